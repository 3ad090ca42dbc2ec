//! An edit: a scene from a finished one and operations on it.
//!
//! The stage `parent` unpacks the parent's bundle. Objects that operations add are made by the ordinary stages, from a
//! text that names only them; meshes, hulls and paid calls of all other objects are the parent's. The stage `edit`
//! carries the operations out, and the result is certified and written like every scene.

pub mod parent;
mod account;
mod additions;
mod apply;
mod draft;
mod error;
mod landmarks;
mod operations;
pub mod predict;
mod recolor;
mod variation;
mod view;

use std::collections::BTreeMap;
use std::sync::Arc;

use error::EditError;
pub use predict::{Prediction, predict};
pub(super) use recolor::main_color;
use serde::Serialize;

use super::certify;
use super::checkpoint::Checkpoints;
use super::error::StageError;
use super::resources::StageResources;
use super::scene_identity::SceneIdentity;
use super::{Settings, bundle, robot_trial};
use scene::{EditOperation, Input, Randomize, SceneRequest};
use store::Digest;
use store::artifacts::BuiltScene;

/// The stages of an edit in order. Those between `parent` and `edit` run for added objects only, `theme` for
/// clutter, `grasp` and `rehearse` for a request that names a robot.
pub const STAGES: [&str; 16] = [
    "parent",
    "theme",
    "reference",
    "recognize",
    "segment",
    "complete",
    "reconstruct",
    "canonicalize",
    "decompose",
    "refine_camera",
    "rotate",
    "edit",
    "grasp",
    "rehearse",
    "certify",
    "bundle",
];

/// Builds the scene of a request for an edit.
///
/// # Errors
///
/// The error of the first stage that fails. `edit_refused` names the operation and the reason; nothing is written then.
pub async fn edit_scene(
    request: SceneRequest,
    checkpoints: Checkpoints,
    services: StageResources,
    settings: Arc<Settings>,
) -> Result<BuiltScene, StageError> {
    let (parent_id, bundle_sha256, change) = match request.input.clone() {
        Input::Edit { parent, bundle_sha256, operations, words, asides, .. } => {
            (parent, bundle_sha256, Change::Stated { operations, words: Words { words, asides } })
        }
        Input::Variant { parent, bundle_sha256, randomize } => {
            (parent, bundle_sha256, Change::Drawn(randomize))
        }
        Input::Text { .. } | Input::Image { .. } => {
            return Err(StageError::permanent("no_edit", "editing: the request is not for an edit"));
        }
    };
    let request = request.without_budget();
    let ports = services.ports.clone();
    let identity = SceneIdentity::new(&request, &ports, &settings)?;
    let stages = checkpoints.for_stages(&STAGES, Arc::new(services));

    let bundle = Digest::parse(&bundle_sha256).map_err(|error| {
        StageError::permanent("parent_unreadable", format!("reading the parent: {error}"))
    })?;
    let inputs = parent::Inputs { bundle: bundle.clone() };
    let parent = stages.run(parent::STAGE, inputs, parent::run).await?;

    let (operations, words, is_drawn) = match change {
        Change::Stated { operations, words } => (operations, words, false),
        Change::Drawn(randomize) => {
            (variation::drawn(&parent, &randomize, request.seed), Words::default(), true)
        }
    };
    let additions = additions::make(&request, &operations, &parent, &stages, &settings).await?;

    let plan = apply::Plan { parent_id, operations, words, additions, is_drawn, seed: request.seed };
    let inputs = apply::Inputs::new(parent, plan, &ports, &settings);
    let composition = stages.run(apply::STAGE, inputs, apply::run).await?;

    let gpu = stages.services().gpu_name().await;
    let inputs = certify::Inputs::of(identity, composition, &ports, &settings, gpu).with_parent(bundle);
    let robot = robot_trial::tried(&stages, &request, inputs.composition(), &settings).await?;
    let certified = stages.run(certify::STAGE, inputs.with_robot(robot), certify::run).await?;

    let bundle = stages.run(bundle::STAGE, bundle::Inputs { certified }, bundle::run).await?;
    Ok(bundle.into_rows())
}

/// The account of an instruction; empty for operations that were not given in words.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Words {
    /// The words that each operation comes from.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub words: Vec<String>,
    /// Words that ask for nothing.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub asides: Vec<String>,
}

/// Change of the parent.
enum Change {
    /// Operations, and the words that each comes from, if any.
    Stated { operations: Vec<EditOperation>, words: Words },
    /// Operations that the seed draws.
    Drawn(Randomize),
}

/// Objects made for the operations that need new ones, by index of the operation.
type Additions = BTreeMap<usize, Vec<additions::NewObject>>;

/// Error of an operation that is not carried out.
fn refused(index: usize, operation: &EditOperation, why: &EditError) -> StageError {
    let message = format!("operation {} ({}): {why}; nothing was changed", index + 1, operation.name());
    StageError::permanent("edit_refused", message)
}
