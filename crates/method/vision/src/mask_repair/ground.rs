//! Local model of the ground's color.

use glam::Vec3;

use super::EROSION_PX;
use imaging::distance_transform::distance_transform;

/// Half sides of the windows; the first one with enough ground is used.
const AROUND_PX: [usize; 3] = [14, 32, 72];

/// Minimum number of ground pixels of an estimate.
const MIN_GROUND_PX: f32 = 30.0;

/// Range of ground shades: the darkest shadow, and the brightest light. Brass on light wood has the wood's hue at
/// a third of its light, and must not count as its shadow.
const SHADES: [f32; 2] = [0.45, 1.15];

/// Mean colors of the pixels away from all masks.
pub(super) struct Ground {
    width: usize,
    height: usize,
    /// Summed-area table: red, green, blue, count; one row and one column more than pixels.
    sums: Vec<[f64; 4]>,
}

impl Ground {
    /// From the pixels farther than the erosion depth from claimed ones.
    pub(super) fn new(colors: &[Vec3], claimed: &[bool], width: usize, height: usize) -> Self {
        let from_masks_px = distance_transform(claimed, width, height);
        let mut sums = vec![[0.0; 4]; (width + 1) * (height + 1)];
        for y in 0..height {
            let mut row = [0.0; 4];
            for x in 0..width {
                let at = y * width + x;
                if from_masks_px[at] > EROSION_PX {
                    let c = colors[at];
                    let own = [c.x, c.y, c.z, 1.0].map(f64::from);
                    (0..4).for_each(|k| row[k] += own[k]);
                }
                let above = sums[y * (width + 1) + x + 1];
                sums[(y + 1) * (width + 1) + x + 1] = std::array::from_fn(|k| above[k] + row[k]);
            }
        }
        Self { width, height, sums }
    }

    /// The shade of the surrounding ground nearest to a color, over the four quadrants with enough ground; `None`
    /// without one.
    pub(super) fn nearest(&self, x: usize, y: usize, color: Vec3) -> Option<Vec3> {
        let shade = |mean: Vec3| {
            let share = color.dot(mean) / mean.length_squared().max(1.0);
            mean * share.clamp(SHADES[0], SHADES[1])
        };
        AROUND_PX.into_iter().find_map(|reach| {
            let (x0, x1) = (x.saturating_sub(reach), (x + reach + 1).min(self.width));
            let (y0, y1) = (y.saturating_sub(reach), (y + reach + 1).min(self.height));
            let quarters = [[x0, y0, x + 1, y + 1], [x, y0, x1, y + 1], [x0, y, x + 1, y1], [x, y, x1, y1]];
            let shades = quarters.into_iter().filter_map(|part| self.mean(part)).map(shade);
            shades.min_by(|a, b| color.distance_squared(*a).total_cmp(&color.distance_squared(*b)))
        })
    }

    /// Mean color of the ground in the pixels from x0, y0 to before x1, y1.
    fn mean(&self, [x0, y0, x1, y1]: [usize; 4]) -> Option<Vec3> {
        let at = |x: usize, y: usize| self.sums[y * (self.width + 1) + x];
        let [a, b, c, d] = [at(x0, y0), at(x1, y0), at(x0, y1), at(x1, y1)];
        let [red, green, blue, count] = std::array::from_fn(|k| (d[k] - b[k] - c[k] + a[k]) as f32);
        (count >= MIN_GROUND_PX).then(|| Vec3::new(red, green, blue) / count)
    }
}
