//! Agents: "the gripper picking up the mug", "hand over the pen from the left arm to the right arm", and what may act
//! itself: "either mug goes in the box".

use super::action::{Action, Part, PathKind};
use super::{Parser, Referent};
use crate::text_parser::phrase::{Determiner, Head, noun_phrase};
use crate::text_parser::phrases::phrases;
use crate::text_parser::tokens::Token;
use crate::text_parser::verbs::{Frame, verbs};

impl Parser<'_, '_> {
    /// "from the left arm", "to the right gripper": the arms of the robot are no objects. Whether the rule applies.
    pub(super) fn other_arm(&mut self, action: &mut Action) -> bool {
        let from = self.word(0) == Some("from");
        if !from && !matches!(self.word(0), Some("to" | "with" | "using" | "into" | "by")) {
            return false;
        }
        let Some(length) = self.agent_length(self.at + 1) else { return false };
        let end = self.at + 1 + length;
        let is_arm = matches!(
            self.word_at(end - 1),
            Some("arm" | "arms" | "gripper" | "grippers" | "hand" | "robot" | "manipulator" | "effector")
        );
        let ends = matches!(self.tokens.get(end), None | Some(Token::Pause | Token::End))
            || matches!(self.word_at(end), Some("to" | "and" | "then" | "from"));
        // "the cube towards the robot" has a place.
        let has_place = self.word_at(end - 1) == Some("robot") && self.word(0) != Some("by");
        if !is_arm || !ends || has_place {
            return false;
        }
        let tokens = self.at..end;
        self.parsed.account.used(tokens.clone());
        action.particles.push(tokens.clone());
        if self.word(0) == Some("to") {
            action.paths.push(self.path(PathKind::Person, tokens));
        }
        self.at = end;
        true
    }

    /// "robot gripper picking up the mug", "end effector reaching knife": what the agent does. Whether the rule
    /// applies.
    pub(super) fn agent_acts(&mut self, start: usize, p: usize) -> bool {
        let begins = p == 0 || p > start || matches!(self.tokens[p - 1], Token::End);
        let Some(length) = self.agent_length(p).filter(|_| begins) else { return false };
        let mut verb = p + length;
        verb += usize::from(matches!(self.word_at(verb), Some("is" | "are")));
        let is_progressive = self.word_at(verb).is_some_and(|word| word.ends_with("ing"));
        let Some((frame, words)) = verbs().at(self.tokens, verb).filter(|_| is_progressive) else {
            return false;
        };
        if !self.phrase_follows(verb + words) {
            return false;
        }
        self.parsed.account.used(start..verb);
        self.instructed = true;
        self.clause_start = false;
        self.act(frame, verb, words, Vec::new());
        self.parsed.instructions.push(start..self.at);
        self.subject.clear();
        true
    }

    /// "either mug goes in the box": one of two. Whether the rule applies.
    pub(super) fn either_ends(&mut self, start: usize, p: usize) -> bool {
        if self.word_at(p) != Some("either") {
            return false;
        }
        let noun = p + 1 + usize::from(self.word_at(p + 1) == Some("of"));
        let noun = noun + usize::from(self.word_at(noun) == Some("the"));
        let Some((mut phrase, end)) = noun_phrase(self.lexicon, self.tokens, noun) else { return false };
        let changes =
            |word: &str| phrases().end_state.changes.has(word) || word == "should" || word == "must";
        let link = self.link_length(end);
        let is_end = link > 0 && (end..end + link).any(|at| self.word_at(at).is_some_and(changes));
        if !is_end || !self.path_follows(end + link) || !matches!(phrase.head, Head::Objects(_)) {
            return false;
        }
        let known = phrase.count.filter(|count| count[0] == count[1] && count[0] > 1);
        (phrase.count, phrase.plural) = (known.or(Some([2, 2])), true);
        phrase.determiner = Determiner::Definite;
        self.at = end;
        let Referent::Mentions(list) = self.refer(phrase, false) else { return false };
        self.parsed.account.used(start..end + link);
        self.instructed = true;
        self.clause_start = false;
        let mut action = self.new_action(Frame::Place, end..end + link);
        action.objects = list.into_iter().map(|mention| Part { mention, take: Some(1) }).collect();
        self.at = end + link;
        self.parts(&mut action);
        self.conclude(action);
        self.parsed.instructions.push(start..self.at);
        self.subject.clear();
        true
    }
}
