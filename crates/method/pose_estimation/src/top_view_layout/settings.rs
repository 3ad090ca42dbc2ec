//! Settings of the top-view alignment.

use serde::{Deserialize, Serialize};

/// Weights of the detected boxes in the layout estimate.
#[derive(Clone, Debug, Serialize, Deserialize, PartialEq)]
#[serde(deny_unknown_fields)]
pub struct TopViewSettings {
    /// Source of the scale of the top view.
    pub scale: TopViewScale,
    /// Log aspect error at which a box's score is halved, above 0; the paper's 0.25. More lets large boxes
    /// of the wrong shape set the scale.
    pub tau: f64,
    /// Log ratio between the box's size and the commonsense size above which the box wins, 0..; 0.3 is 35 percent.
    /// Larger values trust common sense more.
    pub strong_deviation: f64,
    /// Standard deviation of the logarithm of a commonsense size, above 0, used if too few objects determine it;
    /// larger values move sizes further toward their boxes.
    pub size_spread: f64,
    /// Source of the world's origin in the top view.
    pub origin: TopViewOrigin,
    /// Standard deviation of the logarithm of the reference camera's scale, above 0; more trusts boxes and sizes
    /// over distances that the camera saw.
    pub camera_spread: f64,
}

/// Source of the world's origin in the top view.
#[derive(Clone, Copy, Debug, Serialize, Deserialize, PartialEq, Eq)]
#[serde(rename_all = "snake_case")]
pub enum TopViewOrigin {
    /// The table's box, and where the reference camera sees each object.
    Sightings,
    /// The paper's: the center of the table's box alone.
    Table,
}

/// Source of the scale of the top view.
#[derive(Clone, Copy, Debug, Serialize, Deserialize, PartialEq, Eq)]
#[serde(rename_all = "snake_case")]
pub enum TopViewScale {
    /// All objects vote.
    Consensus,
    /// The paper's: the one object of the highest RMA score.
    Anchor,
}
