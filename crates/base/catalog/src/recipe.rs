//! Recipes, and the meshes built from them.

use std::sync::Arc;

use glam::DVec3;
use rand::RngExt;
use serde::{Deserialize, Serialize};

use super::color::with_color;
use super::kit::from_shape;
use super::mesh_cache::Cache;
use super::{Category, category};
use geometry::{Rgb, TexturedMesh};
use runtime::seed::{Rng, child_rng};

/// The complete input of a catalog mesh.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Recipe {
    pub category: String,
    /// Extents in its upright pose, meters.
    pub size_m: DVec3,
    /// Overrides the palette.
    pub color: Option<Rgb>,
    /// Overrides the finish of the main substance (`oak`, `steel`, `glass`, ...).
    pub material: Option<String>,
    pub seed: u64,
}

impl Recipe {
    /// The typical object of a category: central size, first variant. `None` for an unknown category.
    pub fn typical(category_name: &str, color: Option<Rgb>, material: Option<String>) -> Option<Self> {
        let category = category(category_name)?;
        let size_m = category.size.typical_m();
        Some(Self { category: category.name.clone(), size_m, color, material, seed: 0 })
    }
}

/// The input of a shape: a recipe with resolved colors and its random stream.
pub struct Order<'a> {
    pub category: &'a Category,
    /// Extents that the mesh must have, meters.
    pub size_m: DVec3,
    /// Main color.
    pub color: Rgb,
    /// Requested main material, if any.
    pub material: Option<&'a str>,
    pub rng: Rng,
}

impl Order<'_> {
    /// Uniform in `low..high`.
    pub fn uniform(&mut self, low: f64, high: f64) -> f64 {
        if low < high { self.rng.random_range(low..high) } else { low }
    }

    /// Uniform integer in 0..n.
    pub fn pick(&mut self, n: usize) -> usize {
        self.rng.random_range(0..n)
    }
}

/// The recipe's mesh in the canonical frame (origin at the center of the bottom face of its box), or
/// `None` for an unknown category.
///
/// A color that is asked for shows on a large part of the mesh, whatever the category is usually made of.
pub fn build(recipe: &Recipe) -> Option<TexturedMesh> {
    let mesh = designed(recipe, recipe.color)?;
    Some(match recipe.color {
        Some(asked) => with_color(mesh, asked, recipe.material.is_none(), || designed(recipe, None)),
        None => mesh,
    })
}

/// The mesh as the category is designed, with this main color, or one of its palette.
fn designed(recipe: &Recipe, color: Option<Rgb>) -> Option<TexturedMesh> {
    let category = category(&recipe.category)?;
    let mut rng = child_rng(recipe.seed, &recipe.category);
    let usual = category.sample_color(&mut rng);
    let mut order = Order {
        category,
        size_m: recipe.size_m,
        color: color.unwrap_or(usual),
        material: recipe.material.as_deref(),
        rng,
    };
    Some(from_shape(&mut order)?.seated())
}

/// As [`build`], from the cache if it was built recently.
pub fn build_cached(recipe: &Recipe) -> Option<Arc<TexturedMesh>> {
    static CACHE: Cache<TexturedMesh> = Cache::empty();
    CACHE.get(recipe, || build(recipe))
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use rayon::prelude::*;

    use std::f64::consts::FRAC_PI_2;

    use super::*;
    use crate::added::check_values;
    use crate::categories;
    use crate::category::State;
    use crate::checks::{CHECKS, Check, closed, dressed, in_size_and_budget, nowhere_inside_out, stands};
    use geometry::collide::{CollisionRule, PlacedSolid, penetration};
    use geometry::shapes::block;
    use geometry::solid_query::MeshSolid;
    use geometry::{Material, Pose};
    use glam::DQuat;
    use runtime::CancelFlag;
    use runtime::seed::child_seed;

    fn recipe(category: &Category, seed: u64) -> Recipe {
        let mut rng = child_rng(seed, "size");
        Recipe {
            category: category.name.clone(),
            size_m: category.size.sample(&mut rng),
            color: None,
            material: None,
            seed: child_seed(seed, "mesh"),
        }
    }

    /// Builds every recipe in parallel and lists all objections of the checks in order.
    fn objections(recipes: &[Recipe], checks: &[Check]) -> Vec<String> {
        let check_one = |recipe: &Recipe| -> Vec<String> {
            let name = format!("{} ({:?}, {:x})", recipe.category, recipe.material, recipe.seed & 0xffff);
            match build(recipe) {
                Some(mesh) => checks
                    .iter()
                    .filter_map(|check| check(recipe, &mesh))
                    .map(|why| format!("{name}: {why}"))
                    .collect(),
                None => vec![format!("{name}: no shape")],
            }
        };
        recipes.par_iter().flat_map_iter(check_one).collect()
    }

    fn assert_none(objections: &[String]) {
        assert!(objections.is_empty(), "{} objections:\n{}", objections.len(), objections.join("\n"));
    }

    #[test]
    fn catalog_data_are_consistent() {
        let mut names = BTreeSet::new();
        for category in categories() {
            let name = &category.name;
            assert!(names.insert(name.clone()), "{name} twice");
            assert_eq!(check_values(category), Ok(()));
        }
    }

    #[test]
    fn build_gives_sound_meshes_for_every_category() {
        // Of every tenth, two seeds more.
        let seeds = |index: usize| if index.is_multiple_of(10) { 3 } else { 1 };
        let recipes: Vec<Recipe> = categories()
            .iter()
            .enumerate()
            .flat_map(|(index, category)| (0..seeds(index)).map(move |seed| recipe(category, seed)))
            .collect();
        assert_none(&objections(&recipes, &CHECKS));
    }

    #[test]
    fn build_gives_sound_meshes_for_every_stand_in() {
        let usual = crate::stand_in::hidden_categories()
            .iter()
            .flat_map(|category| (0..3).map(move |seed| recipe(category, seed)));
        let of_nouns = crate::stand_in::rule_samples()
            .into_iter()
            .enumerate()
            .map(|(k, stand_in)| stand_in.recipe(None, None, None, k as u64));
        let recipes: Vec<Recipe> = usual.chain(of_nouns).collect();
        let checks: Vec<Check> = CHECKS.into_iter().chain([nowhere_inside_out as Check]).collect();
        assert_none(&objections(&recipes, &checks));
    }

    #[test]
    fn plates_with_wide_wells_are_not_inverted() {
        let carrying =
            ["plate", "saucer", "bowl", "tray", "cutting_board", "coaster", "cutting_mat", "pen_holder"];
        let recipes: Vec<Recipe> = carrying
            .iter()
            .flat_map(|name| {
                (0..8).map(move |seed| recipe(category(name).expect("it is in the catalog"), seed))
            })
            .collect();
        assert_none(&objections(&recipes, &[nowhere_inside_out]));
    }

    #[test]
    fn build_accepts_any_material_and_color() {
        let recipes: Vec<Recipe> = categories()
            .iter()
            .zip(
                ["oak", "steel", "glass", "ceramic", "plastic", "marble", "leather", "wicker"].iter().cycle(),
            )
            .map(|(category, material)| Recipe {
                material: Some((*material).to_owned()),
                color: Some(Rgb::hex(0x20_90_40)),
                ..recipe(category, 9)
            })
            .collect();
        assert_none(&objections(&recipes, &[closed, in_size_and_budget, dressed, stands]));
    }

    #[test]
    fn what_lies_on_a_table_does_not_reach_into_it() {
        // The necks of bottles have slivers, beside which the nearest face does not tell inside from outside.
        let table = block(DVec3::new(2.0, 2.0, 0.04)).translated(DVec3::new(0.0, 0.0, -0.04));
        let mut table_mesh = TexturedMesh::default();
        table_mesh.add(table, &Material::plain("oak", Rgb::hex(0xb0_84_55), 0.5));
        let table = MeshSolid::new(&table_mesh).expect("a table");
        let table = PlacedSolid { solid: &table, world_from_object: Pose::IDENTITY };
        let rule =
            CollisionRule { penetration_m: 0.001, wall_share: 0.25, min_wall_m: 0.0004, spacing_m: 0.001 };
        let lying: Vec<&Category> =
            categories().iter().filter(|category| category.can_be(State::Lying)).collect();
        assert!(lying.len() > 10, "{}", lying.len());
        let faults: Vec<String> = lying
            .par_iter()
            .flat_map_iter(|category| (0..2).map(move |seed| (*category, seed)))
            .filter_map(|(category, seed)| {
                let mesh = build(&recipe(category, seed)).expect("it has a shape");
                let solid = MeshSolid::new(&mesh).expect("a solid");
                let turn = DQuat::from_rotation_z(0.7 * seed as f64) * DQuat::from_rotation_x(FRAC_PI_2);
                let turn = turn * DQuat::from_rotation_z(0.37 + seed as f64);
                let lowest_m = mesh.positions.iter().map(|p| (turn * *p).z).fold(f64::INFINITY, f64::min);
                let pose = Pose { translation_m: DVec3::new(0.0, 0.0, -lowest_m), rotation: turn };
                let placed = PlacedSolid { solid: &solid, world_from_object: pose };
                let found =
                    penetration(&placed, &table, &rule, &CancelFlag::default()).expect("not cancelled");
                found.map(|found| format!("{} {seed}: {:.1} mm", category.name, 1000.0 * found.depth_m))
            })
            .collect();
        assert!(faults.is_empty(), "{faults:?}");
    }
}
