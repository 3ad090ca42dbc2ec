//! A small line plot: a loss over an angle, a speed over time.

use glam::DVec2;

use super::{draw_line, draw_polyline, draw_text, text_width_px};
use imaging::Image;

/// One line of a plot.
#[derive(Clone, Debug)]
pub struct Curve<'a> {
    /// (x, y), in the order of x.
    pub points: &'a [(f64, f64)],
    /// Points of it to mark with a cross.
    pub marks: &'a [(f64, f64)],
    pub color: [u8; 4],
}

const INK: [u8; 4] = [60, 60, 66, 255];
const GRID: [u8; 4] = [225, 225, 228, 255];

/// Draws the curves into one frame that fits all of them, with a title and the ranges written at the
/// axes.
pub fn plot_curves(width_px: u32, height_px: u32, title: &str, curves: &[Curve]) -> Image {
    let mut image = Image::filled(width_px, height_px, [255, 255, 255, 255]);
    let all = || curves.iter().flat_map(|c| c.points.iter().chain(c.marks)).filter(|p| p.1.is_finite());
    let (mut low, mut high) = all().fold((DVec2::INFINITY, DVec2::NEG_INFINITY), |(low, high), p| {
        let p = DVec2::new(p.0, p.1);
        (low.min(p), high.max(p))
    });
    if !low.is_finite() {
        (low, high) = (DVec2::ZERO, DVec2::ONE);
    }
    let span = (high - low).max(DVec2::splat(1e-9));
    low.y -= 0.05 * span.y;
    let span = DVec2::new(span.x, 1.1 * span.y);
    let (left, top) = (48.0, 22.0);
    let inner = DVec2::new(f64::from(width_px) - left - 10.0, f64::from(height_px) - top - 22.0);
    let place = |p: (f64, f64)| {
        let t = (DVec2::new(p.0, p.1) - low) / span;
        DVec2::new(left + t.x * inner.x, top + (1.0 - t.y) * inner.y)
    };
    for k in 0..=4 {
        let t = f64::from(k) / 4.0;
        let (x, y) = (left + t * inner.x, top + t * inner.y);
        draw_line(&mut image, DVec2::new(x, top), DVec2::new(x, top + inner.y), GRID, 1.0);
        draw_line(&mut image, DVec2::new(left, y), DVec2::new(left + inner.x, y), GRID, 1.0);
        let across = number(low.x + t * span.x);
        let at = x - 0.5 * f64::from(text_width_px(&across, 1));
        draw_text(&mut image, at as i64, (top + inner.y + 6.0) as i64, &across, 1, INK);
        let along = number(low.y + (1.0 - t) * span.y);
        let at = left - 5.0 - f64::from(text_width_px(&along, 1));
        draw_text(&mut image, at as i64, (y - 3.0) as i64, &along, 1, INK);
    }
    for curve in curves {
        let points: Vec<DVec2> = curve.points.iter().filter(|p| p.1.is_finite()).map(|&p| place(p)).collect();
        draw_polyline(&mut image, &points, false, curve.color, 1.6);
        for mark in curve.marks.iter().filter(|p| p.1.is_finite()) {
            let p = place(*mark);
            for d in [DVec2::new(4.0, 4.0), DVec2::new(4.0, -4.0)] {
                draw_line(&mut image, p - d, p + d, INK, 1.6);
            }
        }
    }
    draw_text(&mut image, left as i64, 7, title, 1, INK);
    image
}

/// A number in at most six characters or so.
fn number(value: f64) -> String {
    match value.abs() {
        a if a >= 100.0 => format!("{value:.0}"),
        a if a >= 1.0 => format!("{value:.1}"),
        _ => format!("{value:.3}"),
    }
}
