//! Prepositional phrases of instructions: sources, destinations and tools.

use std::ops::Range;

use super::{Parser, PendingRelation, Referent};
use crate::text_parser::measures::read_length;
use crate::text_parser::phrase::{Head, NounPhrase, noun_phrase};
use crate::text_parser::prepositions::{Preposition, place_at, preposition_at};
use crate::text_parser::tokens::{Token, match_phrase};
use crate::text_parser::verbs::Frame;
use scene::RelationKind;

use super::action::{Action, Part, Path, PathKind};

/// Prepositions of sources; longer ones first.
const SOURCES: &[(&str, Option<RelationKind>)] = &[
    ("out from under", None),
    ("from inside of", Some(RelationKind::In)),
    ("from inside", Some(RelationKind::In)),
    ("from within", Some(RelationKind::In)),
    ("from the inside of", Some(RelationKind::In)),
    ("from on top of", Some(RelationKind::On)),
    ("from the top of", Some(RelationKind::On)),
    ("from off", Some(RelationKind::On)),
    ("from behind", Some(RelationKind::Behind)),
    ("from in front of", Some(RelationKind::InFrontOf)),
    ("from next to", Some(RelationKind::NextTo)),
    ("from beside", Some(RelationKind::NextTo)),
    ("out of", Some(RelationKind::In)),
    ("off of", Some(RelationKind::On)),
    ("off", Some(RelationKind::On)),
    ("from", None),
];

/// Prepositions of destinations that are not relations of a description.
const DIRECTED: &[&str] = &[
    "into",
    "onto",
    "to",
    "on to",
    "in to",
    "toward",
    "towards",
    "over to",
    "back to",
    "back into",
    "back onto",
    "back on",
    "back in",
    "all the way to",
    "over into",
    "over onto",
    "up to",
    "down on",
    "down in",
    "down onto",
    "down into",
    "up onto",
    "on top of",
    "up on",
];

impl Parser<'_, '_> {
    pub(super) fn is_source(&self, at: usize) -> bool {
        SOURCES.iter().any(|(phrase, _)| match_phrase(self.tokens, at, phrase).is_some())
    }

    pub(super) fn is_directed(&self, at: usize) -> bool {
        DIRECTED.iter().any(|phrase| match_phrase(self.tokens, at, phrase).is_some())
    }

    /// "from the plate", "out of the mug", "from the left side".
    pub(super) fn source(&mut self, action: &mut Action) -> bool {
        let start = self.at;
        let mut p = start + usize::from(self.word(0) == Some("away") && self.word(1) == Some("from"));
        let away = p > start;
        let Some((kind, length)) = SOURCES
            .iter()
            .filter_map(|(phrase, kind)| Some((*kind, match_phrase(self.tokens, p, phrase)?)))
            .max_by_key(|(_, length)| *length)
        else {
            return false;
        };
        if let Some((places, length)) = place_at(self.tokens, p, &Self::is_table_word)
            && self.word_at(p) == Some("from")
        {
            self.at = p + length;
            action.sources.push(self.path(PathKind::Places(places), start..self.at));
            return true;
        }
        p += length;
        let Some((phrase, end)) = noun_phrase(self.lexicon, self.tokens, p) else {
            // "turn off", "take off".
            return false;
        };
        self.at = end;
        let tokens = start..p;
        let is_unknown = matches!(phrase.head, Head::Unknown(_));
        let path = match self.refer_target(phrase, action) {
            Referent::Mentions(targets) => {
                let kind = if away { PathKind::Away } else { kind.map_or(PathKind::At, PathKind::Relation) };
                Path { targets, ..self.path(kind, tokens) }
            }
            Referent::Table => self.path(PathKind::Table, tokens),
            Referent::Nothing => {
                action.unknown |= is_unknown;
                return true;
            }
        };
        if away && action.frame != Frame::Take {
            action.paths.push(path);
        } else {
            action.sources.push(path);
        }
        true
    }

    pub(super) fn path(&self, kind: PathKind, tokens: Range<usize>) -> Path {
        Path {
            kind,
            targets: Vec::new(),
            second: None,
            directed: false,
            inverse: false,
            distance_m: None,
            tokens,
        }
    }

    /// "upright", "upside down", "on its side".
    pub(super) fn state_path(&mut self, action: &mut Action) -> bool {
        let Some((state, length)) = self.state_at(self.at) else { return false };
        if super::states::pose_of(&state).is_none()
            || (action.objects.is_empty() && self.object_after(length))
        {
            return false;
        }
        let tokens = self.at..self.at + length;
        self.at = tokens.end;
        action.paths.push(self.path(PathKind::State(state), tokens));
        true
    }

    pub(super) fn object_after(&self, length: usize) -> bool {
        noun_phrase(self.lexicon, self.tokens, self.at + length).is_some()
    }

    /// "to the left side of the table", "in the center", "to the left".
    pub(super) fn place_path(&mut self, action: &mut Action) -> bool {
        let start = self.at;
        let direction = [
            "to the left",
            "to the right",
            "to the front",
            "to the back",
            "leftward",
            "rightward",
            "leftwards",
            "rightwards",
            "forward",
            "forwards",
            "backward",
            "backwards",
            "left",
            "right",
        ]
        .iter()
        .filter_map(|phrase| match_phrase(self.tokens, start, phrase))
        .max();
        let (places, length) = match place_at(self.tokens, start, &Self::is_table_word) {
            Some(place) => place,
            None => {
                let Some(length) = direction else { return false };
                if matches!(self.word(length), Some("of" | "side" | "edge" | "corner" | "half" | "end")) {
                    return false;
                }
                let kind = match self.word(length - 1) {
                    Some("left" | "leftward" | "leftwards") => RelationKind::AtLeft,
                    Some("right" | "rightward" | "rightwards") => RelationKind::AtRight,
                    Some("back" | "forward" | "forwards") => RelationKind::AtBack,
                    _ => RelationKind::AtFront,
                };
                (vec![kind], length)
            }
        };
        self.at = start + length;
        let directed = matches!(self.word_at(start), Some("to" | "toward" | "towards" | "into" | "onto"));
        action.paths.push(Path { directed, ..self.path(PathKind::Places(places), start..start + length) });
        true
    }

    /// "with the sponge", "using a knife".
    pub(super) fn tool(&mut self, action: &mut Action) -> bool {
        let start = self.at;
        let uses = self.word(0) == Some("using");
        let takes_tool = matches!(
            action.frame,
            Frame::Use | Frame::Cover | Frame::Fill | Frame::Swap | Frame::Stack | Frame::Push | Frame::Press
        );
        let with = self.word(0) == Some("with") && takes_tool;
        let swap = action.frame == Frame::Swap && self.word(0) == Some("for");
        if !(uses || with || swap) {
            return false;
        }
        let Some((phrase, end)) = noun_phrase(self.lexicon, self.tokens, start + 1) else { return false };
        self.parsed.account.used(start..start + 1);
        self.at = end;
        if action.frame == Frame::Fill && self.is_substance(&phrase) {
            self.parsed.account.used(phrase.tokens);
            action.substance = true;
            return true;
        }
        if let Referent::Mentions(list) = self.refer_target(phrase, action) {
            if action.frame == Frame::Swap {
                action.seconds.extend(list.into_iter().map(|mention| Part { mention, take: None }));
            } else {
                action.tools.extend(list);
            }
        } else {
            action.unknown = true;
        }
        true
    }

    /// "10 cm to the left of the plate", "5 cm to the left".
    pub(super) fn distance_path(&mut self, action: &mut Action) -> bool {
        let Some((meters, length)) = read_length(self.lexicon.vocabulary, self.tokens, self.at) else {
            return false;
        };
        let start = self.at;
        self.at += length;
        let paths = action.paths.len();
        if self.relation_path(action) || self.source(action) || self.place_path(action) {
            if let Some(path) = action.paths.get_mut(paths) {
                path.distance_m = Some(meters);
                path.tokens.start = start;
            }
            return true;
        }
        self.not_expressible(start..start + length);
        true
    }

    /// "in the bowl", "to the left of the plate", "to me".
    pub(super) fn relation_path(&mut self, action: &mut Action) -> bool {
        let start = self.at;
        let mut p = start;
        if let Some(length) =
            ["back", "down", "over", "up", "all the way"].iter().find_map(|w| match_phrase(self.tokens, p, w))
            && (preposition_at(self.tokens, p + length).is_some() || self.is_directed(p + length))
        {
            p += length;
        }
        let directed = self.is_directed(p);
        let plain = DIRECTED
            .iter()
            .filter(|phrase| phrase.ends_with("to") || phrase.starts_with("toward"))
            .filter_map(|phrase| match_phrase(self.tokens, p, phrase))
            .max();
        let (preposition, length) = match preposition_at(self.tokens, p) {
            Some((preposition, length)) => (Some(preposition), length),
            None => match plain {
                Some(length) => (None, length),
                None => return false,
            },
        };
        p += length;
        if matches!(self.word_at(p), Some("me" | "us" | "him" | "her" | "you" | "yourself")) {
            self.at = p + 1;
            let nearer = matches!(self.word_at(start), Some("toward" | "towards"));
            let kind = if nearer { PathKind::Places(vec![RelationKind::AtFront]) } else { PathKind::Person };
            action.paths.push(Path { directed: true, ..self.path(kind, start..p + 1) });
            return true;
        }
        let ends = matches!(self.tokens.get(p), None | Some(Token::Pause | Token::End))
            || matches!(self.word_at(p), Some("and" | "then" | "again"));
        if let Some(preposition) = preposition.filter(|preposition| ends && preposition.kind.is_support()) {
            // "put the mug in": the target is what the text was about.
            let objects: Vec<usize> = action.objects.iter().map(|part| part.mention).collect();
            let target = (0..self.parsed.mentions.len()).rev().find(|m| !objects.contains(m));
            let Some(target) = target.filter(|_| !objects.is_empty()) else { return false };
            self.at = p;
            let kind = PathKind::Relation(preposition.kind);
            action.paths.push(Path { targets: vec![target], directed: true, ..self.path(kind, start..p) });
            return true;
        }
        let Some((phrase, end)) = self.whole_of_part(p).or_else(|| noun_phrase(self.lexicon, self.tokens, p))
        else {
            let person = p + usize::from(matches!(self.word_at(p), Some("the" | "a")));
            if matches!(
                self.word_at(person),
                Some("person" | "user" | "human" | "robot" | "operator" | "guest")
            ) {
                self.at = person + 1;
                action.paths.push(self.path(PathKind::Person, start..person + 1));
                return true;
            }
            return false;
        };
        self.at = end;
        let kind = preposition.map_or(PathKind::At, |preposition| PathKind::Relation(preposition.kind));
        let plural = phrase.plural;
        let two = preposition.is_some_and(|preposition| preposition.two_targets);
        let inverse = preposition.is_some_and(|preposition: Preposition| preposition.inverse);
        match self.refer_target(phrase, action) {
            Referent::Mentions(targets) => {
                let mut path = Path { targets, directed, inverse, ..self.path(kind, start..p) };
                if two {
                    self.second_target(&mut path, plural);
                }
                let describes = action.relative
                    || (!directed
                        && !action.objects.is_empty()
                        && matches!(
                            action.frame,
                            Frame::Swap
                                | Frame::Open
                                | Frame::Close
                                | Frame::Press
                                | Frame::Rotate
                                | Frame::Flip
                        ));
                if describes {
                    action.relative = false;
                    let objects: Vec<usize> =
                        action.objects.last().map(|part| part.mention).into_iter().collect();
                    self.start_relation(&objects, &path);
                } else {
                    action.paths.push(path);
                }
            }
            Referent::Table => {
                let path = self.path(PathKind::Table, start..end);
                action.paths.push(Path { directed, ..path });
            }
            Referent::Nothing => action.unknown = true,
        }
        true
    }

    /// The referent of a target; a pronoun is not the object itself.
    pub(super) fn refer_target(&mut self, phrase: NounPhrase, action: &Action) -> Referent {
        if phrase.head != Head::It {
            return self.refer(phrase, true);
        }
        self.parsed.account.used(phrase.tokens.clone());
        let objects: Vec<usize> = action.objects.iter().map(|part| part.mention).collect();
        let earlier = self
            .salient
            .filter(|it| !objects.contains(it))
            .or_else(|| (0..self.parsed.mentions.len()).rev().find(|m| !objects.contains(m)));
        earlier.map_or(Referent::Nothing, |it| Referent::Mentions(vec![it]))
    }

    pub(super) fn second_target(&mut self, path: &mut Path, plural: bool) {
        if self.word(0) == Some("and")
            && let Some((phrase, end)) = noun_phrase(self.lexicon, self.tokens, self.at + 1)
        {
            self.parsed.account.used(self.at..self.at + 1);
            self.at = end;
            if let Referent::Mentions(more) = self.refer(phrase, true) {
                path.second = more.first().copied();
            }
        } else if let [first, second, ..] = path.targets[..] {
            (path.targets, path.second) = (vec![first], Some(second));
        } else if plural {
            path.second = path.targets.first().copied();
        }
    }

    /// Relates mentions by a path that describes the start state.
    pub(super) fn start_relation(&mut self, objects: &[usize], path: &Path) {
        for &object in objects {
            match &path.kind {
                PathKind::Relation(kind) => {
                    for &target in &path.targets {
                        let (kind, inverse, second) = (*kind, path.inverse, path.second);
                        let (targets, distance_m) = (vec![target], path.distance_m);
                        let tokens = path.tokens.clone();
                        let relation = PendingRelation { kind, inverse, targets, second, distance_m, tokens };
                        self.relate(object, &relation, target);
                    }
                }
                PathKind::At => {
                    for &target in &path.targets {
                        if target != object {
                            self.parsed.account.used(path.tokens.clone());
                            self.parsed.links.push(super::Link::new(object, super::LinkKind::At, target));
                        }
                    }
                }
                PathKind::Places(places) => {
                    for &kind in places {
                        self.set_place(object, super::Place { kind, distance_m: None }, path.tokens.clone());
                    }
                }
                PathKind::State(state) => self.set_states(&[object], state, path.tokens.clone()),
                _ => self.parsed.account.used(path.tokens.clone()),
            }
        }
    }
}
