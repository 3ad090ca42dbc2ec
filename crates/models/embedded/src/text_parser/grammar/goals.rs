//! Goals of instructions: predicates over mentions.

use std::ops::Range;

use super::{LinkKind, Parser};
use crate::text_parser::account::Claimed;
use scene::text_account::PredicateKind;

/// A predicate of the goal over the objects of mentions.
#[derive(Clone, Debug, PartialEq)]
pub(in crate::text_parser) enum GoalKind {
    Predicate(PredicateKind),
    /// In the target if it is a container, otherwise on it, otherwise beside it.
    At,
    /// Out of the target if it is a container, otherwise off it.
    AwayFromSupport,
    /// A stack of the objects of the mention.
    StackOfItself,
    /// The objects of the mention are no longer on each other.
    UnstackOfItself,
    /// The objects of the mention are beside each other.
    Together,
    /// Each object of the mention has this relation to the next.
    InOrder(PredicateKind),
}

#[derive(Clone, Debug, PartialEq)]
pub(in crate::text_parser) struct GoalDraft {
    pub kind: GoalKind,
    pub object: usize,
    /// Only the first objects of the mention.
    pub take: Option<u32>,
    pub target: Option<usize>,
    pub second: Option<usize>,
    /// Whether an earlier step undoes it ("open the drawer, ... close it"), so that it may hold at the start.
    pub is_restored: bool,
}

impl GoalDraft {
    pub fn new(kind: PredicateKind, object: usize) -> Self {
        Self {
            kind: GoalKind::Predicate(kind),
            object,
            take: None,
            target: None,
            second: None,
            is_restored: false,
        }
    }

    pub fn to(self, target: usize) -> Self {
        Self { target: Some(target), ..self }
    }
}

impl Parser<'_, '_> {
    /// Claims words without a claim for the goals that have been stated since there were so many claims.
    pub(super) fn words_of_goals(&mut self, claims: usize, words: Vec<Range<usize>>) {
        let mut goals: Vec<usize> = Vec::new();
        for claim in self.parsed.account.claims.get(claims..).unwrap_or_default() {
            if let Claimed::Goal(index) = claim.meaning
                && !goals.contains(&index)
            {
                goals.push(index);
            }
        }
        for tokens in words {
            if self.parsed.account.is_claimed(&tokens) {
                continue;
            }
            for &index in &goals {
                self.parsed.account.claim(tokens.clone(), Claimed::Goal(index));
            }
        }
    }

    /// Whether the object is in or on another one.
    fn is_carried(&self, object: usize) -> bool {
        self.parsed.links.iter().any(|link| {
            let supports = match link.kind {
                LinkKind::Relation(kind) => kind.is_support(),
                LinkKind::With | LinkKind::At => true,
                _ => false,
            };
            link.from == object && supports
        })
    }

    /// Adds a predicate that the tokens state. Lifting an object that is then moved elsewhere is a step, not a goal.
    pub(super) fn add_goal(&mut self, goal: GoalDraft, tokens: Range<usize>) {
        let lifted = GoalKind::Predicate(PredicateKind::Lifted);
        if goal.kind == lifted && self.parsed.goals.iter().any(|known| known.object == goal.object) {
            return;
        }
        // Only the state at the end counts.
        let opposite = match goal.kind {
            GoalKind::Predicate(PredicateKind::Closed) => Some(GoalKind::Predicate(PredicateKind::Opened)),
            GoalKind::Predicate(PredicateKind::Opened) => Some(GoalKind::Predicate(PredicateKind::Closed)),
            _ => None,
        };
        let earlier = self
            .parsed
            .goals
            .iter()
            .position(|known| Some(&known.kind) == opposite.as_ref() && known.object == goal.object);
        if let Some(index) = earlier {
            self.parsed.goals[index] = GoalDraft { is_restored: true, ..goal };
            self.parsed.account.claim(tokens, Claimed::Goal(index));
            return;
        }
        // "pick up the mug and place it on the counter", on which it stands already.
        let on_table = goal.kind == GoalKind::Predicate(PredicateKind::On) && goal.target.is_none();
        let known = self.parsed.goals.iter().position(|known| {
            (known.kind == lifted || known.kind == GoalKind::Predicate(PredicateKind::AwayFrom))
                && known.object == goal.object
        });
        if let Some(index) = known.filter(|_| on_table && !self.is_carried(goal.object)) {
            self.parsed.account.claim(tokens, Claimed::Goal(index));
            return;
        }
        let step = self.parsed.goals.iter().position(|known| {
            let is_step = known.kind == lifted
                || known.kind == GoalKind::AwayFromSupport
                || matches!(
                    known.kind,
                    GoalKind::Predicate(PredicateKind::OutOf | PredicateKind::Off | PredicateKind::Moved)
                );
            let is_turned = known.kind == GoalKind::Predicate(PredicateKind::Rotated) && is_pose(&goal.kind);
            let acts = known.kind == lifted
                && matches!(
                    goal.kind,
                    GoalKind::Predicate(PredicateKind::UsedOn | PredicateKind::PouredInto)
                );
            // What is taken out of the box and put on the table has left the box.
            let on_table = goal.kind == GoalKind::Predicate(PredicateKind::On)
                && goal.target.is_none()
                && matches!(
                    known.kind,
                    GoalKind::AwayFromSupport
                        | GoalKind::Predicate(PredicateKind::OutOf | PredicateKind::Off)
                );
            (is_step && moves(&goal.kind) && !on_table || is_turned || acts)
                && known.object == goal.object
                && known.take == goal.take
        });
        if let Some(index) = step {
            self.parsed.goals[index] = goal;
            self.parsed.account.claim(tokens, Claimed::Goal(index));
            return;
        }
        if !self.parsed.goals.contains(&goal) {
            self.parsed.goals.push(goal);
        }
        self.parsed.account.claim(tokens, Claimed::Goal(self.parsed.goals.len() - 1));
    }
}

/// Whether the predicate states where the object is at the end.
fn moves(kind: &GoalKind) -> bool {
    match kind {
        GoalKind::At | GoalKind::StackOfItself | GoalKind::Together | GoalKind::InOrder(_) => true,
        GoalKind::AwayFromSupport | GoalKind::UnstackOfItself => false,
        GoalKind::Predicate(kind) => !matches!(
            kind,
            PredicateKind::Lifted
                | PredicateKind::Opened
                | PredicateKind::Closed
                | PredicateKind::Pressed
                | PredicateKind::UsedOn
                | PredicateKind::PouredInto
                | PredicateKind::Off
                | PredicateKind::OutOf
        ),
    }
}

/// Whether the predicate states how the object lies at the end.
fn is_pose(kind: &GoalKind) -> bool {
    use PredicateKind::{LyingOnSide, Upright, UpsideDown};
    matches!(kind, GoalKind::Predicate(Upright | UpsideDown | LyingOnSide))
}
