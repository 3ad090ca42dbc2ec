//! A finished scene as tasks see it: shapes for predicates and places, descriptions for references.

use std::sync::{Arc, OnceLock};

use editing::{EditableObject, Workspace, WorkspaceObject};
use geometry::collision_shape::BrokenHull;
use geometry::drop_cast::floor_hull;
use geometry::shells::Shell;
use geometry::solid_query::{MeshSolid, SolidError};
use geometry::{ConvexHull, Friction, MassProperties, Outline, Pose, Rgb};
use glam::{DQuat, DVec3};
use physics::Body;
use scene::{InstanceId, Scene, SupportTree, Supporter};

use crate::evaluation::Situation;
use crate::goal::Goal;
use crate::posed_object::{ObjectShape, PosedObject};

/// Properties of an object that `scene.json` does not have.
#[derive(Clone)]
pub struct ObjectAppearance {
    pub shape: Arc<ObjectShape>,
    /// The color that covers most of its surface.
    pub color: Option<Rgb>,
    pub material: Option<String>,
}

/// The objects of a finished scene, in the order of `scene.json`, and the edge of its table. World frame.
#[derive(Clone)]
pub struct TaskScene {
    pub table: Outline,
    posed: Vec<PosedObject>,
    described: Vec<EditableObject>,
    /// Prepared by the first search.
    workspace: OnceLock<Workspace>,
}

/// Reason why a scene and shapes do not belong together.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum SceneFault {
    #[error(
        "the scene has {objects} objects, but {shapes} shapes are given; give one for each object, in its order"
    )]
    Count { objects: usize, shapes: usize },
    #[error("the supports of the scene form no tree")]
    Supports,
    #[error("{object} has a broken hull ({error})")]
    Hull { object: InstanceId, error: BrokenHull },
    #[error("{object} has no solid hull ({error})")]
    Solid { object: InstanceId, error: SolidError },
}

impl TaskScene {
    /// A finished scene with the shape and appearance of each instance, in its order.
    ///
    /// # Errors
    ///
    /// [`SceneFault`] for another number of shapes than instances, or a scene whose supports form no tree.
    pub fn of_scene(scene: &Scene, appearances: &[ObjectAppearance]) -> Result<Self, SceneFault> {
        if scene.instances.len() != appearances.len() {
            return Err(SceneFault::Count { objects: scene.instances.len(), shapes: appearances.len() });
        }
        let tree = scene.support_tree().map_err(|_| SceneFault::Supports)?;
        let objects =
            scene.instances.iter().zip(appearances).enumerate().map(|(index, (instance, appearance))| {
                let shape = Arc::clone(&appearance.shape);
                let posed = PosedObject::new(instance.name.clone(), shape, instance.world_from_object);
                let described = EditableObject {
                    name: instance.name.clone(),
                    label: instance.label.clone(),
                    category: instance.category.clone(),
                    stand_in: instance.stand_in.is_some(),
                    color: appearance.color,
                    material: appearance.material.clone(),
                    size_m: instance.size_m,
                    footprint: posed.footprint(),
                    supporter: tree.supporter(index),
                };
                (posed, described)
            });
        let (posed, described) = objects.unzip();
        Ok(Self { table: scene.table.outline_m.clone(), posed, described, workspace: OnceLock::new() })
    }

    /// Objects with their descriptions, in the same order; the names of both are equal.
    ///
    /// # Errors
    ///
    /// [`SceneFault::Count`] for lists of different lengths.
    pub fn new(
        table: Outline,
        posed: Vec<PosedObject>,
        described: Vec<EditableObject>,
    ) -> Result<Self, SceneFault> {
        let count = SceneFault::Count { objects: described.len(), shapes: posed.len() };
        let fits = posed.len() == described.len();
        if fits { Ok(Self { table, posed, described, workspace: OnceLock::new() }) } else { Err(count) }
    }

    pub fn posed(&self) -> &[PosedObject] {
        &self.posed
    }

    /// The objects as references see them.
    pub fn described(&self) -> &[EditableObject] {
        &self.described
    }

    /// Index of the object of a name.
    pub fn index_of(&self, name: &InstanceId) -> Option<usize> {
        self.posed.iter().position(|object| &object.name == name)
    }

    /// Support tree of the objects.
    pub fn supports(&self) -> SupportTree {
        let supporters: Vec<Supporter> = self.described.iter().map(|object| object.supporter).collect();
        SupportTree::without_contradictions(&supporters)
    }

    /// Objects that rest on or in the objects that a goal moves, directly or through others, and move with them.
    pub fn carried(&self, goal: &Goal) -> Vec<InstanceId> {
        let (supports, moved) = (self.supports(), goal.moved_objects());
        let branches =
            moved.iter().filter_map(|name| self.index_of(name)).flat_map(|object| supports.branch(object));
        let names = branches.map(|member| self.posed[member].name.clone());
        names.filter(|name| !moved.contains(&name)).collect()
    }

    /// The scene before anything has moved.
    pub fn situation(&self) -> Situation<'_> {
        Situation { table: &self.table, start: &self.posed, now: &self.posed, contacts: &[] }
    }

    /// The scene as the search for free places sees it. Its masses and solids are those of single hulls: the search
    /// does not use them, and nothing may come to rest in it.
    ///
    /// # Errors
    ///
    /// [`SceneFault`] for an object without a usable hull.
    pub fn workspace(&self) -> Result<Workspace, SceneFault> {
        if let Some(prepared) = self.workspace.get() {
            return Ok(prepared.clone());
        }
        let prepared = self.prepared()?;
        Ok(self.workspace.get_or_init(|| prepared).clone())
    }

    fn prepared(&self) -> Result<Workspace, SceneFault> {
        let floor = [floor_hull(5.0, 0.05)];
        let table_name = InstanceId::numbered("table", 0);
        let table = searched(&table_name, &floor, 10.0, Pose::IDENTITY, Supporter::TABLE)?;
        let objects = self.posed.iter().zip(&self.described).map(|(posed, described)| {
            let (hulls, mass_kg) = (posed.shape.hulls(), posed.shape.mass_kg);
            searched(&posed.name, hulls, mass_kg, posed.world_from_object, described.supporter)
        });
        Ok(Workspace { outline: self.table.clone(), table, objects: objects.collect::<Result<_, _>>()? })
    }
}

fn searched(
    name: &InstanceId,
    hulls: &[ConvexHull],
    mass_kg: f64,
    world_from_object: Pose,
    supporter: Supporter,
) -> Result<WorkspaceObject, SceneFault> {
    let shells: Vec<Shell> = hulls
        .first()
        .map(|hull| Shell { points: hull.points.clone(), triangles: hull.triangles.clone() })
        .into_iter()
        .collect();
    let solid =
        MeshSolid::from_shells(&shells).map_err(|error| SceneFault::Solid { object: name.clone(), error })?;
    let mass = MassProperties {
        mass_kg,
        center_of_mass_m: DVec3::ZERO,
        inertia_diagonal_kg_m2: DVec3::ONE,
        principal_axes_xyzw: DQuat::IDENTITY,
    };
    let body = Body {
        name: name.to_string(),
        hulls: hulls.to_vec(),
        world_from_object,
        mass,
        friction: Friction { static_coefficient: 0.5, dynamic_coefficient: 0.5 },
        restitution: 0.0,
        rolling_friction_m: 0.0,
        fixed: false,
    };
    WorkspaceObject::new(body, Arc::new(solid), supporter, true)
        .map_err(|error| SceneFault::Hull { object: name.clone(), error })
}
