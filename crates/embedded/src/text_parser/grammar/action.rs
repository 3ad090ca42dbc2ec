//! The parts of an instruction: objects, sources, destinations and tools.

use std::ops::Range;

use super::{Parser, PendingRelation, Referent};
use crate::text_parser::measures::read_length;
use crate::text_parser::phrase::{Determiner, Head, NounPhrase, noun_phrase};
use crate::text_parser::prepositions::{Preposition, place_at, preposition_at};
use crate::text_parser::tokens::{Token, match_phrase};
use crate::text_parser::verbs::{Frame, verbs};
use scene::RelationKind;

/// A mention, and how many of its objects.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Part {
    pub mention: usize,
    pub take: Option<u32>,
}

/// A prepositional phrase of an instruction.
#[derive(Clone, Debug)]
pub(super) struct Path {
    pub kind: PathKind,
    pub targets: Vec<usize>,
    pub second: Option<usize>,
    /// "into", "onto", "to": always a destination.
    pub directed: bool,
    pub inverse: bool,
    pub distance_m: Option<f64>,
    pub tokens: Range<usize>,
}

#[derive(Clone, Debug, PartialEq)]
pub(super) enum PathKind {
    Relation(RelationKind),
    /// "to the plate".
    At,
    Places(Vec<RelationKind>),
    Table,
    /// "to me".
    Person,
    /// "away from".
    Away,
    /// "upright", "upside down".
    State(String),
}

/// An instruction in parts.
#[derive(Clone, Debug)]
pub(super) struct Action {
    pub frame: Frame,
    pub verb: Range<usize>,
    pub objects: Vec<Part>,
    pub seconds: Vec<Part>,
    pub tools: Vec<usize>,
    pub sources: Vec<Path>,
    pub paths: Vec<Path>,
    /// Whether a substance without an object is moved ("pour the water").
    pub substance: bool,
    /// Whether the text names an object that is not known.
    pub unknown: bool,
    /// Whether the next path belongs to a relative clause ("that is next to the kettle").
    pub relative: bool,
    /// Particles after the object.
    pub particles: Vec<Range<usize>>,
}

/// Whether the noun is a part that moves with its object or that is pressed.
fn is_part(word: &str) -> bool {
    matches!(
        word,
        "door"
            | "lid"
            | "drawer"
            | "button"
            | "handle"
            | "cap"
            | "switch"
            | "lever"
            | "cover"
            | "doors"
            | "drawers"
            | "knobs"
            | "knob"
    )
}

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
    /// Reads an instruction whose verb is at `at`, and states its goal.
    pub(super) fn act(&mut self, frame: Frame, at: usize, length: usize, subjects: Vec<usize>) {
        let verb = at..at + length;
        self.at = verb.end;
        let mut action = self.new_action(frame, verb.clone());
        if frame == Frame::Use {
            action.tools = subjects;
        } else if !subjects.is_empty() && length <= 2 && !self.object_follows() {
            action.objects = subjects.into_iter().map(|mention| Part { mention, take: None }).collect();
        }
        while self.at < self.tokens.len() {
            let before = self.at;
            if !self.part(&mut action) {
                break;
            }
            self.at = self.at.max(before + 1);
        }
        self.conclude(action);
    }

    fn new_action(&self, frame: Frame, verb: Range<usize>) -> Action {
        Action {
            frame,
            verb,
            objects: Vec::new(),
            seconds: Vec::new(),
            tools: Vec::new(),
            sources: Vec::new(),
            paths: Vec::new(),
            substance: false,
            unknown: false,
            relative: false,
            particles: Vec::new(),
        }
    }

    fn object_follows(&self) -> bool {
        noun_phrase(self.lexicon, self.tokens, self.at).is_some()
    }

    /// Reads one part of the instruction; `false` at its end.
    fn part(&mut self, action: &mut Action) -> bool {
        match &self.tokens[self.at] {
            Token::End => return false,
            Token::Pause => return self.after_pause(action),
            Token::Number(_) | Token::Word(_) => {}
        }
        if matches!(
            self.word(0),
            Some("and" | "then" | "or" | "but" | "while" | "before" | "after" | "so" | "without")
        ) {
            return self.after_conjunction(action);
        }
        if matches!(self.word(0), Some("that" | "which"))
            && matches!(self.word(1), Some("is" | "are" | "lies" | "stands" | "sits" | "was"))
            && !action.objects.is_empty()
        {
            self.parsed.account.used(self.at..self.at + 2);
            self.at += 2;
            action.relative = true;
            return true;
        }
        self.turn(action)
            || self.source(action)
            || self.state_path(action)
            || self.place_path(action)
            || self.tool(action)
            || self.distance_path(action)
            || self.relation_path(action)
            || self.particle(action)
            || self.object(action)
            || self.filler()
    }

    /// After a comma: the list of objects continues, or another prepositional phrase.
    fn after_pause(&mut self, action: &mut Action) -> bool {
        let next = self.at + 1;
        if matches!(self.word_at(next), Some("and" | "then")) {
            self.at = next;
            return self.after_conjunction(action);
        }
        let is_verb =
            verbs().at(self.tokens, next).is_some() || verbs().opener_at(self.tokens, next).is_some();
        let list = action.paths.is_empty() && action.sources.is_empty() && !action.objects.is_empty();
        let phrase = noun_phrase(self.lexicon, self.tokens, next);
        let continues =
            (list && phrase.is_some_and(|(phrase, _)| !phrase.negated) && !self.is_statement(next))
                || self.is_source(next)
                || self.is_directed(next);
        if is_verb || !continues {
            return false;
        }
        self.at = next;
        true
    }

    /// Whether a subject with a verb begins ("the mug is red").
    fn is_statement(&self, at: usize) -> bool {
        noun_phrase(self.lexicon, self.tokens, at).is_some_and(|(_, end)| {
            matches!(self.word_at(end), Some("is" | "are" | "has" | "should" | "must"))
        })
    }

    /// After "and": another object, another action with the same verb ("and the spoon in the mug"), or the end.
    fn after_conjunction(&mut self, action: &mut Action) -> bool {
        let next = self.at + 1;
        let conjunction = self.word(0);
        if conjunction != Some("and") && conjunction != Some("or") {
            return false;
        }
        if verbs().at(self.tokens, next).is_some_and(|(_, length)| self.phrase_or_end(next + length))
            || verbs().opener_at(self.tokens, next).is_some()
            || self.is_statement(next)
        {
            return false;
        }
        if action.objects.is_empty() {
            self.at = next;
            return true;
        }
        if self.is_directed(next) || self.is_source(next) {
            self.at = next;
            return true;
        }
        let Some((phrase, end)) = noun_phrase(self.lexicon, self.tokens, next) else { return false };
        if phrase.negated {
            return false;
        }
        self.parsed.account.used(self.at..next);
        if action.paths.is_empty() && action.sources.is_empty() {
            self.at = next;
            return true;
        }
        // "put the mug on the plate and the spoon in the bowl".
        let own_path = preposition_at(self.tokens, end).is_some()
            || self.is_directed(end)
            || place_at(self.tokens, end, &Self::is_table_word).is_some();
        if action.frame == Frame::Swap {
            self.at = next;
            return true;
        }
        if own_path {
            let (frame, verb) = (action.frame, action.verb.clone());
            let finished = std::mem::replace(action, self.new_action(frame, verb));
            self.conclude(finished);
            self.at = next;
            return true;
        }
        // "between the plate and the mug" is read with its preposition; otherwise another target.
        if let Some(path) = action.paths.last() {
            let path = path.clone();
            self.at = end;
            if let Referent::Mentions(more) = self.refer(phrase, true) {
                action.paths.push(Path { targets: more, ..path });
            }
            return true;
        }
        false
    }

    fn phrase_or_end(&self, at: usize) -> bool {
        noun_phrase(self.lexicon, self.tokens, at).is_some()
            || self.word_at(at).is_none()
            || matches!(
                self.word_at(at),
                Some("it" | "them" | "up" | "down" | "the" | "all" | "back" | "over")
            )
            || preposition_at(self.tokens, at).is_some()
    }

    fn is_source(&self, at: usize) -> bool {
        SOURCES.iter().any(|(phrase, _)| match_phrase(self.tokens, at, phrase).is_some())
    }

    fn is_directed(&self, at: usize) -> bool {
        DIRECTED.iter().any(|phrase| match_phrase(self.tokens, at, phrase).is_some())
    }

    /// "from the plate", "out of the mug", "from the left side".
    fn source(&mut self, action: &mut Action) -> bool {
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

    fn path(&self, kind: PathKind, tokens: Range<usize>) -> Path {
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
    fn state_path(&mut self, action: &mut Action) -> bool {
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

    fn object_after(&self, length: usize) -> bool {
        noun_phrase(self.lexicon, self.tokens, self.at + length).is_some()
    }

    /// "to the left side of the table", "in the center", "to the left".
    fn place_path(&mut self, action: &mut Action) -> bool {
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
    fn tool(&mut self, action: &mut Action) -> bool {
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
    fn distance_path(&mut self, action: &mut Action) -> bool {
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
    fn relation_path(&mut self, action: &mut Action) -> bool {
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
    fn refer_target(&mut self, phrase: NounPhrase, action: &Action) -> Referent {
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

    fn second_target(&mut self, path: &mut Path, plural: bool) {
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

    /// A particle after the object: "pick the mug up", "turn it over", "turn the lamp on".
    fn particle(&mut self, action: &mut Action) -> bool {
        let Some(word) = self.word(0) else { return false };
        if !matches!(
            word,
            "up" | "down"
                | "over"
                | "out"
                | "away"
                | "off"
                | "on"
                | "back"
                | "together"
                | "apart"
                | "around"
                | "open"
                | "closed"
                | "shut"
        ) {
            return false;
        }
        let verb = self.word_at(action.verb.start).unwrap_or_default().to_owned();
        if !action.objects.is_empty()
            && let Some(frame) = verbs().with_particle(&verb, word)
        {
            action.frame = frame;
        } else if matches!(word, "open") && !action.objects.is_empty() {
            action.frame = Frame::Open;
        } else if matches!(word, "closed" | "shut") && !action.objects.is_empty() {
            action.frame = Frame::Close;
        } else if matches!(word, "on") || action.objects.is_empty() && matches!(word, "open" | "closed") {
            return false;
        }
        action.particles.push(self.at..self.at + 1);
        self.parsed.account.used(self.at..self.at + 1);
        self.at += 1;
        true
    }

    /// A noun phrase: an object, or the second object of "swap A and B", "hand me the mug".
    fn object(&mut self, action: &mut Action) -> bool {
        if matches!(self.word(0), Some("me" | "us")) {
            self.parsed.account.used(self.at..self.at + 1);
            self.at += 1;
            return true;
        }
        // "the positions of the apple and the orange", "the contents of the cup".
        let of = [
            "the positions of",
            "the places of",
            "the position of",
            "the contents of",
            "the content of",
            "positions of",
        ]
        .iter()
        .find_map(|phrase| match_phrase(self.tokens, self.at, phrase));
        if let Some(length) = of {
            self.parsed.account.used(self.at..self.at + length);
            self.at += length;
        }
        let found = self.whole_of_part(self.at).or_else(|| noun_phrase(self.lexicon, self.tokens, self.at));
        let Some((phrase, end)) = found else { return of.is_some() };
        if phrase.negated {
            return false;
        }
        if matches!(action.frame, Frame::Pour | Frame::Fill)
            && self.is_substance(&phrase)
            && self.source_ahead(end)
        {
            self.parsed.account.used(phrase.tokens);
            self.at = end;
            action.substance = true;
            return true;
        }
        self.at = end;
        // Objects of an earlier sentence are meant by "one of the mugs" and "a mug" after "three mugs".
        let take = phrase.count.filter(|count| count[0] == count[1]).map(|count| count[0]);
        let before = self.parsed.mentions.len();
        let referent = match self.part_of_earlier(&phrase) {
            Some(mention) => {
                self.parsed.account.used(phrase.tokens.clone());
                self.parsed
                    .account
                    .claim(phrase.head_tokens.clone(), crate::text_parser::account::Claimed::Object(mention));
                Referent::Mentions(vec![mention])
            }
            None => self.refer(phrase, false),
        };
        match referent {
            Referent::Mentions(list) => {
                let take = take.filter(|_| list.iter().all(|&mention| mention < before));
                action.objects.extend(list.iter().map(|&mention| Part { mention, take }));
                if let [.., last] = list[..] {
                    self.salient = Some(last);
                    self.salient_list = action.objects.iter().map(|part| part.mention).collect();
                    if self.word(0) == Some("of") {
                        self.contents_of(last);
                    }
                }
            }
            Referent::Table => action.paths.push(self.path(PathKind::Table, end..end)),
            Referent::Nothing => action.unknown = true,
        }
        true
    }

    /// An earlier plural mention of which the phrase takes some.
    pub(super) fn part_of_earlier(&self, phrase: &NounPhrase) -> Option<usize> {
        let Head::Objects(meanings) = &phrase.head else { return None };
        let [low, high] = phrase.count?;
        if phrase.determiner != Determiner::New || low != high {
            return None;
        }
        let color = &phrase.attributes.color_words;
        self.parsed.mentions.iter().rposition(|mention| {
            mention.meanings.iter().any(|meaning| meanings.contains(meaning))
                && mention.count.is_some_and(|count| count[0] > low)
                && (color.is_empty() || *color == mention.attributes.color_words)
        })
    }

    /// Whether the phrase names a substance.
    fn is_substance(&self, phrase: &NounPhrase) -> bool {
        let words = &self.lexicon.vocabulary;
        let name = phrase.words.rsplit(' ').next().unwrap_or_default();
        words.grammar.substances.contains(name)
            || words.drinks.values().flatten().any(|drink| *drink == phrase.words)
            || matches!(name, "beans" | "contents" | "content")
    }

    /// Whether a source follows in this sentence.
    fn source_ahead(&self, from: usize) -> bool {
        (from..self.tokens.len())
            .take(12)
            .take_while(|&p| !matches!(self.tokens[p], Token::End))
            .any(|p| matches!(self.word_at(p), Some("from" | "out")))
    }

    /// Adverbs and words without an effect stay open; the account reports those that are not ignorable.
    fn filler(&mut self) -> bool {
        let Some(word) = self.word(0) else { return false };
        let known = self.lexicon.vocabulary.grammar.ignorable.contains(word) || word.ends_with("ly");
        let ends = matches!(word, "is" | "are" | "has" | "there" | "should" | "must");
        if !known || ends {
            return false;
        }
        self.at += 1;
        true
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

    /// "the lid of the toolbox", "the microwave door": the object with that part, and the position after it.
    fn whole_of_part(&self, at: usize) -> Option<(NounPhrase, usize)> {
        let mut p = at;
        while matches!(
            self.word_at(p),
            Some("the" | "its" | "top" | "bottom" | "upper" | "lower" | "middle" | "left" | "right")
        ) {
            p += 1;
        }
        if self.word_at(p).is_some_and(is_part) && self.word_at(p + 1) == Some("of") {
            let (mut phrase, end) = noun_phrase(self.lexicon, self.tokens, p + 2)?;
            phrase.tokens.start = at;
            return matches!(phrase.head, Head::Objects(_)).then_some((phrase, end));
        }
        let (mut phrase, end) = noun_phrase(self.lexicon, self.tokens, at)?;
        let Head::Unknown(_) = phrase.head else { return None };
        let range = phrase.head_tokens.clone();
        let last = range.end.checked_sub(1)?;
        let (entry, length) = self.lexicon.longest_at(self.tokens, range.start)?;
        if !self.word_at(last).is_some_and(is_part) || range.start + length != last {
            return None;
        }
        phrase.head = Head::Objects(entry.meanings.clone());
        phrase.words =
            self.tokens[range.start..last].iter().filter_map(Token::word).collect::<Vec<_>>().join(" ");
        Some((phrase, end))
    }

    /// "clockwise", "by 90 degrees", "by a quarter turn" after "rotate".
    fn turn(&mut self, action: &Action) -> bool {
        if action.frame != Frame::Rotate || action.objects.is_empty() {
            return false;
        }
        let is_angle = match &self.tokens[self.at] {
            Token::Number(_) => true,
            Token::Word(word) => {
                matches!(
                    word.as_str(),
                    "by" | "clockwise"
                        | "counterclockwise"
                        | "anticlockwise"
                        | "counter"
                        | "degrees"
                        | "degree"
                        | "quarter"
                        | "half"
                        | "full"
                        | "turn"
                        | "turns"
                        | "about"
                        | "through"
                ) || word == "a" && matches!(self.word(1), Some("quarter" | "half" | "full"))
                    || self.lexicon.vocabulary.numbers.contains_key(word)
            }
            _ => false,
        };
        if is_angle {
            self.parsed.account.used(self.at..self.at + 1);
            self.at += 1;
        }
        is_angle
    }
}
