//! Reconstruction of the true scene for yaw tests: catalog meshes in the true poses.

use std::sync::Arc;

use glam::{DQuat, DVec3};

use super::indistinguishable_yaws::{IndistinguishableYaws, RenderedScene, indistinguishable_yaws};
use catalog::build_table;
use embedded::requested_pose::rendered_mesh;
use geometry::{Camera, Pose, TexturedMesh};
use ports::{Call, Truth};
use render::RenderObject;
use runtime::CancelFlag;
use scene::Recognition;
use tabletopgen::pipeline::error::StageError;

/// The table and all objects in their true poses.
pub struct GroundTruthScene {
    camera: Camera,
    table: TexturedMesh,
    objects: Vec<(TexturedMesh, Pose)>,
}

/// A yaw query: an object and the rotation from which it is rotated.
#[derive(Clone, Copy, Debug)]
pub struct YawQuery {
    /// Index of the object.
    pub object: usize,
    /// `world_from_rendered`: the true rotation, or one in which the object stands on another side.
    pub rotation: DQuat,
}

impl GroundTruthScene {
    /// `recognition` is the generator's own, without noise.
    ///
    /// # Errors
    ///
    /// Fails if the catalog no longer builds the table or an object.
    pub fn new(recognition: &Recognition, truth: &Truth) -> Result<Self, StageError> {
        let gone = |what: &str| {
            let message = format!("evaluating: the catalog builds no {what} any more; restore it");
            StageError::permanent("not_in_catalog", message)
        };
        let table = &recognition.table;
        let top = build_table(&table.model, table.size_m, table.color, table.material.as_deref(), table.seed)
            .ok_or_else(|| gone(&table.model))?;
        let objects = recognition.objects.iter().zip(&truth.instances).map(|(object, true_one)| {
            let mesh = rendered_mesh(object).ok_or_else(|| gone(&object.category))?;
            let pose = Pose { translation_m: true_one.translation_m, rotation: true_one.rotation_xyzw };
            Ok((mesh, pose))
        });
        Ok(Self {
            camera: recognition.camera,
            table: top.mesh,
            objects: objects.collect::<Result<_, StageError>>()?,
        })
    }

    /// The scene with every material in its mean color, to find yaws that only the textures determine.
    pub fn without_textures(&self) -> Self {
        let plain = |mesh: &TexturedMesh| mesh.without_textures().unwrap_or_else(|| mesh.clone());
        let objects = self.objects.iter().map(|(mesh, pose)| (plain(mesh), *pose)).collect();
        Self { camera: self.camera, table: self.table.clone(), objects }
    }

    /// The indistinguishable yaws of each query, computed on the CPU pool.
    pub async fn indistinguishable_yaws(
        self: &Arc<Self>,
        queries: Vec<YawQuery>,
        call: &Call,
    ) -> Result<Vec<IndistinguishableYaws>, StageError> {
        let (world, cancel) = (self.clone(), call.cancel.clone());
        let compute = move || queries.iter().map(|query| world.yaws_of(query, &cancel)).collect();
        call.cpu.run(compute).await?
    }

    fn yaws_of(&self, query: &YawQuery, cancel: &CancelFlag) -> Result<IndistinguishableYaws, StageError> {
        let all = std::iter::once((&self.table, Pose::IDENTITY))
            .chain(self.objects.iter().map(|(mesh, pose)| (mesh, *pose)));
        let placed =
            all.zip(1..).map(|((mesh, world_from_object), id)| RenderObject { mesh, world_from_object, id });
        let scene = RenderedScene { camera: self.camera, objects: placed.collect() };
        Ok(indistinguishable_yaws(&scene, query.object + 1, self.start(query), cancel)?)
    }

    /// The pose with the query's rotation in which the center of the bottom of the mesh's box is at the true
    /// origin; the true pose for the true rotation.
    fn start(&self, query: &YawQuery) -> Pose {
        let (mesh, pose) = &self.objects[query.object];
        if query.rotation == pose.rotation {
            return *pose;
        }
        let turned = mesh.positions.iter().map(|p| query.rotation * *p);
        let (low, high) =
            turned.fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), p| (low.min(p), high.max(p)));
        let seat = DVec3::new(0.5 * (low.x + high.x), 0.5 * (low.y + high.y), low.z);
        Pose { translation_m: pose.translation_m - seat, rotation: query.rotation }
    }
}
