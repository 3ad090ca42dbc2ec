//! A hull on its way to the result.

use crate::ConvexHull;

/// A hull with all its corners and how far it sticks out of the solid.
#[derive(Clone)]
pub(super) struct Fitted {
    pub hull: ConvexHull,
    pub excess_m: f64,
}
