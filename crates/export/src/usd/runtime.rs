//! What single programs know beyond the common physics of USD: a layer each, which a prop loads only where its variant
//! set of that name is switched on. Switched off, a prop says nothing that belongs to one program.

use crate::Body;

use super::layer::{Layer, Prim, Switch};
use super::look::{LOOKS, PHYSICS_MATERIAL};
use super::prop::{COLLIDERS, hull_name};
use super::value::{Dictionary, Value};

/// A program with schemas of its own.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Runtime {
    Newton,
    MuJoCo,
    PhysX,
}

impl Runtime {
    pub const ALL: [Self; 3] = [Self::Newton, Self::MuJoCo, Self::PhysX];

    /// As SimReady calls it.
    pub fn variant_set(self) -> &'static str {
        match self {
            Self::Newton => "Newton",
            Self::MuJoCo => "MuJoCo",
            Self::PhysX => "PhysX",
        }
    }

    /// Where its layer lies, relative to the prop's.
    pub fn path(self) -> &'static str {
        match self {
            Self::Newton => "runnables/physics/newton.usda",
            Self::MuJoCo => "runnables/physics/mujoco.usda",
            Self::PhysX => "runnables/physics/physx.usda",
        }
    }

    /// The variant set that loads its layer.
    pub fn switch(self) -> Switch {
        Switch { name: self.variant_set(), payload: format!("./{}", self.path()).as_str().into() }
    }

    fn collider_schemas(self) -> &'static [&'static str] {
        match self {
            Self::Newton => &["NewtonCollisionAPI", "NewtonMeshCollisionAPI"],
            Self::MuJoCo => &["MjcCollisionAPI"],
            Self::PhysX => &["PhysxCollisionAPI", "PhysxConvexHullCollisionAPI"],
        }
    }
}

/// More about a body's prop: the program's schemas on its colliders, and how it resists rolling and spinning.
pub fn layer(body: &Body, runtime: Runtime) -> Layer {
    let mut root = Prim::over(&body.name);
    let mut colliders = Prim::over(COLLIDERS);
    for index in 0..body.hulls.len() {
        colliders.add(Prim::over(&hull_name(index)).with_schemas(runtime.collider_schemas()));
    }
    root.add(colliders);
    let mut contact = Prim::over(PHYSICS_MATERIAL);
    let (rolling, torsional) = (body.rolling_friction_m, body.torsional_friction_m);
    match runtime {
        Runtime::Newton => {
            contact.schemas = vec!["NewtonMaterialAPI"];
            contact.set("newton:rollingFriction", Value::Float(rolling as f32));
            contact.set("newton:torsionalFriction", Value::Float(torsional as f32));
        }
        Runtime::MuJoCo => {
            contact.schemas = vec!["MjcMaterialAPI"];
            contact.set_uniform("mjc:rollingfriction", Value::Double(rolling));
            contact.set_uniform("mjc:torsionalfriction", Value::Double(torsional));
        }
        // Knows neither.
        Runtime::PhysX => return Layer { custom_data: Dictionary::default(), root },
    }
    let mut looks = Prim::over(LOOKS);
    looks.add(contact);
    root.add(looks);
    Layer { custom_data: Dictionary::default(), root }
}
