//! The parameters of each form and the solid that they describe. Lengths are meters.

mod blocks;
mod outlines;
mod rounds;

pub(super) use blocks::{Block, Loft};
pub(super) use outlines::{Extrusion, Silhouette};
pub(super) use rounds::{Ball, Cylinder, Hoop, Revolution, Torus, Tube};

use glam::DVec3;

/// A smooth curve through `knots` (Catmull-Rom), `steps` segments between neighbors; the knots themselves for 0 or 1.
fn smooth_path(knots: &[DVec3], steps: usize) -> Vec<DVec3> {
    let triples: Vec<(f64, f64, f64)> = knots.iter().map(|p| (p.x, p.y, p.z)).collect();
    crate::assembly::curve(&triples, steps.max(1))
}
