//! Categories that a model may answer with: those that a text names, then others as far as the limits of
//! enumerations permit.

use catalog::{Category, categories};

/// Largest number of categories of an enumeration: all enumerations of a schema may have 1,000 values in strict mode
/// (OpenAI, "Structured Outputs", "Supported schemas").
const MAX_CATEGORIES: usize = 900;
/// Largest number of characters of their names; an enumeration may have 15,000.
const MAX_CHARS: usize = 14_000;

/// Names of categories, those whose names, labels or synonyms stand in the text first.
pub(super) fn offered_categories(text: &str) -> Vec<&'static str> {
    let text = format!(" {} ", plain_words(text));
    let is_named = |category: &&Category| {
        category.words().any(|word| {
            let word = plain_words(word);
            text.contains(&format!(" {word} ")) || text.contains(&format!(" {word}s "))
        })
    };
    let (named, others): (Vec<_>, Vec<_>) = categories().iter().partition(is_named);
    let mut chars = 0;
    let names = named.into_iter().chain(others).take(MAX_CATEGORIES).map(|category| category.name.as_str());
    names
        .take_while(|name| {
            chars += name.len();
            chars <= MAX_CHARS
        })
        .collect()
}

/// Lower-case words between single blanks.
fn plain_words(text: &str) -> String {
    let words = text.split(|c: char| !c.is_alphanumeric()).filter(|word| !word.is_empty());
    words.collect::<Vec<_>>().join(" ").to_lowercase()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_a_text_names_is_offered_first_and_the_limits_hold() {
        let text = "Two thermoses, a safety-pin and a stethoscope beside the last category";
        let last = categories().last().expect("a catalog");
        let offered = offered_categories(&format!("{text}: {}", last.label));
        for name in ["safety_pin", "stethoscope", last.name.as_str()] {
            assert!(offered[..12].contains(&name), "{name}: {:?}", &offered[..12]);
        }
        assert!(offered.len() <= MAX_CATEGORIES && offered.len() > 500, "{}", offered.len());
        assert!(offered.iter().map(|name| name.len()).sum::<usize>() <= MAX_CHARS);
        assert!(offered_categories("").contains(&"mug"));
    }
}
