//! Prepositional phrases of instructions: sources, destinations and tools.

use std::ops::Range;

use super::{Parser, Referent};
use crate::text_parser::measures::read_length;
use crate::text_parser::phrase::{Determiner, Head, noun_phrase};
use crate::text_parser::phrases::phrases;
use crate::text_parser::prepositions::{Preposition, place_at, preposition_at};
use crate::text_parser::tokens::{Token, match_phrase};
use crate::text_parser::verbs::{Frame, verbs};
use scene::RelationKind;

use super::action::{Action, Part, Path, PathKind};

/// Prepositions of sources; longer ones first.
const SOURCES: &[(&str, Option<RelationKind>)] = &[
    ("out from under", None),
    ("from under", Some(RelationKind::NextTo)),
    ("from underneath", Some(RelationKind::NextTo)),
    ("from beneath", Some(RelationKind::NextTo)),
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

const POSES: &[(&str, &str)] = &[
    ("onto its side", "lying_on_side"),
    ("onto their sides", "lying_on_side"),
    ("on to its side", "lying_on_side"),
    ("over onto its side", "lying_on_side"),
    ("over on its side", "lying_on_side"),
    ("down on its side", "lying_on_side"),
    ("to its side", "lying_on_side"),
    ("down flat", "lying_on_side"),
    ("on its head", "upside_down"),
    ("onto its head", "upside_down"),
    ("on its rim", "upside_down"),
    ("on its base", "upright"),
    ("onto its base", "upright"),
    ("on its feet", "upright"),
    ("back on its feet", "upright"),
    ("back on its base", "upright"),
    ("back upright", "upright"),
    ("standing up", "upright"),
    ("vertically", "upright"),
    ("to an upright position", "upright"),
    ("in an upright position", "upright"),
    ("into an upright position", "upright"),
    ("to upright", "upright"),
];

impl Parser<'_, '_> {
    pub(super) fn is_source(&self, at: usize) -> bool {
        SOURCES.iter().any(|(phrase, _)| match_phrase(self.tokens, at, phrase).is_some())
    }

    pub(super) fn is_directed(&self, at: usize) -> bool {
        phrases().path.directed.longest_at(self.tokens, at).is_some()
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
        // "from the center to the front": the words before "to".
        let stop = (p + 1..self.tokens.len())
            .find(|&at| matches!(self.word_at(at), Some("to" | "into" | "onto" | "and")))
            .unwrap_or(self.tokens.len());
        if let Some((places, length)) = place_at(&self.tokens[..stop], p, &Self::is_table_word)
            && self.word_at(p) == Some("from")
        {
            self.at = p + length;
            action.sources.push(self.path(PathKind::Places(places), start..self.at));
            return true;
        }
        p += length;
        let Some((phrase, end)) = self.object_at(p, action.frame) else {
            // "turn off", "take off".
            return false;
        };
        self.at = end;
        let tokens = start..p;
        let is_unknown = matches!(phrase.head, Head::Unknown(_));
        let is_inside = self.names_inside(&phrase);
        let path = match self.refer_target(phrase, action, None) {
            Referent::Mentions(targets) => {
                let kind = if is_inside { kind.or(Some(RelationKind::In)) } else { kind };
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
        let Some((state, length)) = self.state_after_verb().or_else(|| self.state_at(self.at)) else {
            return false;
        };
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

    /// A pose in the words that follow a verb of motion: "onto its side", "back on its feet".
    fn state_after_verb(&self) -> Option<(String, usize)> {
        POSES
            .iter()
            .filter_map(|(phrase, state)| {
                Some(((*state).to_owned(), match_phrase(self.tokens, self.at, phrase)?))
            })
            .max_by_key(|(_, length)| *length)
    }

    pub(super) fn object_after(&self, length: usize) -> bool {
        noun_phrase(self.lexicon, self.tokens, self.at + length).is_some()
    }

    /// "with the sponge", "using a knife".
    pub(super) fn tool(&mut self, action: &mut Action) -> bool {
        let start = self.at;
        let uses = self.word(0) == Some("using");
        let takes_tool = matches!(
            action.frame,
            Frame::Use
                | Frame::Cover
                | Frame::Fill
                | Frame::Swap
                | Frame::Stack
                | Frame::Push
                | Frame::Press
                | Frame::Lift
                | Frame::Take
                | Frame::Rotate
                | Frame::Flip
                | Frame::Topple
                | Frame::Pour
                | Frame::Close
                | Frame::Other
        ) || self.loads(action);
        let with = self.word(0) == Some("with") && takes_tool;
        let swap = action.frame == Frame::Swap && self.word(0) == Some("for");
        if !(uses || with || swap) {
            return false;
        }
        if action.frame == Frame::Fill {
            self.at = start + 1;
            if self.substance(action) {
                self.parsed.account.used(start..start + 1);
                return true;
            }
            self.at = start;
        }
        // "align the ruler with the edge of the book".
        let edges =
            ["the edge of", "the side of", "the end of", "the rim of", "the front of", "the edges of"];
        let object = start + 1 + self.longest(&edges, start + 1);
        let Some((phrase, end)) = noun_phrase(self.lexicon, self.tokens, object) else { return false };
        self.parsed.account.used(start..object);
        self.at = end;
        if let Referent::Mentions(list) = self.refer_target(phrase, action, None) {
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
        if let Some(kind) = self.side_of_it() {
            let objects = Self::mentions(&action.objects);
            let Some(target) = self.target_of_its(&objects) else { return true };
            let path = self.path(PathKind::Relation(kind), start..self.at);
            action.paths.push(Path { targets: vec![target], ..path });
            return true;
        }
        let mut p = start;
        if let Some(length) =
            ["back", "down", "over", "up", "all the way"].iter().find_map(|w| match_phrase(self.tokens, p, w))
            && (preposition_at(self.tokens, p + length).is_some() || self.is_directed(p + length))
        {
            p += length;
        }
        let directed = self.is_directed(p);
        let ends_in_to = |length: &usize| {
            matches!(self.word_at(p + length - 1), Some("to" | "into" | "onto" | "toward" | "towards"))
        };
        let plain = phrases().path.directed.longest_at(self.tokens, p).filter(ends_in_to);
        let (preposition, length) = match self.preposition_of(p, action.frame) {
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
            || matches!(self.word_at(p), Some("and" | "then" | "again"))
            || self.step_number(p).is_some();
        // "turn the lamp on".
        let verb = self.word_at(action.verb.start).unwrap_or_default();
        let particle = self.word_at(start).unwrap_or_default();
        if ends && p == start + 1 && verbs().with_particle(verb, particle).is_some() {
            return false;
        }
        if let Some(preposition) = preposition.filter(|preposition| ends && preposition.kind.is_support()) {
            // "put the mug in": the target is what the text was about.
            let objects: Vec<usize> = action.objects.iter().map(|part| part.mention).collect();
            let target = self.earlier_target(&objects, Some(preposition.kind));
            let Some(target) = target.filter(|_| !objects.is_empty()) else { return false };
            self.at = p;
            let kind = PathKind::Relation(preposition.kind);
            action.paths.push(Path { targets: vec![target], directed: true, ..self.path(kind, start..p) });
            return true;
        }
        let own = self.own_at(p);
        let Some((mut phrase, end)) = self.object_at(own.unwrap_or(p), action.frame) else {
            let person = p + usize::from(matches!(self.word_at(p), Some("the" | "a")));
            if matches!(
                self.word_at(person),
                Some("person" | "user" | "human" | "robot" | "operator" | "guest")
            ) {
                self.at = person + 1;
                // "pull the cube towards the robot" moves it; "give the cube to the robot" does not.
                let is_moved = action.frame == Frame::Push
                    || matches!(self.word_at(start), Some("toward" | "towards" | "closer" | "near"));
                let kind =
                    if is_moved { PathKind::Places(vec![RelationKind::AtFront]) } else { PathKind::Person };
                action.paths.push(self.path(kind, start..person + 1));
                return true;
            }
            return false;
        };
        self.at = end;
        self.bare_is_definite(&mut phrase);
        if own.is_some() {
            self.parsed.account.used(p..phrase.tokens.start);
            phrase.determiner = Determiner::New;
        }
        // "release the ball above the bowl".
        let falls = verb.starts_with("drop") || verb.starts_with("releas");
        let preposition =
            preposition.filter(|_| !(falls && matches!(self.word_at(p - 1), Some("above" | "over"))));
        let nearer = preposition.is_none() && matches!(self.word_at(p - 1), Some("toward" | "towards"));
        let kind = match preposition {
            Some(preposition) => PathKind::Relation(preposition.kind),
            None if nearer => PathKind::Relation(RelationKind::NextTo),
            None => PathKind::At,
        };
        let support = preposition.map(|preposition| preposition.kind);
        let plural = phrase.plural;
        let each = phrase.determiner == Determiner::Each;
        let two = preposition.is_some_and(|preposition| preposition.two_targets);
        let inverse = preposition.is_some_and(|preposition: Preposition| preposition.inverse);
        let is_single =
            phrase.determiner == Determiner::New && phrase.count.is_none_or(|count| count == [1, 1]);
        let mentions = self.parsed.mentions.len();
        let referent = match self.other_of_pair(&phrase, action) {
            Some(other) => Referent::Mentions(vec![other]),
            None => self.refer_target(phrase, action, support),
        };
        match referent {
            Referent::Mentions(targets) => {
                self.one_for_each(&targets, mentions, action, is_single);
                if each {
                    self.for_each_target(&targets, action);
                }
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
                    // "the pot which is in the sink" as a target.
                    let target = action.paths.last().filter(|_| action.relative);
                    let second = action.seconds.last().map(|part| part.mention);
                    let objects: Vec<usize> = target
                        .and_then(|path| path.targets.last().copied())
                        .or(second)
                        .or(action.objects.last().map(|part| part.mention))
                        .into_iter()
                        .collect();
                    action.relative = false;
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
}
