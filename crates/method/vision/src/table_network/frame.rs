//! Input frame of the network: a crop of the image, scaled to fit and centered; the rest repeats its edge pixels
//! (`training/frames.py`).

use glam::DVec2;
use image::imageops::{FilterType, resize};

use imaging::Image;

/// Width and height of frames: for whole images, and for crops. A crop takes the frame that shows it larger.
pub const WHOLE_PX: [usize; 2] = [320, 256];
pub const CLOSER_PX: [[usize; 2]; 2] = [[480, 384], [640, 288]];

/// Maximum scale of a crop, frame pixels per pixel of the image.
const MAX_SCALE: f64 = 1.5;

/// A crop of an image in a frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ImageCrop {
    /// Left, upper, right and lower edge of the crop, pixels of the image.
    part: [u32; 4],
    /// Width and height of the frame.
    pub frame_px: [usize; 2],
    /// Frame pixels per pixel of the image.
    pub scale: f64,
    /// Frame pixels left of and above the crop, and its size in frame pixels.
    pub corner: [usize; 2],
    pub shown: [usize; 2],
}

/// Colors -1..1, channel by channel, each row by row from the top.
pub struct Frame {
    pub rgb: Vec<f32>,
    pub crop: ImageCrop,
}

impl ImageCrop {
    /// The whole image of that size, pixels.
    pub fn whole(image_px: [u32; 2]) -> Self {
        Self::new([0, 0, image_px[0], image_px[1]], WHOLE_PX)
    }

    /// The crop around the box from `low` to `high`, pixels of the image, in the frame that shows it larger, with
    /// as much surroundings as fit.
    pub fn closer(image_px: [u32; 2], low: DVec2, high: DVec2) -> Self {
        let wanted = (high - low).max(DVec2::ONE).to_array();
        let scale_in = |frame: &[usize; 2]| (frame[0] as f64 / wanted[0]).min(frame[1] as f64 / wanted[1]);
        let [first, second] = CLOSER_PX;
        let frame_px = if scale_in(&second) > scale_in(&first) { second } else { first };
        let scale = scale_in(&frame_px).min(MAX_SCALE);
        let [x, y] = [0, 1].map(|k| {
            let highest = f64::from(image_px[k]);
            let length = (frame_px[k] as f64 / scale).round_ties_even().min(highest);
            let center = 0.5 * (low[k] + high[k]);
            let start = (center - 0.5 * length).round_ties_even().max(0.0).min(highest - length);
            [start as u32, (start + length) as u32]
        });
        Self::new([x[0], y[0], x[1], y[1]], frame_px)
    }

    fn new(part: [u32; 4], frame_px: [usize; 2]) -> Self {
        let size = [part[2] - part[0], part[3] - part[1]].map(|side| f64::from(side.max(1)));
        let scale = (0..2).map(|k| frame_px[k] as f64 / size[k]).fold(f64::MAX, f64::min);
        let shown = [0, 1].map(|k| {
            let rounded = (size[k] * scale).round_ties_even() as usize;
            rounded.clamp(1, frame_px[k])
        });
        let corner = [0, 1].map(|k| (frame_px[k] - shown[k]) / 2);
        Self { part, frame_px, scale, corner, shown }
    }

    /// Maps a position from the image to the frame; pixel centers at +0.5 in both.
    pub fn in_frame(&self, p: DVec2) -> DVec2 {
        self.scale * (p - self.upper_left()) + DVec2::new(self.corner[0] as f64, self.corner[1] as f64)
    }

    /// Maps a position from the frame to the image.
    pub fn in_image(&self, p: DVec2) -> DVec2 {
        (p - DVec2::new(self.corner[0] as f64, self.corner[1] as f64)) / self.scale + self.upper_left()
    }

    fn upper_left(&self) -> DVec2 {
        DVec2::new(f64::from(self.part[0]), f64::from(self.part[1]))
    }
}

impl Frame {
    /// The frame of a crop, on white where the image is transparent. When shrinking, each pixel is a tent-weighted
    /// mean of the pixels it covers.
    pub fn of(image: &Image, crop: ImageCrop) -> Self {
        let [left, upper, right, lower] = crop.part;
        let opaque = image::RgbImage::from_fn(right - left, lower - upper, |x, y| {
            let [r, g, b, a] = image.pixel(left + x, upper + y).map(u32::from);
            image::Rgb([r, g, b].map(|c| ((c * a + 255 * (255 - a) + 127) / 255) as u8))
        });
        let [columns, rows] = crop.shown;
        let small = resize(&opaque, columns as u32, rows as u32, FilterType::Triangle);
        let [frame_width, frame_height] = crop.frame_px;
        let within = |at: usize, k: usize| at.saturating_sub(crop.corner[k]).min(crop.shown[k] - 1) as u32;
        let mut rgb = Vec::with_capacity(3 * frame_width * frame_height);
        for channel in 0..3 {
            for y in 0..frame_height {
                let row = within(y, 1);
                rgb.extend(
                    (0..frame_width)
                        .map(|x| f32::from(small.get_pixel(within(x, 0), row)[channel]) / 127.5 - 1.0),
                );
            }
        }
        Self { rgb, crop }
    }

    /// The colors with left and right exchanged.
    pub fn mirrored(&self) -> Vec<f32> {
        let mut rgb = self.rgb.clone();
        rgb.chunks_exact_mut(self.crop.frame_px[0]).for_each(<[f32]>::reverse);
        rgb
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn whole_image_frame_matches_training() {
        let whole = ImageCrop::whole([400, 300]);
        assert_eq!((whole.corner, whole.shown), ([0, 8], [320, 240]));
        let p = DVec2::new(123.0, 45.0);
        assert!((whole.in_image(whole.in_frame(p)) - p).length() < 1e-9);
        assert_eq!(ImageCrop::whole([90, 1000]).shown, [23, 256]);
    }

    #[test]
    fn closer_crop_is_larger_and_inside_image() {
        let image_px = [512, 384];
        for (low, high) in
            [([100.0, 50.0], [400.0, 150.0]), ([0.0, 0.0], [80.0, 300.0]), ([500.0, 370.0], [512.0, 384.0])]
        {
            let (low, high) = (DVec2::from(low), DVec2::from(high));
            let crop = ImageCrop::closer(image_px, low, high);
            assert!(
                crop.scale >= ImageCrop::whole(image_px).scale && crop.scale <= 1.01 * MAX_SCALE,
                "{crop:?}"
            );
            assert!(crop.part[2] <= image_px[0] && crop.part[3] <= image_px[1], "{crop:?}");
            for corner in [low, high] {
                let p = crop.in_frame(corner);
                let [width, height] = crop.frame_px.map(|side| side as f64 + 1.0);
                assert!(p.x > -1.0 && p.y > -1.0 && p.x < width && p.y < height, "{crop:?} {p}");
            }
        }
        let wide = ImageCrop::closer(image_px, DVec2::new(100.0, 50.0), DVec2::new(400.0, 150.0));
        assert_eq!((wide.frame_px, wide.part), (CLOSER_PX[1], [36, 4, 463, 196]));
    }

    #[test]
    fn frame_padding_repeats_edge_and_transparency_is_white() {
        let mut image = Image::filled(40, 40, [0, 0, 0, 255]);
        (0..40).for_each(|y| image.set_pixel(39, y, [9, 9, 9, 0]));
        let frame = Frame::of(&image, ImageCrop::new([0, 0, 40, 40], [64, 32]));
        assert_eq!(frame.crop.corner, [16, 0]);
        let row = &frame.rgb[10 * 64..11 * 64];
        assert!(row[..40].iter().all(|v| *v == -1.0), "{row:?}");
        assert!(row[47] > 0.3 && row[48..].iter().all(|v| *v == row[47]), "{row:?}");
    }
}
