//! Surfaces of revolution about +z.

use std::f64::consts::{PI, TAU};

use glam::{DVec2, DVec3};

use super::loft;
use crate::Solid;

/// Revolves `profile`, points (radius, z) in meters, about the z axis in `segments` steps. The profile
/// runs from the bottom of the axis outward and up to the top of the axis (counter-clockwise in the
/// r-z plane); ends that are not on the axis are closed by flat caps. For a hollow vessel the profile returns
/// down the inside: `[(0,0), (R,0), (R,H), (R-t,H), (R-t,t), (0,t)]`.
pub fn lathe(profile: &[DVec2], segments: usize) -> Solid {
    let rings: Vec<Vec<DVec3>> = profile
        .iter()
        .map(|p| {
            let radius = if p.x.abs() < 1e-9 { 0.0 } else { p.x };
            (0..segments)
                .map(|k| {
                    let angle = TAU * k as f64 / segments as f64;
                    DVec3::new(radius * angle.cos(), radius * angle.sin(), p.y)
                })
                .collect()
        })
        .collect();
    loft(&rings)
}

/// A vessel: the outside follows `outside`, (radius, z) from the foot to the rim, the inside runs
/// `wall_m` (horizontally) within it down to `floor_m` above z = 0. Radii must exceed the wall.
pub fn shell_of_revolution(outside: &[DVec2], wall_m: f64, floor_m: f64, segments: usize) -> Solid {
    let mut profile = vec![DVec2::new(0.0, outside.first().map_or(0.0, |p| p.y))];
    profile.extend_from_slice(outside);
    let inner_radius_at = |z: f64| {
        let segment = outside.windows(2).find(|w| w[0].y <= z && z <= w[1].y && w[1].y > w[0].y);
        segment.map_or(outside[outside.len() - 1].x, |w| {
            w[0].x + (w[1].x - w[0].x) * (z - w[0].y) / (w[1].y - w[0].y)
        }) - wall_m
    };
    profile.extend(
        outside
            .iter()
            .rev()
            .filter(|p| p.y > floor_m + 1e-6)
            .map(|p| DVec2::new((p.x - wall_m).max(0.3 * p.x), p.y)),
    );
    profile.push(DVec2::new(inner_radius_at(floor_m).max(1e-3), floor_m));
    profile.push(DVec2::new(0.0, floor_m));
    lathe(&profile, segments)
}

/// Cylinder of the given radius and height with a small rounded rim (`edge_m`, may be 0).
pub fn cylinder(radius_m: f64, height_m: f64, edge_m: f64, segments: usize) -> Solid {
    let e = edge_m.min(0.49 * height_m).min(0.9 * radius_m);
    let mut profile = vec![DVec2::ZERO];
    if e > 0.0 {
        let arc = |center: DVec2, from: f64| {
            (0..=4).map(move |k| {
                let angle = from + 0.5 * PI * f64::from(k) / 4.0;
                center + e * DVec2::new(angle.cos(), angle.sin())
            })
        };
        profile.extend(arc(DVec2::new(radius_m - e, e), -0.5 * PI));
        profile.extend(arc(DVec2::new(radius_m - e, height_m - e), 0.0));
    } else {
        profile.extend([DVec2::new(radius_m, 0.0), DVec2::new(radius_m, height_m)]);
    }
    profile.push(DVec2::new(0.0, height_m));
    lathe(&profile, segments)
}

/// Truncated cone from `bottom_radius_m` to `top_radius_m` (either may be 0).
pub fn cone(bottom_radius_m: f64, top_radius_m: f64, height_m: f64, segments: usize) -> Solid {
    let profile = [
        DVec2::ZERO,
        DVec2::new(bottom_radius_m, 0.0),
        DVec2::new(top_radius_m, height_m),
        DVec2::new(0.0, height_m),
    ];
    lathe(&profile, segments)
}

/// Sphere of `radius_m` standing on z = 0.
pub fn sphere(radius_m: f64, segments: usize) -> Solid {
    ellipsoid(DVec3::splat(2.0 * radius_m), segments)
}

/// Ellipsoid with the axis-aligned box `size_m`, standing on z = 0.
pub fn ellipsoid(size_m: DVec3, segments: usize) -> Solid {
    let levels = (segments / 2).max(6);
    let profile: Vec<DVec2> = (0..=levels)
        .map(|k| {
            let angle = PI * k as f64 / levels as f64;
            DVec2::new(0.5 * angle.sin(), 0.5 - 0.5 * angle.cos())
        })
        .collect();
    lathe(&profile, segments).scaled(size_m)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn revolved_solids_have_analytic_volumes_and_closed_shells() {
        let ball = sphere(0.1, 96);
        assert!(ball.is_watertight());
        assert!((ball.volume_m3() / (4.0 / 3.0 * PI * 1e-3) - 1.0).abs() < 0.01);
        let mug = shell_of_revolution(&[DVec2::new(0.04, 0.0), DVec2::new(0.04, 0.1)], 0.004, 0.005, 96);
        let expected = PI * (0.04 * 0.04 * 0.1 - 0.036 * 0.036 * 0.095);
        assert!(mug.is_watertight());
        assert!((mug.volume_m3() / expected - 1.0).abs() < 0.01);
        let can = cylinder(0.03, 0.1, 0.002, 64);
        assert!(can.is_watertight() && can.volume_m3() > 0.98 * PI * 9e-5);
    }
}
