//! The front face of the top's board, often so like the top that it was taken for part of it.
//!
//! Below the lower edge of the top lies its rim, a few percent of the table high. Colors are averaged along
//! the edge, per row of offset straight up from it; the offset that splits the rows best into two colors is
//! the true edge, if the two differ by more than the rows vary.

use std::f64::consts::TAU;

use glam::DVec2;

use super::Ellipse;
use crate::pixels::{Pixels, distance};
use crate::polygon::{area, crossing};

/// Highest rim as a share of the outline's size (square root of its area).
const HIGHEST_RIM: f64 = 0.07;

/// Moves the lower sides up by the rim they include.
pub(super) fn off_quad(pixels: &Pixels, corners: [DVec2; 4]) -> [DVec2; 4] {
    let size = area(&corners).abs().sqrt();
    let lines: [(DVec2, DVec2); 4] = std::array::from_fn(|k| {
        let (a, b) = (corners[k], corners[(k + 1) % 4]);
        let outward = -(b - a).perp().normalize_or_zero();
        if outward.y < 0.35 {
            return (a, b);
        }
        let points: Vec<DVec2> =
            (0..200).map(|j| a + (b - a) * (0.06 + 0.88 * f64::from(j) / 199.0)).collect();
        let up = DVec2::new(0.0, -rim_height(pixels, &points, HIGHEST_RIM * size).unwrap_or(0.0));
        (a + up, b + up)
    });
    let met: Vec<DVec2> = (0..4).filter_map(|k| crossing(lines[(k + 3) % 4], lines[k])).collect();
    <[DVec2; 4]>::try_from(met).unwrap_or(corners)
}

/// As [`off_quad`], for the lower half of an ellipse.
pub(super) fn off_ellipse(pixels: &Pixels, ellipse: Ellipse) -> Ellipse {
    let size = (std::f64::consts::PI * ellipse.semi_axes.element_product()).sqrt();
    let points: Vec<DVec2> = (0..240).map(|k| ellipse.at(TAU * f64::from(k) / 240.0)).collect();
    let below = |p: &DVec2| p.y - ellipse.center.y;
    let deepest = points.iter().map(below).fold(0.0, f64::max);
    let lower: Vec<DVec2> = points.iter().copied().filter(|p| below(p) > 0.5 * deepest).collect();
    let Some(height) = rim_height(pixels, &lower, HIGHEST_RIM * size) else { return ellipse };
    let moved: Vec<DVec2> = points
        .into_iter()
        .filter(|p| below(p) < -0.1 * deepest || below(p) > 0.3 * deepest)
        .map(|p| if below(&p) > 0.0 { p - DVec2::new(0.0, height) } else { p })
        .collect();
    ellipse.through(&moved).unwrap_or(ellipse)
}

/// Rows by which the colors change, counted up from the points, if they do.
fn rim_height(pixels: &Pixels, points: &[DVec2], highest: f64) -> Option<f64> {
    let rows = (2.2 * highest).ceil() as usize;
    // Medians, so that things standing on the edge do not count.
    let profile: Vec<[f32; 3]> = (1..=rows)
        .map(|d| {
            let seen: Vec<[f32; 3]> = points
                .iter()
                .filter_map(|p| {
                    pixels.index_at(*p - DVec2::new(0.0, d as f64)).map(|index| pixels.lab[index])
                })
                .collect();
            std::array::from_fn(|c| {
                let mut values: Vec<f32> = seen.iter().map(|lab| lab[c]).collect();
                values.sort_by(f32::total_cmp);
                values.get(values.len() / 2).copied().unwrap_or(0.0)
            })
        })
        .collect();
    let mean = |rows: &[[f32; 3]]| -> [f32; 3] {
        std::array::from_fn(|c| rows.iter().map(|r| r[c]).sum::<f32>() / rows.len() as f32)
    };
    let scatter = |rows: &[[f32; 3]]| {
        let middle = mean(rows);
        rows.iter().map(|r| distance(*r, middle).powi(2)).sum::<f32>()
    };
    let last = (highest as usize).min(rows.saturating_sub(5));
    let (split, left) = (2..=last)
        .map(|k| (k, scatter(&profile[..k]) + scatter(&profile[k..])))
        .min_by(|a, b| a.1.total_cmp(&b.1))?;
    let apart = distance(mean(&profile[..split]), mean(&profile[split..]));
    let spread = (left / rows as f32).sqrt();
    (apart > 2.0 && apart > 2.0 * spread).then_some(split as f64)
}
