//! Object categories of the catalog.

use std::collections::HashMap;
use std::sync::OnceLock;

use glam::DVec3;
use rand::RngExt;
use serde::{Deserialize, Serialize};

use super::added::{added, normalized, read_categories};
use super::kit::StoredShape;
use geometry::Rgb;
use runtime::seed::Rng;

/// An object category, as its table in `config/catalog/*.toml` defines it.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Category {
    /// `[a-z0-9_]`, unique.
    pub name: String,
    /// Singular display name ("coffee mug").
    pub label: String,
    /// Synonyms, singular, lower case.
    #[serde(default)]
    pub synonyms: Vec<String>,
    /// Other objects, singular, lower case, of which it is a plainer one of the kind ("scone" of a muffin): an object
    /// of that name has its shape and is marked as a stand-in.
    #[serde(default)]
    pub stands_in_for: Vec<String>,
    /// Irregular plural ("knives"); `None` if s or es is appended.
    #[serde(default)]
    pub plural: Option<String>,
    /// `office_living`, `dining_kitchen`, `workbench_utility`, `crafting_hobby`.
    pub families: Vec<String>,
    /// Functional group ("cutlery", "screen", "input_device", "vessel", "fruit", "hand_tool").
    pub group: String,
    pub size: SizeRange,
    /// Palette of hexadecimal `#rrggbb` colors; the request's color overrides it.
    pub palette: Vec<String>,
    /// Name of its main substance in `config/materials.toml`.
    pub substance: String,
    /// Effective density of the volume that the visual mesh encloses, if it differs from the substance's
    /// (electronics in a case, a filled carton).
    #[serde(default)]
    pub density_kg_m3: Option<f64>,
    /// For hollow bodies modeled as solids: mass = area x thickness x density of the substance.
    #[serde(default)]
    pub shell_thickness_m: Option<f64>,
    /// Mass at the typical size, kg; the density follows from the volume of the typical mesh. For objects whose
    /// contents or cavities the mesh does not show.
    #[serde(default)]
    pub mass_kg: Option<f64>,
    /// Volume that a container holds at the typical size, m^3.
    #[serde(default)]
    pub container_volume_m3: Option<f64>,
    #[serde(default)]
    pub affordances: Vec<Affordance>,
    /// States that it can be in or shows, beside standing upright.
    #[serde(default)]
    pub states: Vec<State>,
    /// Usual direction of the front (local -y), if the object has one.
    pub facing: Facing,
    /// Order of rotational symmetry about its vertical axis; 0 = any angle.
    pub symmetry_order: u32,
    /// Usual zone on a table.
    pub zone: Zone,
    /// Shape of its objects; a category without one is refused.
    #[serde(default)]
    pub shape: Option<StoredShape>,
}

/// State of an object other than standing upright.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Deserialize, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum State {
    /// Lying on its side, without rolling away at once.
    Lying,
    /// Standing on its rim or top.
    UpsideDown,
    /// The mesh shows it open.
    Open,
    /// The mesh shows it closed.
    Closed,
    /// The mesh shows it folded.
    Folded,
}

/// Affordances of an object.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Affordance {
    /// Top that can carry other objects.
    Support,
    /// Interior that can contain other objects.
    Container,
    /// A parallel gripper can grasp it.
    Graspable,
}

/// Usual orientation of its front.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Facing {
    /// The front faces the person at the front edge, within a few degrees.
    Viewer,
    /// Parallel to one of the table's edges.
    Aligned,
    /// Any orientation.
    Any,
}

/// Part of the table where an object usually stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Zone {
    Back,
    Center,
    Front,
    Side,
    Any,
}

/// Extents in its upright pose, meters: minimum and maximum of width (x), depth (y), height (z).
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SizeRange {
    pub low_m: DVec3,
    pub high_m: DVec3,
}

impl SizeRange {
    /// A random size inside the range: a common factor, which preserves proportions, plus an independent variation of
    /// up to a tenth of the range per axis.
    pub fn sample(&self, rng: &mut Rng) -> DVec3 {
        let common = 0.5 * (rng.random_range(0.0..1.0) + rng.random_range(0.0..1.0));
        let own =
            DVec3::new(rng.random_range(-0.1..0.1), rng.random_range(-0.1..0.1), rng.random_range(-0.1..0.1));
        let fraction = (DVec3::splat(common) + own).clamp(DVec3::ZERO, DVec3::ONE);
        self.low_m + fraction * (self.high_m - self.low_m)
    }

    /// The center of the range.
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

    /// Name, label and synonyms.
    pub fn words(&self) -> impl Iterator<Item = &str> {
        [&self.name, &self.label].into_iter().chain(&self.synonyms).map(String::as_str)
    }

    pub fn affords(&self, affordance: Affordance) -> bool {
        self.affordances.contains(&affordance)
    }

    pub fn can_be(&self, state: State) -> bool {
        self.states.contains(&state)
    }

    /// Volume that it holds at these extents, m^3; `None` if it holds nothing or the volume is unknown.
    pub fn holds_m3(&self, size_m: DVec3) -> Option<f64> {
        let scale = size_m / self.size.typical_m();
        self.container_volume_m3.map(|volume_m3| volume_m3 * scale.element_product())
    }
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct CategoryFile {
    pub category: Vec<Category>,
}

/// The categories that are compiled in, read anew.
pub(super) fn built_in() -> Vec<Category> {
    let sources = [
        include_str!("../../../../config/catalog/dining_kitchen.toml"),
        include_str!("../../../../config/catalog/office_living.toml"),
        include_str!("../../../../config/catalog/workbench_utility.toml"),
        include_str!("../../../../config/catalog/crafting_hobby.toml"),
        include_str!("../../../../config/catalog/primitives.toml"),
        include_str!("../../../../config/catalog/packaged_food.toml"),
        include_str!("../../../../config/catalog/produce.toml"),
        include_str!("../../../../config/catalog/meals.toml"),
        include_str!("../../../../config/catalog/household.toml"),
        include_str!("../../../../config/catalog/kitchen_equipment.toml"),
        include_str!("../../../../config/catalog/toys.toml"),
        include_str!("../../../../config/catalog/stationery_tools.toml"),
        include_str!("../../../../config/catalog/laboratory_medical.toml"),
        include_str!("../../../../config/catalog/electronics.toml"),
        include_str!("../../../../config/catalog/hardware.toml"),
        include_str!("../../../../config/catalog/groceries.toml"),
        include_str!("../../../../config/catalog/tableware.toml"),
        include_str!("../../../../config/catalog/desk_and_crafts.toml"),
        include_str!("../../../../config/catalog/games_and_sports.toml"),
        include_str!("../../../../config/catalog/personal_care.toml"),
    ];
    sources.into_iter().flat_map(with_unread_shapes).collect()
}

/// The categories of a file that is compiled in. In each of them `[category.shape]` is the last table.
pub(super) fn with_unread_shapes(text: &'static str) -> Vec<Category> {
    const BEGIN: &str = "[[category]]\n";
    let blocks = text.split_inclusive(BEGIN).skip(1).map(|block| block.strip_suffix(BEGIN).unwrap_or(block));
    let (heads, shapes): (Vec<&str>, Vec<Option<&str>>) = blocks
        .map(|block| match block.split_once("\n[category.shape]\n") {
            Some((head, shape)) => (head, Some(shape)),
            None => (block, None),
        })
        .unzip();
    let heads: String = heads.iter().map(|head| format!("{BEGIN}{head}\n")).collect();
    let mut categories = read_categories(&heads).expect("the built-in catalog can be read (a test reads it)");
    for (category, shape) in categories.iter_mut().zip(shapes) {
        category.shape = shape.map(StoredShape::unread);
    }
    categories
}

static CATEGORIES: OnceLock<Vec<Category>> = OnceLock::new();

/// Whether the catalog was read, after which nothing can be added.
pub(super) fn is_read() -> bool {
    CATEGORIES.get().is_some()
}

/// Every category, in file order: those that are compiled in, then those of the user.
pub fn categories() -> &'static [Category] {
    CATEGORIES.get_or_init(|| built_in().into_iter().chain(added().iter().cloned()).collect())
}

static BY_NAME: OnceLock<HashMap<&'static str, &'static Category>> = OnceLock::new();

/// The category of that name, also of the hidden ones that build stand-ins.
pub fn category(name: &str) -> Option<&'static Category> {
    let all = || categories().iter().chain(super::stand_in::hidden_categories());
    let by_name = BY_NAME.get_or_init(|| all().map(|category| (category.name.as_str(), category)).collect());
    by_name.get(name).copied()
}

static BY_WORD: OnceLock<HashMap<String, &'static Category>> = OnceLock::new();

/// The category with this name, label or synonym, singular. Case, hyphens and underscores do not matter.
pub fn category_called(noun: &str) -> Option<&'static Category> {
    let words = |category: &'static Category| category.words().map(move |word| (normalized(word), category));
    let by_word = BY_WORD.get_or_init(|| categories().iter().flat_map(words).collect());
    by_word.get(&normalized(noun)).copied()
}

#[cfg(test)]
mod tests;
