//! The classical descriptor of a soft image with its derivative. It replaces learned features in the paper's
//! appearance term `L_app =
//!
//! Phi(I_render) - Phi(I_instance)
//!
//! ^2`.
//!
//! It is computed on a grid of square patches, one block of pixels wide. Each patch holds the distribution of gradient
//! orientations, unsigned and weighted by magnitude (as in Dalal and Triggs, "Histograms of oriented gradients", 2005,
//! but as the first harmonics 1, cos 2t, sin 2t, cos 4t, sin 4t of the histogram, which are smooth in the image where
//! bins are not), the mean color and the spread of the gray. Colors are deviations from the image's own mean color,
//! which is also the background: exposure and white balance drop out, and an outline is an edge only where the color
//! beside it differs from the mean. The other loss terms cover the outline itself. Square roots keep one strong patch
//! from dominating. Both halves are normalized to a length near 1, or below it for faint content, and weighted.
//!
//! The definition is close to that of `vision::descriptor`, which scores finished scenes and has no derivative: its
//! patches' color histograms in CIELAB are means and spreads here, its crop's own box the fit of DRO. The values are
//! not comparable with each other, nor with DINOv2's.
//!
//! Only pixels with `known` = 1 count, and gradients only where all four neighbors are known: an occluder is neither
//! shape nor color. Every number carries its derivative by each parameter.
//!
//! Inputs: an image and a plane of its size. Guarantees: the same bits always. Cost: two passes over the blocks with
//! visible pixels, eight pixels at a time. Images of different crops are not comparable.

use std::array::from_fn;

use wide::f32x8;

use soft_raster::color::{CHANNELS, SoftImage};
use soft_raster::loss::Dual;
use soft_raster::{BLOCK_PX, Grid};

/// Gradients up to this are noise, square roots of light a pixel.
const QUIET: f32 = 0.008;

/// Sum of gradients in a patch up to which the root is bent.
const FEW_LINES: f64 = 0.1;

/// Spread of gray up to which the root is bent.
const EVEN: f64 = 0.01;

/// Length of the lines' half, and of the colors', at which it counts for 0.7 of what it would.
const FAINT_LINES: f64 = 1.5;
const FAINT_COLORS: f64 = 0.25;

/// Share of the squared length that is the colors', 0..1.
const COLOR_SHARE: f64 = 0.5;

/// Numbers of a patch: of lines, of colors.
const LINES: usize = 5;
const COLORS: usize = 4;

/// Luma of red, green and blue.
const LUMA: [f32; 3] = [0.299, 0.587, 0.114];

/// A descriptor and its derivatives by each parameter.
#[derive(Clone, Debug, PartialEq)]
pub struct Descriptor<const N: usize> {
    values: Vec<f64>,
    slopes: [Vec<f64>; N],
}

/// Mask of the pixels that count; as large as the images.
#[derive(Clone, Debug, PartialEq)]
pub struct KnownPixels {
    grid: Grid,
    known: Vec<f32>,
    /// 1 where all four neighbors are known too.
    inner: Vec<f32>,
}

/// Working memory for descriptions.
#[derive(Debug)]
pub struct DescriptorRoom<const N: usize> {
    gray: Vec<f32>,
    gray_slopes: [Vec<f32>; N],
}

impl<const N: usize> Default for DescriptorRoom<N> {
    fn default() -> Self {
        Self { gray: Vec::new(), gray_slopes: from_fn(|_| Vec::new()) }
    }
}

impl KnownPixels {
    /// `known` is 0 or 1, row-major, `grid.pixels()` long.
    pub fn new(grid: Grid, known: Vec<f32>) -> Self {
        let (width, height) = (grid.width_px(), grid.height_px);
        let mut inner = vec![0.0; known.len()];
        for (x, y) in (1..height - 1).flat_map(|y| (1..width - 1).map(move |x| (x, y))) {
            let at = y * width + x;
            inner[at] = [at, at - 1, at + 1, at - width, at + width].iter().map(|&k| known[k]).product();
        }
        Self { grid, known, inner }
    }
}

impl<const N: usize> Descriptor<N> {
    /// `||self - other||^2` and its derivative.
    pub fn squared_distance(&self, other: &Descriptor<0>) -> Dual<N> {
        let apart = || self.values.iter().zip(&other.values).map(|(a, b)| a - b);
        let along = |slopes: &Vec<f64>| 2.0 * apart().zip(slopes).map(|(d, s)| d * s).sum::<f64>();
        Dual { value: apart().map(|d| d * d).sum(), slopes: from_fn(|k| along(&self.slopes[k])) }
    }
}

/// Describes an image. All 0 if no known pixel is visible.
pub fn describe<const N: usize>(
    image: &SoftImage<N>,
    pixels: &KnownPixels,
    room: &mut DescriptorRoom<N>,
) -> Descriptor<N> {
    let grid = image.grid();
    let patches = grid.blocks_across * grid.height_px.div_ceil(BLOCK_PX);
    let mut lines = Half::<N>::new(patches * LINES);
    let mut colors = Half::<N>::new(patches * COLORS);
    let means = MeanColor::of(image, pixels);
    room.fill(image, &means);
    for patch in 0..patches {
        let sums = PatchSums::of(image, pixels, room, patch);
        lines.set(LINES * patch, sums.lines());
        colors.set(COLORS * patch, sums.colors(&means));
    }
    lines.normalize(FAINT_LINES, 1.0 - COLOR_SHARE);
    colors.normalize(FAINT_COLORS, COLOR_SHARE);
    lines.values.extend(colors.values);
    for (slopes, others) in lines.slopes.iter_mut().zip(colors.slopes) {
        slopes.extend(others);
    }
    Descriptor { values: lines.values, slopes: lines.slopes }
}

/// A number and its derivatives, in pixels' precision and eight lanes.
#[derive(Clone, Copy)]
struct Lanes<const N: usize> {
    value: f32x8,
    slopes: [f32x8; N],
}

impl<const N: usize> Lanes<N> {
    const ZERO: Self = Self { value: f32x8::ZERO, slopes: [f32x8::ZERO; N] };

    #[inline]
    fn add(&mut self, other: Self) {
        self.value += other.value;
        (0..N).for_each(|k| self.slopes[k] += other.slopes[k]);
    }

    #[inline]
    fn times(self, factor: f32x8) -> Self {
        Self { value: self.value * factor, slopes: self.slopes.map(|s| s * factor) }
    }

    fn sum(self) -> Dual<N> {
        let total = |lanes: f32x8| f64::from(lanes.reduce_add());
        Dual { value: total(self.value), slopes: self.slopes.map(total) }
    }
}

#[inline]
fn eight(plane: &[f32], at: usize) -> f32x8 {
    let mut lanes = [0.0; BLOCK_PX];
    lanes.copy_from_slice(&plane[at..at + BLOCK_PX]);
    f32x8::from(lanes)
}

#[inline]
fn channel<const N: usize>(image: &SoftImage<N>, number: usize, at: usize) -> Lanes<N> {
    Lanes {
        value: eight(&image.planes()[number], at),
        slopes: from_fn(|k| eight(&image.slopes()[k][number], at)),
    }
}

/// Mean color of the known pixels of an image.
struct MeanColor<const N: usize>([Dual<N>; 3]);

impl<const N: usize> MeanColor<N> {
    fn of(image: &SoftImage<N>, pixels: &KnownPixels) -> Self {
        let nothing = Dual { value: 0.0, slopes: [0.0; N] };
        let mut sums = [nothing; CHANNELS];
        for row in image.shown().chunks(image.grid().blocks_across).enumerate() {
            let mut row_sums = [Lanes::ZERO; CHANNELS];
            for (block, _) in row.1.iter().enumerate().filter(|(_, shown)| **shown) {
                let at = (row.0 * row.1.len() + block) * BLOCK_PX;
                let known = eight(&pixels.known, at);
                (0..CHANNELS).for_each(|c| row_sums[c].add(channel(image, c, at).times(known)));
            }
            for (sum, row) in sums.iter_mut().zip(row_sums) {
                let row = row.sum();
                sum.value += row.value;
                (0..N).for_each(|k| sum.slopes[k] += row.slopes[k]);
            }
        }
        let [r, g, b, weight] = sums;
        if weight.value < 1.0 {
            return Self([nothing; 3]);
        }
        Self([r, g, b].map(|color| {
            let value = color.value / weight.value;
            let slope = |k: usize| (color.slopes[k] - value * weight.slopes[k]) / weight.value;
            Dual { value, slopes: from_fn(slope) }
        }))
    }

    fn luma(&self) -> Dual<N> {
        let total = |of: &dyn Fn(&Dual<N>) -> f64| -> f64 {
            self.0.iter().zip(LUMA).map(|(color, share)| f64::from(share) * of(color)).sum()
        };
        Dual { value: total(&|c| c.value), slopes: from_fn(|k| total(&|c| c.slopes[k])) }
    }
}

impl<const N: usize> DescriptorRoom<N> {
    /// The gray image, its mean color's gray subtracted where it is seen.
    fn fill(&mut self, image: &SoftImage<N>, means: &MeanColor<N>) {
        let pixels = image.grid().pixels();
        for plane in self.gray_slopes.iter_mut().chain([&mut self.gray]) {
            plane.clear();
            plane.resize(pixels, 0.0);
        }
        let mean = means.luma();
        let (value, slopes) = (f32x8::splat(mean.value as f32), mean.slopes.map(|s| f32x8::splat(s as f32)));
        for (block, _) in image.shown().iter().enumerate().filter(|(_, shown)| **shown) {
            let at = block * BLOCK_PX;
            let mut gray = Lanes::<N>::ZERO;
            (0..3).for_each(|c| gray.add(channel(image, c, at).times(f32x8::splat(LUMA[c]))));
            let weight = channel(image, CHANNELS - 1, at);
            let store = |plane: &mut Vec<f32>, lanes: f32x8| {
                plane[at..at + BLOCK_PX].copy_from_slice(&lanes.to_array());
            };
            store(&mut self.gray, gray.value - weight.value * value);
            for (k, &mean_slope) in slopes.iter().enumerate() {
                let slope = gray.slopes[k] - weight.slopes[k] * value - weight.value * mean_slope;
                store(&mut self.gray_slopes[k], slope);
            }
        }
    }
}

/// Sums over the known pixels of a patch.
struct PatchSums<const N: usize> {
    lines: [Lanes<N>; LINES],
    /// Premultiplied red, green, blue, and weight.
    colors: [Lanes<N>; CHANNELS],
    gray: Lanes<N>,
    gray_squared: Lanes<N>,
    known: f32x8,
}

impl<const N: usize> PatchSums<N> {
    fn of(image: &SoftImage<N>, pixels: &KnownPixels, room: &DescriptorRoom<N>, patch: usize) -> Self {
        let grid = image.grid();
        let (across, height) = (grid.blocks_across, grid.height_px);
        let (column, top) = (patch % across, patch / across * BLOCK_PX);
        let mut sums = Self {
            lines: [Lanes::ZERO; LINES],
            colors: [Lanes::ZERO; CHANNELS],
            gray: Lanes::ZERO,
            gray_squared: Lanes::ZERO,
            known: f32x8::ZERO,
        };
        for y in top..(top + BLOCK_PX).min(height) {
            let at = (y * across + column) * BLOCK_PX;
            let known = eight(&pixels.known, at);
            sums.known += known;
            if image.shown()[y * across + column] {
                (0..CHANNELS).for_each(|c| sums.colors[c].add(channel(image, c, at).times(known)));
                let gray = eight(&room.gray, at);
                let slopes: [f32x8; N] = from_fn(|k| eight(&room.gray_slopes[k], at));
                sums.gray.add(Lanes { value: gray, slopes }.times(known));
                let slopes = slopes.map(|s| (gray + gray) * s);
                sums.gray_squared.add(Lanes { value: gray * gray, slopes }.times(known));
            }
            let beside = column.saturating_sub(1)..(column + 2).min(across);
            let near = (y.saturating_sub(1)..(y + 2).min(height))
                .any(|v| image.shown()[v * across..][beside.clone()].contains(&true));
            // The image's first and last row and column are not inner.
            if near && y > 0 && y + 1 < height {
                sums.add_lines(pixels, room, at, grid.width_px());
            }
        }
        sums
    }

    #[inline]
    fn add_lines(&mut self, pixels: &KnownPixels, room: &DescriptorRoom<N>, at: usize, width: usize) {
        let inner = eight(&pixels.inner, at);
        let half = f32x8::splat(0.5);
        let gradient = |plane: &[f32]| {
            let left = if at > 0 { eight(plane, at - 1) } else { f32x8::ZERO };
            let right = if at + BLOCK_PX < plane.len() { eight(plane, at + 1) } else { f32x8::ZERO };
            (half * (right - left), half * (eight(plane, at + width) - eight(plane, at - width)))
        };
        let (gx, gy) = gradient(&room.gray);
        let (two, quiet2) = (f32x8::splat(2.0), f32x8::splat(QUIET * QUIET));
        let square = gx * gx + gy * gy + quiet2;
        let (root, per_square) = (square.sqrt(), f32x8::ONE / square);
        let magnitude = (root - f32x8::splat(QUIET)) * inner;
        // cos 2t and sin 2t of the gradient's direction, smaller where it is faint.
        let (c, s) = ((gx * gx - gy * gy) * per_square, two * gx * gy * per_square);
        let harmonics = [f32x8::ONE, c, s, c * c - s * s, two * c * s];
        for (sum, harmonic) in self.lines.iter_mut().zip(harmonics) {
            sum.value += magnitude * harmonic;
        }
        for k in 0..N {
            let (vx, vy) = gradient(&room.gray_slopes[k]);
            let grows = two * (gx * vx + gy * vy);
            let magnitude_slope = half * grows / root * inner;
            let c_slope = (two * (gx * vx - gy * vy) - c * grows) * per_square;
            let s_slope = (two * (gx * vy + gy * vx) - s * grows) * per_square;
            let turning = [
                f32x8::ZERO,
                c_slope,
                s_slope,
                two * (c * c_slope - s * s_slope),
                two * (c * s_slope + s * c_slope),
            ];
            for ((sum, harmonic), slope) in self.lines.iter_mut().zip(harmonics).zip(turning) {
                sum.slopes[k] += magnitude_slope * harmonic + magnitude * slope;
            }
        }
    }

    /// The harmonics over the square root of the first.
    fn lines(&self) -> [Dual<N>; LINES] {
        let sums = self.lines.map(Lanes::sum);
        let total = &sums[0];
        let root = (total.value.max(0.0) + FEW_LINES).sqrt();
        sums.each_ref().map(|sum| {
            let value = sum.value / root;
            let slope = |k: usize| (sum.slopes[k] - 0.5 * value * total.slopes[k] / root) / root;
            Dual { value, slopes: from_fn(slope) }
        })
    }

    /// Mean deviation from the mean color, and the spread of gray.
    fn colors(&self, means: &MeanColor<N>) -> [Dual<N>; COLORS] {
        let area = (BLOCK_PX * BLOCK_PX) as f64;
        let known = f64::from(self.known.reduce_add());
        let [r, g, b, weight] = self.colors.map(Lanes::sum);
        let [r, g, b] = [(r, 0), (g, 1), (b, 2)].map(|(color, c)| {
            let mean = &means.0[c];
            let slope =
                |k: usize| color.slopes[k] - weight.slopes[k] * mean.value - weight.value * mean.slopes[k];
            Dual {
                value: (color.value - weight.value * mean.value) / area,
                slopes: from_fn(|k| slope(k) / area),
            }
        });
        let (gray, squared) = (self.gray.sum(), self.gray_squared.sum());
        let per_known = 1.0 / known.max(1.0);
        let mean = gray.value * per_known;
        let variance = (squared.value * per_known - mean * mean).max(0.0);
        // A partly known patch is weighted by its known share, as its mean color is.
        let share = known / area;
        let root = (variance + EVEN * EVEN).sqrt();
        let slope = |k: usize| per_known * (squared.slopes[k] - 2.0 * mean * gray.slopes[k]);
        let spread =
            Dual { value: share * (root - EVEN), slopes: from_fn(|k| share * 0.5 * slope(k) / root) };
        [r, g, b, spread]
    }
}

/// One half of the descriptor.
struct Half<const N: usize> {
    values: Vec<f64>,
    slopes: [Vec<f64>; N],
}

impl<const N: usize> Half<N> {
    fn new(length: usize) -> Self {
        Self { values: vec![0.0; length], slopes: from_fn(|_| vec![0.0; length]) }
    }

    fn set<const M: usize>(&mut self, from: usize, numbers: [Dual<N>; M]) {
        for (at, number) in numbers.into_iter().enumerate() {
            self.values[from + at] = number.value;
            (0..N).for_each(|k| self.slopes[k][from + at] = number.slopes[k]);
        }
    }

    /// To a squared length of `share`, less where the length is not far above `faint`.
    fn normalize(&mut self, faint: f64, share: f64) {
        let square: f64 = self.values.iter().map(|v| v * v).sum::<f64>() + faint * faint;
        let scale = (share / square).sqrt();
        for slopes in &mut self.slopes {
            let along: f64 = self.values.iter().zip(&*slopes).map(|(v, s)| v * s).sum::<f64>() / square;
            slopes.iter_mut().zip(&self.values).for_each(|(s, v)| *s = scale * (*s - v * along));
        }
        self.values.iter_mut().for_each(|v| *v *= scale);
    }
}

#[cfg(test)]
mod tests;
