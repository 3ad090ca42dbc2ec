//! Sky occlusion: which of a few directions are open at a point. It depends on the objects alone, so all images of one
//! scene share it.

use glam::Vec3A;
use rayon::prelude::*;

use super::environment::{Ambient, Environment};
use super::light_map::{LightMap, sky_directions};
use super::scene_buffers::{SceneBuffers, TriangleFilter};
use super::sky_group::{SkyGroup, SkyMap};
use crate::RenderSettings;

/// One occlusion map per direction.
pub struct Sky {
    groups: Vec<SkyGroup>,
    directions: usize,
}

/// Share of the sky that a surface point receives.
#[derive(Clone, Copy, Debug)]
pub struct SkyShare {
    /// Of the light that would arrive at a surface of that normal, the share that does, 0..1.
    pub arriving: f32,
    /// Share of the directions that are open, 0..1.
    pub open: f32,
}

/// A sky that nothing occludes.
pub static OPEN_SKY: Sky = Sky { groups: Vec::new(), directions: 0 };

impl Sky {
    /// Renders an occlusion map of the objects, or of the opaque ones, from every direction.
    pub fn new(scene_buffers: &SceneBuffers, casters: TriangleFilter, settings: &RenderSettings) -> Self {
        let directions: Vec<(Vec3A, LightMap)> = sky_directions(settings.sky_directions.min(64))
            .into_par_iter()
            .filter_map(|d| {
                let side_px = settings.sky_map_px.clamp(32, 1024);
                let map = LightMap::of_casters(scene_buffers, casters, d.as_dvec3(), side_px)?;
                Some((Vec3A::from(d), map))
            })
            .collect();
        Self { groups: directions.chunks(8).map(SkyGroup::new).collect(), directions: directions.len() }
    }

    /// Every direction with its map, in order.
    pub fn maps(&self) -> impl Iterator<Item = SkyMap<'_>> {
        self.groups.iter().flat_map(SkyGroup::maps).take(self.directions)
    }

    /// Share of the sky at a surface point; the whole sky if there are no maps. Light from directions whose cosine to
    /// the normal is below `min_cosine` does not count.
    pub fn seen_from(&self, point: Vec3A, normal: Vec3A, min_cosine: f32) -> SkyShare {
        if self.groups.is_empty() {
            return SkyShare { arriving: 1.0, open: 1.0 };
        }
        let (mut lit, mut all, mut open) = (0.0_f32, 1e-4_f32, 0.0_f32);
        for group in &self.groups {
            let shares = group.shares(point, normal, min_cosine);
            lit += shares.lit;
            all += shares.all;
            open += shares.open;
        }
        // Left-over lanes of the last group are open.
        open -= (8 * self.groups.len() - self.directions) as f32;
        SkyShare { arriving: lit / all, open: open / self.directions as f32 }
    }
}

/// Ambient light of one point, reused in its neighborhood on the same smooth surface, where it varies slowly.
#[derive(Default)]
pub struct SkyNearby(Option<(Vec3A, Vec3A, Ambient)>);

/// Limits of the neighborhood: cosine of the angle between normals, distance, and distance from the plane in pixels.
pub const SAME_DIRECTION: f32 = 0.965;
pub const NEAR_PX: f32 = 3.0;
pub const SAME_PLANE_PX: f32 = 0.5;

impl SkyNearby {
    /// Ambient light at a point: the cached one if the point lies in its neighborhood, else a new one, which is then
    /// cached.
    #[inline]
    pub fn at(
        &mut self,
        environment: &Environment,
        (point, flat_normal, normal): (Vec3A, Vec3A, Vec3A),
        pixel_size_m: f32,
    ) -> Ambient {
        if let Some((near, direction, ambient)) = self.0 {
            let offset = point - near;
            if flat_normal.dot(direction) > SAME_DIRECTION
                && offset.length_squared() < (NEAR_PX * pixel_size_m).powi(2)
                && offset.dot(direction).abs() < SAME_PLANE_PX * pixel_size_m
            {
                return ambient;
            }
        }
        let ambient = environment.ambient(point, flat_normal, normal);
        self.0 = Some((point, flat_normal, ambient));
        ambient
    }
}
