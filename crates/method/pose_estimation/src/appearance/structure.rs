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

    /// Pixels of a square image whose colors decide the [`Self::likeness`] of its structure: those of the
    /// neighborhoods, and the neighbors of these.
    pub fn pixels_compared_with(&self, side_px: usize) -> Vec<bool> {
        let reach = REACH_PX + 1;
        let near = |of: usize| of.saturating_sub(reach)..=(of + reach).min(side_px.saturating_sub(1));
        let mut compared = vec![false; self.0.len()];
        for at in (0..self.0.len()).filter(|at| self.0[*at].is_some()) {
            for y in near(at / side_px) {
                compared[y * side_px..][near(at % side_px)].fill(true);
            }
        }
        compared
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
    let near = |place: usize| place.saturating_sub(REACH_PX)..=(place + REACH_PX).min(side_px - 1);
    let nothing = (Vec3::ZERO, 0.0_f32);
    let add = |(sum, count): (Vec3, f32), (line, seen): (Vec3, f32)| (sum + line, count + seen);
    let seen: Vec<(Vec3, f32)> = lines.iter().map(|line| line.map_or(nothing, |line| (line, 1.0))).collect();
    let mut along_rows = Vec::with_capacity(seen.len());
    for row in seen.chunks_exact(side_px.max(1)) {
        along_rows.extend((0..side_px).map(|x| row[near(x)].iter().fold(nothing, |sum, at| add(sum, *at))));
    }
    let mut means = vec![None; lines.len()];
    for (at, mean) in means.iter_mut().enumerate().filter(|(at, _)| lines[*at].is_some()) {
        let (x, y) = (at % side_px, at / side_px);
        let (sum, count) = near(y).fold(nothing, |sum, y| add(sum, along_rows[y * side_px + x]));
        *mean = Some(sum / count.max(1.0));
    }
    means
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn likeness_depends_on_the_compared_pixels_alone() {
        let side = 24;
        let colors = |shift: usize| -> Vec<Option<Vec3>> {
            let level = |k: usize| ((k * 37 + shift * (k / side)) % 251) as f32;
            (0..side * side).map(|k| Some(Vec3::new(level(k), level(k + 5), level(k / 2)))).collect()
        };
        // Seen in two parts, one of them at the border.
        let is_seen =
            |k: usize| (k % side < 4 && k / side < 9) || ((11..15).contains(&(k % side)) && k / side > 8);
        let seen: Vec<Option<Vec3>> =
            colors(3).into_iter().enumerate().map(|(k, color)| color.filter(|_| is_seen(k))).collect();
        let structure = Structure::new(&seen, side);
        let compared = structure.pixels_compared_with(side);
        let left_out = compared.iter().filter(|compared| !**compared).count();
        assert!((100..400).contains(&left_out), "{left_out} pixels are not compared");
        let all = colors(8);
        let few: Vec<Option<Vec3>> =
            all.iter().zip(&compared).map(|(color, compared)| color.filter(|_| *compared)).collect();
        let likeness = structure.likeness(&Structure::new(&all, side));
        assert_ne!(likeness, 0.0);
        assert_eq!(likeness.to_bits(), structure.likeness(&Structure::new(&few, side)).to_bits());
    }
}
