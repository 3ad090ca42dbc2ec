//! The stages of a request that names a robot: `grasp` and `rehearse`, between the finished scene and its certificate.

use std::sync::Arc;

use super::checkpoint::Checkpoints;
use super::composition::Composition;
use super::error::StageError;
use super::resources::StageResources;
use super::{Settings, grasp, rehearse};
use scene::SceneRequest;

/// Abilities of the request's robot in a scene; `None` where the request names none.
///
/// # Errors
///
/// `unknown_robot`, or the error of the first stage that fails.
pub(super) async fn tried(
    stages: &Checkpoints<StageResources>,
    request: &SceneRequest,
    composition: &Composition,
    settings: &Settings,
) -> Result<Option<Arc<rehearse::Output>>, StageError> {
    let Some(robot) = &request.options.robot else { return Ok(None) };
    // Before anything is simulated, also where no object is for grippers.
    grasp::robot_named(robot)?;
    let grasps = grasp::of_objects(stages, robot, composition, &settings.grasps).await?;
    let inputs = rehearse::Inputs::new(robot, request.seed, composition, grasps, settings);
    let rehearsed = stages.run(rehearse::STAGE, inputs, rehearse::run).await?;
    Ok(Some(Arc::new(rehearsed)))
}
