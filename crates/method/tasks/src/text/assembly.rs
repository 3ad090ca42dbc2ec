//! The goal of a description, over the objects of the scene.

use std::collections::BTreeMap;
use std::collections::btree_map::Entry;
use std::ops::Range;

use editing::references::resolve;
use scene::text_account::{GoalPredicate, TextMeaning, UnrecognizedReason};
use scene::{InstanceId, SceneDescription};

use super::Reading;
use super::noun_phrases::{NounPhrase, noun_phrases};
use super::performed::{States, states};
use super::resolution::{Resolved, resolved};
use super::verb_check::require_performed;
use super::words::words;
use crate::goal::Goal;
use crate::refusal::Refusal;
use crate::stacks::chained;

/// Phrases of the goal's objects, resolved.
struct Referents<'a> {
    phrases: &'a [NounPhrase],
    /// By index of the phrase.
    resolved: BTreeMap<usize, Resolved>,
    /// The phrase of each object of the description.
    phrase_of: BTreeMap<InstanceId, usize>,
}

pub(super) fn goal(reading: &Reading, description: &SceneDescription) -> Result<Goal, Refusal> {
    let unread = |parts: Vec<String>| Refusal::InstructionNotUnderstood { parts };
    let stated = description.goal.as_ref().map_or(&[][..], |goal| &goal.predicates);
    require_performed(reading.text(), &description.understood, stated)?;
    let Some(goal) = &description.goal else {
        let parts: Vec<String> = description.unrecognized.iter().map(|part| part.span.text.clone()).collect();
        return Err(if parts.is_empty() { Refusal::NoGoal } else { unread(parts) });
    };
    let mut phrases = noun_phrases(reading.text(), description);
    let contents = joined_contents(reading, &mut phrases);
    let is_contents = |predicate: &&GoalPredicate| !contents.contains(&predicate.object);
    let stated: Vec<GoalPredicate> = goal.predicates.iter().filter(is_contents).cloned().collect();
    let phrase_of = assigned(description, &stated, &phrases)?;
    let mut referents = Referents { phrases: &phrases, resolved: BTreeMap::new(), phrase_of };
    let used: Vec<usize> = referents.phrase_of.values().copied().collect();
    for phrase in used {
        if let Entry::Vacant(vacant) = referents.resolved.entry(phrase) {
            vacant.insert(resolved(reading, description, &phrases, phrase)?);
        }
    }
    let parts = not_understood(description, &referents);
    if !parts.is_empty() {
        return Err(unread(parts));
    }
    let mut predicates = Vec::new();
    for predicate in &stated {
        predicates.extend(referents.over_scene(predicate, reading)?);
    }
    Goal::new(chained(predicates)).map_err(|_| Refusal::NoGoal)
}

/// "put the cup with the spoon on the tray": where the spoon tells which cup is meant, it belongs to the phrase of the
/// cup and is moved along. The objects of such contents.
fn joined_contents(reading: &Reading, phrases: &mut [NounPhrase]) -> Vec<InstanceId> {
    let mut joined = Vec::new();
    for index in 0..phrases.len() {
        let Some(contents) = phrases[index].contents else { continue };
        let end = phrases[contents].end;
        let words = &reading.text()[phrases[index].start..end];
        if resolve(reading.scene.described(), words).is_ok() {
            phrases[index].end = end;
            joined.extend(phrases[contents].objects.iter().cloned());
        }
    }
    joined
}

/// The phrase of each object of the goal. The first phrase that names it is its own; an object without one has the last
/// phrase of its category that is another object's second one ("the first mug next to the second mug").
fn assigned(
    description: &SceneDescription,
    predicates: &[GoalPredicate],
    phrases: &[NounPhrase],
) -> Result<BTreeMap<InstanceId, usize>, Refusal> {
    let mut assigned: BTreeMap<InstanceId, usize> = BTreeMap::new();
    for object in predicates.iter().flat_map(crate::goal::named) {
        if let Some(first) = phrases.iter().position(|phrase| phrase.objects.contains(object)) {
            assigned.entry(object.clone()).or_insert(first);
        }
    }
    let category = |name: &InstanceId| {
        description.objects.iter().find(|spec| spec.id == *name).map(|spec| spec.category.as_str())
    };
    for object in predicates.iter().flat_map(crate::goal::named) {
        if assigned.contains_key(object) {
            continue;
        }
        let alike = |phrase: &NounPhrase| {
            phrase
                .objects
                .iter()
                .any(|other| category(other).is_some() && category(other) == category(object))
        };
        let free = (0..phrases.len())
            .rev()
            .find(|index| alike(&phrases[*index]) && !assigned.values().any(|taken| taken == index));
        let Some(free) = free else {
            return Err(Refusal::ReferenceNotUnderstood {
                phrase: object.to_string(),
                words: vec![object.to_string()],
            });
        };
        assigned.insert(object.clone(), free);
    }
    Ok(assigned)
}

/// Parts that neither the parser nor a reference understands.
fn not_understood(description: &SceneDescription, referents: &Referents) -> Vec<String> {
    let is_within = |bytes: &Range<usize>, start: usize, end: usize| bytes.start <= start && end <= bytes.end;
    let is_referred = |start: usize, end: usize| {
        referents.resolved.values().any(|resolved| is_within(&resolved.bytes, start, end))
    };
    // A goal whose start state the meshes do not show is a goal nevertheless.
    let is_goal = |start: usize| {
        let goals = description.understood.iter();
        goals
            .filter(|part| matches!(part.meaning, TextMeaning::Goal { .. }))
            .any(|part| part.span.start == start)
    };
    let unread = description.unrecognized.iter().filter(|part| {
        let benign = match part.reason {
            UnrecognizedReason::NotInImage | UnrecognizedReason::ShownByImage => true,
            UnrecognizedReason::NotSupported => is_goal(part.span.start),
            _ => false,
        };
        // "find the mug and put it on the plate".
        let is_step = words(&part.span.text).iter().all(|word| states(&word.text) == Some(States::Nothing));
        !benign && !is_step && !is_referred(part.span.start, part.span.end)
    });
    unread.map(|part| part.span.text.clone()).collect()
}

impl Referents<'_> {
    fn indices(&self, object: &InstanceId) -> &[usize] {
        let phrase = self.phrase_of.get(object).and_then(|phrase| self.resolved.get(phrase));
        phrase.map_or(&[], |resolved| &resolved.indices)
    }

    /// Position of an object of the description among those of its phrase, and their number.
    fn position(&self, object: &InstanceId) -> (usize, usize) {
        let objects = self.phrase_of.get(object).map_or(&[][..], |phrase| &self.phrases[*phrase].objects);
        let position = objects.iter().position(|other| other == object).unwrap_or_default();
        (position, objects.len().max(1))
    }

    /// The predicate over objects of the scene. Where a phrase means as many objects as the description has, each
    /// stands for one; else the predicate holds for all that it means, and stacks are chains of them.
    fn over_scene(
        &self,
        predicate: &GoalPredicate,
        reading: &Reading,
    ) -> Result<Vec<GoalPredicate>, Refusal> {
        let name = |index: usize| reading.scene.posed()[index].name.clone();
        let objects = self.indices(&predicate.object);
        let (at, described) = self.position(&predicate.object);
        let one_to_one = objects.len() == described;
        let same_phrase = predicate
            .target
            .as_ref()
            .is_some_and(|target| self.phrase_of.get(target) == self.phrase_of.get(&predicate.object));
        let build = |object: usize, target: Option<usize>, second: Option<usize>| GoalPredicate {
            predicate: predicate.predicate,
            object: name(object),
            target: target.map(name),
            second_target: second.map(name),
        };
        if same_phrase && !one_to_one {
            let chain = objects.windows(2).map(|pair| build(pair[1], Some(pair[0]), None));
            return Ok(chain.collect());
        }
        let subjects: Vec<usize> = if one_to_one { vec![objects[at]] } else { objects.to_vec() };
        let other = |target: &Option<InstanceId>, turn: usize| -> Option<usize> {
            let target = target.as_ref()?;
            let (indices, (position, described)) = (self.indices(target), self.position(target));
            let at = if indices.len() == described { position } else { turn };
            indices.get(at % indices.len().max(1)).copied()
        };
        let predicates = subjects.iter().enumerate().filter_map(|(turn, &object)| {
            let (target, second) = (other(&predicate.target, turn), self.second(predicate, turn, &other));
            (target != Some(object)).then(|| build(object, target, second))
        });
        Ok(predicates.collect())
    }

    /// The second target; "between the two plates" means both of one phrase.
    fn second(
        &self,
        predicate: &GoalPredicate,
        turn: usize,
        other: &dyn Fn(&Option<InstanceId>, usize) -> Option<usize>,
    ) -> Option<usize> {
        let second = predicate.second_target.as_ref()?;
        let same = predicate.target.as_ref().and_then(|target| self.phrase_of.get(target))
            == self.phrase_of.get(second);
        if same { self.indices(second).get(1).copied() } else { other(&predicate.second_target, turn) }
    }
}
