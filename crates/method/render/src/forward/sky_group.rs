//! Eight sky directions evaluated together, one per SIMD lane.

use glam::{Affine3A, Mat3, Vec3, Vec3A};
use wide::f32x8;

use super::light_map::LightMap;

/// Depth maps of up to eight directions; unused lanes see an open sky of zero weight.
pub struct SkyGroup {
    toward: [f32x8; 3],
    /// Rows of texel position and height along the light, from the world.
    texel_from_world: [[f32x8; 3]; 3],
    texel_shift: [f32x8; 3],
    texel_m: f32x8,
    /// Last texel whose right and lower neighbors are in the map.
    last: [f32x8; 2],
    row_lengths: [usize; 8],
    /// First key of each map.
    starts: [usize; 8],
    keys: Vec<f32>,
}

/// One direction with its occlusion map.
pub struct SkyMap<'a> {
    /// Unit, from the scene, in the world.
    pub toward: Vec3,
    /// Texel position, and meters along the light, of a point in the world.
    pub texel_from_world: Affine3A,
    pub texel_m: f32,
    pub width: usize,
    pub height: usize,
    /// Nearest key per texel; minus infinity = nothing.
    pub keys: &'a [f32],
}

/// Sums over the directions of a group at a point.
pub struct GroupShares {
    /// Sum over the directions of the cosine to the normal times the share of light that arrives.
    pub lit: f32,
    /// Sum of the cosines.
    pub all: f32,
    /// Sum of the shares.
    pub open: f32,
}

impl SkyGroup {
    /// At most eight directions with their maps.
    pub fn new(directions: &[(Vec3A, LightMap)]) -> Self {
        let lanes = |of: &dyn Fn(&Vec3A, &LightMap) -> f32, otherwise: f32| {
            let lane = |k: usize| directions.get(k).map_or(otherwise, |(d, map)| of(d, map));
            f32x8::from(std::array::from_fn::<f32, 8, _>(lane))
        };
        let mut keys =
            Vec::with_capacity(directions.iter().map(|(_, map)| map.keys.len()).sum::<usize>() + 4);
        let starts = std::array::from_fn(|k| {
            let start = keys.len();
            if let Some((_, map)) = directions.get(k) {
                keys.extend_from_slice(&map.keys);
            }
            start
        });
        // Keys that an unused lane reads.
        keys.extend([f32::NEG_INFINITY; 4]);
        let row =
            |axis: usize, column: usize| lanes(&|_, map| map.texel_from_world().0.col(column)[axis], 0.0);
        Self {
            toward: std::array::from_fn(|axis| lanes(&|d, _| d[axis], 0.0)),
            texel_from_world: std::array::from_fn(|axis| std::array::from_fn(|column| row(axis, column))),
            texel_shift: std::array::from_fn(|axis| lanes(&|_, map| map.texel_from_world().1[axis], 0.0)),
            texel_m: lanes(&|_, map| map.texel_m, 0.0),
            last: [
                lanes(&|_, map| map.width.saturating_sub(2) as f32, 0.0),
                lanes(&|_, map| map.height.saturating_sub(2) as f32, 0.0),
            ],
            row_lengths: std::array::from_fn(|k| directions.get(k).map_or(2, |(_, map)| map.width)),
            starts,
            keys,
        }
    }

    /// The maps of its lanes, the left-over ones too.
    pub fn maps(&self) -> impl Iterator<Item = SkyMap<'_>> {
        (0..8).map(|k| {
            let lane = |lanes: &f32x8| lanes.as_array()[k];
            let vector =
                |lanes: &[f32x8; 3]| Vec3::from_array(std::array::from_fn(|axis| lane(&lanes[axis])));
            let rows = self.texel_from_world.each_ref().map(vector);
            let texel_from_world = Affine3A::from_mat3_translation(
                Mat3::from_cols_array_2d(&rows.map(|row| row.to_array())).transpose(),
                vector(&self.texel_shift),
            );
            let (width, height) = (self.row_lengths[k], lane(&self.last[1]) as usize + 2);
            let keys = self.keys.get(self.starts[k]..self.starts[k] + width * height).unwrap_or(&[]);
            SkyMap {
                toward: vector(&self.toward),
                texel_from_world,
                texel_m: lane(&self.texel_m),
                width,
                height,
                keys,
            }
        })
    }

    /// For each direction the share of light that reaches the point, with hard edges smoothed over a texel.
    /// Directions whose cosine to the normal is below `min_cosine` count for openness alone.
    pub fn shares(&self, point: Vec3A, normal: Vec3A, min_cosine: f32) -> GroupShares {
        // Offset by a texel from the surface, against self-shadowing.
        let q: [f32x8; 3] =
            std::array::from_fn(|k| f32x8::splat(point[k]) + f32x8::splat(normal[k]) * self.texel_m);
        let along = |axis: usize| {
            let [a, b, c] = self.texel_from_world[axis];
            a * q[0] + b * q[1] + c * q[2] + self.texel_shift[axis]
        };
        // A map is empty around its content, so positions beyond it may be moved to its border.
        let half = f32x8::splat(0.5);
        let place = |axis: usize| (along(axis) - half).fast_max(f32x8::ZERO).fast_min(self.last[axis]);
        let (x, y) = (place(0), place(1));
        let lit_up_to = half * self.texel_m - along(2);
        let (column, row) = (x.fast_trunc_int(), y.fast_trunc_int());
        let (tx, ty) = (x - f32x8::from_i32x8(column), y - f32x8::from_i32x8(row));
        let (column, row) = (column.to_array(), row.to_array());
        let at: [usize; 8] = std::array::from_fn(|k| {
            self.starts[k] + row[k] as usize * self.row_lengths[k] + column[k] as usize
        });
        let [mut upper_left, mut upper_right, mut lower_left, mut lower_right] = [[0.0_f32; 8]; 4];
        for k in 0..8 {
            let upper = &self.keys[at[k]..at[k] + 2];
            let lower = &self.keys[at[k] + self.row_lengths[k]..][..2];
            (upper_left[k], upper_right[k]) = (upper[0], upper[1]);
            (lower_left[k], lower_right[k]) = (lower[0], lower[1]);
        }
        let lit = |keys: [f32; 8], weight: f32x8| f32x8::from(keys).simd_le(lit_up_to) & weight;
        let one = f32x8::ONE;
        let upper = lit(upper_left, one - tx) + lit(upper_right, tx);
        let lower = lit(lower_left, one - tx) + lit(lower_right, tx);
        let share = upper * (one - ty) + lower * ty;
        let [u, v, w] = self.toward;
        let (a, b, c) = (f32x8::splat(normal.x), f32x8::splat(normal.y), f32x8::splat(normal.z));
        let cosine = (a * u + b * v + c * w - f32x8::splat(min_cosine)).fast_max(f32x8::ZERO);
        GroupShares { lit: (cosine * share).reduce_add(), all: cosine.reduce_add(), open: share.reduce_add() }
    }
}
