//! The lexicon: phrases for catalog categories, tables and vague sets, in singular and plural.
//!
//! Built once from the catalog's labels and synonyms, the aliases of `words.toml` and the vague sets of
//! `themes.toml`. A phrase may have several senses; the scene's family picks one later. Lookup is
//! longest match over whole words.

use std::collections::{BTreeMap, BTreeSet};

use super::correction::is_known;
use super::draft::Kind;
use super::nouns::Nouns;
use super::phrases::phrases;
use super::themes::Themes;
use super::tokens::{Token, tokenize};
use super::vocabulary::Vocabulary;
use catalog::{Category, TableModel};
use runtime::edit_distance;

/// A meaning of a phrase.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Meaning {
    /// Index into the catalog's categories.
    Category(usize),
    /// The table, with the model if the phrase names one.
    Table(Option<String>),
    /// Index into the vague sets.
    Vague(usize),
    /// A noun outside the catalog that has a stand-in.
    StandIn(String),
}

/// An entry of the lexicon.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(super) struct Entry {
    /// Senses, best first.
    pub meanings: Vec<Meaning>,
    /// Whether the form is a plural ("mugs").
    pub plural: bool,
    /// Whether singular and plural are identical ("scissors", "coffee"); without a count it means one.
    pub one_by_default: bool,
    /// Whether the phrase names another object, for which the category only stands in.
    pub stands_in: bool,
}

/// Manner in which a phrase names its meaning.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Naming {
    Count,
    /// "some coffee" is one.
    Mass,
    /// The category stands in for what the phrase names.
    StandIn,
}

pub(super) struct Lexicon<'c> {
    pub categories: &'c [Category],
    pub tables: &'c [TableModel],
    pub vocabulary: &'c Vocabulary,
    pub themes: &'c Themes,
    pub nouns: &'c dyn Nouns,
    /// Words of the phrases.
    words: BTreeSet<String>,
    phrases: BTreeMap<String, Entry>,
    longest: usize,
}

impl<'c> Lexicon<'c> {
    pub fn new(
        categories: &'c [Category],
        tables: &'c [TableModel],
        vocabulary: &'c Vocabulary,
        themes: &'c Themes,
        nouns: &'c dyn Nouns,
    ) -> Self {
        let (phrases, words) = (BTreeMap::new(), BTreeSet::new());
        let mut lexicon = Self { categories, tables, vocabulary, themes, nouns, words, phrases, longest: 1 };
        lexicon.add_tables();
        // Labels precede aliases, aliases precede synonyms.
        for (index, category) in categories.iter().enumerate() {
            let own = vec![category.label.clone(), category.name.replace('_', " ")];
            for phrase in own {
                lexicon.add(&phrase, category.plural.as_deref(), Meaning::Category(index), Naming::Count);
            }
        }
        let aliases = [(&vocabulary.aliases, Naming::Count), (&vocabulary.drinks, Naming::Mass)];
        for (aliases, naming) in aliases {
            for (name, phrases) in aliases {
                if let Some(index) = lexicon.index_of(name) {
                    for phrase in phrases {
                        lexicon.add(phrase, None, Meaning::Category(index), naming);
                    }
                }
            }
        }
        let mut synonyms: Vec<(usize, &String)> = categories
            .iter()
            .enumerate()
            .flat_map(|(index, category)| category.synonyms.iter().map(move |phrase| (index, phrase)))
            .collect();
        // Shorter phrases first, since what they mean decides whether a longer one says more.
        synonyms.sort_by_key(|(_, phrase)| phrase.split(' ').count());
        for (index, phrase) in synonyms {
            if !lexicon.is_described(phrase, &Meaning::Category(index)) {
                lexicon.add(phrase, None, Meaning::Category(index), Naming::Count);
            }
        }
        for (index, vague) in themes.vague.iter().enumerate() {
            for phrase in &vague.words {
                lexicon.add(phrase, None, Meaning::Vague(index), Naming::Count);
            }
        }
        for (index, category) in categories.iter().enumerate() {
            for phrase in &category.stands_in_for {
                lexicon.add(phrase, None, Meaning::Category(index), Naming::StandIn);
            }
        }
        let words = lexicon.phrases.keys().flat_map(|phrase| phrase.split(' ')).map(str::to_owned);
        lexicon.words = words.collect();
        lexicon
    }

    /// Whether a phrase is a color, a material or a size before another phrase of the same meaning ("red apple"): its
    /// first word then is a property, not a part of the name.
    fn is_described(&self, phrase: &str, meaning: &Meaning) -> bool {
        let Some((first, rest)) = phrase.split_once(' ') else { return false };
        // "Orange juice" and "olive oil" are names, so that "orange juice carton" is one as well.
        let words: Vec<&str> = phrase.split(' ').collect();
        if (2..words.len()).any(|length| self.phrases.contains_key(&words[..length].join(" "))) {
            return false;
        }
        let vocabulary = self.vocabulary;
        // A small plate is a plate, even where another category has that name.
        if vocabulary.sizes.contains_key(first) && self.phrases.contains_key(rest) {
            return true;
        }
        let is_property = vocabulary.colors.contains_key(first) || vocabulary.materials.contains_key(first);
        is_property && self.phrases.get(rest).is_some_and(|known| known.meanings.first() == Some(meaning))
    }

    /// Whether the word occurs in a phrase of the lexicon.
    pub fn has_word(&self, word: &str) -> bool {
        self.words.contains(word)
    }

    /// Whether the word alone names an object of the catalog.
    pub fn names_object(&self, word: &str) -> bool {
        self.get(word).is_some_and(|entry| matches!(entry.meanings[0], Meaning::Category(_)))
    }

    pub fn words(&self) -> impl Iterator<Item = &str> {
        self.words.iter().map(String::as_str)
    }

    /// The meaning of an unknown noun that has a stand-in, or whose last word has one ("pet collar").
    pub fn stand_in(&self, noun: &str) -> Option<Meaning> {
        let singular = self.vocabulary.singular_of(noun);
        let whole = [singular.as_str(), noun].into_iter().find(|noun| self.nouns.stand_in(noun).is_some());
        if let Some(noun) = whole {
            return Some(Meaning::StandIn(noun.to_owned()));
        }
        // Nothing follows from the last word after a word that is not known ("zorblax holder").
        let (modifiers, _) = noun.rsplit_once(' ')?;
        let is_known = |word: &str| is_known(self, word) || self.nouns.is_noun(word);
        if self.nouns.is_not_placeable(&singular) || !modifiers.split(' ').all(is_known) {
            return None;
        }
        [singular.as_str(), noun]
            .into_iter()
            .find(|noun| self.nouns.stand_in(last_word(noun)).is_some())
            .map(|noun| Meaning::StandIn(noun.to_owned()))
    }

    /// The meaning of a noun that is the short name of a category where it stands alone ("the holder").
    pub fn short_name(&self, noun: &str) -> Option<Meaning> {
        let category = self.vocabulary.short_names.get(&self.vocabulary.singular_of(noun))?;
        self.index_of(category).map(Meaning::Category)
    }

    /// The category of a meaning, or the shape of its stand-in.
    pub fn kind(&self, meaning: &Meaning) -> Option<Kind<'c>> {
        match meaning {
            Meaning::Category(index) => Some(Kind::of(&self.categories[*index])),
            Meaning::StandIn(noun) => {
                let stand_in = self.nouns.stand_in(noun).or_else(|| self.nouns.stand_in(last_word(noun)))?;
                Some(Kind {
                    category: stand_in.category,
                    size: stand_in.size,
                    stand_in: Some((noun.clone(), Some(stand_in.substance))),
                })
            }
            _ => None,
        }
    }

    fn add_tables(&mut self) {
        let (vocabulary, tables) = (self.vocabulary, self.tables);
        for (phrase, model) in &vocabulary.tables {
            let model = tables.iter().find(|table| table.name == model).map(|table| table.name.to_owned());
            self.add(phrase, None, Meaning::Table(model), Naming::Count);
        }
        for table in tables {
            for phrase in std::iter::once(&table.label).chain(table.synonyms) {
                self.add(phrase, None, Meaning::Table(Some(table.name.to_owned())), Naming::Count);
            }
        }
    }

    fn add(&mut self, phrase: &str, plural: Option<&str>, meaning: Meaning, naming: Naming) {
        let (mass, stands_in) = (naming == Naming::Mass, naming == Naming::StandIn);
        let singular = normalize(phrase);
        if singular.is_empty() {
            return;
        }
        let plural = plural.map_or_else(|| self.vocabulary.plural_of(&singular), normalize);
        let last = singular.rsplit(' ').next().unwrap_or_default();
        let same = mass
            || self.vocabulary.grammar.plural_only.contains(&singular)
            || self.vocabulary.grammar.plural_only.contains(last)
            || singular == plural;
        let mut forms = vec![(singular.clone(), false)];
        if plural != singular && !mass {
            forms.push((plural, true));
        }
        // "desklamp" for "desk lamp".
        if singular.split(' ').count() == 2 && !mass {
            let fused = singular.replace(' ', "");
            let fused_plural = self.vocabulary.plural_of(&fused);
            forms.push((fused, false));
            forms.push((fused_plural, true));
        }
        // What a phrase names comes before what stands in for it.
        forms.retain(|(form, _)| !stands_in || !self.phrases.contains_key(form));
        for (form, is_plural) in forms {
            self.longest = self.longest.max(form.split(' ').count());
            let entry = self.phrases.entry(form).or_insert_with(|| Entry {
                meanings: Vec::new(),
                plural: is_plural && !same,
                one_by_default: same,
                stands_in,
            });
            // A word that is the plural of one noun and the singular of another ("glasses") counts as both.
            if entry.plural && same && !mass {
                entry.one_by_default = true;
            }
            if !entry.meanings.contains(&meaning) {
                entry.meanings.push(meaning.clone());
            }
        }
    }

    /// Index of the category with this name.
    pub fn index_of(&self, name: &str) -> Option<usize> {
        self.categories.iter().position(|category| category.name == name)
    }

    /// The entry of exactly these words.
    pub fn get(&self, phrase: &str) -> Option<&Entry> {
        self.phrases.get(phrase)
    }

    /// The longest phrase that starts at `at`, with its number of tokens.
    pub fn longest_at(&self, tokens: &[Token], at: usize) -> Option<(&Entry, usize)> {
        let mut phrase = String::new();
        let mut best = None;
        // After a person, a plural is a verb: "the chef bowls".
        let before = at.checked_sub(1).and_then(|before| tokens.get(before)).and_then(Token::word);
        let after_person = before.is_some_and(|word| phrases().agent.persons.has(word));
        for (k, token) in tokens[at.min(tokens.len())..].iter().take(self.longest).enumerate() {
            let Some(word) = token.word() else { break };
            if k > 0 {
                phrase.push(' ');
            }
            phrase.push_str(word);
            // "A coin-sized button" is no coin.
            let is_measure = tokens.get(at + k + 1).and_then(Token::word) == Some("sized");
            // "Behind the laptop stands a lamp."
            let is_verb = k > 0 && matches!(word, "stands" | "rests" | "holds") && {
                let next = tokens.get(at + k + 1).and_then(Token::word);
                matches!(next, Some("a" | "an" | "the"))
            };
            let is_noun =
                |entry: &&Entry| !is_measure && !(entry.plural && (is_verb || after_person && k == 0));
            if let Some(entry) = self.phrases.get(&phrase).filter(is_noun) {
                best = Some((entry, k + 1));
            }
        }
        best
    }

    /// Known words closest to an unknown one, best first.
    pub fn closest(&self, word: &str, how_many: usize) -> Vec<String> {
        let length = word.chars().count();
        if length > LONGEST_COMPARED {
            return Vec::new();
        }
        let limit = (length / 3).clamp(1, 3);
        let mut scored: Vec<(usize, &String)> = self
            .phrases
            .iter()
            .filter(|(_, entry)| !entry.plural && matches!(entry.meanings[0], Meaning::Category(_)))
            .map(|(phrase, _)| (edit_distance(word, phrase), phrase))
            .filter(|(distance, _)| *distance <= limit)
            .collect();
        scored.sort();
        let mut seen = BTreeSet::new();
        scored
            .into_iter()
            .filter(|(_, phrase)| seen.insert((*phrase).clone()))
            .take(how_many)
            .map(|(_, phrase)| phrase.clone())
            .collect()
    }
}

/// Length of the longest word for which known words are suggested.
const LONGEST_COMPARED: usize = 24;

/// The head of a compound.
pub(super) fn last_word(phrase: &str) -> &str {
    phrase.rsplit(' ').next().unwrap_or(phrase)
}

fn normalize(phrase: &str) -> String {
    tokenize(phrase)
        .iter()
        .filter_map(|token| match token {
            Token::Word(word) => Some(word.clone()),
            _ => None,
        })
        .collect::<Vec<_>>()
        .join(" ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn distances_are_levenshtein() {
        assert_eq!(edit_distance("kitten", "sitting"), 3);
        assert_eq!(edit_distance("", "abc"), 3);
        assert_eq!(edit_distance("labtop", "laptop"), 1);
    }
}
