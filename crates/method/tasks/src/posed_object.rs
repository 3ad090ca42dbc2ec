//! Objects as predicates see them: convex hulls, mass and opening, in a pose.

use std::sync::{Arc, OnceLock};

use geometry::collision_shape::{BrokenHull, CollisionShape};
use geometry::drop_cast::PosedShape;
use geometry::{ConvexHull, Pose};
use glam::DVec3;
use scene::InstanceId;
use scene::predicates::PosedFootprint;

use crate::opening::Opening;
use crate::robot_limits::{GraspWidth, grasp_width};

/// Properties of an object that do not depend on its pose. Object frame: z up, origin at the center of the bottom.
#[derive(Clone)]
pub struct ObjectShape {
    hulls: Vec<ConvexHull>,
    collision: CollisionShape,
    opening: Option<Opening>,
    pub center_of_mass_m: DVec3,
    pub mass_kg: f64,
    /// Whether a parallel gripper can grasp it at all.
    pub is_graspable: bool,
    /// For the first opening that was asked for.
    grasp_width: OnceLock<(f64, GraspWidth)>,
}

impl ObjectShape {
    /// The shape of an object; its opening is found from the hulls ([`Opening::of_hulls`], milliseconds).
    ///
    /// # Errors
    ///
    /// [`BrokenHull`] for a hull that is no convex polyhedron.
    pub fn new(
        hulls: Vec<ConvexHull>,
        center_of_mass_m: DVec3,
        mass_kg: f64,
        is_graspable: bool,
    ) -> Result<Self, BrokenHull> {
        let collision = CollisionShape::new(&hulls)?;
        let opening = Opening::of_hulls(&hulls);
        let grasp_width = OnceLock::new();
        Ok(Self { hulls, collision, opening, center_of_mass_m, mass_kg, is_graspable, grasp_width })
    }

    /// Convex parts, object frame, meters.
    pub fn hulls(&self) -> &[ConvexHull] {
        &self.hulls
    }

    /// The hulls prepared for casts and distances.
    pub fn collision(&self) -> &CollisionShape {
        &self.collision
    }

    /// Width at which a gripper that opens to `widest_m` grasps the object: [`grasp_width`], kept for the first
    /// opening.
    pub fn grasp_width(&self, widest_m: f64) -> GraspWidth {
        let (known_m, width) = self.grasp_width.get_or_init(|| (widest_m, grasp_width(self, widest_m)));
        if *known_m == widest_m { *width } else { grasp_width(self, widest_m) }
    }

    /// The opening of a container; `None` for what holds nothing.
    pub fn opening(&self) -> Option<&Opening> {
        self.opening.as_ref()
    }
}

/// An object of a scene in a pose.
#[derive(Clone)]
pub struct PosedObject {
    pub name: InstanceId,
    pub shape: Arc<ObjectShape>,
    pub world_from_object: Pose,
    /// The footprint in the pose in which it was asked for first. Clones share it: searches for a place clone all
    /// objects for every candidate.
    footprint: Arc<OnceLock<(Pose, PosedFootprint)>>,
}

impl PosedObject {
    pub fn new(name: InstanceId, shape: Arc<ObjectShape>, world_from_object: Pose) -> Self {
        Self { name, shape, world_from_object, footprint: Arc::default() }
    }

    /// The same object in another pose.
    #[must_use]
    pub fn at(&self, world_from_object: Pose) -> Self {
        Self::new(self.name.clone(), Arc::clone(&self.shape), world_from_object)
    }

    /// In the world, meters.
    pub fn center_of_mass_m(&self) -> DVec3 {
        self.world_from_object.transform_point(self.shape.center_of_mass_m)
    }

    /// Vertical projection of the object, with its height range.
    pub fn footprint(&self) -> PosedFootprint {
        let pose = self.world_from_object;
        let here = || PosedFootprint::of_points(self.shape.collision.points(&pose), &pose);
        let (known, footprint) = self.footprint.get_or_init(|| (pose, here()));
        if *known == pose { footprint.clone() } else { here() }
    }

    /// Angle between its upright axis and the vertical, radians.
    pub fn tilt_rad(&self) -> f64 {
        self.world_from_object.transform_vector(DVec3::Z).angle_between(DVec3::Z)
    }

    /// Hulls of the object in the world, for casts and distances.
    pub fn posed_shape(&self) -> PosedShape<'_> {
        PosedShape { shape: &self.shape.collision, world_from_object: self.world_from_object }
    }
}

/// The object of a name.
pub fn find<'a>(objects: &'a [PosedObject], name: &InstanceId) -> Option<&'a PosedObject> {
    objects.iter().find(|object| &object.name == name)
}
