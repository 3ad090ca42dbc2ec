//! Objects of instructions without a name: "put the object in the bowl", "move the green one", "stack red on blue".

use super::Parser;
use super::action::{Action, Part};
use crate::text_parser::phrase::{Determiner, Head, NounPhrase, color_of, noun_phrase};
use crate::text_parser::property::Property;
use crate::text_parser::tokens::tokenize;

/// The noun of `[[vague]]` for an object that the text does not name.
const ANY_OBJECT: &str = "unnamed object";

/// Noun of a color that stands without one.
const COLORED: &str = "block";

impl Parser<'_, '_> {
    /// A phrase with the meaning of a noun that the text does not have, for tokens of the text.
    fn implied_noun(&self, noun: &str, tokens: std::ops::Range<usize>) -> Option<NounPhrase> {
        let words = tokenize(noun);
        let (phrase, _) = noun_phrase(self.lexicon, &words, 0)?;
        matches!(phrase.head, Head::Objects(_)).then(|| NounPhrase {
            determiner: Determiner::New,
            count: Some([1, 1]),
            plural: false,
            head_tokens: tokens.clone(),
            tokens,
            properties: Vec::new(),
            ..phrase
        })
    }

    /// "the object", "something green" as the object of an instruction: the object that the text was about, or any.
    pub(super) fn unnamed_object(&mut self, action: &mut Action) -> bool {
        let start = self.at;
        let mut p = start;
        let mut color = None;
        while let Some(word) = self.word_at(p) {
            let found = color_of(self.lexicon.vocabulary, word).map(|color| (color, word.to_owned(), p));
            if found.is_none()
                && !matches!(word, "the" | "this" | "that" | "a" | "an" | "any" | "some" | "first")
            {
                break;
            }
            color = found.or(color);
            p += 1;
        }
        let named = matches!(self.word_at(p), Some("object" | "item" | "thing"));
        let alone = matches!(self.word_at(p), Some("something" | "anything"));
        if !(named && p > start || alone && p == start) {
            return false;
        }
        let end = p + 1;
        self.parsed.account.used(start..end);
        self.at = end;
        // "there is a mug; pick up the object".
        let known = self.salient.filter(|_| named && color.is_none());
        let mention = match known {
            Some(known) => known,
            None => {
                let Some(mut phrase) = self.implied_noun(ANY_OBJECT, start..end) else { return true };
                if let Some((rgb, word, at)) = color {
                    phrase.attributes.colors = vec![rgb];
                    phrase.attributes.color_words = vec![word];
                    phrase.properties.push((Property::Color, at..at + 1));
                }
                let Head::Objects(meanings) = phrase.head.clone() else { return true };
                self.add_mention(meanings, phrase, false)
            }
        };
        action.objects.push(Part { mention, take: None });
        self.salient = Some(mention);
        self.salient_list = action.objects.iter().map(|part| part.mention).collect();
        true
    }

    /// "red" of "stack red on blue" in a text without objects of that color: a block.
    pub(super) fn colored_block(&mut self, phrase: &NounPhrase) -> Option<usize> {
        let is_bare = phrase.head == Head::One
            && phrase.determiner == Determiner::Definite
            && phrase.selector.is_none()
            && phrase.attributes.color_words.len() == 1
            && phrase.tokens.len() <= 2;
        let block = self.implied_noun(COLORED, phrase.tokens.clone()).filter(|_| is_bare)?;
        let Head::Objects(meanings) = block.head.clone() else { return None };
        let words = format!("{} {COLORED}", phrase.attributes.color_words[0]);
        let (attributes, properties) = (phrase.attributes.clone(), phrase.properties.clone());
        let block = NounPhrase { attributes, properties, words, ..block };
        Some(self.add_mention(meanings, block, false))
    }
}
