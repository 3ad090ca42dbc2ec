//! Recognition of instructions: an imperative ("put the apple in the bowl"), a request ("can you ...", "the robot
//! should ...") or a purpose ("so that", "to wipe the table"). Verbs are never objects.

use super::Parser;
use crate::text_parser::measures::read_length;
use crate::text_parser::phrase::{Determiner, Head, NounPhrase, noun_phrase};
use crate::text_parser::prepositions::preposition_at;
use crate::text_parser::tokens::Token;
use crate::text_parser::verbs::{Frame, verbs};
use scene::text_account::UnrecognizedReason;

/// Openers that do not by themselves ask for an action.
const WEAK: &[&str] = &[
    "please",
    "kindly",
    "next",
    "then",
    "now",
    "finally",
    "first",
    "second",
    "third",
    "lastly",
    "just",
    "and",
    "lets",
    "afterwards",
];

impl Parser<'_, '_> {
    /// An instruction at the current position. Whether the rule applies.
    pub(super) fn instruction(&mut self) -> bool {
        let start = self.at;
        // "leave out the stapler" asks for nothing to be done.
        if self.negation().is_some() {
            return false;
        }
        let purpose = self.is_purpose();
        if !purpose && !self.clause_begins() {
            return self.required_state();
        }
        let mut p = start + usize::from(purpose && self.word(0) == Some("to"));
        let mut requested = purpose;
        // Openers may follow each other: "please, can you".
        for _ in 0..4 {
            let Some(length) = verbs().opener_at(self.tokens, p) else { break };
            requested |= !(length == 1 && self.word_at(p).is_some_and(|word| WEAK.contains(&word)));
            p += length;
            while matches!(self.tokens.get(p), Some(Token::Pause)) && p > start {
                p += 1;
            }
        }
        // "can you carefully put".
        while self.word_at(p).is_some_and(|word| word.ends_with("ly") && word.len() > 4 && requested) {
            p += 1;
        }
        if requested && self.states_goal(start, p) {
            return true;
        }
        let Some((frame, length)) = verbs().at(self.tokens, p) else {
            return p > start && requested && self.scene_request(start, p);
        };
        if !self.governs(p, length, frame, requested) {
            return p > start && requested && self.scene_request(start, p);
        }
        if self.arranges_scene(frame, p + length, requested) {
            self.parsed.account.used(start..p + length);
            self.at = p + length;
            self.clause_start = true;
            self.subject.clear();
            if frame == Frame::Stack || self.word_at(self.at - 1) == Some("up") && frame == Frame::Other {
                self.arranged_next = Some((frame, p..p + length));
            }
            return true;
        }
        let subjects = self.subject.clone();
        self.parsed.account.used(start..p);
        self.instructed = true;
        self.clause_start = false;
        self.act(frame, p, length, if purpose { subjects } else { Vec::new() });
        self.parsed.instructions.push(start..self.at);
        self.subject.clear();
        true
    }

    /// Whether a clause may begin here.
    fn clause_begins(&self) -> bool {
        let before = self.at.checked_sub(1).map(|before| &self.tokens[before]);
        match before {
            None | Some(Token::Pause | Token::End) => true,
            Some(Token::Word(word)) => {
                matches!(word.as_str(), "and" | "then" | "please" | "but" | "now" | "so" | "next" | "by")
            }
            Some(Token::Number(_)) => false,
        }
    }

    /// "so that the robot can ...", "for the robot to ...", "in order to ...", "to wipe the table".
    fn is_purpose(&self) -> bool {
        match self.word(0) {
            Some("so" | "for" | "in") => {
                verbs().opener_at(self.tokens, self.at).is_some_and(|length| length > 2)
            }
            Some("to") => {
                let before = self.at.checked_sub(1).and_then(|before| self.word_at(before));
                let Some((_, length)) = verbs().at(self.tokens, self.at + 1) else { return false };
                !matches!(before, Some("next" | "close" | "adjacent" | "near" | "parallel" | "up"))
                    && self.phrase_follows(self.at + 1 + length)
            }
            _ => false,
        }
    }

    fn phrase_follows(&self, at: usize) -> bool {
        noun_phrase(self.lexicon, self.tokens, at).is_some_and(|(phrase, _)| !phrase.negated)
            || matches!(
                self.word_at(at),
                Some("me" | "us" | "the" | "all" | "up" | "down" | "over" | "from" | "off" | "out")
            )
    }

    /// Whether the word at `at` is a verb with objects, not a noun or an adjective.
    fn governs(&self, at: usize, length: usize, frame: Frame, requested: bool) -> bool {
        let after = at + length;
        let by = at.checked_sub(1).and_then(|before| self.word_at(before)) == Some("by");
        // "and holds a spoon" describes the subject.
        if !requested && !by && !self.word_at(at).is_some_and(|word| verbs().is_base(word)) {
            return false;
        }
        let follows = self.phrase_follows(after)
            || (preposition_at(self.tokens, after).is_some()
                && (requested || matches!(frame, Frame::Pour | Frame::Use)));
        if !follows {
            return false;
        }
        if requested {
            return true;
        }
        let word = self.word_at(at).unwrap_or_default();
        // "lamps, open book" in a list; "drill the hole" at the start of a sentence.
        let determined = matches!(
            self.word_at(after),
            Some(
                "the"
                    | "a"
                    | "an"
                    | "it"
                    | "them"
                    | "this"
                    | "that"
                    | "these"
                    | "those"
                    | "all"
                    | "both"
                    | "each"
                    | "every"
                    | "one"
                    | "another"
                    | "me"
                    | "up"
                    | "any"
                    | "your"
                    | "its"
                    | "everything"
            )
        ) || matches!(self.tokens.get(after), Some(Token::Number(_)))
            || self.word_at(after).is_some_and(|word| self.lexicon.vocabulary.numbers.contains_key(word));
        let sentence_start = at == 0 || matches!(self.tokens[at - 1], Token::End) || self.instructed;
        let is_noun = self.lexicon.longest_at(self.tokens, at).is_some_and(|(_, n)| n >= length);
        let is_adjective = self.lexicon.vocabulary.is_ordinary(word)
            && matches!(frame, Frame::Open | Frame::Close | Frame::Use | Frame::Pour | Frame::Other);
        determined
            || (sentence_start && !is_noun && !is_adjective)
            || (sentence_start && self.instructed && !is_noun)
            || (sentence_start
                && matches!(frame, Frame::Open | Frame::Close)
                && self.known_noun_ends_sentence(after))
    }

    /// "open drawer": a bare noun is all that follows the verb.
    fn known_noun_ends_sentence(&self, at: usize) -> bool {
        at == 1
            && noun_phrase(self.lexicon, self.tokens, at).is_some_and(|(_, end)| {
                matches!(self.tokens.get(end), None | Some(Token::End))
                    || verbs().at(self.tokens, end + 1).is_some()
            })
    }

    /// Whether "put", "place", "stack" and the like only say what is on the table: their object is indefinite, so it is
    /// not there yet; or its destination has a measured distance.
    fn arranges_scene(&self, frame: Frame, at: usize, requested: bool) -> bool {
        let verb = self.word_at(at.saturating_sub(1)).unwrap_or_default();
        let lines_up = frame == Frame::Other && matches!(verb, "up" | "group" | "lean");
        if !matches!(frame, Frame::Place | Frame::Hand | Frame::Stack | Frame::Hang) && !lines_up {
            return false;
        }
        let at = at + usize::from(matches!(self.word_at(at), Some("me" | "us")));
        let Some((phrase, end)) = noun_phrase(self.lexicon, self.tokens, at) else { return false };
        if phrase.is_table() {
            return frame == Frame::Place;
        }
        if phrase.determiner == Determiner::Definite
            && frame == Frame::Place
            && read_length(self.lexicon.vocabulary, self.tokens, end).is_some()
        {
            return true;
        }
        let counted = phrase.count.is_some() || phrase.plural && verb != "sort";
        phrase.determiner == Determiner::New
            && !matches!(phrase.head, Head::It | Head::Them | Head::All)
            && (counted || verb == "add")
            && !(self.instructed && (requested || self.part_of_earlier(&phrase).is_some()))
            && !(phrase.plural && phrase.count.is_none() && self.earlier_plural(&phrase))
    }

    /// Whether the text has objects of the phrase.
    fn earlier_plural(&self, phrase: &NounPhrase) -> bool {
        let Head::Objects(meanings) = &phrase.head else { return false };
        self.parsed
            .mentions
            .iter()
            .any(|mention| mention.meanings.iter().any(|meaning| meanings.contains(meaning)))
    }

    /// "the goal is to have the lemon in the jar", "goal: the banana is in the bowl".
    fn states_goal(&mut self, start: usize, p: usize) -> bool {
        let says = (start..p)
            .any(|token| matches!(self.word_at(token), Some("goal" | "task" | "objective" | "aim")));
        if !says {
            return false;
        }
        if matches!(self.word_at(p), Some("have" | "get")) && self.phrase_follows(p + 1) {
            self.parsed.account.used(start..p);
            self.instructed = true;
            self.act(Frame::Place, p, 1, Vec::new());
            self.parsed.instructions.push(start..self.at);
            self.subject.clear();
            return true;
        }
        let Some((phrase, end)) = noun_phrase(self.lexicon, self.tokens, p) else { return false };
        if !matches!(self.word_at(end), Some("is" | "are")) {
            return false;
        }
        self.at = end;
        let super::Referent::Mentions(subjects) = self.refer(phrase, false) else { return false };
        self.parsed.account.used(start..p);
        self.instructed = true;
        self.act(Frame::Place, end, 1, subjects);
        self.parsed.instructions.push(start..self.at);
        self.subject.clear();
        true
    }

    /// "can you make a desk with ...": a request for a scene.
    fn scene_request(&mut self, start: usize, p: usize) -> bool {
        let asks = self.word_at(p).is_some_and(|word| verbs().asks_for_scene(word));
        if !asks {
            return false;
        }
        self.parsed.account.used(start..p + 1);
        self.at = p + 1;
        true
    }

    /// "the apple should be in the bowl at the end", "the mug must end up on the plate": a goal about the last subject.
    fn required_state(&mut self) -> bool {
        let start = self.at;
        let Some(&object) = self.subject.last() else { return false };
        let modal = matches!(
            self.word(0),
            Some(
                "should"
                    | "must"
                    | "needs"
                    | "need"
                    | "has"
                    | "have"
                    | "ought"
                    | "shall"
                    | "gets"
                    | "goes"
                    | "belongs"
                    | "ends"
            )
        );
        if !modal {
            return false;
        }
        let mut p = start
            + usize::from(matches!(
                self.word(0),
                Some("should" | "must" | "needs" | "need" | "has" | "have" | "ought" | "shall")
            ));
        p += usize::from(self.word_at(p) == Some("to"));
        let (length, certain) = match (self.word_at(p), self.word_at(p + 1)) {
            (Some("end" | "ends"), Some("up")) => (2, true),
            (
                Some("be"),
                Some(
                    "moved" | "placed" | "put" | "stacked" | "brought" | "transferred" | "dropped"
                    | "inserted" | "opened" | "lifted" | "picked" | "removed" | "taken" | "pushed"
                    | "carried",
                ),
            ) => (1, true),
            (Some("go" | "goes" | "belongs" | "land"), _) => (1, true),
            (Some("be" | "stand" | "sit" | "lie"), _) => (1, self.instructed || self.goal_words()),
            _ => return false,
        };
        if !certain {
            return false;
        }
        p += length;
        let participle = self.word_at(p).unwrap_or_default();
        let frame = match participle {
            "opened" => Frame::Open,
            "closed" | "shut" => Frame::Close,
            "lifted" | "picked" => Frame::Lift,
            "stacked" => Frame::Stack,
            "removed" | "taken" => Frame::Take,
            "pushed" => Frame::Push,
            _ => Frame::Place,
        };
        let passive = matches!(
            participle,
            "moved" | "placed" | "put" | "brought" | "transferred" | "dropped" | "inserted" | "carried"
        ) || frame != Frame::Place;
        let length = usize::from(passive)
            + usize::from(matches!(participle, "picked" | "lifted") && self.word_at(p + 1) == Some("up"));
        self.parsed.account.used(start..p + length);
        self.instructed = true;
        self.act(frame, p, length, vec![object]);
        self.parsed.instructions.push(start..self.at);
        self.subject.clear();
        true
    }

    /// Whether the text speaks of a goal or of a robot.
    fn goal_words(&self) -> bool {
        self.tokens.iter().take(400).filter_map(Token::word).any(|word| {
            matches!(
                word,
                "goal"
                    | "task"
                    | "robot"
                    | "finally"
                    | "afterwards"
                    | "end"
                    | "finished"
                    | "done"
                    | "gripper"
            )
        })
    }

    /// Reports an instruction whose goal has no predicate.
    pub(super) fn not_expressible(&mut self, tokens: std::ops::Range<usize>) {
        self.report(tokens, UnrecognizedReason::NotExpressible);
    }
}
