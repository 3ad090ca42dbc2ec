//! Variants of a finished scene: what may differ, and how much.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::validation::{Violation, Violations};

/// Largest number of variants that one request asks for.
pub const MAX_VARIANTS: u32 = 1000;

/// Differences between a scene and its variants. What a text states of an object (its color, its size, where it is)
/// holds in every variant. `{}` varies everything within the usual ranges; a request that names some axes varies only
/// those.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
#[schemars(description = "The axes along which variants differ.")]
pub struct Randomize {
    /// Places on the table, within the stated relations.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    #[schemars(extend("default" = false))]
    pub layout: bool,
    /// Other meshes of the same category.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    #[schemars(extend("default" = false))]
    pub meshes: bool,
    /// Sizes by a factor from 1 - x to 1 + x, 0..=0.3.
    #[serde(skip_serializing_if = "is_zero")]
    #[schemars(range(min = 0.0, max = 0.3), extend("default" = 0.0))]
    pub sizes: f64,
    /// Colors of objects.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    #[schemars(extend("default" = false))]
    pub colors: bool,
    /// Materials of vessels and dishes, which change mass and friction.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    #[schemars(extend("default" = false))]
    pub materials: bool,
    /// Color or material of the table.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    #[schemars(extend("default" = false))]
    pub table: bool,
    /// Direction and brightness of the light.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    #[schemars(extend("default" = false))]
    pub light: bool,
    /// Azimuth, elevation, distance and focal length of the reference camera.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    #[schemars(extend("default" = false))]
    pub camera: bool,
    /// Masses by a factor from 1 - x to 1 + x, 0..=0.5.
    #[serde(skip_serializing_if = "is_zero")]
    #[schemars(range(min = 0.0, max = 0.5), extend("default" = 0.0))]
    pub mass: f64,
    /// Friction by a factor from 1 - x to 1 + x, 0..=0.5.
    #[serde(skip_serializing_if = "is_zero")]
    #[schemars(range(min = 0.0, max = 0.5), extend("default" = 0.0))]
    pub friction: f64,
}

#[expect(clippy::trivially_copy_pass_by_ref, reason = "serde passes a reference")]
fn is_zero(share: &f64) -> bool {
    *share == 0.0
}

impl Randomize {
    /// Every axis within its usual range.
    pub const USUAL: Self = Self {
        layout: true,
        meshes: true,
        sizes: 0.1,
        colors: true,
        materials: true,
        table: true,
        light: true,
        camera: true,
        mass: 0.2,
        friction: 0.2,
    };

    /// Names of the axes, in the order in which they are applied.
    pub const AXES: [&str; 10] =
        ["meshes", "sizes", "colors", "materials", "mass", "friction", "table", "layout", "light", "camera"];

    /// One axis alone within its usual range; `None` for a name that is no axis.
    pub fn only(axis: &str) -> Option<Self> {
        let mut randomize = Self::default();
        match axis {
            "layout" => randomize.layout = true,
            "meshes" => randomize.meshes = true,
            "sizes" => randomize.sizes = Self::USUAL.sizes,
            "colors" => randomize.colors = true,
            "materials" => randomize.materials = true,
            "table" => randomize.table = true,
            "light" => randomize.light = true,
            "camera" => randomize.camera = true,
            "mass" => randomize.mass = Self::USUAL.mass,
            "friction" => randomize.friction = Self::USUAL.friction,
            _ => return None,
        }
        Some(randomize)
    }

    /// The axes of both.
    #[must_use]
    pub fn and(self, other: Self) -> Self {
        Self {
            layout: self.layout || other.layout,
            meshes: self.meshes || other.meshes,
            sizes: self.sizes.max(other.sizes),
            colors: self.colors || other.colors,
            materials: self.materials || other.materials,
            table: self.table || other.table,
            light: self.light || other.light,
            camera: self.camera || other.camera,
            mass: self.mass.max(other.mass),
            friction: self.friction.max(other.friction),
        }
    }

    /// Returns these axes, or all of the usual ones where none is chosen.
    #[must_use]
    pub fn or_usual(self) -> Self {
        if self == Self::default() { Self::USUAL } else { self }
    }

    /// Every value that is out of its range.
    pub fn violations(&self) -> Vec<Violation> {
        let mut violations = Violations::default();
        violations.require((0.0..=0.3).contains(&self.sizes), "/sizes", "must be from 0 to 0.3");
        violations.require((0.0..=0.5).contains(&self.mass), "/mass", "must be from 0 to 0.5");
        violations.require((0.0..=0.5).contains(&self.friction), "/friction", "must be from 0 to 0.5");
        violations.into_vec()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_axes_together_are_the_usual_ones() {
        let together = Randomize::AXES.iter().filter_map(|axis| Randomize::only(axis));
        assert_eq!(together.fold(Randomize::default(), Randomize::and), Randomize::USUAL);
        assert_eq!(Randomize::only("weather"), None);
        assert_eq!(Randomize::default().or_usual(), Randomize::USUAL);
        let layout = Randomize { layout: true, ..Randomize::default() };
        assert_eq!(layout.or_usual(), layout);
    }

    #[test]
    fn only_what_varies_is_written_and_ranges_are_checked() {
        let read = |json: &str| serde_json::from_str::<Randomize>(json).expect(json);
        for json in ["{}", r#"{"layout":true,"sizes":0.1}"#] {
            assert_eq!(serde_json::to_string(&read(json)).expect("text"), json);
        }
        let pointers: Vec<String> = read(r#"{"sizes":0.5,"mass":-1,"friction":2}"#)
            .violations()
            .into_iter()
            .map(|violation| violation.pointer)
            .collect();
        assert_eq!(pointers, ["/sizes", "/mass", "/friction"]);
        assert!(serde_json::from_str::<Randomize>(r#"{"weather":true}"#).is_err());
    }
}
