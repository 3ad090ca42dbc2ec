//! What a light at infinity sees: depth maps for the key light's soft shadows and for the sky.
//!
//! Soft shadows follow Fernando, "Percentage-closer soft shadows" (2005): average the blockers around
//! the receiver, take the penumbra's width from their distance, filter the comparison over it. A dilated
//! coarse map of the highest blockers answers most pixels (plainly lit) with one look.

use glam::{Affine3A, DAffine3, DMat3, DVec3, Vec3, Vec3A};
use rayon::prelude::*;

use super::RenderObject;
use super::prepare::{Keep, Prepared};
use super::projection::{Lens, Projection};
use super::raster::Band;

/// Depth of everything as seen from one direction.
pub struct LightMap {
    light_from_world: Affine3A,
    width: usize,
    height: usize,
    texels_per_m: f32,
    texel_m: f32,
    /// Nearest key (minus meters along the light) per texel; minus infinity = nothing.
    keys: Vec<f32>,
    /// Highest key within reach of each coarse block.
    coarse: Vec<f32>,
    coarse_width: usize,
    /// Furthest a blocker that matters may lie sideways, texels.
    reach: f32,
}

const COARSE: usize = 16;
/// Samples of a penumbra, and every how many of them look for blockers.
const TAPS: usize = 32;
const SEARCH_STEP: usize = 2;

impl LightMap {
    /// Looks at the objects from `toward_light`; `radius_rad` is the light's angular radius.
    pub fn new(
        objects: &[RenderObject],
        toward_light: DVec3,
        longest_side_px: u32,
        radius_rad: f64,
    ) -> Option<Self> {
        let forward = -toward_light.normalize_or(DVec3::Z);
        let helper = if forward.z.abs() > 0.9 { DVec3::Y } else { DVec3::Z };
        let right = forward.cross(helper).normalize();
        let down = forward.cross(right);
        let light_from_world = DMat3::from_cols(right, down, forward).transpose();
        let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        for object in objects {
            let (a, b) = object.mesh.bounds();
            for corner in 0..8 {
                let pick = |bit: u32, a: f64, b: f64| if corner >> bit & 1 == 1 { b } else { a };
                let p = DVec3::new(pick(0, a.x, b.x), pick(1, a.y, b.y), pick(2, a.z, b.z));
                let p = light_from_world * object.world_from_object.transform_point(p);
                (low, high) = (low.min(p), high.max(p));
            }
        }
        let extent = high - low;
        if !extent.is_finite() || longest_side_px == 0 {
            return None;
        }
        let inner = f64::from(longest_side_px.max(32)) - 8.0;
        let texels_per_m = inner / extent.x.max(extent.y).max(1e-3);
        let (width, height) =
            ((extent.x * texels_per_m) as usize + 8, (extent.y * texels_per_m) as usize + 8);
        let shift = DVec3::new(-low.x, -low.y, -low.z + 0.01);
        let camera_from_world = DAffine3::from_translation(shift) * DAffine3::from_mat3(light_from_world);
        let projection = Projection {
            width_px: width,
            height_px: height,
            camera_from_world,
            lens: Lens {
                perspective: false,
                scale_x: texels_per_m as f32,
                scale_y: texels_per_m as f32,
                center_x: 4.0,
                center_y: 4.0,
            },
        };
        let keys = draw(objects, &projection);
        let reach = ((extent.z * radius_rad.tan() * texels_per_m) as f32).clamp(1.0, 40.0);
        let mut map = Self {
            light_from_world: camera_from_world.as_affine3a(),
            width,
            height,
            texels_per_m: texels_per_m as f32,
            texel_m: (1.0 / texels_per_m) as f32,
            keys,
            coarse: Vec::new(),
            coarse_width: width.div_ceil(COARSE),
            reach,
        };
        map.coarse = map.dilated_blocks();
        Some(map)
    }

    fn dilated_blocks(&self) -> Vec<f32> {
        let (columns, rows) = (self.coarse_width, self.height.div_ceil(COARSE));
        let mut blocks = vec![f32::NEG_INFINITY; columns * rows];
        for (y, row) in self.keys.chunks_exact(self.width).enumerate() {
            for (x, chunk) in row.chunks(COARSE).enumerate() {
                let block = &mut blocks[(y / COARSE) * columns + x];
                *block = chunk.iter().fold(*block, |high, &key| high.max(key));
            }
        }
        let around = ((self.reach + 2.0) / COARSE as f32).ceil() as usize;
        let mut dilated = blocks.clone();
        for y in 0..rows {
            for x in 0..columns {
                for v in y.saturating_sub(around)..=(y + around).min(rows - 1) {
                    for u in x.saturating_sub(around)..=(x + around).min(columns - 1) {
                        dilated[y * columns + x] = dilated[y * columns + x].max(blocks[v * columns + u]);
                    }
                }
            }
        }
        dilated
    }

    #[inline]
    fn texel_and_key(&self, point_in_world: Vec3A) -> (f32, f32, f32) {
        let p = self.light_from_world.transform_point3a(point_in_world);
        (p.x * self.texels_per_m + 4.0, p.y * self.texels_per_m + 4.0, -p.z)
    }

    #[inline]
    fn key_at(&self, x: i32, y: i32) -> f32 {
        if x < 0 || y < 0 || x as usize >= self.width || y as usize >= self.height {
            return f32::NEG_INFINITY;
        }
        self.keys[y as usize * self.width + x as usize]
    }

    /// Share of the four texels around a position that let light through to `key`, bilinearly.
    #[inline]
    fn lit_share(&self, x: f32, y: f32, key: f32) -> f32 {
        let (fx, fy) = (x - 0.5, y - 0.5);
        let (ix, iy) = (floor(fx), floor(fy));
        let (tx, ty) = (fx - ix as f32, fy - iy as f32);
        let lit = |dx: i32, dy: i32| f32::from(u8::from(self.key_at(ix + dx, iy + dy) <= key));
        let upper = lit(0, 0) * (1.0 - tx) + lit(1, 0) * tx;
        let lower = lit(0, 1) * (1.0 - tx) + lit(1, 1) * tx;
        upper * (1.0 - ty) + lower * ty
    }

    /// Share of the light that reaches the point unblocked, hard edges smoothed over a texel: for one
    /// direction of many.
    #[inline]
    pub fn openness(&self, point_in_world: Vec3A, normal: Vec3A) -> f32 {
        let (x, y, key) = self.texel_and_key(point_in_world + normal * self.texel_m);
        if x < 0.0 || y < 0.0 || x >= self.width as f32 || y >= self.height as f32 {
            return 1.0;
        }
        self.lit_share(x, y, key + 0.5 * self.texel_m)
    }

    /// Share of a round light of the given angular radius that reaches the point. `turn_rad` rotates the
    /// sampling pattern, so that what is left of it looks like grain and not like bands.
    pub fn soft_visibility(
        &self,
        point_in_world: Vec3A,
        normal: Vec3A,
        radius_rad: f32,
        turn_rad: f32,
    ) -> f32 {
        let (x, y, key) = self.texel_and_key(point_in_world + normal * (1.2 * self.texel_m));
        if x < -self.reach
            || y < -self.reach
            || x >= self.width as f32 + self.reach
            || y >= self.height as f32 + self.reach
        {
            return 1.0;
        }
        let (bx, by) = (
            (x.max(0.0) as usize / COARSE).min(self.coarse_width - 1),
            (y.max(0.0) as usize / COARSE).min(self.coarse.len() / self.coarse_width - 1),
        );
        let bias = 0.6 * self.texel_m;
        let highest = self.coarse[by * self.coarse_width + bx];
        if highest <= key + bias {
            return 1.0;
        }
        let spread = radius_rad.tan() * self.texels_per_m;
        let search = ((highest - key) * spread).clamp(1.0, self.reach);
        let (sin, cos) = turn_rad.sin_cos();
        let (mut sum, mut count) = (0.0, 0.0_f32);
        for &(dx, dy) in DISK.iter().step_by(SEARCH_STEP) {
            let (u, v) = (dx * cos - dy * sin, dx * sin + dy * cos);
            // A blocker must stand above the cone of the surface itself as seen from this offset.
            let found = self.key_at(floor(x + u * search), floor(y + v * search));
            if found > key + bias {
                sum += found;
                count += 1.0;
            }
        }
        if count == 0.0 {
            return 1.0;
        }
        if count as usize == TAPS / SEARCH_STEP {
            return 0.0;
        }
        let width = ((sum / count - key) * spread).clamp(0.8, self.reach);
        let mut lit = 0.0;
        for &(dx, dy) in &DISK[..] {
            let (u, v) = (dx * cos - dy * sin, dx * sin + dy * cos);
            lit += self.lit_share(x + u * width, y + v * width, key + bias);
        }
        lit / TAPS as f32
    }
}

/// Largest whole number at most `x`; without SSE 4.1 the library's floor is a call.
#[inline]
pub(super) fn floor(x: f32) -> i32 {
    let truncated = x as i32;
    truncated - i32::from(truncated as f32 > x)
}

/// Points spread evenly over the unit disk (Vogel's spiral).
static DISK: std::sync::LazyLock<[(f32, f32); TAPS]> = std::sync::LazyLock::new(|| {
    std::array::from_fn(|k| {
        let radius = ((k as f32 + 0.5) / TAPS as f32).sqrt();
        let angle = k as f32 * 2.399_963_2;
        (radius * angle.cos(), radius * angle.sin())
    })
});

fn draw(objects: &[RenderObject], projection: &Projection) -> Vec<f32> {
    const BAND_ROWS: usize = 64;
    let prepared = Prepared::new(objects, projection);
    let opaque = prepared.bin(objects, projection, BAND_ROWS, Keep::Opaque);
    let glass = prepared.bin(objects, projection, BAND_ROWS, Keep::Transparent);
    let (width, height) = (projection.width_px, projection.height_px);
    let bands: Vec<Vec<f32>> = (0..height.div_ceil(BAND_ROWS))
        .into_par_iter()
        .map(|index| {
            let first_row = index * BAND_ROWS;
            let mut band = Band::new(first_row, BAND_ROWS.min(height - first_row), width);
            opaque.band(index).for_each(|t| band.draw(t, 0xffff));
            // Glass stops a third of the light: every third texel of a regular screen.
            glass.band(index).for_each(|t| band.draw(t, 0b1000_0010_1000_0010));
            (0..band.rows).flat_map(|row| band.key_row(row).to_vec()).collect()
        })
        .collect();
    bands.concat()
}

/// Sky directions spread evenly over the upper hemisphere, none nearer than 8 degrees to the horizon.
pub fn sky_directions(count: u32) -> Vec<Vec3> {
    (0..count)
        .map(|k| {
            let z = 0.14 + 0.86 * (k as f32 + 0.5) / count as f32;
            let angle = k as f32 * 2.399_963_2;
            let radius = (1.0 - z * z).max(0.0).sqrt();
            Vec3::new(radius * angle.cos(), radius * angle.sin(), z)
        })
        .collect()
}
