//! Physics schemas of single simulators beyond UsdPhysics: one layer per simulator. A prop loads the layer only where
//! the variant set of that name is `Enabled`; otherwise it contains no schema of a single simulator. Newton's layer
//! says that contacts begin where shapes touch.

use crate::Body;

use super::layer::{Layer, Prim, VariantSet};
use super::prim_names::{COLLIDERS, MATERIALS, PHYSICS_MATERIAL, hull_name};
use super::value::{Dictionary, Value};

/// A simulator with schemas of its own.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Simulator {
    Newton,
    MuJoCo,
    PhysX,
}

impl Simulator {
    pub const ALL: [Self; 3] = [Self::Newton, Self::MuJoCo, Self::PhysX];

    /// Name of its variant set, as in SimReady.
    pub fn variant_set_name(self) -> &'static str {
        match self {
            Self::Newton => "Newton",
            Self::MuJoCo => "MuJoCo",
            Self::PhysX => "PhysX",
        }
    }

    /// Path of its layer, relative to the prop's layer.
    pub fn path(self) -> &'static str {
        match self {
            Self::Newton => "runnables/physics/newton.usda",
            Self::MuJoCo => "runnables/physics/mujoco.usda",
            Self::PhysX => "runnables/physics/physx.usda",
        }
    }

    /// The variant set that loads its layer.
    pub fn variant_set(self) -> VariantSet {
        VariantSet { name: self.variant_set_name(), payload: format!("./{}", self.path()).as_str().into() }
    }

    /// Schemas of a collider that is a mesh or a simple solid.
    fn collider_schemas(self, is_mesh: bool) -> &'static [&'static str] {
        match (self, is_mesh) {
            (Self::Newton, true) => &["NewtonCollisionAPI", "NewtonMeshCollisionAPI"],
            (Self::Newton, false) => &["NewtonCollisionAPI"],
            (Self::MuJoCo, _) => &["MjcCollisionAPI"],
            (Self::PhysX, true) => &["PhysxCollisionAPI", "PhysxConvexHullCollisionAPI"],
            (Self::PhysX, false) => &["PhysxCollisionAPI"],
        }
    }
}

/// The overrides on a body's prop: the simulator's schemas on its colliders, and rolling and torsional friction.
pub fn layer(body: &Body, simulator: Simulator) -> Layer {
    let mut root = Prim::over(&body.name);
    let mut colliders = Prim::over(COLLIDERS);
    for (index, solid) in body.solids.iter().enumerate() {
        let schemas = simulator.collider_schemas(solid.is_none());
        let mut collider = Prim::over(&hull_name(index)).with_schemas(schemas);
        if simulator == Simulator::Newton {
            // Its default of 0.1 m makes a contact of everything within 20 cm, and cups tip over.
            collider.set("newton:contactGap", Value::Float(0.0));
        }
        colliders.add(collider);
    }
    root.add(colliders);
    let mut contact = Prim::over(PHYSICS_MATERIAL);
    let (rolling, torsional) = (body.rolling_friction_m, body.torsional_friction_m);
    match simulator {
        Simulator::Newton => {
            contact.schemas = vec!["NewtonMaterialAPI"];
            contact.set("newton:rollingFriction", Value::Float(rolling as f32));
            contact.set("newton:torsionalFriction", Value::Float(torsional as f32));
        }
        Simulator::MuJoCo => {
            contact.schemas = vec!["MjcMaterialAPI"];
            contact.set_uniform("mjc:rollingfriction", Value::Double(rolling));
            contact.set_uniform("mjc:torsionalfriction", Value::Double(torsional));
        }
        // PhysX has neither coefficient.
        Simulator::PhysX => return Layer { custom_data: Dictionary::default(), root },
    }
    let mut materials = Prim::over(MATERIALS);
    materials.add(contact);
    root.add(materials);
    Layer { custom_data: Dictionary::default(), root }
}
