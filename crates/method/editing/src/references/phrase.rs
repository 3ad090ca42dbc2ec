//! Noun phrases and their parts, before they meet a scene.
//!
//! A phrase is a quantity ("both", "the two"), a body of modifiers and noun ("small red mug"), qualifiers ("on the
//! tray", "from the left") and exceptions ("except the red one"). Which words of the body are the noun depends on the
//! labels of the scene and is decided in `selection`.

use super::qualifier::{Direction, Qualifier, qualifier};
use language::vocabulary::number;

/// Number of objects that a phrase means.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Quantity {
    /// "mugs", "the mug": the number of the noun decides.
    Open,
    /// "one", "a", "any".
    One,
    Count(usize),
    /// "half of the fruit"
    Fraction(f64),
    Both,
    All,
}

/// One noun phrase.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct NounPhrase {
    pub text: String,
    pub quantity: Quantity,
    /// "one of the mugs", "any mug": any so many of those that fit.
    pub choice: bool,
    /// "the other mug", "everything else": what it is other than, the phrase does not say.
    pub other: bool,
    pub body: Vec<String>,
    /// "the first of the two plates": the phrase after "of".
    pub whole: Option<Box<NounPhrase>>,
    pub qualifiers: Vec<Qualifier>,
    pub exceptions: Vec<NounPhrase>,
}

/// Words that are not understood.
pub(super) type Unread = Vec<String>;

const DETERMINERS: &[&str] =
    &["the", "my", "our", "your", "his", "her", "their", "this", "that", "these", "those"];
const EXCEPTIONS: &[&[&str]] = &[
    &["except", "for"],
    &["except"],
    &["but", "not"],
    &["but"],
    &["other", "than"],
    &["apart", "from"],
    &["besides"],
];
const CONTAINED: &[&[&str]] = &[&["in", "it"], &["on", "it"], &["inside", "it"]];
const ORDINALS: &[&str] =
    &["first", "second", "third", "fourth", "fifth", "sixth", "seventh", "eighth", "ninth", "tenth"];

/// Words in lower case; commas are words of their own. Quotes and final points are dropped.
pub(super) fn words(phrase: &str) -> Vec<String> {
    let mut words = Vec::new();
    let spaced = phrase.to_lowercase().replace(',', " , ").replace(['-', '–'], " ");
    for word in spaced.split_whitespace() {
        let is_quote = |c: &char| matches!(c, '"' | '\'' | '’' | '“' | '”');
        let word: String = word.chars().filter(|c| !is_quote(c)).collect();
        let word = word.trim_end_matches(['.', '!', ';', ':']);
        // "the left-hand mug" is the left one.
        let is_side = words.last().is_some_and(|side: &String| side == "left" || side == "right");
        if word.is_empty() || is_side && word == "hand" {
            continue;
        }
        words.push(word.to_owned());
    }
    words
}

/// A reader over the words of a phrase.
pub(super) struct Reader<'w> {
    pub words: &'w [String],
    pub at: usize,
}

impl Reader<'_> {
    pub fn peek(&self) -> Option<&str> {
        self.words.get(self.at).map(String::as_str)
    }

    /// Whether these words follow.
    pub fn follows(&self, pattern: &[&str]) -> bool {
        self.words.get(self.at..self.at + pattern.len()).is_some_and(|words| words == pattern)
    }

    /// Consumes these words if they follow.
    pub fn take(&mut self, pattern: &[&str]) -> bool {
        let follows = self.follows(pattern);
        if follows {
            self.at += pattern.len();
        }
        follows
    }

    /// Consumes one of these words if it follows.
    pub fn take_one(&mut self, words: &[&str]) -> bool {
        let follows = self.peek().is_some_and(|word| words.contains(&word));
        self.at += usize::from(follows);
        follows
    }

    fn rest(&self) -> Unread {
        self.words[self.at.min(self.words.len())..].to_vec()
    }
}

/// All of a phrase: noun phrases joined by "and" or commas.
pub(super) fn read_phrase(words: &[String]) -> Result<Vec<NounPhrase>, Unread> {
    let mut reader = Reader { words, at: 0 };
    let phrases = read_list(&mut reader)?;
    if reader.at < words.len() { Err(reader.rest()) } else { Ok(phrases) }
}

/// Noun phrases joined by "and" or commas, up to what is no noun phrase.
pub(super) fn read_list(reader: &mut Reader) -> Result<Vec<NounPhrase>, Unread> {
    let mut phrases = vec![read_noun_phrase(reader)?];
    loop {
        let before = reader.at;
        let comma = reader.take(&[","]);
        let and = reader.take(&["and"]) || reader.take(&["plus"]);
        if !comma && !and {
            return Ok(phrases);
        }
        match read_noun_phrase(reader) {
            Ok(phrase) => phrases.push(phrase),
            Err(unread) => {
                reader.at = before;
                return if reader.at + 1 < reader.words.len() { Ok(phrases) } else { Err(unread) };
            }
        }
    }
}

/// One noun phrase.
pub(super) fn read_noun_phrase(reader: &mut Reader) -> Result<NounPhrase, Unread> {
    let start = reader.at;
    let fraction = read_fraction(reader);
    // "a mug" and "two mugs" leave open which.
    let is_open = |word: &str| matches!(word, "any" | "either" | "a" | "an") || number(word).is_some();
    // "something sweet" is any one that is.
    let is_any = reader.peek() == Some("something");
    let choice = fraction.is_some() || is_any || reader.peek().is_some_and(is_open);
    let _ = reader.take(&["either"]);
    let (quantity, other) = read_quantity(reader);
    let quantity = fraction.unwrap_or(quantity);
    let mut phrase = NounPhrase {
        text: String::new(),
        quantity: if choice && quantity == Quantity::Open { Quantity::One } else { quantity },
        choice,
        other,
        body: Vec::new(),
        whole: None,
        qualifiers: Vec::new(),
        exceptions: Vec::new(),
    };
    if reader.take_one(&["everything", "anything"]) {
        phrase.quantity = Quantity::All;
        phrase.body.push("objects".to_owned());
        phrase.other |= reader.take(&["else"]);
    }
    while let Some(word) = reader.peek() {
        if matches!(word, "," | "and" | "plus") || exception_length(reader).is_some() {
            break;
        }
        if word == "of" && is_partitive(reader, &phrase) {
            reader.at += 1;
            phrase.choice |= phrase.body.iter().all(|word| matches!(word.as_str(), "one" | "ones"))
                && matches!(
                    phrase.quantity,
                    Quantity::One | Quantity::Count(_) | Quantity::Fraction(_) | Quantity::Open
                );
            phrase.whole = Some(Box::new(read_noun_phrase(reader)?));
            break;
        }
        // "the mug with the spoon in it"; and "from the left" belongs to the phrase that counts.
        let of_outer = CONTAINED.iter().any(|words| reader.follows(words));
        if of_outer || (word == "from" && !phrase.body.iter().any(|word| is_order(word))) {
            break;
        }
        let before = reader.at;
        let follows = if phrase.body.is_empty() { None } else { qualifier(reader)? };
        if let Some(qualifier) = follows {
            phrase.qualifiers.push(qualifier);
        } else if phrase.qualifiers.is_empty() {
            phrase.body.push(reader.words[before].clone());
            reader.at = before + 1;
        } else {
            reader.at = before;
            break;
        }
    }
    if let Some(length) = exception_length(reader) {
        reader.at += length;
        phrase.exceptions = read_list(reader)?;
    }
    let is_empty = phrase.body.is_empty() && phrase.whole.is_none();
    phrase.text = reader.words[start..reader.at].join(" ");
    if is_empty { Err(reader.words[start..].to_vec()) } else { Ok(phrase) }
}

fn exception_length(reader: &Reader) -> Option<usize> {
    EXCEPTIONS.iter().find(|pattern| reader.follows(pattern)).map(|pattern| pattern.len())
}

/// "of" after a quantity or an order and before a determiner.
fn is_partitive(reader: &Reader, phrase: &NounPhrase) -> bool {
    let next = reader.words.get(reader.at + 1).map_or("", String::as_str);
    let is_whole = DETERMINERS.contains(&next) || matches!(next, "all" | "both");
    is_whole && phrase.body.iter().all(|word| is_order(word) || matches!(word.as_str(), "one" | "ones"))
}

/// Whether the word states a rank or a side.
fn is_order(word: &str) -> bool {
    ordinal(word).is_some() || word == "last" || word == "middle" || Direction::of(word).is_some()
}

/// The rank of "first", "2nd", from zero.
pub(super) fn ordinal(word: &str) -> Option<usize> {
    let digits = || {
        let stem = ["st", "nd", "rd", "th"].iter().find_map(|ending| word.strip_suffix(ending))?;
        stem.parse::<usize>().ok()?.checked_sub(1)
    };
    ORDINALS.iter().position(|name| *name == word).or_else(digits)
}

/// "half of", "half the", "a third of", "two thirds of"; "of" is left to what follows.
fn read_fraction(reader: &mut Reader) -> Option<Quantity> {
    const FRACTIONS: &[(&[&str], f64)] = &[
        (&["half"], 0.5),
        (&["a", "third"], 1.0 / 3.0),
        (&["two", "thirds"], 2.0 / 3.0),
        (&["a", "quarter"], 0.25),
        (&["three", "quarters"], 0.75),
    ];
    let before = reader.at;
    let (words, part) = FRACTIONS.iter().find(|(words, _)| reader.follows(words))?;
    reader.at += words.len();
    let has_whole = reader.peek().is_some_and(|word| word == "of" || DETERMINERS.contains(&word));
    if !has_whole {
        reader.at = before;
        return None;
    }
    Some(Quantity::Fraction(*part))
}

/// The quantity, and whether "other" is among its words.
fn read_quantity(reader: &mut Reader) -> (Quantity, bool) {
    let (mut quantity, mut other, start) = (Quantity::Open, false, reader.at);
    while let Some(word) = reader.peek() {
        let next = reader.words.get(reader.at + 1).map_or("", String::as_str);
        quantity = match word {
            "all" | "every" | "each" => Quantity::All,
            "both" => Quantity::Both,
            "a" | "an" | "any" => Quantity::One,
            "one" if !next.is_empty() && reader.at == start => Quantity::One,
            "other" if next != "than" => {
                other = true;
                quantity
            }
            word if DETERMINERS.contains(&word) => quantity,
            word => match number(word) {
                Some(count) if !next.is_empty() && quantity == Quantity::Open && word != "one" => {
                    Quantity::Count(count)
                }
                _ => break,
            },
        };
        reader.at += 1;
    }
    (quantity, other)
}
