//! One object of an image: from the catalog, or a composite.

use std::sync::Arc;

use glam::{DQuat, DVec2, DVec3};
use rand::RngExt;

use super::Split;
use super::composite::{self, Kind};
use super::sampling::{any_color, chance, near, pale, pick, uniform};
use catalog::{Affordance, Category, Facing, Recipe, build};
use geometry::polygon::convex_hull_2d;
use geometry::{Pose, Rgb, TexturedMesh};
use runtime::seed::Rng;

/// Materials that a catalog object may be requested in.
const MATERIALS: &[&str] = &[
    "oak",
    "walnut",
    "pine",
    "steel",
    "chrome",
    "brass",
    "ceramic",
    "stoneware",
    "plastic",
    "leather",
    "marble",
    "glass",
];

/// Color scheme of one image's objects.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Palette {
    /// Usual colors, occasionally replaced.
    Usual,
    /// All objects near one color: white on white, wood on wood.
    Tone(Rgb),
}

/// A mesh with the properties that placement needs.
#[derive(Clone)]
pub(super) struct Object {
    /// Catalog category, or the name of the composite kind.
    pub name: &'static str,
    pub is_composite: bool,
    /// In the canonical frame.
    pub mesh: Arc<TexturedMesh>,
    /// Counter-clockwise hull of the vertical projection, object frame.
    pub footprint: Vec<DVec2>,
    pub faces_viewer: bool,
    pub carries: bool,
    pub contains: bool,
}

impl Object {
    /// A random object of the split, `scale` times its usual size.
    pub(super) fn draw(
        split: Split,
        palette: Palette,
        scale: f64,
        categories: &[&'static Category],
        rng: &mut Rng,
    ) -> Self {
        // Splits with few composite kinds would repeat the same ones.
        let composites = if split == Split::Training { 0.28 } else { 0.12 };
        if chance(rng, composites) {
            let kind = Kind::draw(split, rng);
            let tone = match palette {
                Palette::Usual => None,
                Palette::Tone(tone) => Some(tone),
            };
            let mesh = composite::build(kind, tone, rng).scaled(DVec3::splat(scale));
            return Self::new(kind.name(), true, mesh, false, kind.carries(), false);
        }
        Self::of_category(split, categories[rng.random_range(0..categories.len())], palette, scale, rng)
    }

    /// A random object of the category, `scale` times its usual size.
    pub(super) fn of_category(
        split: Split,
        category: &'static Category,
        palette: Palette,
        scale: f64,
        rng: &mut Rng,
    ) -> Self {
        let color = match palette {
            Palette::Tone(tone) => Some(near(rng, tone, 0.07)),
            Palette::Usual if chance(rng, 0.22) => {
                Some(if chance(rng, 0.3) { pale(rng) } else { any_color(rng) })
            }
            Palette::Usual => None,
        };
        let material =
            (palette == Palette::Usual && chance(rng, 0.12)).then(|| pick(rng, MATERIALS).to_owned());
        let stretch =
            DVec3::new(uniform(rng, 0.88, 1.12), uniform(rng, 0.88, 1.12), uniform(rng, 0.85, 1.18));
        let size_m = category.size.sample(rng)
            * scale
            * if category.symmetry_order == 0 { DVec3::new(1.0, 1.0, stretch.z) } else { stretch };
        let recipe = Recipe {
            category: category.name.clone(),
            size_m,
            color,
            material,
            seed: rng.random_range(0..u64::MAX),
        };
        let mesh = build(&recipe).unwrap_or_else(|| composite::build(Kind::draw(split, rng), None, rng));
        let mesh = lying(mesh, rng);
        let faces_viewer = category.facing != Facing::Any;
        let (carries, contains) =
            (category.affords(Affordance::Support), category.affords(Affordance::Container));
        Self::new(&category.name, false, mesh, faces_viewer, carries, contains)
    }

    fn new(
        name: &'static str,
        is_composite: bool,
        mesh: TexturedMesh,
        faces_viewer: bool,
        carries: bool,
        contains: bool,
    ) -> Self {
        let points: Vec<DVec2> = mesh.positions.iter().map(|p| p.truncate()).collect();
        let footprint = convex_hull_2d(&points);
        Self { name, is_composite, mesh: Arc::new(mesh), footprint, faces_viewer, carries, contains }
    }

    /// Convex hull of the vertical projection, world frame.
    pub(super) fn footprint_in(&self, world_from_object: &Pose) -> Vec<DVec2> {
        self.footprint.iter().map(|p| world_from_object.transform_point(p.extend(0.0)).truncate()).collect()
    }
}

/// Lays a tall slim object on its side with a small probability.
fn lying(mesh: TexturedMesh, rng: &mut Rng) -> TexturedMesh {
    let size = mesh.size_m();
    let slim = size.z > 1.8 * size.x.max(size.y);
    if slim && chance(rng, 0.12) {
        return mesh.rotated(DQuat::from_rotation_x(std::f64::consts::FRAC_PI_2)).seated();
    }
    mesh
}
