//! The frame a network sees: the picture shrunk or enlarged until it fits, in the middle, the rest filled with the
//! picture's edge pixels (`training/frames.py`).

use glam::DVec2;
use image::imageops::{FilterType, resize};

use crate::geometry::Image;

/// Where a picture lies in a frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Placement {
    /// Frame pixels a pixel of the picture.
    pub scale: f64,
    /// Frame pixels left of and above the picture, and how many show it.
    pub corner: [usize; 2],
    pub shown: [usize; 2],
}

/// Colors -1..1, channel by channel, each row by row from the top.
pub struct Frame {
    pub rgb: Vec<f32>,
    pub placement: Placement,
}

impl Placement {
    /// Of a picture of that size in a frame of that size, pixels.
    pub fn of(picture_px: [u32; 2], frame_px: [usize; 2]) -> Self {
        let scale =
            (0..2).map(|k| frame_px[k] as f64 / f64::from(picture_px[k].max(1))).fold(f64::MAX, f64::min);
        let shown = [0, 1].map(|k| {
            let rounded = (f64::from(picture_px[k]) * scale).round_ties_even() as usize;
            rounded.clamp(1, frame_px[k])
        });
        Self { scale, corner: [0, 1].map(|k| (frame_px[k] - shown[k]) / 2), shown }
    }

    /// Frame position of a position in the picture; pixel centers at +0.5 in both.
    pub fn in_frame(&self, p: DVec2) -> DVec2 {
        self.scale * p + DVec2::new(self.corner[0] as f64, self.corner[1] as f64)
    }

    /// Position in the picture of a position in the frame.
    pub fn in_picture(&self, p: DVec2) -> DVec2 {
        (p - DVec2::new(self.corner[0] as f64, self.corner[1] as f64)) / self.scale
    }
}

impl Frame {
    /// Of a picture, on white where it is transparent. Shrinking, each pixel is a tent-weighted mean of all it covers.
    pub fn of(picture: &Image, frame_px: [usize; 2]) -> Self {
        let (width, height) = (picture.width_px(), picture.height_px());
        let placement = Placement::of([width, height], frame_px);
        let opaque = image::RgbImage::from_fn(width, height, |x, y| {
            let [r, g, b, a] = picture.pixel(x, y).map(u32::from);
            image::Rgb([r, g, b].map(|c| ((c * a + 255 * (255 - a) + 127) / 255) as u8))
        });
        let [columns, rows] = placement.shown;
        let small = resize(&opaque, columns as u32, rows as u32, FilterType::Triangle);
        let [frame_width, frame_height] = frame_px;
        let within =
            |at: usize, k: usize| at.saturating_sub(placement.corner[k]).min(placement.shown[k] - 1) as u32;
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
        Self { rgb, placement }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_are_those_of_the_training() {
        let placement = Placement::of([400, 300], [320, 256]);
        assert_eq!((placement.corner, placement.shown), ([0, 8], [320, 240]));
        let p = DVec2::new(123.0, 45.0);
        assert!((placement.in_picture(placement.in_frame(p)) - p).length() < 1e-9);
        assert_eq!(Placement::of([90, 1000], [320, 256]).shown, [23, 256]);
    }

    #[test]
    fn the_rest_of_a_frame_repeats_the_edge_and_transparency_is_white() {
        let mut picture = Image::filled(40, 40, [0, 0, 0, 255]);
        (0..40).for_each(|y| picture.set_pixel(39, y, [9, 9, 9, 0]));
        let frame = Frame::of(&picture, [64, 32]);
        assert_eq!(frame.placement.corner, [16, 0]);
        let row = &frame.rgb[10 * 64..11 * 64];
        assert!(row[..40].iter().all(|v| *v == -1.0), "{row:?}");
        assert!(row[47] > 0.3 && row[48..].iter().all(|v| *v == row[47]), "{row:?}");
    }
}
