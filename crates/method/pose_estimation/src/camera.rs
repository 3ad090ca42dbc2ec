//! Camera refinement: the angles at which one camera explains all silhouettes.
//!
//! A camera estimated by a model may be a few degrees too high, too low or too far to the side. It keeps its target
//! point and distance ([`Camera::orbited`]). The paper refines it together with the yaw of one object; here all
//! silhouettes share it. Two kinds of witness, with the loss of [`super::yaw`]:
//!
//! - the *table*, whose frame is the world, determines both angles (`by_table`). Its depth and height are estimates,
//!   and its position and size in the image depend on the exact target point: these five numbers are optimized as
//!   well, near their estimates;
//! - the *objects*, with boxes fitted to the masks' so that sizes and positions do not count, each at its best yaw. A
//!   turned camera and turned objects are equivalent, so they determine the elevation alone (`by_objects`). The minimum
//!   of a mesh of the wrong shape is arbitrary; the elevation minimizes the sum of the losses' bounded excess, so that
//!   one bad mesh has bounded influence.
//!
//! The table is used if its mask is given and its silhouette fits; otherwise the objects are. A table's outline is
//! some ten times as long as an object's, and a pixel of it that much less of an angle.
//!
//! Guarantees: same input, same answer with any number of threads; never farther from the given camera than
//! [`REACH_RAD`]. Cost: 540 silhouettes for the table, some 300 coarse ones per object. Unsuitable for images with a
//! known camera: a third of a degree is lost there where masks are eroded (`docs/results/layout.md`).

use std::f64::consts::TAU;

use glam::{DVec2, DVec3};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::yaw::YawSettings;
use super::yaw::comparison::{Comparison, Place};
use super::yaw::crop::Crop;
use super::yaw::outline_mesh::OutlineMesh;
use geometry::optimize::{golden_section, local_minima, nelder_mead};
use geometry::{Camera, TexturedMesh};
use imaging::Mask;
use runtime::{CancelFlag, Cancelled};

/// Farthest correction: of the azimuth, of the elevation.
pub const REACH_RAD: [f64; 2] = [0.07, 0.14];

/// A mesh and its mask in the image.
#[derive(Clone, Copy)]
pub struct ObservedMesh<'a> {
    /// An object's: canonical frame, at about its real size. The table's: world frame.
    pub mesh: &'a TexturedMesh,
    pub mask: &'a Mask,
    /// Pixels that may hide it; both as large as the camera's image.
    pub unknown: &'a Mask,
    /// World z of its bottom, meters.
    pub support_height_m: f64,
}

/// The camera and the silhouettes.
pub struct CameraProblem<'a> {
    pub camera: &'a Camera,
    pub table: Option<ObservedMesh<'a>>,
    pub objects: Vec<ObservedMesh<'a>>,
}

/// The source of the refined angles.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum CameraWitness {
    Table,
    Objects,
    /// No source: the camera is the given one.
    Nothing,
}

/// The camera and how far it was moved.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct RefinedCamera {
    pub camera: Camera,
    pub witness: CameraWitness,
    /// Added to the given camera's angles.
    pub azimuth_rad: f64,
    pub elevation_rad: f64,
    /// Of the witness, with the given camera and with this one.
    pub loss_before: f64,
    pub loss: f64,
}

/// Loss of the table's silhouette above which its mesh is taken for a different table.
const STRANGE_TABLE_LOSS: f64 = 0.12;
/// Penalty of the table's depth, height or size in the image off by a factor of e, or of its place by the longer
/// side of its box.
const TABLE_PENALTY: f64 = 0.2;
const TABLE_EVALUATIONS: usize = 240;
/// First steps: of azimuth and elevation, radians; of the logarithms of the table's depth, height and size in the
/// image; of its place, shares of the longer side of its box.
const TABLE_STEPS: [f64; 7] = [0.02, 0.04, 0.02, 0.02, 0.01, 0.01, 0.01];

/// Elevations at which objects are compared, to either side of the given one.
const ELEVATIONS: i32 = 7;
const ELEVATION_STEP_RAD: f64 = REACH_RAD[1] / ELEVATIONS as f64;
/// Yaws that are followed from one elevation to the next.
const YAWS: usize = 4;
/// Width of the interval at which the search for an object's yaw stops.
const YAW_TOLERANCE_RAD: f64 = 0.01;
/// Excess loss at which an object's influence is half of its bound.
const HALF_EXCESS: f64 = 0.01;
/// Minimum number of objects that determine the elevation.
const MIN_OBJECTS: usize = 3;

/// The camera that agrees best with the silhouettes.
pub fn refine_camera(
    problem: &CameraProblem,
    settings: &YawSettings,
    cancel: &CancelFlag,
) -> Result<RefinedCamera, Cancelled> {
    if let Some(table) = &problem.table
        && let Some(found) = by_table(problem.camera, table, settings, cancel)?
    {
        return Ok(found);
    }
    let found = by_objects(problem, settings, cancel)?;
    Ok(found.unwrap_or(RefinedCamera {
        camera: *problem.camera,
        witness: CameraWitness::Nothing,
        azimuth_rad: 0.0,
        elevation_rad: 0.0,
        loss_before: 0.0,
        loss: 0.0,
    }))
}

/// Both angles by the table's silhouette; `None` where it does not fit.
fn by_table(
    camera: &Camera,
    table: &ObservedMesh,
    settings: &YawSettings,
    cancel: &CancelFlag,
) -> Result<Option<RefinedCamera>, Cancelled> {
    let Some(silhouette) = Silhouette::new(table, settings.fine_px, settings) else { return Ok(None) };
    let side_px = (silhouette.crop.high_px - silhouette.crop.low_px).max_element();
    let value = |[azimuth_rad, elevation_rad, log_depth, log_height, log_zoom, right, down]: [f64; 7]| {
        if cancel.check().is_err() || !within_reach(azimuth_rad, elevation_rad) {
            return 1.0;
        }
        let stretch = DVec3::new(1.0, log_depth.exp(), log_height.exp());
        let moved = ImageShift { shift_px: side_px * DVec2::new(right, down), log_zoom };
        let camera = camera.orbited(azimuth_rad, elevation_rad);
        silhouette.table_loss(&camera, stretch, moved, settings)
            + TABLE_PENALTY
                * [log_depth, log_height, log_zoom, right, down].iter().map(|v| v * v).sum::<f64>()
    };
    let loss_before = value([0.0; 7]);
    // The angles alone, then all parameters, twice: a restart lets a collapsed simplex continue.
    let [azimuth_step, elevation_step, ..] = TABLE_STEPS;
    let angles =
        |[azimuth_rad, elevation_rad]: [f64; 2]| value([azimuth_rad, elevation_rad, 0.0, 0.0, 0.0, 0.0, 0.0]);
    let ([azimuth_rad, elevation_rad], _) = nelder_mead([0.0; 2], [azimuth_step, elevation_step], 60, angles);
    let start = [azimuth_rad, elevation_rad, 0.0, 0.0, 0.0, 0.0, 0.0];
    let (rough, _) = nelder_mead(start, TABLE_STEPS.map(|step| 0.5 * step), TABLE_EVALUATIONS, value);
    let (found, loss) = nelder_mead(rough, TABLE_STEPS.map(|step| -0.25 * step), TABLE_EVALUATIONS, value);
    cancel.check()?;
    let [azimuth_rad, elevation_rad, ..] = found;
    Ok((loss < STRANGE_TABLE_LOSS).then(|| RefinedCamera {
        camera: camera.orbited(azimuth_rad, elevation_rad),
        witness: CameraWitness::Table,
        azimuth_rad,
        elevation_rad,
        loss_before,
        loss,
    }))
}

fn within_reach(azimuth_rad: f64, elevation_rad: f64) -> bool {
    azimuth_rad.abs() <= REACH_RAD[0] && elevation_rad.abs() <= REACH_RAD[1]
}

/// The elevation by the objects' silhouettes; `None` where fewer than three show whole.
fn by_objects(
    problem: &CameraProblem,
    settings: &YawSettings,
    cancel: &CancelFlag,
) -> Result<Option<RefinedCamera>, Cancelled> {
    let camera = problem.camera;
    let curves = problem
        .objects
        .par_iter()
        .filter_map(|object| Silhouette::new(object, settings.coarse_px, settings))
        .filter(|silhouette| silhouette.crop.own_sides == [true; 4])
        .map(|silhouette| silhouette.losses_by_elevation(camera, settings, cancel))
        .collect::<Result<Vec<Vec<f64>>, Cancelled>>()?;
    if curves.len() < MIN_OBJECTS {
        return Ok(None);
    }
    let excess: Vec<f64> = (0..curves[0].len())
        .map(|k| {
            let of = |curve: &Vec<f64>| {
                let excess = curve[k] - curve.iter().copied().fold(f64::INFINITY, f64::min);
                excess / (excess + HALF_EXCESS)
            };
            curves.iter().map(of).sum::<f64>() / curves.len() as f64
        })
        .collect();
    let (steps, loss) = parabola_minimum(&excess);
    let elevation_rad = (steps - f64::from(ELEVATIONS)) * ELEVATION_STEP_RAD;
    Ok(Some(RefinedCamera {
        camera: camera.orbited(0.0, elevation_rad),
        witness: CameraWitness::Objects,
        azimuth_rad: 0.0,
        elevation_rad,
        loss_before: excess[ELEVATIONS as usize],
        loss,
    }))
}

/// Minimum of the parabola through the lowest value and its neighbors: its position in steps, and the lowest value.
fn parabola_minimum(values: &[f64]) -> (f64, f64) {
    let mut at = 0;
    for (k, value) in values.iter().enumerate() {
        if *value < values[at] {
            at = k;
        }
    }
    if at == 0 || at + 1 == values.len() {
        return (at as f64, values[at]);
    }
    let (a, b, c) = (values[at - 1], values[at], values[at + 1]);
    let curvature = a - 2.0 * b + c;
    let shift = if curvature > 1e-12 { (0.5 * (a - c) / curvature).clamp(-0.5, 0.5) } else { 0.0 };
    (at as f64 + shift, b)
}

/// Displacement of the table in the image.
#[derive(Clone, Copy)]
struct ImageShift {
    shift_px: DVec2,
    log_zoom: f64,
}

/// A mesh beside the crop it is compared with.
struct Silhouette {
    mesh: OutlineMesh,
    crop: Crop,
    support_height_m: f64,
}

impl Silhouette {
    /// `None` if the mask is empty or the mesh has no triangles.
    fn new(outlined: &ObservedMesh, side_px: u32, settings: &YawSettings) -> Option<Self> {
        let mesh = OutlineMesh::new(outlined.mesh, settings.outline_cells);
        let bbox = outlined.mask.bbox_px().filter(|_| !mesh.triangles.is_empty())?;
        let crop = Crop::new(outlined.mask, outlined.unknown, bbox, side_px as usize);
        Some(Self { mesh, crop, support_height_m: outlined.support_height_m })
    }

    /// Loss of the mesh where it is in the world (its yaw 0), stretched along its axes about the origin; its image
    /// moved.
    fn table_loss(&self, camera: &Camera, stretch: DVec3, moved: ImageShift, settings: &YawSettings) -> f64 {
        let mut mesh = self.mesh.clone();
        mesh.positions.iter_mut().for_each(|p| *p *= stretch);
        mesh.bounds = (mesh.bounds.0 * stretch, mesh.bounds.1 * stretch);
        let Some((center_px, _)) = camera.project(0.5 * (mesh.bounds.0 + mesh.bounds.1)) else { return 1.0 };
        let place = Place { center_px: center_px + moved.shift_px, log_zoom: moved.log_zoom };
        Comparison::new(&mesh, camera, stretch.z * self.support_height_m, &self.crop, settings)
            .standing_at(Some(place))
            .loss(0.0)
    }

    /// Least loss over all yaws at each elevation, lowest first.
    fn losses_by_elevation(
        &self,
        camera: &Camera,
        settings: &YawSettings,
        cancel: &CancelFlag,
    ) -> Result<Vec<f64>, Cancelled> {
        let here = Comparison::new(&self.mesh, camera, self.support_height_m, &self.crop, settings);
        let count = settings.coarse_yaws.max(8);
        let step_rad = TAU / f64::from(count);
        let mut curve = Vec::with_capacity(count as usize);
        for k in 0..count {
            cancel.check()?;
            curve.push((step_rad * f64::from(k), here.loss(step_rad * f64::from(k))));
        }
        let yaws = local_minima(&curve, YAWS);
        (-ELEVATIONS..=ELEVATIONS)
            .map(|k| {
                let camera = camera.orbited(0.0, f64::from(k) * ELEVATION_STEP_RAD);
                let there = Comparison::new(&self.mesh, &camera, self.support_height_m, &self.crop, settings);
                let mut lowest = f64::INFINITY;
                for yaw_rad in &yaws {
                    let (from, to) = (yaw_rad - step_rad, yaw_rad + step_rad);
                    let loss = |yaw_rad| cancel.check().map(|()| there.loss(yaw_rad));
                    lowest = lowest.min(golden_section(from, to, YAW_TOLERANCE_RAD, loss)?.1);
                }
                Ok(lowest)
            })
            .collect()
    }
}

#[cfg(test)]
mod tests;
