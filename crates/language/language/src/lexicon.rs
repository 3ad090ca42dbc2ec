//! Classes of words that constructions name: verbs in all their forms, function words. They are data, in
//! `config/language`.

use std::collections::BTreeMap;
use std::sync::LazyLock;

use serde::Deserialize;

use crate::tokens::Token;

/// Forms of a verb.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Form {
    /// "put"
    Base,
    /// "putting"
    Ing,
    /// "put", "moved": the past participle.
    Done,
    /// "puts"
    Third,
}

/// A word or several.
pub(crate) type Phrase = Vec<String>;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Verbs {
    classes: BTreeMap<String, Vec<String>>,
    irregular: BTreeMap<String, [String; 2]>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct FunctionWords {
    classes: BTreeMap<String, Vec<String>>,
    determiners: BTreeMap<String, Vec<String>>,
    adjectives: BTreeMap<String, Vec<String>>,
    relations: BTreeMap<String, Vec<String>>,
    qualifiers: BTreeMap<String, Vec<String>>,
    emphasis: BTreeMap<String, Vec<String>>,
}

/// All classes.
pub(crate) struct Lexicon {
    verbs: BTreeMap<(String, Form), Vec<Phrase>>,
    /// Phrases of every table of function words, by their names.
    words: BTreeMap<String, Vec<Phrase>>,
    /// Words that cannot be the noun of a phrase.
    function_words: std::collections::BTreeSet<String>,
}

static LEXICON: LazyLock<Lexicon> = LazyLock::new(|| {
    let verbs: Verbs = toml::from_str(include_str!("../../../../config/language/verbs.toml"))
        .expect("the built-in verbs parse (a test loads them)");
    let words: FunctionWords =
        toml::from_str(include_str!("../../../../config/language/function_words.toml"))
            .expect("the built-in function words parse (a test loads them)");
    Lexicon::new(verbs, words)
});

/// The built-in classes.
pub(crate) fn lexicon() -> &'static Lexicon {
    &LEXICON
}

impl Lexicon {
    fn new(verbs: Verbs, words: FunctionWords) -> Self {
        let mut by_form = BTreeMap::new();
        for (class, bases) in &verbs.classes {
            for form in [Form::Base, Form::Ing, Form::Done, Form::Third] {
                let regular = bases.iter().map(|base| inflected(base, form, &verbs.irregular));
                let phrases: Vec<Phrase> =
                    regular.flat_map(|phrase| [british(&phrase), Some(phrase)]).flatten().collect();
                by_form.insert((class.clone(), form), phrases);
            }
        }
        let FunctionWords { classes, determiners, adjectives, relations, qualifiers, emphasis } = words;
        let mut tables = BTreeMap::new();
        for table in [classes, determiners, relations, qualifiers] {
            tables.extend(table);
        }
        tables.insert("adjective".to_owned(), adjectives.into_values().flatten().collect());
        tables.insert("emphasis".to_owned(), emphasis.into_values().flatten().collect());
        let words: BTreeMap<String, Vec<Phrase>> = tables
            .into_iter()
            .map(|(class, phrases)| (class, phrases.iter().map(|p| split(p)).collect()))
            .collect();
        let never = [
            "definite",
            "indefinite",
            "all",
            "next_to",
            "on",
            "in",
            "between",
            "from",
            "out_of",
            "behind",
            "closed",
        ];
        let single = |phrase: &&Phrase| phrase.len() == 1;
        let function_words = never
            .iter()
            .flat_map(|class| words[*class].iter().filter(single))
            .map(|phrase| phrase[0].clone())
            .collect();
        Self { verbs: by_form, words, function_words }
    }

    /// Number of tokens of each phrase of a class that begins at an index.
    pub fn lengths(&self, class: &str, tokens: &[Token], at: usize) -> Vec<usize> {
        lengths(self.words.get(class).map_or(&[], Vec::as_slice), tokens, at)
    }

    /// As [`Self::lengths`], for verbs in a form.
    pub fn verb_lengths(&self, class: &str, form: Form, tokens: &[Token], at: usize) -> Vec<usize> {
        lengths(self.verbs.get(&(class.to_owned(), form)).map_or(&[], Vec::as_slice), tokens, at)
    }

    /// Whether a class of verbs or of words has this name.
    pub fn is_class(&self, class: &str) -> bool {
        self.words.contains_key(class) || self.verbs.contains_key(&(class.to_owned(), Form::Base))
    }

    /// Whether the class is one of verbs.
    pub fn is_verb_class(&self, class: &str) -> bool {
        self.verbs.contains_key(&(class.to_owned(), Form::Base))
    }

    /// Whether a word cannot be the noun of a phrase.
    pub fn is_function_word(&self, word: &str) -> bool {
        self.function_words.contains(word)
    }
}

fn lengths(phrases: &[Phrase], tokens: &[Token], at: usize) -> Vec<usize> {
    let mut found: Vec<usize> =
        phrases.iter().filter(|phrase| begins_with(tokens, at, phrase)).map(Vec::len).collect();
    found.sort_unstable();
    found.dedup();
    found
}

/// Whether these words stand at an index.
pub(crate) fn begins_with(tokens: &[Token], at: usize, phrase: &[String]) -> bool {
    tokens.get(at..at + phrase.len()).is_some_and(|tokens| {
        tokens.iter().zip(phrase).all(|(token, word)| !token.is_quoted && token.word == *word)
    })
}

/// The words of a phrase.
pub(crate) fn split(phrase: &str) -> Phrase {
    phrase.split_whitespace().map(str::to_owned).collect()
}

/// "labelled" of "labeled"; `None` for other words.
fn british(phrase: &[String]) -> Option<Phrase> {
    let first = phrase.first()?;
    let stem = ["ed", "ing"].iter().find_map(|ending| Some((first.strip_suffix(ending)?, *ending)));
    let (stem, ending) = stem.filter(|(stem, _)| stem.ends_with("el"))?;
    let mut phrase = phrase.to_vec();
    phrase[0] = format!("{stem}l{ending}");
    Some(phrase)
}

/// A verb in a form; the first word of several is inflected.
fn inflected(base: &str, form: Form, irregular: &BTreeMap<String, [String; 2]>) -> Phrase {
    let mut words = split(base);
    let first = words[0].clone();
    let stem = first.strip_suffix('e').filter(|_| !first.ends_with("ee") && !first.ends_with("ye"));
    let doubled = || {
        let letters: Vec<char> = first.chars().collect();
        let is_vowel = |c: char| "aeiou".contains(c);
        let short = matches!(letters[..], [.., a, b, c]
            if !is_vowel(a) && is_vowel(b) && !is_vowel(c) && !"wxy".contains(c) && letters.len() <= 4);
        if short { format!("{first}{}", &first[first.len() - 1..]) } else { first.clone() }
    };
    let regular_done = || match () {
        () if first.ends_with('e') => format!("{first}d"),
        () if first.ends_with('y') && !first.ends_with("ay") && !first.ends_with("oy") => {
            format!("{}ied", &first[..first.len() - 1])
        }
        () => format!("{}ed", doubled()),
    };
    words[0] = match form {
        Form::Base => first.clone(),
        Form::Ing => irregular.get(&first).map_or_else(
            || stem.map_or_else(|| format!("{}ing", doubled()), |stem| format!("{stem}ing")),
            |[ing, _]| ing.clone(),
        ),
        Form::Done => irregular.get(&first).map_or_else(regular_done, |[_, done]| done.clone()),
        Form::Third => match () {
            () if ["s", "sh", "ch", "x", "z", "o"].iter().any(|ending| first.ends_with(ending)) => {
                format!("{first}es")
            }
            () if first.ends_with('y') && !first.ends_with("ay") && !first.ends_with("oy") => {
                format!("{}ies", &first[..first.len() - 1])
            }
            () => format!("{first}s"),
        },
    };
    words
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn verbs_are_inflected() {
        let irregular = BTreeMap::from([("put".to_owned(), ["putting".to_owned(), "put".to_owned()])]);
        let form = |base, form| inflected(base, form, &irregular).join(" ");
        for (base, ing, done, third) in [
            ("put down", "putting down", "put down", "puts down"),
            ("move", "moving", "moved", "moves"),
            ("drop", "dropping", "dropped", "drops"),
            ("carry", "carrying", "carried", "carries"),
            ("push", "pushing", "pushed", "pushes"),
            ("rotate", "rotating", "rotated", "rotates"),
            ("stack", "stacking", "stacked", "stacks"),
        ] {
            assert_eq!(
                [form(base, Form::Ing), form(base, Form::Done), form(base, Form::Third)],
                [ing, done, third]
            );
        }
    }

    #[test]
    fn every_phrase_is_found_where_it_stands() {
        let tokens = crate::tokens::tokens("could you please put it to the left of that");
        assert_eq!(lexicon().lengths("opening", &tokens, 0), [2, 3]);
        assert_eq!(lexicon().verb_lengths("put", Form::Base, &tokens, 3), [1]);
        assert!(lexicon().lengths("left_of", &tokens, 5).contains(&4));
    }
}
