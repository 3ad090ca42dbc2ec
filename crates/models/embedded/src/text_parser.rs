//! Rule-based text parser: a grammar over the catalog converts an English text to a scene description.
//!
//! Method: tokens with their positions -> noun phrases (longest match over labels, synonyms and plurals; the head noun
//! decides) -> mentions and links (lists, prepositions, pronouns, negation, arrangements, instructions) -> theme
//! (keywords and named categories) -> objects with sizes, attributes and relations, in the start state of the goal ->
//! table of sufficient size. The vocabulary is data (`config/catalog/words.toml`, `verbs.toml`, `phrases.toml`,
//! `themes.toml`). Lengths are in meters. Left, right, front and back are relative to a viewer at the front edge.
//!
//! Guarantees: the same text, seed and options give the same description; every recognized object is present with its
//! count; supports form a tree rooted at the table; no text causes a panic; the time is linear in the text. Every word
//! is accounted for: it is part of `understood` or `unrecognized`, or of a closed list of ignorable words. Limits:
//! English only, lists, simple sentences and instructions; long prose is parsed poorly.

mod tokens;
mod json_input;
mod vocabulary;
mod verbs;
mod phrases;
mod nouns;
mod lexicon;
mod correction;
mod taken_back;
mod language;
mod position_verbs;
mod account;
mod property;
mod measures;
mod quantity;
mod phrase;
mod prepositions;
mod grammar;
mod themes;
mod draft;
mod counts;
mod supports;
mod start_state;
mod completion;
mod place_settings;
mod measured_size;
mod sizing;
mod table_choice;
mod arranged;
mod understood;
mod prose;
mod error_code;

use std::sync::LazyLock;

use serde::{Deserialize, Serialize};

use self::account::Claimed;
use self::draft::Draft;
use self::grammar::ParsedText;
use self::lexicon::{Lexicon, Meaning};
use self::property::Property;
pub(crate) use self::table_choice::shape_of as table_shape;
use self::themes::Theme;
use self::tokens::Source;
use catalog::{categories, table_models};
use geometry::Rgb;
use runtime::seed::child_rng;
use scene::request::OnUnknown;
use scene::text_account::{Goal, GoalPredicate, Unrecognized, UnrecognizedReason};
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
    /// Treatment of objects that the catalog does not have.
    pub on_unknown: OnUnknown,
}

/// Failure to describe a text.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum DescribeError {
    #[error("the text is empty: name a table and what stands on it, such as \"a desk with two mugs\"")]
    Empty,
    #[error("the text has {chars} characters, the most read is {limit}: shorten it to a list of objects")]
    TooLong { chars: usize, limit: usize },
    #[error("no word of the text names an object of the catalog{}: name everyday tabletop objects, such as {}",
        unknown_clause(.terms), .suggestions.join(", "))]
    NothingRecognized { terms: Vec<String>, suggestions: Vec<String> },
    #[error(
        "the text asks for {count} objects, the limit is {limit}: ask for fewer, or raise `max_objects` (64 at most)"
    )]
    TooManyObjects { count: usize, limit: usize },
    #[error("most words of the text are not known ({}): write the text in English, such as \"a desk with two mugs\"",
        .words.join(", "))]
    NotEnglish { words: Vec<String> },
    #[error("the text has parts that are not understood: {}; remove or reword them, or set `on_unknown` to `stand_in` or \
        `drop`", .parts.iter().map(described).collect::<Vec<_>>().join(", "))]
    NotUnderstood { parts: Vec<Unrecognized> },
    #[error("there is no table model {model:?}: use one of {}", .known.join(", "))]
    UnknownTableModel { model: String, known: Vec<String> },
}

fn unknown_clause(terms: &[String]) -> String {
    if terms.is_empty() { String::new() } else { format!(" (not known: {})", terms.join(", ")) }
}

/// A part of the text with its position and the nearest known word.
fn described(part: &Unrecognized) -> String {
    let nearest = part.nearest_by_meaning.as_ref().or(part.nearest_by_spelling.as_ref());
    let hint = nearest.map_or(String::new(), |nearest| format!(", nearest is {nearest:?}"));
    format!("{:?} (bytes {} to {}{hint})", part.span.text, part.span.start, part.span.end)
}

static LEXICON: LazyLock<Lexicon<'static>> = LazyLock::new(|| {
    Lexicon::new(
        categories(),
        table_models(),
        vocabulary::vocabulary(),
        themes::themes(),
        &nouns::WordNetNouns,
    )
});

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
/// A [`DescribeError`] if the text is empty, too long, not English or without a known object, if it requests too many
/// objects, if `options` name an unknown table model, or if a part of the text is not understood and `options` do not
/// permit that.
pub fn describe(
    text: &str,
    seed: u64,
    options: &DescribeOptions,
    settings: &TextParserSettings,
) -> Result<SceneDescription, DescribeError> {
    describe_with(&LEXICON, text, seed, options, settings)
}

fn describe_with(
    lexicon: &Lexicon<'static>,
    text: &str,
    seed: u64,
    options: &DescribeOptions,
    settings: &TextParserSettings,
) -> Result<SceneDescription, DescribeError> {
    let chars = text.chars().count();
    if chars > settings.max_text_chars {
        return Err(DescribeError::TooLong { chars, limit: settings.max_text_chars });
    }
    let mut source = json_input::read(text).unwrap_or_else(|| {
        let mut source = Source::read(text);
        taken_back::take_back(&mut source);
        source
    });
    if source.tokens.is_empty() {
        return Err(DescribeError::Empty);
    }
    let corrections = correction::correct(lexicon, &mut source);
    let corrections: Vec<_> =
        corrections.into_iter().map(|(token, word)| (source.spans[token].clone(), word)).collect();
    if let Some(words) = language::foreign_words(lexicon, &source) {
        return Err(DescribeError::NotEnglish { words: words.into_iter().take(12).collect() });
    }
    source.separate_bare_nouns(lexicon);
    position_verbs::separate(lexicon, &mut source);
    let normalized = source.tokens.iter().filter_map(tokens::Token::word).collect::<Vec<_>>().join(" ");
    let mut parsed = grammar::parse(lexicon, &source, options.on_unknown == OnUnknown::StandIn);
    for (span, corrected) in corrections {
        // Separation inserts tokens, so that those of corrected words are found by their place in the text.
        if let Some(token) = source.spans.iter().position(|other| *other == span) {
            parsed.account.note(token..token + 1, Claimed::Correction(corrected));
        }
    }
    let theme = theme_of(lexicon, &parsed, &normalized, seed)?;
    let limit = options.max_objects.min(64);

    let mut draft = Draft::new(lexicon, &theme.family, seed);
    counts::instantiate(&mut draft, &parsed, limit)?;
    supports::relate(&mut draft, &parsed);
    // "Afternoon tea" and "an electronics bench" name the theme, not objects.
    let names_theme = |words: &str| {
        let keywords = theme.keywords.iter().filter(|keyword| themes::has_phrase(&normalized, keyword));
        keywords
            .into_iter()
            .any(|keyword| themes::has_phrase(keyword, words) || themes::has_phrase(words, keyword))
    };
    let is_vague = |meanings: &[Meaning]| matches!(meanings.first(), Some(Meaning::Vague(_)));
    let is_bare = parsed.mentions.iter().all(|mention| {
        (mention.count.is_none() || is_vague(&mention.meanings)) && names_theme(&mention.words)
    });
    let is_open = completion::is_open(lexicon, &mut parsed, &source, is_bare);
    if is_open {
        completion::complete(&mut draft, &parsed, theme, settings, limit);
    } else {
        place_settings::complete_settings(&mut draft, &parsed, limit);
    }
    themes::claim_words(theme, lexicon, &source, &mut parsed.account);
    if draft.objects.is_empty() {
        return Err(nothing_recognized(lexicon, &parsed));
    }
    let out_of_range = sizing::size(&mut draft);
    place_settings::make_alike(&mut draft);
    let without_room = supports::keep_what_fits(&mut draft);
    let (surplus, misfits): (Vec<usize>, Vec<usize>) =
        without_room.into_iter().partition(|object| is_surplus(&draft, &parsed, *object));
    for object in misfits {
        report_support(&draft, &mut parsed, object);
    }
    surplus.into_iter().rev().for_each(|object| draft.remove(object));
    let goals = start_state::predicates(&draft, &parsed);
    report_empty(&mut parsed, &goals);
    let start_state::Unviolated { satisfied, unshown } =
        start_state::stand_apart(&mut draft, &goals.predicates);
    report_unshown(&mut parsed, &goals, &unshown);
    for object in out_of_range {
        report_measures(&draft, &mut parsed, object);
    }
    for object in sizing::contradictions(&draft) {
        report_last_measure(&draft, &mut parsed, object);
    }
    if !satisfied.is_empty() {
        for range in parsed.instructions.clone() {
            parsed.account.report(range, UnrecognizedReason::NotExpressible);
        }
    }
    counts::retract_others(&draft, &mut parsed, &source);
    parsed.account.close(&source, lexicon);
    let ids = draft.ids();
    let predicates: Vec<GoalPredicate> = goals
        .predicates
        .iter()
        .filter(|predicate| !satisfied.contains(predicate))
        .map(|predicate| GoalPredicate {
            predicate: predicate.kind,
            object: ids[predicate.object].clone(),
            target: predicate.target.map(|target| ids[target].clone()),
            second_target: predicate.second.map(|second| ids[second].clone()),
        })
        .collect();
    let goal = (!predicates.is_empty())
        .then(|| Goal { instruction: instruction_text(&source, &parsed), predicates });
    let arrangements = arranged::arrangements(&draft, &parsed);
    let unrecognized = understood::unrecognized(lexicon, &parsed.account, &source);
    if options.on_unknown == OnUnknown::Fail && !unrecognized.is_empty() {
        return Err(DescribeError::NotUnderstood { parts: unrecognized });
    }
    let understood = understood::understood(&draft, &parsed, &source, &theme.name, &goals.of_goal);
    let objects = draft.into_objects();
    let mut table =
        table_choice::choose(lexicon, &parsed, options.table.as_ref(), theme, &objects, seed, settings)?;
    table_choice::finish_by_place(&mut table, lexicon, &normalized, seed);
    let mut description = SceneDescription {
        theme: theme.name.clone(),
        family: theme.family.clone(),
        table,
        table_size_is_stated: table_choice::size_is_stated(&parsed, options.table.as_ref()),
        objects,
        arrangements,
        goal,
        excluded_categories: understood::categories_of(lexicon, &parsed.excluded),
        understood,
        unrecognized,
        prose: String::new(),
    };
    description.prose = prose::write(&description);
    Ok(description)
}

/// Whether the object is one more of contents without a stated number ("a plate of pancakes"), of which others fit.
fn is_surplus(draft: &Draft, parsed: &ParsedText, object: usize) -> bool {
    let mention = draft.of_mention.iter().position(|objects| objects.contains(&object));
    mention.is_some_and(|m| {
        let mention = &parsed.mentions[m];
        mention.contents && mention.count.is_none() && draft.of_mention[m].first() != Some(&object)
    })
}

/// Reports the relation of an object to a support on which it does not fit.
fn report_support(draft: &Draft, parsed: &mut ParsedText, object: usize) {
    let Some(mention) = draft.of_mention.iter().position(|objects| objects.contains(&object)) else { return };
    let relations: Vec<_> = parsed
        .account
        .claims
        .iter()
        .filter_map(|claim| match &claim.meaning {
            Claimed::Relation { kind, from, .. } if kind.is_support() && from.contains(&mention) => {
                Some(claim.tokens.clone())
            }
            _ => None,
        })
        .collect();
    // Where the first objects of the mention fit, the relation has an effect.
    let first = draft.of_mention[mention].first() == Some(&object);
    for tokens in relations {
        if first {
            parsed.account.retract(&tokens);
        }
        parsed.account.report(tokens, UnrecognizedReason::NotSupported);
    }
}

/// Reports the goals that these objects cannot have ("gather the tray").
fn report_empty(parsed: &mut ParsedText, goals: &start_state::Predicates) {
    let states = |meaning: &Claimed, is_empty: bool| match meaning {
        Claimed::Goal(goal) => goals.of_goal.get(*goal).copied().flatten().is_none() == is_empty,
        _ => false,
    };
    let claims = &parsed.account.claims;
    let stated: std::collections::BTreeSet<usize> =
        claims.iter().filter(|claim| states(&claim.meaning, false)).map(|claim| claim.tokens.start).collect();
    let tokens: Vec<_> = claims
        .iter()
        .filter(|claim| states(&claim.meaning, true) && !stated.contains(&claim.tokens.start))
        .map(|claim| claim.tokens.clone())
        .collect();
    for tokens in tokens {
        parsed.account.report(tokens, UnrecognizedReason::NotExpressible);
    }
}

/// Reports the goals whose start state the meshes do not show ("close the drawer" without a mesh of an open drawer).
fn report_unshown(
    parsed: &mut ParsedText,
    goals: &start_state::Predicates,
    unshown: &[start_state::DraftPredicate],
) {
    let is_unshown = |goal: &usize| {
        let first = goals.of_goal.get(*goal).copied().flatten();
        first.is_some_and(|first| unshown.contains(&goals.predicates[first]))
    };
    let tokens: Vec<_> = parsed
        .account
        .claims
        .iter()
        .filter_map(|claim| match &claim.meaning {
            Claimed::Goal(goal) if is_unshown(goal) => Some(claim.tokens.clone()),
            _ => None,
        })
        .collect();
    for tokens in tokens {
        parsed.account.report(tokens, UnrecognizedReason::NotSupported);
    }
}

/// Reports the measures of an object that are outside the range of its category.
fn report_measures(draft: &Draft, parsed: &mut ParsedText, object: usize) {
    let Some(mention) = draft.of_mention.iter().position(|objects| objects.contains(&object)) else { return };
    let measures: Vec<_> = parsed
        .account
        .claims
        .iter()
        .filter_map(|claim| match &claim.meaning {
            Claimed::Property { property: Property::Size | Property::Volume | Property::Mass, mentions }
                if mentions.contains(&mention) =>
            {
                Some(claim.tokens.clone())
            }
            _ => None,
        })
        .collect();
    for tokens in measures {
        parsed.account.retract(&tokens);
        parsed.account.report(tokens, UnrecognizedReason::OutOfRange);
    }
}

/// Reports the last measure of an object as a contradiction of those before it.
fn report_last_measure(draft: &Draft, parsed: &mut ParsedText, object: usize) {
    let Some(mention) = draft.of_mention.iter().position(|objects| objects.contains(&object)) else { return };
    let is_size = |meaning: &Claimed| matches!(meaning, Claimed::Property { property: Property::Size, mentions } if mentions.contains(&mention));
    let last = parsed.account.claims.iter().rev().find(|claim| is_size(&claim.meaning));
    if let Some(tokens) = last.map(|claim| claim.tokens.clone()) {
        parsed.account.retract(&tokens);
        parsed.account.report(tokens, UnrecognizedReason::Contradiction);
    }
}

/// The instructions as the text has them.
fn instruction_text(source: &Source, parsed: &ParsedText) -> String {
    let mut parts: Vec<String> = Vec::new();
    let mut last: Option<std::ops::Range<usize>> = None;
    let mut flush = |range: &std::ops::Range<usize>| {
        let span = source.span(range.clone());
        let text = source.text[span].trim().trim_end_matches([',', '.', ';']);
        parts.push(text.to_owned());
    };
    for range in &parsed.instructions {
        match &mut last {
            // Neighboring clauses of one sentence are one instruction.
            Some(known) if range.start <= known.end + 2 && !source.has_end(known.end..range.start) => {
                known.end = range.end.max(known.end);
            }
            _ => {
                if let Some(known) = last.take() {
                    flush(&known);
                }
                last = Some(range.clone());
            }
        }
    }
    if let Some(known) = last {
        flush(&known);
    }
    parts.join(". ")
}

/// The theme; an error if the text has no recognized content.
fn theme_of<'t>(
    lexicon: &Lexicon<'t>,
    parsed: &ParsedText,
    normalized: &str,
    seed: u64,
) -> Result<&'t Theme, DescribeError> {
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
        return Ok(choice);
    }
    let scene =
        lexicon.vocabulary.grammar.scene_words.iter().any(|word| themes::has_phrase(normalized, word));
    let bare_table = (parsed.table.is_some() || scene || parsed.nothing_else) && parsed.unknown.is_empty();
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
    Ok(pool[pick])
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
