//! Closed packages: "a can of peas and carrots", "a bottle of wine", "an olive oil bottle". What is in them is no
//! object of its own.

use super::head::words_of;
use super::{Chunk, is_boundary};
use crate::text_parser::lexicon::{Entry, Lexicon, Meaning, last_word};
use crate::text_parser::tokens::{Token, word};
use catalog::Affordance;

/// Maximum number of words of the contents of a package.
const MAX_CONTENTS: usize = 3;

impl Chunk<'_, '_> {
    /// The phrase that "of" continues: "bottle of wine" is the wine bottle, "ball of yarn" the yarn ball.
    pub(super) fn with_of(&self, entry: &Entry, start: usize, end: usize) -> Option<(Entry, usize)> {
        if word(self.tokens, end) != Some("of") {
            return None;
        }
        // "a mug of pencils" holds them; "a deck of cards" consists of them.
        let holds = matches!(word(self.tokens, end - 1), Some("mug" | "cup" | "glass" | "jar" | "bowl"))
            && self.lexicon.longest_at(self.tokens, end + 1).is_some_and(|(contents, _)| {
                contents.plural && matches!(contents.meanings.first(), Some(Meaning::Category(_)))
            });
        let inverted = inverted_phrase(self.lexicon, self.tokens, start, end).filter(|_| !holds);
        let (inverted, after) = inverted
            .or_else(|| self.package(start, end))
            .or_else(|| self.portion(start, end))
            .or_else(|| self.filled(entry, end))?;
        Some((Entry { plural: entry.plural, ..inverted }, after))
    }

    /// "a bar of milk chocolate": a portion of something is that.
    fn portion(&self, start: usize, of: usize) -> Option<(Entry, usize)> {
        let is_portion = of == start + 1
            && word(self.tokens, start)
                .is_some_and(|w| self.lexicon.vocabulary.grammar.partitives.contains(w));
        let (entry, length) = self.lexicon.longest_at(self.tokens, of + 1).filter(|_| is_portion)?;
        Some((entry.clone(), of + 1 + length))
    }

    /// "a cup of ranch": a vessel of what comes in a package stands in for itself with its contents.
    fn filled(&self, entry: &Entry, of: usize) -> Option<(Entry, usize)> {
        let categories = self.lexicon.categories;
        let category = |entry: &Entry| match entry.meanings.first() {
            Some(Meaning::Category(index)) => Some(&categories[*index]),
            _ => None,
        };
        let (contents, length) = self.lexicon.longest_at(self.tokens, of + 1)?;
        let package = category(contents).filter(|package| {
            let named = words_of(self.tokens, of + 1..of + 1 + length).collect::<Vec<_>>().join(" ");
            ["bottle", "can", "package"].contains(&package.group.as_str())
                && !contents.plural
                && last_word(&named) != last_word(&package.label)
        });
        package?;
        category(entry).filter(|vessel| vessel.affords(Affordance::Container))?;
        Some((Entry { stands_in: true, ..entry.clone() }, of + 1 + length))
    }

    /// "olive oil bottle": a noun that by itself means a package is followed by the name of that package.
    pub(super) fn is_package_of(&self, entry: &Entry, at: usize, length: usize) -> bool {
        let Some(Meaning::Category(index)) = entry.meanings.first() else { return false };
        // The head of "bottle of oil" and of "pudding box".
        let label = self.lexicon.categories[*index].label.split(" of ").next().map_or("", last_word);
        let next = words_of(self.tokens, at..at + length).collect::<Vec<_>>().join(" ");
        self.lexicon.vocabulary.singular_of(&next) == label
    }

    /// "a can of peas and carrots": the position after all contents.
    pub(super) fn more_contents(&self, start: usize, end: usize) -> usize {
        let vocabulary = self.lexicon.vocabulary;
        let is_plural = |at: usize| word(self.tokens, at).is_some_and(|w| vocabulary.singular_of(w) != w);
        let is_contained = self.package_category(start).is_some()
            && word(self.tokens, start + 1) == Some("of")
            && word(self.tokens, end) == Some("and")
            && is_plural(end - 1)
            && is_plural(end + 1)
            && word(self.tokens, end + 2).is_none_or(|next| is_boundary(vocabulary, next));
        if is_contained { end + 2 } else { end }
    }

    /// "a can of lychees": a package of something that the lexicon does not have in such a package; the position after
    /// its contents.
    fn package(&self, start: usize, of: usize) -> Option<(Entry, usize)> {
        let vocabulary = self.lexicon.vocabulary;
        let category = self.package_category(start).filter(|_| of == start + 1)?;
        let is_of_contents = |w: &str| {
            !is_boundary(vocabulary, w)
                && !vocabulary.grammar.after_noun.contains(w)
                && !vocabulary.numbers.contains_key(w)
                && !vocabulary.grammar.substances.contains(w)
        };
        let length = (0..MAX_CONTENTS)
            .take_while(|k| word(self.tokens, of + 1 + k).is_some_and(is_of_contents))
            .count();
        let meanings = vec![Meaning::Category(category)];
        (length > 0).then_some((Entry { meanings, ..Entry::default() }, of + 1 + length))
    }

    /// The category of closed packages that a word names.
    fn package_category(&self, at: usize) -> Option<usize> {
        let vocabulary = self.lexicon.vocabulary;
        let noun = vocabulary.singular_of(word(self.tokens, at)?);
        self.lexicon.index_of(vocabulary.packages.get(&noun)?)
    }
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

#[cfg(test)]
mod tests {
    use super::super::noun_phrase;
    use crate::text_parser::LEXICON;
    use crate::text_parser::lexicon::Meaning;
    use crate::text_parser::phrase::Head;
    use crate::text_parser::tokens::tokenize;

    /// Text, category, and the number of tokens of the phrase.
    #[test]
    fn packages_are_one_object_with_their_contents() {
        for (text, category, length) in [
            ("a can of peas and carrots", "food_can", 6),
            ("two cans of lychees next to a mug", "food_can", 4),
            ("a can of tomatoes and a plate", "tomato_can", 4),
            ("a bottle of wine", "wine_bottle", 4),
            ("an olive oil bottle", "oil_bottle", 4),
            ("the chocolate pudding box", "pudding_box", 4),
            ("a bar of milk chocolate", "chocolate_bar", 5),
            ("a masking tape roll", "masking_tape_roll", 4),
        ] {
            let (phrase, end) = noun_phrase(&LEXICON, &tokenize(text), 0).expect(text);
            let index = LEXICON.index_of(category).expect(category);
            assert_eq!(phrase.head, Head::Objects(vec![Meaning::Category(index)]), "{text}");
            assert_eq!((end, phrase.stand_in), (length, None), "{text}");
        }
    }
}
