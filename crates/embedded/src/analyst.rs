//! The embedded analyst for text: a grammar over the catalog turns a sentence into a description.
//!
//! Method: tokens -> noun phrases (longest match over labels, synonyms and plurals) -> mentions and
//! links (lists, prepositions, pronouns, "with", "each") -> a theme (keywords and what is named) ->
//! objects with sizes, looks, relations -> a table large enough. Words are data
//! (`config/catalog/words.toml`, `themes.toml`). Lengths are meters; left, right, front and back are
//! those of somebody at the front edge.
//!
//! Guarantees: the same text, seed and options give the same description; every recognized object is
//! there with its count; supports form a tree rooted at the table; no text makes it panic. What is not
//! understood is listed in `unrecognized_terms`. Not for other languages than English, nor for long
//! prose: it reads lists and simple sentences.

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

use std::sync::LazyLock;

use serde::{Deserialize, Serialize};

use self::draft::Draft;
use self::grammar::Reading;
use self::lexicon::{Lexicon, Meaning};
pub(crate) use self::table_choice::shape_of as table_shape;
use self::themes::Theme;
use catalog::{categories, table_models};
use geometry::Rgb;
use runtime::seed::child_rng;
use scene::{SceneDescription, TableSpec};

/// Knobs of the analyst.
#[derive(Clone, Debug, Serialize, Deserialize, PartialEq)]
#[serde(deny_unknown_fields)]
pub struct Settings {
    /// Longest text read, characters (1..). More admits prose the grammar reads badly.
    pub max_text_chars: usize,
    /// Fewest objects of a scene the theme completes (1..=64). More fills the table.
    pub fewest_objects: usize,
    /// Most objects of a scene the theme completes (`fewest_objects`..=64).
    pub most_objects: usize,
    /// A text that names its theme and at least this many kinds of things is complete as it is (1..).
    /// More lets themes add to longer lists.
    pub kinds_that_close_a_text: usize,
    /// Table area over the area its objects cover (1.5..10). More gives emptier tables.
    pub table_area_per_footprint: f64,
}

/// What the request adds to its text.
#[derive(Clone, Debug, PartialEq)]
pub struct DescribeOptions {
    /// Refuse descriptions with more objects (1..=64).
    pub max_objects: usize,
    /// Overrides what the text says about the table.
    pub table: Option<TableSpec>,
}

/// Why a text became no description.
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

/// The color a color word of a text means ("navy", "light blue"), as used for `TableSpec::color`.
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

/// Describes the scene a text asks for. Another seed gives another plausible scene of the same text:
/// other sizes, other vague counts, other members of vague sets, another table of the theme.
pub fn describe(
    text: &str,
    seed: u64,
    options: &DescribeOptions,
    settings: &Settings,
) -> Result<SceneDescription, DescribeError> {
    describe_with(&LEXICON, text, seed, options, settings)
}

fn describe_with(
    lexicon: &Lexicon,
    text: &str,
    seed: u64,
    options: &DescribeOptions,
    settings: &Settings,
) -> Result<SceneDescription, DescribeError> {
    let chars = text.chars().count();
    if chars > settings.max_text_chars {
        return Err(DescribeError::TooLong { chars, limit: settings.max_text_chars });
    }
    let tokens = tokens::tokenize(text);
    if tokens.is_empty() {
        return Err(DescribeError::Empty);
    }
    let spoken = tokens.iter().filter_map(tokens::Token::word).collect::<Vec<_>>().join(" ");
    let reading = grammar::read(lexicon, &tokens);
    let (theme, named) = theme_of(lexicon, &reading, &spoken, seed)?;
    let limit = options.max_objects.min(64);

    let mut draft = Draft::new(lexicon, &theme.family, seed);
    counts::instantiate(&mut draft, &reading, limit)?;
    supports::relate(&mut draft, &reading);
    let kinds = reading.mentions.len();
    let says = |words: &std::collections::BTreeSet<String>| {
        words.iter().any(|phrase| themes::has_phrase(&spoken, phrase))
    };
    let grammar = &lexicon.vocabulary.grammar;
    let open = named && kinds < settings.kinds_that_close_a_text || says(&grammar.openers);
    if draft.objects.is_empty() || (open && !says(&grammar.closers)) {
        completion::complete(&mut draft, &reading, theme, settings, limit);
    }
    if draft.objects.is_empty() {
        return Err(nothing_recognized(lexicon, &reading));
    }
    sizing::size(&mut draft);
    supports::keep_what_fits(&mut draft);
    let objects = draft.into_objects();
    let table =
        table_choice::choose(lexicon, &reading, options.table.as_ref(), theme, &objects, seed, settings)?;
    let mut description = SceneDescription {
        theme: theme.name.clone(),
        family: theme.family.clone(),
        table,
        objects,
        unrecognized_terms: reading.unknown,
        prose: String::new(),
    };
    description.prose = prose::write(&description);
    Ok(description)
}

/// The theme and whether the text names it; an error when there is nothing to go on.
fn theme_of<'t>(
    lexicon: &Lexicon<'t>,
    reading: &Reading,
    spoken: &str,
    seed: u64,
) -> Result<(&'t Theme, bool), DescribeError> {
    let named: Vec<(&str, &[String])> = reading
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
    if let Some(choice) = themes::choose_theme(lexicon.themes, spoken, &named) {
        return Ok((choice.theme, choice.named));
    }
    let scene = lexicon.vocabulary.grammar.scene_words.iter().any(|word| themes::has_phrase(spoken, word));
    let bare_table = (reading.table.is_some() || scene) && reading.unknown.is_empty();
    if !bare_table && reading.mentions.is_empty() {
        return Err(nothing_recognized(lexicon, reading));
    }
    // A vague set alone, or a bare table: any theme such a table fits.
    let model = reading.table.as_ref().and_then(|(model, _)| model.clone());
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

fn nothing_recognized(lexicon: &Lexicon, reading: &Reading) -> DescribeError {
    let mut suggestions: Vec<String> = Vec::new();
    for word in reading
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
    DescribeError::NothingRecognized { terms: reading.unknown.clone(), suggestions }
}

#[cfg(test)]
mod tests;
