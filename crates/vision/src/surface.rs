//! What the bare table top looks like: one color with its grain, grown from the commonest colors of the
//! foreground.
//!
//! Each candidate color grows into a model (mean that may drift linearly over the picture, covariance of
//! the grain) by repeated selection and refitting, as region growing does; the caller judges the
//! candidates by the outline each gives.

use super::minimize::solve;
use super::pixels::Pixels;
use super::regions::{closed, filled, opened, parts};
use super::{VisionError, VisionSettings};
use runtime::Interrupt;

/// Color of a bare surface at every place, and how much it varies.
#[derive(Clone)]
pub(crate) struct Surface {
    /// Mean = c0 + c1 x + c2 y per CIELAB channel, x and y from -0.5 to 0.5 over the picture.
    mean: [[f64; 3]; 3],
    /// Inverse covariance.
    precision: [[f64; 3]; 3],
    /// The surface's mean as log light: c0 + c1 x + c2 y per channel.
    log_mean: [[f64; 3]; 3],
}

/// A candidate for the table top.
pub(crate) struct Candidate {
    pub surface: Surface,
    /// Bare pixels, in one or a few large parts.
    pub bare: Vec<usize>,
}

impl Candidate {
    /// The largest part left after thin parts are opened away; `None` where little is.
    pub fn opened(&self, pixels: &Pixels, radius: f32) -> Option<Self> {
        if radius < 1.0 {
            return Some(Self { surface: self.surface.clone(), bare: self.bare.clone() });
        }
        let (w, h) = (pixels.width, pixels.height);
        let mut bits = vec![false; pixels.len()];
        self.bare.iter().for_each(|&index| bits[index] = true);
        // Things standing on the top are no reason to open it up around them.
        let bits = opened(&filled(&bits, w, h, usize::MAX), w, h, radius);
        let bare = parts(&bits, w, h).into_iter().max_by_key(Vec::len)?;
        (4 * bare.len() > self.bare.len()).then(|| Self { surface: self.surface.clone(), bare })
    }
}

/// Candidates from the commonest colors of the foreground, at most four.
pub(crate) fn candidates(
    pixels: &Pixels,
    foreground: &[bool],
    settings: &VisionSettings,
    interrupt: &Interrupt,
) -> Result<Vec<Candidate>, VisionError> {
    let mut found = Vec::new();
    for mode in common_colors(pixels, foreground) {
        interrupt.check()?;
        found.extend(grow(pixels, foreground, mode, settings));
    }
    Ok(found)
}

/// Peaks of the color histogram (bins of 6 CIELAB units, smoothed), each at least 8 % of the foreground.
fn common_colors(pixels: &Pixels, foreground: &[bool]) -> Vec<[f32; 3]> {
    const SIZE: [usize; 3] = [17, 40, 40];
    let bin = |lab: [f32; 3]| {
        let l = (lab[0] / 6.0) as usize;
        let [a, b] = [lab[1], lab[2]].map(|c| ((c + 120.0) / 6.0).max(0.0) as usize);
        [l.min(SIZE[0] - 1), a.min(SIZE[1] - 1), b.min(SIZE[2] - 1)]
    };
    let flat = |[l, a, b]: [usize; 3]| (l * SIZE[1] + a) * SIZE[2] + b;
    let mut counts = vec![0_usize; SIZE.iter().product()];
    let mut total = 0;
    for (lab, _) in pixels.lab.iter().zip(foreground).filter(|(_, inside)| **inside) {
        counts[flat(bin(*lab))] += 1;
        total += 1;
    }
    let around = |center: [usize; 3], reach: usize| {
        let span = |k: usize| center[k].saturating_sub(reach)..(center[k] + reach + 1).min(SIZE[k]);
        let (ls, az, bs) = (span(0), span(1), span(2));
        ls.flat_map(move |l| {
            let bs = bs.clone();
            az.clone().flat_map(move |a| bs.clone().map(move |b| [l, a, b]))
        })
    };
    let mut peaks = Vec::new();
    for _ in 0..4 {
        let occupied = (0..counts.len()).filter(|&k| counts[k] > 0);
        let smoothed = occupied.map(|k| {
            let center = [k / (SIZE[1] * SIZE[2]), k / SIZE[2] % SIZE[1], k % SIZE[2]];
            (around(center, 1).map(|c| counts[flat(c)]).sum::<usize>(), center)
        });
        // The first of equals.
        let best = smoothed.fold(None, |best: Option<(usize, [usize; 3])>, next| match best {
            Some(b) if b.0 >= next.0 => Some(b),
            _ => Some(next),
        });
        let Some((mass, center)) = best.filter(|(mass, _)| 12 * mass >= total) else { break };
        let (mut sum, mut weight) = ([0.0; 3], 0.0);
        for c in around(center, 1) {
            let w = counts[flat(c)] as f32;
            let lab = [6.0 * c[0] as f32 + 3.0, 6.0 * c[1] as f32 - 117.0, 6.0 * c[2] as f32 - 117.0];
            (0..3).for_each(|k| sum[k] += w * lab[k]);
            weight += w;
        }
        peaks.push(sum.map(|s| s / weight));
        around(center, 2).for_each(|c| counts[flat(c)] = 0);
        let _ = mass;
    }
    peaks
}

fn grow(
    pixels: &Pixels,
    foreground: &[bool],
    mode: [f32; 3],
    settings: &VisionSettings,
) -> Option<Candidate> {
    let (w, h) = (pixels.width, pixels.height);
    let near = |lab: [f32; 3]| {
        (lab[0] - mode[0]).abs() < 10.0 && (lab[1] - mode[1]).abs() < 7.0 && (lab[2] - mode[2]).abs() < 7.0
    };
    let mut chosen: Vec<bool> =
        (0..pixels.len()).map(|index| foreground[index] && near(pixels.lab[index])).collect();
    let mut surface = None;
    for _ in 0..5 {
        // Grain leaves specks, legs and rims leave stripes: close the first, open away the second.
        let solid = opened(&closed(&chosen, w, h, 1.5), w, h, 3.0);
        let mut areas = parts(&solid, w, h);
        areas.sort_by_key(|part| std::cmp::Reverse(part.len()));
        let largest = areas.first().map_or(0, Vec::len);
        if largest < 200 {
            return None;
        }
        let bare: Vec<usize> =
            areas.into_iter().take_while(|part| 4 * part.len() >= largest).flatten().collect();
        let inside: Vec<usize> = bare.iter().copied().filter(|&index| chosen[index]).collect();
        let model = Surface::of(pixels, &inside)?;
        for index in 0..pixels.len() {
            chosen[index] = foreground[index] && model.distance(pixels, index) < settings.surface_sigmas;
        }
        surface = Some((model, bare));
    }
    surface.map(|(surface, bare)| Candidate { surface, bare })
}

impl Surface {
    fn terms(pixels: &Pixels, index: usize) -> [f64; 3] {
        let (x, y) = pixels.place(index);
        [1.0, x as f64 / pixels.width as f64 - 0.5, y as f64 / pixels.height as f64 - 0.5]
    }

    /// Fits mean and covariance to the pixels.
    pub fn of(pixels: &Pixels, inside: &[usize]) -> Option<Self> {
        let plane = |values: &[[f32; 3]]| -> Option<[[f64; 3]; 3]> {
            let mut system = [[0.0; 3]; 3];
            let mut right = [[0.0; 3]; 3];
            for &index in inside {
                let terms = Self::terms(pixels, index);
                for i in 0..3 {
                    (0..3).for_each(|j| system[i][j] += terms[i] * terms[j]);
                    (0..3).for_each(|c| right[c][i] += terms[i] * f64::from(values[index][c]));
                }
            }
            let [a, b, c] = right.map(|sums| solve(system, sums));
            let (a, b, c) = (a?, b?, c?);
            Some(std::array::from_fn(|k| [a[k], b[k], c[k]]))
        };
        let mean = plane(&pixels.lab)?;
        let log_mean = plane(&pixels.log_light)?;
        let mut surface = Self { mean, precision: [[0.0; 3]; 3], log_mean };
        let mut covariance = [[0.0; 3]; 3];
        for &index in inside {
            let d = surface.difference(pixels, index);
            for i in 0..3 {
                (0..3).for_each(|j| covariance[i][j] += d[i] * d[j] / inside.len() as f64);
            }
        }
        // Sensor noise and compression that the chosen pixels do not show.
        let floor = [2.2_f64.powi(2), 1.2_f64.powi(2), 1.2_f64.powi(2)];
        (0..3).for_each(|k| covariance[k][k] += floor[k]);
        // A surface this uneven is several.
        if covariance[0][0] > 15.0_f64.powi(2) {
            return None;
        }
        for k in 0..3 {
            let mut unit = [0.0; 3];
            unit[k] = 1.0;
            surface.precision[k] = solve(covariance, unit)?;
        }
        Some(surface)
    }

    fn difference(&self, pixels: &Pixels, index: usize) -> [f64; 3] {
        let terms = Self::terms(pixels, index);
        [0, 1, 2].map(|c| {
            f64::from(pixels.lab[index][c])
                - terms.iter().zip(&self.mean).map(|(term, row)| term * row[c]).sum::<f64>()
        })
    }

    /// Mahalanobis distance of a pixel's color from the bare surface there.
    pub fn distance(&self, pixels: &Pixels, index: usize) -> f64 {
        let d = self.difference(pixels, index);
        let squared: f64 =
            (0..3).map(|i| (0..3).map(|j| d[i] * self.precision[i][j] * d[j]).sum::<f64>()).sum();
        squared.max(0.0).sqrt()
    }

    /// Whether a pixel may be the bare surface in shadow: darker by one factor in all channels.
    pub fn is_shadow(&self, pixels: &Pixels, index: usize, settings: &VisionSettings) -> bool {
        let terms = Self::terms(pixels, index);
        let ratio: [f64; 3] = std::array::from_fn(|c| {
            f64::from(pixels.log_light[index][c])
                - terms.iter().zip(&self.log_mean).map(|(term, row)| term * row[c]).sum::<f64>()
        });
        let mean = ratio.iter().sum::<f64>() / 3.0;
        let stray = ratio.iter().map(|r| (r - mean).abs()).fold(0.0, f64::max);
        // The darker, the more a cool sky colors it.
        let allowed = settings.shadow_hue * (1.0 + 0.5 * -mean.min(0.0));
        mean < 0.05 && mean > settings.shadow_darkest.ln() && stray < allowed
    }
}
