//! The function words and modifiers of `config/catalog/words.toml`.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::LazyLock;

use indexmap::IndexMap;
use serde::Deserialize;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Vocabulary {
    pub numbers: BTreeMap<String, u32>,
    /// Minimum and maximum count of a vague quantity.
    pub quantities: BTreeMap<String, [u32; 2]>,
    pub plural: PluralCounts,
    /// `#rrggbb`.
    pub colors: BTreeMap<String, String>,
    /// Mix toward white (positive) or black (negative).
    pub shades: BTreeMap<String, f32>,
    pub materials: BTreeMap<String, MaterialWord>,
    pub sizes: BTreeMap<String, f64>,
    pub stretch: BTreeMap<String, Stretch>,
    /// Meters.
    pub units: BTreeMap<String, f64>,
    /// Cubic meters.
    pub volumes: BTreeMap<String, f64>,
    /// Kilograms.
    pub masses: BTreeMap<String, f64>,
    /// Poses and states of objects.
    pub states: BTreeMap<String, String>,
    pub shapes: BTreeMap<String, String>,
    pub tables: BTreeMap<String, String>,
    pub aliases: IndexMap<String, Vec<String>>,
    pub drinks: IndexMap<String, Vec<String>>,
    /// Nouns that alone, but not as heads of compounds, name a category.
    pub short_names: BTreeMap<String, String>,
    /// Categories of closed packages, whose contents are no objects.
    pub packages: BTreeMap<String, String>,
    pub grammar: GrammarWords,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct PluralCounts {
    pub bare: [u32; 2],
    pub contents: [u32; 2],
}

#[derive(Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct MaterialWord {
    /// Name in `config/materials.toml`.
    pub substance: String,
    /// Finish of tables in this material, if there is one.
    pub table: Option<String>,
    /// The implied color.
    pub color: Option<String>,
}

#[derive(Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Stretch {
    /// `x`, `y`, `z`, or `l` for the longer horizontal one.
    pub axis: char,
    pub factor: f64,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct GrammarWords {
    pub plural_only: BTreeSet<String>,
    pub invariant: BTreeSet<String>,
    pub irregular_plurals: BTreeMap<String, String>,
    pub determiners: BTreeSet<String>,
    pub partitives: BTreeSet<String>,
    pub piles: BTreeSet<String>,
    pub substances: BTreeSet<String>,
    pub parts: BTreeSet<String>,
    pub stop: BTreeSet<String>,
    /// The closed list of words without an effect of their own.
    pub ignorable: BTreeSet<String>,
    /// Words that end a noun phrase where they follow a noun.
    pub after_noun: BTreeSet<String>,
    pub soft_endings: Vec<String>,
    pub hard_nouns: BTreeSet<String>,
    /// Common words that are no nouns for objects and no misspellings of such.
    pub common: BTreeSet<String>,
    /// Nouns that are likelier misspellings of the words for common objects.
    pub rare_nouns: BTreeSet<String>,
    pub compound_heads: BTreeSet<String>,
    pub openers: BTreeSet<String>,
    pub closers: BTreeSet<String>,
    /// Words that end a noun phrase, unless they belong to a phrase of the lexicon.
    pub boundaries: BTreeSet<String>,
    pub scene_words: BTreeSet<String>,
}

static VOCABULARY: LazyLock<Vocabulary> = LazyLock::new(|| {
    toml::from_str(include_str!("../../../../../config/catalog/words.toml"))
        .expect("the built-in words parse (a test loads them)")
});

pub(super) fn vocabulary() -> &'static Vocabulary {
    &VOCABULARY
}

impl Vocabulary {
    /// The plural of a phrase: that of its last word.
    pub fn plural_of(&self, phrase: &str) -> String {
        let (head, last) = phrase.rsplit_once(' ').map_or(("", phrase), |(head, last)| (head, last));
        let plural = if let Some(irregular) = self.grammar.irregular_plurals.get(last) {
            irregular.clone()
        } else if self.grammar.invariant.contains(last) || self.grammar.plural_only.contains(last) {
            last.to_owned()
        } else if ["s", "x", "z", "ch", "sh"].iter().any(|ending| last.ends_with(ending)) {
            format!("{last}es")
        } else if last.ends_with('y') && !["ay", "ey", "oy", "uy"].iter().any(|e| last.ends_with(e)) {
            format!("{}ies", &last[..last.len() - 1])
        } else {
            format!("{last}s")
        };
        if head.is_empty() { plural } else { format!("{head} {plural}") }
    }

    /// The singular of a phrase whose last word is a plural.
    pub fn singular_of(&self, phrase: &str) -> String {
        let (head, last) = phrase.rsplit_once(' ').map_or(("", phrase), |(head, last)| (head, last));
        let irregular = self.grammar.irregular_plurals.iter().find(|(_, plural)| *plural == last);
        let singular = if let Some((singular, _)) = irregular {
            singular.clone()
        } else if self.grammar.plural_only.contains(last) || last.ends_with("ss") {
            last.to_owned()
        } else if let Some(stem) = last.strip_suffix("ies") {
            format!("{stem}y")
        } else if ["sses", "buses", "lenses", "xes", "zzes", "ches", "shes"]
            .iter()
            .any(|ending| last.ends_with(ending))
        {
            last[..last.len() - 2].to_owned()
        } else {
            last.strip_suffix('s').unwrap_or(last).to_owned()
        };
        if head.is_empty() { singular } else { format!("{head} {singular}") }
    }

    /// Whether the word occurs in any of the lists.
    pub fn has_word(&self, word: &str) -> bool {
        let grammar = &self.grammar;
        let phrases =
            self.quantities.keys().chain(self.states.keys()).chain(&grammar.openers).chain(&grammar.closers);
        self.is_listed(word)
            || grammar.ignorable.contains(word)
            || grammar.after_noun.contains(word)
            || grammar.scene_words.contains(word)
            || grammar.common.contains(word)
            || grammar.compound_heads.contains(word)
            || self.volumes.contains_key(word)
            || self.masses.contains_key(word)
            || self.states.contains_key(word)
            || phrases.flat_map(|phrase| phrase.split(' ')).any(|known| known == word)
    }

    /// Whether a word outside the lexicon is probably not a noun for an object: grammar, a part, a modifier, an adverb.
    pub fn is_ordinary(&self, word: &str) -> bool {
        let grammar = &self.grammar;
        if self.is_listed(word) {
            return true;
        }
        let singular = word.strip_suffix('s').unwrap_or(word);
        !grammar.hard_nouns.contains(singular)
            && word.len() > 4
            && grammar.soft_endings.iter().any(|ending| word.ends_with(ending.as_str()))
    }

    /// Whether the word occurs in a list of words that are no nouns for objects.
    pub fn is_listed(&self, word: &str) -> bool {
        let grammar = &self.grammar;
        grammar.stop.contains(word)
            || grammar.common.contains(word)
            || grammar.parts.contains(word)
            || grammar.substances.contains(word)
            || grammar.determiners.contains(word)
            || grammar.partitives.contains(word)
            || grammar.piles.contains(word)
            || self.colors.contains_key(word)
            || self.shades.contains_key(word)
            || self.materials.contains_key(word)
            || self.sizes.contains_key(word)
            || self.stretch.contains_key(word)
            || self.units.contains_key(word)
            || self.shapes.contains_key(word)
            || self.numbers.contains_key(word)
            || word.chars().count() < 3
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn vocabulary_parses_and_plurals_follow_english() {
        let words = vocabulary();
        for (one, many) in [
            ("mug", "mugs"),
            ("paint brush", "paint brushes"),
            ("utility knife", "utility knives"),
            ("battery", "batteries"),
            ("toy", "toys"),
            ("pair of scissors", "pair of scissors"),
            ("mouse", "mice"),
            ("storage box", "storage boxes"),
            ("vase", "vases"),
            ("bus", "buses"),
            ("wine glass", "wine glasses"),
            ("cookie", "cookies"),
            ("pie", "pies"),
        ] {
            assert_eq!(words.plural_of(one), many);
            assert_eq!(words.singular_of(many), one);
        }
        for color in words.colors.values() {
            assert!(u32::from_str_radix(color.trim_start_matches('#'), 16).is_ok(), "{color}");
        }
        for material in words.materials.values() {
            assert!(catalog::substance(&material.substance).is_some(), "{}", material.substance);
        }
        for shape in words.shapes.values() {
            assert!(words.colors.len() >= 40 && !shape.is_empty());
        }
    }
}
