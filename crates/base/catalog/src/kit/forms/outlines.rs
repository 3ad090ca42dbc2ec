//! Forms that follow an outline: extrusions and inflated silhouettes.

use std::f64::consts::{FRAC_PI_2, TAU};

use glam::{DMat3, DQuat, DVec2, DVec3};
use serde::Deserialize;

use crate::kit::skins::pierced;
use geometry::shapes::{Inflation, prism, slab, smooth};
use geometry::{Posture, Solid};

/// Orientation of an outline's plane.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
enum Facing {
    /// The outline is (x, y), raised from z = 0.
    #[default]
    Up,
    /// The outline is (x, z), its depth centered on y = 0.
    Front,
    /// The outline is (y, z), its width centered on x = 0.
    Side,
}

/// An outline given a thickness. The outline is smoothed by `smooth` segments between neighbors unless that is 0.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Extrusion {
    pub outline: Vec<DVec2>,
    thickness: f64,
    #[serde(default)]
    edge: f64,
    /// Cut off each corner along both sides and replaced by a curve.
    #[serde(default)]
    corner: f64,
    #[serde(default)]
    smooth: usize,
    #[serde(default)]
    facing: Facing,
    hole: Option<Hole>,
}

/// A hole through the thickness. The outline is star shaped as seen from its center.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Hole {
    #[serde(default)]
    at: DVec2,
    radius: f64,
    /// Number of sides of a polygon; round where it is absent.
    sides: Option<u32>,
}

impl Hole {
    /// Distance of its edge from its center in this direction.
    fn reach(self, angle: f64) -> f64 {
        let Some(sides) = self.sides else { return self.radius };
        let sector = TAU / f64::from(sides);
        self.radius * (0.5 * sector).cos() / (angle.rem_euclid(sector) - 0.5 * sector).cos()
    }
}

/// Segments of a rounded corner.
const CORNER_STEPS: u32 = 6;

impl Extrusion {
    pub fn solid(&self) -> Solid {
        let outline = oriented(&self.outline, self.smooth);
        let outline = if self.corner > 0.0 { rounded_corners(&outline, self.corner) } else { outline };
        let raised = if let Some(hole) = self.hole {
            pierced(&outline, hole.at, |angle| hole.reach(angle), self.thickness, self.edge)
        } else if self.edge > 0.0 {
            slab(&outline, self.thickness, self.edge).with_flat_ends()
        } else {
            prism(&outline, self.thickness)
        };
        let half = 0.5 * self.thickness;
        match self.facing {
            Facing::Up => raised,
            Facing::Front => {
                raised.rotated(DQuat::from_rotation_x(FRAC_PI_2)).translated(DVec3::new(0.0, half, 0.0))
            }
            Facing::Side => raised
                .rotated(DQuat::from_mat3(&DMat3::from_cols(DVec3::Y, DVec3::Z, DVec3::X)))
                .translated(DVec3::new(-half, 0.0, 0.0)),
        }
    }
}

/// A body with this silhouette whose thickness follows its width, in a box of `size`: lying, the outline is (x, y);
/// standing, it is (x, z). The outline's own scale does not matter.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Silhouette {
    pub outline: Vec<DVec2>,
    size: DVec3,
    #[serde(default)]
    standing: bool,
    #[serde(default)]
    smooth: usize,
    #[serde(default = "usual_squares")]
    squares: u32,
}

const fn usual_squares() -> u32 {
    320
}

impl Silhouette {
    /// Empty if the outline encloses nothing.
    pub fn solid(&self) -> Solid {
        let outline = oriented(&self.outline, self.smooth);
        let posture = if self.standing { Posture::Standing } else { Posture::Lying };
        Inflation::new(&outline, posture, self.squares)
            .map_or_else(Solid::default, |inflation| inflation.solid(self.size))
    }
}

/// The outline, smoothed, counter-clockwise.
fn oriented(outline: &[DVec2], steps: usize) -> Vec<DVec2> {
    let mut line = if steps > 1 { smooth(outline, steps) } else { outline.to_vec() };
    let n = line.len();
    let area: f64 = (0..n).map(|k| line[k].perp_dot(line[(k + 1) % n])).sum();
    if area < 0.0 {
        line.reverse();
    }
    line
}

/// The outline with a parabola in place of each corner.
fn rounded_corners(outline: &[DVec2], corner_m: f64) -> Vec<DVec2> {
    let n = outline.len();
    let toward = |here: DVec2, other: DVec2| {
        let side = other - here;
        here + side * (corner_m / side.length().max(1e-9)).min(0.49)
    };
    (0..n)
        .flat_map(|k| {
            let here = outline[k];
            let (from, to) = (toward(here, outline[(k + n - 1) % n]), toward(here, outline[(k + 1) % n]));
            (0..=CORNER_STEPS).map(move |step| {
                let t = f64::from(step) / f64::from(CORNER_STEPS);
                from.lerp(here, t).lerp(here.lerp(to, t), t)
            })
        })
        .collect()
}
