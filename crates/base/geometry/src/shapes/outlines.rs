//! Closed counter-clockwise outlines in the plane, meters, centered on the origin.

use std::f64::consts::{PI, TAU};

use glam::DVec2;

/// Axis-aligned rectangle.
pub fn rectangle(width_m: f64, depth_m: f64) -> Vec<DVec2> {
    let (x, y) = (0.5 * width_m, 0.5 * depth_m);
    vec![DVec2::new(-x, -y), DVec2::new(x, -y), DVec2::new(x, y), DVec2::new(-x, y)]
}

/// Rectangle with corners rounded by `radius_m`, `steps` segments a corner.
pub fn rounded_rectangle(width_m: f64, depth_m: f64, radius_m: f64, steps: usize) -> Vec<DVec2> {
    let r = radius_m.min(0.499 * width_m).min(0.499 * depth_m);
    let (x, y) = (0.5 * width_m - r, 0.5 * depth_m - r);
    let corners = [(x, -y, -0.5 * PI), (x, y, 0.0), (-x, y, 0.5 * PI), (-x, -y, PI)];
    corners
        .iter()
        .flat_map(|&(cx, cy, from)| {
            (0..=steps).map(move |k| {
                let angle = from + 0.5 * PI * k as f64 / steps as f64;
                DVec2::new(cx, cy) + r * DVec2::new(angle.cos(), angle.sin())
            })
        })
        .collect()
}

/// Ellipse with the given axes.
pub fn ellipse(width_m: f64, depth_m: f64, segments: usize) -> Vec<DVec2> {
    superellipse(width_m, depth_m, 2.0, segments)
}

/// Circle of `radius_m`.
pub fn circle(radius_m: f64, segments: usize) -> Vec<DVec2> {
    ellipse(2.0 * radius_m, 2.0 * radius_m, segments)
}

/// |x/a|^n + |y/b|^n = 1: n = 2 an ellipse, larger n squarer.
pub fn superellipse(width_m: f64, depth_m: f64, exponent: f64, segments: usize) -> Vec<DVec2> {
    let power = |c: f64| c.signum() * c.abs().powf(2.0 / exponent);
    (0..segments)
        .map(|k| {
            let angle = TAU * k as f64 / segments as f64;
            DVec2::new(0.5 * width_m * power(angle.cos()), 0.5 * depth_m * power(angle.sin()))
        })
        .collect()
}

/// Regular polygon whose corners lie on a circle of `radius_m`, one corner at +x.
pub fn regular_polygon(radius_m: f64, sides: usize) -> Vec<DVec2> {
    circle(radius_m, sides)
}

/// The outline moved inward by `distance_m` (outward where negative), corners mitered. For convex or
/// gently concave outlines and distances well under the narrowest part.
pub fn inset(outline: &[DVec2], distance_m: f64) -> Vec<DVec2> {
    let n = outline.len();
    (0..n)
        .map(|k| {
            let (before, here, after) = (outline[(k + n - 1) % n], outline[k], outline[(k + 1) % n]);
            let a = (here - before).normalize_or_zero().perp();
            let b = (after - here).normalize_or_zero().perp();
            let center = (a + b).normalize_or(a);
            let cosine = center.dot(a).max(0.25);
            here + center * (distance_m / cosine)
        })
        .collect()
}

/// A closed Catmull-Rom curve through `points`, `steps` segments between neighbors.
pub fn smooth(points: &[DVec2], steps: usize) -> Vec<DVec2> {
    let n = points.len();
    (0..n)
        .flat_map(|k| {
            let [p0, p1, p2, p3] = [k + n - 1, k, k + 1, k + 2].map(|j| points[j % n]);
            (0..steps).map(move |s| {
                let t = s as f64 / steps as f64;
                let (t2, t3) = (t * t, t * t * t);
                0.5 * ((2.0 * p1)
                    + (p2 - p0) * t
                    + (2.0 * p0 - 5.0 * p1 + 4.0 * p2 - p3) * t2
                    + (3.0 * p1 - p0 - 3.0 * p2 + p3) * t3)
            })
        })
        .collect()
}
