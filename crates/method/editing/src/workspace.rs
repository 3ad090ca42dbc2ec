//! A finished scene as the search for places sees it: convex hulls, meshes and supports, in their poses.

use std::sync::Arc;

use geometry::collision_shape::{BrokenHull, CollisionShape};
use geometry::drop_cast::PosedShape;
use geometry::solid_query::MeshSolid;
use geometry::{Outline, Pose};
use physics::Body;
use scene::predicates::PosedFootprint;
use scene::{SupportRelation, SupportTree, Supporter};

/// One object with its collision geometry.
#[derive(Clone)]
pub struct WorkspaceObject {
    /// Hulls, mass, friction, and the pose in the world.
    pub body: Body,
    pub shape: CollisionShape,
    /// The visual mesh.
    pub solid: Arc<MeshSolid>,
    pub supporter: Supporter,
    /// Whether it has a pose yet; without one it is in no other object's way.
    pub is_placed: bool,
    /// Number of turns about the vertical that show the same object in one revolution; 0 if every turn does. One unless
    /// set otherwise.
    pub symmetry_order: u32,
}

impl WorkspaceObject {
    /// An object in the pose of its body.
    ///
    /// # Errors
    ///
    /// [`BrokenHull`] for a hull that is no convex polyhedron.
    pub fn new(
        body: Body,
        solid: Arc<MeshSolid>,
        supporter: Supporter,
        is_placed: bool,
    ) -> Result<Self, BrokenHull> {
        let shape = CollisionShape::new(&body.hulls)?;
        Ok(Self { body, shape, solid, supporter, is_placed, symmetry_order: 1 })
    }

    pub(crate) fn posed(&self) -> PosedShape<'_> {
        self.posed_at(self.body.world_from_object)
    }

    pub(crate) fn posed_at(&self, world_from_object: Pose) -> PosedShape<'_> {
        PosedShape { shape: &self.shape, world_from_object }
    }

    /// Vertical projection of the object in a pose.
    pub fn footprint_at(&self, world_from_object: &Pose) -> PosedFootprint {
        PosedFootprint::of_points(self.shape.points(world_from_object), world_from_object)
    }

    /// Vertical projection of the object in its present pose.
    pub fn footprint(&self) -> PosedFootprint {
        self.footprint_at(&self.body.world_from_object)
    }
}

/// The table and the objects on it.
#[derive(Clone)]
pub struct Workspace {
    /// Edge of the table's top.
    pub outline: Outline,
    /// The table, which never moves.
    pub table: WorkspaceObject,
    pub objects: Vec<WorkspaceObject>,
}

impl Workspace {
    /// The supports of all objects.
    pub fn supports(&self) -> SupportTree {
        let supporters: Vec<Supporter> = self.objects.iter().map(|object| object.supporter).collect();
        SupportTree::without_contradictions(&supporters)
    }

    /// An object and everything that rests on or in it, by index.
    pub fn branch(&self, object: usize) -> Vec<usize> {
        self.supports().branch(object).collect()
    }

    /// Gives an object another pose; what rests on or in it keeps its pose relative to it.
    pub fn move_branch(&mut self, object: usize, world_from_object: Pose) {
        let change = world_from_object * self.objects[object].body.world_from_object.inverse();
        for member in self.branch(object) {
            let pose = &mut self.objects[member].body.world_from_object;
            *pose = change * *pose;
            pose.rotation = pose.rotation.normalize();
        }
        // Without the rounding of the product.
        self.objects[object].body.world_from_object = world_from_object;
    }

    /// Removes an object. What rested on or in it has the removed object's supporter then; their indices are returned,
    /// as they are after the removal.
    pub fn remove(&mut self, object: usize) -> Vec<usize> {
        let removed = self.objects.remove(object);
        let shifted = |index: usize| index - usize::from(index > object);
        let mut loose = Vec::new();
        for (index, other) in self.objects.iter_mut().enumerate() {
            match other.supporter.parent {
                Some(parent) if parent == object => {
                    other.supporter = Supporter {
                        parent: removed.supporter.parent.map(shifted),
                        relation: removed.supporter.relation,
                    };
                    loose.push(index);
                }
                Some(parent) => other.supporter.parent = Some(shifted(parent)),
                None => {}
            }
        }
        loose
    }

    /// The surface on which an object stands that is placed relative to another one: that of the other one, or of what
    /// contains it.
    pub(crate) fn surface_beside(&self, object: usize) -> Supporter {
        let mut supporter = self.objects[object].supporter;
        while supporter.relation == SupportRelation::In {
            let Some(parent) = supporter.parent else { return Supporter::TABLE };
            supporter = self.objects[parent].supporter;
        }
        supporter
    }
}
