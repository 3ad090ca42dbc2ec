//! Kinds of properties that words of a text state, and whether words are a value of a kind.
//!
//! A claim of a property is made by the rule that used the words. [`Property::reads`] checks it independently of that
//! rule: the words of a color parse as a color, those of a count as a number. What does not parse is no claim.

use std::ops::Range;

use super::lexicon::Lexicon;
use super::measures::read_measure;
use super::phrase::color_of;
use super::phrases::phrases;
use super::quantity::quantity;
use super::tokens::{Token, word};
use super::vocabulary::Vocabulary;
use geometry::Rgb;

/// A kind of property of objects.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Property {
    Color,
    Material,
    Size,
    Shape,
    Volume,
    Mass,
    /// A pose, or a state such as "open".
    State,
    Count,
    /// The number of people that a table is set for.
    People,
    Content,
    /// The set that objects are examples of.
    Kind,
    Arrangement,
    Position,
    Distance,
    Orientation,
}

/// Longest color, material or state, in words.
const LONGEST: usize = 4;

/// Words between values of one kind.
const JOINTS: &[&str] = &["and", "or", "very"];

impl Property {
    /// The name of the property in the account of a text.
    pub fn name(self) -> &'static str {
        match self {
            Self::Color => "color",
            Self::Material => "material",
            Self::Size => "size",
            Self::Shape => "shape",
            Self::Volume => "volume",
            Self::Mass => "mass",
            Self::State => "state",
            Self::Count => "count",
            Self::People => "people",
            Self::Content => "content",
            Self::Kind => "kind",
            Self::Arrangement => "arrangement",
            Self::Position => "position",
            Self::Distance => "distance",
            Self::Orientation => "orientation",
        }
    }

    /// Whether the tokens are a value of this property.
    pub fn reads(self, lexicon: &Lexicon, tokens: &[Token], range: &Range<usize>) -> bool {
        let vocabulary = lexicon.vocabulary;
        let tokens = &tokens[..range.end.min(tokens.len())];
        let measures = || range.clone().any(|at| read_measure(vocabulary, tokens, at).is_some());
        let consists = |is_value: &dyn Fn(&str) -> bool| {
            let is_joint = |word: &str| JOINTS.contains(&word) || vocabulary.shades.contains_key(word);
            consists_of(tokens, range.start, is_value, &is_joint)
        };
        match self {
            Self::Color => consists(&|words| color_of(vocabulary, words).is_some()),
            Self::Material => consists(&|words| vocabulary.materials.contains_key(words)),
            Self::Shape => consists(&|words| vocabulary.shapes.contains_key(words)),
            Self::Size => {
                measures()
                    || consists(&|words| {
                        vocabulary.sizes.contains_key(words) || vocabulary.stretch.contains_key(words)
                    })
            }
            Self::Volume | Self::Mass | Self::Distance => measures(),
            Self::State => range.clone().any(|at| {
                let is_state = |words: &str| {
                    vocabulary.states.contains_key(words) || matches!(words, "lying" | "standing")
                };
                let falls = word(tokens, at).is_some_and(|word| phrases().list.falls.has(word));
                falls || longest(tokens, at, &is_state) > 0
            }),
            Self::Count => number(lexicon, tokens, range).is_some(),
            Self::People => range.clone().any(|at| {
                quantity(lexicon, tokens, at).is_some()
                    || word(tokens, at).is_some_and(|word| phrases().agent.people.has(word))
            }),
            Self::Content | Self::Kind | Self::Arrangement | Self::Position | Self::Orientation => {
                range.clone().any(|at| word(tokens, at).is_some())
            }
        }
    }
}

/// The colors that the tokens name.
pub(super) fn colors(vocabulary: &Vocabulary, tokens: &[Token], range: &Range<usize>) -> Vec<Rgb> {
    let tokens = &tokens[..range.end.min(tokens.len())];
    let mut named = Vec::new();
    let mut at = range.start;
    while at < tokens.len() {
        let is_color = |words: &str| color_of(vocabulary, words).is_some();
        let shade = word(tokens, at).and_then(|word| vocabulary.shades.get(word)).copied();
        let after = at + usize::from(shade.is_some());
        let length = longest(tokens, after, &is_color);
        let words: Vec<&str> = (after..after + length).filter_map(|at| word(tokens, at)).collect();
        if let Some(color) = color_of(vocabulary, &words.join(" ")) {
            let amount = shade.unwrap_or(0.0);
            let toward = if amount >= 0.0 { Rgb([1.0; 3]) } else { Rgb([0.0; 3]) };
            named.push(shade.map_or(color, |_| color.mix(toward, amount.abs())));
            at = after;
        }
        at += length.max(1);
    }
    named
}

/// The lowest and the highest number that the tokens of a count state.
pub(super) fn number(lexicon: &Lexicon, tokens: &[Token], range: &Range<usize>) -> Option<[u32; 2]> {
    let tokens = &tokens[..range.end.min(tokens.len())];
    let mut at = range.start;
    let mut number: Option<[u32; 2]> = None;
    while at < tokens.len() {
        let pair = || matches!(word(tokens, at), Some("pair" | "pairs")).then_some(([2, 2], 1));
        let Some((more, length)) = quantity(lexicon, tokens, at).or_else(pair) else {
            at += 1;
            continue;
        };
        let [low, high] = number.unwrap_or([1, 1]);
        number = Some([low.saturating_mul(more[0]), high.saturating_mul(more[1])]);
        at += length;
    }
    number
}

/// Whether the tokens from `start` on are values, with words between them that join values.
fn consists_of(
    tokens: &[Token],
    start: usize,
    is_value: &dyn Fn(&str) -> bool,
    is_joint: &dyn Fn(&str) -> bool,
) -> bool {
    let (mut at, mut values) = (start, 0);
    while at < tokens.len() {
        let length = longest(tokens, at, is_value);
        let joins = match &tokens[at] {
            Token::Word(word) => is_joint(word),
            Token::Number(_) => false,
            Token::Pause | Token::End => true,
        };
        if length == 0 && !joins {
            return false;
        }
        values += usize::from(length > 0);
        at += length.max(1);
    }
    values > 0
}

/// Number of tokens of the longest value at `at`.
fn longest(tokens: &[Token], at: usize, is_value: &dyn Fn(&str) -> bool) -> usize {
    let mut words = String::new();
    let mut longest = 0;
    for (length, word) in (1..=LONGEST).zip((at..tokens.len()).map_while(|at| word(tokens, at))) {
        if length > 1 {
            words.push(' ');
        }
        words.push_str(word);
        if is_value(&words) {
            longest = length;
        }
    }
    longest
}

#[cfg(test)]
mod tests {
    use super::super::LEXICON;
    use super::super::tokens::tokenize;
    use super::*;

    #[test]
    fn words_are_values_of_their_own_kind_only() {
        for (property, right, wrong) in [
            (Property::Color, "light blue", "3"),
            (Property::Color, "red and white", "into"),
            (Property::Color, "off white", "arrange"),
            (Property::Material, "stainless steel", "red"),
            (Property::Size, "small", "two"),
            (Property::Size, "20 cm wide", "wooden"),
            (Property::Shape, "round", "small"),
            (Property::Volume, "0.5 l", "large"),
            (Property::Mass, "200 g", "two"),
            (Property::State, "upside down", "blue"),
            (Property::Count, "half a dozen", "in total"),
            (Property::People, "each guest", "plate"),
            (Property::Distance, "at 5 cm", "next to"),
            (Property::Position, "on the left", ","),
        ] {
            let reads = |text: &str| {
                let tokens = tokenize(text);
                property.reads(&LEXICON, &tokens, &(0..tokens.len()))
            };
            assert!(reads(right), "{right:?} is no {}", property.name());
            assert!(!reads(wrong), "{wrong:?} is a {}", property.name());
        }
    }
}
