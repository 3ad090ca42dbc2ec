//! Clauses that say for which other objects the clause before holds, and for which it does not.

use scene::EditOperation;

use super::discourse::Changes;
use super::error::Reason;
use super::fold::{Fold, Outcome, Step};
use crate::clause::Clause;
use crate::nominal::{NounPhrase, Reference};

impl Fold<'_, '_> {
    /// The operation before, for other objects too.
    pub fn likewise(&mut self, clause: &Clause) -> Outcome<()> {
        // "a bit greener" is no object.
        let is_named =
            |phrase: &NounPhrase| phrase.reference != Reference::Indefinite || phrase.noun.starts_with("one");
        if !clause.objects("").iter().all(is_named) {
            return self.refuse(Reason::NotUnderstood("say what should change, one change at a time"));
        }
        let targets = self.targets(clause.objects(""))?;
        let Some(last) = self.steps.last().cloned() else { return self.refuse(Reason::Empty) };
        for target in &targets {
            let mut step = last.clone();
            let Some(phrase) = target_of(&mut step) else {
                return self.refuse(Reason::NotUnderstood("say what should change"));
            };
            target.phrase.clone_into(phrase);
            self.push_step(step);
        }
        self.now_about(targets, Changes::Nothing);
        Ok(())
    }

    /// The objects of the operation before, without these.
    pub fn except(&mut self, clause: &Clause) -> Outcome<()> {
        let excluded = self.targets(clause.objects(""))?;
        let Some((target, is_plural)) = self.steps.last_mut().and_then(target_of).map(|target| {
            let is_plural = self.discourse.topic.as_ref().is_some_and(|topic| topic.is_plural);
            (target, is_plural)
        }) else {
            return self.refuse(Reason::NotUnderstood("say of which objects these are excepted"));
        };
        if !is_plural {
            return self.refuse(Reason::NotUnderstood("say of which objects these are excepted"));
        }
        let phrases: Vec<String> = excluded.iter().map(|target| target.phrase.clone()).collect();
        *target = format!("{target} except {}", phrases.join(" and "));
        let target = target.clone();
        if let Some(topic) = &mut self.discourse.topic {
            topic.phrases = vec![target];
        }
        self.discourse.kept.extend(phrases);
        Ok(())
    }
}

/// The one phrase for the objects of an operation.
fn target_of(step: &mut Step) -> Option<&mut String> {
    let Step::Operation(operation) = step else { return None };
    match operation {
        EditOperation::Move { target, .. }
        | EditOperation::Remove { target, .. }
        | EditOperation::Recolor { target, .. }
        | EditOperation::Resize { target, .. }
        | EditOperation::Rotate { target, .. }
        | EditOperation::Replace { target, .. } => Some(target),
        EditOperation::Stack { targets } | EditOperation::Arrange { targets, .. } => {
            match targets.as_mut_slice() {
                [only] => Some(only),
                _ => None,
            }
        }
        _ => None,
    }
}
