//! Scene themes and vague sets of `config/catalog/themes.toml`.

use std::collections::BTreeMap;
use std::sync::LazyLock;

use serde::Deserialize;

use super::account::{Account, Claimed};
use super::lexicon::Lexicon;
use super::tokens::{Source, match_phrase};
use scene::RelationKind;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Themes {
    pub theme: Vec<Theme>,
    pub vague: Vec<VagueSet>,
    #[serde(rename = "finish")]
    finishes: Vec<PlaceFinishes>,
}

/// Finishes of tables in a place.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct PlaceFinishes {
    /// Phrases that name the place, or who works there.
    words: Vec<String>,
    /// Materials of tables; one that occurs twice is chosen twice as often.
    materials: Vec<String>,
}

/// A scene theme: its tables and typical objects.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Theme {
    pub name: String,
    pub family: String,
    /// Phrases that name the theme and leave the scene open to completion.
    pub keywords: Vec<String>,
    /// Phrases that add to the theme's score without naming it.
    pub hints: Vec<String>,
    /// Table models that fit the theme.
    pub tables: Vec<String>,
    /// Minimum and maximum number of place settings of a completed scene.
    #[serde(default)]
    pub settings: Option<[u32; 2]>,
    #[serde(rename = "item")]
    pub items: Vec<ThemeItem>,
}

/// An entry of a theme's typical objects.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct ThemeItem {
    #[serde(default)]
    pub category: Option<String>,
    #[serde(default)]
    pub any_of: Vec<String>,
    pub count: [u32; 2],
    pub probability: f64,
    #[serde(default)]
    pub place: Option<RelationKind>,
    #[serde(default)]
    pub relation: Option<RelationKind>,
    /// Target category of the relation.
    #[serde(default)]
    pub target: Option<String>,
    /// Whether the entry is repeated for every instance of `target`.
    #[serde(default)]
    pub each: bool,
    #[serde(default)]
    pub stacked: bool,
}

/// A word for a set of categories ("tools").
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct VagueSet {
    pub words: Vec<String>,
    pub count: [u32; 2],
    pub members: Vec<String>,
    /// Members for scenes of this family.
    #[serde(default)]
    pub by_family: BTreeMap<String, Vec<String>>,
    /// Whether a member may occur more than once.
    #[serde(default)]
    pub repeat: bool,
    /// Whether the set is a place setting: cutlery beside the plate, the glass behind it.
    #[serde(default)]
    pub place_setting: bool,
}

static THEMES: LazyLock<Themes> = LazyLock::new(|| {
    toml::from_str(include_str!("../../../../../config/catalog/themes.toml"))
        .expect("the built-in themes parse (a test loads them)")
});

impl Themes {
    /// Materials that tables have where the text takes place; none where it names no place that is known. The first
    /// place of the list counts.
    pub fn table_materials(&self, text: &str) -> &[String] {
        let named = |place: &&PlaceFinishes| place.words.iter().any(|phrase| has_phrase(text, phrase));
        self.finishes.iter().find(named).map_or(&[], |place| &place.materials)
    }

    /// Whether the word occurs in a phrase that names or suggests a theme.
    pub fn has_word(&self, word: &str) -> bool {
        self.theme
            .iter()
            .flat_map(|theme| theme.keywords.iter().chain(&theme.hints))
            .any(|phrase| has_phrase(phrase, word))
    }
}

pub(super) fn themes() -> &'static Themes {
    &THEMES
}

/// Whether `phrase` occurs in `text` as whole words.
pub(super) fn has_phrase(text: &str, phrase: &str) -> bool {
    let mut from = 0;
    while let Some(found) = text[from..].find(phrase) {
        let (start, end) = (from + found, from + found + phrase.len());
        let before = text[..start].chars().next_back().is_none_or(|c| c == ' ');
        let after = text[end..].chars().next().is_none_or(|c| c == ' ');
        if before && after {
            return true;
        }
        from = start + phrase.chars().next().map_or(1, char::len_utf8);
    }
    false
}

/// Scores every theme: keywords most (longer phrases more), then hints, then named categories that
/// are typical of it or of its family. `None` if no theme has a positive score.
pub(super) fn choose_theme<'t>(
    themes: &'t Themes,
    text: &str,
    categories: &[(&str, &[String])],
) -> Option<&'t Theme> {
    let mut best: Option<(f64, &Theme)> = None;
    for theme in &themes.theme {
        let keyword: f64 = theme
            .keywords
            .iter()
            .filter(|phrase| has_phrase(text, phrase))
            .map(|phrase| 6.0 + phrase.split(' ').count() as f64)
            .fold(0.0, f64::max);
        let hints = theme.hints.iter().filter(|phrase| has_phrase(text, phrase)).count() as f64;
        let votes: f64 = categories
            .iter()
            .map(|(name, families)| {
                let typical = theme.items.iter().any(|item| item.names().any(|n| n == *name));
                let family = families.contains(&theme.family);
                f64::from(u8::from(typical)) + 0.5 * f64::from(u8::from(family))
            })
            .sum();
        let share = if categories.is_empty() { 0.0 } else { 2.0 * votes / categories.len() as f64 };
        let score = keyword + hints + share;
        if score > 0.0 && best.as_ref().is_none_or(|(top, _)| score > *top + 1e-9) {
            best = Some((score, theme));
        }
    }
    best.map(|(_, theme)| theme)
}

/// Claims the words of the text that name the theme, where they have no other meaning.
pub(super) fn claim_words(theme: &Theme, lexicon: &Lexicon, source: &Source, account: &mut Account) {
    let others = lexicon.themes.theme.iter().filter(|other| other.name != theme.name);
    let own = theme.keywords.iter().chain(&theme.hints);
    let phrases: Vec<&String> = own
        .chain(others.flat_map(|other| &other.keywords))
        .chain(&lexicon.vocabulary.grammar.scene_words)
        .collect();
    for at in 0..source.tokens.len() {
        if !account.is_open(at) || source.tokens[at].word().is_none() {
            continue;
        }
        let longest = phrases.iter().filter_map(|phrase| match_phrase(&source.tokens, at, phrase)).max();
        if let Some(length) = longest.filter(|length| (at..at + length).all(|token| account.is_open(token))) {
            account.claim(at..at + length, Claimed::Theme);
        }
    }
}

impl ThemeItem {
    /// All categories of the entry.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.category.iter().chain(&self.any_of).map(String::as_str)
    }
}

impl VagueSet {
    pub fn members_in(&self, family: &str) -> &[String] {
        self.by_family.get(family).unwrap_or(&self.members)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tables_have_the_finishes_of_their_place() {
        let themes = themes();
        assert!(themes.table_materials("a laboratory bench with a microscope").contains(&"white".to_owned()));
        assert_eq!(themes.table_materials("a table with a barometer"), <[String; 0]>::default());
        for material in themes.finishes.iter().flat_map(|place| &place.materials) {
            let size_m = glam::DVec3::new(1.2, 0.7, 0.75);
            let built = catalog::build_table("desk", size_m, None, Some(material), 1).expect("a desk");
            let names: Vec<&str> = built.mesh.materials.iter().map(|known| known.name.as_str()).collect();
            let known = names.iter().any(|name| name == material)
                || (matches!(material.as_str(), "white" | "black") && names.contains(&"paint"));
            assert!(known, "{material}: {names:?}");
        }
    }

    #[test]
    fn themes_parse_and_cover_all_families() {
        let themes = themes();
        assert!(themes.theme.len() >= 12);
        for family in ["office_living", "dining_kitchen", "workbench_utility", "crafting_hobby"] {
            assert!(themes.theme.iter().filter(|theme| theme.family == family).count() >= 3, "{family}");
        }
        for theme in &themes.theme {
            for table in &theme.tables {
                assert!(catalog::table_models().iter().any(|m| m.name == table), "{table}");
            }
            for item in &theme.items {
                assert!(item.names().next().is_some(), "{}", theme.name);
                if let Some(target) = &item.target {
                    assert!(theme.items.iter().any(|other| other.names().any(|n| n == target)), "{target}");
                }
            }
        }
    }

    #[test]
    fn has_phrase_matches_whole_words_of_any_script() {
        assert!(has_phrase("an art table", "art") && !has_phrase("a party", "art"));
        assert!(!has_phrase("ääart ärt", "art"));
    }
}
