//! Instructions as goals over the objects of a finished scene.
//!
//! [`language::task`] reads the statements of an instruction; [`editing::references`] finds the objects that their
//! phrases mean. Nothing is ignored: what neither understands is refused. So are verbs that ask for more than a goal
//! states ([`PERFORMED`]).
//!
//! Cost: that of the references, a few passes over the words and objects.

mod function_words;
mod statements;
mod unstated;
mod verb_check;
mod words;

use scene::TaskProgram;
use scene::request::Input;

pub use language::performed::PERFORMED;

use crate::goal::Goal;
use crate::refusal::Refusal;
use crate::stacks::chained;
use crate::task::Task;
use crate::task_scene::TaskScene;
use verb_check::require_performed;

/// The goal of an instruction, over the objects of the scene.
///
/// # Errors
///
/// [`Refusal`] for a verb that is not performed, without a goal, for parts that are not understood, and for phrases
/// that do not say which objects of the scene they mean.
pub fn goal(instruction: &str, scene: &TaskScene) -> Result<Goal, Refusal> {
    statements::goal(&statements::program(instruction, scene)?, scene)
}

/// The task of a program that a language model read from an instruction.
///
/// # Errors
///
/// [`Refusal`] for phrases that do not say which objects of the scene they mean.
pub fn task_of_program(
    instruction: &str,
    program: &TaskProgram,
    scene: &TaskScene,
    robot: &str,
) -> Result<Task, Refusal> {
    Ok(Task::new(instruction.trim(), statements::goal(program, scene)?, robot))
}

/// As [`goal`], as a task with the usual limits.
///
/// # Errors
///
/// As for [`goal`].
pub fn task(instruction: &str, scene: &TaskScene, robot: &str) -> Result<Task, Refusal> {
    Ok(Task::new(instruction.trim(), goal(instruction, scene)?, robot))
}

/// The task of a scene whose request was an instruction; `None` if it was none, if a verb of it is not performed, or if
/// its goal needs an object that the scene does not have.
pub fn own_task(scene: &scene::Scene, robot: &str) -> Option<Task> {
    let account = scene.text.as_ref()?;
    let goal = account.goal.as_ref()?;
    let (text, understood) = match &scene.request.input {
        Input::Text { text } | Input::Image { text: Some(text), .. } => (text, account.understood.as_slice()),
        // An edit has the account of its parent's text, and not the text.
        _ => (&goal.instruction, &[][..]),
    };
    require_performed(text, understood, &goal.predicates).ok()?;
    let is_present = |name: &scene::InstanceId| scene.instances.iter().any(|object| &object.name == name);
    let complete = goal.predicates.iter().flat_map(crate::goal::named).all(is_present);
    let predicates = Goal::new(chained(goal.predicates.clone())).ok().filter(|_| complete)?;
    Some(Task::new(goal.instruction.clone(), predicates, robot))
}
