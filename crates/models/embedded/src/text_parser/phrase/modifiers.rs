//! Modifiers of noun phrases: colors, materials, sizes, shapes and measures, before a noun or after a verb.

use super::{Attributes, Variant, is_boundary};
use crate::text_parser::lexicon::Lexicon;
use crate::text_parser::measures::{Reading, read_measure, trailing};
use crate::text_parser::property::Property;
use crate::text_parser::tokens::{Token, word};
use crate::text_parser::vocabulary::Vocabulary;
use geometry::Rgb;

/// A modifier: the number of tokens and the property it describes.
pub(super) struct Modifier {
    pub length: usize,
    pub property: Property,
    /// Whether the phrase has a property that excludes this one ("a small large bowl"); it is not added then.
    pub contradicts: bool,
}

impl Modifier {
    fn new(length: usize, property: Property) -> Self {
        Self { length, property, contradicts: false }
    }
}

impl Attributes {
    pub fn add_reading(&mut self, reading: Reading) -> Property {
        let property = match (&reading.lengths[..], reading.volume_m3) {
            ([], None) => Property::Mass,
            ([], Some(_)) => Property::Volume,
            _ => Property::Size,
        };
        self.measures.extend(reading.lengths);
        self.volume_m3 = reading.volume_m3.or(self.volume_m3);
        self.mass_kg = reading.mass_kg.or(self.mass_kg);
        property
    }

    /// The property of a word that excludes one of these: "large" after "small", "steel" after "wooden".
    fn excludes(&self, vocabulary: &Vocabulary, name: &str) -> Option<Property> {
        if color_of(vocabulary, name).is_some() {
            return None;
        }
        let size = vocabulary.sizes.get(name).is_some_and(|size| (size - 1.0) * (self.scale - 1.0) < -1e-9);
        let material = vocabulary.materials.get(name).is_some_and(|material| {
            self.substance.as_ref().is_some_and(|known| *known != material.substance)
        });
        match (size, material) {
            (true, _) => Some(Property::Size),
            (_, true) => Some(Property::Material),
            _ => None,
        }
    }

    /// Adds the attribute that a word or two words name; the property, or `None` if they name none.
    fn add_word(&mut self, vocabulary: &Vocabulary, name: &str) -> Option<Property> {
        if let Some(color) = color_of(vocabulary, name) {
            self.colors.push(color);
            self.color_words.push(name.to_owned());
            return Some(Property::Color);
        }
        if let Some(material) = vocabulary.materials.get(name) {
            self.substance = Some(material.substance.clone());
            self.material_color = material.color.as_deref().and_then(parse_hex);
            self.table_finish = material.table.clone();
            return Some(Property::Material);
        }
        if let Some(&factor) = vocabulary.sizes.get(name) {
            self.scale *= factor;
            return Some(Property::Size);
        }
        if let Some(stretch) = vocabulary.stretch.get(name) {
            self.stretches.push((stretch.axis, stretch.factor));
            return Some(Property::Size);
        }
        if vocabulary.shapes.contains_key(name) {
            self.shape = Some(name.to_owned());
            return Some(Property::Shape);
        }
        None
    }
}

/// A color, material, size, shape or measure at `at`.
pub(super) fn modifier(
    lexicon: &Lexicon,
    tokens: &[Token],
    at: usize,
    attributes: &mut Attributes,
) -> Option<Modifier> {
    let vocabulary = lexicon.vocabulary;
    let w = word(tokens, at)?;
    let two = word(tokens, at + 1).map(|next| format!("{w} {next}"));
    let object = lexicon.longest_at(tokens, at).map_or(0, |(_, length)| length);
    let listed = |length: usize, property: Property| {
        list_end(vocabulary, tokens, at + length, property)
            .is_some_and(|end| adjective_position(lexicon, tokens, end))
    };
    let allowed = |length: usize| {
        length > object
            || (length == object
                && (adjective_position(lexicon, tokens, at + length)
                    || [Property::Color, Property::Material, Property::Size]
                        .into_iter()
                        .any(|kind| is_of_kind(vocabulary, w, kind) && listed(length, kind))))
    };
    if let Some((reading, length)) = read_measure(vocabulary, tokens, at)
        && allowed(length)
    {
        return Some(Modifier::new(length, attributes.add_reading(reading)));
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
                return Some(Modifier::new(length, Property::Color));
            }
        }
    }
    for (name, length) in [(two.as_deref(), 2), (Some(w), 1)] {
        let Some(name) = name else { continue };
        if !allowed(length) {
            continue;
        }
        let scale = attributes.scale;
        if let Some(property) = attributes.excludes(vocabulary, name)
            && attributes.variants.is_empty()
            && !listed(length, property)
        {
            return Some(Modifier { length, property, contradicts: true });
        }
        if let Some(property) = attributes.add_word(vocabulary, name) {
            // "red, blue and green mugs": the next property belongs to the same phrase.
            let joined = listed(length, property);
            let continues = attributes.variants.last().is_some_and(|variant| variant.property == property)
                && matches!(tokens[at - 1], Token::Pause | Token::Word(_))
                && !is_of_kind(vocabulary, word(tokens, at - 1).unwrap_or_default(), property);
            if matches!(property, Property::Material | Property::Size) && (joined || continues) {
                attributes.variants.push(Variant {
                    word: name.to_owned(),
                    property,
                    substance: attributes.substance.clone(),
                    material_color: attributes.material_color,
                    scale: vocabulary.sizes.get(name).copied().unwrap_or(1.0),
                });
                attributes.scale = scale;
            }
            let comma = usize::from(joined && matches!(tokens.get(at + length), Some(Token::Pause)));
            let and = usize::from(joined && matches!(word(tokens, at + length + comma), Some("and" | "or")));
            return Some(Modifier::new(length + comma + and, property));
        }
    }
    // "hot coffee" implies no color, "water glass" is in the lexicon.
    let substance = vocabulary.grammar.substances.contains(w)
        && allowed(1)
        && adjective_position(lexicon, tokens, at + 1);
    substance.then_some(Modifier::new(1, Property::Content))
}

/// The position after further properties of one kind: after ", blue and green" where "red" is before it.
fn list_end(vocabulary: &Vocabulary, tokens: &[Token], at: usize, property: Property) -> Option<usize> {
    let mut end = at;
    // At most this many properties.
    for _ in 0..6 {
        let comma = usize::from(matches!(tokens.get(end), Some(Token::Pause)));
        let and = usize::from(matches!(word(tokens, end + comma), Some("and" | "or")));
        let mut p = end + comma + and;
        p += usize::from(
            property == Property::Color && word(tokens, p).is_some_and(|w| vocabulary.shades.contains_key(w)),
        );
        if comma + and == 0 || !is_of_kind(vocabulary, word(tokens, p)?, property) {
            return None;
        }
        end = p + 1;
        if and == 1 {
            return Some(end);
        }
    }
    None
}

/// Whether the word is a property of this kind.
fn is_of_kind(vocabulary: &Vocabulary, word: &str, property: Property) -> bool {
    match property {
        Property::Color => color_of(vocabulary, word).is_some(),
        Property::Material => vocabulary.materials.contains_key(word),
        Property::Size => vocabulary.sizes.contains_key(word),
        _ => false,
    }
}

/// Whether a noun follows directly, after further modifiers.
pub(super) fn adjective_position(lexicon: &Lexicon, tokens: &[Token], at: usize) -> bool {
    let vocabulary = lexicon.vocabulary;
    for p in at..at + 6 {
        let Some(w) = word(tokens, p) else { return false };
        if lexicon.longest_at(tokens, p).is_some() || matches!(w, "one" | "ones") && p > at.saturating_sub(1)
        {
            return true;
        }
        let is_modifier = is_attribute(vocabulary, w)
            || vocabulary.shades.contains_key(w)
            || (w == "and" && word(tokens, p + 1).is_some_and(|next| color_of(vocabulary, next).is_some()));
        if is_modifier {
            continue;
        }
        if is_boundary(vocabulary, w) {
            return false;
        }
        if !vocabulary.is_ordinary(w) {
            // A noun outside the lexicon.
            return true;
        }
    }
    false
}

pub(super) fn is_attribute(vocabulary: &Vocabulary, word: &str) -> bool {
    vocabulary.colors.contains_key(word)
        || vocabulary.materials.contains_key(word)
        || vocabulary.sizes.contains_key(word)
        || vocabulary.stretch.contains_key(word)
        || vocabulary.shapes.contains_key(word)
}

/// Attributes after a verb, with the property of each token range, and the position after them: "the laptop is silver",
/// "they are blue and small", "a mug (red)".
pub(in crate::text_parser) fn predicate(
    lexicon: &Lexicon,
    tokens: &[Token],
    at: usize,
) -> Option<(Attributes, Vec<super::PropertySpan>, usize)> {
    let vocabulary = lexicon.vocabulary;
    let mut attributes = Attributes { scale: 1.0, ..Attributes::default() };
    let mut properties = Vec::new();
    let mut p = at;
    let is_color = |p: usize| word(tokens, p).is_some_and(|next| color_of(vocabulary, next).is_some());
    loop {
        // "in red, green and blue".
        if matches!(tokens.get(p), Some(Token::Pause))
            && p > at
            && is_color(p - 1)
            && (is_color(p + 1) || word(tokens, p + 1) == Some("and") && is_color(p + 2))
        {
            p += 1;
        }
        let Some(w) = word(tokens, p) else { break };
        if matches!(
            w,
            "very" | "made" | "of" | "all" | "both" | "and" | "quite" | "about" | "colored" | "coloured"
        ) || matches!(w, "a" | "in")
            && word(tokens, p + 1).is_some_and(|n| color_of(vocabulary, n).is_some())
        {
            p += 1;
            continue;
        }
        let shade = vocabulary.shades.contains_key(w)
            && word(tokens, p + 1).is_some_and(|next| color_of(vocabulary, next).is_some());
        if shade && let Some(found) = modifier_alone(vocabulary, tokens, p, &mut attributes) {
            properties.push((Property::Color, p..p + found));
            p += found;
            continue;
        }
        match attributes.add_word(vocabulary, w) {
            Some(property) => properties.push((property, p..p + 1)),
            None => break,
        }
        p += 1;
    }
    let (readings, end) = trailing(vocabulary, tokens, p);
    for (reading, range) in readings {
        properties.push((attributes.add_reading(reading), range));
        p = end;
    }
    // "and" before the next clause is not part of it.
    while p > at && matches!(word(tokens, p - 1), Some("and" | "all" | "both" | "a" | "in")) {
        p -= 1;
    }
    // A continuation as a noun phrase means that this is not a predicate ("there are red mugs").
    let ends =
        word(tokens, p).is_none_or(|w| is_boundary(vocabulary, w)) || matches!(word(tokens, p), Some("too"));
    (!properties.is_empty() && ends).then_some((attributes, properties, p))
}

/// "light blue" outside a noun phrase; the number of tokens.
fn modifier_alone(
    vocabulary: &Vocabulary,
    tokens: &[Token],
    at: usize,
    attributes: &mut Attributes,
) -> Option<usize> {
    let shade = *vocabulary.shades.get(word(tokens, at)?)?;
    let name = word(tokens, at + 1)?;
    let color = color_of(vocabulary, name)?;
    let toward = if shade >= 0.0 { Rgb([1.0; 3]) } else { Rgb([0.0; 3]) };
    attributes.colors.push(color.mix(toward, shade.abs()));
    attributes.color_words.push(format!("{} {name}", word(tokens, at)?));
    Some(2)
}

pub(in crate::text_parser) fn color_of(vocabulary: &Vocabulary, name: &str) -> Option<Rgb> {
    vocabulary.colors.get(name).and_then(|hex| parse_hex(hex))
}

fn parse_hex(hex: &str) -> Option<Rgb> {
    u32::from_str_radix(hex.trim_start_matches('#'), 16).ok().map(Rgb::hex)
}
