//! A mesh generator that delegates to another and records the orientation of each mesh.
//!
//! A generated mesh has one of 24 axis-aligned orientations; a stage must find the upright rotation. To compare the
//! resulting pose with the true one, the benchmark needs the rotation between generated and true mesh. With noise,
//! meshes are built in the true size whatever size the stages estimate, and are then degraded
//! ([`super::noise::meshes`]).

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex};

use futures::FutureExt;
use glam::{DMat3, DQuat, DVec3};

use super::noise::{Noise, meshes};
use embedded::requested_pose::rendered_mesh;
use geometry::TexturedMesh;
use ports::{
    Adapter, Answer, Call, MeshGenerator, Port, ProviderError, RawMesh, RawTable, ReconstructionRequest,
    TableRequest,
};
use runtime::seed::child_seed;
use scene::{InstanceId, RecognizedObject};

/// Maximum distance between equal vertices, as a share of the mesh's longest side.
const SAME_VERTEX: f64 = 1e-3;

/// Wraps `generator`.
pub struct RecordingMeshGenerator {
    pub generator: Arc<dyn MeshGenerator>,
    /// The true objects, by id.
    pub true_objects: BTreeMap<InstanceId, RecognizedObject>,
    pub noise: Option<Noise>,
    /// Seed of the scene; each object uses a child seed.
    pub seed: u64,
    /// `raw_from_rendered` by id, recorded once the mesh was generated.
    pub raw_from_rendered: Arc<Mutex<BTreeMap<InstanceId, DQuat>>>,
}

impl MeshGenerator for RecordingMeshGenerator {
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
            let true_object = self.true_objects.get(&id).ok_or_else(|| unknown("it was not rendered"))?;
            request.object.size_m = true_object.size_m;
            let mut raw = self.generator.reconstruct(call, request).await?;
            let own = rendered_mesh(true_object).ok_or_else(|| unknown("the catalog does not build it"))?;
            let rotation = turn_between(&own, &raw.mesh)
                .ok_or_else(|| unknown("the generated mesh is not the rendered one turned"))?;
            if let Ok(mut known) = self.raw_from_rendered.lock() {
                known.insert(id.clone(), rotation);
            }
            if let Some(noise) = self.noise {
                let seed = child_seed(self.seed, id.as_str());
                let seed_of_texture = child_seed(seed, "texture");
                let other = rendered_mesh(&RecognizedObject { seed: seed_of_texture, ..true_object.clone() });
                raw.mesh = meshes::degrade(raw.mesh, other.as_ref(), &noise, seed);
            }
            Ok(raw)
        }
        .boxed()
    }

    fn table<'a>(&'a self, call: &'a Call, request: TableRequest) -> Answer<'a, RawTable> {
        self.generator.table(call, request)
    }
}

/// The axis-aligned rotation that maps the vertices of one mesh, up to uniform scale and translation, to those of
/// the other, which has the same vertices in the same order. `None` if there is none.
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
        .find(|turn| from.iter().zip(&to).all(|(a, b)| (*turn * *a - *b).abs().max_element() < SAME_VERTEX))
}

/// The 24 proper rotations that map axes to axes.
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
    use catalog::{Recipe, build};
    use embedded::orientation::randomly_oriented;

    #[test]
    fn turn_between_recovers_generated_orientation() {
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
            let raw = randomly_oriented(mesh.clone(), seed);
            let turn = turn_between(&mesh, &raw).expect("is the same mesh");
            let size = mesh.clone().rotated(turn).size_m();
            let ratio = raw.size_m() / size;
            assert!((ratio / ratio.x - DVec3::ONE).abs().max_element() < 1e-9);
        }
        let other = build(&Recipe { category: "plate".into(), ..recipe }).expect("a plate");
        assert_eq!(turn_between(&mesh, &other), None);
    }
}
