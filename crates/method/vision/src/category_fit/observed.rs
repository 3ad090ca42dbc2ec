//! Observation of one object: a small grid with its mask, its occluders and its colors.

use glam::{DVec2, DVec3};

use super::outline_raster::Grid;
use super::views::{Bits, SIDE};
use crate::PosedPrimitive;
use crate::pixels::lab_of;
use geometry::Camera;
use imaging::srgb::LINEAR_OF_SRGB;
use imaging::{Image, Mask};

/// Cells along the longer side of the compared box.
const CELLS: f64 = 34.0;
/// Margin around it on each side, as a share.
const MARGIN: f64 = 0.22;
/// Samples a cell along each side.
const SAMPLES: usize = 3;

/// Observation of one object.
pub(super) struct Observation {
    pub grid: Grid,
    /// Share of each cell inside the mask, and share in which occluders hide the object.
    pub cover: Vec<f32>,
    pub hidden: Vec<f32>,
    /// Mean color of the mask's part of each cell, CIELAB.
    pub lab: Vec<[f32; 3]>,
    pub area: f32,
    /// Box of the object with its probably occluded part: pixels.
    pub low_px: DVec2,
    pub high_px: DVec2,
    /// Share of the cells around its outline that may be occluded.
    pub hidden_rim: f64,
    /// The box as a square of bits.
    pub bits: Bits,
    pub hidden_bits: Bits,
}

/// The image with the masks of its objects, farthest first.
#[derive(Clone, Copy)]
pub(super) struct MaskedImage<'a> {
    pub image: &'a Image,
    pub camera: &'a Camera,
    pub masks: &'a [&'a Mask],
}

impl Observation {
    /// The object of that index; `None` if nothing of it is visible.
    pub fn new(masked: &MaskedImage, index: usize, solid: &PosedPrimitive) -> Option<Self> {
        let mask = masked.masks[index];
        let [x0, y0, x1, y1] = mask.bbox_px()?.map(f64::from);
        let in_front = &masked.masks[index + 1..];
        let frame = DVec2::new(f64::from(mask.width_px()), f64::from(mask.height_px()));
        let is_hidden = |p: DVec2| {
            p.cmplt(DVec2::ZERO).any()
                || p.cmpge(frame).any()
                || in_front.iter().any(|other| other.contains(p.x as u32, p.y as u32))
        };
        let is_own = |p: DVec2| p.cmpge(DVec2::ZERO).all() && mask.contains(p.x as u32, p.y as u32);
        let (low_px, high_px) =
            with_hidden(DVec2::new(x0, y0), DVec2::new(x1, y1), solid, masked.camera, &is_hidden);
        let extent = high_px - low_px;
        let cell_px = (extent.max_element() / CELLS).max(1.0);
        let margin = (MARGIN * extent).max(DVec2::splat(2.0 * cell_px));
        let origin_px = low_px - margin;
        let count = ((extent + 2.0 * margin) / cell_px).ceil();
        let grid = Grid { origin_px, cell_px, columns: count.x as usize, rows: count.y as usize };
        let mut own = Self {
            grid,
            cover: vec![0.0; grid.cells()],
            hidden: vec![0.0; grid.cells()],
            lab: vec![[0.0; 3]; grid.cells()],
            area: 0.0,
            low_px,
            high_px,
            hidden_rim: 0.0,
            bits: [0; SIDE],
            hidden_bits: [0; SIDE],
        };
        let share = 1.0 / (SAMPLES * SAMPLES) as f32;
        for cell in 0..grid.cells() {
            let corner = DVec2::new((cell % grid.columns) as f64, (cell / grid.columns) as f64);
            let (mut light, mut set) = ([0.0_f32; 3], 0);
            for sample in 0..SAMPLES * SAMPLES {
                let inner = DVec2::new((sample % SAMPLES) as f64 + 0.5, (sample / SAMPLES) as f64 + 0.5);
                let p = origin_px + cell_px * (corner + inner / SAMPLES as f64);
                if is_own(p) {
                    let color = masked.image.pixel(p.x as u32, p.y as u32);
                    (0..3).for_each(|k| light[k] += LINEAR_OF_SRGB[usize::from(color[k])]);
                    set += 1;
                } else if is_hidden(p) {
                    own.hidden[cell] += share;
                }
            }
            own.cover[cell] = share * set as f32;
            if set > 0 {
                own.lab[cell] = lab_of(light.map(|sum| sum / set as f32));
            }
        }
        own.area = own.cover.iter().sum();
        own.hidden_rim = own.hidden_rim();
        for cell in 0..SIDE * SIDE {
            let inner = DVec2::new((cell % SIDE) as f64 + 0.5, (cell / SIDE) as f64 + 0.5) / SIDE as f64;
            let p = low_px + inner * extent;
            let bit = 1 << (cell % SIDE);
            if is_own(p) {
                own.bits[cell / SIDE] |= bit;
            } else if is_hidden(p) {
                own.hidden_bits[cell / SIDE] |= bit;
            }
        }
        (own.area > 0.0).then_some(own)
    }

    /// Intersection over union with the cells covered in `front`; occluded cells have a small weight.
    pub fn overlap(&self, front: &[u32]) -> f64 {
        let (mut both, mut own) = (0.0_f32, 0.0_f32);
        for ((front, cover), hidden) in front.iter().zip(&self.cover).zip(&self.hidden) {
            if *front != super::outline_raster::NOTHING {
                both += cover;
                own += 1.0 - (1.0 - OCCLUDED_WEIGHT) * hidden;
            }
        }
        f64::from(both) / f64::from(own + self.area - both).max(1e-9)
    }

    fn hidden_rim(&self) -> f64 {
        let (columns, rows) = (self.grid.columns, self.grid.rows);
        let (mut rim, mut hidden) = (0.0, 0.0);
        for y in 1..rows.saturating_sub(1) {
            for x in 1..columns.saturating_sub(1) {
                let at = y * columns + x;
                let beside = [at - 1, at + 1, at - columns, at + columns];
                if self.cover[at] < 0.5 && beside.iter().any(|cell| self.cover[*cell] >= 0.5) {
                    rim += 1.0;
                    hidden += f64::from(self.hidden[at]).min(1.0);
                }
            }
        }
        hidden / f64::max(rim, 1.0)
    }
}

/// Weight of an occluded cell.
const OCCLUDED_WEIGHT: f32 = 0.1;

/// The box of the visible part, grown to that of the primitive where the strip between them is mostly occluded.
fn with_hidden(
    low: DVec2,
    high: DVec2,
    solid: &PosedPrimitive,
    camera: &Camera,
    is_hidden: &impl Fn(DVec2) -> bool,
) -> (DVec2, DVec2) {
    let corners = solid.footprint();
    let ends = corners.iter().flat_map(|p| [p.extend(0.0), p.extend(solid.size.z)]);
    let pixels: Option<Vec<DVec2>> = ends.map(|p: DVec3| camera.project(p).map(|(pixel, _)| pixel)).collect();
    let Some(pixels) = pixels.filter(|pixels| !pixels.is_empty()) else { return (low, high) };
    let solid_low = pixels.iter().fold(DVec2::INFINITY, |low, p| low.min(*p));
    let solid_high = pixels.iter().fold(DVec2::NEG_INFINITY, |high, p| high.max(*p));
    let extent = high - low;
    let mostly_hidden = |from: DVec2, to: DVec2| {
        let inner = |k: usize| DVec2::new((k % 5) as f64 + 0.5, (k / 5) as f64 + 0.5) / 5.0;
        let hidden = (0..25).filter(|k| is_hidden(from + inner(*k) * (to - from))).count();
        hidden >= 13
    };
    let (mut grown_low, mut grown_high) = (low, high);
    for axis in 0..2 {
        let limit = 0.6 * extent[axis];
        let (mut from, mut to) = (low, high);
        let target = solid_low[axis].max(low[axis] - limit);
        (from[axis], to[axis]) = (target, low[axis]);
        if target < low[axis] - 1.0 && mostly_hidden(from, to) {
            grown_low[axis] = target;
        }
        let (mut from, mut to) = (low, high);
        let target = solid_high[axis].min(high[axis] + limit);
        (from[axis], to[axis]) = (high[axis], target);
        if target > high[axis] + 1.0 && mostly_hidden(from, to) {
            grown_high[axis] = target;
        }
    }
    (grown_low, grown_high)
}
