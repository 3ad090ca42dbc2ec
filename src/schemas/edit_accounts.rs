//! Results of an edit, predicted or made: documents of the pipeline.

use schemars::JsonSchema;

use super::values::Names;

/// Prediction of an edit, as far as it needs no new object.
#[derive(JsonSchema)]
pub struct EditPrediction {
    pub operations: Vec<OperationResult>,
    /// Indices of the operations whose objects are made, and placed, only when the edit runs.
    #[schemars(inner(range(min = 0, max = 63)))]
    pub undetermined: Vec<u32>,
    pub moved: Vec<MovedObject>,
}

/// Result of an edit.
#[derive(JsonSchema)]
pub struct EditAccount {
    /// The id in the `scene.json` of the parent.
    pub parent: String,
    /// One for each operation, in order.
    pub operations: Vec<OperationResult>,
    /// Objects that no operation names and that moved nevertheless; all others have exactly the parent's poses.
    pub moved: Vec<MovedObject>,
}

/// Result of one operation.
#[derive(JsonSchema)]
pub struct OperationResult {
    pub op: String,
    /// Removed objects by their names in the parent.
    pub objects: Names,
    pub sentence: String,
}

/// A movement that no operation asks for, and its cause.
#[derive(JsonSchema)]
pub struct MovedObject {
    pub name: String,
    #[schemars(range(min = 0.0, max = 1000.0))]
    pub distance_m: f64,
    #[schemars(range(min = 0.0, max = 3.2))]
    pub angle_rad: f64,
    pub cause: String,
}
