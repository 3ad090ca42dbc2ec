//! The numbers of every frame as features with names: what all formats write, and what has quantiles.

use crate::description::DatasetDescription;
use crate::unit::EpisodeUnit;

pub(crate) const STATE: &str = "observation.state";
pub(crate) const ACTION: &str = "action";
/// Name that does not begin with `action`, because LeRobot would take such a feature for an action.
pub(crate) const SERVO_COMMAND: &str = "servo_command";

/// A feature of `names.len()` f32 numbers a frame.
pub(crate) struct NumericFeature {
    pub key: String,
    pub names: Vec<String>,
}

/// State, action, what the servos pull to, and for each camera K and pose. The keys of cameras do not begin with
/// `observation`, since policies of LeRobot would take them for states.
pub(crate) fn numeric_features(description: &DatasetDescription) -> Vec<NumericFeature> {
    let mut features = vec![
        NumericFeature { key: STATE.to_owned(), names: description.state().full_names() },
        NumericFeature { key: ACTION.to_owned(), names: description.action().full_names() },
    ];
    if let Some(layout) = description.servo_command() {
        features.push(NumericFeature { key: SERVO_COMMAND.to_owned(), names: layout.full_names() });
    }
    for camera in description.cameras() {
        let matrix = |name: &str, columns: usize, numbers: usize| NumericFeature {
            key: format!("camera.{}.{name}", camera.name),
            names: (0..numbers).map(|i| format!("row{}_column{}", i / columns, i % columns)).collect(),
        };
        features.push(matrix("intrinsics", 3, 9));
        features.push(matrix("world_from_camera", 4, 16));
    }
    features
}

/// The rows of an episode, one list for each of [`numeric_features`].
pub(crate) fn numeric_rows(unit: &EpisodeUnit) -> Vec<&[f32]> {
    let mut rows = vec![unit.state(), unit.action()];
    // A unit has at least one frame, so that this is empty only where it is not described.
    rows.extend(Some(unit.servo_command()).filter(|rows| !rows.is_empty()));
    for camera in unit.cameras() {
        rows.push(&camera.intrinsics);
        rows.push(&camera.world_from_camera);
    }
    rows
}
