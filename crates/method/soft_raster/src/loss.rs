//! The loss of a soft silhouette against a mask, with derivatives: TabletopGen's silhouette and edge terms.
//!
//! - `L_sil = 1 - sum(S^ S) / sum(S + S^ - S S^)`, the soft intersection over union;
//! - `L_edge = sum(D_S E^) / sum(E^) / side`, the one-sided chamfer distance: `E^` the Sobel magnitude of the soft
//!   silhouette S^, `D_S` the distance to the contour of the mask S.
//!
//! Pixels whose `known` is 0 have no weight in any sum; the edge term excludes the image's first and last column. The
//! magnitude is `sqrt(gx^2 + gy^2 + eps) - sqrt(eps)`: smooth at 0, and 0 where nothing changes; otherwise the whole
//! image would be a faint edge far from the contour. Sums of rows are in f32, of rows together in f64, in order: the
//! same bits always. Cost: a pass over the image, Sobel only near the outline.

use std::array::from_fn;

use wide::f32x8;

use super::{BLOCK_PX, Grid, SoftSilhouette};

/// `eps` of the magnitude, squared Sobel units (a full edge is 4): bends the edge map below 1/1000 of a
/// full edge.
pub(super) const EDGE_EPSILON: f32 = 1e-6;

/// Areas and edge sums below this count as zero, pixels.
const NOTHING: f64 = 1e-9;

/// The target of a comparison; all planes row-major and as large as the silhouette.
#[derive(Clone, Copy, Debug)]
pub struct Target<'a> {
    /// Soft mask, 0..1; 0 where unknown.
    pub mask: &'a [f32],
    /// 1 where the pixel is known, 0 where an occluder may hide the object.
    pub known: &'a [f32],
    /// Distance to the mask's contour, pixels.
    pub distance_px: &'a [f32],
    /// Sum of `mask`.
    pub mask_area_px2: f64,
    /// Length by which the edge term's distance is divided: the crop's side, pixels.
    pub side_px: f64,
}

/// A number and its derivative with respect to each parameter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dual<const N: usize> {
    pub value: f64,
    pub slopes: [f64; N],
}

/// The two terms, before weighting.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SoftTerms<const N: usize> {
    pub silhouette: Dual<N>,
    pub edge: Dual<N>,
}

impl<const N: usize> SoftTerms<N> {
    /// The terms of a silhouette that has no overlap with the mask and cannot be moved: behind the camera.
    pub const HOPELESS: Self = Self {
        silhouette: Dual { value: 1.0, slopes: [0.0; N] },
        edge: Dual { value: 1.0, slopes: [0.0; N] },
    };

    /// `silhouette_weight * L_sil + edge_weight * L_edge`.
    pub fn weighted(&self, silhouette_weight: f64, edge_weight: f64) -> Dual<N> {
        let sum = |s: f64, e: f64| silhouette_weight * s + edge_weight * e;
        Dual {
            value: sum(self.silhouette.value, self.edge.value),
            slopes: from_fn(|k| sum(self.silhouette.slopes[k], self.edge.slopes[k])),
        }
    }
}

/// Compares a silhouette with a target of its size.
pub fn terms<const N: usize>(drawn: &SoftSilhouette<N>, target: &Target) -> SoftTerms<N> {
    let grid = drawn.grid();
    let mut sums = LossSums::NOTHING;
    let mut near = NearRow::default();
    for y in 0..grid.height_px {
        let mut row = RowSums::new();
        row.add_overlap(drawn, target, grid, y);
        row.add_edges(drawn, target, grid, y, near.of(drawn, y));
        row.common.add_to(&mut sums.common);
        row.covered.add_to(&mut sums.covered);
        row.far.add_to(&mut sums.far);
        row.edges.add_to(&mut sums.edges);
    }
    sums.terms(target.mask_area_px2, target.side_px)
}

/// The four sums over the image that the two terms are made of.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct LossSums<const N: usize> {
    /// Coverage times mask.
    pub common: Dual<N>,
    /// Coverage where known.
    pub covered: Dual<N>,
    /// Edge magnitude times distance.
    pub far: Dual<N>,
    /// Edge magnitude.
    pub edges: Dual<N>,
}

impl<const N: usize> LossSums<N> {
    pub const NOTHING: Self = {
        let nothing = Dual { value: 0.0, slopes: [0.0; N] };
        Self { common: nothing, covered: nothing, far: nothing, edges: nothing }
    };

    /// Both as in [`Target`].
    pub fn terms(&self, mask_area_px2: f64, side_px: f64) -> SoftTerms<N> {
        let Self { common, covered, far, edges } = self;
        let union = Dual {
            value: mask_area_px2 + covered.value - common.value,
            slopes: from_fn(|k| covered.slopes[k] - common.slopes[k]),
        };
        let (overlap, distance) = (ratio(common, &union), ratio(far, edges));
        SoftTerms {
            silhouette: Dual { value: 1.0 - overlap.value, slopes: overlap.slopes.map(|s| -s) },
            edge: Dual { value: distance.value / side_px, slopes: distance.slopes.map(|s| s / side_px) },
        }
    }
}

/// A quotient; its derivatives are 0 for a vanishing denominator.
fn ratio<const N: usize>(a: &Dual<N>, b: &Dual<N>) -> Dual<N> {
    if b.value <= NOTHING {
        return Dual { value: a.value / NOTHING, slopes: [0.0; N] };
    }
    let value = a.value / b.value;
    Dual { value, slopes: from_fn(|k| (a.slopes[k] - value * b.slopes[k]) / b.value) }
}

/// A sum over a row, still in eight lanes.
#[derive(Clone, Copy)]
struct Lanes<const N: usize> {
    value: f32x8,
    slopes: [f32x8; N],
}

impl<const N: usize> Lanes<N> {
    const ZERO: Self = Self { value: f32x8::ZERO, slopes: [f32x8::ZERO; N] };

    fn add_to(&self, total: &mut Dual<N>) {
        total.value += f64::from(self.value.reduce_add());
        for k in 0..N {
            total.slopes[k] += f64::from(self.slopes[k].reduce_add());
        }
    }
}

/// [`LossSums`] over one row.
struct RowSums<const N: usize> {
    common: Lanes<N>,
    covered: Lanes<N>,
    far: Lanes<N>,
    edges: Lanes<N>,
}

#[inline(always)]
fn load(plane: &[f32], at: usize) -> f32x8 {
    let mut lanes = [0.0; BLOCK_PX];
    lanes.copy_from_slice(&plane[at..at + BLOCK_PX]);
    f32x8::from(lanes)
}

/// Blocks of a row that can have edges; keep it to save allocations.
#[derive(Default)]
struct NearRow {
    /// In the row, the one above or the one below.
    column: Vec<bool>,
    near: Vec<bool>,
}

impl NearRow {
    /// Of each block of row `y`, whether one of the nine around it is near the outline.
    fn of<const N: usize>(&mut self, drawn: &SoftSilhouette<N>, y: usize) -> &[bool] {
        let Grid { blocks_across: across, height_px } = drawn.grid();
        let row = |y: usize| &drawn.near_outline()[y * across..][..across];
        let rows = row(y.saturating_sub(1)).iter().zip(row(y)).zip(row((y + 1).min(height_px - 1)));
        self.column.clear();
        self.column.extend(rows.map(|((above, here), below)| above | here | below));
        self.near.clear();
        let column = &self.column;
        let beside = |block: usize| column[block.saturating_sub(1)] | column[(block + 1).min(across - 1)];
        self.near.extend((0..across).map(|block| column[block] | beside(block)));
        &self.near
    }
}

/// Three rows of a plane around a block: its Sobel derivatives along x and y.
struct Sobel<'a> {
    rows: [&'a [f32]; 3],
}

impl<'a> Sobel<'a> {
    fn new(plane: &'a [f32], grid: Grid, y: usize) -> Self {
        let width = grid.width_px();
        let row = |y: usize| &plane[y * width..(y + 1) * width];
        Self { rows: [row(y.saturating_sub(1)), row(y), row((y + 1).min(grid.height_px - 1))] }
    }

    #[inline(always)]
    fn at(&self, block: usize) -> (f32x8, f32x8) {
        let x = block * BLOCK_PX;
        let [above, here, below] = self.rows;
        let (above, here, below) = (around(above, x), around(here, x), around(below, x));
        let two = f32x8::splat(2.0);
        let dx = (above.2 - above.0) + two * (here.2 - here.0) + (below.2 - below.0);
        let dy = (below.0 - above.0) + two * (below.1 - above.1) + (below.2 - above.2);
        (dx, dy)
    }
}

/// A block's pixels, those to their left and those to their right: left, own, right.
#[inline(always)]
fn around(row: &[f32], x: usize) -> (f32x8, f32x8, f32x8) {
    (left_of(row, x), load(row, x), right_of(row, x))
}

/// The pixels to the left of a block's own; at the border the border pixel itself.
#[inline(always)]
fn left_of(row: &[f32], x: usize) -> f32x8 {
    if x > 0 {
        return load(row, x - 1);
    }
    f32x8::from(from_fn(|k: usize| row[k.saturating_sub(1)]))
}

#[inline(always)]
fn right_of(row: &[f32], x: usize) -> f32x8 {
    if x + BLOCK_PX < row.len() {
        return load(row, x + 1);
    }
    f32x8::from(from_fn(|k: usize| row[(x + k + 1).min(row.len() - 1)]))
}

impl<const N: usize> RowSums<N> {
    fn new() -> Self {
        Self { common: Lanes::ZERO, covered: Lanes::ZERO, far: Lanes::ZERO, edges: Lanes::ZERO }
    }

    fn add_overlap(&mut self, drawn: &SoftSilhouette<N>, target: &Target, grid: Grid, y: usize) {
        for block in y * grid.blocks_across..(y + 1) * grid.blocks_across {
            let at = block * BLOCK_PX;
            // Away from the outline a block is covered throughout or not at all; empty blocks contribute 0.
            if !drawn.near_outline()[block] && drawn.coverage()[at] == 0.0 {
                continue;
            }
            let coverage = load(drawn.coverage(), at);
            let (mask, known) = (load(target.mask, at), load(target.known, at));
            self.common.value += coverage * mask;
            self.covered.value += coverage * known;
            if drawn.near_outline()[block] {
                for (k, plane) in drawn.slopes().iter().enumerate() {
                    let slope = load(plane, at);
                    self.common.slopes[k] += slope * mask;
                    self.covered.slopes[k] += slope * known;
                }
            }
        }
    }

    /// `near` of each block of the row as [`NearRow::of`] tells it.
    fn add_edges(&mut self, drawn: &SoftSilhouette<N>, target: &Target, grid: Grid, y: usize, near: &[bool]) {
        let across = grid.blocks_across;
        let epsilon = f32x8::splat(EDGE_EPSILON);
        let soft = Sobel::new(drawn.coverage(), grid, y);
        let moving: [Sobel; N] = from_fn(|k| Sobel::new(&drawn.slopes()[k], grid, y));
        for block in (0..across).filter(|&block| near[block]) {
            let at = y * grid.width_px() + block * BLOCK_PX;
            let mut known = load(target.known, at).to_array();
            if block == 0 {
                known[0] = 0.0;
            }
            if block + 1 == across {
                known[BLOCK_PX - 1] = 0.0;
            }
            let (known, distance) = (f32x8::from(known), load(target.distance_px, at));
            let (dx, dy) = soft.at(block);
            let length = (dx * dx + dy * dy + epsilon).sqrt();
            let edge = (length - epsilon.sqrt()) * known;
            self.edges.value += edge;
            self.far.value += edge * distance;
            let per_length = known / length;
            for (k, sobel) in moving.iter().enumerate() {
                let (vx, vy) = sobel.at(block);
                let slope = (dx * vx + dy * vy) * per_length;
                self.edges.slopes[k] += slope;
                self.far.slopes[k] += slope * distance;
            }
        }
    }
}
