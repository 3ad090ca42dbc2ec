//! Knobs of the top-view alignment.

use serde::{Deserialize, Serialize};

/// How boxes are believed.
#[derive(Clone, Debug, Serialize, Deserialize, PartialEq)]
#[serde(deny_unknown_fields)]
pub struct TsaSettings {
    /// Who sets the scale of the top view.
    pub scale: TsaScale,
    /// Log aspect error at which a box's score is halved, above 0; the paper's 0.25. More lets large boxes
    /// of the wrong shape set the scale.
    pub tau: f64,
    /// Log ratio between the size a box says and the commonsense size beyond which the box wins, 0..;
    /// 0.3 is 35 percent. More trusts common sense.
    pub strong_deviation: f64,
    /// Standard deviation of the logarithm of a commonsense size, above 0, where too few objects tell it
    /// themselves; more draws their sizes further toward their boxes.
    pub size_spread: f64,
    /// What tells where the world's origin is on the top view.
    pub origin: TsaOrigin,
    /// Standard deviation of the logarithm of the reference camera's scale, above 0; more trusts boxes and sizes
    /// over distances that the camera saw.
    pub camera_spread: f64,
}

/// What tells where the world's origin is on the top view.
#[derive(Clone, Copy, Debug, Serialize, Deserialize, PartialEq, Eq)]
#[serde(rename_all = "snake_case")]
pub enum TsaOrigin {
    /// The table's box, and where the reference camera sees each object.
    Sightings,
    /// The paper's: the middle of the table's box alone.
    Table,
}

/// Who sets the scale of the top view.
#[derive(Clone, Copy, Debug, Serialize, Deserialize, PartialEq, Eq)]
#[serde(rename_all = "snake_case")]
pub enum TsaScale {
    /// All objects vote.
    Consensus,
    /// The paper's: the one object of the highest RMA score.
    Anchor,
}
