//! Bodies of revolution: cups, bowls, vases, bottles, rings.
//!
//! A shell whose vertices lie on coaxial rings, all at the same angles, is its profile revolved about an axis. Elliptic
//! rings are supported: the two axes across may be scaled. The profile is cut into convex parts. A revolved part is a
//! convex body if it reaches the axis, else a ring, which is cut into as many sectors as the tolerance requires. Every
//! hull spans vertices of the mesh or points on its edges, so rims and feet are exactly those of the mesh.

use std::collections::HashMap;
use std::sync::{Mutex, PoisonError};

use glam::{DMat3, DVec2, DVec3};

use super::DecomposeSettings;
use super::excess::excess;
use super::field::Field;
use super::fitted_hull::FittedHull;
use super::profile::{convex_parts, crosses_itself};
use crate::convex_hull::convex_hull;
use crate::mass_properties::symmetric_eigen;
use crate::shells::Shell;
use runtime::{CancelFlag, Cancelled};

/// Minimum number of vertices of a round ring.
const FEWEST_STEPS: usize = 10;
/// Distance up to which two radii or heights count as equal, share of the shell's size.
const SAME: f64 = 1e-5;
/// Difference up to which two angles count as equal.
const SAME_ANGLE_RAD: f64 = 1e-3;
/// Crossing depth up to which edges of a profile count as touching, meters.
const TOUCHING_M: f64 = 1e-6;
/// Numbers of sectors that are tried for a ring.
const SECTORS: [usize; 14] = [1, 2, 3, 4, 5, 6, 8, 10, 12, 14, 16, 20, 24, 32];

/// A shell as a profile revolved about an axis.
pub(super) struct Revolution {
    center: DVec3,
    /// Unit.
    axis: DVec3,
    /// Scaled axes across: a profile point (r, h) at angle a lies at
    /// center + h axis + r (cos a across\[0\] + sin a across\[1\]), the larger of the two having length 1.
    across: [DVec3; 2],
    /// Angles of the ring's corners, ascending.
    angles_rad: Vec<f64>,
    /// Counter-clockwise, x = radius, y = height along the axis.
    profile: Vec<DVec2>,
    /// Results of sectors tried before, which recur as the tolerance is relaxed.
    tried: Mutex<HashMap<Sectors, Outcome>>,
}

/// Key: a part of the profile, as the bits of its corners, and its number of sectors.
type Sectors = (Vec<[u64; 2]>, usize);

/// Known result for a part with a number of sectors.
#[derive(Clone)]
enum Outcome {
    /// Lower bound of the excess of a sector, meters.
    Beyond(f64),
    /// The sectors and their largest excess, meters.
    FittedHull(Vec<FittedHull>, f64),
}

impl Revolution {
    /// Recognizes a body of revolution about an axis parallel to x, y or z, or about any other: objects that lie on
    /// their side are seldom level.
    pub(super) fn recognize(shell: &Shell) -> Option<Self> {
        let (low, high) = shell.bounds();
        let (center, half) = (0.5 * (low + high), 0.5 * (high - low));
        let along_axes = [DVec3::Z, DVec3::X, DVec3::Y].into_iter().find_map(|axis| {
            let one = if axis == DVec3::X { DVec3::Y } else { DVec3::X };
            let other = axis.cross(one);
            let widths = [half.dot(one.abs()), half.dot(other.abs())];
            Self::about(shell, center, axis, [one, other], widths, half.length())
        });
        along_axes.or_else(|| Self::recognize_by_spread(shell, half.length()))
    }

    /// The corners of a body of revolution have their mean on its axis, and its axis as one of their principal axes.
    /// The spread along the other two gives how they are scaled.
    fn recognize_by_spread(shell: &Shell, size: f64) -> Option<Self> {
        let count = shell.points.len() as f64;
        let center = shell.points.iter().sum::<DVec3>() / count;
        let outer = |d: DVec3| DMat3::from_cols(d * d.x, d * d.y, d * d.z);
        let spread = shell.points.iter().map(|p| outer(*p - center)).fold(DMat3::ZERO, |a, b| a + b);
        let (values, turn) = symmetric_eigen(spread * (1.0 / count));
        let (axes, widths) = (DMat3::from_quat(turn), values.max(DVec3::ZERO).map(f64::sqrt));
        (0..3).find_map(|k| {
            let (one, other) = ((k + 1) % 3, (k + 2) % 3);
            let across = [axes.col(one), axes.col(other)];
            Self::about(shell, center, axes.col(k), across, [widths[one], widths[other]], size)
        })
    }

    /// Widths are those along the directions across, in any unit; `size` is that of the shell, for tolerances.
    fn about(
        shell: &Shell,
        center: DVec3,
        axis: DVec3,
        [one, other]: [DVec3; 2],
        [a, b]: [f64; 2],
        size: f64,
    ) -> Option<Self> {
        let widest = a.max(b);
        if a.min(b) < SAME * widest {
            return None;
        }
        let across = [one * (a / widest), other * (b / widest)];
        // (radius, height, angle) of each corner.
        let polar: Vec<(f64, f64, f64)> = shell
            .points
            .iter()
            .map(|&p| {
                let d = p - center;
                let flat = DVec2::new(d.dot(one) * widest / a, d.dot(other) * widest / b);
                (flat.length(), d.dot(axis), angle_rad(flat))
            })
            .collect();
        let on_axis = |r: f64| r < 10.0 * SAME * size;
        // Rings: corners of one radius and height.
        let mut order: Vec<usize> = (0..polar.len()).collect();
        let cell = |x: f64| (x / (SAME * size)).round() as i64;
        order.sort_by_key(|&k| (cell(polar[k].1), cell(polar[k].0), k));
        let mut ring_of = vec![0_usize; polar.len()];
        let mut rings: Vec<(DVec2, Vec<f64>)> = Vec::new();
        for &k in &order {
            let (r, h, angle) = polar[k];
            let here = DVec2::new(if on_axis(r) { 0.0 } else { r }, h);
            // Rounding may put equal corners in neighboring cells, so recent rings are compared too.
            let known = (rings.len().saturating_sub(6)..rings.len())
                .rev()
                .find(|&ring| rings[ring].0.distance(here) < 4.0 * SAME * size);
            let ring = known.unwrap_or(rings.len());
            if known.is_none() {
                rings.push((here, Vec::new()));
            }
            rings[ring].1.push(angle);
            ring_of[k] = ring;
        }
        let mut angles_rad = rings.iter().map(|ring| &ring.1).max_by_key(|angles| angles.len())?.clone();
        angles_rad.sort_by(f64::total_cmp);
        let steps = angles_rad.len();
        if steps < FEWEST_STEPS || rings.len() < 2 {
            return None;
        }
        let same_angle = |x: f64, y: f64| {
            let apart = (x - y).rem_euclid(std::f64::consts::TAU);
            apart.min(std::f64::consts::TAU - apart) < SAME_ANGLE_RAD
        };
        for (here, angles) in &rings {
            if here.x == 0.0 {
                continue;
            }
            let mut angles = angles.clone();
            angles.sort_by(f64::total_cmp);
            if angles.len() != steps || !angles.iter().zip(&angles_rad).all(|(&x, &y)| same_angle(x, y)) {
                return None;
            }
        }
        let profile = profile_of(shell, &ring_of, &rings).filter(|p| !crosses_itself(p, TOUCHING_M))?;
        Some(Self { center, axis, across, angles_rad, profile, tried: Mutex::default() })
    }

    /// Points of a profile part revolved from step `from` to step `to` (which may pass the last one).
    fn swept(&self, part: &[DVec2], from: usize, to: usize) -> Vec<DVec3> {
        let steps = self.angles_rad.len();
        let mut points = Vec::with_capacity(part.len() * (to - from + 1));
        for p in part {
            let base = self.center + p.y * self.axis;
            if p.x == 0.0 {
                points.push(base);
                continue;
            }
            points.extend((from..=to).map(|k| {
                let (sin, cos) = self.angles_rad[k % steps].sin_cos();
                base + p.x * (cos * self.across[0] + sin * self.across[1])
            }));
        }
        points
    }

    /// Hulls of the body within `tolerance_m`; `None` if that takes more than `max_hulls`.
    pub(super) fn hulls(
        &self,
        tolerance_m: f64,
        max_hulls: usize,
        solid: &Field,
        settings: &DecomposeSettings,
        cancel: &CancelFlag,
    ) -> Result<Option<Vec<FittedHull>>, Cancelled> {
        let mut hulls = Vec::new();
        for part in convex_parts(self.profile.clone(), 0.4 * tolerance_m) {
            // A chord of the inner circle leaves it by r (1 - cos(pi / n)), and no fewer sectors can do, unless
            // the inside of this part is no surface.
            let inner_m = part.iter().map(|p| p.x).fold(f64::INFINITY, f64::min);
            let fewest = std::f64::consts::PI / (1.0 - tolerance_m / inner_m.max(tolerance_m)).acos();
            let fewest = fewest.min(SECTORS[SECTORS.len() - 1] as f64);
            let counts = SECTORS.into_iter().filter(|&n| n == 1 || n as f64 > 0.8 * fewest);
            let mut found = None;
            for sectors in counts {
                let fitted_hull = self.sectors(&part, sectors, tolerance_m, solid, settings, cancel)?;
                if let Some(fitted_hull) = fitted_hull {
                    found = Some(fitted_hull);
                    break;
                }
                if hulls.len() + sectors > max_hulls {
                    return Ok(None);
                }
            }
            hulls.extend(found.into_iter().flatten());
            if hulls.len() > max_hulls {
                return Ok(None);
            }
        }
        Ok(Some(hulls))
    }

    /// The revolved part in equal sectors; `None` if the excess of one is above `enough_m`.
    fn sectors(
        &self,
        part: &[DVec2],
        sectors: usize,
        enough_m: f64,
        solid: &Field,
        settings: &DecomposeSettings,
        cancel: &CancelFlag,
    ) -> Result<Option<Vec<FittedHull>>, Cancelled> {
        let steps = self.angles_rad.len();
        let sectors = sectors.min(steps);
        let finest = sectors == steps || sectors == SECTORS[SECTORS.len() - 1];
        let enough_m = if finest { f64::INFINITY } else { enough_m };
        let key = (part.iter().map(|p| p.to_array().map(f64::to_bits)).collect(), sectors);
        match self.known(&key) {
            Some(Outcome::Beyond(min_m)) if min_m > enough_m => return Ok(None),
            Some(Outcome::FittedHull(_, farthest_m)) if farthest_m > enough_m => return Ok(None),
            Some(Outcome::FittedHull(hulls, _)) => return Ok(Some(hulls)),
            Some(Outcome::Beyond(_)) | None => {}
        }
        let (mut hulls, mut farthest_m) = (Vec::with_capacity(sectors), 0.0_f64);
        for k in 0..sectors {
            let points = self.swept(part, k * steps / sectors, (k + 1) * steps / sectors);
            let Some(hull) = convex_hull(&points, usize::MAX, 0.0) else { continue };
            let known_m = 0.25 * settings.tolerance_m;
            let found = excess(&hull, solid, settings.excess_spacing_m, known_m, enough_m, cancel)?;
            if found.distance_m > enough_m {
                self.learn(key, Outcome::Beyond(found.distance_m));
                return Ok(None);
            }
            farthest_m = farthest_m.max(found.distance_m);
            hulls.push(FittedHull { hull, excess_m: found.distance_m });
        }
        self.learn(key, Outcome::FittedHull(hulls.clone(), farthest_m));
        Ok(Some(hulls))
    }

    fn known(&self, key: &Sectors) -> Option<Outcome> {
        self.tried.lock().unwrap_or_else(PoisonError::into_inner).get(key).cloned()
    }

    fn learn(&self, key: Sectors, outcome: Outcome) {
        self.tried.lock().unwrap_or_else(PoisonError::into_inner).insert(key, outcome);
    }
}

/// Angle from -pi. Points half a turn away, up to rounding, have angle -pi on either side of the axis.
fn angle_rad(across: DVec2) -> f64 {
    let angle_rad = across.to_angle();
    if angle_rad > std::f64::consts::PI - SAME_ANGLE_RAD {
        angle_rad - std::f64::consts::TAU
    } else {
        angle_rad
    }
}

/// The closed counter-clockwise profile through the rings, or `None` if they do not form a simple chain.
fn profile_of(shell: &Shell, ring_of: &[usize], rings: &[(DVec2, Vec<f64>)]) -> Option<Vec<DVec2>> {
    let mut neighbors: Vec<Vec<usize>> = vec![Vec::new(); rings.len()];
    for t in &shell.triangles {
        for k in 0..3 {
            let (a, b) = (ring_of[t[k] as usize], ring_of[t[(k + 1) % 3] as usize]);
            if a != b && !neighbors[a].contains(&b) {
                neighbors[a].push(b);
                neighbors[b].push(a);
            }
        }
    }
    if neighbors.iter().any(|n| n.is_empty() || n.len() > 2) {
        return None;
    }
    let start = neighbors.iter().position(|n| n.len() == 1).unwrap_or(0);
    let mut profile = vec![rings[start].0];
    let (mut before, mut here) = (start, neighbors[start][0]);
    while here != start {
        profile.push(rings[here].0);
        let Some(&next) = neighbors[here].iter().find(|&&n| n != before) else { break };
        (before, here) = (here, next);
    }
    if profile.len() != rings.len() {
        return None;
    }
    if neighbors[start].len() == 1 {
        // An open chain ends on the axis, or in flat caps.
        let (first, last) = (profile[0], profile[profile.len() - 1]);
        if last.x > 0.0 {
            profile.push(DVec2::new(0.0, last.y));
        }
        if first.x > 0.0 {
            profile.insert(0, DVec2::new(0.0, first.y));
        }
    }
    let n = profile.len();
    let area: f64 = (0..n).map(|k| profile[k].perp_dot(profile[(k + 1) % n])).sum();
    if area < 0.0 {
        profile.reverse();
    }
    Some(profile)
}
