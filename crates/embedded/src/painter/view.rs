//! Which camera the picture is taken with.
//!
//! A few cameras are drawn within the allowed angles; each is moved until the whole table with everything
//! on it fills the frame. Small pictures of ids alone tell how much of each object shows; the first
//! camera that shows enough of every object is taken, else the best.

use glam::DVec3;
use rand::RngExt;
use rayon::prelude::*;

use super::PainterSettings;
use super::arrangement::Arrangement;
use super::props::Prop;
use super::table::PaintedTable;
use geometry::{Camera, Pose};
use render::{Lighting, RenderObject, View, render_geometry};
use runtime::seed::{Rng, child_rng};
use runtime::{Interrupt, Interrupted};

/// Width of the pictures that tell what shows, pixels.
const TRIAL_PX: u32 = 360;

/// Camera and light of a picture.
pub(super) struct Viewpoint {
    pub camera: Camera,
    pub lighting: Lighting,
    /// Of the worst object: visible over whole silhouette, at trial size.
    pub least_visible_share: f64,
    /// Names of objects that do not show at all.
    pub hidden: Vec<String>,
}

/// The first camera from which all objects show, or the best of those tried.
pub(super) fn choose(
    table: &PaintedTable,
    props: &[Prop],
    arrangement: &Arrangement,
    seed: u64,
    settings: &PainterSettings,
    interrupt: &Interrupt,
) -> Result<Viewpoint, Interrupted> {
    let mut rng = child_rng(seed, "camera");
    let points = framed_points(table, props, arrangement);
    let lighting = light(&mut child_rng(seed, "light"));
    let mut best: Option<Viewpoint> = None;
    for _ in 0..settings.views.max(1) {
        interrupt.check()?;
        let camera = framed(&points, draw(settings, &mut rng), settings);
        let shares = visible_shares(table, props, arrangement, &camera);
        let least = shares.iter().copied().fold(1.0, f64::min);
        let hidden = props.iter().zip(&shares).filter(|(_, share)| **share <= 0.0);
        let hidden = hidden.map(|(prop, _)| prop.spec.id.to_string()).collect();
        if best.as_ref().is_none_or(|known| least > known.least_visible_share) {
            best = Some(Viewpoint { camera, lighting, least_visible_share: least, hidden });
        }
        if least >= settings.least_visible_share {
            break;
        }
    }
    // At least one camera was tried.
    Ok(best.expect("the loop above runs at least once"))
}

/// Azimuth and elevation of a camera.
#[derive(Clone, Copy)]
struct Angles {
    azimuth_rad: f64,
    elevation_rad: f64,
}

fn draw(settings: &PainterSettings, rng: &mut Rng) -> Angles {
    let [low, high] = settings.elevation_rad;
    // Two draws averaged: the middle of the range is more usual than its ends.
    let share = 0.5 * (rng.random_range(0.0..1.0) + rng.random_range(0.0..1.0));
    let turn: f64 = rng.random_range(-1.0..1.0);
    Angles { azimuth_rad: settings.azimuth_rad * turn, elevation_rad: low + share * (high - low) }
}

/// Light from one side, high and soft.
fn light(rng: &mut Rng) -> Lighting {
    let side = if rng.random_bool(0.5) { 1.0 } else { -1.0 };
    let azimuth_rad = side * rng.random_range(0.5..1.3);
    Lighting::studio(azimuth_rad, rng.random_range(0.85..1.1), rng.random_range(0.5..1.0))
}

/// Everything that must be in the frame.
fn framed_points(table: &PaintedTable, props: &[Prop], arrangement: &Arrangement) -> Vec<DVec3> {
    let mut points = table.mesh.positions.clone();
    for (prop, pose) in props.iter().zip(&arrangement.poses) {
        let (low, high) = prop.mesh.bounds();
        points.extend((0..8).map(|k| {
            let pick = |bit: usize, l: f64, h: f64| if k & bit == 0 { l } else { h };
            let corner = DVec3::new(pick(1, low.x, high.x), pick(2, low.y, high.y), pick(4, low.z, high.z));
            pose.transform_point(corner)
        }));
    }
    points
}

/// The camera at these angles whose frame the points just fill.
fn framed(points: &[DVec3], angles: Angles, settings: &PainterSettings) -> Camera {
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
        let (mut least, mut most) = (glam::DVec2::INFINITY, glam::DVec2::NEG_INFINITY);
        for point in points {
            // A point behind the camera: step back and look again.
            let Some((pixel, _)) = trial.project(*point) else {
                most = glam::DVec2::INFINITY;
                break;
            };
            (least, most) = (least.min(pixel), most.max(pixel));
        }
        if !most.is_finite() {
            distance_m *= 1.5;
            continue;
        }
        let off = 0.5 * (least + most) - glam::DVec2::new(trial.cx, trial.cy);
        let meters_per_px = distance_m / trial.fx;
        let in_camera = DVec3::new(off.x, off.y, 0.0) * meters_per_px;
        target_m += trial.world_from_camera.transform_vector(in_camera);
        let used = (most - least) / glam::DVec2::new(width, height);
        distance_m *= used.max_element() / wanted;
    }
    camera(target_m, distance_m)
}

/// Visible over whole silhouette of each prop, from a small picture of ids.
fn visible_shares(
    table: &PaintedTable,
    props: &[Prop],
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
    let placed: Vec<RenderObject> = props
        .iter()
        .zip(&arrangement.poses)
        .enumerate()
        .map(|(k, (prop, pose))| RenderObject {
            mesh: &prop.mesh,
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
