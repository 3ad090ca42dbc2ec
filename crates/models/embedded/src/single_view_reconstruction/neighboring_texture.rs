//! Inpainting of an object's occluded pixels with the texture of its visible part.
//!
//! Exemplar-based (Criminisi, Perez and Toyama, "Region filling and object removal by exemplar-based image
//! inpainting", 2004). It proceeds from the edge inward, first where lines run into the gap. Each patch is filled
//! from the visible patch most similar to its known part, so stripes continue and prints repeat. Patches are
//! sought in a copy reduced to [`WORK_PX`]; pixels come from the same position of the full image. Without enough
//! visible patches the nearest visible color is used. Deterministic; at most about [`MAX_COMPARED`] pixel
//! comparisons, some 50 ms.

use imaging::Image;
use runtime::{CancelFlag, Cancelled};

/// Longest side of the copy in which patches are sought, pixels.
const WORK_PX: usize = 112;
/// Half sides of patches; smaller ones if there are too few larger examples.
const HALVES: [usize; 3] = [4, 3, 2];
/// Minimum number of examples.
const MIN_EXAMPLES: usize = 40;
/// Maximum number of pixel comparisons; then the nearest color is used.
const MAX_COMPARED: usize = 60_000_000;
/// Depth from which visible pixels have the object's pure color; its edge is mixed with the surroundings.
const MIXED_PX: usize = 2;
/// Cost of a pixel of distance to the example, in squared color differences (0..1 a channel) of a patch.
const NEARER: f32 = 2e-4;

/// Colors of the `hidden` pixels from those of the `visible` ones (flags a pixel of `image`, row by row), in the
/// order of their indices; black if nothing is visible.
pub(super) fn filled(
    image: &Image,
    visible: &[bool],
    hidden: &[bool],
    cancel: &CancelFlag,
) -> Result<Vec<(usize, [u8; 3])>, Cancelled> {
    let (width, height) = (image.width_px() as usize, image.height_px() as usize);
    let own = eroded(visible, width, height);
    let own = if own.contains(&true) { own } else { visible.to_vec() };
    let step = width.max(height).div_ceil(WORK_PX).max(1);
    let mut copy = Copy::new(image, &own, hidden, step);
    copy.fill(cancel)?;
    let color = |index: usize| {
        let (x, y) = (index % width, index / width);
        let cell = (y / step) * copy.width + x / step;
        let example = copy.from[cell];
        let (u, v) = ((example % copy.width) * step + x % step, (example / copy.width) * step + y % step);
        if u < width && v < height && own[v * width + u] {
            let [r, g, b, _] = image.pixel(u as u32, v as u32);
            [r, g, b]
        } else {
            copy.color[example].map(|c| (255.0 * c).round().clamp(0.0, 255.0) as u8)
        }
    };
    Ok(hidden
        .iter()
        .enumerate()
        .filter(|(_, hidden)| **hidden)
        .map(|(index, _)| (index, color(index)))
        .collect())
}

/// Pixels at least [`MIXED_PX`] away from every clear one, along rows and columns.
fn eroded(bits: &[bool], width: usize, height: usize) -> Vec<bool> {
    let deep = |index: usize| {
        let (x, y) = (index % width, index / width);
        let columns = x.saturating_sub(MIXED_PX)..=(x + MIXED_PX).min(width - 1);
        let rows = y.saturating_sub(MIXED_PX)..=(y + MIXED_PX).min(height - 1);
        columns.into_iter().all(|u| bits[y * width + u]) && rows.into_iter().all(|v| bits[v * width + x])
    };
    (0..bits.len()).map(|index| bits[index] && deep(index)).collect()
}

/// The reduced copy.
struct Copy {
    width: usize,
    height: usize,
    color: Vec<[f32; 3]>,
    /// Confidence of the color, 0..1; 0 = unknown.
    confidence: Vec<f32>,
    /// Cells to be filled.
    wanted: Vec<bool>,
    /// Cell from which the color comes.
    from: Vec<usize>,
}

impl Copy {
    fn new(image: &Image, own: &[bool], hidden: &[bool], step: usize) -> Self {
        let (full, full_rows) = (image.width_px() as usize, image.height_px() as usize);
        let (width, height) = (full.div_ceil(step), full_rows.div_ceil(step));
        let count = width * height;
        let mut copy = Self {
            width,
            height,
            color: vec![[0.0; 3]; count],
            confidence: vec![0.0; count],
            wanted: vec![false; count],
            from: (0..count).collect(),
        };
        for cell in 0..count {
            let (x0, y0) = ((cell % width) * step, (cell / width) * step);
            let pixels = (y0..(y0 + step).min(full_rows))
                .flat_map(|y| (x0..(x0 + step).min(full)).map(move |x| (x, y)))
                .collect::<Vec<_>>();
            let known = pixels.iter().filter(|(x, y)| own[y * full + x]);
            let (mut sum, mut seen) = ([0.0_f32; 3], 0_usize);
            for (x, y) in known {
                let pixel = image.pixel(*x as u32, *y as u32);
                (0..3).for_each(|c| sum[c] += f32::from(pixel[c]) / 255.0);
                seen += 1;
            }
            if seen == pixels.len() {
                copy.color[cell] = sum.map(|s| s / seen as f32);
                copy.confidence[cell] = 1.0;
            }
            copy.wanted[cell] = pixels.iter().any(|(x, y)| hidden[y * full + x]);
        }
        // The seam between occluded and certainly visible cells is filled too.
        let reach = (2 * MIXED_PX + 1).div_ceil(step) + 1;
        let seam: Vec<bool> = (0..count)
            .map(|cell| copy.confidence[cell] == 0.0 && copy.around(cell, reach).any(|c| copy.wanted[c]))
            .collect();
        copy.wanted = seam;
        copy
    }

    /// Cells at most `half` columns and rows away.
    fn around(&self, cell: usize, half: usize) -> impl Iterator<Item = usize> + use<> {
        let (x, y, width) = (cell % self.width, cell / self.width, self.width);
        let columns = x.saturating_sub(half)..(x + half + 1).min(self.width);
        (y.saturating_sub(half)..(y + half + 1).min(self.height))
            .flat_map(move |v| columns.clone().map(move |u| v * width + u))
    }

    fn is_known(&self, cell: usize) -> bool {
        self.confidence[cell] > 0.0
    }

    fn fill(&mut self, cancel: &CancelFlag) -> Result<(), Cancelled> {
        let chosen = HALVES.into_iter().map(|half| (half, self.examples(half)));
        let chosen = chosen.into_iter().find(|(_, examples)| examples.len() >= MIN_EXAMPLES);
        if let Some((half, examples)) = chosen {
            let mut left = MAX_COMPARED;
            while let Some(target) = self.next(half) {
                cancel.check()?;
                let compared = examples.len() * (2 * half + 1).pow(2);
                if left < compared {
                    break;
                }
                left -= compared;
                self.copy_patch(target, half, &examples);
            }
        }
        cancel.check()?;
        self.spread();
        Ok(())
    }

    /// Centers of fully visible patches.
    fn examples(&self, half: usize) -> Vec<usize> {
        let whole = |cell: &usize| {
            let (x, y) = (cell % self.width, cell / self.width);
            x >= half
                && y >= half
                && x + half < self.width
                && y + half < self.height
                && self.around(*cell, half).all(|c| self.is_known(c))
        };
        (0..self.color.len()).filter(whole).collect()
    }

    /// The cell on the edge of the gap of highest priority: confidence of its patch times strength of the incoming
    /// line.
    fn next(&self, half: usize) -> Option<usize> {
        let open = |cell: usize| self.wanted[cell] && !self.is_known(cell);
        let edge = (0..self.color.len())
            .filter(|&cell| open(cell) && self.around(cell, 1).any(|c| c != cell && self.is_known(c)));
        let priority = |cell: usize| {
            let (mut sure, mut count) = (0.0, 0);
            let (mut line, mut strongest) = ([0.0; 2], 0.0_f32);
            for c in self.around(cell, half) {
                count += 1;
                sure += self.confidence[c];
                if let Some(slope) = self.slope(c) {
                    let strength = slope[0].hypot(slope[1]);
                    if strength > strongest {
                        (line, strongest) = ([-slope[1], slope[0]], strength);
                    }
                }
            }
            // Toward the known side.
            let (mut normal, x, y) = ([0.0_f32; 2], (cell % self.width) as f32, (cell / self.width) as f32);
            for c in self.around(cell, 2).filter(|&c| self.is_known(c)) {
                normal[0] += (c % self.width) as f32 - x;
                normal[1] += (c / self.width) as f32 - y;
            }
            let length = normal[0].hypot(normal[1]).max(1e-6);
            let runs_in = ((line[0] * normal[0] + line[1] * normal[1]) / length).abs();
            sure / count as f32 * (runs_in + 0.02)
        };
        edge.map(|cell| (cell, priority(cell)))
            .max_by(|a, b| a.1.total_cmp(&b.1).then(b.0.cmp(&a.0)))
            .map(|(cell, _)| cell)
    }

    /// Gradient of the lightness at a cell whose four neighbors are known.
    fn slope(&self, cell: usize) -> Option<[f32; 2]> {
        let (x, y) = (cell % self.width, cell / self.width);
        if x == 0 || y == 0 || x + 1 == self.width || y + 1 == self.height || !self.is_known(cell) {
            return None;
        }
        let light = |c: usize| self.is_known(c).then(|| self.color[c].iter().sum::<f32>() / 3.0);
        let across = light(cell + 1)? - light(cell - 1)?;
        let down = light(cell + self.width)? - light(cell - self.width)?;
        Some([0.5 * across, 0.5 * down])
    }

    /// Fills the open cells of the patch around `target` from the example most similar to its known cells.
    fn copy_patch(&mut self, target: usize, half: usize, examples: &[usize]) {
        let at = |cell: usize| ((cell % self.width) as i64, (cell / self.width) as i64);
        let (x, y) = at(target);
        let patch: Vec<usize> = self.around(target, half).collect();
        let offset = |cell: usize| {
            let (u, v) = at(cell);
            (v - y) * self.width as i64 + (u - x)
        };
        let known: Vec<(i64, [f32; 3])> =
            patch.iter().filter(|&&c| self.is_known(c)).map(|&c| (offset(c), self.color[c])).collect();
        let mut best = (f32::INFINITY, target);
        for &example in examples {
            let (u, v) = at(example);
            let mut off =
                NEARER * known.len() as f32 / (2 * half + 1) as f32 * ((u - x) as f32).hypot((v - y) as f32);
            for (shift, color) in &known {
                let other = self.color[(example as i64 + shift) as usize];
                off += (0..3).map(|c| (color[c] - other[c]).powi(2)).sum::<f32>();
                if off >= best.0 {
                    break;
                }
            }
            if off < best.0 {
                best = (off, example);
            }
        }
        let sure = patch.iter().map(|&c| self.confidence[c]).sum::<f32>() / patch.len() as f32;
        let open: Vec<(usize, i64)> =
            patch.iter().filter(|&&c| self.wanted[c] && !self.is_known(c)).map(|&c| (c, offset(c))).collect();
        for (cell, shift) in open {
            let example = (best.1 as i64 + shift) as usize;
            self.color[cell] = self.color[example];
            self.from[cell] = example;
            self.confidence[cell] = sure.max(1e-4);
        }
    }

    /// Gives the remaining cells the color of the nearest known one, ring by ring.
    fn spread(&mut self) {
        let mut ring: Vec<usize> = (0..self.color.len()).filter(|&cell| self.is_known(cell)).collect();
        while !ring.is_empty() {
            let mut next = Vec::new();
            for &cell in &ring {
                for c in self.around(cell, 1) {
                    if !self.is_known(c) {
                        self.color[c] = self.color[cell];
                        self.from[c] = self.from[cell];
                        self.confidence[c] = 1e-4;
                        next.push(c);
                    }
                }
            }
            ring = next;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Horizontal stripes of eight pixels; their right half is occluded.
    fn striped() -> (Image, Vec<bool>, Vec<bool>) {
        let mut image = Image::filled(120, 80, [90, 90, 90, 255]);
        for y in 0..80 {
            let color = if y / 8 % 2 == 0 { [200, 40, 30, 255] } else { [240, 235, 225, 255] };
            (0..60).for_each(|x| image.set_pixel(x, y, color));
        }
        let visible = (0..120 * 80).map(|k| k % 120 < 60).collect();
        (image, visible, (0..120 * 80).map(|k| k % 120 >= 60).collect())
    }

    #[test]
    fn inpainting_continues_stripes() {
        let (image, visible, hidden) = striped();
        let stop = CancelFlag::default();
        let filled = filled(&image, &visible, &hidden, &stop).expect("not interrupted");
        assert_eq!(filled.len(), 60 * 80);
        let right = filled.iter().filter(|(index, color)| {
            let is_red = index / 120 / 8 % 2 == 0;
            (color[1] < 130) == is_red
        });
        let share = right.count() as f64 / filled.len() as f64;
        assert!(share > 0.93, "{share}");
    }

    #[test]
    fn inpainting_is_deterministic_and_cancellable() {
        let (image, visible, hidden) = striped();
        let stop = CancelFlag::default();
        let once = filled(&image, &visible, &hidden, &stop).expect("not interrupted");
        assert_eq!(once, filled(&image, &visible, &hidden, &stop).expect("not interrupted"));
        stop.cancel();
        assert!(filled(&image, &visible, &hidden, &stop).is_err());
    }

    #[test]
    fn inpainting_uses_nearest_color_without_examples() {
        let image = Image::filled(30, 20, [10, 120, 200, 255]);
        let few: Vec<bool> = (0..600).map(|k| k % 30 < 3).collect();
        let rest: Vec<bool> = few.iter().map(|visible| !visible).collect();
        let filled = filled(&image, &few, &rest, &CancelFlag::default()).expect("not interrupted");
        assert!(filled.len() == 540 && filled.iter().all(|(_, color)| *color == [10, 120, 200]));
    }
}
