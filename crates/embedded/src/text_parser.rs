//! Rule-based text parser: a grammar over the catalog converts an English text to a scene description.
//!
//! Method: tokens -> noun phrases (longest match over labels, synonyms and plurals) -> mentions and links (lists,
//! prepositions, pronouns, "with", "each") -> theme (keywords and named categories) -> objects with sizes, attributes
//! and relations -> table of sufficient size. The vocabulary is data (`config/catalog/words.toml`, `themes.toml`).
//! Lengths are in meters. Left, right, front and back are relative to a viewer at the front edge.
//!
//! Guarantees: the same text, seed and options give the same description; every recognized object is present with its
//! count; supports form a tree rooted at the table; no text causes a panic. Terms outside the vocabulary are listed in
//! `unrecognized_terms`. Limits: English only, lists and simple sentences; long prose is parsed poorly.

mod tokens;
mod vocabulary;
mod lexicon;
mod measures;
mod quantity;
mod phrase;
mod prepositions;
mod grammar;
mod themes;
mod draft;
mod counts;
mod supports;
mod completion;
mod sizing;
mod table_choice;
mod prose;
mod error_code;

use std::sync::LazyLock;

use serde::{Deserialize, Serialize};

use self::draft::Draft;
use self::grammar::ParsedText;
use self::lexicon::{Lexicon, Meaning};
pub(crate) use self::table_choice::shape_of as table_shape;
use self::themes::Theme;
use catalog::{categories, table_models};
use geometry::Rgb;
use runtime::seed::child_rng;
use scene::text_account::{TextSpan, Unrecognized, UnrecognizedReason};
use scene::{SceneDescription, TableSpec};

/// Section `[analyst]`.
#[derive(Clone, Debug, Serialize, Deserialize, PartialEq)]
#[serde(deny_unknown_fields)]
pub struct TextParserSettings {
    /// Maximum text length, characters (1..). Higher admits prose that the grammar parses poorly.
    pub max_text_chars: usize,
    /// Minimum number of objects of a scene completed by its theme (1..=64). Higher: fuller tables.
    pub fewest_objects: usize,
    /// Maximum number of objects of a scene completed by its theme (`fewest_objects`..=64).
    pub default_max_objects: usize,
    /// Number of categories from which a text that names its theme is not completed (1..). Higher: themes also complete
    /// longer lists.
    pub kinds_that_close_a_text: usize,
    /// Ratio of table area to total footprint area of the objects (1.5..10). Higher: emptier tables.
    pub table_area_per_footprint: f64,
}

/// Options of the request that apply to its text.
#[derive(Clone, Debug, PartialEq)]
pub struct DescribeOptions {
    /// Maximum number of objects (1..=64); more are an error.
    pub max_objects: usize,
    /// Table specification that overrides the text.
    pub table: Option<TableSpec>,
}

/// Failure to describe a text.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum DescribeError {
    #[error("the text is empty: name a table and what stands on it, such as \"a desk with two mugs\"")]
    Empty,
    #[error("the text has {chars} characters, the most read is {limit}: shorten it to a list of objects")]
    TooLong { chars: usize, limit: usize },
    #[error("no word of the text is a thing the catalog knows{}: name everyday tabletop objects, such as {}",
        unknown_clause(.terms), .suggestions.join(", "))]
    NothingRecognized { terms: Vec<String>, suggestions: Vec<String> },
    #[error(
        "the text asks for {count} objects, the limit is {limit}: ask for fewer, or raise `max_objects` (64 at most)"
    )]
    TooManyObjects { count: usize, limit: usize },
    #[error("there is no table model {model:?}: use one of {}", .known.join(", "))]
    UnknownTableModel { model: String, known: Vec<String> },
}

fn unknown_clause(terms: &[String]) -> String {
    if terms.is_empty() { String::new() } else { format!(" (not known: {})", terms.join(", ")) }
}

static LEXICON: LazyLock<Lexicon<'static>> =
    LazyLock::new(|| Lexicon::new(categories(), table_models(), vocabulary::vocabulary(), themes::themes()));

/// The color of a color word ("navy", "light blue"), as used for `TableSpec::color`.
pub fn color_of_word(word: &str) -> Option<Rgb> {
    let words = vocabulary::vocabulary();
    if let Some(color) = phrase::color_of(words, word) {
        return Some(color);
    }
    let (shade, name) = word.split_once(' ')?;
    let amount = *words.shades.get(shade)?;
    let toward = if amount >= 0.0 { Rgb([1.0; 3]) } else { Rgb([0.0; 3]) };
    phrase::color_of(words, name).map(|color| color.mix(toward, amount.abs()))
}

/// Parses a text into a scene description. Another seed gives another plausible scene for the same text: other sizes,
/// vague counts, members of vague sets, and another table of the theme.
///
/// # Errors
///
/// A [`DescribeError`] if the text is empty, too long or without a known object, if it requests too many objects, or
/// if `options` name an unknown table model.
pub fn describe(
    text: &str,
    seed: u64,
    options: &DescribeOptions,
    settings: &TextParserSettings,
) -> Result<SceneDescription, DescribeError> {
    let lexicon = &*LEXICON;
    let chars = text.chars().count();
    if chars > settings.max_text_chars {
        return Err(DescribeError::TooLong { chars, limit: settings.max_text_chars });
    }
    let tokens = tokens::tokenize(text);
    if tokens.is_empty() {
        return Err(DescribeError::Empty);
    }
    let normalized = tokens.iter().filter_map(tokens::Token::word).collect::<Vec<_>>().join(" ");
    let parsed = grammar::parse(lexicon, &tokens);
    let (theme, named) = theme_of(lexicon, &parsed, &normalized, seed)?;
    let limit = options.max_objects.min(64);

    let mut draft = Draft::new(lexicon, &theme.family, seed);
    counts::instantiate(&mut draft, &parsed, limit)?;
    supports::relate(&mut draft, &parsed);
    let kinds = parsed.mentions.len();
    let says = |words: &std::collections::BTreeSet<String>| {
        words.iter().any(|phrase| themes::has_phrase(&normalized, phrase))
    };
    let grammar = &lexicon.vocabulary.grammar;
    let open = named && kinds < settings.kinds_that_close_a_text || says(&grammar.openers);
    if draft.objects.is_empty() || (open && !says(&grammar.closers)) {
        completion::complete(&mut draft, &parsed, theme, settings, limit);
    }
    if draft.objects.is_empty() {
        return Err(nothing_recognized(lexicon, &parsed));
    }
    sizing::size(&mut draft);
    supports::keep_what_fits(&mut draft);
    let objects = draft.into_objects();
    let table =
        table_choice::choose(lexicon, &parsed, options.table.as_ref(), theme, &objects, seed, settings)?;
    let mut description = SceneDescription {
        theme: theme.name.clone(),
        family: theme.family.clone(),
        table,
        objects,
        table_size_is_stated: false,
        arrangements: Vec::new(),
        goal: None,
        excluded_categories: Vec::new(),
        understood: Vec::new(),
        unrecognized: unrecognized(text, &parsed.unknown),
        prose: String::new(),
    };
    description.prose = prose::write(&description);
    Ok(description)
}

/// Unknown terms with their first place in the text.
fn unrecognized(text: &str, terms: &[String]) -> Vec<Unrecognized> {
    let lower = text.to_ascii_lowercase();
    let at = |term: &String| {
        let start = lower.find(term.as_str()).unwrap_or(0);
        TextSpan { start, end: (start + term.len()).min(text.len()), text: term.clone() }
    };
    terms
        .iter()
        .map(|term| Unrecognized {
            span: at(term),
            reason: UnrecognizedReason::UnknownWord,
            nearest_by_spelling: None,
            nearest_by_meaning: None,
        })
        .collect()
}

/// The theme, and whether the text names it; an error if the text has no recognized content.
fn theme_of<'t>(
    lexicon: &Lexicon<'t>,
    parsed: &ParsedText,
    normalized: &str,
    seed: u64,
) -> Result<(&'t Theme, bool), DescribeError> {
    let named: Vec<(&str, &[String])> = parsed
        .mentions
        .iter()
        .filter_map(|mention| match mention.meanings[0] {
            Meaning::Category(index) => {
                let category = &lexicon.categories[index];
                Some((category.name.as_str(), category.families.as_slice()))
            }
            _ => None,
        })
        .collect();
    if let Some(choice) = themes::choose_theme(lexicon.themes, normalized, &named) {
        return Ok((choice.theme, choice.named));
    }
    let scene =
        lexicon.vocabulary.grammar.scene_words.iter().any(|word| themes::has_phrase(normalized, word));
    let bare_table = (parsed.table.is_some() || scene) && parsed.unknown.is_empty();
    if !bare_table && parsed.mentions.is_empty() {
        return Err(nothing_recognized(lexicon, parsed));
    }
    // A vague set or a table without objects: a random theme that fits the table.
    let model = parsed.table.as_ref().and_then(|(model, _)| model.clone());
    let fitting: Vec<&Theme> = lexicon
        .themes
        .theme
        .iter()
        .filter(|theme| model.as_ref().is_none_or(|model| theme.tables.contains(model)))
        .collect();
    let pool = if fitting.is_empty() { lexicon.themes.theme.iter().collect() } else { fitting };
    use rand::RngExt;
    let pick = child_rng(seed, "theme").random_range(0..pool.len());
    Ok((pool[pick], false))
}

fn nothing_recognized(lexicon: &Lexicon, parsed: &ParsedText) -> DescribeError {
    let mut suggestions: Vec<String> = Vec::new();
    for word in parsed
        .unknown
        .iter()
        .flat_map(|term| std::iter::once(term.as_str()).chain(term.split(' ').filter(|word| word.len() > 3)))
    {
        for close in lexicon.closest(word, 3) {
            if !suggestions.contains(&close) {
                suggestions.push(close);
            }
        }
    }
    if suggestions.is_empty() {
        suggestions = ["mug", "laptop", "book", "plate", "hammer"].map(str::to_owned).to_vec();
    }
    suggestions.truncate(6);
    DescribeError::NothingRecognized { terms: parsed.unknown.clone(), suggestions }
}

#[cfg(test)]
mod tests;
