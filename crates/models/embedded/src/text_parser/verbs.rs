//! Verbs of instructions and requests (`config/catalog/verbs.toml`).

use std::collections::{BTreeMap, BTreeSet};
use std::sync::LazyLock;

use serde::Deserialize;

use super::tokens::{Token, match_phrase, word};

/// Effect of a verb on its objects.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(super) enum Frame {
    Place,
    Take,
    Lift,
    Hand,
    Stack,
    Swap,
    Push,
    Open,
    Close,
    Pour,
    Fill,
    Rotate,
    Flip,
    Press,
    Upright,
    Topple,
    Separate,
    Use,
    UseTool,
    Hang,
    Cover,
    Other,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct VerbFile {
    verb: Vec<VerbGroup>,
    /// Passive participles.
    participle: Vec<VerbGroup>,
    noun: NounVerbs,
    vessel: Vec<Vessel>,
    scene: SceneVerbs,
    request: Requests,
}

/// Vessel from which substances are poured if the text names none.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Vessel {
    pub noun: String,
    pub holds: Vec<String>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct VerbGroup {
    frame: Frame,
    forms: Vec<String>,
}

/// Verbs that may be adjectives or nouns before another noun.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct NounVerbs {
    verbs: BTreeSet<String>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct SceneVerbs {
    verbs: BTreeSet<String>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Requests {
    openers: Vec<String>,
    desires: Vec<String>,
}

/// The verbs by form.
pub(super) struct Verbs {
    /// Frame of each phrase whose first word is the base form or an inflected form.
    phrases: BTreeMap<String, Frame>,
    /// First words of the phrases.
    forms: BTreeSet<String>,
    /// First words of the phrases, in their base form.
    bases: BTreeSet<String>,
    participles: BTreeMap<String, Frame>,
    modifiers: BTreeSet<String>,
    scene: BTreeSet<String>,
    openers: BTreeMap<String, Vec<String>>,
    desires: Vec<String>,
    vessels: Vec<Vessel>,
}

static VERBS: LazyLock<Verbs> = LazyLock::new(|| {
    let file: VerbFile = toml::from_str(include_str!("../../../../../config/catalog/verbs.toml"))
        .expect("the built-in verbs parse (a test loads them)");
    let mut verbs = Verbs {
        phrases: BTreeMap::new(),
        forms: BTreeSet::new(),
        bases: BTreeSet::new(),
        participles: BTreeMap::new(),
        modifiers: file.noun.verbs,
        scene: file.scene.verbs,
        openers: BTreeMap::new(),
        desires: file.request.desires,
        vessels: file.vessel,
    };
    for group in file.participle {
        verbs.participles.extend(group.forms.into_iter().map(|form| (form, group.frame)));
    }
    for group in file.verb {
        for phrase in group.forms {
            let (base, rest) =
                phrase.split_once(' ').map_or((phrase.as_str(), ""), |(base, rest)| (base, rest));
            verbs.bases.insert(base.to_owned());
            for form in inflected(base) {
                let phrase = format!("{form} {rest}").trim_end().to_owned();
                verbs.phrases.entry(phrase).or_insert(group.frame);
                verbs.forms.insert(form);
            }
        }
    }
    for opener in file.request.openers {
        let first = opener.split(' ').next().unwrap_or_default().to_owned();
        verbs.openers.entry(first).or_default().push(opener);
    }
    verbs
});

pub(super) fn verbs() -> &'static Verbs {
    &VERBS
}

/// The base form, the third person and the participle in "ing".
fn inflected(base: &str) -> [String; 3] {
    let consonant = |c: char| !"aeiouwxy".contains(c);
    let letters: Vec<char> = base.chars().collect();
    let doubles = matches!(letters[..], [.., a, b, c] if consonant(a) && !consonant(b) && consonant(c))
        && letters.len() <= 4;
    let third = match base {
        _ if ["s", "x", "ch", "sh", "z"].iter().any(|ending| base.ends_with(ending)) => format!("{base}es"),
        _ if base.ends_with('y') && !["ay", "ey", "oy"].iter().any(|e| base.ends_with(e)) => {
            format!("{}ies", &base[..base.len() - 1])
        }
        "go" | "do" => format!("{base}es"),
        _ => format!("{base}s"),
    };
    let participle = match base.strip_suffix('e') {
        Some(stem) if !base.ends_with("ee") => format!("{stem}ing"),
        _ if doubles => format!("{base}{}ing", letters[letters.len() - 1]),
        _ => format!("{base}ing"),
    };
    [base.to_owned(), third, participle]
}

impl Verbs {
    /// Whether the word is a form of a verb.
    pub fn is_form(&self, word: &str) -> bool {
        self.forms.contains(word)
    }

    /// Whether the word is a verb in its base form.
    pub fn is_base(&self, word: &str) -> bool {
        self.bases.contains(word)
    }

    /// The frame of a passive participle ("moved"), or of a state that a verb leads to ("shut").
    pub fn participle(&self, word: &str) -> Option<Frame> {
        self.participles.get(word).copied()
    }

    /// Whether the verb may be an adjective or a noun before another noun ("an open box").
    pub fn may_modify(&self, word: &str) -> bool {
        self.modifiers.contains(word)
    }

    /// Whether the word asks for a scene ("create").
    pub fn asks_for_scene(&self, word: &str) -> bool {
        self.scene.contains(word)
    }

    /// The frame of the longest verb phrase at `at`, and its number of words. A particle after the object ("pick the
    /// mug up") is not part of it.
    pub fn at(&self, tokens: &[Token], at: usize) -> Option<(Frame, usize)> {
        let mut phrase = word(tokens, at)?.to_owned();
        if !self.forms.contains(&phrase) {
            return None;
        }
        let mut best = self.phrases.get(&phrase).map(|frame| (*frame, 1));
        for length in 2..=3 {
            let Some(next) = word(tokens, at + length - 1) else { break };
            phrase = format!("{phrase} {next}");
            if let Some(frame) = self.phrases.get(&phrase) {
                best = Some((*frame, length));
            }
        }
        best
    }

    /// The frame of a verb with a particle that follows its object ("turn ... over").
    pub fn with_particle(&self, verb: &str, particle: &str) -> Option<Frame> {
        self.phrases.get(&format!("{verb} {particle}")).copied()
    }

    /// Number of tokens of the longest phrase at `at` that introduces an instruction ("can you").
    pub fn opener_at(&self, tokens: &[Token], at: usize) -> Option<usize> {
        let openers = self.openers.get(word(tokens, at)?)?;
        openers.iter().filter_map(|opener| match_phrase(tokens, at, opener)).max()
    }

    /// Number of tokens of the longest phrase at `at` after which an object and its end state follow ("i want").
    pub fn desire_at(&self, tokens: &[Token], at: usize) -> Option<usize> {
        self.desires.iter().filter_map(|desire| match_phrase(tokens, at, desire)).max()
    }

    /// The noun of what a substance is poured from.
    pub fn vessel_of(&self, substance: &str) -> Option<&str> {
        let holds = |vessel: &&Vessel| vessel.holds.iter().any(|held| held == substance);
        self.vessels.iter().find(holds).map(|vessel| vessel.noun.as_str())
    }
}

#[cfg(test)]
mod tests {
    use super::super::tokens::tokenize;
    use super::*;

    #[test]
    fn the_longest_verb_phrase_has_the_frame() {
        for (text, expected) in [
            ("put the mug", Some((Frame::Place, 1))),
            ("picks up the mug", Some((Frame::Lift, 2))),
            ("turn over the cup", Some((Frame::Flip, 2))),
            ("turn on the lamp", Some((Frame::Press, 2))),
            ("stacking blocks", Some((Frame::Stack, 1))),
            ("putting it down", Some((Frame::Place, 1))),
            ("mug", None),
        ] {
            assert_eq!(verbs().at(&tokenize(text), 0), expected, "{text}");
        }
        assert_eq!(verbs().opener_at(&tokenize("could you please put"), 0), Some(2));
    }
}
