//! A mesh generator that is watched: it answers as the one it stands for, and notes how each mesh came turned.
//!
//! A generated mesh comes in one of 24 orientations, and standing it up is a stage's task. To compare the pose the
//! stages arrive at with the pose that was painted, the evaluator must know how the generated mesh lies in the
//! painted one. With noise, meshes are built for the painted size whatever size the stages believe in, and are then
//! worn ([`super::noise::meshes`]).

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex};

use futures::FutureExt;
use glam::{DMat3, DQuat, DVec3};

use super::noise::{Noise, meshes};
use catalog::{Recipe, build};
use geometry::TexturedMesh;
use ports::{
    Adapter, Answer, Call, MeshGenerator, Port, ProviderError, RawMesh, RawTable, ReconstructionRequest,
};
use runtime::seed::child_seed;
use scene::{InstanceId, RecognizedObject, RecognizedTable};

/// Largest distance, as a share of the mesh's longest edge, between corners that should be the same.
const SAME_CORNER: f64 = 1e-3;

/// Wraps `generator`.
pub struct WatchedMeshes {
    pub generator: Arc<dyn MeshGenerator>,
    /// The objects as they were painted, by name.
    pub painted: BTreeMap<InstanceId, RecognizedObject>,
    pub noise: Option<Noise>,
    /// Of the scene; each object draws from a child of it.
    pub seed: u64,
    /// `raw_from_painted`, by name, once the mesh was asked for.
    pub turned: Arc<Mutex<BTreeMap<InstanceId, DQuat>>>,
}

impl MeshGenerator for WatchedMeshes {
    fn adapter(&self) -> Adapter {
        let inner = self.generator.adapter();
        Adapter::new("evaluate/watched", &inner.model, &(inner.settings, self.noise, self.seed))
    }

    fn reconstruct<'a>(&'a self, call: &'a Call, mut request: ReconstructionRequest) -> Answer<'a, RawMesh> {
        async move {
            let id = request.object.id.clone();
            let unknown = |what: &str| ProviderError::Rejected {
                port: Port::MeshGenerator,
                code: "not_watched",
                reason: format!("evaluating {id}: {what}"),
            };
            let painted = self.painted.get(&id).ok_or_else(|| unknown("it was not painted"))?;
            request.object.size_m = painted.size_m;
            let mut raw = self.generator.reconstruct(call, request).await?;
            let recipe = Recipe {
                category: painted.category.clone(),
                size_m: painted.size_m,
                color: painted.color,
                material: painted.material.clone(),
                seed: painted.seed,
            };
            let own = build(&recipe).ok_or_else(|| unknown("the catalog does not build it"))?;
            let turned = turn_between(&own, &raw.mesh)
                .ok_or_else(|| unknown("the generated mesh is not the painted one turned"))?;
            if let Ok(mut known) = self.turned.lock() {
                known.insert(id.clone(), turned);
            }
            if let Some(noise) = self.noise {
                let seed = child_seed(self.seed, id.as_str());
                let other = build(&Recipe { seed: child_seed(seed, "texture"), ..recipe });
                raw.mesh = meshes::worn(raw.mesh, other.as_ref(), &noise, seed);
            }
            Ok(raw)
        }
        .boxed()
    }

    fn table<'a>(&'a self, call: &'a Call, table: RecognizedTable) -> Answer<'a, RawTable> {
        self.generator.table(call, table)
    }
}

/// The axis-aligned rotation that takes the corners of one mesh, up to a common scale and a shift, to those of the
/// other, which has the same corners in the same order; `None` if none does.
fn turn_between(from: &TexturedMesh, to: &TexturedMesh) -> Option<DQuat> {
    if from.positions.is_empty() || from.positions.len() != to.positions.len() {
        return None;
    }
    let unit = |mesh: &TexturedMesh| {
        let (low, high) = mesh.bounds();
        let longest = (high - low).max_element().max(1e-12);
        mesh.positions.iter().map(|p| (*p - 0.5 * (low + high)) / longest).collect::<Vec<DVec3>>()
    };
    let (from, to) = (unit(from), unit(to));
    axis_aligned()
        .into_iter()
        .find(|turn| from.iter().zip(&to).all(|(a, b)| (*turn * *a - *b).abs().max_element() < SAME_CORNER))
}

/// The 24 proper rotations that take axes to axes.
fn axis_aligned() -> Vec<DQuat> {
    let axes = [DVec3::X, DVec3::Y, DVec3::Z, -DVec3::X, -DVec3::Y, -DVec3::Z];
    axes.into_iter()
        .flat_map(|x| axes.into_iter().filter(move |y| y.dot(x).abs() < 0.5).map(move |y| (x, y)))
        .map(|(x, y)| DQuat::from_mat3(&DMat3::from_cols(x, y, x.cross(y))).normalize())
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use embedded::orientation::turned;

    #[test]
    fn the_orientation_a_mesh_came_in_is_found_again() {
        assert_eq!(axis_aligned().len(), 24);
        let recipe = Recipe {
            category: "mug".into(),
            size_m: DVec3::new(0.11, 0.08, 0.1),
            color: None,
            material: None,
            seed: 3,
        };
        let mesh = build(&recipe).expect("a mug");
        for seed in 0..40 {
            let raw = turned(mesh.clone(), seed);
            let turn = turn_between(&mesh, &raw).expect("is the same mesh");
            let size = mesh.clone().rotated(turn).size_m();
            let ratio = raw.size_m() / size;
            assert!((ratio / ratio.x - DVec3::ONE).abs().max_element() < 1e-9);
        }
        let other = build(&Recipe { category: "plate".into(), ..recipe }).expect("a plate");
        assert_eq!(turn_between(&mesh, &other), None);
    }
}
