//! Maps that the network predicts for a crop.

use glam::DVec2;

use self::channel::{
    BASE, BORDER, CENTER, FOCAL, GROUND_ROW, KINDS, LATITUDE, OBJECT, OFFSET, OUTLINE, TOP, TOP_ROW,
};
use super::frame::ImageCrop;
use super::{MAP_CHANNELS, RawMaps};

/// Channels of the maps, as in `training/network.py`: two of the classes, the number of classes, then the first
/// channel of each other output.
pub mod channel {
    pub const TOP: usize = 2;
    pub const OBJECT: usize = 3;
    pub const KINDS: usize = 4;
    pub const OUTLINE: usize = 4;
    pub const BORDER: usize = 5;
    pub const CENTER: usize = 7;
    pub const OFFSET: usize = 8;
    pub const BASE: usize = 10;
    pub const TOP_ROW: usize = 12;
    pub const GROUND_ROW: usize = 13;
    pub const LATITUDE: usize = 14;
    pub const FOCAL: usize = 15;
}

/// Map cells per unit of an offset channel.
pub const OFFSET_UNIT: f64 = 8.0;

/// Channels with horizontal offsets, which change sign under mirroring.
const TO_THE_RIGHT: [usize; 2] = [OFFSET, BASE];

impl RawMaps {
    /// The output with left and right exchanged.
    pub(super) fn mirrored(mut self) -> Self {
        for (row, values) in self.maps.chunks_exact_mut(self.width).enumerate() {
            values.reverse();
            if TO_THE_RIGHT.contains(&(row / self.height)) {
                values.iter_mut().for_each(|value| *value = -*value);
            }
        }
        self
    }

    /// The mean of two outputs of one size.
    pub(super) fn mean_with(mut self, other: &Self) -> Self {
        self.maps.iter_mut().zip(&other.maps).for_each(|(a, b)| *a = 0.5 * (*a + b));
        self
    }
}

/// Class of the visible surface at a cell.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PixelClass {
    Backdrop,
    /// The table without its top surface: edge, legs.
    TableFrame,
    /// The bare top.
    Top,
    Object,
}

/// Maps of a crop, at half the frame's size.
pub struct Maps {
    answer: RawMaps,
    crop: ImageCrop,
    /// Frame pixels per map cell.
    stride: f64,
}

impl Maps {
    /// The maps of a crop from the network's output.
    pub fn new(answer: RawMaps, crop: ImageCrop) -> Self {
        debug_assert_eq!(answer.maps.len(), MAP_CHANNELS * answer.width * answer.height);
        let stride = crop.frame_px[0] as f64 / answer.width as f64;
        Self { answer, crop, stride }
    }

    pub fn width(&self) -> usize {
        self.answer.width
    }

    pub fn height(&self) -> usize {
        self.answer.height
    }

    /// Number of map cells.
    pub fn count(&self) -> usize {
        self.width() * self.height()
    }

    /// Elevation in radians, and focal length in longer sides of the image, which may be known: weighted means over the
    /// cells of the table top, each with its own angle below the horizon. For maps of a whole image.
    pub fn camera(&self, known_focal: Option<f64>) -> (f64, f64) {
        let weight = |index: usize| 1.0 / (1.0 + (-self.outline(index)).exp());
        let whole: f64 = (0..self.count()).map(weight).sum();
        let mean = |value: &dyn Fn(usize) -> f64| {
            (0..self.count()).map(|index| weight(index) * value(index)).sum::<f64>() / whole.max(1e-3)
        };
        let predicted = || mean(&|index| f64::from(self.plane(FOCAL)[index])).clamp(-1.5, 3.0).exp();
        let focal = known_focal.unwrap_or_else(predicted);
        let [width_px, height_px] = self.crop.shown;
        let focal_px = focal * width_px.max(height_px) as f64;
        let slant = |index: usize| {
            (self.stride * (self.pixel_center(index).y - 0.5 * self.height() as f64)).atan2(focal_px)
        };
        (mean(&|index| f64::from(self.plane(LATITUDE)[index]) - slant(index)), focal)
    }

    /// Pixels of the image per map cell.
    pub fn pixel_px(&self) -> f64 {
        self.stride / self.crop.scale
    }

    /// Maps a position from the map to the image; pixel centers at +0.5 in both.
    pub fn in_image(&self, p: DVec2) -> DVec2 {
        self.crop.in_image(self.stride * p)
    }

    /// Maps a position from the image to the map.
    pub fn in_map(&self, p: DVec2) -> DVec2 {
        self.crop.in_frame(p) / self.stride
    }

    /// Center of a map cell.
    pub fn pixel_center(&self, index: usize) -> DVec2 {
        DVec2::new((index % self.width()) as f64 + 0.5, (index / self.width()) as f64 + 0.5)
    }

    /// Whether the center of a map cell lies in the crop and not in the frame's padding.
    pub fn shows_image(&self, index: usize) -> bool {
        self.shows(self.pixel_center(index))
    }

    /// Whether a map position lies in the crop.
    pub fn shows(&self, p: DVec2) -> bool {
        let p = self.stride * p;
        let [x, y] = self.crop.corner.map(|c| c as f64);
        let [width, height] = self.crop.shown.map(|s| s as f64);
        p.x > x && p.y > y && p.x < x + width && p.y < y + height
    }

    pub fn class(&self, index: usize) -> PixelClass {
        let value = |kind: usize| self.plane(kind)[index];
        let highest = (1..KINDS).fold(0, |best, kind| if value(kind) > value(best) { kind } else { best });
        [PixelClass::Backdrop, PixelClass::TableFrame, PixelClass::Top, PixelClass::Object][highest]
    }

    /// Object probability, 0..1.
    pub fn object_probability(&self, index: usize) -> f64 {
        let values: [f64; KINDS] = std::array::from_fn(|kind| f64::from(self.plane(kind)[index]));
        let highest = values.iter().copied().fold(f64::MIN, f64::max);
        let sum: f64 = values.iter().map(|v| (v - highest).exp()).sum();
        (values[OBJECT] - highest).exp() / sum
    }

    /// Logit of the whole top's outline, occluded parts included: above 0 inside.
    pub fn outline(&self, index: usize) -> f64 {
        f64::from(self.plane(OUTLINE)[index])
    }

    /// Probability of a border between two objects, 0..1.
    pub fn border_probability(&self, index: usize) -> f64 {
        1.0 / (1.0 + (-f64::from(self.plane(BORDER)[index])).exp())
    }

    /// Center-heatmap value of a cell, about 0..1.
    pub fn center_score(&self, index: usize) -> f32 {
        self.plane(CENTER)[index]
    }

    /// Map position of the object center that a cell votes for.
    pub fn voted_center(&self, index: usize) -> DVec2 {
        let offset = [0, 1].map(|k| OFFSET_UNIT * f64::from(self.plane(OFFSET + k)[index]));
        self.pixel_center(index) + DVec2::from_array(offset)
    }

    /// Map position of the footprint center of a cell's object.
    pub fn base(&self, index: usize) -> DVec2 {
        let offset = [0, 1].map(|k| OFFSET_UNIT * f64::from(self.plane(BASE + k)[index]));
        self.pixel_center(index) + DVec2::from_array(offset)
    }

    /// Row of the map of the point above that center at the height of the object.
    pub fn top_row(&self, index: usize) -> f64 {
        self.pixel_center(index).y + OFFSET_UNIT * f64::from(self.plane(TOP_ROW)[index])
    }

    /// Row of the map of the point of the table below that center.
    pub fn ground_row(&self, index: usize) -> f64 {
        self.pixel_center(index).y + OFFSET_UNIT * f64::from(self.plane(GROUND_ROW)[index])
    }

    /// Margin of the object logit over those of the other classes, interpolated at a map position.
    pub fn object_margin(&self, p: DVec2) -> f64 {
        let values: [f64; KINDS] = std::array::from_fn(|kind| {
            self.around(p).iter().map(|&(index, weight)| weight * f64::from(self.plane(kind)[index])).sum()
        });
        values[OBJECT] - values[..=TOP].iter().copied().fold(f64::MIN, f64::max)
    }

    /// The four map cells around a position, with bilinear weights.
    pub fn around(&self, p: DVec2) -> [(usize, f64); 4] {
        let highest = DVec2::new(self.width() as f64 - 1.0, self.height() as f64 - 1.0);
        let q = (p - 0.5).clamp(DVec2::ZERO, highest);
        let (x, y) = (q.x as usize, q.y as usize);
        let (right, below) = ((x + 1).min(self.width() - 1), (y + 1).min(self.height() - 1));
        let (u, v) = (q.x.fract(), q.y.fract());
        let at = |x: usize, y: usize| y * self.width() + x;
        [
            (at(x, y), (1.0 - u) * (1.0 - v)),
            (at(right, y), u * (1.0 - v)),
            (at(x, below), (1.0 - u) * v),
            (at(right, below), u * v),
        ]
    }

    fn plane(&self, channel: usize) -> &[f32] {
        &self.answer.maps[channel * self.count()..][..self.count()]
    }
}
