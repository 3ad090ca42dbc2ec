//! Quadrilaterals and ellipses fitted to the table-top probability.
//!
//! Corners of a hull lie at the outermost errors of an outline, and a single spike moves them. This fit uses every
//! map cell: it minimizes the difference between the soft inside of the shape and the probabilities, first with an
//! edge some cells wide, then with a sharp one.
//!
//! On rectangular tops of validation images the corner error is half of that of the hull. The error of a quarter
//! of them no longer exceeds three cells.

use glam::DVec2;

use super::ellipse::Ellipse;
use crate::pixels::Pixels;
use crate::polygon::{area, contains};
use crate::table_network::maps::Maps;
use geometry::optimize::least_squares;

/// Rounds of a fit: width of the soft edge in cells, and the sampling stride in cells.
const ROUNDS: [(f64, usize); 3] = [(3.0, 3), (1.2, 2), (0.6, 1)];
/// Cells deeper inside or farther outside than this many edge widths are ignored.
const REACH: f64 = 10.0;
/// Factor on the logits: the network is unsure in a band along the edge.
const SHARPNESS: f64 = 2.0;
/// Step of the numerical derivative, pixels.
const STEP_PX: f64 = 0.02;

/// Top probability per map cell; positions and lengths in pixels of the working copy.
pub(super) struct TopRegion {
    cells: Vec<CellSample>,
    /// Distance of adjacent cells.
    spacing_px: f64,
}

struct CellSample {
    at: DVec2,
    column: usize,
    row: usize,
    probability: f64,
}

impl TopRegion {
    /// `inside` holds the pixels of the copy within the top; separate components do not belong to it. `shows_plane` are
    /// those that are known to show the plane of the top, or not to.
    pub(super) fn new(maps: &Maps, pixels: &Pixels, inside: &[usize], shows_plane: &[Option<bool>]) -> Self {
        let mut taken = vec![false; pixels.len()];
        inside.iter().for_each(|&index| taken[index] = true);
        let cells = (0..maps.count()).filter(|&index| maps.shows_image(index)).map(|index| {
            let at = pixels.scale * maps.in_image(maps.pixel_center(index));
            let logit = maps.outline(index);
            let pixel = pixels.index_at(at);
            let is_taken = pixel.is_some_and(|pixel| taken[pixel]);
            let is_measured = pixel.is_some_and(|pixel| shows_plane[pixel] == Some(is_taken));
            let probability = match (is_taken, logit > 0.0) {
                _ if is_measured => f64::from(u8::from(is_taken)),
                (true, _) => sigmoid(SHARPNESS * logit.max(0.0)),
                (false, true) => 0.0,
                (false, false) => sigmoid(SHARPNESS * logit),
            };
            CellSample { at, column: index % maps.width(), row: index / maps.width(), probability }
        });
        Self { cells: cells.collect(), spacing_px: maps.pixel_px() * pixels.scale }
    }

    /// The best-fitting convex quadrilateral near `start`; corners in the order of growing angle (y down).
    pub(super) fn quadrilateral(&self, start: &[DVec2; 4]) -> Option<[DVec2; 4]> {
        let corners =
            |q: &[f64; 8]| -> [DVec2; 4] { std::array::from_fn(|k| DVec2::new(q[2 * k], q[2 * k + 1])) };
        let first = std::array::from_fn(|k| start[k / 2][k % 2]);
        let found = self.fit(first, |q, p| {
            let c = corners(q);
            (0..4)
                .map(|k| {
                    let side = c[(k + 1) % 4] - c[k];
                    side.perp_dot(p - c[k]) / side.length().max(1e-9)
                })
                .fold(f64::INFINITY, f64::min)
        })?;
        Some(corners(&found)).filter(|c| area(c) > 0.0 && c.iter().all(|p| p.is_finite()))
    }

    /// The best-fitting ellipse near `start`.
    pub(super) fn ellipse(&self, start: &Ellipse) -> Option<Ellipse> {
        let of = |q: &[f64; 5]| Ellipse {
            center: DVec2::new(q[0], q[1]),
            semi_axes: DVec2::new(q[2], q[3]),
            // Unit of rotation: a pixel at the end of the longer axis.
            angle_rad: q[4] / start.semi_axes.x,
        };
        let first = [
            start.center.x,
            start.center.y,
            start.semi_axes.x,
            start.semi_axes.y,
            start.angle_rad * start.semi_axes.x,
        ];
        let found = of(&self.fit(first, |q, p| of(q).depth_px(p))?);
        (found.semi_axes.min_element() > 0.0 && found.center.is_finite()).then_some(found)
    }

    /// Intersection over union of a convex polygon (in the order of growing angle) with the cells inside the top.
    pub(super) fn overlap(&self, polygon: &[DVec2]) -> f64 {
        let (mut both, mut either) = (0_usize, 0_usize);
        for cell in &self.cells {
            let (seen, drawn) = (cell.probability >= 0.5, contains(polygon, cell.at));
            both += usize::from(seen && drawn);
            either += usize::from(seen || drawn);
        }
        both as f64 / either.max(1) as f64
    }

    /// Best parameters of a shape. `depth_px` is the depth of a point inside the shape, negative outside.
    fn fit<const N: usize>(
        &self,
        start: [f64; N],
        depth_px: impl Fn(&[f64; N], DVec2) -> f64,
    ) -> Option<[f64; N]> {
        let mut at = start;
        for (softness, every) in ROUNDS {
            let softness_px = softness * self.spacing_px;
            let sampled: Vec<&CellSample> = self
                .cells
                .iter()
                .filter(|cell| cell.column % every == 0 && cell.row % every == 0)
                .filter(|cell| depth_px(&at, cell.at).abs() < REACH * softness_px)
                .collect();
            let residuals = |q: &[f64; N]| {
                let apart =
                    sampled.iter().map(|cell| sigmoid(depth_px(q, cell.at) / softness_px) - cell.probability);
                Some(apart.collect())
            };
            (at, _) = least_squares(at, [STEP_PX; N], residuals)?;
        }
        Some(at)
    }
}

fn sigmoid(x: f64) -> f64 {
    1.0 / (1.0 + (-x).exp())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Prediction of a confident network for a top with this interior.
    fn seen(is_inside: impl Fn(DVec2) -> bool) -> TopRegion {
        let cells = (0..60 * 80).map(|index| {
            let (column, row) = (index % 80, index / 80);
            let at = 4.0 * DVec2::new(column as f64 + 0.5, row as f64 + 0.5);
            // Four points a cell, so that edges are as soft as a network's.
            let points = [(-1.0, -1.0), (1.0, -1.0), (-1.0, 1.0), (1.0, 1.0)];
            let within = points.iter().filter(|(x, y)| is_inside(at + DVec2::new(*x, *y))).count();
            CellSample { at, column, row, probability: 0.02 + 0.24 * within as f64 }
        });
        TopRegion { cells: cells.collect(), spacing_px: 4.0 }
    }

    const TRUE_CORNERS: [DVec2; 4] =
        [DVec2::new(62.0, 51.0), DVec2::new(271.0, 44.0), DVec2::new(301.0, 181.0), DVec2::new(30.0, 196.0)];

    #[test]
    fn quadrilateral_fit_ignores_spike() {
        let spiked = seen(|p| contains(&TRUE_CORNERS, p) || (p - DVec2::new(290.0, 40.0)).length() < 16.0);
        let off = [(-9.0, -9.0), (25.0, -16.0), (8.0, 9.0), (-8.0, 7.0)].map(|(x, y)| DVec2::new(x, y));
        let start = std::array::from_fn(|k| TRUE_CORNERS[k] + off[k]);
        let found = spiked.quadrilateral(&start).expect("a quadrilateral");
        for (corner, expected) in found.iter().zip(TRUE_CORNERS) {
            assert!((*corner - expected).length() < 3.0, "{corner} for {expected}");
        }
        let (after, before) = (spiked.overlap(&found), spiked.overlap(&start));
        assert!(after > 0.95 && before < after - 0.02, "{before} {after}");
    }

    #[test]
    fn ellipse_fit_ignores_occluded_edge() {
        let expected =
            Ellipse { center: DVec2::new(160.0, 110.0), semi_axes: DVec2::new(110.0, 60.0), angle_rad: 0.1 };
        // An occluder cuts into its edge.
        let occluded = seen(|p| expected.depth_px(p) > 0.0 && (p - DVec2::new(160.0, 170.0)).length() > 14.0);
        let start = Ellipse {
            center: expected.center + DVec2::new(5.0, -6.0),
            semi_axes: expected.semi_axes * 1.07,
            angle_rad: 0.0,
        };
        let found = occluded.ellipse(&start).expect("an ellipse");
        assert!((found.center - expected.center).length() < 1.5, "{found:?}");
        assert!((found.semi_axes - expected.semi_axes).length() < 2.0, "{found:?}");
        assert!((found.angle_rad - expected.angle_rad).abs() < 0.03, "{found:?}");
    }
}
