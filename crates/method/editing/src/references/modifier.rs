//! Words before a noun: colors, materials, sizes, ranks, words of labels.

use super::color_match::is_color;
use super::phrase::ordinal;
use super::qualifier::Direction;
use crate::EditableObject;
use language::vocabulary::{material_of, number, vocabulary};

/// A measure by which objects compare.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Measure {
    /// Cubic root of the volume of the box.
    Size,
    Height,
    Length,
}

impl Measure {
    pub fn of(self, object: &EditableObject) -> f64 {
        match self {
            Self::Size => object.size_m.element_product().cbrt(),
            Self::Height => object.footprint.top_m - object.footprint.bottom_m,
            Self::Length => object.size_m.truncate().max_element(),
        }
    }
}

/// A choice among objects that otherwise fit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Pick {
    /// The rank from zero, counted from where the phrase says.
    Nth(usize),
    Last,
    /// The first from that direction.
    Outermost(Direction),
    Center,
    /// The largest of the measure, or the smallest.
    Extreme(Measure, bool),
    /// Objects that are distinctly larger, or smaller, than the others.
    Group(Measure, bool),
}

/// A word before a noun.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Modifier {
    Color(String),
    Material(String),
    Pick(Pick, String),
    Count(usize),
    LabelWord(String),
}

/// Reads the words before a noun. `is_label_word` says whether the label of an object that fits has the word. The
/// error lists words without a meaning.
pub(super) fn modifiers(
    words: &[String],
    is_label_word: impl Fn(&str) -> bool,
) -> Result<Vec<Modifier>, Vec<String>> {
    let (mut found, mut unknown, mut at) = (Vec::new(), Vec::new(), 0);
    while let Some(word) = words.get(at) {
        let mut length = 1;
        if let Some(words_of_color) = vocabulary().color_length(words, at) {
            length = words_of_color;
            found.push(Modifier::Color(words[at..at + length].join(" ")));
            // "a red colored mug"
            length += usize::from(matches!(
                words.get(at + length).map(String::as_str),
                Some("colored" | "coloured")
            ));
        } else if let Some(words_of_material) = vocabulary().material_length(words, at) {
            length = words_of_material;
            found.push(Modifier::Material(words[at..at + length].join(" ")));
        } else if let Some(pick) = pick(word) {
            found.push(Modifier::Pick(pick, word.clone()));
        } else if let Some(count) = number(word) {
            found.push(Modifier::Count(count));
        } else if is_label_word(word) {
            found.push(Modifier::LabelWord(word.clone()));
        } else {
            unknown.push(word.clone());
        }
        at += length;
    }
    if unknown.is_empty() { Ok(found) } else { Err(unknown) }
}

fn pick(word: &str) -> Option<Pick> {
    use Measure::{Height, Length, Size};
    if let Some(rank) = ordinal(word) {
        return Some(Pick::Nth(rank));
    }
    if let Some(direction) = Direction::of(word) {
        return Some(Pick::Outermost(direction));
    }
    Some(match word {
        "last" => Pick::Last,
        "middle" | "center" | "centre" | "central" => Pick::Center,
        "largest" | "biggest" | "larger" | "bigger" => Pick::Extreme(Size, true),
        "smallest" | "smaller" | "littlest" | "tiniest" => Pick::Extreme(Size, false),
        "tallest" | "taller" | "highest" => Pick::Extreme(Height, true),
        "shortest" | "shorter" => Pick::Extreme(Height, false),
        "longest" | "longer" | "widest" | "wider" => Pick::Extreme(Length, true),
        "large" | "big" | "huge" => Pick::Group(Size, true),
        "small" | "little" | "tiny" => Pick::Group(Size, false),
        "tall" => Pick::Group(Height, true),
        "short" => Pick::Group(Height, false),
        "long" | "wide" => Pick::Group(Length, true),
        _ => return None,
    })
}

/// Whether the label has these words, as whole words.
pub(super) fn label_has(object: &EditableObject, words: &str) -> bool {
    let label = object.label.to_lowercase().replace(['-', '_', ','], " ");
    format!(" {label} ").contains(&format!(" {words} "))
}

/// Objects whose label has the color, and objects whose measured color or label is it.
pub(super) fn of_color(objects: &[EditableObject], pool: &[usize], words: &str) -> (Vec<usize>, Vec<usize>) {
    let labeled = pool.iter().copied().filter(|&index| label_has(&objects[index], words)).collect();
    let measured = |index: &usize| objects[*index].color.is_some_and(|color| is_color(color, words));
    let matching = |index: &usize| measured(index) || label_has(&objects[*index], words);
    (labeled, pool.iter().copied().filter(matching).collect())
}

/// Objects whose label has the material, and objects that are made of it.
pub(super) fn of_material(
    objects: &[EditableObject],
    pool: &[usize],
    words: &str,
) -> (Vec<usize>, Vec<usize>) {
    let labeled = pool.iter().copied().filter(|&index| label_has(&objects[index], words)).collect();
    let substance = material_of(words).map_or("", |material| material.substance.as_str());
    let metals: &[&str] = match words {
        "metal" | "metallic" => &["steel", "aluminum", "brass", "cast_iron"],
        "plastic" => &["plastic", "hard_plastic"],
        _ => &[],
    };
    let made_of = |index: &usize| {
        let made = objects[*index].material.as_deref().unwrap_or_default();
        made == words || made == substance || metals.contains(&made)
    };
    let matching = |index: &usize| made_of(index) || label_has(&objects[*index], words);
    (labeled, pool.iter().copied().filter(matching).collect())
}
