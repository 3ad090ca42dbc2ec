//! From a recipe to a mesh.

use glam::DVec3;
use rand::RngExt;
use serde::{Deserialize, Serialize};

use super::{Category, category};
use crate::geometry::seed::{Rng, child_rng};
use crate::geometry::{Rgb, TexturedMesh};

/// Everything that decides a catalog mesh.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Recipe {
    pub category: String,
    /// Extents as it stands, meters.
    pub size_m: DVec3,
    /// Overrides the palette.
    pub color: Option<Rgb>,
    /// Overrides the look of the main substance (`oak`, `steel`, `glass`, ...).
    pub material: Option<String>,
    pub seed: u64,
}

/// A recipe as a generator sees it: colors resolved, random stream open.
pub struct Order<'a> {
    pub category: &'a Category,
    /// Extents the mesh must have, meters. The generator meets them within a few percent.
    pub size_m: DVec3,
    /// Main color.
    pub color: Rgb,
    /// Main material the text asked for, if it did.
    pub material: Option<&'a str>,
    pub rng: Rng,
}

impl Order<'_> {
    /// Uniform in `low..high`.
    pub fn uniform(&mut self, low: f64, high: f64) -> f64 {
        if low < high { self.rng.random_range(low..high) } else { low }
    }

    /// 0..n.
    pub fn pick(&mut self, n: usize) -> usize {
        self.rng.random_range(0..n)
    }
}

/// Builds a mesh: +z up as it stands, front toward -y, centered, base on z = 0, meters.
pub type Generator = fn(&mut Order) -> TexturedMesh;

/// The recipe's mesh in the canonical frame (origin at the center of the bottom face of its box), or
/// `None` for a category nobody here knows.
pub fn build(recipe: &Recipe) -> Option<TexturedMesh> {
    let category = category(&recipe.category)?;
    let generator = category.generator()?;
    let mut rng = child_rng(recipe.seed, &recipe.category);
    let color = category.sample_color(&mut rng);
    let mut order = Order {
        category,
        size_m: recipe.size_m,
        color: recipe.color.unwrap_or(color),
        material: recipe.material.as_deref(),
        rng,
    };
    Some(generator(&mut order).seated())
}
