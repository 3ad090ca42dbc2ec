//! Mass and friction of catalog meshes: from the category's substance, or from the requested material.

use std::collections::BTreeMap;
use std::sync::Mutex;

use serde::{Deserialize, Serialize};

use super::{Category, Recipe, build, category, substance};
use geometry::mass_properties::{MassError, shell_mass_properties, solid_mass_properties};
use geometry::{Friction, MassProperties, TexturedMesh};

/// Substance of objects of unknown categories, and of tables.
const USUAL_SUBSTANCE: &str = "wood";

/// Table finishes that are not substances, with the substance beneath.
const FINISHES: &[(&str, &str)] = &[
    ("oak", "wood"),
    ("walnut", "wood"),
    ("pine", "wood"),
    ("birch", "wood"),
    ("white", "plywood"),
    ("black", "plywood"),
    ("marble", "stone"),
    ("granite", "stone"),
    ("terrazzo", "stone"),
    ("concrete", "stone"),
    ("tile", "ceramic"),
];

/// All properties of a body that a simulation needs besides its shape.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct PhysicalProperties {
    pub mass: MassProperties,
    pub friction: Friction,
    pub restitution: f64,
    /// Rolling and torsional friction as lengths, meters (MuJoCo's convention).
    pub rolling_friction_m: f64,
    pub torsional_friction_m: f64,
}

/// Physical properties of `mesh` (meters, object frame) as an object of the category.
///
/// `material` (a substance, or a table finish) replaces the category's substance. A density of the category itself
/// stays, because it describes the contents, which the material does not determine. A mass of the category changes with
/// the square root of the ratio of densities, since what is made of a denser substance has thinner walls. A category
/// with a shell thickness has the mass of a shell. Unknown categories and tables are solid wood unless a material is
/// given.
///
/// # Errors
///
/// The mesh has no volume (open or inverted), or no surface.
pub fn physical_properties(
    mesh: &TexturedMesh,
    category_name: &str,
    material: Option<&str>,
) -> Result<PhysicalProperties, MassError> {
    let kind = category(category_name);
    let Some(asked) = substance(made_of(category_name, material)) else {
        return Err(MassError::BadSubstance { density_kg_m3: f64::NAN, thickness_m: 1.0 });
    };
    let mass = match kind {
        Some(kind) => match (kind.shell_thickness_m, kind.density_kg_m3) {
            (Some(thickness_m), _) => shell_mass_properties(mesh, thickness_m, asked.density_kg_m3)?,
            (None, own) => {
                let own = own.or_else(|| {
                    let usual = substance(made_of(category_name, None))?;
                    let thinning = (asked.density_kg_m3 / usual.density_kg_m3).sqrt();
                    Some(thinning * density_from_mass(kind)?)
                });
                solid_mass_properties(mesh, own.unwrap_or(asked.density_kg_m3))?
            }
        },
        None => solid_mass_properties(mesh, asked.density_kg_m3)?,
    };
    Ok(PhysicalProperties {
        mass,
        friction: asked.friction(),
        restitution: asked.restitution,
        rolling_friction_m: asked.rolling_friction_m,
        torsional_friction_m: asked.torsional_friction_m,
    })
}

/// The density that gives the typical mesh the category's mass; `None` if the category does not state one. Each
/// category's typical mesh is built once.
fn density_from_mass(kind: &Category) -> Option<f64> {
    static DENSITIES: Mutex<BTreeMap<&'static str, f64>> = Mutex::new(BTreeMap::new());
    let mass_kg = kind.mass_kg?;
    let known = DENSITIES.lock().ok().and_then(|densities| densities.get(kind.name.as_str()).copied());
    if known.is_some() {
        return known;
    }
    let mesh = build(&Recipe::typical(&kind.name, None, None)?)?;
    let at_unit_density = solid_mass_properties(&mesh, 1.0).ok()?;
    let density_kg_m3 = mass_kg / at_unit_density.mass_kg;
    let name = category(&kind.name)?.name.as_str();
    if let Ok(mut densities) = DENSITIES.lock() {
        densities.insert(name, density_kg_m3);
    }
    Some(density_kg_m3)
}

/// Whether a word names a finish of tables (`oak`), which has a substance beneath.
pub fn is_finish(name: &str) -> bool {
    FINISHES.iter().any(|(finish, _)| *finish == name)
}

/// Name of the main substance of an object of the category; `material` as in
/// [`physical_properties`].
pub fn made_of<'a>(category_name: &str, material: Option<&'a str>) -> &'a str {
    let beneath = |word: &'a str| {
        FINISHES.iter().find(|(finish, _)| *finish == word).map_or(word, |(_, beneath)| *beneath)
    };
    let asked_for = material.map(beneath).filter(|name| substance(name).is_some());
    let usual = || category(category_name).map_or(USUAL_SUBSTANCE, |kind| kind.substance.as_str());
    asked_for.unwrap_or_else(|| beneath(usual()))
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::{Recipe, build, build_table, categories, table_models};

    #[test]
    fn every_category_has_a_plausible_mass() {
        for kind in categories() {
            let recipe = Recipe {
                category: kind.name.clone(),
                size_m: kind.size.typical_m(),
                color: None,
                material: None,
                seed: 3,
            };
            let mesh = build(&recipe).expect("a shape");
            let found = physical_properties(&mesh, &kind.name, None).expect("a solid");
            // From a matchstick (0.15 g) to a car's battery.
            let mass_kg = found.mass.mass_kg;
            assert!((0.0001..18.0).contains(&mass_kg), "{} weighs {mass_kg} kg", kind.name);
            assert!(found.mass.inertia_diagonal_kg_m2.cmpgt(DVec3::ZERO).all(), "{}", kind.name);
        }
    }

    #[test]
    fn requested_material_replaces_the_substance_and_table_finishes_are_known() {
        let recipe = |material: Option<&str>| Recipe {
            category: "plate".into(),
            size_m: DVec3::new(0.24, 0.24, 0.024),
            color: None,
            material: material.map(str::to_owned),
            seed: 1,
        };
        let weigh = |material| {
            let mesh = build(&recipe(material)).expect("a plate");
            physical_properties(&mesh, "plate", material).expect("a solid").mass.mass_kg
        };
        assert!((weigh(Some("steel")) / weigh(Some("glass")) - (7850.0_f64 / 2500.0).sqrt()).abs() < 0.05);
        assert!(weigh(Some("wood")) < weigh(None));
        for model in table_models() {
            let table = build_table(model.name, model.low_m, None, Some("oak"), 1).expect("a table");
            let weigh = |material| physical_properties(&table.mesh, "table", material).expect("a solid").mass;
            assert_eq!(weigh(Some("oak")), weigh(None));
            assert!(weigh(Some("marble")).mass_kg > weigh(None).mass_kg);
            assert!((5.0..200.0).contains(&weigh(None).mass_kg), "{} {:?}", model.name, weigh(None));
        }
    }
}
