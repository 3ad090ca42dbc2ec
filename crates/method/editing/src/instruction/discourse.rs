//! Meaning of pronouns, and the order of operations on the same objects.
//!
//! "It" and "them" stand for the objects that the last command changed or made. A phrase may cease to fit by a change:
//! after "move the leftmost book to the right edge", another book is leftmost. An operation on "it" then precedes that
//! change, which gives the same scene; where the order matters, the instruction is refused.

use super::Reason;
use super::cursor::{Cursor, Outcome};
use super::nouns::{has_color_or_material, has_place, has_size, noun_of};
use scene::{EditOperation, EditPlace, RelationKind};

/// The objects that pronouns stand for.
#[derive(Clone, Debug)]
pub(super) struct Topic {
    pub phrases: Vec<String>,
    pub plural: bool,
    /// Indices of the operations that make them, if they are new.
    pub made_at: Vec<usize>,
    /// The first operation after which the phrases may no longer fit.
    pub changed_at: Option<usize>,
    pub removed: bool,
}

/// Content of earlier clauses.
#[derive(Default)]
pub(super) struct Discourse {
    pub topic: Option<Topic>,
    /// The relation and the object of the last place.
    pub landmark: Option<(RelationKind, String)>,
    pub place: Option<EditPlace>,
    /// Nouns with the phrase that named their object, and whether the object was removed.
    pub mentions: Vec<(String, String, bool)>,
}

/// An object that an operation is about.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Target {
    pub phrase: String,
    pub pronoun: bool,
}

impl Discourse {
    pub fn mention(&mut self, phrase: &str, removed: bool) {
        let noun = noun_of(phrase);
        if !noun.is_empty() {
            self.mentions.retain(|(_, known, _)| known != phrase);
            self.mentions.push((noun, phrase.to_owned(), removed));
        }
    }

    /// The noun of "a blue one".
    pub fn last_noun(&self) -> Option<&str> {
        self.mentions.last().map(|(noun, ..)| noun.as_str())
    }

    /// "the other mug" as "the mug other than the red mug".
    pub fn other(&self, noun: &str) -> Option<String> {
        let (_, phrase, removed) = self.mentions.iter().rev().find(|(known, ..)| known == noun)?;
        let only = phrase == &format!("the {noun}");
        match (removed, only) {
            (true, _) => Some(format!("the {noun}")),
            (false, true) => None,
            (false, false) => Some(format!("the {noun} other than {phrase}")),
        }
    }
}

impl Cursor {
    /// Adds an operation on a target.
    pub fn change(&mut self, target: &Target, operation: EditOperation, from: usize) -> Outcome<()> {
        let stale = target.pronoun.then(|| self.discourse.topic.as_ref().and_then(|topic| topic.changed_at));
        let Some(changed_at) = stale.flatten() else {
            self.operations.push(operation);
            return Ok(());
        };
        let earlier = self.operations[changed_at].clone();
        let is_absolute = |operation: &EditOperation| match operation {
            EditOperation::Move { place, .. } => place.offset_m.is_none(),
            _ => false,
        };
        if is_absolute(&operation) && is_absolute(&earlier) && changed_at + 1 == self.operations.len() {
            self.operations[changed_at] = operation;
            return Ok(());
        }
        let same_kind = operation.name() == earlier.name();
        let depends = matches!(
            (&operation, &earlier),
            (EditOperation::Rotate { facing: Some(_), .. }, EditOperation::Move { .. })
        );
        if same_kind
            || depends
            || matches!(operation, EditOperation::Replace { .. } | EditOperation::Remove { .. })
        {
            return Err(self.error(from, self.at, Reason::Changed(target.phrase.clone())));
        }
        self.insert(changed_at, operation);
        Ok(())
    }

    /// Adds an operation before another one.
    fn insert(&mut self, index: usize, operation: EditOperation) {
        self.operations.insert(index, operation);
        if let Some(topic) = &mut self.discourse.topic {
            topic.changed_at = topic.changed_at.map(|at| at + usize::from(at >= index));
            topic.made_at.iter_mut().for_each(|at| *at += usize::from(*at >= index));
        }
    }

    /// Adds an object inside or on one that a pronoun stands for.
    pub fn add_with_pronoun(&mut self, operation: EditOperation) -> usize {
        let changed_at = self.discourse.topic.as_ref().and_then(|topic| topic.changed_at);
        let index = changed_at.unwrap_or(self.operations.len());
        self.insert(index, operation);
        index
    }

    /// Makes the objects of a command what pronouns stand for. `first` is the index of its first operation.
    pub fn now_about(&mut self, targets: &[Target], first: usize) {
        let pronoun = targets.iter().any(|target| target.pronoun);
        let last = self.operations.last().filter(|_| first < self.operations.len());
        let removed = matches!(last, Some(EditOperation::Remove { .. }));
        if !matches!(last, Some(EditOperation::Move { .. })) {
            self.discourse.landmark = None;
        }
        let phrases: Vec<String> = targets.iter().map(|target| target.phrase.clone()).collect();
        for phrase in phrases.iter().rev() {
            self.discourse.mention(phrase, removed);
        }
        let earlier = self.discourse.topic.take().filter(|_| pronoun);
        let ceases = |phrase: &String| match last {
            Some(EditOperation::Move { .. }) => has_place(phrase),
            Some(EditOperation::Recolor { .. }) => has_color_or_material(phrase),
            Some(EditOperation::Resize { .. }) => has_size(phrase),
            Some(EditOperation::Relabel { .. }) => true,
            _ => false,
        };
        let changed =
            phrases.iter().any(ceases).then_some(first.min(self.operations.len().saturating_sub(1)));
        let plural = phrases.len() > 1 || phrases.iter().any(|phrase| is_plural(phrase));
        self.discourse.topic = Some(Topic {
            plural: earlier.as_ref().map_or(plural, |topic| topic.plural),
            changed_at: earlier.as_ref().and_then(|topic| topic.changed_at).or(changed),
            made_at: earlier.map_or(Vec::new(), |topic| topic.made_at),
            phrases,
            removed,
        });
    }

    /// Makes new objects what pronouns stand for.
    pub fn now_about_new(&mut self, objects: Vec<String>, made_at: Vec<usize>, plural: bool) {
        for phrase in &objects {
            self.discourse.mention(phrase, false);
        }
        let plural = plural || objects.len() > 1;
        let topic = Topic { phrases: objects, plural, made_at, changed_at: None, removed: false };
        self.discourse.topic = Some(topic);
    }
}

/// Whether a phrase means several objects, from its first words and its last.
pub(super) fn is_plural(phrase: &str) -> bool {
    let words: Vec<&str> = phrase.split(' ').collect();
    let first = words.first().copied().unwrap_or_default().to_lowercase();
    let many = matches!(first.as_str(), "all" | "both" | "every" | "each" | "everything" | "these" | "those");
    let count =
        words.iter().take(2).any(|word| crate::references::number(word).is_some_and(|count| count > 1));
    let noun = noun_of(phrase);
    let singular = crate::references::vocabulary().singular_of(&noun);
    many || count
        || singular.is_some_and(|singular| crate::references::is_noun(&singular) && singular != noun)
}
