//! Goals of instructions for a robot: "take the spoon out of the mug and put it on the tray".
//!
//! A goal is the state at the end, so that only verbs are read that ask for nothing else. Objects stay phrases as
//! written, which are resolved by who knows the scene. Nothing is dropped: what no goal states is refused.

use std::ops::Range;

use scene::program::{Program, Statement};
use scene::text_account::PredicateKind;
use scene::{EditOperation, EditPlace, RelationKind, StatedGoal, TaskProgram};

use crate::chart::{Chart, Referents};
use crate::clause::Clause;
use crate::construction::Act;
use crate::edit::InstructionError;
use crate::edit::fold::{Fold, Step, asides};
use crate::lexicon::lexicon;
use crate::nominal::{NounPhrase, Reference};
use crate::performed::is_performed;
use crate::reading::{Reading, tasks_of};
use crate::vocabulary::vocabulary;

/// Reason why an instruction states no goal.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum TaskError {
    /// A verb that the robot does not perform.
    Verb(String),
    /// Parts that no goal states.
    Parts(Vec<String>),
    NoGoal,
}

/// The goal of an instruction, in its order; at least one statement, each with the words of its clause.
///
/// # Errors
///
/// [`TaskError`] for a verb that is not performed, for parts that no goal states, and without a goal.
pub fn read(text: &str, referents: &dyn Referents) -> Result<TaskProgram, TaskError> {
    let (chart, reading) = tasks_of(text, referents);
    require_verbs(&chart, &reading)?;
    let part = |range: &Range<usize>| TaskError::Parts(vec![chart.written(range.clone())]);
    let mut fold = Fold::new(&chart, true);
    for clause in &reading.clauses {
        let is_read = !matches!(clause.act, Act::Condition | Act::Question | Act::Negation);
        if !is_read {
            return Err(part(&(clause.start..clause.end)));
        }
        fold.carry_out(clause).map_err(|error: InstructionError| TaskError::Parts(vec![error.words]))?;
    }
    let mut goal = Vec::new();
    for (index, (step, clause)) in fold.steps.iter().zip(&fold.clauses).enumerate() {
        if !is_superseded(step, &fold.steps[index + 1..]) {
            let stated = statements(step).ok_or_else(|| part(clause))?;
            let words = || chart.quoted(clause.clone());
            goal.extend(stated.into_iter().map(|meaning| Statement { words: words(), meaning }));
        }
    }
    if goal.is_empty() {
        Err(TaskError::NoGoal)
    } else {
        Ok(Program { statements: goal, asides: asides(&chart, &reading) })
    }
}

/// Whether a later step says where the object goes.
fn is_superseded(step: &Step, later: &[Step]) -> bool {
    let (Step::Lift { target } | Step::TakeOut { target, .. }) = step else { return false };
    later.iter().any(|step| match step {
        Step::Operation(EditOperation::Move { target: moved, .. }) => {
            moved == target
                || moved.starts_with(&format!("{target} "))
                || target.starts_with(&format!("{moved} "))
        }
        _ => false,
    })
}

/// The statements of a step; `None` where no goal states it.
fn statements(step: &Step) -> Option<Vec<StatedGoal>> {
    let of = |predicate, object: &str, target: Option<&str>| StatedGoal {
        predicate,
        object: object.to_owned(),
        target: target.map(str::to_owned),
        second_target: None,
    };
    Some(match step {
        Step::Lift { target } => vec![of(PredicateKind::Lifted, target, None)],
        Step::TakeOut { target, carrier, is_inside } => {
            let predicate = if *is_inside { PredicateKind::OutOf } else { PredicateKind::Off };
            vec![of(
                predicate,
                target,
                Some(carrier).filter(|carrier| !carrier.is_empty()).map(String::as_str),
            )]
        }
        Step::Clear { carrier, is_inside } => {
            let (predicate, word) =
                if *is_inside { (PredicateKind::OutOf, "in") } else { (PredicateKind::Off, "on") };
            vec![of(predicate, &format!("everything {word} {carrier}"), Some(carrier))]
        }
        Step::Pose { target, act } => {
            let predicate = match act {
                Act::Topple => PredicateKind::UpsideDown,
                Act::LayOnSide => PredicateKind::LyingOnSide,
                Act::Turn => PredicateKind::Rotated,
                _ => PredicateKind::Upright,
            };
            vec![of(predicate, target, None)]
        }
        Step::Away { target, landmark } => vec![of(PredicateKind::AwayFrom, target, Some(landmark))],
        Step::Operation(EditOperation::Move { target, place }) => vec![placed(target, place)?],
        Step::Operation(EditOperation::Swap { targets }) => {
            vec![of(PredicateKind::Swapped, targets.first()?, targets.get(1).map(String::as_str))]
        }
        Step::Operation(EditOperation::Stack { targets }) => match targets.as_slice() {
            [all] => vec![of(PredicateKind::StackedOn, all, None)],
            several => several
                .windows(2)
                .map(|pair| of(PredicateKind::StackedOn, &pair[1], Some(&pair[0])))
                .collect(),
        },
        Step::Operation(_) => return None,
    })
}

/// A place as a predicate; `None` for distances, displacements and yaws.
fn placed(object: &str, place: &EditPlace) -> Option<StatedGoal> {
    use {PredicateKind as P, RelationKind as R};
    if place.distance_m.is_some() || place.yaw_rad.is_some() {
        return None;
    }
    let predicate = match place.relation? {
        R::On => P::On,
        R::In => P::In,
        R::LeftOf => P::LeftOf,
        R::RightOf => P::RightOf,
        R::InFrontOf => P::InFrontOf,
        R::Behind => P::Behind,
        R::NextTo => P::NextTo,
        R::Between => P::Between,
        R::AtCenter => P::AtCenter,
        R::AtBack | R::FromBackEdge => P::AtBack,
        R::AtFront | R::FromFrontEdge => P::AtFront,
        R::AtLeft | R::FromLeftEdge => P::AtLeft,
        R::AtRight | R::FromRightEdge => P::AtRight,
        R::AtBackLeft => P::AtBackLeft,
        R::AtBackRight => P::AtBackRight,
        R::AtFrontLeft => P::AtFrontLeft,
        R::AtFrontRight => P::AtFrontRight,
        _ => return None,
    };
    let (target, second_target) = (place.target.clone(), place.second_target.clone());
    Some(StatedGoal { predicate, object: object.to_owned(), target, second_target })
}

/// Persons, and arms of the robot: nothing is handed to them.
const RECIPIENTS: &[&str] = &[
    "me",
    "us",
    "him",
    "her",
    "someone",
    "somebody",
    "person",
    "user",
    "man",
    "woman",
    "child",
    "boy",
    "girl",
    "guest",
    "customer",
    "operator",
    "friend",
    "colleague",
    "mother",
    "father",
    "sister",
    "brother",
    "patient",
    "arm",
    "arms",
    "hand",
    "hands",
    "gripper",
    "grippers",
    "palm",
    "manipulator",
    "other",
];

/// Checks that every verb is performed, and that nothing is left unread.
fn require_verbs(chart: &Chart, reading: &Reading) -> Result<(), TaskError> {
    for clause in &reading.clauses {
        // "without touching the vase" asks for no motion.
        let verbs = if clause.act == Act::Keep { &[][..] } else { clause.verbs.as_slice() };
        for &verb in verbs {
            if !is_performed(chart.word(verb)) {
                return Err(TaskError::Verb(chart.word(verb).to_owned()));
            }
        }
        // "crack apple into box": without a determiner the first word may be a verb.
        if clause.verbs.is_empty() && is_bare(chart, clause) {
            // "pour tea into the plate": the word before it is the verb.
            let before = reading.unread.iter().find(|range| range.end == clause.start);
            let verb = before.map_or(clause.start, |range| range.start);
            return Err(TaskError::Verb(chart.word(verb).to_owned()));
        }
        // "put the apple in the box and shake the box"
        let mut named = clause.fillers.iter().flat_map(|(_, filler)| filler.phrases());
        let is_absent = |phrase: &&NounPhrase| {
            phrase.reference == Reference::Indefinite
                && phrase.tokens.start == phrase.body.start
                && phrase.tokens.start > clause.start
                && chart.resolves(&phrase.tokens) == Some(false)
        };
        if let Some(verb) = named.find(is_absent) {
            return Err(TaskError::Verb(chart.word(verb.tokens.start).to_owned()));
        }
        if let Some(recipient) = recipient(chart, clause.start..clause.end) {
            return Err(TaskError::Verb(recipient));
        }
    }
    let Some(first) = reading.unread.first() else { return Ok(()) };
    for range in &reading.unread {
        if let Some(verb) = verb_of(chart, range) {
            return Err(TaskError::Verb(verb));
        }
    }
    let has_clauses = !reading.clauses.is_empty();
    let parts = reading.unread.iter().map(|range| chart.written(range.clone())).collect();
    let is_list = !has_clauses
        && first.start == 0
        && chart.lists_at(0).iter().any(|span| span.end == chart.tokens.len());
    Err(if is_list { TaskError::NoGoal } else { TaskError::Parts(parts) })
}

/// Whether a clause without a verb begins with a word that is no determiner, number or name.
fn is_bare(chart: &Chart, clause: &Clause) -> bool {
    let phrases = clause.objects("");
    !clause.is_elliptic
        && matches!(clause.act, Act::Put)
        && phrases.first().is_some_and(|phrase| {
            phrase.tokens.start == clause.start
                && phrase.tokens.start == phrase.body.start
                && !vocabulary().is_color(chart.word(clause.start))
                && chart.longest("adjective", clause.start).is_none()
                && chart.resolves(&phrase.tokens) != Some(true)
        })
}

/// The word for a person or an arm that a clause hands something to.
fn recipient(chart: &Chart, range: Range<usize>) -> Option<String> {
    let is_recipient = |at: &usize| {
        let word = chart.word(*at);
        // "the left-hand cup"
        let is_side = matches!(chart.word(at.saturating_sub(1)), "left" | "right")
            && chart.referents.is_noun(chart.word(at + 1));
        !is_side && RECIPIENTS.contains(&word) && word != "other"
    };
    range
        .clone()
        .find(|at| is_recipient(at) && chart.resolves(&(*at..*at + 1)) != Some(true))
        .map(|at| chart.word(at).to_owned())
}

/// A verb among words that are part of nothing: the first word of a clause, a form in -ing, what is done to an object.
fn verb_of(chart: &Chart, range: &Range<usize>) -> Option<String> {
    let starts_clause = range.start == 0 || {
        let before = chart.word(range.start - 1);
        matches!(
            before,
            "." | ","
                | "and"
                | "then"
                | "please"
                | "to"
                | "you"
                | "should"
                | "robot"
                | "but"
                | "gripper"
                | "or"
                | "mind"
        )
    };
    let first = chart.word(range.start);
    let is_known =
        |word: &str| lexicon().is_function_word(word) || chart.longest("condition", range.start).is_some();
    let opens_phrase =
        ["definite", "indefinite", "all"].iter().any(|class| chart.longest(class, range.start).is_some());
    if starts_clause
        && !opens_phrase
        && !is_known(first)
        && !is_performed(first)
        && chart.lengths("closing", range.start).is_empty()
    {
        return Some(first.to_owned());
    }
    // "switch the lamp off", "by throwing it"
    if matches!(first, "off" | "open" | "shut" | "closed")
        || chart.word(range.start.saturating_sub(1)) == "by"
    {
        return Some(first.to_owned());
    }
    for at in range.clone() {
        let word = chart.word(at);
        if RECIPIENTS.contains(&word) && word != "other" {
            return Some(word.to_owned());
        }
        let described = at > range.start
            && ["definite", "indefinite"].iter().any(|class| chart.lengths(class, at - 1).contains(&1));
        let is_form =
            word.ends_with("ing") || ["be", "been", "being"].contains(&chart.word(at.saturating_sub(1)));
        if is_form
            && !described
            && !is_performed(word)
            && !chart.referents.is_noun(word)
            && !lexicon().is_function_word(word)
        {
            return Some(word.to_owned());
        }
    }
    None
}
