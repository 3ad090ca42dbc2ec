//! Types named by a bare participle or adverb, which states no noun.

use crate::lexer::Token;

const BANNED: &[&str] = &[
    "Asked", "Behind", "Believed", "Drawn", "Found", "Given", "Grown", "Held", "Instead", "Kept", "Laid",
    "Looked", "Painted", "Said", "Seen", "Sent", "Shown", "Standing", "Taken", "Told", "Turned", "Under",
    "Wear",
];

/// Declared structs, enums, unions, traits, aliases and classes with a banned name, and their lines. Variants may have
/// one.
pub fn declared_participles(tokens: &[Token]) -> impl Iterator<Item = (&str, usize)> {
    let declarations = tokens.windows(2).filter(|pair| {
        matches!(pair[0].text.as_str(), "struct" | "enum" | "union" | "trait" | "type" | "class")
            && BANNED.contains(&pair[1].text.as_str())
    });
    declarations.map(|pair| (pair[1].text.as_str(), pair[1].line))
}
