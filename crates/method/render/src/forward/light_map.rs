//! Depth maps of a light at infinity, for the key light's soft shadows and for sky occlusion.
//!
//! Soft shadows follow Fernando, "Percentage-closer soft shadows" (2005): average the blockers around the receiver,
//! derive the penumbra's width from their distance, filter the comparison over it. A dilated coarse map of the highest
//! blockers answers most pixels (fully lit) with one lookup; the others test eight texels at a time. Transparent
//! objects have shadows of their own, [`glass`].

pub mod glass;

use std::ops::Range;

use glam::{Affine3A, DAffine3, DMat3, DVec3, Mat3A, Vec3, Vec3A};
use rayon::prelude::*;
use wide::f32x8;

use self::glass::GlassShadow;
use super::prepare::ViewGeometry;
use super::projection::{Lens, Projection};
use super::raster::Band;
use super::scene_buffers::{SceneBuffers, TriangleFilter};
use imaging::rounding::floor;

/// Depth map from one direction.
pub struct LightMap {
    pub(crate) light_from_world: Affine3A,
    pub(crate) width: usize,
    pub(crate) height: usize,
    pub(crate) texels_per_m: f32,
    pub(crate) texel_m: f32,
    /// Nearest key (minus meters along the light) per texel; minus infinity = nothing.
    pub(crate) keys: Vec<f32>,
    /// Highest key within reach of each coarse block.
    pub(crate) coarse: Vec<f32>,
    pub(crate) coarse_width: usize,
    /// Highest key of each fine block.
    pub(crate) fine: Vec<f32>,
    /// Largest sideways distance of a relevant blocker, texels.
    pub(crate) reach: f32,
    /// Texels the penumbra widens by for each meter to the blocker.
    pub(crate) spread: f32,
    /// Light that transparent objects let pass, where they are not in `keys`.
    pub(crate) glass: Option<GlassShadow>,
}

pub const COARSE: usize = 16;
pub const FINE: usize = 8;
/// Up to this radius the fine blocks around a receiver are tested before its texels, texels.
pub const FEW_BLOCKS: f32 = 12.0;
/// Up to this radius all texels around a receiver are tested before samples among them, texels.
const FEW_TEXELS: f32 = 2.0;
/// Empty texels around the rasterized area.
pub const BORDER: f32 = 4.0;
/// Samples of a penumbra, in groups of eight; the first groups search for blockers.
pub const TAP_GROUPS: usize = 8;
pub const SEARCH_GROUPS: usize = 4;
/// Penumbras narrower than this are smoothed between texels, texels.
pub const NARROW: f32 = 2.0;
/// The z of a normal in the frame of the light beyond which surfaces are no steeper: they get hardly any light.
pub const STEEPEST: f32 = -0.05;

impl LightMap {
    /// Renders the objects, or the opaque ones, from `toward_light`. The map has its keys only.
    pub fn of_casters(
        scene_buffers: &SceneBuffers,
        casters: TriangleFilter,
        toward_light: DVec3,
        longest_side_px: u32,
    ) -> Option<Self> {
        let all = scene_buffers.all();
        Self::placed(scene_buffers, (&all, casters), toward_light, longest_side_px, f64::INFINITY, None)
    }

    /// The map of the shadows that consecutive objects cast, with texels no finer than `max_texels_per_m`. `radius_rad`
    /// is the angular radius of the light for later soft-shadow queries; the penumbra is as wide as on the farthest of
    /// all objects.
    pub fn of_part(
        scene_buffers: &SceneBuffers,
        casters: &Range<usize>,
        toward_light: DVec3,
        longest_side_px: u32,
        max_texels_per_m: f64,
        radius_rad: f64,
    ) -> Option<Self> {
        let casters = (casters, TriangleFilter::Opaque);
        Self::placed(
            scene_buffers,
            casters,
            toward_light,
            longest_side_px,
            max_texels_per_m,
            Some(radius_rad),
        )
    }

    fn placed(
        scene_buffers: &SceneBuffers,
        (casters, keep): (&Range<usize>, TriangleFilter),
        toward_light: DVec3,
        longest_side_px: u32,
        max_texels_per_m: f64,
        radius_rad: Option<f64>,
    ) -> Option<Self> {
        if longest_side_px == 0 {
            return None;
        }
        let forward = -toward_light.normalize_or(DVec3::Z);
        let helper = if forward.z.abs() > 0.9 { DVec3::Y } else { DVec3::Z };
        let right = forward.cross(helper).normalize();
        let down = forward.cross(right);
        let light_from_world = DMat3::from_cols(right, down, forward).transpose();
        let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        for (index, (object, (a, b))) in scene_buffers.objects.iter().zip(&scene_buffers.bounds).enumerate() {
            for corner in 0..8 {
                let pick = |bit: u32, a: f64, b: f64| if corner >> bit & 1 == 1 { b } else { a };
                let p = DVec3::new(pick(0, a.x, b.x), pick(1, a.y, b.y), pick(2, a.z, b.z));
                let p = light_from_world * object.world_from_object.transform_point(p);
                // What casts nothing counts along the light only.
                let (lowest, highest) = match casters.contains(&index) {
                    true => (p, p),
                    false => (DVec3::INFINITY.with_z(p.z), DVec3::NEG_INFINITY.with_z(p.z)),
                };
                (low, high) = (low.min(lowest), high.max(highest));
            }
        }
        let extent = high - low;
        if !extent.is_finite() {
            return None;
        }
        let border = f64::from(BORDER);
        let inner = f64::from(longest_side_px.max(32)) - 2.0 * border;
        let texels_per_m = (inner / extent.x.max(extent.y).max(1e-3)).min(max_texels_per_m);
        let (width, height) =
            [extent.x, extent.y].map(|length| (length * texels_per_m + 2.0 * border) as usize).into();
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
                center_x: BORDER,
                center_y: BORDER,
            },
        };
        let keys = draw(scene_buffers, casters, keep, &projection);
        let widening = radius_rad.map_or(0.0, f64::tan) * texels_per_m;
        let reach = ((extent.z * widening) as f32).clamp(1.0, 40.0);
        let mut map = Self {
            light_from_world: camera_from_world.as_affine3a(),
            width,
            height,
            texels_per_m: texels_per_m as f32,
            texel_m: (1.0 / texels_per_m) as f32,
            keys,
            coarse: Vec::new(),
            coarse_width: width.div_ceil(COARSE),
            fine: Vec::new(),
            reach,
            spread: widening as f32,
            glass: None,
        };
        if radius_rad.is_some() {
            map.glass = GlassShadow::new(scene_buffers, casters, &projection);
            map.coarse = map.dilated_blocks();
            map.fine = map.highest_in_blocks(FINE);
        }
        Some(map)
    }

    /// Highest key in blocks of `size` texels each way.
    fn highest_in_blocks(&self, size: usize) -> Vec<f32> {
        let columns = self.width.div_ceil(size);
        let mut blocks = vec![f32::NEG_INFINITY; columns * self.height.div_ceil(size)];
        for (y, row) in self.keys.chunks_exact(self.width).enumerate() {
            for (x, chunk) in row.chunks(size).enumerate() {
                let block = &mut blocks[(y / size) * columns + x];
                *block = chunk.iter().copied().fold(*block, higher);
            }
        }
        blocks
    }

    fn dilated_blocks(&self) -> Vec<f32> {
        let (columns, rows) = (self.coarse_width, self.height.div_ceil(COARSE));
        let blocks = self.highest_in_blocks(COARSE);
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

    /// At least the highest key within `radius` texels.
    #[inline]
    fn highest_within(&self, x: f32, y: f32, radius: f32) -> f32 {
        let block = |c: f32, size: usize| (c.max(0.0) as usize).min(size - 1) / FINE;
        let columns = self.width.div_ceil(FINE);
        let (left, right) = (block(x - radius, self.width), block(x + radius, self.width));
        let mut highest = f32::NEG_INFINITY;
        for row in block(y - radius, self.height)..=block(y + radius, self.height) {
            for block in &self.fine[row * columns + left..=row * columns + right] {
                highest = higher(highest, *block);
            }
        }
        highest
    }

    /// Whether no key within a square of half side `radius` texels is above `limit`.
    #[inline]
    fn is_clear(&self, x: f32, y: f32, radius: f32, limit: f32) -> bool {
        // As `keys_at` finds them, so that none of its samples is missed.
        let within = |c: f32, size: usize| c.clamp(0.0, (size - 1) as f32) as usize;
        let (left, right) = (within(x - radius, self.width), within(x + radius, self.width));
        let mut rows = within(y - radius, self.height)..=within(y + radius, self.height);
        rows.all(|row| {
            let mut clear = true;
            for key in &self.keys[row * self.width + left..=row * self.width + right] {
                clear &= *key <= limit;
            }
            clear
        })
    }

    /// Texel position and meters along the light of a point in the world: matrix and shift.
    pub(crate) fn texel_from_world(&self) -> (Mat3A, Vec3A) {
        let scale = Vec3A::new(self.texels_per_m, self.texels_per_m, 1.0);
        let Affine3A { matrix3, translation } = self.light_from_world;
        (Mat3A::from_diagonal(scale.into()) * matrix3, scale * translation + Vec3A::new(BORDER, BORDER, 0.0))
    }

    #[inline]
    fn texel_and_key(&self, point_in_world: Vec3A) -> (f32, f32, f32) {
        let p = self.light_from_world.transform_point3a(point_in_world);
        (p.x * self.texels_per_m + BORDER, p.y * self.texels_per_m + BORDER, -p.z)
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

    /// Share of the disk light that reaches the point. `turn` (0..1) rotates the sampling pattern, so that residual
    /// noise appears as grain instead of bands.
    pub fn soft_visibility(&self, point_in_world: Vec3A, normal: Vec3A, turn: f32) -> f32 {
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
        let mut highest = self.coarse[by * self.coarse_width + bx];
        if highest <= key + bias {
            return 1.0;
        }
        let reach = |highest: f32| ((highest - key) * self.spread).clamp(1.0, self.reach);
        if reach(highest) <= FEW_BLOCKS {
            highest = self.highest_within(x, y, reach(highest) + 1.0);
            if highest <= key + bias {
                return 1.0;
            }
        }
        let search = reach(highest);
        if search <= FEW_TEXELS && self.is_clear(x, y, search, key + bias) {
            return 1.0;
        }
        let disk = &DISKS[(turn * TURNS as f32) as usize % TURNS];
        let (x, y, lit_up_to) = (f32x8::splat(x), f32x8::splat(y), f32x8::splat(key + bias));
        let search = f32x8::splat(search);
        let [slope_x, slope_y] = self.slope(normal).0.map(f32x8::splat);
        // What blocks light stands above the plane of the surface, which rises to one side of a steep one.
        let plane = |dx: f32x8, dy: f32x8| lit_up_to + (slope_x * dx + slope_y * dy).max(f32x8::ZERO);
        let (mut sum, mut count) = (f32x8::ZERO, 0);
        for (dx, dy) in &disk.wide[..SEARCH_GROUPS] {
            let (dx, dy) = (*dx * search, *dy * search);
            let found = self.keys_at(x + dx, y + dy);
            let blocks = found.simd_gt(plane(dx, dy));
            sum += found & blocks;
            count += blocks.to_bitmask().count_ones();
        }
        if count == 0 {
            return 1.0;
        }
        if count as usize == 8 * SEARCH_GROUPS {
            return 0.0;
        }
        let blocker = sum.reduce_add() / count as f32;
        let width = ((blocker - key) * self.spread).clamp(0.8, self.reach);
        let radius = f32x8::splat(width);
        if width < NARROW {
            let (dx, dy) = (disk.narrow.0 * radius, disk.narrow.1 * radius);
            let (u, v, limit) = ((x + dx).to_array(), (y + dy).to_array(), plane(dx, dy).to_array());
            let lit: f32 = (0..8).map(|k| self.lit_share(u[k], v[k], limit[k])).sum();
            return lit / 8.0;
        }
        let lit_among = |groups: &[(f32x8, f32x8)]| {
            let lit = |(dx, dy): &(f32x8, f32x8)| {
                let (dx, dy) = (*dx * radius, *dy * radius);
                let found = self.keys_at(x + dx, y + dy);
                found.simd_le(plane(dx, dy)).to_bitmask().count_ones()
            };
            groups.iter().map(lit).sum::<u32>()
        };
        // Where all of the first half agree, the second would.
        let (few, more) = disk.wide.split_at(TAP_GROUPS / 2);
        match lit_among(few) {
            0 => 0.0,
            lit if lit as usize == 8 * few.len() => 1.0,
            lit => (lit + lit_among(more)) as f32 / (8 * TAP_GROUPS) as f32,
        }
    }

    /// Change of the key of a surface with this normal per texel sideways, and per meter away from it.
    #[inline]
    fn slope(&self, normal: Vec3A) -> ([f32; 2], f32) {
        let in_light = self.light_from_world.matrix3 * normal;
        // Lit surfaces face against z, along which the light goes.
        let facing = in_light.z.min(STEEPEST);
        ([in_light.x, in_light.y].map(|sideways| sideways / facing * self.texel_m), -1.0 / facing)
    }

    /// Share of light that transparent objects let pass to the point, by color.
    pub fn through_glass(&self, point_in_world: Vec3A, normal: Vec3A) -> Vec3 {
        let Some(glass) = &self.glass else { return Vec3::ONE };
        let (x, y, key) = self.texel_and_key(point_in_world + normal * (1.2 * self.texel_m));
        let (slope, per_m_away) = self.slope(normal);
        let lit_up_to = key + 0.6 * self.texel_m + glass::CLOSE_M * per_m_away;
        glass.passing(glass::Receiver { x, y, key, lit_up_to, slope }, self.spread)
    }

    /// Keys at eight positions; outside the map they are those of the empty border.
    #[inline]
    fn keys_at(&self, x: f32x8, y: f32x8) -> f32x8 {
        let within = |c: f32x8, size: usize| {
            c.fast_max(f32x8::ZERO).fast_min(f32x8::splat((size - 1) as f32)).fast_trunc_int().to_array()
        };
        let (columns, rows) = (within(x, self.width), within(y, self.height));
        let at: [f32; 8] =
            std::array::from_fn(|k| self.keys[rows[k] as usize * self.width + columns[k] as usize]);
        f32x8::from(at)
    }
}

/// The higher of two keys, which are never NaN. `f32::max` takes three times as long because it handles NaN.
#[inline]
fn higher(a: f32, b: f32) -> f32 {
    if b > a { b } else { a }
}

/// Rotations of the sampling pattern.
pub const TURNS: usize = 64;

/// Points spread evenly over the unit disk, eight at a time, in one of their rotations.
struct Disk {
    narrow: (f32x8, f32x8),
    /// The first half covers the disk, too.
    wide: [(f32x8, f32x8); TAP_GROUPS],
}

static DISKS: std::sync::LazyLock<Vec<Disk>> = std::sync::LazyLock::new(|| {
    const COUNT: usize = 8 * TAP_GROUPS;
    let even_then_odd: Vec<usize> = (0..COUNT).step_by(2).chain((1..COUNT).step_by(2)).collect();
    (0..TURNS)
        .map(|turn| {
            // Vogel's spiral.
            let lanes = |of: usize, index: &dyn Fn(usize) -> usize| {
                let point = |lane: usize| {
                    let k = index(lane) as f32;
                    let radius = ((k + 0.5) / of as f32).sqrt();
                    let angle = k * 2.399_963_2 + turn as f32 / TURNS as f32 * std::f32::consts::TAU;
                    (radius * angle.cos(), radius * angle.sin())
                };
                let points: [(f32, f32); 8] = std::array::from_fn(point);
                (f32x8::from(points.map(|p| p.0)), f32x8::from(points.map(|p| p.1)))
            };
            Disk {
                narrow: lanes(8, &|lane| lane),
                wide: std::array::from_fn(|group| lanes(COUNT, &|lane| even_then_odd[8 * group + lane])),
            }
        })
        .collect()
});

/// The sampling patterns as numbers: of each turn the points of a narrow penumbra, then those of a wide one, x and y.
pub fn sampling_patterns() -> Vec<f32> {
    let group = |(x, y): &(f32x8, f32x8)| {
        let (x, y) = (x.to_array(), y.to_array());
        (0..8).flat_map(move |lane| [x[lane], y[lane]])
    };
    let disk =
        |disk: &Disk| std::iter::once(&disk.narrow).chain(&disk.wide).flat_map(group).collect::<Vec<_>>();
    DISKS.iter().flat_map(disk).collect()
}

fn draw(
    scene_buffers: &SceneBuffers,
    casters: &Range<usize>,
    keep: TriangleFilter,
    projection: &Projection,
) -> Vec<f32> {
    const BAND_ROWS: usize = 64;
    /// Smallest rayon task, texels.
    const TASK_TEXELS: usize = 1 << 16;
    let prepared = ViewGeometry::refreshed(scene_buffers, projection, Vec::new(), casters);
    let projected = prepared.projected_part(projection, casters);
    let opaque = projected.bin(BAND_ROWS, TriangleFilter::Opaque);
    let glass = (keep == TriangleFilter::All).then(|| projected.bin(BAND_ROWS, TriangleFilter::Transparent));
    let (width, height) = (projection.width_px, projection.height_px);
    let mut keys = vec![f32::NEG_INFINITY; width * height];
    keys.par_chunks_mut((BAND_ROWS * width).max(1))
        .enumerate()
        .with_min_len(TASK_TEXELS.div_ceil((BAND_ROWS * width).max(1)))
        .for_each(|(index, keys)| {
            let mut band = Band::new(index * BAND_ROWS, keys.len() / width, width);
            opaque.band(index).for_each(|t| band.draw(t, 0xffff));
            // Glass stops a third of the light: every third texel of a regular screen.
            let glass = glass.iter().flat_map(|glass| glass.band(index));
            glass.for_each(|t| band.draw(t, 0b1000_0010_1000_0010));
            for (row, keys) in keys.chunks_exact_mut(width).enumerate() {
                keys.copy_from_slice(band.key_row(row));
            }
        });
    keys
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
