//! Heights of objects above the plane of the table top.

use super::{DepthCopy, TopPlane};
use crate::morphology;

/// Rim of a mask that may show two surfaces, pixels.
const RIM_PX: f32 = 1.6;
/// Half the side of the neighborhood whose median is a height, pixels.
const REACH_PX: usize = 2;
/// Shares of the sorted heights at which an object begins and ends.
const BOTTOM_SHARE: f64 = 0.03;
const TOP_SHARE: f64 = 0.985;
/// Distance from the median along the optical axis within which pixels belong to the object: a constant, meters, and a
/// multiple of the median absolute deviation.
const MAX_APART_M: f64 = 0.03;
const MAX_DEVIATIONS: f64 = 5.0;
/// Minimum number and share of an object's pixels with a depth.
const MIN_MEASURED: usize = 12;
const MIN_MEASURED_SHARE: f64 = 0.15;

/// Lowest and highest visible surface of an object, in heights of the camera above the table.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct HeightRange {
    pub bottom: f64,
    pub top: f64,
    /// Standard deviation of either, by the noise of the top.
    pub sigma: f64,
}

impl HeightRange {
    /// Of the object with those pixels; `None` if too few have a depth.
    pub fn of(depth: &DepthCopy, plane: &TopPlane, mask: &[bool]) -> Option<Self> {
        let (width, height) = (depth.width, depth.height);
        let inner = morphology::erode(mask, width, height, RIM_PX);
        let count = |bits: &[bool]| bits.iter().filter(|bit| **bit).count();
        // Erosion would delete thin objects.
        let bits = if 3 * count(&inner) > count(mask) { &inner } else { mask };
        let own: Vec<usize> = (0..depth.len()).filter(|&index| bits[index]).collect();
        let depths_m: Vec<f64> = own.iter().filter_map(|&index| depth.depth_m(index)).collect();
        if depths_m.len() < MIN_MEASURED || (depths_m.len() as f64) < MIN_MEASURED_SHARE * own.len() as f64 {
            return None;
        }
        let median_m = median(depths_m.clone());
        let deviation_m = median(depths_m.iter().map(|depth_m| (depth_m - median_m).abs()).collect());
        let max_apart_m = MAX_APART_M + MAX_DEVIATIONS * deviation_m;
        let mut heights_m = vec![None; depth.len()];
        for &index in &own {
            let point_m = depth.point_m(index).filter(|point_m| (point_m.z - median_m).abs() < max_apart_m);
            heights_m[index] = point_m.map(|point_m| plane.height_m(point_m));
        }
        let mut smooth_m: Vec<f64> =
            own.iter().filter_map(|&index| median_around(&heights_m, width, height, index)).collect();
        smooth_m.sort_by(f64::total_cmp);
        let at =
            |share: f64| smooth_m.get((share * smooth_m.len().saturating_sub(1) as f64).round() as usize);
        let unit_m = plane.camera_height_m();
        Some(Self {
            bottom: at(BOTTOM_SHARE)? / unit_m,
            top: at(TOP_SHARE)? / unit_m,
            sigma: plane.rms_m / unit_m,
        })
    }
}

/// Median height around a pixel with a height.
fn median_around(heights_m: &[Option<f64>], width: usize, height: usize, index: usize) -> Option<f64> {
    heights_m[index]?;
    let (x, y) = (index % width, index / width);
    let rows = y.saturating_sub(REACH_PX)..(y + REACH_PX + 1).min(height);
    let columns = x.saturating_sub(REACH_PX)..(x + REACH_PX + 1).min(width);
    let around = rows.flat_map(|v| columns.clone().filter_map(move |u| heights_m[v * width + u]));
    Some(median(around.collect()))
}

/// Median of values, of which there is at least one.
fn median(mut values: Vec<f64>) -> f64 {
    let center = values.len() / 2;
    *values.select_nth_unstable_by(center, f64::total_cmp).1
}
