//! Things as solids that stand on the table, and the elevation from which they are seen to stand best.
//!
//! The outline of a rectangle or of a circle corrects what the network says of the elevation, and does it better than what
//! stands on it would; no other outline tells anything of it. The things do: seen from too high, boxes and cylinders lean, sink
//! or have no such silhouette.

use glam::DVec2;
use rayon::prelude::*;

use super::camera_fit::ELEVATION_SIGMA_RAD;
use super::instances::Thing;
use super::top::{SeenTop, Top};
use crate::geometry::{Camera, Interrupt, Interrupted, Mask};
use crate::vision::VisionError;
use crate::vision::network::maps::Maps;
use crate::vision::pixels::Pixels;
use crate::vision::reading::TopShape;
use crate::vision::solid_fit::{self, Expected, ExpectedBase, InnerEdges, SolidFit, Surroundings};

/// Standard deviation of what the network says of the middle of a footprint, map pixels.
const BASE_SIGMA: f64 = 1.5;
/// Least height of a thing, as a share of the camera's height above the table.
const LEAST_HEIGHT: f64 = 0.002;
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
            Ok(Some(Seen { steps, top, solids, likelihood }))
        };
        let tried = (-STEPS_EITHER_SIDE..=STEPS_EITHER_SIDE)
            .map(|k| seen_from(f64::from(k)))
            .collect::<Result<Vec<Option<Seen>>, Interrupted>>()?;
        let between = summit(&tried).map(seen_from).transpose()?.flatten();
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
    /// Steps up from what the network says.
    steps: f64,
    top: Top,
    solids: Vec<Option<Solid>>,
    likelihood: f64,
}

/// Where a parabola through the likeliest elevation and its neighbors is highest, steps; `None` where a neighbor is missing.
fn summit(tried: &[Option<Seen>]) -> Option<f64> {
    let likelihood = |k: usize| tried.get(k)?.as_ref().map(|seen| seen.likelihood);
    let most = (0..tried.len())
        .filter(|&k| tried[k].is_some())
        .max_by(|&a, &b| likelihood(a).unwrap_or(f64::MIN).total_cmp(&likelihood(b).unwrap_or(f64::MIN)))?;
    let (before, here, after) = (likelihood(most.checked_sub(1)?)?, likelihood(most)?, likelihood(most + 1)?);
    let bend = before + after - 2.0 * here;
    (bend < 0.0)
        .then(|| tried[most].as_ref().map(|seen| seen.steps + 0.5 * (before - after) / bend))
        .flatten()
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
    use glam::DVec3;

    use super::*;
    use crate::geometry::Image;
    use crate::vision::learned::{NetworkReadingSettings, indices, instances, masks, nearer_ones};
    use crate::vision::network::frame::Look;
    use crate::vision::network::{Answer, MAP_CHANNELS};
    use crate::vision::polygon::{contains, convex_hull};

    const PICTURE_PX: [u32; 2] = [640, 512];
    /// A top whose outline tells nothing of the camera, counter-clockwise.
    const TOP: [DVec2; 3] = [DVec2::new(-0.6, 0.35), DVec2::new(0.1, -0.45), DVec2::new(0.6, 0.3)];
    /// Middles of the feet and sizes of the blocks on it, the nearest first.
    const BLOCKS: [(DVec2, DVec3); 4] = [
        (DVec2::new(0.08, -0.15), DVec3::new(0.12, 0.10, 0.14)),
        (DVec2::new(-0.15, 0.02), DVec3::new(0.16, 0.12, 0.08)),
        (DVec2::new(0.3, 0.12), DVec3::new(0.10, 0.14, 0.20)),
        (DVec2::new(-0.28, 0.25), DVec3::new(0.18, 0.10, 0.10)),
    ];

    fn in_picture(camera: &Camera, point: DVec3) -> DVec2 {
        camera.project(point).expect("in front of the camera").0
    }

    /// Each block's outline in the picture.
    fn outlines(camera: &Camera) -> Vec<Vec<DVec2>> {
        let corners = |(middle, size): &(DVec2, DVec3)| -> Vec<DVec2> {
            let signs = (0..8).map(|k| [k & 1, k >> 1 & 1, k >> 2].map(f64::from));
            signs
                .map(|[x, y, z]| {
                    in_picture(camera, middle.extend(0.0) + DVec3::new(x - 0.5, y - 0.5, z) * *size)
                })
                .collect()
        };
        BLOCKS.iter().map(|block| convex_hull(&corners(block))).collect()
    }

    /// What a sure network says of the blocks on their top.
    fn maps(camera: &Camera) -> Maps {
        let look = Look::whole(PICTURE_PX);
        let [width, height] = look.frame_px.map(|side| side / 2);
        let empty = || Answer { maps: vec![0.0; MAP_CHANNELS * width * height], width, height };
        let grid = Maps::new(empty(), look);
        let (blocks, top) = (outlines(camera), TOP.map(|p| in_picture(camera, p.extend(0.0))));
        let [first, second, third] = top;
        let around =
            if (second - first).perp_dot(third - first) > 0.0 { top } else { [third, second, first] };
        let is_seen = |p: DVec2| blocks.iter().position(|outline| contains(outline, p));
        let mut answer = empty();
        let mut votes = vec![(DVec2::ZERO, 0.0); BLOCKS.len()];
        let seen: Vec<Option<usize>> =
            (0..grid.count()).map(|index| is_seen(grid.in_picture(grid.middle(index)))).collect();
        for (index, block) in seen.iter().enumerate().filter_map(|(index, block)| Some((index, (*block)?))) {
            votes[block].0 += grid.middle(index);
            votes[block].1 += 1.0;
        }
        for (index, block) in seen.iter().enumerate() {
            let at = grid.middle(index);
            let is_top = contains(&around, grid.in_picture(at));
            let kind = match (block, is_top) {
                (Some(_), _) => 3,
                (None, true) => 2,
                (None, false) => 0,
            };
            let mut say = |channel: usize, value: f64| {
                answer.maps[channel * width * height + index] = value as f32;
            };
            (0..4).for_each(|k| say(k, if k == kind { 4.0 } else { -4.0 }));
            say(4, if is_top { 4.0 } else { -4.0 });
            let Some(block) = *block else { continue };
            let (middle, size) = BLOCKS[block];
            let vote = votes[block].0 / votes[block].1;
            let base = grid.in_map(in_picture(camera, middle.extend(0.0)));
            let top_row = grid.in_map(in_picture(camera, middle.extend(size.z))).y;
            say(7, (-(at - vote).length_squared() / 12.5).exp());
            let ways =
                [vote.x - at.x, vote.y - at.y, base.x - at.x, base.y - at.y, top_row - at.y, base.y - at.y];
            ways.iter().enumerate().for_each(|(k, way)| say(8 + k, way / 8.0));
        }
        Maps::new(answer, look)
    }

    #[test]
    fn things_tell_the_elevation_where_the_outline_does_not() {
        let settings = NetworkReadingSettings {
            work_px: 640,
            min_table_share: 0.03,
            min_object_share: 0.0003,
            least_middle: 0.2,
            least_confidence: 0.45,
            mask_rim: 0.5,
            max_objects: 48,
        };
        let interrupt = Interrupt::default();
        for (elevation_rad, off_rad) in [(0.5, 0.13), (0.7, -0.13)] {
            let camera = Camera::orbit(640, 512, 0.61, DVec3::ZERO, 0.0, elevation_rad, 2.2);
            let mut picture = Image::filled(640, 512, [235, 235, 235, 255]);
            let blocks = outlines(&camera);
            for (x, y) in (0..512).flat_map(|y| (0..640).map(move |x| (x, y))) {
                let p = DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5);
                if let Some(k) = blocks.iter().position(|outline| contains(outline, p)) {
                    picture.set_pixel(x, y, [40 + 50 * k as u8, 90, 160 - 40 * k as u8, 255]);
                }
            }
            let (maps, pixels) = (maps(&camera), Pixels::new(&picture, settings.work_px));
            let said = (elevation_rad + off_rad, camera.fx / 640.0);
            let seen = SeenTop::new(&maps, &pixels, &settings).expect("a top");
            let things = instances::find(&maps, PICTURE_PX, &settings).expect("things");
            let masks = masks(&things, &maps, &pixels, &settings);
            let silhouettes: Vec<Vec<usize>> = masks.iter().map(indices).collect();
            let standing = Standing {
                things: &things,
                silhouettes: &silhouettes,
                in_front: &nearer_ones(&masks),
                edges: &InnerEdges::new(&pixels),
                maps: &maps,
                pixels: &pixels,
                interrupt: &interrupt,
            };
            let (top, solids) = standing.best(&seen, said).expect("solids");
            assert!(!tells_the_elevation(&top), "{:?}", top.shape);
            let off_now_rad = top.found.camera.elevation_rad() - elevation_rad;
            assert!(off_now_rad.abs() < 0.4 * off_rad.abs(), "{off_rad} became {off_now_rad}");
            assert_eq!(solids.iter().flatten().count(), BLOCKS.len());
        }
    }
}
