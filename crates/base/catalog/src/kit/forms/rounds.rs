//! Bodies of revolution, rings and tubes.

use std::f64::consts::TAU;

use glam::{DVec2, DVec3};
use serde::Deserialize;

use crate::kit::skins::{smooth_path, turned_ring, vessel};
use geometry::Solid;
use geometry::shapes::{circle, cylinder, ellipsoid, lathe, ring, sweep, sweep_closed};

const fn usual_segments() -> usize {
    36
}

const fn one() -> f64 {
    1.0
}

/// A cylinder, or a truncated cone where `top_radius` is given. Edges are rounded by `edge` unless it is 0.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Cylinder {
    radius: f64,
    height: f64,
    top_radius: Option<f64>,
    #[serde(default)]
    edge: f64,
    #[serde(default = "usual_segments")]
    segments: usize,
}

impl Cylinder {
    pub fn solid(&self) -> Solid {
        let solid = cylinder(self.radius, self.height, self.edge, self.segments);
        let Some(top_radius) = self.top_radius else { return solid };
        let tapered: Vec<DVec3> = solid
            .positions
            .iter()
            .map(|p| {
                let share = p.z / self.height;
                let factor = 1.0 + share * (top_radius / self.radius - 1.0);
                DVec3::new(p.x * factor, p.y * factor, p.z)
            })
            .collect();
        Solid::from_corners(&tapered, &solid.uvs, &solid.triangles)
    }
}

/// An ellipsoid with these extents.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Ball {
    size: DVec3,
    #[serde(default = "usual_segments")]
    segments: usize,
}

impl Ball {
    pub fn solid(&self) -> Solid {
        ellipsoid(self.size, self.segments)
    }
}

/// A body of revolution. `profile` is (radius, z): of a solid from the bottom up to the top; of a vessel, which has a
/// `wall`, the outside from the foot up to the rim.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Revolution {
    pub profile: Vec<DVec2>,
    /// Segments of a smooth curve between neighboring points; straight lines where it is 0.
    #[serde(default)]
    smooth: usize,
    /// Thickness of the wall of a vessel, and of its floor.
    wall: Option<f64>,
    floor: Option<f64>,
    /// Depth by width.
    #[serde(default = "one")]
    oval: f64,
    /// Ribs around: their number, and the height of the waves as a share of the radius.
    #[serde(default)]
    lobes: u32,
    #[serde(default)]
    lobe_depth: f64,
    lip: Option<Lip>,
    #[serde(default = "usual_segments")]
    segments: usize,
}

/// A pouring lip toward -x: how far the rim reaches out and rises there, meters.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Lip {
    reach: f64,
    rise: f64,
}

impl Lip {
    /// Angle from -x within which it is, rad, and the share of the height above which it begins.
    const WIDTH_RAD: f64 = 0.42;
    const BEGIN: f64 = 0.7;

    fn moved(self, p: DVec3, height: f64) -> DVec3 {
        let up = ((p.z / height - Self::BEGIN) / (1.0 - Self::BEGIN)).max(0.0);
        let angle = p.y.atan2(-p.x) / Self::WIDTH_RAD;
        let pull = (-angle * angle).exp() * up * up;
        p + pull * DVec3::new(-self.reach, 0.0, self.rise)
    }
}

impl Revolution {
    pub fn solid(&self) -> Solid {
        let knots: Vec<DVec3> = self.profile.iter().map(|p| p.extend(0.0)).collect();
        let line: Vec<DVec2> =
            smooth_path(&knots, self.smooth).iter().map(|p| DVec2::new(p.x.max(0.0), p.y)).collect();
        let solid = match self.wall {
            Some(wall) => vessel(&line, wall, self.floor.unwrap_or(wall), self.segments),
            None => lathe(&line, self.segments),
        };
        let solid = if self.oval == 1.0 { solid } else { solid.scaled(DVec3::new(1.0, self.oval, 1.0)) };
        let solid = match self.lip {
            Some(lip) => {
                let height = solid.positions.iter().map(|p| p.z).fold(0.0, f64::max);
                let positions: Vec<DVec3> = solid.positions.iter().map(|p| lip.moved(*p, height)).collect();
                Solid::from_corners(&positions, &solid.uvs, &solid.triangles)
            }
            None => solid,
        };
        if self.lobes == 0 {
            return solid;
        }
        let waved: Vec<DVec3> = solid
            .positions
            .iter()
            .map(|p| {
                let wave = (f64::from(self.lobes) * p.y.atan2(p.x)).cos();
                let factor = 1.0 + self.lobe_depth * wave;
                DVec3::new(p.x * factor, p.y * factor, p.z)
            })
            .collect();
        Solid::from_corners(&waved, &solid.uvs, &solid.triangles)
    }
}

/// A ring of revolution: `section` is a closed loop of (radius, z), counter-clockwise, off the axis.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Hoop {
    pub section: Vec<DVec2>,
    #[serde(default = "usual_segments")]
    segments: usize,
}

impl Hoop {
    pub fn solid(&self) -> Solid {
        turned_ring(&self.section, self.segments)
    }
}

/// A torus lying on z = 0: `radius` to the center of a bar of radius `bar`.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Torus {
    radius: f64,
    bar: f64,
    #[serde(default = "usual_segments")]
    segments: usize,
}

impl Torus {
    pub fn solid(&self) -> Solid {
        ring(self.radius, self.bar, self.segments, 12)
    }
}

/// A round bar along a path or a helix. `end_radius` where it tapers, or `radii` at the points of the path; `flat` is
/// the ratio of the bar's two axes.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Tube {
    #[serde(default)]
    path: Vec<DVec3>,
    helix: Option<Helix>,
    #[serde(default)]
    radius: f64,
    #[serde(default)]
    radii: Vec<f64>,
    end_radius: Option<f64>,
    #[serde(default)]
    smooth: usize,
    #[serde(default)]
    closed: bool,
    #[serde(default = "one")]
    flat: f64,
    #[serde(default = "bar_segments")]
    segments: usize,
}

const fn bar_segments() -> usize {
    10
}

/// A path around the z axis from z = 0 upward.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Helix {
    radius: f64,
    /// Height of one turn, meters.
    pitch: f64,
    turns: f64,
}

impl Helix {
    const STEPS_PER_TURN: f64 = 14.0;

    fn path(self) -> Vec<DVec3> {
        let steps = (Self::STEPS_PER_TURN * self.turns).ceil().max(2.0) as usize;
        let point = |k: usize| {
            let turns = self.turns * k as f64 / steps as f64;
            (self.radius * DVec2::from_angle(TAU * turns)).extend(self.pitch * turns)
        };
        (0..=steps).map(point).collect()
    }
}

impl Tube {
    /// The path's points, and the radii where they are listed one by one.
    fn points(&self) -> Vec<DVec3> {
        self.helix.map_or_else(|| self.path.clone(), Helix::path)
    }

    /// Number of points that it is given by; 0 if the radii are fewer or more than these, or there is no radius.
    pub fn point_count(&self) -> usize {
        let points = self.helix.map_or(self.path.len(), |_| 2);
        let radii =
            if self.radii.is_empty() { self.radius > 0.0 } else { self.radii.len() == self.path.len() };
        if radii { points } else { 0 }
    }

    pub fn solid(&self) -> Solid {
        let thickest = self.radii.iter().copied().fold(self.radius, f64::max);
        let section: Vec<DVec2> =
            circle(thickest, self.segments).iter().map(|p| DVec2::new(p.x, p.y * self.flat)).collect();
        let up = |path: &[DVec3]| {
            let direction = (path[1] - path[0]).normalize_or_zero();
            if direction.z.abs() < 0.8 { DVec3::Z } else { DVec3::X }
        };
        let points = self.points();
        if self.closed {
            let around = closed_path(&points, self.smooth.max(1));
            return sweep_closed(&around, &section, up(&around));
        }
        let path = smooth_path(&points, self.smooth);
        if self.radii.is_empty() {
            let end = self.end_radius.unwrap_or(self.radius) / self.radius;
            return sweep(&path, &section, up(&path), |share| 1.0 + share * (end - 1.0));
        }
        let knots: Vec<DVec3> =
            self.radii.iter().map(|radius| DVec3::new(radius / thickest, 0.0, 0.0)).collect();
        let scales = smooth_path(&knots, self.smooth);
        let last = scales.len() - 1;
        sweep(&path, &section, up(&path), |share| {
            let scale = scales[(share * last as f64).round() as usize];
            scale.x.clamp(0.0, 1.0)
        })
    }
}

/// A smooth closed curve through `knots`.
fn closed_path(knots: &[DVec3], steps: usize) -> Vec<DVec3> {
    let n = knots.len();
    let wrapped: Vec<DVec3> = (0..n + 3).map(|k| knots[(k + n - 1) % n]).collect();
    let line = smooth_path(&wrapped, steps);
    line[steps..steps * (n + 1)].to_vec()
}
