//! The ablation of the paper, at `place` and before `resolve`: how many scenes collide with a stage taken out.
//!
//! The paper replaces a removed stage by asking a language model for its numbers. Here it is replaced by the truth plus
//! noise, stated below: uniform yaws within 30 degrees for the rotation optimizer (a model names a yaw to about the
//! nearest twelfth of a turn); for the top-view alignment a place uniform in a disk of 5 cm and a size within 25 %,
//! log-uniform, per object (what common sense knows of sizes). Objects are let down onto their supporters as `place`
//! does. Collisions are those of the method ([`physics::metrics`]): on visual meshes, the table included.

use std::f64::consts::TAU;
use std::sync::Arc;

use glam::{DVec2, DVec3};
use rand::RngExt;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use geometry::Pose;
use geometry::collide::PlacedSolid;
use geometry::mesh_solid::MeshSolid;
use physics::{CertifySettings, collisions};
use runtime::seed::child_rng;
use scene::InstanceId;
use tabletopgen::pipeline::checkpoint::Stage;
use tabletopgen::pipeline::error::StageError;
use tabletopgen::pipeline::place;
use tabletopgen::pipeline::place::PlacedInstance;
use tabletopgen::pipeline::place::layout::{let_down, resized};
use tabletopgen::pipeline::{Context, carry};

/// Yaws that stand for the rotation optimizer's err by up to this, radians.
pub const YAW_NOISE_RAD: f64 = std::f64::consts::FRAC_PI_6;
/// Places that stand for the alignment's err by up to this, meters.
pub const PLACE_NOISE_M: f64 = 0.05;
/// Sizes that stand for the alignment's err by up to this factor less 1.
pub const SIZE_NOISE_SHARE: f64 = 0.25;

/// What collides in one scene under each variation.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Ablation {
    pub full: Colliding,
    pub without_dro: Colliding,
    pub without_tsa: Colliding,
    pub without_both: Colliding,
}

/// Colliding pairs of a layout.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Colliding {
    /// All pairs, the table included.
    pub pairs: usize,
    /// Names and depth in meters of those that collide.
    pub colliding: Vec<(String, String, f64)>,
}

/// Yaw, radians, that stands for the optimizer's.
pub fn guessed_yaw_rad(true_yaw_rad: f64, seed: u64, id: &InstanceId) -> f64 {
    let mut rng = child_rng(seed, &format!("ablation yaw {id}"));
    true_yaw_rad + YAW_NOISE_RAD * rng.random_range(-1.0..1.0)
}

/// Where an object stands and how much larger than it was placed, in place of what the alignment found.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Instead {
    /// World, of the origin of its frame.
    pub xy_m: DVec2,
    /// Factor on the placed size.
    pub factor: f64,
}

/// Place and size that stand for the alignment's; `placed_scale` is placed over true size.
pub fn guessed_place(true_xy_m: DVec2, placed_scale: f64, seed: u64, id: &InstanceId) -> Instead {
    let mut rng = child_rng(seed, &format!("ablation place {id}"));
    // The root spreads the points evenly over the disk.
    let radius_m = PLACE_NOISE_M * rng.random_range(0.0..1.0_f64).sqrt();
    let offset_m = radius_m * DVec2::from_angle(rng.random_range(0.0..TAU));
    let size = ((1.0 + SIZE_NOISE_SHARE).ln() * rng.random_range(-1.0..1.0_f64)).exp();
    Instead { xy_m: true_xy_m + offset_m, factor: size / placed_scale }
}

/// The stage that puts objects elsewhere.
pub const MOVE: Stage = Stage { name: "moved_layout", version: 2 };

/// A layout, and for each of its objects in order where it is to stand.
#[derive(Serialize)]
pub struct Moves {
    pub layout: place::Output,
    pub instead: Vec<Instead>,
}

/// The layout with its objects elsewhere, let down anew.
pub async fn moved(context: Context, moves: Arc<Moves>) -> Result<place::Output, StageError> {
    let mut layout = moves.layout.clone();
    for (instance, instead) in layout.instances.iter_mut().zip(&moves.instead) {
        let PlacedInstance { id, mesh, hulls, size_m, scale, world_from_object, seen_from_above, .. } =
            instance;
        let factor = DVec3::splat(instead.factor);
        (*mesh, *hulls) = resized(&context, mesh, hulls, factor, id.as_str()).await?;
        *size_m *= factor;
        *scale *= instead.factor;
        seen_from_above.center_m += instead.xy_m - world_from_object.translation_m.truncate();
        seen_from_above.extent_m *= instead.factor;
        *world_from_object =
            Pose { translation_m: instead.xy_m.extend(0.0), rotation: world_from_object.rotation };
    }
    let_down(&context, &mut layout).await?;
    Ok(layout)
}

/// The stage that looks for collisions.
pub const COLLIDE: Stage = Stage { name: "layout_collisions", version: 1 };

/// A layout and when an overlap counts.
#[derive(Serialize)]
pub struct Overlaps {
    pub layout: place::Output,
    pub certify: CertifySettings,
}

/// What collides in the layout.
pub async fn colliding(context: Context, overlaps: Arc<Overlaps>) -> Result<Colliding, StageError> {
    let layout = &overlaps.layout;
    let mut parts =
        vec![(carry::mesh(&context, &layout.table.mesh).await?, Pose::IDENTITY, "table".to_owned())];
    for instance in &layout.instances {
        let mesh = carry::mesh(&context, &instance.mesh).await?;
        parts.push((mesh, instance.world_from_object, instance.id.to_string()));
    }
    let (certify, interrupt) = (overlaps.certify.clone(), context.interrupt().clone());
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
        let found = collisions(&placed, &certify, &interrupt)?;
        let named = |k: usize| parts[k].2.clone();
        let colliding =
            found.colliding.iter().map(|pair| (named(pair.a), named(pair.b), pair.depth_m)).collect();
        Ok(Colliding { pairs: found.pairs, colliding })
    });
    found.await?
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn guesses_stay_within_what_is_stated() {
        let id = InstanceId::numbered("mug", 1);
        for seed in 0..200 {
            let yaw_rad = guessed_yaw_rad(1.0, seed, &id);
            assert!((yaw_rad - 1.0).abs() <= YAW_NOISE_RAD);
            let Instead { xy_m, factor } = guessed_place(DVec2::new(0.2, -0.1), 1.1, seed, &id);
            assert!((xy_m - DVec2::new(0.2, -0.1)).length() <= PLACE_NOISE_M);
            let size = 1.1 * factor;
            assert!((1.0 / 1.2501..1.2501).contains(&size));
        }
    }
}
