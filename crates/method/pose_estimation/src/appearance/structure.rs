//! Line structure of an object's image, independent of its colors.
//!
//! The structure tensor of Bigun and Granlund (1987) without its scale: at each pixel the gradient's strength, and a
//! vector of twice its direction, so that a line and its negative are equal. Square roots keep one strong line from
//! dominating. Means over a neighborhood tolerate small offsets. Only pixels whose four neighbors belong to the object
//! count, so the outline, which other terms compare, has no effect.

use glam::Vec3;

/// Pixels to either side over which lines are gathered.
const REACH_PX: usize = 2;

/// Gradients up to this are noise, gray levels a pixel.
const QUIET_PER_PX: f32 = 2.0;

/// Mean square of the gathered lines below which an image has none to compare, gray levels a pixel.
const NO_LINES: f64 = 0.02;

/// For each pixel the strength of its lines, and twice their direction as a vector; `None` where the object is not
/// visible.
pub struct Structure(Vec<Option<Vec3>>);

impl Structure {
    /// Of a square image, row-major, sRGB 0..255, `None` where the object is not seen.
    pub fn new(colors: &[Option<Vec3>], side_px: usize) -> Self {
        let luma = Vec3::new(0.299, 0.587, 0.114);
        let gray: Vec<Option<f32>> = colors.iter().map(|color| color.map(|c| c.dot(luma))).collect();
        let mut lines = vec![None; gray.len()];
        for y in 1..side_px.saturating_sub(1) {
            for x in 1..side_px - 1 {
                let at = y * side_px + x;
                let across = gray[at - 1].zip(gray[at + 1]);
                let along = gray[at - side_px].zip(gray[at + side_px]);
                if let (Some(_), Some((left, right)), Some((above, below))) = (gray[at], across, along) {
                    lines[at] = Some(line(0.5 * (right - left), 0.5 * (below - above)));
                }
            }
        }
        Self(gathered(&lines, side_px))
    }

    /// Correlation over what both show, -1..1; 0 where either has no lines.
    pub fn likeness(&self, other: &Self) -> f64 {
        let pairs: Vec<(Vec3, Vec3)> =
            self.0.iter().zip(&other.0).filter_map(|(a, b)| (*a).zip(*b)).collect();
        super::correlation_above(&pairs, NO_LINES)
    }
}

fn line(dx: f32, dy: f32) -> Vec3 {
    let square = dx * dx + dy * dy;
    if square <= QUIET_PER_PX * QUIET_PER_PX {
        return Vec3::ZERO;
    }
    let strength = square.sqrt().sqrt();
    strength * Vec3::new(1.0, (dx * dx - dy * dy) / square, 2.0 * dx * dy / square)
}

/// Means over the neighborhood, of what is seen of it.
fn gathered(lines: &[Option<Vec3>], side_px: usize) -> Vec<Option<Vec3>> {
    let sums_along = |from: &[(Vec3, f32)], stride: usize| -> Vec<(Vec3, f32)> {
        (0..from.len())
            .map(|k| {
                let place = k / stride % side_px;
                let (low, high) = (place.saturating_sub(REACH_PX), (place + REACH_PX).min(side_px - 1));
                (low..=high).fold((Vec3::ZERO, 0.0), |(sum, count), other| {
                    let (line, seen) = from[k - place * stride + other * stride];
                    (sum + line, count + seen)
                })
            })
            .collect()
    };
    let seen: Vec<(Vec3, f32)> =
        lines.iter().map(|line| line.map_or((Vec3::ZERO, 0.0), |line| (line, 1.0))).collect();
    let sums = sums_along(&sums_along(&seen, 1), side_px);
    lines.iter().zip(sums).map(|(line, (sum, count))| line.map(|_| sum / count.max(1.0))).collect()
}
