//! Physical materials: density, friction, restitution, with their sources (`config/materials.toml`).

use std::sync::LazyLock;

use indexmap::IndexMap;
use serde::Deserialize;

use geometry::Friction;

/// A physical material.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Substance {
    pub density_kg_m3: f64,
    pub static_friction: f64,
    pub dynamic_friction: f64,
    pub restitution: f64,
    /// Rolling and torsional friction as lengths, meters (MuJoCo's convention).
    pub rolling_friction_m: f64,
    pub torsional_friction_m: f64,
    /// Source of the numbers.
    pub source: String,
}

impl Substance {
    pub fn friction(&self) -> Friction {
        Friction { static_coefficient: self.static_friction, dynamic_coefficient: self.dynamic_friction }
    }
}

static SUBSTANCES: LazyLock<IndexMap<String, Substance>> = LazyLock::new(|| {
    toml::from_str(include_str!("../../../../config/materials.toml"))
        .expect("the built-in materials parse (a test loads them)")
});

/// The substance with this name.
pub fn substance(name: &str) -> Option<&'static Substance> {
    SUBSTANCES.get(name)
}

/// All substances in file order.
pub fn substances() -> &'static IndexMap<String, Substance> {
    &SUBSTANCES
}
