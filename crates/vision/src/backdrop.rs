//! The backdrop: one smooth color, learned from the border of the picture.
//!
//! A quadratic in x and y per CIELAB channel is fitted to the border band by least squares with Cauchy
//! weights, so that a table's legs crossing the border do not bend it. Whatever strays from it is
//! foreground, except soft shadows on the backdrop's floor. Not for rooms: then it refuses.

use super::minimize::solve;
use super::pixels::{Pixels, distance};
use super::regions::opened;
use super::{VisionError, VisionSettings};

/// Width of the border band, as a share of the shorter side.
const BAND: f64 = 0.025;

/// The backdrop's color at every place.
struct Backdrop {
    coefficients: [[f64; 3]; 6],
}

/// Pixels that do not show the backdrop.
pub(crate) fn foreground(pixels: &Pixels, settings: &VisionSettings) -> Result<Vec<bool>, VisionError> {
    let (backdrop, spread) = fit(pixels, settings)?;
    let threshold = settings.backdrop_distance.max(3.5 * spread) as f32;
    let differs: Vec<bool> = (0..pixels.len())
        .map(|index| {
            let (lab, plain) = (pixels.lab[index], backdrop.at(pixels, index));
            distance(lab, plain) > threshold && !is_floor_shadow(lab, plain)
        })
        .collect();
    Ok(opened(&differs, pixels.width, pixels.height, 1.0))
}

/// A shadow on the backdrop is darker, and of its hue.
fn is_floor_shadow(lab: [f32; 3], plain: [f32; 3]) -> bool {
    let brightness = lab[0] / plain[0].max(1.0);
    let hue = (lab[1] - plain[1]).hypot(lab[2] - plain[2]);
    (0.62..1.0).contains(&brightness) && hue < 3.0
}

fn fit(pixels: &Pixels, settings: &VisionSettings) -> Result<(Backdrop, f64), VisionError> {
    let band = ((BAND * pixels.width.min(pixels.height) as f64) as usize).max(3);
    let border: Vec<usize> = (0..pixels.len())
        .filter(|&index| {
            let (x, y) = pixels.place(index);
            let on_border = x < band || y < band || x + band >= pixels.width || y + band >= pixels.height;
            on_border && (x + y) % 2 == 0
        })
        .collect();
    let middle = [0, 1, 2].map(|channel| {
        let mut values: Vec<f32> = border.iter().map(|&index| pixels.lab[index][channel]).collect();
        values.sort_by(f32::total_cmp);
        values[values.len() / 2]
    });
    let mut backdrop = Backdrop { coefficients: [[0.0; 3]; 6] };
    backdrop.coefficients[0] = middle.map(f64::from);
    let mut spread = 6.0;
    for _ in 0..10 {
        let errors: Vec<f64> = border
            .iter()
            .map(|&index| f64::from(distance(pixels.lab[index], backdrop.at(pixels, index))))
            .collect();
        let mut sorted = errors.clone();
        sorted.sort_by(f64::total_cmp);
        spread = sorted[sorted.len() / 2].clamp(0.7, 8.0);
        let weights: Vec<f64> = errors.iter().map(|e| 1.0 / (1.0 + (e / (2.0 * spread)).powi(2))).collect();
        let Some(next) = Backdrop::through(pixels, &border, &weights) else { break };
        backdrop = next;
    }
    let limit = settings.backdrop_distance.max(3.5 * spread);
    let explained = border
        .iter()
        .filter(|&&index| f64::from(distance(pixels.lab[index], backdrop.at(pixels, index))) < limit)
        .count();
    let share = explained as f64 / border.len().max(1) as f64;
    if share < settings.backdrop_share || limit > 3.0 * settings.backdrop_distance {
        return Err(VisionError::BackdropNotPlain { percent: 100.0 * share });
    }
    Ok((backdrop, spread))
}

impl Backdrop {
    fn terms(pixels: &Pixels, index: usize) -> [f64; 6] {
        let (x, y) = pixels.place(index);
        let (x, y) = (x as f64 / pixels.width as f64 - 0.5, y as f64 / pixels.height as f64 - 0.5);
        [1.0, x, y, x * x, x * y, y * y]
    }

    fn at(&self, pixels: &Pixels, index: usize) -> [f32; 3] {
        let terms = Self::terms(pixels, index);
        [0, 1, 2].map(|c| {
            terms.iter().zip(&self.coefficients).map(|(term, row)| term * row[c]).sum::<f64>() as f32
        })
    }

    fn through(pixels: &Pixels, border: &[usize], weights: &[f64]) -> Option<Self> {
        let mut system = [[0.0; 6]; 6];
        let mut right = [[0.0; 6]; 3];
        for (&index, weight) in border.iter().zip(weights) {
            let terms = Self::terms(pixels, index);
            for i in 0..6 {
                for j in 0..6 {
                    system[i][j] += weight * terms[i] * terms[j];
                }
                for (c, sums) in right.iter_mut().enumerate() {
                    sums[i] += weight * terms[i] * f64::from(pixels.lab[index][c]);
                }
            }
        }
        let [l, a, b] = right.map(|sums| solve(system, sums));
        let (l, a, b) = (l?, a?, b?);
        Some(Self { coefficients: std::array::from_fn(|k| [l[k], a[k], b[k]]) })
    }
}
