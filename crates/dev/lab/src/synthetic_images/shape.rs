//! Outlines of table tops.

use std::f64::consts::TAU;

use glam::DVec2;
use rand::RngExt;
use serde::{Deserialize, Serialize};

use super::sampling::{chance, uniform, weighted};
use geometry::shapes::{ellipse, rounded_rectangle, smooth, superellipse};
use runtime::seed::Rng;

/// Common name of the outline.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum TableShape {
    /// Four sides, corners sharp or rounded.
    Rectangle,
    Round,
    Oval,
    /// Three corners, rounded.
    Triangle,
    /// Trapezoids, polygons, kidneys, free forms.
    Irregular,
}

/// A shape and its counter-clockwise edge, meters, centered on its axis-aligned box.
pub(super) fn draw(rng: &mut Rng) -> (TableShape, Vec<DVec2>) {
    let shape = weighted(
        rng,
        &[
            (TableShape::Rectangle, 5.5),
            (TableShape::Round, 1.5),
            (TableShape::Oval, 0.8),
            (TableShape::Triangle, 0.9),
            (TableShape::Irregular, 1.6),
        ],
    );
    let width_m = uniform(rng, 0.55, 1.7);
    let depth_m = width_m * uniform(rng, 0.42, 0.85);
    let edge = match shape {
        TableShape::Rectangle => {
            let depth_m = if chance(rng, 0.15) { width_m } else { depth_m };
            let radius_m = if chance(rng, 0.5) { 0.006 } else { uniform(rng, 0.006, 0.14) };
            rounded_rectangle(width_m, depth_m, radius_m, 5)
        }
        TableShape::Round => ellipse(width_m, width_m, 72),
        TableShape::Oval => {
            superellipse(width_m, width_m * uniform(rng, 0.45, 0.82), uniform(rng, 1.9, 3.0), 72)
        }
        TableShape::Triangle => triangle(width_m, rng),
        TableShape::Irregular => irregular(width_m, depth_m, rng),
    };
    (shape, centered(&edge))
}

/// Three corners rounded off, sides straight or bulging, turned at random.
fn triangle(width_m: f64, rng: &mut Rng) -> Vec<DVec2> {
    let turn = if chance(rng, 0.5) { 0.25 * TAU } else { uniform(rng, 0.0, TAU) };
    let bulge = uniform(rng, 0.0, 0.6);
    let sides: Vec<DVec2> = (0..144)
        .map(|k| {
            let angle = TAU * f64::from(k) / 144.0;
            // Between the triangle's radius and the circle's.
            let straight = 0.5 / (angle.rem_euclid(TAU / 3.0) - TAU / 6.0).cos();
            let radius = 1.0 / ((1.0 - bulge) / straight + bulge);
            0.55 * width_m * radius * DVec2::from_angle(turn + angle)
        })
        .collect();
    softened(&sides, rng.random_range(4..120))
}

/// Smooths a closed curve: moves every point to the midpoint of its neighbors, `times` times.
fn softened(edge: &[DVec2], times: usize) -> Vec<DVec2> {
    let mut soft = edge.to_vec();
    let n = soft.len();
    for _ in 0..times {
        soft = (0..n).map(|k| 0.25 * (soft[(k + n - 1) % n] + 2.0 * soft[k] + soft[(k + 1) % n])).collect();
    }
    soft
}

/// Rounds the corners of a polygon with curves that begin at `roundness` of the side lengths.
fn rounded(corners: &[DVec2], roundness: f64) -> Vec<DVec2> {
    let n = corners.len();
    let mut edge = Vec::new();
    for k in 0..n {
        let (before, here, after) = (corners[(k + n - 1) % n], corners[k], corners[(k + 1) % n]);
        let (from, to) = (here + roundness * (before - here), here + roundness * (after - here));
        for step in 0..=6 {
            let t = f64::from(step) / 6.0;
            edge.push((1.0 - t).powi(2) * from + 2.0 * t * (1.0 - t) * here + t * t * to);
        }
    }
    edge
}

fn irregular(width_m: f64, depth_m: f64, rng: &mut Rng) -> Vec<DVec2> {
    match rng.random_range(0..6) {
        // A trapezoid.
        0 => {
            let (x, y, top) = (0.5 * width_m, 0.5 * depth_m, uniform(rng, 0.45, 0.85));
            let flip = if chance(rng, 0.5) { 1.0 } else { -1.0 };
            let (low, high) = if flip > 0.0 { (x, top * x) } else { (top * x, x) };
            let corners = [(-low, -y), (low, -y), (high, y), (-high, y)].map(|(x, y)| DVec2::new(x, y));
            rounded(&corners, uniform(rng, 0.01, 0.15))
        }
        // A polygon of five to eight sides, stretched.
        1 => {
            let sides = rng.random_range(5..9);
            let turn = if chance(rng, 0.5) { TAU / f64::from(2 * sides) } else { uniform(rng, 0.0, TAU) };
            let corners: Vec<DVec2> = (0..sides)
                .map(|k| {
                    let p = DVec2::from_angle(turn + TAU * f64::from(k) / f64::from(sides));
                    DVec2::new(0.5 * width_m * p.x, 0.5 * depth_m.max(0.7 * width_m) * p.y)
                })
                .collect();
            rounded(&corners, uniform(rng, 0.01, 0.2))
        }
        // A kidney.
        2 => {
            let dent = uniform(rng, 0.05, 0.4);
            let side = if chance(rng, 0.5) { 1.0 } else { -1.0 };
            (0..72)
                .map(|k| {
                    let angle = TAU * f64::from(k) / 72.0;
                    let near = (-((angle - 0.75 * TAU) / 0.6).powi(2)).exp();
                    let p = DVec2::from_angle(angle);
                    DVec2::new(0.5 * width_m * p.x, 0.5 * depth_m * (p.y + 2.0 * dent * near))
                })
                .map(|p| if side > 0.0 { p } else { DVec2::new(-p.x, -p.y) })
                .collect()
        }
        // A half disc.
        3 => {
            let back = uniform(rng, 0.0, 0.25);
            let mut edge: Vec<DVec2> = (0..=48)
                .map(|k| 0.5 * width_m * DVec2::from_angle(-0.5 * TAU * f64::from(k) / 48.0))
                .rev()
                .collect();
            edge.push(DVec2::new(0.5 * width_m, back * width_m));
            edge.push(DVec2::new(-0.5 * width_m, back * width_m));
            edge
        }
        // A free form.
        _ => {
            let knots = rng.random_range(5..9);
            let points: Vec<DVec2> = (0..knots)
                .map(|k| {
                    let p =
                        DVec2::from_angle(TAU * f64::from(k) / f64::from(knots)) * uniform(rng, 0.72, 1.0);
                    DVec2::new(0.5 * width_m * p.x, 0.5 * depth_m.max(0.6 * width_m) * p.y)
                })
                .collect();
            smooth(&points, 10)
        }
    }
}

fn centered(edge: &[DVec2]) -> Vec<DVec2> {
    let mut low = DVec2::INFINITY;
    let mut high = DVec2::NEG_INFINITY;
    edge.iter().for_each(|p| (low, high) = (low.min(*p), high.max(*p)));
    let center = 0.5 * (low + high);
    let mut moved: Vec<DVec2> = edge.iter().map(|p| *p - center).collect();
    moved.dedup_by(|a, b| (*a - *b).length() < 1e-4);
    while moved.len() > 3 && (moved[0] - moved[moved.len() - 1]).length() < 1e-4 {
        moved.pop();
    }
    moved
}

#[cfg(test)]
mod tests {
    use super::*;
    use geometry::Outline;
    use runtime::seed::child_rng;

    #[test]
    fn outlines_are_centered_and_counter_clockwise() {
        for seed in 0..200 {
            let (shape, edge) = draw(&mut child_rng(seed, "shape"));
            let outline = Outline::new(edge.clone()).expect("an outline");
            assert_eq!(outline.corners(), edge, "{shape:?} {seed} was turned around");
            let (low, high) = outline.bounds();
            assert!((low + high).abs().max_element() < 1e-9, "{shape:?} {seed}");
            assert!(outline.area_m2() > 0.08, "{shape:?} {seed} {}", outline.area_m2());
        }
    }
}
