//! Pieces of furniture: boards between two corners, tapered and splayed legs, turned columns.

use glam::{DVec2, DVec3};

use geometry::Solid;
use geometry::shapes::{block, lathe, loft, rectangle, rounded_rectangle};

/// An axis-aligned board between its lowest and highest corner.
pub fn board(low: DVec3, high: DVec3) -> Solid {
    let center = 0.5 * (low + high);
    block(high - low).translated(DVec3::new(center.x, center.y, low.z))
}

/// A straight leg with a rounded-rectangle section from `foot` (on the floor) up to `head`, its side
/// changing from `foot_side_m` to `head_side_m`. Its ends stay horizontal, so it stands flat.
pub fn leg(foot: DVec3, head: DVec3, foot_side_m: f64, head_side_m: f64) -> Solid {
    let ring = |center: DVec3, side: f64| -> Vec<DVec3> {
        rounded_rectangle(side, side, 0.15 * side, 3).iter().map(|p| center + p.extend(0.0)).collect()
    };
    loft(&[ring(foot, foot_side_m), ring(head, head_side_m)])
}

/// A round leg from `foot` up to `head`.
pub fn round_leg(foot: DVec3, head: DVec3, foot_radius_m: f64, head_radius_m: f64) -> Solid {
    let ring = |center: DVec3, radius: f64| -> Vec<DVec3> {
        (0..24)
            .map(|k| {
                center + (radius * DVec2::from_angle(std::f64::consts::TAU * f64::from(k) / 24.0)).extend(0.0)
            })
            .collect()
    };
    loft(&[ring(foot, foot_radius_m), ring(head, head_radius_m)])
}

/// A straight rectangular bar between two points, `width_m` across horizontally and `height_m` high,
/// ends cut vertically.
pub fn bar(from: DVec3, to: DVec3, width_m: f64, height_m: f64) -> Solid {
    let forward = (to - from).truncate().normalize_or(DVec2::X);
    let side = forward.perp();
    let ring = |center: DVec3| -> Vec<DVec3> {
        rectangle(width_m, height_m)
            .iter()
            .map(|p| center + (side * p.x).extend(0.0) + DVec3::Z * p.y)
            .collect()
    };
    loft(&[ring(from), ring(to)])
}

/// A turned column: (radius, z) pairs from the floor up, closed at both ends.
pub fn column(profile: &[(f64, f64)]) -> Solid {
    let mut points = vec![DVec2::new(0.0, profile[0].1)];
    points.extend(profile.iter().map(|&(r, z)| DVec2::new(r, z)));
    points.push(DVec2::new(0.0, profile[profile.len() - 1].1));
    lathe(&points, 40)
}
