//! Parametric closed solids: surfaces of revolution, prisms, slabs, sweeps, lofts, inflated outlines.
//!
//! Every function returns a watertight [`Solid`](super::Solid) with outward faces, meters, z up. The
//! base of each shape lies on z = 0 and its axis on x = y = 0 unless its documentation says otherwise.

mod loft;
mod lathe;
mod prism;
mod sweep;
mod triangulate;
mod outlines;
mod inflate;

pub use inflate::Inflation;
pub use lathe::{cone, cylinder, ellipsoid, lathe, shell_of_revolution, sphere};
pub use loft::{loft, loft_closed};
pub use outlines::{
    circle, ellipse, inset, rectangle, regular_polygon, rounded_rectangle, smooth, superellipse,
};
pub use prism::{block, prism, rounded_block, slab};
pub use sweep::{ring, sweep, sweep_closed, tube};
pub use triangulate::triangulate;
