//! A hull during decomposition, before its corners are limited.

use crate::ConvexHull;

/// A hull with all its corners and its excess over the solid.
#[derive(Clone)]
pub(super) struct FittedHull {
    pub hull: ConvexHull,
    pub excess_m: f64,
}
