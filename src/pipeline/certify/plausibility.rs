//! Is each body an object that can be? Size, density and friction within what is found on tables, a closed
//! mesh, hulls that cover it and do not stick out.
//!
//! A wrong unit shows here: a mug of 80 m was given in millimeters and stops the scene; one of 2,300,000 kg/m^3 was
//! weighed in grams and quarantines it.

use glam::DVec3;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::Inputs;
use crate::pipeline::composition::BodyParts;
use crate::pipeline::error::StageError;
use crate::pipeline::resolve::Loaded;
use certificate::{BodyHealth, HealthThresholds, Reason, ReasonCode};
use geometry::convex_hull::{FlatPlanes, planes};
use geometry::{ConvexHull, Friction, TexturedMesh};

/// Section `[health]`.
#[derive(Clone, Debug, Serialize, Deserialize, PartialEq)]
#[serde(deny_unknown_fields)]
pub struct HealthSettings {
    /// A hull may stick out of the visual mesh by this, meters.
    pub hull_excess_m: f64,
    /// A corner of the visual mesh may lie outside all hulls by this, meters.
    pub uncovered_m: f64,
    /// Maximum of that distance as a share of the body's longest side, where this is more, 0..1.
    pub uncovered_share: f64,
    /// Hulls must leave at least this share of the mesh's openings open, 0..1.
    pub min_open_share: f64,
    /// The longest side of a body is at least this, meters.
    pub min_side_m: f64,
    /// The longest side of a body is at most this, meters.
    pub max_side_m: f64,
    /// Mass over the volume that the mesh encloses is at least this, kg/m^3; hollow objects are drawn solid.
    pub min_density_kg_m3: f64,
    /// Mass over the volume is at most this, kg/m^3.
    pub max_density_kg_m3: f64,
    /// Largest coefficient of static friction.
    pub max_friction: f64,
}

impl HealthSettings {
    pub(crate) fn thresholds(&self) -> HealthThresholds {
        HealthThresholds {
            hull_excess_m: self.hull_excess_m,
            uncovered_m: self.uncovered_m,
            uncovered_share: self.uncovered_share,
            open_share: self.min_open_share,
            longest_side_m: [self.min_side_m, self.max_side_m],
            density_kg_m3: [self.min_density_kg_m3, self.max_density_kg_m3],
            friction: self.max_friction,
        }
    }
}

/// Nothing can be measured, a millimeter at a time, of what is a thousand times too large.
pub(super) fn check_size(name: &str, mesh: &TexturedMesh, limits: &HealthSettings) -> Result<(), StageError> {
    let side_m = mesh.size_m().max_element();
    if (limits.min_side_m..=limits.max_side_m).contains(&side_m) {
        return Ok(());
    }
    let (lowest, highest) = (limits.min_side_m, limits.max_side_m);
    let message = format!(
        "certifying {name}: it is {side_m} m long, outside {lowest} to {highest} m; is its unit the meter?"
    );
    Err(StageError::permanent("implausible_size", message))
}

/// Most corners of a mesh that are tested for cover; larger meshes are sampled in even steps.
const MAX_CORNERS: usize = 20_000;

/// Every body, the table first.
pub(super) fn health(inputs: &Inputs, loaded: &[Loaded]) -> Vec<BodyHealth> {
    let of = |(body, geometry): (&BodyParts, &Loaded)| {
        let (mass_kg, volume_m3) = (body.resolved.physical.mass.mass_kg, enclosed_m3(&geometry.mesh));
        BodyHealth {
            name: body.resolved.name.clone(),
            watertight: geometry.solid.is_watertight(),
            triangles: geometry.mesh.triangle_count(),
            size_m: geometry.mesh.size_m().to_array(),
            volume_m3,
            mass_kg,
            density_kg_m3: mass_kg / volume_m3,
            hulls: geometry.hulls.len(),
            hull_corners: geometry.hulls.iter().map(|hull| hull.points.len()).max().unwrap_or(0),
            hull_volume_m3: geometry.hulls.iter().map(ConvexHull::volume_m3).sum(),
            hull_excess_m: body.hull_excess_m,
            uncovered_m: uncovered_m(&geometry.mesh, &geometry.hulls),
            hull_fit: body.hull_fit,
            repair: body.repair,
        }
    };
    inputs.composition.bodies.par_iter().zip(loaded).map(of).collect()
}

/// Reasons why a body cannot exist as it is described.
pub(super) fn reasons(found: &BodyHealth, friction: &Friction, limits: &HealthSettings) -> Vec<Reason> {
    let name = &found.name;
    let mut reasons = Vec::new();
    let mut reason = |code, sentence| reasons.push(Reason { code, bodies: vec![name.clone()], sentence });
    let mm = |meters: f64| 1e3 * meters;
    if !found.watertight {
        reason(ReasonCode::OpenMesh, format!("the mesh of {name} is not watertight"));
    }
    // An open mesh encloses nothing that could be weighed.
    if found.watertight
        && !(limits.min_density_kg_m3..=limits.max_density_kg_m3).contains(&found.density_kg_m3)
    {
        let sentence = format!(
            "{name} has {:.3} kg/m³, which is outside {} to {} kg/m³: is its unit the kilogram?",
            found.density_kg_m3, limits.min_density_kg_m3, limits.max_density_kg_m3
        );
        reason(ReasonCode::ImplausibleDensity, sentence);
    }
    if found.uncovered_m.is_nan() || found.uncovered_m > limits.thresholds().max_uncovered_m(found.size_m) {
        let sentence = format!("{name} has a part {:.1} mm outside all of its hulls", mm(found.uncovered_m));
        reason(ReasonCode::MissingCollider, sentence);
    }
    if found.hull_excess_m.is_nan() || found.hull_excess_m > limits.hull_excess_m {
        let sentence =
            format!("a hull of {name} sticks out of its mesh by {:.1} mm", mm(found.hull_excess_m));
        reason(ReasonCode::ProtrudingCollider, sentence);
    }
    let open_share = found.hull_fit.open_share;
    if open_share.is_nan() || open_share < limits.min_open_share {
        let percent = |share: f64| 100.0 * share;
        let sentence = format!(
            "the hulls of {name} leave {:.0} % of its openings open, at least {:.0} % is asked",
            percent(open_share),
            percent(limits.min_open_share)
        );
        reason(ReasonCode::ClosedOpening, sentence);
    }
    let Friction { static_coefficient, dynamic_coefficient } = *friction;
    let holds = dynamic_coefficient >= 0.0
        && dynamic_coefficient <= static_coefficient
        && static_coefficient <= limits.max_friction;
    if !holds {
        let sentence = format!(
            "{name} has a static friction of {static_coefficient} and a dynamic one of {dynamic_coefficient}; \
             0 <= dynamic <= static <= {} is asked",
            limits.max_friction
        );
        reason(ReasonCode::ImplausibleFriction, sentence);
    }
    reasons
}

/// Signed volume between the faces and the center of the mesh.
fn enclosed_m3(mesh: &TexturedMesh) -> f64 {
    let (low, high) = mesh.bounds();
    let center = 0.5 * (low + high);
    mesh.triangles()
        .map(|t| {
            let [a, b, c] = t.map(|v| mesh.positions[v as usize] - center);
            a.dot(b.cross(c)) / 6.0
        })
        .sum()
}

/// Largest distance of a corner of the mesh outside the nearest hull, to the planes of its faces.
pub(crate) fn uncovered_m(mesh: &TexturedMesh, hulls: &[ConvexHull]) -> f64 {
    let planes: Vec<FlatPlanes> = hulls.iter().map(|hull| FlatPlanes::of(&supporting_planes(hull))).collect();
    let step = mesh.positions.len().div_ceil(MAX_CORNERS).max(1);
    // The hull that has a corner most likely has the next one.
    let (mut farthest_m, mut last) = (0.0, 0);
    for &corner in mesh.positions.iter().step_by(step) {
        let mut nearest_m = f64::INFINITY;
        for k in (last..planes.len()).chain(0..last) {
            nearest_m = planes[k].distance_above(corner).min(nearest_m);
            if nearest_m <= farthest_m {
                last = k;
                break;
            }
        }
        farthest_m = nearest_m.max(farthest_m);
    }
    farthest_m
}

/// The planes of a hull's faces, moved out to its farthest corner: the normal of a sliver may be off, and still
/// nothing of the hull lies above.
fn supporting_planes(hull: &ConvexHull) -> Vec<(DVec3, f64)> {
    let farthest =
        |normal: DVec3| hull.points.iter().map(|p| normal.dot(*p)).fold(f64::NEG_INFINITY, f64::max);
    planes(hull).into_iter().map(|(normal, _)| (normal, farthest(normal))).collect()
}
