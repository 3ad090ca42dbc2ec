//! Table models with real legs and outlines.
//!
//! Every model is built standing on z = 0 and then lowered, so that its top surface lies at z = 0 of
//! the world frame and its feet at -height. Parts are closed solids that overlap by about a
//! millimeter. Tops are 20 to 45 mm thick with edges eased by [`EASED_EDGE_M`]; the outline returned is that
//! of the flat part inside the eased edge, so no object placed on it overhangs the rounding.

mod finish;
pub(crate) mod grain;
mod frames;
mod outlined;
mod pedestals;
pub(crate) mod shapes;

use std::sync::Arc;

use glam::{DVec2, DVec3};

use self::finish::Finish;
pub(crate) use self::finish::TOPS;
pub use self::finish::refinished;
use super::mesh_cache::Cache;
use geometry::{Outline, Rgb, Solid, TexturedMesh};
use runtime::seed::child_rng;

/// Radius of the rounding between a table's top surface and its edge.
pub const EASED_EDGE_M: f64 = 0.002;

/// A table model.
#[derive(Clone, Debug)]
pub struct TableModel {
    /// `[a-z0-9_]`.
    pub name: &'static str,
    pub label: &'static str,
    /// Synonyms, singular, lower case.
    pub synonyms: &'static [&'static str],
    /// `rectangular`, `square`, `round`, `oval`, `triangular`, `irregular`.
    pub shape: &'static str,
    /// Minimum and maximum width, depth, height, meters.
    pub low_m: DVec3,
    pub high_m: DVec3,
    /// Families that usually use it.
    pub families: &'static [&'static str],
}

/// A table as built: the mesh in the world frame (top surface at z = 0, feet at -height).
pub struct BuiltTable {
    pub mesh: TexturedMesh,
    /// Edge of the top surface.
    pub outline_m: Outline,
}

/// Every table model.
pub fn table_models() -> &'static [TableModel] {
    MODELS
}

/// Builds the model at `size_m` (width, depth, height); `None` for an unknown name. `material` is one
/// of [`TABLE_MATERIALS`] (any other word gives the model's usual finish); `color` is the color of the top. A table
/// that is smaller than its model's range is a scaled copy of the smallest one: its parts keep their proportions.
pub fn build_table(
    name: &str,
    size_m: DVec3,
    color: Option<Rgb>,
    material: Option<&str>,
    seed: u64,
) -> Option<BuiltTable> {
    let model = MODELS.iter().find(|model| model.name == name)?;
    let built_m = size_m.max(model.low_m);
    let built = build_in_range(name, built_m, color, material, seed)?;
    if built_m == size_m {
        return Some(built);
    }
    let scale = size_m / built_m;
    let corners = built.outline_m.corners().iter().map(|corner| *corner * scale.truncate());
    Some(BuiltTable { outline_m: Outline::new(corners.collect()).ok()?, mesh: built.mesh.scaled(scale) })
}

/// Builds a model at least as large as the smallest one, for which its joints are made.
fn build_in_range(
    name: &str,
    size_m: DVec3,
    color: Option<Rgb>,
    material: Option<&str>,
    seed: u64,
) -> Option<BuiltTable> {
    let mut rng = child_rng(seed, name);
    let finish = Finish::choose(name, color, material, &mut rng);
    let mut draft = Draft::new(size_m, finish);
    // Of its own, so that another color or material leaves the shape as it is.
    let mut rng = child_rng(seed, &format!("shape of {name}"));
    let edge = match name {
        "dining_table" => frames::dining_table(&mut draft, &mut rng),
        "desk" => frames::desk(&mut draft),
        "workbench" => frames::workbench(&mut draft),
        "coffee_table" => frames::coffee_table(&mut draft),
        "square_table" => frames::square_table(&mut draft, &mut rng),
        "round_table" => pedestals::round_table(&mut draft),
        "oval_table" => pedestals::oval_table(&mut draft),
        "triangular_table" => pedestals::triangular_table(&mut draft),
        "hexagonal_table" => pedestals::hexagonal_table(&mut draft),
        "kidney_table" => pedestals::kidney_table(&mut draft),
        _ => return None,
    };
    let flat = geometry::shapes::inset(&edge, EASED_EDGE_M);
    Some(BuiltTable {
        mesh: draft.mesh.translated(DVec3::new(0.0, 0.0, -size_m.z)),
        outline_m: Outline::new(flat).ok()?,
    })
}

/// Name of the model that [`build_outlined_table`] builds; it cannot be built by name, because it needs an outline.
pub const OUTLINED_TABLE: &str = "outlined_table";

/// Builds a table whose top has this edge, centered on its axis-aligned box, on three legs or more; finish as in
/// [`build_table`]. `None` if the top is too narrow somewhere for its rounding.
pub fn build_outlined_table(
    edge: &Outline,
    height_m: f64,
    legs: usize,
    color: Option<Rgb>,
    material: Option<&str>,
    seed: u64,
) -> Option<BuiltTable> {
    let (low, high) = edge.bounds();
    let mut rng = child_rng(seed, OUTLINED_TABLE);
    let finish = Finish::choose(OUTLINED_TABLE, color, material, &mut rng);
    let mut draft = Draft::new((high - low).extend(height_m), finish);
    outlined::outlined_table(&mut draft, edge, legs.max(3));
    let flat = geometry::shapes::inset(edge.corners(), EASED_EDGE_M);
    Some(BuiltTable {
        mesh: draft.mesh.translated(DVec3::new(0.0, 0.0, -height_m)),
        outline_m: Outline::new(flat).ok()?,
    })
}

/// As [`build_table`], from the cache if it was built recently.
pub fn build_cached_table(
    name: &str,
    size_m: DVec3,
    color: Option<Rgb>,
    material: Option<&str>,
    seed: u64,
) -> Option<Arc<BuiltTable>> {
    static CACHE: Cache<BuiltTable> = Cache::empty();
    CACHE.get(&(name, size_m, color, material, seed), || build_table(name, size_m, color, material, seed))
}

/// A table under construction: standing on z = 0, centered on the z axis.
struct Draft {
    mesh: TexturedMesh,
    size_m: DVec3,
    finish: Finish,
}

impl Draft {
    fn new(size_m: DVec3, finish: Finish) -> Self {
        Self { mesh: TexturedMesh::default(), size_m, finish }
    }

    /// Height of the top's lower face.
    fn underside_m(&self) -> f64 {
        self.size_m.z - self.finish.thickness_m
    }

    /// The top: `edge` raised to the table's height, grain along x.
    fn add_top(&mut self, edge: &[DVec2]) {
        let slab = geometry::shapes::slab(edge, self.finish.thickness_m, EASED_EDGE_M);
        let top = slab.with_flat_ends().translated(DVec3::new(0.0, 0.0, self.underside_m()));
        self.mesh.add(grain::along(top, DVec3::X), &self.finish.top);
    }

    /// A part of the frame with its grain along `axis`.
    fn add_frame(&mut self, solid: Solid, axis: DVec3) {
        self.mesh.add(grain::along(solid, axis), &self.finish.frame);
    }
}

/// Materials of tables that a request can name.
pub const TABLE_MATERIALS: &[&str] = &[
    "oak", "walnut", "pine", "birch", "white", "black", "marble", "granite", "terrazzo", "concrete", "tile",
    "glass", "steel",
];

const MODELS: &[TableModel] = &[
    TableModel {
        name: "dining_table",
        label: "dining table",
        synonyms: &[
            "rectangular table",
            "kitchen table",
            "dinner table",
            "breakfast table",
            "farmhouse table",
            "trestle table",
            "conference table",
            "craft table",
            "hobby table",
            "table",
        ],
        shape: "rectangular",
        low_m: DVec3::new(1.1, 0.7, 0.72),
        high_m: DVec3::new(1.9, 1.0, 0.77),
        families: &["dining_kitchen", "crafting_hobby", "office_living"],
    },
    TableModel {
        name: "desk",
        label: "desk",
        synonyms: &[
            "office desk",
            "writing desk",
            "computer desk",
            "study desk",
            "work desk",
            "hobby desk",
            "school desk",
            "sewing desk",
            "writing table",
            "study table",
        ],
        shape: "rectangular",
        low_m: DVec3::new(1.0, 0.55, 0.72),
        high_m: DVec3::new(1.6, 0.8, 0.76),
        families: &["office_living", "crafting_hobby"],
    },
    TableModel {
        name: "workbench",
        label: "workbench",
        synonyms: &["work bench", "bench", "carpenter's bench", "work table", "worktable", "tool bench"],
        shape: "rectangular",
        low_m: DVec3::new(1.1, 0.55, 0.8),
        high_m: DVec3::new(1.8, 0.8, 0.92),
        families: &["workbench_utility", "crafting_hobby"],
    },
    TableModel {
        name: "coffee_table",
        label: "coffee table",
        synonyms: &["low table", "living room table", "cocktail table", "sofa table", "tea table"],
        shape: "rectangular",
        low_m: DVec3::new(0.9, 0.5, 0.4),
        high_m: DVec3::new(1.3, 0.75, 0.48),
        families: &["office_living", "dining_kitchen"],
    },
    TableModel {
        name: "square_table",
        label: "square table",
        synonyms: &["card table", "game table", "chess table", "cafe table", "end table", "side table"],
        shape: "square",
        low_m: DVec3::new(0.7, 0.7, 0.68),
        high_m: DVec3::new(1.0, 1.0, 0.76),
        families: &["dining_kitchen", "crafting_hobby", "office_living"],
    },
    TableModel {
        name: "round_table",
        label: "round table",
        synonyms: &["circular table", "pedestal table", "bistro table", "round dining table"],
        shape: "round",
        low_m: DVec3::new(0.8, 0.8, 0.71),
        high_m: DVec3::new(1.3, 1.3, 0.76),
        families: &["dining_kitchen", "office_living", "crafting_hobby"],
    },
    TableModel {
        name: "oval_table",
        label: "oval table",
        synonyms: &["elliptical table", "oval dining table", "ellipse table"],
        shape: "oval",
        low_m: DVec3::new(1.2, 0.75, 0.72),
        high_m: DVec3::new(1.9, 1.1, 0.76),
        families: &["dining_kitchen", "office_living"],
    },
    TableModel {
        name: "triangular_table",
        label: "triangular table",
        synonyms: &["triangle table", "three-legged table", "corner table", "three-cornered table"],
        shape: "triangular",
        low_m: DVec3::new(0.95, 0.85, 0.68),
        high_m: DVec3::new(1.35, 1.2, 0.75),
        families: &["office_living", "crafting_hobby"],
    },
    TableModel {
        name: "hexagonal_table",
        label: "hexagonal table",
        synonyms: &["hexagon table", "six-sided table", "hex table"],
        shape: "irregular",
        low_m: DVec3::new(0.9, 0.8, 0.68),
        high_m: DVec3::new(1.35, 1.2, 0.76),
        families: &["crafting_hobby", "office_living", "dining_kitchen"],
    },
    TableModel {
        name: "kidney_table",
        label: "kidney-shaped table",
        synonyms: &[
            "kidney table",
            "kidney shaped table",
            "bean-shaped table",
            "irregular table",
            "curved table",
        ],
        shape: "irregular",
        low_m: DVec3::new(1.2, 0.75, 0.68),
        high_m: DVec3::new(1.7, 0.95, 0.75),
        families: &["office_living", "crafting_hobby"],
    },
];

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use super::*;

    /// Whether every edge, by welded position, is used equally often in both directions.
    fn is_closed(mesh: &TexturedMesh) -> bool {
        let bits = |v: u32| (mesh.positions[v as usize] + DVec3::ZERO).to_array().map(f64::to_bits);
        let mut balance: BTreeMap<_, i32> = BTreeMap::new();
        for t in mesh.triangles() {
            for k in 0..3 {
                let (a, b) = (bits(t[k]), bits(t[(k + 1) % 3]));
                if a < b {
                    *balance.entry((a, b)).or_default() += 1;
                } else {
                    *balance.entry((b, a)).or_default() -= 1;
                }
            }
        }
        balance.values().all(|&count| count == 0)
    }

    #[test]
    fn another_material_leaves_the_shape_of_a_table_as_it_is() {
        let triangles = |name: &str, size_m: DVec3, material: &str, seed: u64| {
            build_table(name, size_m, None, Some(material), seed)
                .expect("a known model")
                .mesh
                .triangles()
                .count()
        };
        for model in table_models() {
            for seed in 1..6 {
                let in_oak = triangles(model.name, model.high_m, "oak", seed);
                assert_eq!(in_oak, triangles(model.name, model.high_m, "marble", seed), "{}", model.name);
            }
        }
    }

    #[test]
    fn build_table_gives_size_flat_top_at_zero_and_feet_on_the_floor() {
        for model in table_models() {
            for (seed, size_m) in
                [(1, model.low_m), (2, model.high_m), (3, 0.5 * (model.low_m + model.high_m))]
            {
                let table = build_table(model.name, size_m, None, None, seed).expect("a known model");
                let (low, high) = table.mesh.bounds();
                let context = format!("{} {size_m} {low} {high}", model.name);
                assert!(high.z.abs() < 1e-9 && (low.z + size_m.z).abs() < 1e-9, "{context}");
                assert!(((high - low) / size_m - 1.0).abs().max_element() < 0.02, "{context}");
                assert!((high + low).truncate().abs().max_element() < 2e-3, "{context}");
                assert!(is_closed(&table.mesh), "{context}");
                let (inner, outer) = table.outline_m.bounds();
                assert!((outer + inner).abs().max_element() < 2e-3, "{context}");
                // Corners of the outline are corners of the flat top: present in the mesh at z = 0.
                for corner in table.outline_m.corners() {
                    let on_top = table
                        .mesh
                        .positions
                        .iter()
                        .any(|p| p.z.abs() < 1e-9 && (p.truncate() - *corner).length() < 1e-6);
                    assert!(on_top, "{context}: {corner} is not a corner of the flat top");
                }
                assert_eq!(table.mesh.normals.len(), table.mesh.positions.len());
                assert_eq!(table.mesh.uvs.len(), table.mesh.positions.len());
                let again = build_table(model.name, size_m, None, None, seed).expect("a known model");
                assert_eq!(table.mesh, again.mesh);
            }
        }
        assert!(build_table("hovering_table", DVec3::ONE, None, None, 1).is_none());
    }

    /// Regression: the column of a round table of 0.45 m rose 7 cm above its top, and scenes were quarantined.
    #[test]
    fn no_part_leaves_the_box_of_a_table_that_is_low_small_or_large() {
        for model in table_models() {
            let small = DVec3::new(0.5, 0.4, 0.35).min(model.low_m);
            let large = 1.6 * model.high_m;
            for size_m in [
                small,
                small.with_z(model.low_m.z),
                model.low_m.with_z(0.4),
                model.high_m.with_z(0.45),
                model.high_m.with_z(0.5),
                large.with_z(0.35),
                large,
            ] {
                let table = build_table(model.name, size_m, None, None, 1).expect("a known model");
                let (low, high) = table.mesh.bounds();
                let context = format!("{} {size_m} {low} {high}", model.name);
                assert!(high.z < 1e-9 && low.z > -size_m.z - 1e-9, "{context}");
                assert!(((high - low) / size_m - 1.0).abs().max_element() < 0.02, "{context}");
                assert!(is_closed(&table.mesh), "{context}");
            }
        }
    }

    #[test]
    fn small_and_low_tables_are_closed_and_have_their_size() {
        for model in table_models() {
            for size_m in [DVec3::new(0.9, 0.9, 0.45), DVec3::new(0.5, 0.5, 0.4), DVec3::new(0.4, 0.3, 0.72)]
            {
                let table = build_table(model.name, size_m, None, None, 1).expect("a known model");
                let (low, high) = table.mesh.bounds();
                let context = format!("{} {size_m} {low} {high}", model.name);
                assert!(high.z.abs() < 1e-9 && (low.z + size_m.z).abs() < 1e-9, "{context}");
                assert!(((high - low) / size_m - 1.0).abs().max_element() < 0.02, "{context}");
                assert!(is_closed(&table.mesh), "{context}");
                let (from, to) = table.outline_m.bounds();
                assert!(((to - from) - size_m.truncate()).abs().max_element() < 0.02, "{context}");
                assert!(part_volumes_m3(&table.mesh).iter().all(|&volume| volume > 0.0), "{context}");
            }
        }
    }

    #[test]
    fn build_outlined_table_has_its_outline_and_feet_below_it() {
        let bean = geometry::shapes::smooth(
            &[(-0.5, 0.0), (-0.4, -0.3), (0.0, -0.1), (0.4, -0.3), (0.5, 0.0), (0.0, 0.3)]
                .map(|(x, y)| DVec2::new(x, y)),
            8,
        );
        let (low, high) = bean.iter().fold((bean[0], bean[0]), |(l, h), p| (l.min(*p), h.max(*p)));
        let edge = Outline::new(bean.iter().map(|p| *p - 0.5 * (low + high)).collect()).expect("a bean");
        for legs in [3, 4] {
            let table = build_outlined_table(&edge, 0.7, legs, None, None, 3).expect("a table");
            let (lowest, highest) = table.mesh.bounds();
            assert!(highest.z.abs() < 1e-9 && (lowest.z + 0.7).abs() < 1e-9, "{lowest} {highest}");
            assert!(
                ((highest - lowest).truncate() - (high - low)).length() < 1e-6,
                "legs reach beyond the top"
            );
            assert!(is_closed(&table.mesh));
            assert!((table.outline_m.area_m2() / edge.area_m2() - 1.0).abs() < 0.03);
            let feet = table.mesh.positions.iter().filter(|p| p.z < -0.7 + 1e-6);
            assert!(feet.clone().count() >= 3 * legs && feet.clone().all(|p| edge.contains(p.truncate())));
        }
    }

    #[test]
    fn faces_of_every_part_point_outward() {
        // Parts are convex or nearly so: seen from a part's center, most of its area faces away. An
        // inverted part would reverse that.
        for model in table_models() {
            let mesh = build_table(model.name, model.high_m, None, None, 2).expect("a known model").mesh;
            let volumes_m3 = part_volumes_m3(&mesh);
            assert!(volumes_m3.len() > 3, "{}: {} parts", model.name, volumes_m3.len());
            assert!(volumes_m3.iter().all(|&v| v > 0.0), "{}: {volumes_m3:?}", model.name);
        }
    }

    /// Signed volume of each connected part, about the origin.
    fn part_volumes_m3(mesh: &TexturedMesh) -> Vec<f64> {
        let mut part_of: Vec<usize> = (0..mesh.positions.len()).collect();
        let mut by_position = BTreeMap::new();
        for (v, p) in mesh.positions.iter().enumerate() {
            part_of[v] = *by_position.entry((*p + DVec3::ZERO).to_array().map(f64::to_bits)).or_insert(v);
        }
        let find = |part_of: &[usize], mut v: usize| {
            while part_of[v] != v {
                v = part_of[v];
            }
            v
        };
        for t in mesh.triangles() {
            for k in 0..2 {
                let (a, b) = (find(&part_of, t[k] as usize), find(&part_of, t[k + 1] as usize));
                part_of[a.max(b)] = a.min(b);
            }
        }
        let mut volume_m3: BTreeMap<usize, f64> = BTreeMap::new();
        for t in mesh.triangles() {
            let [a, b, c] = t.map(|v| mesh.positions[v as usize]);
            *volume_m3.entry(find(&part_of, t[0] as usize)).or_default() += a.dot(b.cross(c)) / 6.0;
        }
        volume_m3.into_values().collect()
    }

    #[test]
    fn build_table_puts_feet_around_the_center() {
        for model in table_models() {
            for material in TABLE_MATERIALS {
                let size_m = model.low_m;
                let table = build_table(model.name, size_m, None, Some(material), 5).expect("a known model");
                let feet: Vec<DVec2> = table
                    .mesh
                    .positions
                    .iter()
                    .filter(|p| p.z < -size_m.z + 1e-6)
                    .map(|p| p.truncate())
                    .collect();
                let (low, high) = feet.iter().fold((feet[0], feet[0]), |(l, h), p| (l.min(*p), h.max(*p)));
                assert!(
                    low.x < -0.15 && high.x > 0.15 && low.y < -0.1 && high.y > 0.1,
                    "{} {low} {high}",
                    model.name
                );
            }
        }
    }
}
