//! The parameters of each form and the solid that they describe. Lengths are meters.

mod blocks;
mod outlines;
mod rounds;

pub(super) use blocks::{Block, Loft};
pub(super) use outlines::{Extrusion, Silhouette};
pub(super) use rounds::{Ball, Cylinder, Hoop, Revolution, Torus, Tube};
