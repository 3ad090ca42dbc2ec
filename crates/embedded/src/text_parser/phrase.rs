//! The noun-phrase chunker: "two small light blue ceramic mugs", "a stack of three books", "a 30 cm
//! wide oak table", "them".
//!
//! A phrase consists of determiners and quantities, then modifiers, then the longest lexicon match as head. Words
//! that are both modifier and noun ("glass", "orange") are modifiers if a noun follows in the same phrase.

use super::lexicon::{Entry, Lexicon, Meaning};
use super::measures::{Measure, read_measures};
use super::quantity::quantity;
use super::tokens::{Token, word};
use geometry::Rgb;

/// The determiner of a phrase.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Determiner {
    /// "a", a number or a bare noun: a new referent.
    New,
    /// "the", "that", "its": possibly an earlier mention.
    Definite,
    /// "each", "every".
    Each,
}

/// The head of a phrase.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Head {
    Objects(Vec<Meaning>),
    /// "it", "this".
    It,
    /// "them".
    Them,
    Unknown(String),
}

/// Attributes given by the modifiers of a phrase.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Attributes {
    /// Two or more for "red and blue mugs".
    pub colors: Vec<Rgb>,
    pub color_words: Vec<String>,
    pub substance: Option<String>,
    /// Color implied by the material.
    pub material_color: Option<Rgb>,
    pub table_finish: Option<String>,
    /// Factor on all extents.
    pub scale: f64,
    /// Factors on single extents (axis letter, factor).
    pub stretches: Vec<(char, f64)>,
    pub measures: Vec<Measure>,
    /// A key of `[shapes]`.
    pub shape: Option<String>,
}

#[derive(Clone, Debug, PartialEq)]
pub(super) struct NounPhrase {
    pub determiner: Determiner,
    /// Minimum and maximum count; `None` if the phrase leaves it open.
    pub count: Option<[u32; 2]>,
    pub plural: bool,
    /// "a stack of".
    pub stacked: bool,
    /// "no mugs".
    pub negated: bool,
    pub attributes: Attributes,
    pub head: Head,
    /// Modifiers and head as written in the text, with the head in the singular where the text has it so.
    pub words: String,
}

/// Parses the noun phrase at `at`; returns it with the position after it. `None` if no phrase starts here.
pub(super) fn noun_phrase(lexicon: &Lexicon, tokens: &[Token], at: usize) -> Option<(NounPhrase, usize)> {
    let vocabulary = lexicon.vocabulary;
    let mut p = at;
    let mut phrase = NounPhrase {
        determiner: Determiner::New,
        count: None,
        plural: false,
        stacked: false,
        negated: false,
        attributes: Attributes { scale: 1.0, ..Attributes::default() },
        head: Head::It,
        words: String::new(),
    };
    match word(tokens, p) {
        Some("it" | "this" | "that" | "itself") if !starts_noun(lexicon, tokens, p + 1) => {
            return Some((phrase, p + 1));
        }
        Some("each") if !starts_noun(lexicon, tokens, p + 1) => {
            phrase.determiner = Determiner::Each;
            let of =
                word(tokens, p + 1) == Some("of") && matches!(word(tokens, p + 2), Some("them" | "these"));
            return Some((phrase, if of { p + 3 } else { p + 1 }));
        }
        Some("them" | "these" | "those" | "both") if !starts_noun(lexicon, tokens, p + 1) => {
            phrase.head = Head::Them;
            return Some((phrase, p + 1));
        }
        _ => {}
    }
    // A phrase of the lexicon may begin with a quantity word ("pair of glasses").
    let mut phrase_words: Vec<String> = Vec::new();
    let mut determined = false;
    loop {
        if p >= tokens.len() {
            return None;
        }
        if let Some((measures, length)) = read_measures(vocabulary, tokens, p) {
            phrase.attributes.measures.extend(measures);
            p += length;
            determined = true;
            continue;
        }
        if let Some((range, length)) = quantity(lexicon, tokens, p)
            && lexicon.longest_at(tokens, p).is_none_or(|(_, n)| n < length)
        {
            phrase.count = Some(match phrase.count {
                // "a dozen", "two pairs": the inner number counts.
                Some([1, 1]) | None => range,
                Some([low, high]) => [low.saturating_mul(range[0]), high.saturating_mul(range[1])],
            });
            determined = true;
            p += length;
            continue;
        }
        let w = word(tokens, p)?;
        let known = lexicon.longest_at(tokens, p);
        match w {
            "no" | "zero" => phrase.negated = true,
            "a" | "an" | "another" => {
                phrase.count.get_or_insert([1, 1]);
                determined = true;
            }
            "the" | "this" | "that" | "these" | "those" | "its" | "their" | "his" | "her" => {
                phrase.determiner = Determiner::Definite;
                determined = true;
            }
            "each" | "every" => {
                phrase.determiner = Determiner::Each;
                determined = true;
            }
            "pair" | "pairs" if word(tokens, p + 1) == Some("of") => {
                let (_, two) = phrase.count.map_or((1, 1), |[low, high]| (low, high));
                // "a pair of scissors" is one; two of anything else.
                let next = lexicon.longest_at(tokens, p + 2);
                let single = next.is_some_and(|(entry, _)| entry.one_by_default);
                let each = if single { 1 } else { 2 };
                phrase.count = Some([two.saturating_mul(each); 2]);
                determined = true;
                p += 1;
            }
            _ if known.is_none()
                && vocabulary.grammar.piles.contains(w)
                && word(tokens, p + 1) == Some("of") =>
            {
                phrase.stacked = true;
                phrase.count = phrase.count.filter(|count| *count != [1, 1]);
                determined = true;
                p += 1;
            }
            _ if known.is_none()
                && vocabulary.grammar.partitives.contains(w)
                && word(tokens, p + 1) == Some("of") =>
            {
                // "a set of mugs" leaves the number open, "a slice of bread" is one.
                if matches!(w, "set" | "sets" | "row" | "line" | "circle" | "mix" | "range" | "arrangement") {
                    phrase.count = None;
                }
                determined = true;
                p += 1;
            }
            "stacked" => phrase.stacked = true,
            _ if vocabulary.grammar.determiners.contains(w) => determined = true,
            _ => match modifier(lexicon, tokens, p, &mut phrase.attributes) {
                Some(length) => {
                    phrase_words
                        .extend(tokens[p..p + length].iter().filter_map(Token::word).map(str::to_owned));
                    p += length;
                    determined = true;
                    continue;
                }
                None => {
                    return finish(lexicon, tokens, p, phrase, phrase_words, determined);
                }
            },
        }
        p += 1;
    }
}

/// The head and what follows it.
fn finish(
    lexicon: &Lexicon,
    tokens: &[Token],
    at: usize,
    mut phrase: NounPhrase,
    mut phrase_words: Vec<String>,
    determined: bool,
) -> Option<(NounPhrase, usize)> {
    let mut p = at;
    // Ordinary and unknown adjectives before a noun of this phrase.
    let mut skipped = 0;
    while lexicon.longest_at(tokens, p).is_none() {
        let w = word(tokens, p)?;
        let ordinary = lexicon.vocabulary.is_ordinary(w);
        let glue = GLUE.contains(&w);
        if glue || (ordinary && !noun_ahead(lexicon, tokens, p + 1)) {
            return None;
        }
        if !ordinary && !noun_ahead(lexicon, tokens, p + 1) {
            return unknown(lexicon, tokens, p, phrase);
        }
        if let Some(length) = modifier(lexicon, tokens, p, &mut phrase.attributes) {
            phrase_words.extend(tokens[p..p + length].iter().filter_map(Token::word).map(str::to_owned));
            p += length;
            continue;
        }
        if let Some((range, length)) = quantity(lexicon, tokens, p) {
            phrase.count = Some(range);
            p += length;
            continue;
        }
        phrase_words.push(w.to_owned());
        p += 1;
        skipped += 1;
        if skipped > 6 {
            return None;
        }
    }
    let (entry, length) = lexicon.longest_at(tokens, p)?;
    let (mut entry, mut end) = (entry.clone(), p + length);
    // "bottle of wine" is the wine bottle, "ball of yarn" the yarn ball.
    if word(tokens, end) == Some("of")
        && let Some((inverted, after)) = inverted_phrase(lexicon, tokens, p, end)
    {
        entry = Entry { plural: entry.plural, ..inverted };
        end = after;
    }
    // A vague word before a noun is a modifier ("tool box" is in the lexicon, "fruit tray" is a tray). Before a
    // table any noun is a modifier ("electronics bench").
    while let Some((next, more)) = lexicon.longest_at(tokens, end)
        && !next.plural
        && matches!(
            (&entry.meanings[0], &next.meanings[0]),
            (Meaning::Vague(_) | Meaning::Table(_), Meaning::Category(_))
                | (Meaning::Vague(_) | Meaning::Category(_), Meaning::Table(_))
        )
    {
        phrase_words.extend(tokens[p..end].iter().filter_map(Token::word).map(str::to_owned));
        p = end;
        entry = next.clone();
        end += more;
    }
    // "mug holder" is another noun.
    if let Some(next) = word(tokens, end)
        && lexicon.vocabulary.grammar.compound_heads.contains(next)
        && lexicon.longest_at(tokens, end).is_none()
    {
        let name: Vec<&str> = tokens[p..=end].iter().filter_map(Token::word).collect();
        phrase.head = Head::Unknown(name.join(" "));
        return Some((phrase, end + 1));
    }
    phrase_words.extend(tokens[p..end].iter().filter_map(Token::word).map(str::to_owned));
    phrase.plural = entry.plural || (entry.one_by_default && phrase.count.is_some_and(|c| c[1] > 1));
    if phrase.count == Some([1, 1]) && entry.plural && !determined {
        phrase.count = None;
    }
    // "some bread", "some coffee": one of it.
    if entry.one_by_default && !entry.plural && phrase.count.is_some_and(|c| c[0] != c[1]) {
        phrase.count = Some([1, 1]);
        phrase.plural = false;
    }
    phrase.head = Head::Objects(entry.meanings);
    phrase.words = phrase_words.join(" ");
    end = trailing_measures(lexicon, tokens, end, &mut phrase);
    Some((phrase, end))
}

/// "a plate 30 cm wide", "a mug 9 cm tall".
fn trailing_measures(lexicon: &Lexicon, tokens: &[Token], at: usize, phrase: &mut NounPhrase) -> usize {
    let mut end = at;
    let start = if matches!(tokens.get(end), Some(Token::Pause)) { end + 1 } else { end };
    let start = match word(tokens, start) {
        Some("about" | "of" | "measuring" | "roughly") => start + 1,
        _ => start,
    };
    if matches!(tokens.get(start), Some(Token::Number(_)))
        && let Some((measures, length)) = read_measures(lexicon.vocabulary, tokens, start)
        && !noun_ahead(lexicon, tokens, start + length)
    {
        phrase.attributes.measures.extend(measures);
        end = start + length;
    }
    end
}

/// "of" and prepositions end a phrase.
const GLUE: &[&str] = &[
    "and",
    "or",
    "with",
    "of",
    "on",
    "in",
    "at",
    "to",
    "by",
    "for",
    "from",
    "next",
    "near",
    "beside",
    "behind",
    "under",
    "between",
    "around",
    "inside",
    "without",
    "but",
    "is",
    "are",
    "it",
    "them",
    "there",
    "left",
    "right",
    "front",
    "into",
    "onto",
    "over",
    "above",
    "below",
    "beneath",
    "underneath",
    "atop",
    "upon",
    "within",
    "along",
    "alongside",
    "against",
    "containing",
    "holding",
    "filled",
    "full",
    "topped",
    "surrounded",
    "has",
    "have",
    "plus",
    "then",
    "while",
    "where",
    "which",
    "as",
    "also",
    "not",
    "except",
    "close",
    "adjacent",
    "together",
    "stacked",
    "placed",
    "standing",
    "lying",
    "sitting",
    "resting",
    "arranged",
    "opposite",
    "facing",
];

fn unknown(
    lexicon: &Lexicon,
    tokens: &[Token],
    at: usize,
    mut phrase: NounPhrase,
) -> Option<(NounPhrase, usize)> {
    let mut names = Vec::new();
    let mut end = at;
    while let Some(w) = word(tokens, end) {
        if lexicon.vocabulary.is_ordinary(w) || GLUE.contains(&w) || lexicon.longest_at(tokens, end).is_some()
        {
            break;
        }
        names.push(w.to_owned());
        end += 1;
        if names.len() == 4 {
            break;
        }
    }
    phrase.head = Head::Unknown(names.join(" "));
    Some((phrase, end.max(at + 1)))
}

/// Whether a noun of the lexicon follows within this phrase, after modifiers and adjectives.
fn noun_ahead(lexicon: &Lexicon, tokens: &[Token], at: usize) -> bool {
    for p in at..(at + 5).min(tokens.len()) {
        let Some(w) = word(tokens, p) else { return false };
        if GLUE.contains(&w) || lexicon.vocabulary.grammar.determiners.contains(w) {
            return false;
        }
        if quantity(lexicon, tokens, p).is_some() && lexicon.longest_at(tokens, p).is_none() {
            return false;
        }
        if lexicon.longest_at(tokens, p).is_some() {
            return true;
        }
    }
    false
}

/// Whether a noun phrase with a known head begins here, after its determiner.
fn starts_noun(lexicon: &Lexicon, tokens: &[Token], at: usize) -> bool {
    noun_ahead(lexicon, tokens, at) || quantity(lexicon, tokens, at).is_some()
}

/// A color, material, size, shape or measure at `at`; the number of tokens it takes.
fn modifier(lexicon: &Lexicon, tokens: &[Token], at: usize, attributes: &mut Attributes) -> Option<usize> {
    let vocabulary = lexicon.vocabulary;
    let w = word(tokens, at)?;
    let two = word(tokens, at + 1).map(|next| format!("{w} {next}"));
    let object = lexicon.longest_at(tokens, at).map_or(0, |(_, length)| length);
    let allowed = |length: usize| {
        length > object || (length == object && adjective_position(lexicon, tokens, at + length))
    };
    if let Some((measures, length)) = read_measures(vocabulary, tokens, at)
        && allowed(length)
    {
        attributes.measures.extend(measures);
        return Some(length);
    }
    // "light blue".
    if let (Some(&shade), Some(next)) = (vocabulary.shades.get(w), word(tokens, at + 1)) {
        let longer = word(tokens, at + 2).map(|third| format!("{next} {third}"));
        for (name, length) in [(longer.as_deref(), 3), (Some(next), 2)] {
            if let Some(name) = name
                && let Some(color) = color_of(vocabulary, name)
                && allowed(length)
            {
                let toward = if shade >= 0.0 { Rgb([1.0; 3]) } else { Rgb([0.0; 3]) };
                attributes.colors.push(color.mix(toward, shade.abs()));
                attributes.color_words.push(format!("{w} {name}"));
                return Some(length);
            }
        }
    }
    for (name, length) in [(two.as_deref(), 2), (Some(w), 1)] {
        let Some(name) = name else { continue };
        if !allowed(length) {
            continue;
        }
        if let Some(color) = color_of(vocabulary, name) {
            attributes.colors.push(color);
            attributes.color_words.push(name.to_owned());
            // "red and blue mugs": the joint color belongs to the same phrase.
            if word(tokens, at + length) == Some("and")
                && word(tokens, at + length + 1).is_some_and(|next| color_of(vocabulary, next).is_some())
                && adjective_position(lexicon, tokens, at + length + 2)
            {
                return Some(length + 1);
            }
            return Some(length);
        }
        if let Some(material) = vocabulary.materials.get(name) {
            attributes.substance = Some(material.substance.clone());
            attributes.material_color = material.color.as_deref().and_then(parse_hex);
            attributes.table_finish = material.table.clone();
            return Some(length);
        }
        if let Some(&factor) = vocabulary.sizes.get(name) {
            attributes.scale *= factor;
            return Some(length);
        }
        if let Some(stretch) = vocabulary.stretch.get(name) {
            attributes.stretches.push((stretch.axis, stretch.factor));
            return Some(length);
        }
        if vocabulary.shapes.contains_key(name) {
            attributes.shape = Some(name.to_owned());
            return Some(length);
        }
    }
    // "hot coffee" implies no color, "water glass" is in the lexicon.
    (vocabulary.grammar.substances.contains(w) && allowed(1) && adjective_position(lexicon, tokens, at + 1))
        .then_some(1)
}

/// Whether a noun follows directly, after further modifiers.
fn adjective_position(lexicon: &Lexicon, tokens: &[Token], at: usize) -> bool {
    let vocabulary = lexicon.vocabulary;
    for p in at..at + 6 {
        let Some(w) = word(tokens, p) else { return false };
        if lexicon.longest_at(tokens, p).is_some() {
            return true;
        }
        let is_modifier = color_of(vocabulary, w).is_some()
            || vocabulary.materials.contains_key(w)
            || vocabulary.sizes.contains_key(w)
            || vocabulary.stretch.contains_key(w)
            || vocabulary.shapes.contains_key(w)
            || vocabulary.shades.contains_key(w)
            || (w == "and" && word(tokens, p + 1).is_some_and(|next| color_of(vocabulary, next).is_some()));
        if !is_modifier && (GLUE.contains(&w) || !vocabulary.grammar.stop.contains(w)) {
            return false;
        }
    }
    false
}

/// Attributes after a verb: "the laptop is silver", "they are blue and small".
pub(super) fn predicate(lexicon: &Lexicon, tokens: &[Token], at: usize) -> Option<(Attributes, usize)> {
    let vocabulary = lexicon.vocabulary;
    let mut attributes = Attributes { scale: 1.0, ..Attributes::default() };
    let mut p = at;
    let mut found = false;
    while let Some(w) = word(tokens, p) {
        if matches!(w, "very" | "made" | "of" | "all" | "both" | "and" | "quite" | "about")
            || matches!(w, "a" | "in")
                && word(tokens, p + 1).is_some_and(|n| color_of(vocabulary, n).is_some())
        {
            p += 1;
            continue;
        }
        if let Some(color) = color_of(vocabulary, w) {
            attributes.colors.push(color);
            attributes.color_words.push(w.to_owned());
        } else if let Some(material) = vocabulary.materials.get(w) {
            attributes.substance = Some(material.substance.clone());
            attributes.material_color = material.color.as_deref().and_then(parse_hex);
            attributes.table_finish = material.table.clone();
        } else if let Some(&factor) = vocabulary.sizes.get(w) {
            attributes.scale *= factor;
        } else if vocabulary.shapes.contains_key(w) {
            attributes.shape = Some(w.to_owned());
        } else {
            break;
        }
        found = true;
        p += 1;
    }
    if matches!(tokens.get(p), Some(Token::Number(_)))
        && let Some((measures, length)) = read_measures(vocabulary, tokens, p)
    {
        attributes.measures.extend(measures);
        p += length;
        found = true;
    }
    // A continuation as a noun phrase means that this is not a predicate ("there are red mugs").
    let ends = word(tokens, p).is_none_or(|w| GLUE.contains(&w));
    (found && ends).then_some((attributes, p))
}

/// "X of Y" where the lexicon knows "Y X" (Y also in the singular, or fused).
fn inverted_phrase(lexicon: &Lexicon, tokens: &[Token], head: usize, of: usize) -> Option<(Entry, usize)> {
    let joined_words = |from: usize, to: usize| -> Option<String> {
        let words: Option<Vec<&str>> = (from..to).map(|p| word(tokens, p)).collect();
        words.map(|words| words.join(" "))
    };
    let noun = joined_words(head, of)?;
    let noun_singular = lexicon.vocabulary.singular_of(&noun);
    for length in [2, 1] {
        let Some(complement) = joined_words(of + 1, of + 1 + length) else { continue };
        for y in [complement.clone(), lexicon.vocabulary.singular_of(&complement)] {
            for x in [&noun, &noun_singular] {
                for phrase in [format!("{y} {x}"), format!("{y}{x}")] {
                    if let Some(entry) = lexicon.get(&phrase) {
                        return Some((entry.clone(), of + 1 + length));
                    }
                }
            }
        }
    }
    None
}

pub(super) fn color_of(vocabulary: &super::vocabulary::Vocabulary, name: &str) -> Option<Rgb> {
    vocabulary.colors.get(name).and_then(|hex| parse_hex(hex))
}

fn parse_hex(hex: &str) -> Option<Rgb> {
    u32::from_str_radix(hex.trim_start_matches('#'), 16).ok().map(Rgb::hex)
}
