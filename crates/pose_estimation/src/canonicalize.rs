//! Which way is up: the one of 24 axis-aligned rotations that stands a raw mesh as the picture shows it.
//!
//! A generated mesh comes unit-sized in any of 24 orientations. Three kinds of evidence are added up as
//! costs, the least wins:
//!
//! - *extents*: width, depth and height as common sense gives them against the turned mesh's, up to one
//!   common factor (tells lying from standing);
//! - *picture*: with each of the six up directions the mesh is turned through a full circle on the
//!   instance's viewing ray; the best silhouette and, there, the colors count (tells upside down);
//! - *example*: where a typical mesh of its kind is known in the canonical frame, how alike the turned mesh
//!   fills its box (names the front, breaks ties), and how alike what is drawn on both is spread over their boxes
//!   (tells a cover from a back);
//! - *told*: what somebody says who has looked at the mesh. It breaks ties, and names the front where nothing else can; it does
//!   not outweigh a picture that shows the thing otherwise.
//!
//! The four rotations that share an up direction cast the same outlines, so between them only extents and
//! example decide; where neither does (a cube without an example) the first in the list is taken, and the
//! yaw found later is relative to it. Cost: 6 x 24 small silhouettes and five to thirty 64 x 64
//! paintings, about 0.03 s of one core for the catalog's meshes.

mod cells;
mod contest;
mod detail;
mod evidence;
mod likeness;
mod settings;
mod turns;

pub use settings::CanonicalizeSettings;
pub use turns::axis_aligned;

use glam::{DQuat, DVec3};
use rayon::prelude::*;

use contest::Candidates;
use evidence::Standing;

use super::dro::DroSettings;
use super::dro::outline_mesh::OutlineMesh;
use geometry::{Camera, TexturedMesh};
use imaging::{Image, Mask};
use runtime::{Interrupt, Interrupted};

/// A raw mesh and what is known of the instance.
#[derive(Clone, Copy, Debug)]
pub struct UprightProblem<'a> {
    /// As generated: any size, any of the 24 axis-aligned orientations.
    pub raw_mesh: &'a TexturedMesh,
    pub camera: &'a Camera,
    /// Complete silhouette of the instance, as large as the camera's picture.
    pub mask: &'a Mask,
    /// Picture of the instance and the part of the camera's picture it shows (x0, y0, x1, y1 pixels);
    /// transparent pixels do not count.
    pub picture: Option<(&'a Image, [f64; 4])>,
    /// Commonsense extents as it stands: width, depth, height, meters.
    pub size_m: DVec3,
    /// A typical mesh of its kind in the canonical frame, any size.
    pub example: Option<&'a TexturedMesh>,
    /// `canonical_from_raw` as somebody says who has looked; of several each is as good, none = nobody has.
    pub told: &'a [DQuat],
}

/// How the raw mesh is to be turned, and how sure that is.
#[derive(Clone, Debug, PartialEq)]
pub struct CanonicalPose {
    /// `canonical_from_raw`, one of the 24.
    pub rotation: DQuat,
    /// Common factor that brings the turned mesh nearest to `size_m`.
    pub scale: f64,
    /// Cost of that rotation, in units of the silhouette loss.
    pub cost: f64,
    /// 0..1: lead of the best over the best with another up direction.
    pub confidence: f64,
}

/// Why no rotation could be found.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum CanonicalizeError {
    #[error("standing a mesh up: it has no triangles or no extent; reconstruct it again")]
    EmptyMesh,
    #[error("standing a mesh up: the instance's mask is empty or not as large as the camera's picture")]
    NoMask,
    #[error("standing a mesh up: its commonsense size is not positive; measure it again")]
    NoSize,
    #[error(transparent)]
    Interrupted(#[from] Interrupted),
}

/// Finds the rotation that stands the mesh as the picture shows it.
pub fn upright(
    problem: &UprightProblem,
    settings: &CanonicalizeSettings,
    dro: &DroSettings,
    interrupt: &Interrupt,
) -> Result<CanonicalPose, CanonicalizeError> {
    let raw_size = problem.raw_mesh.size_m();
    if problem.raw_mesh.triangle_count() == 0 || raw_size.max_element() <= 0.0 || !raw_size.is_finite() {
        return Err(CanonicalizeError::EmptyMesh);
    }
    if !(problem.size_m.min_element() > 0.0 && problem.size_m.is_finite()) {
        return Err(CanonicalizeError::NoSize);
    }
    let camera = problem.camera;
    let fits = (problem.mask.width_px(), problem.mask.height_px()) == (camera.width_px, camera.height_px);
    let bbox = problem.mask.bbox_px().filter(|_| fits).ok_or(CanonicalizeError::NoMask)?;

    let turns = turns::axis_aligned();
    let extent_costs: Vec<f64> =
        turns.iter().map(|t| evidence::extent_cost(raw_size, *t, problem.size_m, settings)).collect();
    let least = extent_costs.iter().copied().fold(f64::INFINITY, f64::min);
    let example_costs: Vec<f64> = match problem.example {
        Some(example) => {
            let shapes = likeness::costs(problem.raw_mesh, &turns, example);
            let details = detail::costs(problem.raw_mesh, &turns, example);
            let weighted =
                |(shape, detail)| settings.example_weight * shape + settings.detail_weight * detail;
            shapes.into_iter().zip(details).map(weighted).collect()
        }
        None => vec![0.0; turns.len()],
    };
    let told_costs: Vec<f64> =
        turns.iter().map(|turn| evidence::told_cost(*turn, problem.told, settings)).collect();
    let outline = OutlineMesh::new(problem.raw_mesh, dro.outline_cells);
    let seen = evidence::Seen::new(problem, bbox, settings);
    // One look per up direction that the extents leave possible.
    let ups: Vec<Vec<usize>> = turns::up_directions()
        .iter()
        .map(|&up| (0..turns.len()).filter(|&k| turns::raw_up(turns[k]).dot(up) > 0.5).collect())
        .collect();
    let standing = ups
        .par_iter()
        .map(|rotations| {
            let by_extent = |a: &&usize, b: &&usize| extent_costs[**a].total_cmp(&extent_costs[**b]);
            let likeliest = rotations.iter().min_by(by_extent).copied();
            likeliest
                .filter(|&k| extent_costs[k] <= least + settings.hopeless_extent_cost)
                .map(|k| Standing::new(problem, &outline, &seen, turns[k], settings, dro, interrupt))
                .transpose()
        })
        .collect::<Result<Vec<Option<Standing>>, Interrupted>>()?;
    let costs = |&k: &usize| (k, extent_costs[k], example_costs[k] + told_costs[k]);
    let candidates: Vec<Candidates> = ups
        .iter()
        .zip(&standing)
        .map(|(rotations, standing)| Candidates {
            rotations: rotations.iter().map(costs).collect(),
            least_picture_cost: standing.as_ref().map(Standing::least_cost),
        })
        .collect();
    let [best, other] = contest::best_two(&candidates, |up, matters| match &standing[up] {
        Some(standing) => standing.picture_cost(problem, &seen, settings, dro, matters, interrupt),
        None => Ok(f64::INFINITY),
    })?;
    let (rotation, cost) = (turns[best.rotation], best.cost);
    let lead = other.cost - cost;
    let turned = turns::turned_size(raw_size, rotation);
    let scale = (problem.size_m.element_product() / turned.element_product().max(1e-30)).cbrt();
    let confidence = lead / (lead + settings.clear_lead);
    Ok(CanonicalPose { rotation, scale, cost, confidence })
}

#[cfg(test)]
mod tests;
