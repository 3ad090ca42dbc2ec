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
        if self.happened() {
            return true;
        }
        if self.negation().is_some() {
            return false;
        }
        let purpose = self.is_purpose();
        if !purpose && !self.clause_begins() {
            return self.required_state();
        }
        // "the pear, which is ripe, is to be put in the bowl".
        if !purpose && self.follows_pause() && self.required_state() {
            return true;
        }
        let mut p = start + usize::from(purpose && self.word(0) == Some("to"));
        let (mut requested, mut tells) = (purpose, self.is_narrated && self.instructed);
        // Openers may follow each other: "please, can you".
        for _ in 0..4 {
            let known = verbs().opener_at(self.tokens, p).filter(|length| self.opens(p, *length));
            let heading = self.goal_heading(p).filter(|_| p == start && !purpose);
            let own = self.agent_opener(p).max(self.step_number(p)).max(heading);
            let Some(length) = known.max(own) else { break };
            tells |= self.narration(p).is_some();
            requested |= own == Some(length)
                || !(length == 1 && self.word_at(p).is_some_and(|word| WEAK.contains(&word)));
            p += length;
            while matches!(self.tokens.get(p), Some(Token::Pause)) && p > start {
                p += 1;
            }
        }
        // "can you carefully put".
        while self.word_at(p).is_some_and(|word| word.ends_with("ly") && word.len() > 4 && requested) {
            p += 1;
        }
        if (requested && self.states_goal(start, p))
            || self.either_ends(start, p)
            || self.agent_acts(start, p)
            || self.desire(start, p)
            || self.causative(start, p)
            || self.builds_stack(start, p)
            || self.terse_list(start, p)
            || self.arrow_statement(start, p)
            || self.verbless(start, p)
        {
            return true;
        }
        // "pick up and lift the mug".
        if let Some((first, length)) = verbs().at(self.tokens, p)
            && self.word_at(p + length) == Some("and")
            && matches!(first, Frame::Lift | Frame::Take | Frame::Push)
            && verbs()
                .at(self.tokens, p + length + 1)
                .is_some_and(|(_, more)| self.phrase_follows(p + length + 1 + more))
        {
            self.parsed.account.used(p..p + length + 1);
            p += length + 1;
            requested = true;
        }
        // "could you do a desk with a lamp".
        let asks = self.word_at(p).is_some_and(|word| verbs().asks_for_scene(word));
        if requested && asks && p > start && self.word_at(p) == Some("do") && self.indefinite_at(p + 1) {
            return self.scene_request(start, p);
        }
        // "after you have moved the mug".
        let have = p > start && matches!(self.word_at(p - 1), Some("have" | "having" | "has"));
        let participle = self.word_at(p).filter(|_| have).and_then(|word| verbs().participle(word));
        let past = self.past_at(p).filter(|_| tells);
        let verb = past.or_else(|| verbs().at(self.tokens, p)).or_else(|| participle.map(|frame| (frame, 1)));
        let Some((frame, length)) = verb else {
            return self.unknown_imperative(start, p)
                || p > start && requested && self.scene_request(start, p);
        };
        if !self.governs(p, length, frame, requested) {
            return p > start && requested && self.scene_request(start, p);
        }
        let third_person = |word: &str| word.ends_with('s') && !verbs().is_base(word);
        let narrates = requested && self.word_at(p).is_some_and(third_person) || past.is_some();
        if !narrates && self.arranges_scene(frame, p + length, requested) {
            self.parsed.account.used(start..p + length);
            self.at = p + length;
            self.clause_start = true;
            self.subject.clear();
            let ignorable = &self.lexicon.vocabulary.grammar.ignorable;
            if frame == Frame::Stack || self.word_at(self.at - 1) == Some("up") && frame == Frame::Other {
                self.arranged_next = Some((frame, p..p + length));
            } else if self.word_at(p).is_some_and(|verb| !ignorable.contains(verb)) {
                self.arranging = Some((p..p + length, self.parsed.mentions.len()));
            }
            return true;
        }
        let subjects = self.subject.clone();
        self.parsed.account.used(start..p);
        self.is_narrated |= narrates;
        self.instructed = true;
        self.clause_start = false;
        self.act(frame, p, length, if purpose { subjects } else { Vec::new() });
        self.parsed.instructions.push(start..self.at);
        self.subject.clear();
        true
    }

    /// Whether the opener at `at` is one: "goal: ...", but not "the task lamp".
    fn opens(&self, at: usize, length: usize) -> bool {
        let last = self.word_at(at + length - 1);
        !matches!(last, Some("goal" | "task" | "instruction" | "objective"))
            || matches!(self.tokens.get(at + length), Some(Token::Pause | Token::End))
            || verbs().at(self.tokens, at + length).is_some()
    }

    /// Whether a clause may begin here.
    fn clause_begins(&self) -> bool {
        let before = self.at.checked_sub(1).map(|before| &self.tokens[before]);
        let begins = match before {
            None | Some(Token::Pause | Token::End) => true,
            Some(Token::Word(word)) => {
                matches!(word.as_str(), "and" | "then" | "please" | "but" | "now" | "so" | "next" | "by")
                    || self.is_quoted()
            }
            Some(Token::Number(_)) => false,
        };
        // "close it after taking out the spoon".
        let while_acting = self.instructed
            && matches!(self.word(0), Some("after" | "before"))
            && verbs().at(self.tokens, self.at + 1).is_some();
        begins || while_acting || self.step_number(self.at).is_some()
    }

    /// "for the instruction "put the carrot in the bowl"".
    fn is_quoted(&self) -> bool {
        let says = self.at.checked_sub(1).and_then(|before| self.word_at(before));
        let is_instruction = matches!(
            says,
            Some(
                "instruction" | "task" | "command" | "goal" | "prompt" | "says" | "say" | "called" | "named"
            )
        );
        let start = self.source.spans.get(self.at).map_or(0, |span| span.start);
        let quote = self.source.text[..start].trim_end().chars().next_back();
        is_instruction && quote.is_some_and(|c| matches!(c, '"' | '\'' | '“' | '”' | '‘' | '’' | '«' | '`'))
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

    pub(super) fn phrase_follows(&self, at: usize) -> bool {
        noun_phrase(self.lexicon, self.tokens, at).is_some_and(|(phrase, _)| !phrase.negated)
            || self.bare_one(at).is_some()
            || self.bare_color(at).is_some() && preposition_at(self.tokens, at + 1).is_some()
            || matches!(
                self.word_at(at),
                Some(
                    "me" | "us"
                        | "the"
                        | "its"
                        | "all"
                        | "either"
                        | "up"
                        | "down"
                        | "over"
                        | "from"
                        | "off"
                        | "out"
                )
            )
    }

    /// "frobnicate the mug": a verb that is not known. Its words never describe the start state.
    fn unknown_imperative(&mut self, start: usize, p: usize) -> bool {
        let vocabulary = self.lexicon.vocabulary;
        let begins = p == 0 || matches!(self.tokens[p - 1], Token::End) || p > start || self.instructed;
        let Some(word) = self.word_at(p).filter(|_| begins) else { return false };
        let is_known = vocabulary.is_ordinary(word)
            || vocabulary.has_word(word)
            || self.lexicon.longest_at(self.tokens, p).is_some();
        let is_function_word = vocabulary.numbers.contains_key(word)
            || verbs().asks_for_scene(word)
            || verbs().is_form(word)
            || vocabulary.grammar.determiners.contains(word)
            || vocabulary.grammar.ignorable.contains(word)
            || word.ends_with("ing")
            || word.len() < 3
            || preposition_at(self.tokens, p).is_some();
        let definite = matches!(
            self.word_at(p + 1),
            Some("the" | "it" | "them" | "this" | "that" | "these" | "those" | "both" | "my" | "your")
        );
        let indefinite =
            matches!(self.word_at(p + 1), Some("a" | "an" | "one" | "all" | "each" | "every" | "either"));
        // "ferry the mug to the tray": a noun before an article, and a path.
        let reaches = || {
            noun_phrase(self.lexicon, self.tokens, p + 1)
                .is_some_and(|(_, end)| preposition_at(self.tokens, end).is_some() || self.is_directed(end))
        };
        let is_verb = match (is_known, definite) {
            (false, true) => true,
            (false, false) => indefinite && reaches(),
            (true, true) => {
                matches!(self.word_at(p + 1), Some("the" | "it" | "them"))
                    && !super::desired_state::is_state_word(word)
                    && !vocabulary.is_listed(word)
                    && reaches()
            }
            (true, false) => false,
        };
        if !is_verb || is_function_word || !self.phrase_follows(p + 1) {
            return false;
        }
        self.parsed.account.used(start..p);
        self.instructed = true;
        self.clause_start = false;
        self.act(Frame::Other, p, 1, Vec::new());
        self.parsed.instructions.push(start..self.at);
        self.subject.clear();
        true
    }

    /// Whether the word at `at` is a verb with objects, not a noun or an adjective.
    pub(super) fn governs(&self, at: usize, length: usize, frame: Frame, requested: bool) -> bool {
        let after = at + length;
        let by = at.checked_sub(1).and_then(|before| self.word_at(before)) == Some("by");
        // "and holds a spoon" describes the subject.
        let narrated = self.is_narrated && self.instructed || self.past_at(at).is_some();
        if !requested && !by && !narrated && !self.word_at(at).is_some_and(|word| verbs().is_base(word)) {
            return false;
        }
        let pours = matches!(frame, Frame::Pour | Frame::Fill | Frame::Use);
        // "pick the apple and place in the bowl", "put the mug in and close".
        let continues = self.instructed
            && matches!(frame, Frame::Place | Frame::Push | Frame::Hang | Frame::Stack)
            && self.path_follows(after);
        let closes = self.instructed
            && matches!(frame, Frame::Open | Frame::Close)
            && (self.word_at(after).is_none() || matches!(self.word_at(after), Some("again" | "afterwards")));
        let follows = self.phrase_follows(after)
            || (preposition_at(self.tokens, after).is_some() && (requested || pours))
            || (pours && self.substance_length(after).is_some())
            || (matches!(frame, Frame::Push | Frame::Rotate | Frame::Place)
                && matches!(self.word_at(after), Some("left" | "right" | "forward" | "backward"))
                && self.phrase_follows(after + 1))
            || continues
            || closes;
        if !follows {
            return false;
        }
        if requested || continues || closes {
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
                    | "either"
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
        let for_person = matches!(self.word_at(at), Some("me" | "us"));
        let at = at + usize::from(for_person);
        let Some((phrase, end)) = noun_phrase(self.lexicon, self.tokens, at) else { return false };
        if phrase.is_table() {
            return frame == Frame::Place && !self.is_colon(end);
        }
        // "stack two red blocks" as the whole text; "pile up five lemons" describes a pile.
        let piles = (at.saturating_sub(3)..at).any(|at| matches!(self.word_at(at), Some("pile" | "heap")));
        if frame == Frame::Stack && !piles && self.parsed.mentions.is_empty() && end == self.tokens.len() {
            return false;
        }
        if phrase.determiner == Determiner::Definite
            && matches!(verb, "put" | "place" | "set" | "position" | "lay" | "keep" | "leave")
            && read_length(self.lexicon.vocabulary, self.tokens, self.after_hedges(end)).is_some()
        {
            return true;
        }
        // "put 2 markers in the cup" as the first sentence: the cup is there.
        if frame == Frame::Place && self.parsed.mentions.is_empty() && self.definite_support(end) {
            return false;
        }
        // "put one block on the other".
        let mut sentence = (end..self.tokens.len()).take_while(|&at| self.tokens[at] != Token::End);
        let names_other = self.word_at(phrase.tokens.start) == Some("one")
            && sentence.any(|at| {
                self.word_at(at) == Some("other") && self.word_at(at.saturating_sub(1)) == Some("the")
            });
        if names_other {
            return false;
        }
        let counted = phrase.count.is_some() || phrase.plural && verb != "sort";
        phrase.determiner == Determiner::New
            && !matches!(phrase.head, Head::It | Head::Them | Head::All)
            && (counted || verb == "add")
            && !(self.instructed
                && (requested
                    || for_person
                    || self.definite_target(end)
                    || self.part_of_earlier(&phrase).is_some()))
            && !(phrase.plural && phrase.count.is_none() && self.earlier_plural(&phrase))
    }

    /// "next to the can" at `at`.
    fn definite_target(&self, at: usize) -> bool {
        let Some((_, length)) = preposition_at(self.tokens, at) else { return false };
        noun_phrase(self.lexicon, self.tokens, at + length).is_some_and(|(phrase, _)| {
            phrase.determiner == Determiner::Definite
                && !phrase.is_table()
                && matches!(phrase.head, Head::Objects(_))
        })
    }

    fn indefinite_at(&self, at: usize) -> bool {
        matches!(self.word_at(at), Some("a" | "an" | "me" | "us" | "one" | "some" | "another"))
            || matches!(self.tokens.get(at), Some(Token::Number(_)))
            || self.word_at(at).is_some_and(|word| self.lexicon.vocabulary.numbers.contains_key(word))
    }

    /// "in the cup" at `at`.
    fn definite_support(&self, at: usize) -> bool {
        let Some((preposition, length)) = preposition_at(self.tokens, at) else { return false };
        noun_phrase(self.lexicon, self.tokens, at + length).is_some_and(|(phrase, _)| {
            (preposition.kind.is_support() && phrase.determiner == Determiner::Definite
                || phrase.determiner == Determiner::Each)
                && !phrase.is_table()
                && matches!(phrase.head, Head::Objects(_))
        })
    }

    /// Whether the text has objects of the phrase.
    fn earlier_plural(&self, phrase: &NounPhrase) -> bool {
        let Head::Objects(meanings) = &phrase.head else { return false };
        self.parsed
            .mentions
            .iter()
            .any(|mention| mention.meanings.iter().any(|meaning| meanings.contains(meaning)))
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

    /// Reports an instruction whose goal has no predicate.
    pub(super) fn not_expressible(&mut self, tokens: std::ops::Range<usize>) {
        self.report(tokens, UnrecognizedReason::NotExpressible);
    }
}
