//! The painted scene built again, for looking at it: meshes of the catalog in the poses of the truth.

use std::sync::Arc;

use glam::{DQuat, DVec3};

use super::look_alikes::{LookAlikes, TrueScene, look_alikes};
use catalog::{Recipe, build, build_table};
use geometry::{Camera, Pose, TexturedMesh};
use ports::{Call, Truth};
use render::RenderObject;
use runtime::Interrupt;
use scene::{Recognition, RecognizedObject};
use tabletopgen::pipeline::error::StageError;

/// Everything that shows, where it was painted.
pub struct TrueWorld {
    camera: Camera,
    table: TexturedMesh,
    objects: Vec<(TexturedMesh, Pose)>,
}

/// One object to be turned about, and the rotation it is turned on from.
#[derive(Clone, Copy, Debug)]
pub struct Look {
    /// Index of the object.
    pub object: usize,
    /// `world_from_painted`; the true one, or one in which it stands on another side.
    pub rotation: DQuat,
}

impl TrueWorld {
    /// `recognition` is what the painter knows, unspoiled.
    pub fn new(recognition: &Recognition, truth: &Truth) -> Result<Self, StageError> {
        let gone = |what: &str| {
            let message = format!("evaluating: the catalog builds no {what} any more; restore it");
            StageError::permanent("not_in_catalog", message)
        };
        let table = &recognition.table;
        let top = build_table(&table.model, table.size_m, table.color, table.material.as_deref(), table.seed)
            .ok_or_else(|| gone(&table.model))?;
        let objects = recognition.objects.iter().zip(&truth.instances).map(|(object, true_one)| {
            let mesh = as_painted(object).ok_or_else(|| gone(&object.category))?;
            let pose = Pose { translation_m: true_one.translation_m, rotation: true_one.rotation_xyzw };
            Ok((mesh, pose))
        });
        Ok(Self {
            camera: recognition.camera,
            table: top.mesh,
            objects: objects.collect::<Result<_, StageError>>()?,
        })
    }

    /// The same with every material in its mean color: what is left to know of a yaw where the stages' meshes wear
    /// other pictures than the painted ones.
    pub fn without_pictures(&self) -> Self {
        let plain = |mesh: &TexturedMesh| mesh.without_textures().unwrap_or_else(|| mesh.clone());
        let objects = self.objects.iter().map(|(mesh, pose)| (plain(mesh), *pose)).collect();
        Self { camera: self.camera, table: self.table.clone(), objects }
    }

    /// The yaws that look the same in the true picture, for each of the looks, on the pool.
    pub async fn look(
        self: &Arc<Self>,
        looks: Vec<Look>,
        call: &Call,
    ) -> Result<Vec<LookAlikes>, StageError> {
        let (world, interrupt) = (self.clone(), call.interrupt.clone());
        let looked = move || looks.iter().map(|look| world.look_once(look, &interrupt)).collect();
        call.cpu.run(looked).await?
    }

    fn look_once(&self, look: &Look, interrupt: &Interrupt) -> Result<LookAlikes, StageError> {
        let all = std::iter::once((&self.table, Pose::IDENTITY))
            .chain(self.objects.iter().map(|(mesh, pose)| (mesh, *pose)));
        let placed =
            all.zip(1..).map(|((mesh, world_from_object), id)| RenderObject { mesh, world_from_object, id });
        let scene = TrueScene { camera: self.camera, objects: placed.collect() };
        Ok(look_alikes(&scene, look.object + 1, self.start(look), interrupt)?)
    }

    /// The pose with the look's rotation in which the bottom of the mesh's box has its center where the true pose has
    /// the object's origin; the true pose for the true rotation.
    fn start(&self, look: &Look) -> Pose {
        let (mesh, pose) = &self.objects[look.object];
        if look.rotation == pose.rotation {
            return *pose;
        }
        let turned = mesh.positions.iter().map(|p| look.rotation * *p);
        let (low, high) =
            turned.fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), p| (low.min(p), high.max(p)));
        let seat = DVec3::new(0.5 * (low.x + high.x), 0.5 * (low.y + high.y), low.z);
        Pose { translation_m: pose.translation_m - seat, rotation: look.rotation }
    }
}

fn as_painted(object: &RecognizedObject) -> Option<TexturedMesh> {
    build(&Recipe {
        category: object.category.clone(),
        size_m: object.size_m,
        color: object.color,
        material: object.material.clone(),
        seed: object.seed,
    })
}
