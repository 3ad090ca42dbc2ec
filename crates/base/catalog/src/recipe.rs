//! Recipes, and the meshes built from them.

use std::sync::Arc;

use glam::DVec3;
use rand::RngExt;
use serde::{Deserialize, Serialize};

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

/// The input of a generator: a recipe with resolved colors and its random stream.
pub struct Order<'a> {
    pub category: &'a Category,
    /// Extents the mesh must have, meters. The generator meets them within a few percent.
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

/// Builds a mesh: upright with +z up, front toward -y, centered, base on z = 0, meters.
pub type Generator = fn(&mut Order) -> TexturedMesh;

/// The recipe's mesh in the canonical frame (origin at the center of the bottom face of its box), or
/// `None` for an unknown category.
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

/// As [`build`], from the cache if it was built recently.
pub fn build_cached(recipe: &Recipe) -> Option<Arc<TexturedMesh>> {
    static CACHE: Cache<TexturedMesh> = Cache::empty();
    CACHE.get(recipe, || build(recipe))
}

#[cfg(test)]
mod tests {
    use std::collections::{BTreeMap, BTreeSet};

    use rayon::prelude::*;

    use std::f64::consts::FRAC_PI_2;

    use super::*;
    use crate::category::State;
    use crate::{categories, substance};
    use geometry::collide::{CollisionRule, PlacedSolid, penetration};
    use geometry::shapes::block;
    use geometry::shells::shells;
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

    type Judge = fn(&Recipe, &TexturedMesh) -> Option<String>;

    /// Builds every recipe in parallel and lists all objections of the judges in order.
    fn objections(recipes: &[Recipe], judges: &[Judge]) -> Vec<String> {
        let judge_one = |recipe: &Recipe| -> Vec<String> {
            let name = format!("{} ({:?}, {:x})", recipe.category, recipe.material, recipe.seed & 0xffff);
            match build(recipe) {
                Some(mesh) => judges
                    .iter()
                    .filter_map(|judge| judge(recipe, &mesh))
                    .map(|why| format!("{name}: {why}"))
                    .collect(),
                None => vec![format!("{name}: no generator")],
            }
        };
        recipes.par_iter().flat_map_iter(judge_one).collect()
    }

    fn assert_none(objections: &[String]) {
        assert!(objections.is_empty(), "{} objections:\n{}", objections.len(), objections.join("\n"));
    }

    fn welded(p: DVec3) -> [u64; 3] {
        (p + DVec3::ZERO).to_array().map(f64::to_bits)
    }

    /// Signed volume and center of mass of the (possibly overlapping) shells.
    fn mass_center(mesh: &TexturedMesh) -> (f64, DVec3) {
        let (mut volume, mut moment) = (0.0, DVec3::ZERO);
        for t in mesh.triangles() {
            let [a, b, c] = t.map(|v| mesh.positions[v as usize]);
            let tetrahedron = a.dot(b.cross(c)) / 6.0;
            volume += tetrahedron;
            moment += tetrahedron * (a + b + c) / 4.0;
        }
        (volume, moment / volume)
    }

    #[test]
    fn catalog_data_are_consistent() {
        let mut names = BTreeSet::new();
        for category in categories() {
            let name = &category.name;
            assert!(names.insert(name.clone()), "{name} twice");
            assert!(substance(&category.substance).is_some(), "{name}: substance {}", category.substance);
            assert!(!category.palette.is_empty() && !category.families.is_empty(), "{name}: empty list");
            assert!(
                category.size.low_m.cmpgt(DVec3::ZERO).all()
                    && category.size.low_m.cmple(category.size.high_m).all(),
                "{name}: size {:?}",
                category.size
            );
            for color in &category.palette {
                let digits = color.strip_prefix('#').expect("palette colors start with #");
                assert!(
                    digits.len() == 6 && u32::from_str_radix(digits, 16).is_ok(),
                    "{name}: color {color}"
                );
            }
        }
    }

    /// After welding, every edge is used once in each direction, and the faces point outward.
    fn closed(_: &Recipe, mesh: &TexturedMesh) -> Option<String> {
        let mut balance: BTreeMap<([u64; 3], [u64; 3]), i32> = BTreeMap::new();
        for t in mesh.triangles() {
            for k in 0..3 {
                let a = welded(mesh.positions[t[k] as usize]);
                let b = welded(mesh.positions[t[(k + 1) % 3] as usize]);
                let (edge, sign) = if a < b { ((a, b), 1) } else { ((b, a), -1) };
                *balance.entry(edge).or_default() += sign;
            }
        }
        let open = balance.values().filter(|&&count| count != 0).count();
        let (volume_m3, _) = mass_center(mesh);
        (open > 0 || volume_m3 <= 0.0).then(|| format!("{open} open edges, volume {volume_m3:e} m^3"))
    }

    /// Normals are unit and point in the direction of their faces.
    fn normals_agree(_: &Recipe, mesh: &TexturedMesh) -> Option<String> {
        let not_unit = mesh.normals.iter().filter(|n| (n.length() - 1.0).abs() > 1e-3).count();
        let against = mesh
            .triangles()
            .filter(|t| {
                let [a, b, c] = t.map(|v| mesh.positions[v as usize]);
                let face = (b - a).cross(c - a).normalize_or_zero().as_vec3();
                t.iter().any(|&v| mesh.normals[v as usize].dot(face) < -0.1)
            })
            .count();
        (not_unit > 0 || against > 0)
            .then(|| format!("{not_unit} normals not unit, {against} faces against their normals"))
    }

    /// The ordered extents, base on z = 0, 300 to 6000 triangles, finite numbers.
    fn in_size_and_budget(recipe: &Recipe, mesh: &TexturedMesh) -> Option<String> {
        let error = (mesh.size_m() / recipe.size_m - 1.0).abs();
        let base_m = mesh.bounds().0.z.abs();
        let count = mesh.triangle_count();
        let parallel = mesh.uvs.len() == mesh.positions.len() && mesh.normals.len() == mesh.positions.len();
        let finite = mesh.positions.iter().all(|p| p.is_finite()) && mesh.uvs.iter().all(|uv| uv.is_finite());
        (error.max_element() > 0.06
            || base_m > 1e-9
            || !(300..=6000).contains(&count)
            || !parallel
            || !finite)
            .then(|| {
                format!(
                    "size error {error:.3}, base {base_m:e}, {count} triangles, parallel {parallel}, finite {finite}"
                )
            })
    }

    /// Texture sizes are powers of two, and material names differ.
    fn dressed(_: &Recipe, mesh: &TexturedMesh) -> Option<String> {
        let names: BTreeSet<&str> = mesh.materials.iter().map(|m| m.name.as_str()).collect();
        let odd = mesh.materials.iter().filter_map(|m| m.base_color_texture.as_ref()).find(|t| {
            [t.width_px(), t.height_px()].iter().any(|s| !s.is_power_of_two() || !(64..=512).contains(s))
        });
        (names.len() != mesh.materials.len() || odd.is_some()).then(|| {
            format!("materials {names:?}, odd texture {:?}", odd.map(|t| (t.width_px(), t.height_px())))
        })
    }

    /// The center of mass is over the feet, away from their edge: the tilt at which it passes over the edge is at least
    /// four degrees.
    fn stands(_: &Recipe, mesh: &TexturedMesh) -> Option<String> {
        let (_, center) = mass_center(mesh);
        let feet: Vec<DVec3> =
            mesh.positions.iter().copied().filter(|p| p.z < 2e-4).map(|p| p - center).collect();
        // Smallest reach of the feet beyond the center of mass over all directions.
        let reach_m = (0..72)
            .map(|k| {
                let angle = f64::from(k) * std::f64::consts::TAU / 72.0;
                let (sin, cos) = angle.sin_cos();
                feet.iter().map(|p| p.x * cos + p.y * sin).fold(f64::NEG_INFINITY, f64::max)
            })
            .fold(f64::INFINITY, f64::min);
        let tilt_deg = reach_m.atan2(center.z).to_degrees();
        (tilt_deg < 4.0).then(|| {
            format!("tips over at {tilt_deg:.1} degrees ({reach_m:.4} m, center {:.4} m up)", center.z)
        })
    }

    /// A second build gives the same bytes.
    fn repeats(recipe: &Recipe, mesh: &TexturedMesh) -> Option<String> {
        (build(recipe).as_ref() != Some(mesh)).then(|| "two builds differ".to_owned())
    }

    /// The shape is unchanged by a rotation of its symmetry: every vertex lands within 4 % of the
    /// largest extent of another one.
    fn symmetric(recipe: &Recipe, mesh: &TexturedMesh) -> Option<String> {
        let order = category(&recipe.category)?.symmetry_order;
        let turn_rad = match order {
            0 => 0.7,
            1 => return None,
            n => std::f64::consts::TAU / f64::from(n),
        };
        let turn = glam::DQuat::from_rotation_z(turn_rad);
        let stride = mesh.positions.len().div_ceil(300);
        let worst_m = mesh
            .positions
            .iter()
            .step_by(stride)
            .map(|p| {
                let turned = turn * *p;
                mesh.positions.iter().map(|q| q.distance_squared(turned)).fold(f64::INFINITY, f64::min)
            })
            .fold(0.0, f64::max)
            .sqrt();
        let share = worst_m / mesh.size_m().max_element();
        (share > 0.04)
            .then(|| format!("symmetry order {order}, but a vertex is off by {share:.3} of the size"))
    }

    #[test]
    fn build_gives_sound_meshes_for_every_category() {
        let recipes: Vec<Recipe> =
            categories().iter().flat_map(|category| (0..3).map(move |seed| recipe(category, seed))).collect();
        let judges: [Judge; 7] =
            [closed, normals_agree, in_size_and_budget, dressed, stands, repeats, symmetric];
        assert_none(&objections(&recipes, &judges));
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
        assert_none(&objections(
            &recipes,
            &[
                closed,
                normals_agree,
                in_size_and_budget,
                dressed,
                stands,
                repeats,
                symmetric,
                nowhere_inside_out,
            ],
        ));
    }

    /// Winding number of the surface around a point: 1 inside, 0 outside, other values at self-intersections.
    fn winding(triangles: &[[DVec3; 3]], point: DVec3) -> f64 {
        let solid_angle = |corners: &[DVec3; 3]| {
            let [a, b, c] = corners.map(|p| p - point);
            let lengths = a.length() * b.length() * c.length();
            let around = lengths + a.dot(b) * c.length() + b.dot(c) * a.length() + c.dot(a) * b.length();
            2.0 * a.dot(b.cross(c)).atan2(around)
        };
        triangles.iter().map(solid_angle).sum::<f64>() / (4.0 * std::f64::consts::PI)
    }

    /// There is air in front of each face. A wall whose sides cross is inverted there, and objects on it seem to be
    /// inside.
    fn nowhere_inside_out(_: &Recipe, mesh: &TexturedMesh) -> Option<String> {
        const BEFORE_M: f64 = 2e-5;
        let inside_out = shells(mesh).into_iter().map(|shell| {
            let triangles: Vec<[DVec3; 3]> = shell.corners().collect();
            let is_in_the_solid = |[a, b, c]: &[DVec3; 3]| {
                let before = (b - a).cross(c - a).normalize_or_zero() * BEFORE_M;
                winding(&triangles, (a + b + c) / 3.0 + before) > 0.5
            };
            triangles.iter().filter(|triangle| is_in_the_solid(triangle)).count()
        });
        let count: usize = inside_out.sum();
        (count > 0).then(|| format!("{count} faces look into the solid"))
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
                let mesh = build(&recipe(category, seed)).expect("it has a generator");
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
