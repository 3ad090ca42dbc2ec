//! Words before an instruction: the agent that is to act ("let the arm"), a heading of the end state ("the goal state
//! has"), the number of a step ("2."). Also instructions without a verb: "apple -> bowl", "lamp off".

use super::action::{Action, Part, Path, PathKind};
use super::goals::GoalDraft;
use super::{Parser, Referent};
use crate::text_parser::lexicon::Meaning;
use crate::text_parser::phrase::{Determiner, Head, noun_phrase};
use crate::text_parser::phrases::phrases;
use crate::text_parser::tokens::Token;
use crate::text_parser::verbs::{Frame, verbs};
use scene::RelationKind;
use scene::text_account::PredicateKind;

impl Parser<'_, '_> {
    /// Number of words that name an agent at `at`.
    pub(super) fn agent_length(&self, at: usize) -> Option<usize> {
        let agent = &phrases().agent;
        let mut p =
            at + usize::from(matches!(self.word_at(at), Some("the" | "a" | "your" | "my" | "our" | "this")));
        while self.word_at(p).is_some_and(|word| agent.adjectives.has(word)) {
            p += 1;
        }
        let mut heads = 0;
        while self.word_at(p).is_some_and(|word| agent.names.has(word)) {
            (p, heads) = (p + 1, heads + 1);
        }
        (heads > 0).then_some(p - at)
    }

    /// Number of words that name who acts at `at`: an agent, a person, a pronoun, or a name before a verb ("Alice").
    pub(super) fn actor_length(&self, at: usize) -> Option<usize> {
        let agent = &phrases().agent;
        if self.word_at(at).is_some_and(|word| agent.pronouns.has(word)) {
            return Some(1);
        }
        if let Some(length) = self.agent_length(at) {
            return Some(length);
        }
        let mut p = at
            + usize::from(matches!(
                self.word_at(at),
                Some("the" | "a" | "an" | "your" | "my" | "our" | "this" | "his" | "her" | "their")
            ));
        let is_role = |word: &str| agent.persons.has(word) || agent.names.has(word);
        let start = p;
        while self.word_at(p).is_some_and(is_role) {
            p += 1;
        }
        if p > start {
            return Some(p - at);
        }
        let word = self.word_at(at).filter(|word| p == at && word.len() > 1)?;
        let is_name = self.source.is_capitalized(at)
            && self.lexicon.longest_at(self.tokens, at).is_none()
            && !self.lexicon.vocabulary.has_word(word)
            && !verbs().is_form(word);
        is_name.then_some(1)
    }

    /// "Franka puts", "the robot is putting", "we then move" before an object: the number of words before the verb.
    pub(super) fn narration(&self, at: usize) -> Option<usize> {
        let agent = &phrases().agent;
        let mut verb = at + self.actor_length(at)?;
        let is_pronoun = self.word_at(at).is_some_and(|word| agent.pronouns.has(word));
        let is_adverb = |word: &str| {
            word.ends_with("ly") && word.len() > 4
                || matches!(word, "then" | "now" | "first" | "also" | "next")
        };
        while self.word_at(verb).is_some_and(is_adverb) {
            verb += 1;
        }
        let is = matches!(self.word_at(verb), Some("is" | "are" | "am"));
        verb += usize::from(is);
        let past = self.past_at(verb).filter(|_| !is);
        if past.is_none() && !is && self.is_unknown_motion(verb) {
            return Some(verb - at);
        }
        let known = || verbs().at(self.tokens, verb).filter(|(frame, _)| *frame != Frame::Other);
        let (frame, length) = past.or_else(known)?;
        let form = self.word_at(verb)?;
        let has_plural_subject = matches!(self.word_at(at), Some("we" | "i" | "you" | "they"))
            || self.word_at(verb - 1) == Some("robots");
        let acts = is == form.ends_with("ing")
            && (is || past.is_some() || !verbs().is_base(form) || has_plural_subject);
        let may_be_state = frame == Frame::Use || agent.stative.has(form);
        let acts = acts && !(may_be_state && (is_pronoun || self.agent_or_person(at).is_none()));
        (acts && self.phrase_follows(verb + length)).then_some(verb - at)
    }

    /// A verb of moving in the past at `at` with its object after it ("took", "picked up"). "Left" tells where an
    /// object is.
    pub(super) fn past_at(&self, at: usize) -> Option<(Frame, usize)> {
        let form = self.word_at(at).filter(|word| *word != "left")?;
        let frame = verbs().participle(form).filter(|frame| super::unread::moves(*frame))?;
        let particle = matches!(self.word_at(at + 1), Some("up" | "down" | "out" | "away" | "off"));
        let length = 1 + usize::from(particle);
        let (phrase, _) = noun_phrase(self.lexicon, self.tokens, at + length)?;
        let is_object = phrase.determiner == Determiner::Definite || phrase.head == Head::It || particle;
        (is_object && !phrase.negated && !phrase.is_table()).then_some((frame, length))
    }

    /// "lowers the egg into": a third person that is no known verb, with an object that gets elsewhere.
    fn is_unknown_motion(&self, at: usize) -> bool {
        let Some(word) = self.word_at(at) else { return false };
        let is_third = word.len() > 4 && word.ends_with('s') && !verbs().is_form(word);
        let Some((phrase, end)) = noun_phrase(self.lexicon, self.tokens, at + 1) else { return false };
        let is_known = phrase.determiner == Determiner::Definite || phrase.head == Head::It;
        is_third && is_known && self.is_directed(end)
    }

    /// Number of words that name an agent or a person by their role.
    fn agent_or_person(&self, at: usize) -> Option<usize> {
        let length = self.actor_length(at)?;
        let last = self.word_at(at + length - 1)?;
        let agent = &phrases().agent;
        (agent.names.has(last) || agent.persons.has(last)).then_some(length)
    }

    /// "let the gripper", "have your arm", "the manipulator has to" or "Alice" before a verb, and "could the chef": the
    /// number of words.
    pub(super) fn agent_opener(&self, at: usize) -> Option<usize> {
        if let Some(length) = self.narration(at) {
            return Some(length);
        }
        // "could the chef put the mug away".
        if matches!(self.word_at(at), Some("can" | "could" | "would" | "will"))
            && let Some(length) = self.agent_or_person(at + 1)
        {
            let please = usize::from(self.word_at(at + 1 + length) == Some("please"));
            return Some(1 + length + please);
        }
        let causes = usize::from(self.word_at(at).is_some_and(|word| phrases().agent.causes.has(word)));
        let mut end = at + causes + self.agent_or_person(at + causes)?;
        if causes == 0 {
            let modal = self.modal_length(end);
            if modal == 0 {
                return None;
            }
            end += modal;
        } else {
            end += usize::from(self.word_at(end) == Some("to"));
        }
        while self.word_at(end).is_some_and(|word| word.ends_with("ly") && word.len() > 4) {
            end += 1;
        }
        let acts = self.word_at(end).is_some_and(|word| verbs().is_base(word));
        acts.then_some(end - at)
    }

    /// "wanted:", "the goal state has", "in the final state,": the number of tokens that announce the end state.
    pub(super) fn goal_heading(&self, at: usize) -> Option<usize> {
        let opens = usize::from(matches!(self.word_at(at), Some("in" | "at" | "as" | "for")));
        let mut p = at + opens;
        p += usize::from(matches!(self.word_at(p), Some("the" | "a" | "my" | "your" | "our")));
        let heading = &phrases().goal_heading;
        let named = self.word_at(p).is_some_and(|word| heading.names.has(word));
        if !named {
            return None;
        }
        p += 1;
        let is_state = self.word_at(p).is_some_and(|word| heading.states.has(word));
        p += usize::from(is_state);
        if matches!(self.tokens.get(p), Some(Token::Pause)) {
            let at_end = opens > 0 && self.word_at(p - 1) == Some("end");
            return (is_state || at_end || opens == 0 && self.is_colon(p)).then_some(p + 1 - at);
        }
        if !is_state {
            let link = heading.reached.length_at(self.tokens, p);
            return (link > 0).then_some(p + link - at);
        }
        let link = heading.links.length_at(self.tokens, p);
        p += link;
        let pause = usize::from(matches!(self.tokens.get(p), Some(Token::Pause)));
        (link > 0 || opens > 0).then_some(p + pause - at)
    }

    /// "2." or "step 2:" before a verb: the number of tokens.
    pub(super) fn step_number(&self, at: usize) -> Option<usize> {
        let named = usize::from(self.word_at(at) == Some("step"));
        let p = at + named;
        let counts = match self.tokens.get(p)? {
            Token::Number(number) => *number >= 1.0 && *number <= 30.0 && number.fract() == 0.0,
            Token::Word(word) => named == 1 && self.lexicon.vocabulary.numbers.contains_key(word.as_str()),
            _ => false,
        };
        let end = self.source.spans.get(p)?.end;
        let marked = self.source.text[end..].starts_with(['.', ')', ':']);
        if !counts || !marked && named == 0 {
            return None;
        }
        let mark = usize::from(matches!(self.tokens.get(p + 1), Some(Token::Pause | Token::End)));
        let next = p + 1 + mark;
        let acts = self.word_at(next).is_some_and(|word| verbs().is_base(word))
            || verbs().opener_at(self.tokens, next).is_some();
        acts.then_some(next - at)
    }

    /// The arrow at a pause: "->".
    fn arrow_at(&self, at: usize) -> Option<&str> {
        let span = self.source.spans.get(at).filter(|_| matches!(self.tokens.get(at), Some(Token::Pause)))?;
        Some(&self.source.text[span.clone()]).filter(|mark| mark.contains(['>', '→', '⇒', '↔']))
    }

    pub(super) fn is_arrow(&self, at: usize) -> bool {
        self.arrow_at(at).is_some()
    }

    /// "apple -> bowl", "mug <-> plate". Whether the rule applies.
    pub(super) fn arrow_statement(&mut self, start: usize, p: usize) -> bool {
        let Some((mut phrase, end)) = noun_phrase(self.lexicon, self.tokens, p) else { return false };
        let Some(arrow) = self.arrow_at(end) else { return false };
        let swaps = arrow.contains(['<', '↔']);
        let Some((mut target, _)) = noun_phrase(self.lexicon, self.tokens, end + 1) else { return false };
        if phrase.negated || target.negated || phrase.is_table() || !super::steps::is_object(&phrase.head) {
            return false;
        }
        self.bare_is_definite(&mut phrase);
        self.bare_is_definite(&mut target);
        self.parsed.account.used(start..target.tokens.end);
        self.at = target.tokens.end;
        let (Referent::Mentions(objects), referent) = (self.refer(phrase, false), self.refer(target, true))
        else {
            return true;
        };
        let mut action = self.new_action(if swaps { Frame::Swap } else { Frame::Place }, end..end + 1);
        action.objects = objects.into_iter().map(|mention| Part { mention, take: None }).collect();
        match referent {
            Referent::Mentions(targets) => {
                let path = self.path(PathKind::At, end..end + 1);
                action.paths.push(Path { targets, directed: true, ..path });
            }
            Referent::Table => action.paths.push(self.path(PathKind::Table, end..end + 1)),
            Referent::Nothing => {}
        }
        self.instructed = true;
        self.conclude(action);
        self.parsed.instructions.push(start..self.at);
        self.subject.clear();
        true
    }

    /// "move the apple -> the bowl": the target after the arrow. Whether the rule applies.
    pub(super) fn pointed_target(&mut self, action: &mut Action) -> bool {
        let Some((mut phrase, end)) = noun_phrase(self.lexicon, self.tokens, self.at + 1) else {
            return false;
        };
        if action.objects.is_empty() || !action.paths.is_empty() || phrase.negated {
            return false;
        }
        self.bare_is_definite(&mut phrase);
        let tokens = self.at..self.at + 1;
        self.at = end;
        match self.refer_target(phrase, action, None) {
            Referent::Mentions(targets) => {
                let path = self.path(PathKind::At, tokens);
                action.paths.push(Path { targets, directed: true, ..path });
            }
            Referent::Table => action.paths.push(self.path(PathKind::Table, tokens)),
            Referent::Nothing => action.unknown = true,
        }
        true
    }

    /// "get rid of the peel: trash can": a single noun after the colon is the target. Whether the rule applies.
    pub(super) fn colon_target(&mut self, action: &mut Action) -> bool {
        let ends = noun_phrase(self.lexicon, self.tokens, self.at + 1).is_some_and(|(phrase, end)| {
            matches!(phrase.head, Head::Objects(_))
                && !phrase.plural
                && phrase.count.is_none()
                && matches!(self.tokens.get(end), None | Some(Token::End))
        });
        let [part] = action.objects[..] else { return false };
        let vague = self.is_several(part.mention)
            || !matches!(self.parsed.mentions[part.mention].meanings.first(), Some(Meaning::Category(_)));
        action.frame == Frame::Place && ends && !vague && self.pointed_target(action)
    }

    fn asks_politely(&self, at: usize) -> bool {
        let pause = usize::from(matches!(self.tokens.get(at), Some(Token::Pause)));
        self.word_at(at + pause) == Some("please")
    }

    /// "lamp off", "the mug off the tray, please": an end state without a verb. Whether the rule applies.
    pub(super) fn verbless(&mut self, start: usize, p: usize) -> bool {
        let begins = (p == 0 || p > start || matches!(self.tokens[p - 1], Token::End))
            && verbs().at(self.tokens, p).is_none();
        let Some((mut phrase, end)) = noun_phrase(self.lexicon, self.tokens, p).filter(|_| begins) else {
            return false;
        };
        let ends = |at: usize| {
            let please = usize::from(matches!(self.tokens.get(at), Some(Token::Pause)));
            let at = at + please;
            let at = at + usize::from(self.word_at(at) == Some("please"));
            matches!(self.tokens.get(at), None | Some(Token::End))
        };
        if phrase.negated || phrase.is_table() || !matches!(phrase.head, Head::Objects(_)) {
            return false;
        }
        let word = self.word_at(end);
        if matches!(word, Some("on" | "off")) && ends(end + 1) && is_switched(&phrase.words) {
            self.bare_is_definite(&mut phrase);
            self.parsed.account.used(start..end + 1);
            self.at = end + 1;
            if let Referent::Mentions(list) = self.refer(phrase, false) {
                for mention in list {
                    self.add_goal(GoalDraft::new(PredicateKind::Pressed, mention), end..end + 1);
                }
            }
        } else if let Some((state, length)) = self.state_at(end)
            && super::states::pose_of(&state).is_some()
            && self.asks_politely(end + length)
        {
            // "mug upright, please".
            self.bare_is_definite(&mut phrase);
            self.at = end;
            let Referent::Mentions(objects) = self.refer(phrase, false) else { return true };
            let mut action = self.new_action(Frame::Place, end..end + length);
            action.objects = objects.into_iter().map(|mention| Part { mention, take: None }).collect();
            action.paths.push(self.path(PathKind::State(state), end..end + length));
            self.at = end + length;
            self.conclude(action);
        } else if matches!(word, Some("off")) || word == Some("out") && self.word_at(end + 1) == Some("of") {
            let at = end + usize::from(word == Some("out")) + 1;
            let Some((target, after)) = noun_phrase(self.lexicon, self.tokens, at) else { return false };
            if !ends(after) || target.is_table() || target.negated {
                return false;
            }
            self.bare_is_definite(&mut phrase);
            self.at = after;
            let (Referent::Mentions(objects), Referent::Mentions(targets)) =
                (self.refer(phrase, false), self.refer(target, true))
            else {
                return true;
            };
            let kind = if word == Some("off") { RelationKind::On } else { RelationKind::In };
            let mut action = self.new_action(Frame::Take, end..at);
            action.objects = objects.into_iter().map(|mention| Part { mention, take: None }).collect();
            action.sources.push(Path { targets, ..self.path(PathKind::Relation(kind), end..at) });
            self.conclude(action);
        } else {
            return false;
        }
        self.instructed = true;
        self.parsed.instructions.push(start..self.at);
        self.subject.clear();
        true
    }
}

/// Whether the object of this name is switched on and off.
pub(super) fn is_switched(words: &str) -> bool {
    let name = words.rsplit(' ').next().unwrap_or_default();
    matches!(
        name,
        "lamp"
            | "light"
            | "lights"
            | "lamps"
            | "bulb"
            | "fan"
            | "stove"
            | "radio"
            | "kettle"
            | "toaster"
            | "blender"
            | "monitor"
            | "screen"
            | "tv"
            | "television"
            | "microwave"
            | "oven"
            | "heater"
            | "machine"
            | "maker"
            | "speaker"
            | "printer"
            | "computer"
            | "laptop"
            | "burner"
            | "lantern"
            | "flashlight"
            | "torch"
            | "cooker"
    )
}
