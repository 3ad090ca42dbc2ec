//! The account of all scenes that a freeze read: which passed, and why some are not in the dataset.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

/// Numbers of scenes.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Selection {
    /// Items of the batch, if its output was given, else bundles.
    pub requested: usize,
    /// Bundles of different scenes that were read.
    pub read: usize,
    /// Of these, scenes with the verdict `pass`.
    pub passed: usize,
    /// Bundles that are copies of another one.
    pub copies: usize,
    /// Items of the batch without a bundle, by state.
    pub without_bundle: BTreeMap<String, usize>,
    /// Scenes that failed a check of the certificate, by the check's code. A scene may fail several.
    pub quarantine_reasons: BTreeMap<String, usize>,
    /// Scenes that the filter left out, by the first condition that they do not meet.
    pub left_out: BTreeMap<String, usize>,
}

impl Selection {
    /// Passes over all requested scenes; `None` if there are none.
    pub fn yield_share(&self) -> Option<f64> {
        (self.requested > 0).then(|| self.passed as f64 / self.requested as f64)
    }
}
