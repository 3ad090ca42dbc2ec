//! A strip of an episode: a few of its frames of one camera, side by side, for people who choose a dataset.

use image::RgbImage;
use image::imageops::{replace, thumbnail};
use imaging::Image;

use crate::pixels::{rgb_of, rgb_png};

/// Frames in a strip; fewer of an episode that has fewer.
pub const STRIP_FRAMES: usize = 8;
/// Width of a frame in a strip; smaller images keep their size.
const FRAME_WIDTH_PX: u32 = 128;

/// Episodes in a folder of strips.
pub(crate) const CHUNK: u64 = 1000;

/// Path of an episode's strip in the folder of a format.
pub(crate) fn strip_path(episode_index: u64, camera: &str) -> String {
    format!("strips/chunk-{:03}/episode_{episode_index:06}_{camera}.png", episode_index / CHUNK)
}

/// Keeps frames that are spread evenly over an episode, without knowing how long it will be.
pub(crate) struct StripFrames {
    /// Every so many frames one is kept, from the first on.
    stride: usize,
    seen: usize,
    kept: Vec<RgbImage>,
}

impl Default for StripFrames {
    fn default() -> Self {
        Self { stride: 1, seen: 0, kept: Vec::new() }
    }
}

impl StripFrames {
    /// Adds the next frame. At most twice the frames of a strip are held.
    pub fn add(&mut self, image: &Image) {
        if self.seen.is_multiple_of(self.stride) {
            if self.kept.len() == 2 * STRIP_FRAMES {
                let mut place = 0..;
                self.kept.retain(|_| place.next().is_some_and(|place: usize| place.is_multiple_of(2)));
                self.stride *= 2;
            }
            // After the stride has grown, the frame is still one of those that are kept.
            if self.seen.is_multiple_of(self.stride) {
                self.kept.push(thumbnail_of(image));
            }
        }
        self.seen += 1;
    }

    /// The strip as a PNG file; `None` without frames.
    pub fn finish(self) -> Option<Vec<u8>> {
        let (width_px, height_px) = self.kept.first()?.dimensions();
        let count = self.kept.len().min(STRIP_FRAMES);
        let mut strip = RgbImage::new(width_px * count as u32, height_px);
        for column in 0..count {
            let chosen = column * (self.kept.len() - 1) / (count - 1).max(1);
            replace(&mut strip, &self.kept[chosen], i64::from(width_px) * column as i64, 0);
        }
        Some(rgb_png(strip.as_raw(), strip.width(), strip.height()))
    }
}

/// The size of an image of this size in strips and previews, pixels.
pub(crate) fn small_size_px(width_px: u32, height_px: u32) -> (u32, u32) {
    if width_px <= FRAME_WIDTH_PX {
        return (width_px, height_px);
    }
    (FRAME_WIDTH_PX, (height_px * FRAME_WIDTH_PX / width_px).max(1))
}

/// The image in that size.
pub(crate) fn thumbnail_of(image: &Image) -> RgbImage {
    let (width_px, height_px) = (image.width_px(), image.height_px());
    let full = RgbImage::from_raw(width_px, height_px, rgb_of(image)).expect("as many bytes as pixels need");
    match small_size_px(width_px, height_px) {
        size_px if size_px == (width_px, height_px) => full,
        (width_px, height_px) => thumbnail(&full, width_px, height_px),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The gray values of the frames in the strip of an episode whose frame t has the gray value t.
    fn strip_of(frames: u8, width_px: u32) -> Vec<u8> {
        let mut strip = StripFrames::default();
        for gray in 0..frames {
            let rgba = [gray, gray, gray, 255].repeat((width_px * 4) as usize);
            strip.add(&Image::from_rgba(width_px, 4, rgba).expect("an image"));
            assert!(strip.kept.len() <= 2 * STRIP_FRAMES);
        }
        let strip = strip.finish().expect("a strip");
        let image = image::load_from_memory(&strip).expect("PNG").into_rgb8();
        let width_px = width_px.min(FRAME_WIDTH_PX);
        (0..image.width() / width_px).map(|column| image.get_pixel(column * width_px, 0)[0]).collect()
    }

    #[test]
    fn strips_have_frames_from_begin_to_end() {
        assert_eq!(strip_of(1, 6), [0]);
        assert_eq!(strip_of(3, 6), [0, 1, 2]);
        assert_eq!(strip_of(8, 6), [0, 1, 2, 3, 4, 5, 6, 7]);
        assert_eq!(strip_of(15, 6), [0, 2, 4, 6, 8, 10, 12, 14]);
        for frames in [17, 50, 115, 200, 255] {
            let strip = strip_of(frames, 256);
            assert_eq!((strip.len(), strip[0]), (STRIP_FRAMES, 0));
            // The last frame that is kept is at most a stride before the end.
            assert!(strip[7] >= frames - 1 - frames / 8, "{strip:?} of {frames}");
            assert!(strip.is_sorted());
        }
        assert_eq!(StripFrames::default().finish(), None);
    }
}
