//! Prediction of an edit without making it: references, places and collisions, but no new objects.

use std::fmt::Display;

use schemars::JsonSchema;
use serde::Serialize;

use super::draft::{Draft, load};
use super::operations::{OperationInputs, carry_out};
use super::{parent, refused};
use crate::pipeline::Settings;
use crate::pipeline::error::StageError;
use editing::RestSettings;
use geometry::TexturedMesh;
use mesh_io::gltf::read_mesh_glb;
use runtime::CancelFlag;
use scene::EditOperation;
use scene::edit::{MovedObject, OperationResult};

/// The prediction of an edit.
#[derive(Clone, Debug, Serialize, JsonSchema)]
#[schemars(
    rename = "EditPrediction",
    description = "Prediction of an edit, as far as it needs no new object."
)]
pub struct Prediction {
    /// Results of the operations that need no new object.
    pub operations: Vec<OperationResult>,
    /// Indices of operations whose objects are made, and placed, only when the edit runs; later operations are
    /// predicted without them.
    #[schemars(inner(range(min = 0, max = 63)))]
    pub undetermined: Vec<usize>,
    /// Objects that no operation names and that would move.
    pub moved: Vec<MovedObject>,
}

/// Carries the operations out on the parent's bundle, an archive, as the stage `edit` does. Blocks for as long.
///
/// # Errors
///
/// `edit_refused` for the first operation that cannot be carried out; `parent_unreadable` for an archive that is no
/// bundle.
pub fn predict(
    archive: &[u8],
    operations: &[EditOperation],
    settings: &Settings,
    cancel: &CancelFlag,
) -> Result<Prediction, StageError> {
    let parent::Parent { stored, files } = parent::unpacked(archive)?;
    let unreadable = |why: &dyn Display| {
        StageError::permanent("parent_unreadable", format!("reading the parent's bundle: {why}"))
    };
    let mut loaded = Vec::with_capacity(stored.hulls.len());
    for (body, hulls) in stored.composition.bodies.iter().zip(stored.hulls) {
        let path = parent::mesh_path(&body.resolved.name);
        let bytes = files.get(&path).ok_or_else(|| unreadable(&format!("it has no {path}")))?;
        let mesh: TexturedMesh = read_mesh_glb(bytes).map_err(|error| unreadable(&error))?;
        loaded.push(load(mesh, hulls).map_err(|error| unreadable(&error))?);
    }
    let rest = RestSettings { settle: &settings.settle, certify: &settings.certify, may_roll: false };
    let draft = Draft::new(stored.composition, loaded, rest, cancel.clone());
    let mut draft = draft.map_err(|error| unreadable(&error))?;
    let (mut results, mut undetermined) = (Vec::new(), Vec::new());
    for (index, operation) in operations.iter().enumerate() {
        let needs_objects = matches!(
            operation,
            EditOperation::Add { .. }
                | EditOperation::Replace { .. }
                | EditOperation::Remake { .. }
                | EditOperation::Clutter { .. }
                | EditOperation::RestyleTable { .. }
        );
        if needs_objects {
            undetermined.push(index);
            continue;
        }
        let given = OperationInputs { additions: Vec::new(), table: None, seed: 0 };
        let done = carry_out(&mut draft, operation, given);
        cancel.check()?;
        match done {
            Ok(done) => results.push(done),
            // It may name an object that an operation before it adds.
            Err(_) if !undetermined.is_empty() => undetermined.push(index),
            Err(why) => return Err(refused(index, operation, &why)),
        }
    }
    let (_, _, _, moved) = draft.finish();
    Ok(Prediction { operations: results, undetermined, moved })
}
