//! Formations of instructions: "on top of each other", "side by side", "from left to right", "build a tower from three
//! cubes".

use super::Parser;
use super::action::{Action, Formation, Part, Path};
use super::goals::{GoalDraft, GoalKind};
use super::outcome::predicate_of;
use crate::text_parser::phrase::{Determiner, Head, noun_phrase};
use crate::text_parser::tokens::match_phrase;
use crate::text_parser::verbs::Frame;
use scene::RelationKind;
use scene::text_account::PredicateKind;

/// The objects form one stack.
const STACKS: &[&str] = &[
    "on top of each other",
    "on top of one another",
    "one on top of the other",
    "on each other",
    "on one another",
    "onto each other",
    "onto one another",
    "atop each other",
    "atop one another",
    "inside each other",
    "inside one another",
    "into each other",
    "into a tower",
    "into one tower",
    "in a tower",
    "into a stack",
    "into one stack",
    "in a stack",
    "in one stack",
    "to form a tower",
    "to form a stack",
    "to make a tower",
    "to make a stack",
    "to build a tower",
];

/// The objects stand beside each other.
const TOGETHER: &[&str] = &[
    "next to each other",
    "next to one another",
    "beside each other",
    "beside one another",
    "close to each other",
    "near each other",
    "side by side",
    "close together",
    "together",
    "into a pile",
    "in a pile",
    "in a row",
    "into a row",
    "in one row",
    "in a line",
    "into a line",
    "in a straight line",
];

const ORDERS: &[(&str, RelationKind)] = &[
    ("from left to right", RelationKind::LeftOf),
    ("left to right", RelationKind::LeftOf),
    ("from the left to the right", RelationKind::LeftOf),
    ("from right to left", RelationKind::RightOf),
    ("right to left", RelationKind::RightOf),
    ("from front to back", RelationKind::InFrontOf),
    ("front to back", RelationKind::InFrontOf),
    ("from back to front", RelationKind::Behind),
    ("back to front", RelationKind::Behind),
];

impl Parser<'_, '_> {
    /// A formation of the objects of an instruction. Whether the rule applies.
    pub(super) fn formation(&mut self, action: &mut Action) -> bool {
        if !matches!(action.frame, Frame::Place | Frame::Push | Frame::Stack | Frame::Lift | Frame::Other) {
            return false;
        }
        let longest = |phrases: &[&str]| {
            phrases.iter().filter_map(|phrase| match_phrase(self.tokens, self.at, phrase)).max()
        };
        let order = ORDERS
            .iter()
            .filter_map(|(phrase, kind)| Some((match_phrase(self.tokens, self.at, phrase)?, *kind)))
            .max_by_key(|(length, _)| *length);
        let (length, formation) = match (order, longest(STACKS), longest(TOGETHER)) {
            (Some((length, kind)), _, _) => (length, Formation::Ordered(kind)),
            (_, Some(length), _) => (length, Formation::Stack),
            (_, _, Some(length)) => (length, Formation::Together),
            _ => return false,
        };
        if action.objects.is_empty() && !matches!(formation, Formation::Ordered(_)) {
            return false;
        }
        let is_known = action.frame == Frame::Stack
            || formation == Formation::Together && matches!(action.formation, Some(Formation::Ordered(_)));
        if !is_known {
            action.formation = Some(formation);
        }
        self.parsed.account.used(self.at..self.at + length);
        self.at += length;
        true
    }

    /// States the formation of the objects, and where they form it.
    pub(super) fn forms(&mut self, action: &mut Action, formation: Formation) {
        let destination: Option<Path> = self.destination(action);
        match formation {
            Formation::Stack => {
                action.paths.extend(destination);
                self.stacked(action);
                return;
            }
            Formation::Together => {
                self.pairs(action, |pair| GoalDraft::new(PredicateKind::NextTo, pair[1]).to(pair[0]), {
                    GoalKind::Together
                });
            }
            Formation::Ordered(kind) => {
                let Some(predicate) = predicate_of(kind, false) else { return };
                self.pairs(action, |pair| GoalDraft::new(predicate, pair[0]).to(pair[1]), {
                    GoalKind::InOrder(predicate)
                });
            }
        }
        if let Some(path) = destination {
            self.reach(action, &path);
        }
        self.states(action);
    }

    /// A goal for each pair of neighbors of the list, or for the objects of its only mention.
    fn pairs(&mut self, action: &Action, of: impl Fn(&[usize]) -> GoalDraft, own: GoalKind) {
        let mentions = Self::mentions(&action.objects);
        if let [one] = mentions[..] {
            self.goal(GoalDraft { kind: own, ..GoalDraft::new(PredicateKind::NextTo, one) }, action);
        }
        for pair in mentions.windows(2) {
            self.goal(of(pair), action);
        }
    }

    /// "a tower", "one stack" at `at`; the position after it.
    fn tower_at(&self, at: usize) -> Option<usize> {
        let mut p = at;
        while matches!(
            self.word_at(p),
            Some("a" | "an" | "one" | "the" | "single" | "tall" | "high" | "small" | "neat")
        ) {
            p += 1;
        }
        matches!(self.word_at(p), Some("tower" | "stack")).then_some(p + 1)
    }

    /// "build a tower from three cubes", "make a stack of the books". Whether the rule applies.
    pub(super) fn builds_stack(&mut self, start: usize, p: usize) -> bool {
        let builds = matches!(self.word_at(p), Some("build" | "form" | "construct" | "assemble" | "erect"));
        if !builds && !matches!(self.word_at(p), Some("make" | "create")) {
            return false;
        }
        let Some(end) = self.tower_at(p + 1) else { return false };
        let material = ["from", "out of", "with", "using", "by stacking", "of"]
            .iter()
            .filter_map(|phrase| match_phrase(self.tokens, end, phrase))
            .max();
        let Some(length) = material else { return false };
        let Some((phrase, _)) = noun_phrase(self.lexicon, self.tokens, end + length) else { return false };
        // "make a stack of three books" asks for a scene.
        let is_made = builds
            || phrase.determiner == Determiner::Definite
            || matches!(phrase.head, Head::Them)
            || self.word_at(end) != Some("of");
        if !is_made || phrase.is_table() {
            return false;
        }
        self.parsed.account.used(start..end + length);
        self.instructed = true;
        self.clause_start = false;
        self.act_on(Frame::Stack, p..end, end + length, Vec::new());
        self.parsed.instructions.push(start..self.at);
        self.subject.clear();
        true
    }

    /// "use the cubes to build a tower" after its tools.
    pub(super) fn tools_form_stack(&mut self, tools: &[usize]) -> bool {
        let builds = matches!(self.word(1), Some("build" | "make" | "form" | "construct" | "create"));
        if self.word(0) != Some("to") || !builds {
            return false;
        }
        let Some(end) = self.tower_at(self.at + 2) else { return false };
        let mut action = self.new_action(Frame::Stack, self.at + 1..end);
        action.objects = tools.iter().map(|&mention| Part { mention, take: None }).collect();
        self.parsed.account.used(self.at..end);
        self.at = end;
        self.conclude(action);
        true
    }
}
