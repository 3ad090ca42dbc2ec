//! Knobs of the upright search.

use serde::{Deserialize, Serialize};

/// How the kinds of evidence are weighed; costs are in units of the silhouette loss.
#[derive(Clone, Debug, Serialize, Deserialize, PartialEq)]
#[serde(deny_unknown_fields)]
pub struct CanonicalizeSettings {
    /// Yaws tried for each up direction, 8..72; more tells finer shapes apart.
    pub yaws: u32,
    /// Side of the silhouettes, pixels, a multiple of 32.
    pub side_px: u32,
    /// Cost per unit of log extent error, above 0; more trusts the commonsense size.
    pub extent_weight: f64,
    /// Extent cost above the least beyond which an up direction is not looked at.
    pub hopeless_extent_cost: f64,
    /// Cost per unit of color disagreement (0..2); more trusts colors over outlines.
    pub appearance_weight: f64,
    /// Best silhouettes of an up direction whose colors are looked at, 1..8.
    pub looks: u32,
    /// Cost per unit of unlikeness to the example (0..1); more trusts the example.
    pub example_weight: f64,
    /// Cost per unit of unlikeness (0..1) of where colors vary on the mesh and on the example; more trusts
    /// what is drawn on things to tell their sides apart.
    pub detail_weight: f64,
    /// Cost of another up direction than the one that somebody says who has looked; more trusts the word,
    /// less the picture.
    pub told_up_weight: f64,
    /// Cost of another front with that up direction; more trusts the word, less extents and example.
    pub told_front_weight: f64,
    /// Lead over the next up direction at which the confidence is one half.
    pub clear_lead: f64,
}
