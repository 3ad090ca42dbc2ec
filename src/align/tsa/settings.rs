//! Knobs of the top-view alignment.

use serde::{Deserialize, Serialize};

/// How boxes are believed.
#[derive(Clone, Debug, Serialize, Deserialize, PartialEq)]
#[serde(deny_unknown_fields)]
pub struct TsaSettings {
    /// Log aspect error at which a box's score is halved, above 0; the paper's 0.25. More lets large boxes
    /// of the wrong shape set the scale.
    pub tau: f64,
    /// Log ratio between the size a box says and the commonsense size beyond which the box wins, 0..;
    /// 0.3 is 35 percent. More trusts common sense.
    pub strong_deviation: f64,
}
