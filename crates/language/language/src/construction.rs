//! Constructions: patterns of clauses and what they mean, as data in `config/language`.
//!
//! A pattern is a sequence of words (`into`), alternatives (`with|by`), classes of words (`@turn`, and `@turn:done` for
//! "turned"), roles (`OBJECT`, `OBJECT.new`), and optional parts in brackets.

use std::sync::LazyLock;

use serde::Deserialize;

use crate::lexicon::{Form, Phrase, lexicon};

/// Change that a clause asks for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Act {
    /// Objects get a place: new ones are made, existing ones moved.
    Put,
    /// Existing objects get a place.
    Move,
    /// Objects leave what carries or contains them, or the table.
    Take,
    Add,
    Remove,
    /// With what it carries.
    RemoveWithContents,
    /// Everything that an object carries is removed.
    Clear,
    /// Everything in an object is removed.
    Empty,
    Replace,
    Swap,
    Turn,
    TurnAround,
    /// Toward an object or a side.
    Face,
    /// Bottom up, on its side, upright.
    Topple,
    LayOnSide,
    StandUp,
    Resize,
    Grow,
    Shrink,
    Recolor,
    Rename,
    Stack,
    LineUp,
    LineUpInDepth,
    Sort,
    Tidy,
    Clutter,
    /// Other places for everything.
    Rearrange,
    /// Another mesh of the same kind.
    Remake,
    /// Another mass or friction.
    SetPhysics,
    RestyleTable,
    Relight,
    MoveCamera,
    /// Objects are lifted.
    Lift,
    /// All but these, of the clause before.
    Except,
    /// Objects stay as they are.
    Keep,
    /// The change of the clause before, for other objects too.
    Likewise,
    /// A reason or a contrast, which changes nothing.
    Aside,
    /// The topic of what follows.
    Mention,
    Negation,
    Condition,
    Question,
}

/// Values that the words of a construction state ("dim the lights"). Factors are of what is usual or of what is there.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Means {
    /// Of the light: its direction from the front edge to the right, its height, and its brightness.
    pub azimuth_deg: Option<f64>,
    pub elevation_deg: Option<f64>,
    pub intensity: Option<f64>,
    /// Of the camera: about the table, counter-clockwise seen from above, and upward.
    pub turn_deg: Option<f64>,
    pub raise_deg: Option<f64>,
    pub distance_factor: Option<f64>,
    pub focal_factor: Option<f64>,
    /// Of objects.
    pub mass_factor: Option<f64>,
    pub friction_factor: Option<f64>,
}

/// Kinds of what a construction has open.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum RoleKind {
    Object,
    Place,
    /// A place that something comes from.
    Source,
    Angle,
    Factor,
    Change,
    Appearance,
    Label,
    Heading,
    Key,
    Rest,
}

/// One part of a pattern.
#[derive(Clone, Debug)]
pub(crate) enum Part {
    /// Alternatives of one word or several.
    Words(Vec<Phrase>),
    Class(String),
    Verb(String, Form),
    Role(RoleKind, String),
    Optional(Vec<Part>),
    /// Alternatives, some of which are classes.
    Any(Vec<Part>),
}

/// A pattern with its meaning.
#[derive(Debug)]
pub(crate) struct Construction {
    pub act: Act,
    pub parts: Vec<Part>,
    pub cost: f64,
    /// Acts of the clause before, where a clause without a verb repeats it.
    pub repeats: Vec<Act>,
    pub means: Means,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    construction: Vec<Entry>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Entry {
    act: Act,
    patterns: Vec<String>,
    #[serde(default)]
    cost: f64,
    #[serde(default)]
    repeats: Vec<Act>,
    #[serde(default)]
    means: Means,
    /// Sentences that it reads, for the tests.
    #[cfg_attr(not(test), allow(dead_code, reason = "only tests read them"))]
    #[serde(default)]
    examples: Vec<String>,
}

static EDITS: LazyLock<Vec<Construction>> =
    LazyLock::new(|| file().construction.into_iter().flat_map(|entry| compiled(&entry)).collect());

fn file() -> File {
    toml::from_str(include_str!("../../../../config/language/edits.toml"))
        .expect("the built-in constructions parse (a test loads them)")
}

/// The constructions of edits.
pub(crate) fn edits() -> &'static [Construction] {
    &EDITS
}

fn compiled(entry: &Entry) -> Vec<Construction> {
    let Entry { act, patterns, cost, repeats, means, .. } = entry;
    let one = |pattern: &String| Construction {
        act: *act,
        parts: parts(pattern),
        cost: *cost,
        repeats: repeats.clone(),
        means: *means,
    };
    patterns.iter().map(one).collect()
}

/// The parts of a pattern. A pattern of the built-in files that is wrong is a bug, which a test finds.
fn parts(pattern: &str) -> Vec<Part> {
    let spaced = pattern.replace('[', " [ ").replace(']', " ] ");
    let mut stack: Vec<Vec<Part>> = vec![Vec::new()];
    for word in spaced.split_whitespace() {
        match word {
            "[" => stack.push(Vec::new()),
            "]" => {
                let inner = stack.pop().expect("brackets are balanced");
                stack.last_mut().expect("brackets are balanced").push(Part::Optional(inner));
            }
            _ => stack.last_mut().expect("brackets are balanced").push(part(word)),
        }
    }
    assert_eq!(stack.len(), 1, "brackets of {pattern:?} are balanced");
    stack.pop().unwrap_or_default()
}

fn part(word: &str) -> Part {
    if word.contains('|') && word.contains('@') {
        return Part::Any(word.split('|').map(part).collect());
    }
    if let Some(class) = word.strip_prefix('@') {
        let (class, form) = class.split_once(':').unwrap_or((class, ""));
        assert!(lexicon().is_class(class), "{class} is a class");
        let form = match form {
            "ing" => Form::Ing,
            "done" => Form::Done,
            "third" => Form::Third,
            _ => Form::Base,
        };
        let is_verb = lexicon().is_verb_class(class);
        return if is_verb { Part::Verb(class.to_owned(), form) } else { Part::Class(class.to_owned()) };
    }
    let (name, suffix) = word.split_once('.').unwrap_or((word, ""));
    let kind = match name {
        "OBJECT" => RoleKind::Object,
        "PLACE" => RoleKind::Place,
        "SOURCE" => RoleKind::Source,
        "ANGLE" => RoleKind::Angle,
        "FACTOR" => RoleKind::Factor,
        "CHANGE" => RoleKind::Change,
        "APPEARANCE" => RoleKind::Appearance,
        "LABEL" => RoleKind::Label,
        "HEADING" => RoleKind::Heading,
        "KEY" => RoleKind::Key,
        "REST" => RoleKind::Rest,
        _ => {
            let phrases = word.split('|').map(|words| words.split('_').map(str::to_owned).collect());
            return Part::Words(phrases.collect());
        }
    };
    Part::Role(kind, suffix.to_owned())
}

#[cfg(test)]
pub(crate) fn examples() -> Vec<(Act, String)> {
    file()
        .construction
        .into_iter()
        .flat_map(|entry| entry.examples.into_iter().map(move |text| (entry.act, text)))
        .collect()
}
