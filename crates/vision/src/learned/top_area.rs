//! Quadrilaterals and ellipses fitted to the area that the network takes for the top.
//!
//! The corners of a hull lie where an outline errs most outward, and one spike moves them. Here every place of the maps
//! has its say: the shape whose soft inside agrees best with the probabilities of all places, first with an edge some
//! places wide, then with a sharp one. On rectangles of the validation split corners are half as far off as the hull's,
//! and a quarter of them no longer by more than three places.

use glam::DVec2;

use super::ellipse::Ellipse;
use crate::minimize::least_squares;
use crate::network::maps::Maps;
use crate::pixels::Pixels;
use crate::polygon::{area, contains};

/// Rounds of a fit: how soft the edge is, places, and of how many places each way one is looked at.
const ROUNDS: [(f64, usize); 3] = [(3.0, 3), (1.2, 2), (0.6, 1)];
/// Places deeper in or farther out than so many times the softness tell nothing about where the edge is.
const REACH: f64 = 10.0;
/// Probabilities are sharper than the network's own, which is unsure of a whole band.
const SHARPNESS: f64 = 2.0;
/// Edges of shapes are followed by a derivative over so many pixels.
const STEP_PX: f64 = 0.02;

/// How probable places of the maps are to lie within the top; positions and lengths in pixels of the copy.
pub(super) struct TopArea {
    places: Vec<Place>,
    /// From place to place.
    spacing_px: f64,
}

struct Place {
    at: DVec2,
    column: usize,
    row: usize,
    probability: f64,
}

impl TopArea {
    /// `inside` are the pixels of the copy that are taken for the top; what lies apart from them is not part of it.
    pub(super) fn new(maps: &Maps, pixels: &Pixels, inside: &[usize]) -> Self {
        let mut taken = vec![false; pixels.len()];
        inside.iter().for_each(|&index| taken[index] = true);
        let places = (0..maps.count()).filter(|&index| maps.shows_picture(index)).map(|index| {
            let at = pixels.scale * maps.in_picture(maps.middle(index));
            let logit = maps.outline(index);
            let is_taken = pixels.index_at(at).is_some_and(|pixel| taken[pixel]);
            let probability = match (is_taken, logit > 0.0) {
                (true, _) => sigmoid(SHARPNESS * logit.max(0.0)),
                (false, true) => 0.0,
                (false, false) => sigmoid(SHARPNESS * logit),
            };
            Place { at, column: index % maps.width(), row: index / maps.width(), probability }
        });
        Self { places: places.collect(), spacing_px: maps.pixel_px() * pixels.scale }
    }

    /// The convex quadrilateral that agrees best, from one near it; corners in the order of growing angle (y down).
    pub(super) fn quadrilateral(&self, start: &[DVec2; 4]) -> Option<[DVec2; 4]> {
        let corners =
            |q: &[f64; 8]| -> [DVec2; 4] { std::array::from_fn(|k| DVec2::new(q[2 * k], q[2 * k + 1])) };
        let first = std::array::from_fn(|k| start[k / 2][k % 2]);
        let found = self.fitted(first, |q, p| {
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

    /// The ellipse that agrees best, from one near it.
    pub(super) fn ellipse(&self, start: &Ellipse) -> Option<Ellipse> {
        let of = |q: &[f64; 5]| Ellipse {
            center: DVec2::new(q[0], q[1]),
            semi_axes: DVec2::new(q[2], q[3]),
            // A pixel of the longer axis' end is the unit of turning, too.
            angle_rad: q[4] / start.semi_axes.x,
        };
        let first = [
            start.center.x,
            start.center.y,
            start.semi_axes.x,
            start.semi_axes.y,
            start.angle_rad * start.semi_axes.x,
        ];
        let found = of(&self.fitted(first, |q, p| of(q).depth_px(p))?);
        (found.semi_axes.min_element() > 0.0 && found.center.is_finite()).then_some(found)
    }

    /// Intersection over union of a convex polygon (in the order of growing angle) with the places within the top.
    pub(super) fn overlap(&self, polygon: &[DVec2]) -> f64 {
        let (mut both, mut either) = (0_usize, 0_usize);
        for place in &self.places {
            let (seen, drawn) = (place.probability >= 0.5, contains(polygon, place.at));
            both += usize::from(seen && drawn);
            either += usize::from(seen || drawn);
        }
        both as f64 / either.max(1) as f64
    }

    /// Parameters at which `depth_px` (how deep within the shape a point lies, negative outside) agrees best.
    fn fitted<const N: usize>(
        &self,
        start: [f64; N],
        depth_px: impl Fn(&[f64; N], DVec2) -> f64,
    ) -> Option<[f64; N]> {
        let mut at = start;
        for (softness, every) in ROUNDS {
            let softness_px = softness * self.spacing_px;
            let looked_at: Vec<&Place> = self
                .places
                .iter()
                .filter(|place| place.column % every == 0 && place.row % every == 0)
                .filter(|place| depth_px(&at, place.at).abs() < REACH * softness_px)
                .collect();
            let residuals = |q: &[f64; N]| {
                let apart = looked_at
                    .iter()
                    .map(|place| sigmoid(depth_px(q, place.at) / softness_px) - place.probability);
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

    /// What a sure network says of a top of which `is_inside`.
    fn seen(is_inside: impl Fn(DVec2) -> bool) -> TopArea {
        let places = (0..60 * 80).map(|index| {
            let (column, row) = (index % 80, index / 80);
            let at = 4.0 * DVec2::new(column as f64 + 0.5, row as f64 + 0.5);
            // Four points of a place: edges are as soft as a network's.
            let points = [(-1.0, -1.0), (1.0, -1.0), (-1.0, 1.0), (1.0, 1.0)];
            let within = points.iter().filter(|(x, y)| is_inside(at + DVec2::new(*x, *y))).count();
            Place { at, column, row, probability: 0.02 + 0.24 * within as f64 }
        });
        TopArea { places: places.collect(), spacing_px: 4.0 }
    }

    const TRUE_CORNERS: [DVec2; 4] =
        [DVec2::new(62.0, 51.0), DVec2::new(271.0, 44.0), DVec2::new(301.0, 181.0), DVec2::new(30.0, 196.0)];

    #[test]
    fn a_spike_does_not_move_a_quadrilateral() {
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
    fn an_ellipse_is_found_behind_what_hides_its_edge() {
        let expected =
            Ellipse { center: DVec2::new(160.0, 110.0), semi_axes: DVec2::new(110.0, 60.0), angle_rad: 0.1 };
        // A bite out of its edge.
        let bitten = seen(|p| expected.depth_px(p) > 0.0 && (p - DVec2::new(160.0, 170.0)).length() > 14.0);
        let start = Ellipse {
            center: expected.center + DVec2::new(5.0, -6.0),
            semi_axes: expected.semi_axes * 1.07,
            angle_rad: 0.0,
        };
        let found = bitten.ellipse(&start).expect("an ellipse");
        assert!((found.center - expected.center).length() < 1.5, "{found:?}");
        assert!((found.semi_axes - expected.semi_axes).length() < 2.0, "{found:?}");
        assert!((found.angle_rad - expected.angle_rad).abs() < 0.03, "{found:?}");
    }
}
