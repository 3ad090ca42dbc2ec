//! The simulated world that settling and manipulation have in common: bodies as sets of hulls, with our own contacts.

use glam::DVec3;
use rapier3d_f64::geometry::NarrowPhase;
use rapier3d_f64::prelude::{
    ColliderBuilder, FrictionModel, MassProperties as RapierMass, PhysicsWorld, RigidBodyBuilder,
    RigidBodyHandle, SharedShape,
};

use crate::Body;
use crate::contacts::HullContacts;
use crate::hull_set::HullSet;
use crate::rolling::GRAVITY_M_S2;
use geometry::collision_shape::{BrokenHull, to_parry};

/// Contacts are computed anew when a pair moved by this much against each other, meters; in between the engine follows
/// the known points.
const RECYCLE_M: f64 = 1e-5;

/// Resolution of the simulation of contacts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ContactOptions {
    pub steps_per_s: f64,
    /// Solver iterations per step.
    pub solver_iterations: usize,
    /// Natural frequency of contacts, hertz; more is stiffer.
    pub contact_frequency_hz: f64,
    /// Typical size of objects, meters; scales the engine's tolerances.
    pub length_unit_m: f64,
    /// Damping of the linear and angular velocity of bodies, 1/s.
    pub damping_per_s: f64,
    /// Contacts of moving bodies are predicted up to this distance, meters.
    pub look_ahead_m: f64,
}

/// A body that cannot be simulated.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum UnfitBody {
    #[error("{name}: {source}")]
    BrokenHull { name: String, source: BrokenHull },
    #[error("the mass or inertia of {name} is not positive; compute its mass properties again")]
    BadMass { name: String },
}

impl ContactOptions {
    /// A world without bodies, in which gravity acts.
    pub fn empty_world(&self) -> PhysicsWorld {
        let mut world = PhysicsWorld::new();
        world.narrow_phase = NarrowPhase::with_query_dispatcher(HullContacts);
        world.gravity = DVec3::new(0.0, 0.0, -GRAVITY_M_S2);
        let parameters = &mut world.integration_parameters;
        parameters.dt = 1.0 / self.steps_per_s;
        parameters.num_solver_iterations = self.solver_iterations;
        parameters.length_unit = self.length_unit_m;
        parameters.contact_softness.natural_frequency = self.contact_frequency_hz;
        parameters.static_contact_softness.natural_frequency = self.contact_frequency_hz;
        parameters.friction_model = FrictionModel::Coulomb;
        // Our contacts are merged already, and fast bodies use a larger contact distance instead of sweeping.
        parameters.contact_clustering = false;
        parameters.normalized_contact_recycle_distance = RECYCLE_M / self.length_unit_m;
        parameters.max_ccd_substeps = 0;
        world
    }

    /// Inserts a body, whose collider `finish` completes. A body without hulls has no collider.
    ///
    /// # Errors
    ///
    /// [`UnfitBody`] for a flat hull, or a mass or inertia that is not positive.
    pub fn insert(
        &self,
        world: &mut PhysicsWorld,
        body: &Body,
        finish: impl FnOnce(ColliderBuilder) -> ColliderBuilder,
    ) -> Result<RigidBodyHandle, UnfitBody> {
        let hulls = HullSet::new(&body.hulls);
        if let Some(hull) = hulls.hulls.iter().position(|hull| hull.points.len() < 4 || hull.planes.len() < 4)
        {
            let source = BrokenHull { hull, points: body.hulls[hull].points.len() };
            return Err(UnfitBody::BrokenHull { name: body.name.clone(), source });
        }
        let positive = body.mass.mass_kg > 0.0 && body.mass.inertia_diagonal_kg_m2.min_element() > 0.0;
        if !body.fixed && !positive {
            return Err(UnfitBody::BadMass { name: body.name.clone() });
        }
        let builder = if body.fixed { RigidBodyBuilder::fixed() } else { RigidBodyBuilder::dynamic() };
        let rigid = builder
            .pose(to_parry(&body.world_from_object))
            .additional_mass_properties(RapierMass::with_principal_inertia_frame(
                body.mass.center_of_mass_m,
                body.mass.mass_kg,
                body.mass.inertia_diagonal_kg_m2,
                body.mass.principal_axes_xyzw,
            ))
            .linear_damping(self.damping_per_s)
            .angular_damping(self.damping_per_s)
            .soft_ccd_prediction(self.look_ahead_m)
            // Sleep would hide creeping, which the certificate measures.
            .can_sleep(false);
        let handle = world.insert_body(rigid);
        if !body.hulls.is_empty() {
            let collider = ColliderBuilder::new(SharedShape::new(hulls))
                // The mass is set above. The collider adds none, or overlapping hulls would count twice.
                .density(0.0)
                // The engine has one coefficient for sticking and sliding.
                .friction(body.friction.dynamic_coefficient)
                .restitution(body.restitution);
            world.insert_collider(finish(collider), Some(handle));
        }
        Ok(handle)
    }
}
