//! The scene of a task: a table and objects, as the simulation and the predicates see them.

use std::sync::Arc;

use geometry::collision_shape::{BrokenHull, CollisionShape};
use geometry::drop_cast::PosedShape;
use geometry::{Outline, Pose};
use physics::Body;
use scene::InstanceId;
use tasks::{ObjectShape, PosedObject};

/// A table with objects on it; the top is at z = 0.
#[derive(Clone, Debug)]
pub struct TaskScene {
    /// Fixed; its hulls reach up to z = 0.
    pub table: Body,
    /// The edge of the top.
    pub outline: Outline,
    /// The names are those of the task.
    pub objects: Vec<Body>,
}

/// The objects of a scene as predicates see them.
#[derive(Clone)]
pub(crate) struct Shapes {
    pub names: Vec<InstanceId>,
    pub shapes: Vec<Arc<ObjectShape>>,
    pub table: Arc<CollisionShape>,
}

/// An object that predicates cannot see.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SceneError {
    #[error("{name} is no name of an object")]
    Name { name: String },
    #[error("{name}: {source}")]
    BrokenHull { name: String, source: BrokenHull },
}

impl TaskScene {
    /// The index of an object.
    pub fn index(&self, name: &str) -> Option<usize> {
        self.objects.iter().position(|object| object.name == name)
    }

    /// The poses in which the scene begins.
    pub fn poses(&self) -> Vec<Pose> {
        self.objects.iter().map(|object| object.world_from_object).collect()
    }

    /// The table first, then the objects: the order of the simulation.
    pub(crate) fn bodies(&self) -> Vec<Body> {
        std::iter::once(&self.table).chain(&self.objects).cloned().collect()
    }
}

impl Shapes {
    pub fn new(scene: &TaskScene) -> Result<Self, SceneError> {
        let broken = |name: &str| {
            let name = name.to_owned();
            move |source| SceneError::BrokenHull { name, source }
        };
        let names = scene.objects.iter().map(|object| {
            InstanceId::new(&object.name).map_err(|_| SceneError::Name { name: object.name.clone() })
        });
        let shapes = scene.objects.iter().map(|object| {
            let (center_m, mass_kg) = (object.mass.center_of_mass_m, object.mass.mass_kg);
            let shape = ObjectShape::new(object.hulls.clone(), center_m, mass_kg, !object.fixed);
            shape.map(Arc::new).map_err(broken(&object.name))
        });
        let table = CollisionShape::new(&scene.table.hulls).map_err(broken(&scene.table.name))?;
        Ok(Self {
            names: names.collect::<Result<_, _>>()?,
            shapes: shapes.collect::<Result<_, _>>()?,
            table: Arc::new(table),
        })
    }

    /// The objects in given poses.
    pub fn posed(&self, poses: &[Pose]) -> Vec<PosedObject> {
        let objects = self.names.iter().zip(&self.shapes).zip(poses);
        objects
            .map(|((name, shape), pose)| PosedObject::new(name.clone(), Arc::clone(shape), *pose))
            .collect()
    }

    /// The table, for casts and distances.
    pub fn posed_table<'a>(&'a self, scene: &TaskScene) -> PosedShape<'a> {
        PosedShape { shape: &self.table, world_from_object: scene.table.world_from_object }
    }
}
