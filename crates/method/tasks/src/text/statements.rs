//! Statements of an instruction, over the objects of the scene.

use editing::references::{ReferenceError, SceneReferents, resolve};
use language::performed::PERFORMED;
use language::task::{TaskError, read};
use scene::text_account::{GoalPredicate, PredicateKind};
use scene::{StatedGoal, TaskProgram};

use crate::goal::Goal;
use crate::refusal::Refusal;
use crate::stacks::chained;
use crate::task_scene::TaskScene;

pub(super) fn program(instruction: &str, scene: &TaskScene) -> Result<TaskProgram, Refusal> {
    Ok(read(instruction, &SceneReferents(scene.described()))?)
}

/// The goal of a program, over the objects of the scene.
pub(super) fn goal(program: &TaskProgram, scene: &TaskScene) -> Result<Goal, Refusal> {
    let mut predicates = Vec::new();
    for statement in program.meanings() {
        predicates.extend(over_scene(statement, scene)?);
    }
    Goal::new(chained(predicates)).map_err(|_| Refusal::NoGoal)
}

impl From<TaskError> for Refusal {
    fn from(error: TaskError) -> Self {
        match error {
            TaskError::Verb(verb) => Self::VerbNotPerformed { verb, performed: PERFORMED.to_owned() },
            TaskError::Parts(parts) => Self::InstructionNotUnderstood { parts },
            TaskError::NoGoal => Self::NoGoal,
        }
    }
}

/// Indices of the objects that a phrase means.
fn objects(scene: &TaskScene, phrase: &str) -> Result<Vec<usize>, Refusal> {
    resolve(scene.described(), phrase).map_err(|error| match error {
        ReferenceError::NotFound { phrase, candidates } => Refusal::AbsentObject { phrase, candidates },
        ReferenceError::TooFew { phrase, found, .. } => Refusal::AbsentObject { phrase, candidates: found },
        ReferenceError::Ambiguous { phrase, candidates } => {
            Refusal::AmbiguousReference { phrase, candidates }
        }
        ReferenceError::NotUnderstood { phrase, words } => Refusal::ReferenceNotUnderstood { phrase, words },
    })
}

/// The predicates of a statement. Several objects share one target; as many targets as objects are one for each, in
/// order.
fn over_scene(statement: &StatedGoal, scene: &TaskScene) -> Result<Vec<GoalPredicate>, Refusal> {
    let name = |index: usize| scene.posed()[index].name.clone();
    let predicate = |object: usize, target: Option<usize>, second: Option<usize>| GoalPredicate {
        predicate: statement.predicate,
        object: name(object),
        target: target.map(name),
        second_target: second.map(name),
    };
    let subjects = objects(scene, &statement.object)?;
    let Some(phrase) = &statement.target else {
        return Ok(match statement.predicate {
            PredicateKind::Swapped => match subjects[..] {
                [first, second] => vec![predicate(first, Some(second), None)],
                _ => return Err(ambiguous(scene, &statement.object, &subjects)),
            },
            PredicateKind::StackedOn => {
                subjects.windows(2).map(|pair| predicate(pair[1], Some(pair[0]), None)).collect()
            }
            // "take the book from the pile": off what carries it.
            PredicateKind::Off => subjects
                .iter()
                .map(|&object| predicate(object, scene.described()[object].supporter.parent, None))
                .collect(),
            _ => subjects.iter().map(|&object| predicate(object, None, None)).collect(),
        });
    };
    let targets = objects(scene, phrase)?;
    let seconds = statement.second_target.as_ref().map(|phrase| objects(scene, phrase)).transpose()?;
    let second = seconds.as_ref().and_then(|seconds| seconds.first().copied());
    let one_each = targets.len() == subjects.len();
    if targets.len() > 1 && !one_each {
        return Err(ambiguous(scene, phrase, &targets));
    }
    let pairs = subjects.iter().enumerate().map(|(turn, &object)| {
        predicate(object, Some(if one_each { targets[turn] } else { targets[0] }), second)
    });
    let of_others: Vec<GoalPredicate> =
        pairs.filter(|predicate| predicate.target.as_ref() != Some(&predicate.object)).collect();
    // "put the mug next to the mug"
    let parts = vec![format!("{} ... {phrase}", statement.object)];
    if of_others.is_empty() { Err(Refusal::InstructionNotUnderstood { parts }) } else { Ok(of_others) }
}

fn ambiguous(scene: &TaskScene, phrase: &str, found: &[usize]) -> Refusal {
    let candidates = found.iter().map(|&index| scene.posed()[index].name.clone()).collect();
    Refusal::AmbiguousReference { phrase: phrase.to_owned(), candidates }
}
