//! Upright pose of a raw mesh: the one of 24 axis-aligned rotations that matches the image.
//!
//! A generated mesh comes unit-sized in any of 24 orientations. Four kinds of evidence are added up as costs; the
//! rotation of minimum cost wins:
//!
//! - *extents*: the commonsense width, depth and height against the rotated mesh's, up to one common factor (separates
//!   lying from standing);
//! - *image*: for each of the six up directions the mesh is turned through a full circle on the instance's viewing
//!   ray; the best silhouette and its colors count (separates upside down);
//! - *example*: if a typical mesh of the category is known in the canonical frame, the similarity of the rotated
//!   mesh's volume distribution in its box (determines the front, breaks ties), and of the distribution of texture
//!   detail over the boxes (separates a cover from a back);
//! - *hints*: rotations reported by a model that saw the mesh. They break ties, and determine the front if no other
//!   evidence does; they do not outweigh an image that contradicts them.
//!
//! The four rotations that share an up direction have the same outlines, so only extents, example and hints separate
//! them. If none does (a cube without an example) the first in the list is taken, and the yaw found later is relative
//! to it. Cost: 6 x 24 small silhouettes and five to thirty 64 x 64 renderings, about 0.03 s of one core for the
//! catalog's meshes.

mod surface_samples;
mod best_two;
mod texture_detail;
mod evidence;
mod likeness;
mod settings;
mod rotations;

pub use rotations::axis_aligned;
pub use settings::UprightSettings;

use glam::{DQuat, DVec3};
use rayon::prelude::*;

use best_two::Candidates;
use evidence::UprightHypothesis;

use super::yaw::YawSettings;
use super::yaw::outline_mesh::OutlineMesh;
use geometry::{Camera, TexturedMesh};
use imaging::{Image, Mask};
use runtime::{CancelFlag, Cancelled};

/// A raw mesh and the evidence about its instance.
#[derive(Clone, Copy, Debug)]
pub struct UprightProblem<'a> {
    /// As generated: any size, any of the 24 axis-aligned orientations.
    pub raw_mesh: &'a TexturedMesh,
    pub camera: &'a Camera,
    /// Complete silhouette of the instance, as large as the camera's image.
    pub mask: &'a Mask,
    /// Image of the instance and the part of the camera's image it shows (x0, y0, x1, y1 pixels);
    /// transparent pixels do not count.
    pub image: Option<(&'a Image, [f64; 4])>,
    /// Commonsense extents as it stands: width, depth, height, meters.
    pub size_m: DVec3,
    /// A typical mesh of its kind in the canonical frame, any size.
    pub example: Option<&'a TexturedMesh>,
    /// Hints for `canonical_from_raw`, each as good as the others; empty if there are none.
    pub hints: &'a [DQuat],
}

/// The upright rotation with its confidence.
#[derive(Clone, Debug, PartialEq)]
pub struct UprightPose {
    /// `canonical_from_raw`, one of the 24.
    pub rotation: DQuat,
    /// Common scale factor that brings the rotated mesh nearest to `size_m`.
    pub scale: f64,
    /// Cost of that rotation, in units of the silhouette loss.
    pub cost: f64,
    /// Confidence 0..1: lead of the best rotation over the best one with another up direction.
    pub confidence: f64,
}

/// Reason why no rotation could be found.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum UprightError {
    #[error("standing a mesh up: it has no triangles or no extent; reconstruct it again")]
    EmptyMesh,
    #[error("standing a mesh up: the instance's mask is empty or not as large as the camera's image")]
    NoMask,
    #[error("standing a mesh up: its commonsense size is not positive; measure it again")]
    NoSize,
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

/// Finds the upright rotation of the mesh.
///
/// # Errors
///
/// [`UprightError`] if the mesh, the mask or the size is empty, or the call is cancelled.
pub fn upright(
    problem: &UprightProblem,
    settings: &UprightSettings,
    dro: &YawSettings,
    cancel: &CancelFlag,
) -> Result<UprightPose, UprightError> {
    let raw_size = problem.raw_mesh.size_m();
    if problem.raw_mesh.triangle_count() == 0 || raw_size.max_element() <= 0.0 || !raw_size.is_finite() {
        return Err(UprightError::EmptyMesh);
    }
    if !(problem.size_m.min_element() > 0.0 && problem.size_m.is_finite()) {
        return Err(UprightError::NoSize);
    }
    let camera = problem.camera;
    let fits = (problem.mask.width_px(), problem.mask.height_px()) == (camera.width_px, camera.height_px);
    let bbox = problem.mask.bbox_px().filter(|_| fits).ok_or(UprightError::NoMask)?;

    let turns = rotations::axis_aligned();
    let extent_costs: Vec<f64> =
        turns.iter().map(|t| evidence::extent_cost(raw_size, *t, problem.size_m, settings)).collect();
    let lowest = extent_costs.iter().copied().fold(f64::INFINITY, f64::min);
    let example_costs: Vec<f64> = match problem.example {
        Some(example) => {
            let shapes = likeness::costs(problem.raw_mesh, &turns, example);
            let details = texture_detail::costs(problem.raw_mesh, &turns, example);
            let weighted =
                |(shape, detail)| settings.example_weight * shape + settings.detail_weight * detail;
            shapes.into_iter().zip(details).map(weighted).collect()
        }
        None => vec![0.0; turns.len()],
    };
    let hint_costs: Vec<f64> =
        turns.iter().map(|turn| evidence::hint_cost(*turn, problem.hints, settings)).collect();
    let outline = OutlineMesh::new(problem.raw_mesh, dro.outline_cells);
    let seen = evidence::InstanceCrops::new(problem, bbox, settings);
    // One hypothesis per up direction that the extents leave possible.
    let ups: Vec<Vec<usize>> = rotations::up_directions()
        .iter()
        .map(|&up| (0..turns.len()).filter(|&k| rotations::raw_up(turns[k]).dot(up) > 0.5).collect())
        .collect();
    let standing = ups
        .par_iter()
        .map(|rotations| {
            let by_extent = |a: &&usize, b: &&usize| extent_costs[**a].total_cmp(&extent_costs[**b]);
            let likeliest = rotations.iter().min_by(by_extent).copied();
            likeliest
                .filter(|&k| extent_costs[k] <= lowest + settings.hopeless_extent_cost)
                .map(|k| UprightHypothesis::new(problem, &outline, &seen, turns[k], settings, dro, cancel))
                .transpose()
        })
        .collect::<Result<Vec<Option<UprightHypothesis>>, Cancelled>>()?;
    let costs = |&k: &usize| (k, extent_costs[k], example_costs[k] + hint_costs[k]);
    let candidates: Vec<Candidates> = ups
        .iter()
        .zip(&standing)
        .map(|(rotations, standing)| Candidates {
            rotations: rotations.iter().map(costs).collect(),
            min_image_cost: standing.as_ref().map(UprightHypothesis::min_cost),
        })
        .collect();
    let [best, other] = best_two::best_two(&candidates, |up, matters| match &standing[up] {
        Some(standing) => standing.image_cost(problem, &seen, settings, dro, matters, cancel),
        None => Ok(f64::INFINITY),
    })?;
    let (rotation, cost) = (turns[best.rotation], best.cost);
    let lead = other.cost - cost;
    let turned = rotations::turned_size(raw_size, rotation);
    let scale = (problem.size_m.element_product() / turned.element_product().max(1e-30)).cbrt();
    let confidence = lead / (lead + settings.clear_lead);
    Ok(UprightPose { rotation, scale, cost, confidence })
}

#[cfg(test)]
mod tests;
