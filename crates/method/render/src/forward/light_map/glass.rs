//! Light that transparent objects let pass, by color: their shadows are tinted and without noise.
//!
//! Method: each transparent triangle multiplies what passes its texels by what it lets through, less where the light
//! grazes it, so that the outline of a glass is its darkest part. The map is halved again and again; a point takes the
//! level whose texels are as wide as the penumbra there (Williams, "Pyramidal parametrics", 1983).
//!
//! Texels are twice as wide as those of the map of opaque objects. Cost: as that of the triangles drawn once, and
//! up to twelve texels for a point near the shadow.

use std::ops::Range;

use glam::{Vec3, Vec4};
use rayon::prelude::*;

use super::higher;
use crate::forward::prepare::ViewGeometry;
use crate::forward::projection::{Lens, Projection};
use crate::forward::raster::Band;
use crate::forward::scene_buffers::{SceneBuffers, TriangleFilter};
use geometry::Material;

/// Texels of the map of opaque objects along the side of one of glass.
pub const WIDER: f32 = 2.0;
/// Level whose highest keys tell where no glass is near.
pub const NEAR_LEVEL: usize = 4;
/// Number of levels; the last has texels as wide as the widest penumbra.
pub const LEVELS: usize = 6;
/// Glass that is nearer to a surface than this holds it, as that about a drink: it casts no shadow there.
pub const CLOSE_M: f32 = 0.005;
/// Share of light that a surface of clear glass takes, and the largest lengthening of the way through it.
const CLEAR_TAKES: f32 = 0.04;
const LONGEST_WAY: f32 = 4.0;

/// Share of light that passes, at several resolutions.
pub struct GlassShadow {
    pub levels: Vec<GlassLevel>,
    /// Highest key of each texel of [`NEAR_LEVEL`] and its neighbors.
    pub near: Vec<f32>,
}

/// One resolution.
pub struct GlassLevel {
    pub width: usize,
    pub height: usize,
    /// Share of light that passes, by color; and the nearest key, the lowest number where there is no glass.
    pub texels: Vec<Vec4>,
}

/// Point to which glass may let light pass, in texels of the map of opaque objects.
#[derive(Clone, Copy)]
pub struct Receiver {
    pub x: f32,
    pub y: f32,
    pub key: f32,
    /// Key up to which glass is not in the way, and how much that rises per texel sideways along the surface.
    pub lit_up_to: f32,
    pub slope: [f32; 2],
}

impl Receiver {
    /// Key above which glass at a texel of some level is in the way: it is above the plane of the surface.
    #[inline]
    fn limit(&self, column: i32, row: i32, level: usize) -> f32 {
        let width = WIDER * (1_u32 << level) as f32;
        let rise = |slope: f32, texel: i32, at: f32| {
            slope * ((texel as f32 + 0.5) * width - at) + 0.5 * width * slope.abs()
        };
        let rises = rise(self.slope[0], column, self.x) + rise(self.slope[1], row, self.y);
        self.lit_up_to + rises.max(0.0)
    }
}

/// Clear air.
const NO_GLASS: Vec4 = Vec4::new(1.0, 1.0, 1.0, f32::MIN);

impl GlassShadow {
    /// The shadow of the transparent triangles of consecutive objects in a projection for opaque ones; `None` if there
    /// are none.
    pub fn new(scene_buffers: &SceneBuffers, casters: &Range<usize>, opaque: &Projection) -> Option<Self> {
        if scene_buffers.drawn(TriangleFilter::Transparent, casters).len() == 0 {
            return None;
        }
        let lens = opaque.lens;
        let half = |side: usize| (side as f32 / WIDER).ceil() as usize;
        let projection = Projection {
            width_px: half(opaque.width_px),
            height_px: half(opaque.height_px),
            lens: Lens {
                scale_x: lens.scale_x / WIDER,
                scale_y: lens.scale_y / WIDER,
                center_x: lens.center_x / WIDER,
                center_y: lens.center_y / WIDER,
                ..lens
            },
            ..*opaque
        };
        let texels = drawn(scene_buffers, casters, &projection);
        let mut levels =
            vec![GlassLevel { width: projection.width_px, height: projection.height_px, texels }];
        while levels.len() < LEVELS {
            levels.push(levels[levels.len() - 1].halved());
        }
        let near = levels[NEAR_LEVEL].highest_around();
        Some(Self { levels, near })
    }

    /// Share of light that reaches a point, by color. The penumbra widens by `spread` texels for each meter from it.
    pub fn passing(&self, point: Receiver, spread: f32) -> Vec3 {
        let (x, y) = (point.x / WIDER, point.y / WIDER);
        let coarse = &self.levels[NEAR_LEVEL];
        let block = |c: f32, size: usize| (c.max(0.0) as usize >> NEAR_LEVEL).min(size - 1);
        let highest = self.near[block(y, coarse.height) * coarse.width + block(x, coarse.width)];
        if highest <= point.lit_up_to {
            return Vec3::ONE;
        }
        let level = |above: f32| {
            let radius = ((above - point.key) * spread / WIDER).max(1.0);
            radius.log2().min((LEVELS - 1) as f32)
        };
        // The highest glass of the neighborhood need not be what is in the way.
        let at = level(highest);
        let blocker = self.levels[at as usize].mean_key(point, at as usize).unwrap_or(highest);
        let at = level(blocker);
        let fine = at as usize;
        let passing = self.levels[fine].passing(point, fine);
        match self.levels.get(fine + 1) {
            Some(coarser) => passing.lerp(coarser.passing(point, fine + 1), at - fine as f32),
            None => passing,
        }
    }
}

impl GlassLevel {
    #[inline]
    fn texel(&self, x: i32, y: i32) -> Vec4 {
        if x < 0 || y < 0 || x as usize >= self.width || y as usize >= self.height {
            return NO_GLASS;
        }
        self.texels[y as usize * self.width + x as usize]
    }

    /// The four texels about a point, their weights, and whether their glass is in its way; `level` is the number of
    /// this one.
    #[inline]
    fn around(&self, point: Receiver, level: usize) -> [(Vec4, f32, bool); 4] {
        let scale = 1.0 / (WIDER * (1_u32 << level) as f32);
        let (x, y) = (point.x * scale - 0.5, point.y * scale - 0.5);
        let (left, upper) = (imaging::rounding::floor(x), imaging::rounding::floor(y));
        let (tx, ty) = (x - left as f32, y - upper as f32);
        let texel = |dx: i32, dy: i32, weight: f32| {
            let texel = self.texel(left + dx, upper + dy);
            (texel, weight, texel.w > point.limit(left + dx, upper + dy, level))
        };
        [
            texel(0, 0, (1.0 - tx) * (1.0 - ty)),
            texel(1, 0, tx * (1.0 - ty)),
            texel(0, 1, (1.0 - tx) * ty),
            texel(1, 1, tx * ty),
        ]
    }

    fn passing(&self, point: Receiver, level: usize) -> Vec3 {
        let share = |(texel, weight, is_in_the_way): (Vec4, f32, bool)| {
            weight * if is_in_the_way { texel.truncate() } else { Vec3::ONE }
        };
        self.around(point, level).map(share).into_iter().sum()
    }

    /// Mean key of what is in the way of a point.
    fn mean_key(&self, point: Receiver, level: usize) -> Option<f32> {
        let (mut sum, mut weights) = (0.0, 0.0);
        for (texel, weight, is_in_the_way) in self.around(point, level) {
            if is_in_the_way {
                sum += weight * texel.w;
                weights += weight;
            }
        }
        (weights > 1e-3).then(|| sum / weights)
    }

    /// The level of half the size: means of what passes, and the highest keys.
    fn halved(&self) -> Self {
        let (width, height) = (self.width.div_ceil(2), self.height.div_ceil(2));
        let texels = (0..width * height).map(|k| {
            let (x, y) = (2 * (k % width) as i32, 2 * (k / width) as i32);
            let four = [(0, 0), (1, 0), (0, 1), (1, 1)].map(|(dx, dy)| self.texel(x + dx, y + dy));
            let mean = 0.25 * four.iter().map(|texel| texel.truncate()).sum::<Vec3>();
            mean.extend(four.iter().fold(f32::MIN, |highest, texel| higher(highest, texel.w)))
        });
        Self { width, height, texels: texels.collect() }
    }

    /// Highest key of each texel and its neighbors.
    fn highest_around(&self) -> Vec<f32> {
        (0..self.width * self.height)
            .map(|k| {
                let (x, y) = ((k % self.width) as i32, (k / self.width) as i32);
                let around = (-1..=1).flat_map(|dy| (-1..=1).map(move |dx| (x + dx, y + dy)));
                around.fold(f32::MIN, |highest, (x, y)| higher(highest, self.texel(x, y).w))
            })
            .collect()
    }
}

/// Share of light that a surface of that material lets pass where light meets it upright.
fn passed(material: &Material) -> Vec3 {
    let opacity = material.opacity.clamp(0.0, 1.0);
    let tint = Vec3::ONE.lerp(Vec3::from(material.base_color.to_linear()), 0.2 + 0.4 * opacity);
    tint * ((1.0 - CLEAR_TAKES) * (1.0 - opacity * opacity * opacity))
}

fn drawn(scene_buffers: &SceneBuffers, casters: &Range<usize>, projection: &Projection) -> Vec<Vec4> {
    const BAND_ROWS: usize = 64;
    let prepared = ViewGeometry::refreshed(scene_buffers, projection, Vec::new(), casters);
    let binned = prepared.projected_part(projection, casters).bin(BAND_ROWS, TriangleFilter::Transparent);
    let materials: Vec<Vec<Vec3>> = scene_buffers
        .objects
        .iter()
        .map(|object| object.mesh.materials.iter().map(passed).collect())
        .collect();
    let facings = scene_buffers.facings();
    let along_light = projection.camera_from_world.matrix3.row(2).as_vec3a();
    let (width, height) = (projection.width_px, projection.height_px);
    let mut texels = vec![NO_GLASS; width * height];
    texels.par_chunks_mut((BAND_ROWS * width).max(1)).enumerate().for_each(|(index, texels)| {
        let band = Band::new(index * BAND_ROWS, texels.len() / width, width);
        for t in binned.band(index) {
            let triangle = &scene_buffers.triangles[t.source as usize];
            let passed = materials[triangle.object as usize][triangle.material as usize];
            let cosine = facings[t.source as usize].dot(along_light).abs();
            let passed = passed.powf((1.0 / cosine.max(1e-3)).min(LONGEST_WAY));
            band.each_pixel_in_front(t, |x, row, key| {
                let texel = &mut texels[row * width + x];
                *texel = (texel.truncate() * passed).extend(higher(texel.w, key));
            });
        }
    });
    texels
}
