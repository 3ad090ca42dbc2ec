//! What a network says of a picture, place by place.

use glam::DVec2;

use self::channel::{
    BASE, BORDER, CENTER, FOCAL, GROUND_ROW, KINDS, LATITUDE, OBJECT, OFFSET, OUTLINE, TOP, TOP_ROW,
};
use super::frame::Look;
use super::{Answer, MAP_CHANNELS};

/// Channels of the maps, as `training/network.py` has them: those of two kinds, the number of kinds, then the first of each
/// other answer.
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

/// Offsets are counted in this many map pixels.
pub const OFFSET_UNIT: f64 = 8.0;

/// Channels that count map pixels to the right, which turn their sign where left and right are exchanged.
const TO_THE_RIGHT: [usize; 2] = [OFFSET, BASE];

impl Answer {
    /// The answer with left and right exchanged.
    pub(super) fn mirrored(mut self) -> Self {
        for (row, values) in self.maps.chunks_exact_mut(self.width).enumerate() {
            values.reverse();
            if TO_THE_RIGHT.contains(&(row / self.height)) {
                values.iter_mut().for_each(|value| *value = -*value);
            }
        }
        self
    }

    /// The mean of two answers to frames of one size.
    pub(super) fn mean_with(mut self, other: &Self) -> Self {
        self.maps.iter_mut().zip(&other.maps).for_each(|(a, b)| *a = 0.5 * (*a + b));
        self
    }
}

/// What is in front at a place.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    Backdrop,
    /// The table but for its top surface: edge, legs.
    TableFrame,
    /// The bare top.
    Top,
    Object,
}

/// Maps of what was looked at, each at half the frame's size.
pub struct Maps {
    answer: Answer,
    look: Look,
    /// Frame pixels a map pixel.
    stride: f64,
}

impl Maps {
    /// The answer to the frame of that look.
    pub fn new(answer: Answer, look: Look) -> Self {
        debug_assert_eq!(answer.maps.len(), MAP_CHANNELS * answer.width * answer.height);
        let stride = look.frame_px[0] as f64 / answer.width as f64;
        Self { answer, look, stride }
    }

    pub fn width(&self) -> usize {
        self.answer.width
    }

    pub fn height(&self) -> usize {
        self.answer.height
    }

    /// Of map pixels.
    pub fn count(&self) -> usize {
        self.width() * self.height()
    }

    /// Elevation in radians, and the focal length in longer sides of the picture: what the places of the table top say in
    /// the mean, each of how far below the horizon it is seen. Of a look at a whole picture.
    pub fn camera(&self) -> (f64, f64) {
        let weight = |index: usize| 1.0 / (1.0 + (-self.outline(index)).exp());
        let whole: f64 = (0..self.count()).map(weight).sum();
        let mean = |value: &dyn Fn(usize) -> f64| {
            (0..self.count()).map(|index| weight(index) * value(index)).sum::<f64>() / whole.max(1e-3)
        };
        let focal = mean(&|index| f64::from(self.plane(FOCAL)[index])).clamp(-1.5, 3.0).exp();
        let [width_px, height_px] = self.look.shown;
        let focal_px = focal * width_px.max(height_px) as f64;
        let slant = |index: usize| {
            (self.stride * (self.middle(index).y - 0.5 * self.height() as f64)).atan2(focal_px)
        };
        (mean(&|index| f64::from(self.plane(LATITUDE)[index]) - slant(index)), focal)
    }

    /// Pixels of the picture a map pixel.
    pub fn pixel_px(&self) -> f64 {
        self.stride / self.look.scale
    }

    /// Position in the picture of a map position; pixel centers at +0.5 in both.
    pub fn in_picture(&self, p: DVec2) -> DVec2 {
        self.look.in_picture(self.stride * p)
    }

    /// Map position of a position in the picture.
    pub fn in_map(&self, p: DVec2) -> DVec2 {
        self.look.in_frame(p) / self.stride
    }

    /// Middle of a map pixel.
    pub fn middle(&self, index: usize) -> DVec2 {
        DVec2::new((index % self.width()) as f64 + 0.5, (index / self.width()) as f64 + 0.5)
    }

    /// Whether a map pixel's middle shows what was looked at and not the frame's filling.
    pub fn shows_picture(&self, index: usize) -> bool {
        self.shows(self.middle(index))
    }

    /// Whether a map position does.
    pub fn shows(&self, p: DVec2) -> bool {
        let p = self.stride * p;
        let [x, y] = self.look.corner.map(|c| c as f64);
        let [width, height] = self.look.shown.map(|s| s as f64);
        p.x > x && p.y > y && p.x < x + width && p.y < y + height
    }

    pub fn kind(&self, index: usize) -> Kind {
        let value = |kind: usize| self.plane(kind)[index];
        let most = (1..KINDS).fold(0, |best, kind| if value(kind) > value(best) { kind } else { best });
        [Kind::Backdrop, Kind::TableFrame, Kind::Top, Kind::Object][most]
    }

    /// Probability of an object, 0..1.
    pub fn object_probability(&self, index: usize) -> f64 {
        let values: [f64; KINDS] = std::array::from_fn(|kind| f64::from(self.plane(kind)[index]));
        let most = values.iter().copied().fold(f64::MIN, f64::max);
        let sum: f64 = values.iter().map(|v| (v - most).exp()).sum();
        (values[OBJECT] - most).exp() / sum
    }

    /// Logit of the whole top's outline, hidden parts included: above 0 inside.
    pub fn outline(&self, index: usize) -> f64 {
        f64::from(self.plane(OUTLINE)[index])
    }

    /// Probability of a border between two objects, 0..1.
    pub fn border_probability(&self, index: usize) -> f64 {
        1.0 / (1.0 + (-f64::from(self.plane(BORDER)[index])).exp())
    }

    /// How much a map pixel is the middle of an object, about 0..1.
    pub fn center(&self, index: usize) -> f32 {
        self.plane(CENTER)[index]
    }

    /// Map position of the middle of the object that a map pixel belongs to.
    pub fn votes_for(&self, index: usize) -> DVec2 {
        let offset = [0, 1].map(|k| OFFSET_UNIT * f64::from(self.plane(OFFSET + k)[index]));
        self.middle(index) + DVec2::from_array(offset)
    }

    /// Map position of the middle of the footprint of the object that a map pixel belongs to.
    pub fn base(&self, index: usize) -> DVec2 {
        let offset = [0, 1].map(|k| OFFSET_UNIT * f64::from(self.plane(BASE + k)[index]));
        self.middle(index) + DVec2::from_array(offset)
    }

    /// Row of the map in which the point above that middle lies at the height of the object.
    pub fn top_row(&self, index: usize) -> f64 {
        self.middle(index).y + OFFSET_UNIT * f64::from(self.plane(TOP_ROW)[index])
    }

    /// Row of the map in which the point of the table below that middle lies.
    pub fn ground_row(&self, index: usize) -> f64 {
        self.middle(index).y + OFFSET_UNIT * f64::from(self.plane(GROUND_ROW)[index])
    }

    /// How far an object's logit lies above every other kind's, interpolated at a map position.
    pub fn object_margin(&self, p: DVec2) -> f64 {
        let values: [f64; KINDS] = std::array::from_fn(|kind| {
            self.around(p).iter().map(|&(index, weight)| weight * f64::from(self.plane(kind)[index])).sum()
        });
        values[OBJECT] - values[..=TOP].iter().copied().fold(f64::MIN, f64::max)
    }

    /// The four map pixels around a position, with bilinear weights.
    pub fn around(&self, p: DVec2) -> [(usize, f64); 4] {
        let most = DVec2::new(self.width() as f64 - 1.0, self.height() as f64 - 1.0);
        let q = (p - 0.5).clamp(DVec2::ZERO, most);
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
