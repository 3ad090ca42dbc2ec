//! What the catalog knows about a kind of thing.

use std::sync::LazyLock;

use glam::DVec3;
use rand::RngExt;
use serde::Deserialize;

use super::Generator;
use geometry::Rgb;
use runtime::seed::Rng;

/// A kind of thing, as its table in `config/catalog/<family>.toml` tells it.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Category {
    /// `[a-z0-9_]`, unique; also the generator's name.
    pub name: String,
    /// Singular, as people say it ("coffee mug").
    pub label: String,
    /// Other words for it, singular, lower case.
    #[serde(default)]
    pub synonyms: Vec<String>,
    /// Only where adding s or es is wrong ("knives").
    #[serde(default)]
    pub plural: Option<String>,
    /// `office_living`, `dining_kitchen`, `workbench_utility`, `crafting_hobby`.
    pub families: Vec<String>,
    /// Functional group ("cutlery", "screen", "input_device", "vessel", "fruit", "hand_tool").
    pub group: String,
    pub size: SizeRange,
    /// Hexadecimal `#rrggbb` colors it comes in; the request's color overrides.
    pub palette: Vec<String>,
    /// Name of its main substance in `config/materials.toml`.
    pub substance: String,
    /// Effective density of the volume its visual mesh encloses, where the substance's is wrong
    /// (electronics in a case, a filled carton).
    #[serde(default)]
    pub density_kg_m3: Option<f64>,
    /// For hollow bodies drawn as solids: mass = area x thickness x density of the substance.
    #[serde(default)]
    pub shell_thickness_m: Option<f64>,
    #[serde(default)]
    pub affordances: Vec<Affordance>,
    /// Whether it has a front (its local -y) that people turn toward themselves.
    pub facing: Facing,
    /// Order of rotational symmetry about its vertical axis; 0 = any angle.
    pub symmetry_order: u32,
    /// Where on a table people put it.
    pub zone: Zone,
}

/// What it is good for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Affordance {
    /// Its top carries other things.
    Support,
    /// Other things go into it.
    Container,
    /// A parallel gripper can take it.
    Graspable,
}

/// How its front is turned when people put it down.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Facing {
    /// The front looks at the person at the front edge, within a few degrees.
    Viewer,
    /// Square to the table's edges.
    Aligned,
    /// Any way.
    Any,
}

/// Part of the table where it usually stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Zone {
    Back,
    Center,
    Front,
    Side,
    Any,
}

/// Extents as it stands, meters: lowest and highest of width (x), depth (y), height (z).
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SizeRange {
    pub low_m: DVec3,
    pub high_m: DVec3,
}

impl SizeRange {
    /// A size inside the range: one common factor, so that proportions stay, and up to a tenth of
    /// the range of its own per axis.
    pub fn sample(&self, rng: &mut Rng) -> DVec3 {
        let common = 0.5 * (rng.random_range(0.0..1.0) + rng.random_range(0.0..1.0));
        let own =
            DVec3::new(rng.random_range(-0.1..0.1), rng.random_range(-0.1..0.1), rng.random_range(-0.1..0.1));
        let fraction = (DVec3::splat(common) + own).clamp(DVec3::ZERO, DVec3::ONE);
        self.low_m + fraction * (self.high_m - self.low_m)
    }

    /// The middle of the range.
    pub fn typical_m(&self) -> DVec3 {
        0.5 * (self.low_m + self.high_m)
    }
}

impl Category {
    /// One of the palette's colors.
    pub fn sample_color(&self, rng: &mut Rng) -> Rgb {
        let pick = &self.palette[rng.random_range(0..self.palette.len())];
        Rgb::hex(u32::from_str_radix(pick.trim_start_matches('#'), 16).unwrap_or(0x80_80_80))
    }

    pub fn affords(&self, affordance: Affordance) -> bool {
        self.affordances.contains(&affordance)
    }

    pub(super) fn generator(&self) -> Option<Generator> {
        [
            super::dining::GENERATORS,
            super::office::GENERATORS,
            super::workbench::GENERATORS,
            super::crafting::GENERATORS,
        ]
        .iter()
        .flat_map(|family| family.iter())
        .find(|(name, _)| *name == self.name)
        .map(|(_, generator)| *generator)
    }
}

#[derive(Deserialize)]
struct CategoryFile {
    category: Vec<Category>,
}

static CATEGORIES: LazyLock<Vec<Category>> = LazyLock::new(|| {
    let sources = [
        include_str!("../../../config/catalog/dining_kitchen.toml"),
        include_str!("../../../config/catalog/office_living.toml"),
        include_str!("../../../config/catalog/workbench_utility.toml"),
        include_str!("../../../config/catalog/crafting_hobby.toml"),
    ];
    sources
        .iter()
        .flat_map(|text| {
            let file: CategoryFile =
                toml::from_str(text).expect("the built-in catalog parses (a test loads it)");
            file.category
        })
        .collect()
});

/// Every category, in file order.
pub fn categories() -> &'static [Category] {
    &CATEGORIES
}

/// The category of that name.
pub fn category(name: &str) -> Option<&'static Category> {
    CATEGORIES.iter().find(|category| category.name == name)
}
