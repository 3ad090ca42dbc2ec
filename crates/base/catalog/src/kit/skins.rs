//! Solids that several forms are made of: skins over sections, bodies of revolution with a hole, plates with a hole.
//! The functions do not depend on the unit of length.

use std::f64::consts::TAU;

use glam::{DVec2, DVec3};

use geometry::Solid;
use geometry::shapes::{circle, lathe, loft, loft_closed};

/// An open Catmull-Rom curve through `knots` (two or more), `steps` segments between neighbors; the knots themselves
/// for 0 or 1.
pub(super) fn smooth_path(knots: &[DVec3], steps: usize) -> Vec<DVec3> {
    let (steps, last) = (steps.max(1), knots.len() - 1);
    let mut smooth = Vec::with_capacity(last * steps + 1);
    for k in 0..last {
        let (p1, p2) = (knots[k], knots[k + 1]);
        let p0 = if k == 0 { 2.0 * p1 - p2 } else { knots[k - 1] };
        let p3 = if k + 2 > last { 2.0 * p2 - p1 } else { knots[k + 2] };
        for s in 0..steps {
            let t = s as f64 / steps as f64;
            smooth.push(
                0.5 * (2.0 * p1
                    + (p2 - p0) * t
                    + (2.0 * p0 - 5.0 * p1 + 4.0 * p2 - p3) * t * t
                    + (3.0 * p1 - p0 - 3.0 * p2 + p3) * t * t * t),
            );
        }
    }
    smooth.push(knots[last]);
    smooth
}

/// A superellipse section: (position along the axis, center a, center b, full width a, full width b).
pub(super) type Section = (f64, f64, f64, f64, f64);

/// Skins superellipse sections (z, x, y, width, depth) upward; `exponent` 2 is round, 6 boxy.
pub(super) fn column(sections: &[Section], exponent: f64, segments: usize) -> Solid {
    let power = |c: f64| 0.5 * c.signum() * c.abs().powf(2.0 / exponent);
    let unit: Vec<DVec2> = (0..segments)
        .map(|k| {
            // Offset by half a step, so that a boxy section has a flat underside instead of a corner.
            let (sin, cos) = (TAU * (k as f64 + 0.5) / segments as f64).sin_cos();
            DVec2::new(power(cos), power(sin))
        })
        .collect();
    let rings: Vec<Vec<DVec3>> = sections
        .iter()
        .map(|&(z, x, y, width, depth)| {
            unit.iter().map(|p| DVec3::new(x + width * p.x, y + depth * p.y, z)).collect()
        })
        .collect();
    loft(&rings)
}

/// A ring of revolution with an open center: `profile`, a closed loop (radius, z), counter-clockwise in the
/// r-z plane, no point on the axis.
pub(super) fn turned_ring(profile: &[DVec2], segments: usize) -> Solid {
    let rings: Vec<Vec<DVec3>> =
        profile.iter().map(|p| circle(p.x, segments).iter().map(|q| q.extend(p.y)).collect()).collect();
    loft_closed(&rings)
}

/// An open vessel of revolution about +z. `outside` runs (radius, z) from the foot to the rim; the inside
/// lies `wall` within it, measured across the wall, and has its floor at z = `floor`.
pub(super) fn vessel(outside: &[DVec2], wall: f64, floor: f64, segments: usize) -> Solid {
    let n = outside.len();
    let inward = |k: usize| {
        let along = (outside[(k + 1).min(n - 1)] - outside[k.saturating_sub(1)]).normalize_or_zero();
        along.perp()
    };
    let mut profile = vec![DVec2::new(0.0, outside[0].y)];
    profile.extend_from_slice(outside);
    let rim = outside[n - 1];
    profile.push(rim + 0.5 * wall * inward(n - 1) + 0.35 * wall * DVec2::Y);
    for k in (0..n).rev() {
        let inner = outside[k] + wall * inward(k);
        let inner = DVec2::new(inner.x, inner.y.max(floor));
        if inner.x > 1e-4 {
            profile.push(inner);
        }
        if inner.y <= floor {
            break;
        }
    }
    profile.push(DVec2::new(0.0, floor));
    lathe(&profile, segments)
}

/// Number of steps around a plate's hole, beside the corners of the outline.
const HOLE_SEGMENTS: usize = 48;

/// A plate with one hole, standing on z = 0: `outline` must be star shaped as seen from `center`; the hole reaches
/// `hole(angle)` from there. Edges are rounded by `edge` unless it is 0.
pub(super) fn pierced(
    outline: &[DVec2],
    center: DVec2,
    hole: impl Fn(f64) -> f64,
    height: f64,
    edge: f64,
) -> Solid {
    let reach = |direction: DVec2| {
        (0..outline.len())
            .filter_map(|k| {
                let (a, b) = (outline[k] - center, outline[(k + 1) % outline.len()] - center);
                let along = b - a;
                let turn = direction.perp_dot(along);
                let (distance, fraction) = (a.perp_dot(along) / turn, a.perp_dot(direction) / turn);
                let meets = turn.abs() > 1e-12 && (-1e-9..=1.0 + 1e-9).contains(&fraction);
                (meets && distance > 0.0).then_some(distance)
            })
            .fold(0.0, f64::max)
    };
    // The outline's own corners are sampled exactly; even steps fill the rest.
    let mut angles: Vec<f64> = (0..HOLE_SEGMENTS).map(|k| TAU * k as f64 / HOLE_SEGMENTS as f64).collect();
    angles.extend(outline.iter().map(|p| (*p - center).to_angle().rem_euclid(TAU)));
    angles.sort_by(f64::total_cmp);
    angles.dedup_by(|a, b| (*a - *b).abs() < 0.02);
    let ring = |outer: bool, shrink: f64, z: f64| -> Vec<DVec3> {
        let point = |&angle: &f64| {
            let direction = DVec2::from_angle(angle);
            let radius = if outer { reach(direction) - shrink } else { hole(angle) + shrink };
            (center + radius * direction).extend(z)
        };
        angles.iter().map(point).collect()
    };
    if edge <= 0.0 {
        let rings = [(true, 0.0), (true, height), (false, height), (false, 0.0)];
        return loft_closed(&rings.map(|(outer, z)| ring(outer, 0.0, z)));
    }
    let rings = [(edge, 0.0), (0.0, edge), (0.0, height - edge), (edge, height)];
    let outer = rings.map(|(shrink, z)| ring(true, shrink, z));
    let inner = rings.map(|(shrink, z)| ring(false, shrink, z));
    let around: Vec<Vec<DVec3>> = outer.into_iter().chain(inner.into_iter().rev()).collect();
    loft_closed(&around)
}

#[cfg(test)]
mod tests {
    use super::*;
    use geometry::shapes::rectangle;

    #[test]
    fn skins_are_closed() {
        let outside = [DVec2::new(0.04, 0.0), DVec2::new(0.07, 0.03), DVec2::new(0.08, 0.06)];
        let solids = [
            vessel(&outside, 0.003, 0.004, 32),
            turned_ring(&[DVec2::new(0.03, 0.0), DVec2::new(0.04, 0.0), DVec2::new(0.04, 0.01)], 24),
            pierced(&rectangle(0.1, 0.06), DVec2::new(0.01, 0.0), |_| 0.01, 0.005, 0.001),
            pierced(&rectangle(0.1, 0.06), DVec2::ZERO, |_| 0.01, 0.005, 0.0),
        ];
        for solid in solids {
            assert!(solid.is_watertight() && solid.volume_m3() > 0.0, "{}", solid.volume_m3());
        }
    }
}
