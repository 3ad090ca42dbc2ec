//! Instructions as goals over the objects of a finished scene.
//!
//! The text parser (or another analyst) describes the start state and goal of an instruction with objects of its own.
//! [`Reading`] prepares the text for it and then replaces these objects by those of the scene: each has a noun phrase
//! in the text, which [`editing::references`] resolves. An object may also be called by its name. Nothing is ignored:
//! parts that neither the parser nor the references understand are refused, and so are verbs that ask for more than a
//! goal states ([`PERFORMED`]).
//!
//! Cost: that of the references, a few passes over the words and objects.

mod assembly;
mod ellipsis;
mod function_words;
mod names;
mod noun_phrases;
mod performed;
mod resolution;
mod unstated;
mod verb_check;
mod words;

use std::ops::Range;

use scene::SceneDescription;
use scene::request::Input;

pub use performed::PERFORMED;

use crate::goal::Goal;
use crate::refusal::Refusal;
use crate::stacks::chained;
use crate::task::Task;
use crate::task_scene::TaskScene;
use verb_check::require_performed;

/// An instruction, ready for the analyst.
pub struct Reading<'a> {
    scene: &'a TaskScene,
    instruction: &'a str,
    /// As the analyst reads it: without names of objects and without the ellipses that it does not complete.
    text: String,
    /// Bytes of `text` that stand for an object by its name.
    named: Vec<(Range<usize>, usize)>,
}

impl<'a> Reading<'a> {
    /// Prepares an instruction.
    pub fn new(instruction: &'a str, scene: &'a TaskScene) -> Self {
        let completed = ellipsis::completed(instruction);
        let (text, named) = names::replaced(&completed, scene.described());
        Self { scene, instruction, text, named }
    }

    /// The text to describe.
    pub fn text(&self) -> &str {
        &self.text
    }

    /// The goal of the description of [`Reading::text`], over the objects of the scene.
    ///
    /// # Errors
    ///
    /// [`Refusal`] for a verb that is not performed, without a goal, for parts that are not understood, and for phrases
    /// that do not say which objects of the scene they mean.
    pub fn goal(&self, description: &SceneDescription) -> Result<Goal, Refusal> {
        assembly::goal(self, description)
    }

    /// As [`Reading::goal`], as a task with the usual limits.
    ///
    /// # Errors
    ///
    /// As for [`Reading::goal`].
    pub fn task(&self, description: &SceneDescription, robot: &str) -> Result<Task, Refusal> {
        Ok(Task::new(self.instruction.trim(), self.goal(description)?, robot))
    }
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
