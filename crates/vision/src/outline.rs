//! The edge of the table top in the picture: a quadrilateral or an ellipse, from the bare top's pixels.
//!
//! The hull of the bare pixels bridges what objects hide of the edge. The quadrilateral is the smallest
//! that encloses it, the ellipse the one with its moments; each is moved onto the step from bare top to
//! anything else, wherever bare top shows just inside, and refitted with outliers trimmed.

mod rim;

use glam::DVec2;

use super::VisionSettings;
use super::pixels::Pixels;
use super::polygon::{area, crossing, enclosed_by, hull_of_pixels, overlap};
use super::surface::{Candidate, Surface};

/// Shape of the top as seen.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Seen {
    /// Corners in the order of growing angle (y down).
    Quad([DVec2; 4]),
    Ellipse(Ellipse),
}

/// An ellipse in the picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Ellipse {
    pub center: DVec2,
    /// Semi-axes, and the direction of the first.
    pub semi_axes: DVec2,
    pub angle_rad: f64,
}

/// An outline and how believable it is.
pub(crate) struct Hypothesis {
    pub seen: Seen,
    /// Overlap with the hull of the bare pixels, 0..1.
    pub fit: f64,
    /// Share of the edge with bare top just inside and something else just outside, 0..1.
    pub clean: f64,
    /// Area in pixels of the copy.
    pub area: f64,
}

impl Seen {
    /// A polygon around it, in the order of growing angle.
    pub fn polygon(&self) -> Vec<DVec2> {
        match self {
            Self::Quad(corners) => corners.to_vec(),
            Self::Ellipse(ellipse) => {
                (0..96).map(|k| ellipse.at(std::f64::consts::TAU * f64::from(k) / 96.0)).collect()
            }
        }
    }
}

impl Ellipse {
    /// Point at an angle of its parameter.
    pub fn at(&self, t: f64) -> DVec2 {
        let along = DVec2::from_angle(self.angle_rad);
        self.center + self.semi_axes.x * t.cos() * along + self.semi_axes.y * t.sin() * along.perp()
    }

    /// The ellipse near this one that runs through the points, wrong ones pulling little.
    fn through(&self, points: &[DVec2]) -> Option<Self> {
        let of = |q: &[f64; 5]| Ellipse {
            center: DVec2::new(q[0], q[1]),
            semi_axes: DVec2::new(q[2], q[3]),
            angle_rad: q[4],
        };
        let start = [self.center.x, self.center.y, self.semi_axes.x, self.semi_axes.y, self.angle_rad];
        let residuals = |q: &[f64; 5]| {
            let e = of(q);
            let error = |p: &DVec2| {
                let d = DVec2::from_angle(-e.angle_rad).rotate(*p - e.center);
                let r = (d / e.semi_axes).length();
                let error = (r - 1.0) * d.length() / r.max(1e-9);
                error / (1.0 + (error / 3.0).powi(2)).sqrt()
            };
            (q[2] > 3.0 && q[3] > 3.0).then(|| points.iter().map(error).collect())
        };
        let steps = [0.1, 0.1, 0.1, 0.1, 1e-4];
        super::minimize::least_squares(start, steps, residuals).map(|(q, _)| of(&q))
    }
}

/// The better of both readings of a candidate's pixels.
pub(crate) fn read(pixels: &Pixels, candidate: &Candidate, settings: &VisionSettings) -> Option<Hypothesis> {
    let hull = hull_of_pixels(candidate.bare.iter().copied(), pixels.width);
    if hull.len() < 4 {
        return None;
    }
    let quad = enclosed_by(&hull, 4)
        .and_then(|corners| <[DVec2; 4]>::try_from(corners).ok())
        .map(|corners| on_the_edge(pixels, &candidate.surface, corners, settings))
        .map(|corners| Seen::Quad(rim::off_quad(pixels, corners)));
    let ellipse = moments(&hull)
        .map(|e| ellipse_on_the_edge(pixels, &candidate.surface, e, settings))
        .map(|e| Seen::Ellipse(rim::off_ellipse(pixels, e)));
    [quad, ellipse]
        .into_iter()
        .flatten()
        .map(|seen| {
            let polygon = seen.polygon();
            let fit = overlap(&hull, &polygon);
            let clean = cleanness(pixels, &candidate.surface, &polygon, settings);
            Hypothesis { seen, fit, clean, area: area(&polygon) }
        })
        .max_by(|a, b| (a.fit + 0.2 * a.clean).total_cmp(&(b.fit + 0.2 * b.clean)))
}

fn is_bare(pixels: &Pixels, surface: &Surface, p: DVec2, settings: &VisionSettings) -> bool {
    pixels.index_at(p).is_some_and(|index| surface.distance(pixels, index) < settings.surface_sigmas)
}

/// Share of the edge that is a step from bare top to something else.
fn cleanness(pixels: &Pixels, surface: &Surface, polygon: &[DVec2], settings: &VisionSettings) -> f64 {
    let (mut clean, mut all) = (0, 0);
    for k in 0..polygon.len() {
        let (a, b) = (polygon[k], polygon[(k + 1) % polygon.len()]);
        let outward = -(b - a).perp().normalize_or_zero();
        let steps = ((b - a).length() / 4.0).ceil().max(1.0) as usize;
        for step in 0..steps {
            let p = a + (b - a) * ((step as f64 + 0.5) / steps as f64);
            let inside = (2..=5).filter(|&d| is_bare(pixels, surface, p - f64::from(d) * outward, settings));
            let outside = (2..=5).filter(|&d| is_bare(pixels, surface, p + f64::from(d) * outward, settings));
            clean += usize::from(inside.count() >= 3 && outside.count() <= 1);
            all += 1;
        }
    }
    f64::from(clean as u32) / f64::from(all.max(1) as u32)
}

/// Offset along `outward` from `p` at which bare top ends, if the step is a clear one.
fn step_at(
    pixels: &Pixels,
    surface: &Surface,
    p: DVec2,
    outward: DVec2,
    settings: &VisionSettings,
) -> Option<f64> {
    const REACH: i32 = 9;
    let bare: Vec<bool> =
        (-REACH..=REACH).map(|d| is_bare(pixels, surface, p + f64::from(d) * outward, settings)).collect();
    let total = bare.iter().filter(|&&b| b).count() as i32;
    // Bare before the split and not bare after it.
    let (mut best, mut best_score, mut before) = (0, i32::MIN, 0);
    for split in 0..=bare.len() {
        let score = 2 * before - split as i32 + (bare.len() - split) as i32 - 2 * (total - before);
        if score > best_score {
            (best, best_score) = (split, score);
        }
        before += i32::from(split < bare.len() && bare[split]);
    }
    // Nearly all samples on their side, and enough of each to mean something.
    let clear = best_score >= bare.len() as i32 - 4 && best >= 4 && best + 3 <= bare.len();
    clear.then(|| f64::from(best as i32 - REACH) - 0.5)
}

fn on_the_edge(
    pixels: &Pixels,
    surface: &Surface,
    corners: [DVec2; 4],
    settings: &VisionSettings,
) -> [DVec2; 4] {
    let mut corners = corners;
    for _ in 0..2 {
        let lines: [(DVec2, DVec2); 4] = std::array::from_fn(|k| {
            let (a, b) = (corners[k], corners[(k + 1) % 4]);
            let outward = -(b - a).perp().normalize_or_zero();
            let count = ((b - a).length() / 3.0).clamp(12.0, 400.0) as usize;
            let points: Vec<DVec2> = (0..count)
                .filter_map(|j| {
                    let p = a + (b - a) * (0.04 + 0.92 * (j as f64 + 0.5) / count as f64);
                    step_at(pixels, surface, p, outward, settings).map(|d| p + d * outward)
                })
                .collect();
            if points.len() * 5 < count { (a, b) } else { trimmed_line(points).unwrap_or((a, b)) }
        });
        let met: Vec<DVec2> = (0..4).filter_map(|k| crossing(lines[(k + 3) % 4], lines[k])).collect();
        let Ok(met) = <[DVec2; 4]>::try_from(met) else { break };
        // A corner that leaps has met the wrong line.
        let size = area(&corners).abs().sqrt();
        if met.iter().zip(&corners).any(|(new, old)| (*new - *old).length() > 0.12 * size) {
            break;
        }
        corners = met;
    }
    corners
}

/// Line with the least squared distances, after three rounds of leaving out the farther points.
fn trimmed_line(mut points: Vec<DVec2>) -> Option<(DVec2, DVec2)> {
    let mut line = None;
    for round in 0..4 {
        if points.len() < 6 {
            return line;
        }
        let center = points.iter().sum::<DVec2>() / points.len() as f64;
        let (mut xx, mut xy, mut yy) = (0.0, 0.0, 0.0);
        for p in &points {
            let d = *p - center;
            (xx, xy, yy) = (xx + d.x * d.x, xy + d.x * d.y, yy + d.y * d.y);
        }
        let direction = DVec2::from_angle(0.5 * (2.0 * xy).atan2(xx - yy));
        line = Some((center, center + direction));
        let error = |p: &DVec2| direction.perp_dot(*p - center).abs();
        let mut errors: Vec<f64> = points.iter().map(error).collect();
        errors.sort_by(f64::total_cmp);
        let limit = (3.0 * errors[errors.len() / 2]).max(if round == 0 { 2.0 } else { 1.0 });
        points.retain(|p| error(p) <= limit);
    }
    line
}

/// The ellipse with the area moments of a polygon.
fn moments(polygon: &[DVec2]) -> Option<Ellipse> {
    let origin = polygon[0];
    let (mut total, mut first) = (0.0, DVec2::ZERO);
    let (mut xx, mut xy, mut yy) = (0.0, 0.0, 0.0);
    for k in 1..polygon.len() - 1 {
        let (b, c) = (polygon[k] - origin, polygon[k + 1] - origin);
        let area = 0.5 * b.perp_dot(c);
        total += area;
        first += area * (b + c) / 3.0;
        // Second moments of a triangle with one corner at the origin.
        let sum = b + c;
        xx += area / 12.0 * (b.x * b.x + c.x * c.x + sum.x * sum.x);
        yy += area / 12.0 * (b.y * b.y + c.y * c.y + sum.y * sum.y);
        xy += area / 12.0 * (b.x * b.y + c.x * c.y + sum.x * sum.y);
    }
    if total <= 1.0 {
        return None;
    }
    let mean = first / total;
    let (xx, xy, yy) =
        (xx / total - mean.x * mean.x, xy / total - mean.x * mean.y, yy / total - mean.y * mean.y);
    let angle_rad = 0.5 * (2.0 * xy).atan2(xx - yy);
    let (half, spread) = (0.5 * (xx + yy), (0.5 * (xx - yy)).hypot(xy));
    // A filled ellipse has a quarter of its squared semi-axes as variances.
    let semi_axes = DVec2::new(2.0 * (half + spread).sqrt(), 2.0 * (half - spread).max(0.0).sqrt());
    (semi_axes.y > 2.0).then(|| Ellipse { center: origin + mean, semi_axes, angle_rad })
}

fn ellipse_on_the_edge(
    pixels: &Pixels,
    surface: &Surface,
    ellipse: Ellipse,
    settings: &VisionSettings,
) -> Ellipse {
    let mut ellipse = ellipse;
    for _ in 0..3 {
        let points: Vec<DVec2> = (0..240)
            .filter_map(|k| {
                let t = std::f64::consts::TAU * f64::from(k) / 240.0;
                let p = ellipse.at(t);
                let along = ellipse.at(t + 0.01) - ellipse.at(t - 0.01);
                let outward = -along.perp().normalize_or_zero();
                step_at(pixels, surface, p, outward, settings).map(|d| p + d * outward)
            })
            .collect();
        if points.len() < 60 {
            break;
        }
        ellipse = ellipse.through(&points).unwrap_or(ellipse);
    }
    ellipse
}
