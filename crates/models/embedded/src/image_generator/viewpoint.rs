//! Camera selection for the reference image.
//!
//! Cameras are sampled within the allowed angles and moved until the table with all objects fills the frame.
//! Small id images give the visible share of each object. The first camera with sufficient visibility is
//! selected, otherwise the best of those tried.

use glam::DVec3;
use rand::RngExt;
use rayon::prelude::*;

use super::ImageGeneratorSettings;
use super::arrangement::Arrangement;
use super::objects::SceneObject;
use super::table::SceneTable;
use geometry::{Camera, Pose};
use render::{Lighting, RenderObject, View, render_geometry};
use runtime::seed::{Rng, child_rng};
use runtime::{CancelFlag, Cancelled};
use scene::RelationKind;

/// Width of the id images that measure visibility, pixels.
const TRIAL_PX: u32 = 360;

/// Camera and light of an image.
pub(super) struct Viewpoint {
    pub camera: Camera,
    pub lighting: Lighting,
    /// Minimum over the objects of visible over total silhouette area, at trial size.
    pub min_visible_share: f64,
    /// Minimum visible share over the objects that nothing rests on: lower objects of a stack are covered in every
    /// arrangement.
    pub min_uncovered_visible_share: f64,
    /// Minimum visible share over the objects that nothing rests on and that are not in another one: a container hides
    /// its contents in most arrangements.
    pub min_open_visible_share: f64,
    /// Names of objects without a visible pixel.
    pub hidden: Vec<String>,
}

/// The first camera with sufficient visibility of all objects, or the best of those tried.
pub(super) fn choose(
    table: &SceneTable,
    objects: &[SceneObject],
    arrangement: &Arrangement,
    seed: u64,
    settings: &ImageGeneratorSettings,
    cancel: &CancelFlag,
) -> Result<Viewpoint, Cancelled> {
    let mut rng = child_rng(seed, "camera");
    let points = framed_points(table, objects, arrangement);
    let lighting = light(&mut child_rng(seed, "light"));
    let mut best: Option<Viewpoint> = None;
    for _ in 0..settings.views.max(1) {
        cancel.check()?;
        let camera = framed(&points, sample_angles(settings, &mut rng), settings);
        let shares = visible_shares(table, objects, arrangement, &camera);
        let min_of = |counts: &dyn Fn(&SceneObject) -> bool| {
            let counted = objects.iter().zip(&shares).filter(|(object, _)| counts(object));
            counted.map(|(_, share)| *share).fold(1.0, f64::min)
        };
        let min_share = min_of(&|_| true);
        let min_uncovered_visible_share = min_of(&|object| !is_covered(object, objects));
        let min_open_visible_share = min_of(&|object| !is_covered(object, objects) && !is_contained(object));
        let hidden = objects.iter().zip(&shares).filter(|(_, share)| **share <= 0.0);
        let hidden = hidden.map(|(object, _)| object.spec.id.to_string()).collect();
        if best.as_ref().is_none_or(|best| min_share > best.min_visible_share) {
            best = Some(Viewpoint {
                camera,
                lighting,
                min_visible_share: min_share,
                min_uncovered_visible_share,
                min_open_visible_share,
                hidden,
            });
        }
        if min_share >= settings.min_visible_share {
            break;
        }
    }
    // The loop tries at least one camera.
    Ok(best.expect("the loop above runs at least once"))
}

/// Whether another object rests on it.
fn is_covered(object: &SceneObject, objects: &[SceneObject]) -> bool {
    let relations = objects.iter().flat_map(|other| &other.spec.relations);
    relations.into_iter().any(|relation| {
        relation.kind.is_support()
            && relation.kind != RelationKind::In
            && relation.target.as_ref() == Some(&object.spec.id)
    })
}

fn is_contained(object: &SceneObject) -> bool {
    object
        .spec
        .relations
        .iter()
        .any(|relation| relation.kind == RelationKind::In && relation.target.is_some())
}

/// Azimuth and elevation of a camera.
#[derive(Clone, Copy)]
struct Angles {
    azimuth_rad: f64,
    elevation_rad: f64,
}

fn sample_angles(settings: &ImageGeneratorSettings, rng: &mut Rng) -> Angles {
    let [low, high] = settings.elevation_rad;
    // The mean of two samples favors the center of the range over its ends.
    let share = 0.5 * (rng.random_range(0.0..1.0) + rng.random_range(0.0..1.0));
    let turn: f64 = rng.random_range(-1.0..1.0);
    Angles { azimuth_rad: settings.azimuth_rad * turn, elevation_rad: low + share * (high - low) }
}

/// A high, soft light from one side.
fn light(rng: &mut Rng) -> Lighting {
    let side = if rng.random_bool(0.5) { 1.0 } else { -1.0 };
    let azimuth_rad = side * rng.random_range(0.5..1.3);
    Lighting::studio(azimuth_rad, rng.random_range(0.85..1.1), rng.random_range(0.5..1.0))
}

/// Points that must lie in the frame.
fn framed_points(table: &SceneTable, objects: &[SceneObject], arrangement: &Arrangement) -> Vec<DVec3> {
    let mut points = table.mesh.positions.clone();
    for (object, pose) in objects.iter().zip(&arrangement.poses) {
        let (low, high) = object.mesh.bounds();
        points.extend((0..8).map(|k| {
            let pick = |bit: usize, l: f64, h: f64| if k & bit == 0 { l } else { h };
            let corner = DVec3::new(pick(1, low.x, high.x), pick(2, low.y, high.y), pick(4, low.z, high.z));
            pose.transform_point(corner)
        }));
    }
    points
}

/// The camera at these angles whose frame the points fill up to the margin.
fn framed(points: &[DVec3], angles: Angles, settings: &ImageGeneratorSettings) -> Camera {
    let (low, high) =
        points.iter().fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(l, h), &p| (l.min(p), h.max(p)));
    let (mut target_m, mut distance_m) = (0.5 * (low + high), 2.0 * (high - low).length());
    let (width, height) = (f64::from(settings.width_px), f64::from(settings.height_px));
    let wanted = 1.0 - 2.0 * settings.frame_margin;
    let camera = |target_m: DVec3, distance_m: f64| {
        Camera::orbit(
            settings.width_px,
            settings.height_px,
            settings.fov_x_rad,
            target_m,
            angles.azimuth_rad,
            angles.elevation_rad,
            distance_m,
        )
    };
    for _ in 0..12 {
        let trial = camera(target_m, distance_m);
        let (mut low_px, mut high_px) = (glam::DVec2::INFINITY, glam::DVec2::NEG_INFINITY);
        for point in points {
            // A point behind the camera: retry from farther away.
            let Some((pixel, _)) = trial.project(*point) else {
                high_px = glam::DVec2::INFINITY;
                break;
            };
            (low_px, high_px) = (low_px.min(pixel), high_px.max(pixel));
        }
        if !high_px.is_finite() {
            distance_m *= 1.5;
            continue;
        }
        let off = 0.5 * (low_px + high_px) - glam::DVec2::new(trial.cx, trial.cy);
        let meters_per_px = distance_m / trial.fx;
        let in_camera = DVec3::new(off.x, off.y, 0.0) * meters_per_px;
        target_m += trial.world_from_camera.transform_vector(in_camera);
        let used = (high_px - low_px) / glam::DVec2::new(width, height);
        distance_m *= used.max_element() / wanted;
    }
    camera(target_m, distance_m)
}

/// Visible over total silhouette area of each object, from a small id image.
fn visible_shares(
    table: &SceneTable,
    objects: &[SceneObject],
    arrangement: &Arrangement,
    camera: &Camera,
) -> Vec<f64> {
    let scale = f64::from(TRIAL_PX) / f64::from(camera.width_px);
    let small = Camera {
        width_px: TRIAL_PX,
        height_px: (f64::from(camera.height_px) * scale).round() as u32,
        fx: camera.fx * scale,
        fy: camera.fy * scale,
        cx: camera.cx * scale,
        cy: camera.cy * scale,
        ..*camera
    };
    let view = View::Perspective(small);
    let placed: Vec<RenderObject> = objects
        .iter()
        .zip(&arrangement.poses)
        .enumerate()
        .map(|(k, (object, pose))| RenderObject {
            mesh: &object.mesh,
            world_from_object: *pose,
            id: k as u32 + 2,
        })
        .collect();
    let mut all = vec![RenderObject { mesh: &table.mesh, world_from_object: Pose::IDENTITY, id: 1 }];
    all.extend(&placed);
    let together = render_geometry(&all, &view);
    let mut visible = vec![0_usize; placed.len() + 2];
    together.ids.iter().for_each(|&id| visible[id as usize] += 1);
    placed
        .par_iter()
        .map(|object| {
            let whole = render_geometry(&[*object], &view).ids.iter().filter(|&&id| id != 0).count();
            visible[object.id as usize] as f64 / whole.max(1) as f64
        })
        .collect()
}
