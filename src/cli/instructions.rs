//! Instructions of the command line, as the configured analyst reads them: an edit, or tasks for a robot. Calls of
//! remote models may cost the usual budget of a scene.

use super::{Failure, block_on};
use crate::app::edit_scene::EditOrder;
use crate::app::executions::TaskSource;
use crate::app::instructions::{InstructedScene, Reading, objects_of};
use crate::app::remote::Remote;
use crate::app::{App, cpu_pool};
use crate::config::Resolved;
use crate::problem::Problem;

/// The use cases with the configured reader, and its budget.
fn reading(resolved: &Resolved) -> Result<(App, Reading), Failure> {
    let app = App::reading_with(resolved, &Remote::load(resolved)?);
    let cpu = cpu_pool(&resolved.config).map_err(|error| Failure::usage(error.chain()))?;
    Ok((app, Reading::of_command(cpu, resolved.config.server.usual_budget_usd)))
}

/// Reads the instruction of an order, where it has one, beside the objects of the scene in an archive.
///
/// # Errors
///
/// A [`Failure`] for settings that will not do, and for an instruction that is not understood.
pub fn read_edit(
    resolved: &Resolved,
    archive: &[u8],
    order: &mut EditOrder,
    refusal: impl Fn(Problem) -> Failure,
) -> Result<(), Failure> {
    if order.text.is_none() {
        return Ok(());
    }
    let (app, reading) = reading(resolved)?;
    let Some(text) = app.instruction_of(order) else { return Ok(()) };
    let read = app.read_edit(text, objects_of(archive), &reading);
    order.program = Some(block_on(async { read.await.map_err(refusal) })?);
    Ok(())
}

/// Replaces tasks in words by the tasks that a remote model reads. Where the embedded reader reads, they stay words,
/// which it reads when they are carried out.
///
/// # Errors
///
/// As [`read_edit`].
pub fn read_tasks(
    resolved: &Resolved,
    archive: &[u8],
    tasks: &mut [TaskSource],
    robot: &str,
    refusal: impl Fn(Problem) -> Failure,
) -> Result<(), Failure> {
    if tasks.iter().all(|task| matches!(task, TaskSource::Task(_))) {
        return Ok(());
    }
    let (app, reading) = reading(resolved)?;
    if !app.asks_models() {
        return Ok(());
    }
    let scene = InstructedScene::of_archive(archive).map_err(&refusal)?;
    block_on(async {
        for task in tasks {
            let TaskSource::Text(text) = task else { continue };
            let read = app.read_task(text, &scene, robot, &reading).await.map_err(&refusal)?;
            *task = TaskSource::Task(Box::new(read));
        }
        Ok(())
    })
}
