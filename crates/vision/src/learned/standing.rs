//! Things as solids that stand on the table, and the elevation from which they are seen to stand best.
//!
//! The outline of a rectangle or of a circle corrects what the network says of the elevation, and does it better than what
//! stands on it would; no other outline tells anything of it. The things do: seen from too high, boxes and cylinders lean, sink
//! or have no such silhouette.

use glam::DVec2;
use rayon::prelude::*;

use super::instances::Thing;
use super::top::{SeenTop, Top};
use crate::VisionError;
use crate::network::maps::Maps;
use crate::pixels::Pixels;
use crate::reading::TopShape;
use crate::solid_fit;
use crate::solid_fit::{Expected, ExpectedBase, InnerEdges, SolidFit, Surroundings};
use geometry::Camera;
use imaging::Mask;
use runtime::{Interrupt, Interrupted};

/// Standard deviation of what the network says of the middle of a footprint, map pixels.
const BASE_SIGMA: f64 = 1.5;
/// Least height of a thing, as a share of the camera's height above the table.
const LEAST_HEIGHT: f64 = 0.002;
/// Standard deviation of what the network says of the elevation, on pictures of the validation split.
const ELEVATION_SIGMA_RAD: f64 = 0.1;
/// Elevations that are tried: so far apart, and so many on either side of what the network says.
const ELEVATION_STEP_RAD: f64 = 0.06;
const STEPS_EITHER_SIDE: i32 = 3;
/// How much more merit of all solids makes an elevation e times as likely; on pictures of the validation split.
const MERIT_UNIT: f64 = 0.05;

/// A thing as a solid, and how high it stands.
pub(super) struct Solid {
    pub fit: SolidFit,
    pub support: f64,
}

/// Things, and what is seen of each.
pub(super) struct Standing<'a> {
    pub things: &'a [Thing],
    /// Pixels of the copy, without holes.
    pub silhouettes: &'a [Vec<usize>],
    /// What hides parts of it.
    pub in_front: &'a [Mask],
    pub edges: &'a InnerEdges,
    pub maps: &'a Maps,
    pub pixels: &'a Pixels,
    pub interrupt: &'a Interrupt,
}

impl Standing<'_> {
    /// The top, seen from where the things stand best on it, and each as the simplest solid that looks like it there; `None`
    /// for what looks like none. The network says the elevation (radians) and the focal length (longer sides of the
    /// picture).
    pub fn best(
        &self,
        seen: &SeenTop,
        (said_rad, focal): (f64, f64),
    ) -> Result<(Top, Vec<Option<Solid>>), VisionError> {
        let first = seen.under(said_rad, focal).ok_or(VisionError::NoCamera)?;
        if tells_the_elevation(&first) {
            let (solids, _) = self.on(&first)?;
            return Ok((first, solids));
        }
        let seen_from = |steps: f64| -> Result<Option<Seen>, Interrupted> {
            let off_rad = ELEVATION_STEP_RAD * steps;
            // From elsewhere it may be no top of this kind, or none at all.
            let Some(top) = seen.under(said_rad + off_rad, focal).filter(|top| !tells_the_elevation(top))
            else {
                return Ok(None);
            };
            let (solids, merit) = self.on(&top)?;
            let likelihood = merit / MERIT_UNIT - 0.5 * (off_rad / ELEVATION_SIGMA_RAD).powi(2);
            Ok(Some(Seen { top, solids, likelihood }))
        };
        let tried = (-STEPS_EITHER_SIDE..=STEPS_EITHER_SIDE)
            .map(|k| seen_from(f64::from(k)))
            .collect::<Result<Vec<Option<Seen>>, Interrupted>>()?;
        let likelihoods: Vec<Option<f64>> =
            tried.iter().map(|seen| seen.as_ref().map(|seen| seen.likelihood)).collect();
        let steps = summit(&likelihoods).map(|place| place - f64::from(STEPS_EITHER_SIDE));
        let between = steps.map(seen_from).transpose()?.flatten();
        let all = tried.into_iter().flatten().chain(between);
        let best = all.max_by(|a, b| a.likelihood.total_cmp(&b.likelihood)).ok_or(VisionError::NoCamera)?;
        Ok((best.top, best.solids))
    }

    /// Each thing as the simplest solid that looks like it under the top's camera, and the sum of the solids' merits.
    fn on(&self, top: &Top) -> Result<(Vec<Option<Solid>>, f64), Interrupted> {
        let seen = self.things.par_iter().zip(self.silhouettes).zip(self.in_front);
        let fits = seen
            .map(|((thing, silhouette), in_front)| {
                self.interrupt.check()?;
                Ok(self.solid(thing, silhouette, in_front, top))
            })
            .collect::<Result<Vec<Option<(Solid, f64)>>, Interrupted>>()?;
        let merit = fits.iter().flatten().map(|(_, merit)| merit).sum();
        Ok((fits.into_iter().map(|fit| fit.map(|(solid, _)| solid)).collect(), merit))
    }

    fn solid(&self, thing: &Thing, silhouette: &[usize], in_front: &Mask, top: &Top) -> Option<(Solid, f64)> {
        let camera = &top.found.camera;
        let eye_height = camera.world_from_camera.translation_m.z;
        let said = self.expected(thing, camera);
        let support = said.as_ref().map_or(0.0, |(_, support)| *support);
        let around = Surroundings {
            in_front: Some(in_front.bits()),
            top: Some((&top.outline, (eye_height - support) / eye_height)),
        };
        let expected = said.as_ref().map(|(expected, _)| expected);
        let (fit, merit) = solid_fit::fit(silhouette, camera, Some(self.edges), expected, &around)?;
        Some((Solid { fit, support }, merit))
    }

    /// What the network says of a thing that stands on the table along the same rays, and how high it stands; `None` where its
    /// base is seen above the horizon.
    fn expected(&self, thing: &Thing, camera: &Camera) -> Option<(Expected, f64)> {
        let in_copy = |p: DVec2| self.pixels.scale * self.maps.in_picture(p);
        let row = |y: f64| in_copy(DVec2::new(thing.base.x, y));
        let eye_height = camera.world_from_camera.translation_m.z;
        let ground = camera.meet_plane(row(thing.ground_row), 0.0)?.truncate();
        let support = height_over(camera, ground, in_copy(thing.base)).clamp(0.0, 0.9 * eye_height);
        let top = height_over(camera, ground, row(thing.top_row));
        let height = (top - support).max(LEAST_HEIGHT * eye_height);
        let sigma_px = BASE_SIGMA * self.maps.pixel_px() * self.pixels.scale;
        let base = ExpectedBase { at_px: in_copy(thing.base), sigma_px };
        // What stands higher is nearer to the camera, hence smaller than on the table.
        let height = height * eye_height / (eye_height - support);
        Some((Expected { base: Some(base), height }, support))
    }
}

/// Whether the outline corrected the elevation.
fn tells_the_elevation(top: &Top) -> bool {
    matches!(top.shape, TopShape::Rectangle | TopShape::Circle)
}

/// The things as they stand when seen from some elevation.
struct Seen {
    top: Top,
    solids: Vec<Option<Solid>>,
    likelihood: f64,
}

/// Where, counted in places, a parabola through the greatest of values and its neighbors is highest; `None` where a neighbor
/// is missing.
fn summit(values: &[Option<f64>]) -> Option<f64> {
    let known = values.iter().enumerate().filter_map(|(place, value)| Some((place, (*value)?)));
    let (most, here) = known.max_by(|a, b| a.1.total_cmp(&b.1))?;
    let (before, after) = ((*values.get(most.checked_sub(1)?)?)?, (*values.get(most + 1)?)?);
    let bend = before + after - 2.0 * here;
    (bend < 0.0).then(|| most as f64 + 0.5 * (before - after) / bend)
}

/// Height at which the upright line over a point of the table is seen in a pixel's row.
fn height_over(camera: &Camera, ground: DVec2, at_px: DVec2) -> f64 {
    let eye = camera.world_from_camera.translation_m;
    let away = ground - eye.truncate();
    let ray = camera.ray_direction_in_world(at_px);
    eye.z + away.length_squared() / ray.truncate().dot(away).max(1e-9) * ray.z
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_summit_lies_between_the_elevations_that_were_tried() {
        let along = |highest: f64| -> Vec<Option<f64>> {
            (0..7).map(|place| Some(5.0 - 2.0 * (f64::from(place) - highest).powi(2))).collect()
        };
        for highest in [1.0, 3.3, 4.45] {
            let found = summit(&along(highest)).expect("has neighbors");
            assert!((found - highest).abs() < 1e-9, "{found} for {highest}");
        }
        assert_eq!(summit(&along(-1.0)), None, "the first has no neighbor before it");
        assert_eq!(summit(&along(9.0)), None, "nor the last one after it");
        let mut torn = along(3.3);
        torn[2] = None;
        assert_eq!(summit(&torn), None);
        assert_eq!(summit(&[Some(1.0), Some(1.0), Some(1.0)]), None, "a plain has none");
        assert_eq!(summit(&[None, None]), None);
    }
}
