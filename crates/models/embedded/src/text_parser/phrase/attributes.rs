//! Attributes of noun phrases: colors, materials, sizes, measures and shapes.

use crate::text_parser::measures::Measure;
use crate::text_parser::property::Property;
use geometry::Rgb;

/// Attributes given by the modifiers of a phrase.
#[derive(Clone, Debug, Default, PartialEq)]
pub(in crate::text_parser) struct Attributes {
    /// Two or more for "red and blue mugs".
    pub colors: Vec<Rgb>,
    pub color_words: Vec<String>,
    pub substance: Option<String>,
    /// Color implied by the material.
    pub material_color: Option<Rgb>,
    pub table_finish: Option<String>,
    /// Factor on all extents.
    pub scale: f64,
    /// Factors on single extents (axis letter, factor).
    pub stretches: Vec<(char, f64)>,
    pub measures: Vec<Measure>,
    pub volume_m3: Option<f64>,
    pub mass_kg: Option<f64>,
    /// A key of `[shapes]`.
    pub shape: Option<String>,
    /// Two or more for "wooden and plastic spoons": the objects have them in turn.
    pub variants: Vec<Variant>,
}

/// A material or a size of a list of such properties.
#[derive(Clone, Debug, PartialEq)]
pub(in crate::text_parser) struct Variant {
    pub word: String,
    pub property: Property,
    pub substance: Option<String>,
    pub material_color: Option<Rgb>,
    pub scale: f64,
}

impl Attributes {
    pub fn plain() -> Self {
        Self { scale: 1.0, ..Self::default() }
    }

    /// The attributes of the object with this number, where the text lists several colors, materials or sizes.
    pub fn of_object(&self, number: usize) -> Self {
        let mut own = self.clone();
        if own.colors.len() > 1 {
            let pick = number % own.colors.len();
            own.colors.swap(0, pick);
        }
        if let Some(variant) = self.variants.get(number % self.variants.len().max(1)) {
            if variant.property == Property::Material {
                own.substance = variant.substance.clone();
                own.material_color = variant.material_color;
            } else {
                own.scale = variant.scale;
            }
        }
        own
    }

    /// Number of different colors, materials or sizes that the text lists.
    pub fn kinds(&self) -> usize {
        self.colors.len().max(self.variants.len())
    }
}
