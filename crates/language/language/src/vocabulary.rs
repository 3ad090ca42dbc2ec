//! Words of phrases: colors, materials, numbers, plurals, superclasses. They come from `config/catalog/words.toml` and
//! `themes.toml`, which the text parser of scenes reads too, so that both know the same words.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::LazyLock;

use serde::Deserialize;

use geometry::Rgb;

#[derive(Deserialize)]
pub struct Vocabulary {
    pub numbers: BTreeMap<String, u32>,
    colors: BTreeMap<String, String>,
    /// Mix toward white (positive) or black (negative).
    shades: BTreeMap<String, f32>,
    pub materials: BTreeMap<String, MaterialWord>,
    /// Meters.
    pub units: BTreeMap<String, f64>,
    /// Nouns for the table itself.
    tables: BTreeMap<String, String>,
    aliases: BTreeMap<String, Vec<String>>,
    drinks: BTreeMap<String, Vec<String>>,
    short_names: BTreeMap<String, String>,
    grammar: Grammar,
}

/// A word for a material.
#[derive(Clone, Debug, Deserialize)]
pub struct MaterialWord {
    /// Name in `config/materials.toml`.
    pub substance: String,
    /// Finish of tables in this material, if there is one.
    pub table: Option<String>,
    /// The implied color, `#rrggbb`.
    pub color: Option<String>,
}

#[derive(Deserialize)]
struct Grammar {
    plural_only: BTreeSet<String>,
    invariant: BTreeSet<String>,
    irregular_plurals: BTreeMap<String, String>,
}

#[derive(Deserialize)]
struct Themes {
    theme: Vec<Theme>,
    vague: Vec<VagueSet>,
}

#[derive(Deserialize)]
struct Theme {
    name: String,
    keywords: Vec<String>,
    hints: Vec<String>,
}

/// A word for objects of several categories ("toy").
#[derive(Deserialize)]
pub struct VagueSet {
    pub words: Vec<String>,
    /// Names of categories.
    pub members: Vec<String>,
}

static VOCABULARY: LazyLock<Vocabulary> = LazyLock::new(|| {
    toml::from_str(include_str!("../../../../config/catalog/words.toml"))
        .expect("the built-in words parse (a test loads them)")
});

static THEMES: LazyLock<Themes> = LazyLock::new(|| {
    toml::from_str(include_str!("../../../../config/catalog/themes.toml"))
        .expect("the built-in themes parse (a test loads them)")
});

/// The built-in words.
pub fn vocabulary() -> &'static Vocabulary {
    &VOCABULARY
}

/// Words for objects of several categories.
pub fn vague_sets() -> &'static [VagueSet] {
    &THEMES.vague
}

/// The color of a word or of two ("red", "sky blue", "dark green"), case-insensitive; `None` for other words.
///
/// ```
/// assert!(language::vocabulary::color_of("dark green").is_some());
/// assert!(language::vocabulary::color_of("heavy").is_none());
/// ```
pub fn color_of(words: &str) -> Option<Rgb> {
    let words = words.to_lowercase().replace('-', " ");
    if words.starts_with('#') {
        return read_hex(&words);
    }
    let plain = |word: &str| VOCABULARY.colors.get(word).and_then(|hex| read_hex(hex));
    plain(&words).or_else(|| {
        let (shade, color) = words.split_once(' ')?;
        let amount = *VOCABULARY.shades.get(shade)?;
        let toward = if amount > 0.0 { Rgb::hex(0xff_ff_ff) } else { Rgb::hex(0) };
        Some(plain(color)?.mix(toward, amount.abs()))
    })
}

/// The material of a word ("wooden", "stainless steel"), case-insensitive; `None` for other words.
pub fn material_of(words: &str) -> Option<&'static MaterialWord> {
    VOCABULARY.materials.get(&words.to_lowercase().replace('-', " "))
}

/// The name of the theme that a word names ("kitchen" is `kitchen_prep`), case-insensitive; `None` for other words.
pub fn theme_of(words: &str) -> Option<&'static str> {
    let words = words.to_lowercase().replace('_', " ");
    let themes = &THEMES.theme;
    let named = themes.iter().find(|theme| theme.name.replace('_', " ") == words);
    let keyed = || themes.iter().find(|theme| theme.keywords.contains(&words));
    let hinted = || themes.iter().find(|theme| theme.hints.contains(&words));
    named.or_else(keyed).or_else(hinted).map(|theme| theme.name.as_str())
}

fn read_hex(hex: &str) -> Option<Rgb> {
    u32::from_str_radix(hex.trim_start_matches('#'), 16).ok().map(Rgb::hex)
}

/// A whole number above zero in words or digits.
pub fn number(word: &str) -> Option<usize> {
    let named = || VOCABULARY.numbers.get(word).map(|&number| number as usize);
    word.parse().ok().or_else(named).filter(|&number| number > 0)
}

impl Vocabulary {
    /// Whether words are a color ("dark blue").
    pub fn is_color(&self, words: &str) -> bool {
        color_of(words).is_some()
    }

    /// Whether words are a material ("stainless steel").
    pub fn is_material(&self, words: &str) -> bool {
        self.materials.contains_key(words)
    }

    /// Whether a word states a rank or a side.
    pub fn is_order(&self, word: &str) -> bool {
        const RANKS: &[&str] = &[
            "first",
            "second",
            "third",
            "fourth",
            "fifth",
            "sixth",
            "seventh",
            "eighth",
            "ninth",
            "tenth",
            "last",
            "middle",
            "leftmost",
            "rightmost",
            "frontmost",
            "backmost",
            "nearest",
            "closest",
            "farthest",
            "furthest",
            "topmost",
            "lowest",
            "left",
            "right",
            "front",
            "back",
            "largest",
            "biggest",
            "smallest",
            "tallest",
            "shortest",
            "longest",
            "heaviest",
            "lightest",
            "larger",
            "bigger",
            "smaller",
            "taller",
            "shorter",
            "longer",
        ];
        RANKS.contains(&word)
    }

    pub fn is_table(&self, words: &str) -> bool {
        self.tables.contains_key(words)
    }

    pub fn is_shade(&self, word: &str) -> bool {
        self.shades.contains_key(word)
    }

    /// Number of words from `at` on that are a color: one or two.
    pub fn color_length(&self, words: &[String], at: usize) -> Option<usize> {
        [2, 1].into_iter().find(|&length| {
            words.get(at..at + length).is_some_and(|words| color_of(&words.join(" ")).is_some())
        })
    }

    /// Number of words from `at` on that are a material: one or two.
    pub fn material_length(&self, words: &[String], at: usize) -> Option<usize> {
        [2, 1].into_iter().find(|&length| {
            words.get(at..at + length).is_some_and(|words| self.materials.contains_key(&words.join(" ")))
        })
    }

    /// The plural of a phrase: that of its last word.
    pub fn plural_of(&self, phrase: &str) -> String {
        let (head, last) = split_last(phrase);
        let grammar = &self.grammar;
        let vowel_y = || ["ay", "ey", "oy", "uy"].iter().any(|ending| last.ends_with(ending));
        let plural = if let Some(irregular) = grammar.irregular_plurals.get(last) {
            irregular.clone()
        } else if grammar.invariant.contains(last) || grammar.plural_only.contains(last) {
            last.to_owned()
        } else if ["s", "x", "z", "ch", "sh"].iter().any(|ending| last.ends_with(ending)) {
            format!("{last}es")
        } else if last.ends_with('y') && !vowel_y() {
            format!("{}ies", &last[..last.len() - 1])
        } else {
            format!("{last}s")
        };
        format!("{head}{plural}")
    }

    /// The singular of a phrase whose last word is a plural; `None` if no plural is spelled like that.
    pub fn singular_of(&self, phrase: &str) -> Option<String> {
        let (head, last) = split_last(phrase);
        let irregular = self.grammar.irregular_plurals.iter().find(|(_, plural)| *plural == last);
        let endings = ["sses", "buses", "lenses", "xes", "zzes", "ches", "shes"];
        let singular = if let Some((singular, _)) = irregular {
            singular.clone()
        } else if self.grammar.plural_only.contains(last) || last.ends_with("ss") {
            return None;
        } else if let Some(stem) = last.strip_suffix("ies") {
            format!("{stem}y")
        } else if endings.iter().any(|ending| last.ends_with(ending)) {
            last[..last.len() - 2].to_owned()
        } else {
            last.strip_suffix('s').filter(|stem| stem.len() > 1)?.to_owned()
        };
        Some(format!("{head}{singular}"))
    }

    /// Whether the last word is spelled as a plural that means one ("scissors").
    pub fn is_plural_only(&self, phrase: &str) -> bool {
        self.grammar.plural_only.contains(phrase) || self.grammar.plural_only.contains(split_last(phrase).1)
    }

    /// Everyday words for a category beside the catalog's own synonyms.
    pub fn is_alias(&self, category: &str, noun: &str) -> bool {
        let listed = |words: &BTreeMap<String, Vec<String>>| {
            words.get(category).is_some_and(|words| words.iter().any(|word| word == noun))
        };
        listed(&self.aliases)
            || listed(&self.drinks)
            || self.short_names.get(noun).is_some_and(|name| name == category)
    }

    /// Whether the word alone is a drink ("water"), which stands for a vessel of it.
    pub fn is_drink(&self, noun: &str) -> bool {
        self.drinks.values().flatten().any(|word| word == noun)
    }

    pub fn is_alias_of_any(&self, noun: &str) -> bool {
        let mut words = self.aliases.values().chain(self.drinks.values()).flatten();
        words.any(|word| word == noun) || self.short_names.contains_key(noun)
    }
}

/// Splits a phrase into the part before the last word, with the space, and the last word.
fn split_last(phrase: &str) -> (&str, &str) {
    phrase.split_at(phrase.rfind(' ').map_or(0, |space| space + 1))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn plurals_and_singulars_are_inverse() {
        let words = vocabulary();
        let pairs =
            [("mug", "mugs"), ("wine glass", "wine glasses"), ("knife", "knives"), ("battery", "batteries")];
        for (one, many) in pairs {
            assert_eq!(words.plural_of(one), many);
            assert_eq!(words.singular_of(many).as_deref(), Some(one));
        }
        assert_eq!(words.singular_of("scissors"), None);
        assert_eq!(words.singular_of("glass"), None);
    }

    #[test]
    fn colors_materials_and_themes_are_found_by_their_words() {
        let (blue, dark) = (color_of("blue").expect("a color"), color_of("dark blue").expect("a shade"));
        assert!(dark.0.iter().sum::<f32>() < blue.0.iter().sum());
        assert!(color_of("Sky Blue").is_some() && color_of("blue dark").is_none());
        assert_eq!(material_of("wooden").map(|word| word.substance.as_str()), Some("wood"));
        assert_eq!(theme_of("kitchen"), Some("kitchen_prep"));
        assert_eq!(theme_of("submarine"), None);
    }
}
