//! Instructions about a finished scene, read when their order comes. Calls of remote models are booked on the scene, so
//! that the same instruction is paid once.

use super::extract::TenantApi;
use super::parent;
use crate::app::edit_scene::ParentBundle;
use crate::app::executions::TaskSource;
use crate::app::instructions::{InstructedScene, Reading, objects_of};
use crate::problem::Problem;
use scene::{EditProgram, SceneId};

/// The program of an edit in words, beside the objects of the scene.
///
/// # Errors
///
/// A [`Problem`] for an instruction that is not understood, and of the model that does not answer.
pub(super) async fn edit_program(
    api: &TenantApi,
    scene_id: &SceneId,
    bundle: &ParentBundle,
    text: String,
) -> Result<EditProgram, Problem> {
    let permit = api.decoders.of(&api.tenant_id).await;
    let objects = parent::compute_with(api, scene_id, bundle, permit, |archive| Ok(objects_of(archive)));
    let objects = objects.await?;
    api.app.read_edit(text, objects, &reading(api, scene_id).await?).await
}

/// Replaces tasks in words by those that a remote model reads. The embedded reader is asked when they are carried out,
/// and then they stay words.
///
/// # Errors
///
/// As [`edit_program`], and for words that do not say which objects they mean.
pub(super) async fn read_tasks<'t>(
    api: &TenantApi,
    scene_id: &SceneId,
    bundle: &ParentBundle,
    tasks: impl Iterator<Item = &'t mut TaskSource>,
    robot: &str,
) -> Result<(), Problem> {
    if !api.app.asks_models() {
        return Ok(());
    }
    let mut known: Option<(InstructedScene, Reading)> = None;
    for task in tasks {
        let TaskSource::Text(text) = task else { continue };
        let (scene, reading) = match &mut known {
            Some(known) => known,
            None => {
                let permit = api.decoders.of(&api.tenant_id).await;
                let scene = parent::compute_with(api, scene_id, bundle, permit, InstructedScene::of_archive);
                known.insert((scene.await?, reading(api, scene_id).await?))
            }
        };
        *task = TaskSource::Task(Box::new(api.app.read_task(text, scene, robot, reading).await?));
    }
    Ok(())
}

async fn reading(api: &TenantApi, scene_id: &SceneId) -> Result<Reading, Problem> {
    Reading::about(&api.app, &api.store, api.cpu.clone(), &api.tenant_id, scene_id).await
}
