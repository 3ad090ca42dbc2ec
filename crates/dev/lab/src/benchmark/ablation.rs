//! Ablation of the paper, at `place` and before `resolve`: share of scenes with collisions when a stage is removed.
//!
//! The paper replaces a removed stage by numbers from a language model. Here it is replaced by the truth plus
//! noise: uniform yaw errors within 30 degrees for the rotation optimizer (a model names a yaw to about the nearest
//! twelfth of a turn); for the top-view alignment, a position uniform in a disk of 5 cm and a log-uniform size
//! within 25 %, per object (the precision of commonsense sizes). Objects are lowered onto their supports as in
//! `place`. Collisions follow the method ([`physics::metrics`]): on visual meshes, the table included.

use std::f64::consts::TAU;
use std::sync::Arc;

use glam::{DVec2, DVec3};
use rand::RngExt;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use geometry::Pose;
use geometry::collide::PlacedSolid;
use geometry::solid_query::MeshSolid;
use physics::{CertifySettings, collisions};
use runtime::seed::child_rng;
use scene::InstanceId;
use tabletopgen::pipeline::checkpoint::Stage;
use tabletopgen::pipeline::error::StageError;
use tabletopgen::pipeline::place;
use tabletopgen::pipeline::place::PlacedInstance;
use tabletopgen::pipeline::place::layout::{let_down, resized};
use tabletopgen::pipeline::{Context, artifact_io};

/// Maximum error of the yaws that replace the rotation optimizer's, radians.
pub const YAW_NOISE_RAD: f64 = std::f64::consts::FRAC_PI_6;
/// Maximum error of the positions that replace the alignment's, meters.
pub const PLACE_NOISE_M: f64 = 0.05;
/// Maximum size error of the replacement: factor minus 1.
pub const SIZE_NOISE_SHARE: f64 = 0.25;

/// Collisions of one scene under each variation.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Ablation {
    pub full: Collisions,
    pub without_dro: Collisions,
    pub without_tsa: Collisions,
    pub without_both: Collisions,
}

/// Colliding pairs of a layout.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Collisions {
    /// Number of all pairs, the table included.
    pub pairs: usize,
    /// Names and penetration depth in meters of the colliding pairs.
    pub colliding: Vec<(String, String, f64)>,
}

/// Replacement yaw, radians.
pub fn guessed_yaw_rad(true_yaw_rad: f64, seed: u64, id: &InstanceId) -> f64 {
    let mut rng = child_rng(seed, &format!("ablation yaw {id}"));
    true_yaw_rad + YAW_NOISE_RAD * rng.random_range(-1.0..1.0)
}

/// Replacement of an aligned position and size.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Replacement {
    /// Position of the frame origin, world frame.
    pub xy_m: DVec2,
    /// Factor on the placed size.
    pub factor: f64,
}

/// Replacement position and size; `placed_scale` is placed over true size.
pub fn guessed_place(true_xy_m: DVec2, placed_scale: f64, seed: u64, id: &InstanceId) -> Replacement {
    let mut rng = child_rng(seed, &format!("ablation place {id}"));
    // The square root makes the points uniform in the disk.
    let radius_m = PLACE_NOISE_M * rng.random_range(0.0..1.0_f64).sqrt();
    let offset_m = radius_m * DVec2::from_angle(rng.random_range(0.0..TAU));
    let size = ((1.0 + SIZE_NOISE_SHARE).ln() * rng.random_range(-1.0..1.0_f64)).exp();
    Replacement { xy_m: true_xy_m + offset_m, factor: size / placed_scale }
}

/// Stage that moves objects.
pub const MOVE: Stage = Stage { name: "moved_layout", version: 2 };

/// A layout and the replacement of each of its objects, in order.
#[derive(Serialize)]
pub struct Moves {
    pub layout: place::Output,
    pub replacements: Vec<Replacement>,
}

/// The layout with moved objects, lowered onto their supports again.
pub async fn moved(context: Context, moves: Arc<Moves>) -> Result<place::Output, StageError> {
    let mut layout = moves.layout.clone();
    for (instance, replacement) in layout.instances.iter_mut().zip(&moves.replacements) {
        let PlacedInstance { id, mesh, hulls, size_m, scale, world_from_object, seen_from_above, .. } =
            instance;
        let factor = DVec3::splat(replacement.factor);
        (*mesh, *hulls) = resized(&context, mesh, hulls, factor, id.as_str()).await?;
        *size_m *= factor;
        *scale *= replacement.factor;
        seen_from_above.center_m += replacement.xy_m - world_from_object.translation_m.truncate();
        seen_from_above.extent_m *= replacement.factor;
        *world_from_object =
            Pose { translation_m: replacement.xy_m.extend(0.0), rotation: world_from_object.rotation };
    }
    let_down(&context, &mut layout).await?;
    Ok(layout)
}

/// Stage that detects collisions.
pub const COLLIDE: Stage = Stage { name: "layout_collisions", version: 1 };

/// A layout and the collision thresholds.
#[derive(Serialize)]
pub struct Overlaps {
    pub layout: place::Output,
    pub certify: CertifySettings,
}

/// Collisions of the layout.
pub async fn colliding(context: Context, overlaps: Arc<Overlaps>) -> Result<Collisions, StageError> {
    let layout = &overlaps.layout;
    let mut parts =
        vec![(artifact_io::mesh(&context, &layout.table.mesh).await?, Pose::IDENTITY, "table".to_owned())];
    for instance in &layout.instances {
        let mesh = artifact_io::mesh(&context, &instance.mesh).await?;
        parts.push((mesh, instance.world_from_object, instance.id.to_string()));
    }
    let (certify, cancel) = (overlaps.certify.clone(), context.cancel().clone());
    let found = context.cpu(move || {
        let solids: Vec<MeshSolid> = parts
            .par_iter()
            .map(|(mesh, _, name)| {
                MeshSolid::new(mesh).map_err(|error| {
                    StageError::permanent("no_solid", format!("looking for collisions of {name}: {error}"))
                })
            })
            .collect::<Result<_, StageError>>()?;
        let placed: Vec<PlacedSolid> = solids
            .iter()
            .zip(&parts)
            .map(|(solid, (_, world_from_object, _))| PlacedSolid {
                solid,
                world_from_object: *world_from_object,
            })
            .collect();
        let found = collisions(&placed, &certify, &cancel)?;
        let named = |k: usize| parts[k].2.clone();
        let colliding =
            found.colliding.iter().map(|pair| (named(pair.a), named(pair.b), pair.depth_m)).collect();
        Ok(Collisions { pairs: found.pairs, colliding })
    });
    found.await?
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn replacements_stay_within_stated_noise() {
        let id = InstanceId::numbered("mug", 1);
        for seed in 0..200 {
            let yaw_rad = guessed_yaw_rad(1.0, seed, &id);
            assert!((yaw_rad - 1.0).abs() <= YAW_NOISE_RAD);
            let Replacement { xy_m, factor } = guessed_place(DVec2::new(0.2, -0.1), 1.1, seed, &id);
            assert!((xy_m - DVec2::new(0.2, -0.1)).length() <= PLACE_NOISE_M);
            let size = 1.1 * factor;
            assert!((1.0 / 1.2501..1.2501).contains(&size));
        }
    }
}
