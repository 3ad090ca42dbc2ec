//! Sky light on the backdrop's floor, on a coarse grid and blurred.
//!
//! The sky is sampled in a few directions with hard shadows, whose edges would be visible on a plain floor. Ambient
//! shadows far below a table are soft, so the coarse grid loses no detail.

use glam::{Vec2, Vec3, Vec3A};
use rayon::prelude::*;

use super::environment::Environment;
use super::scene_buffers::SceneBuffers;

/// Nodes along each side of the grid.
pub const SIDE: usize = 96;
/// Passes of a 5 x 5 mean; three come close to a Gaussian.
const BLURS: usize = 3;

/// Diffuse sky light at the nodes of a square grid on the floor.
pub struct FloorLight {
    pub low: Vec2,
    pub nodes_per_m: f32,
    /// Row by row, [`SIDE`] in each.
    pub nodes: Vec<Vec3>,
}

impl FloorLight {
    /// The light at height `z_m` under and around the objects.
    pub fn new(scene_buffers: &SceneBuffers, environment: &Environment, z_m: f32) -> Self {
        let (mut low, mut high) = (Vec3::INFINITY, Vec3::NEG_INFINITY);
        for (object, (a, b)) in scene_buffers.objects.iter().zip(&scene_buffers.bounds) {
            let radius = 0.5 * (*b - *a).length() as f32;
            let center = object.world_from_object.transform_point(0.5 * (*a + *b)).as_vec3();
            (low, high) = (low.min(center - radius), high.max(center + radius));
        }
        if !low.is_finite() {
            (low, high) = (Vec3::splat(-0.5), Vec3::splat(0.5));
        }
        // Shadows of the lowest sky directions reach far; beyond one height they are faint.
        let reach = (high.z - z_m).max(0.1);
        let center = 0.5 * (low + high).truncate();
        let half = 0.5 * (high - low).truncate().max_element() + reach;
        let cell_m = 2.0 * half / (SIDE - 1) as f32;
        let low = center - Vec2::splat(half);
        let nodes = (0..SIDE * SIDE)
            .into_par_iter()
            .map(|k| {
                let xy = low + cell_m * Vec2::new((k % SIDE) as f32, (k / SIDE) as f32);
                environment.on_floor(environment.sky.seen_from(Vec3A::new(xy.x, xy.y, z_m), Vec3A::Z, 0.0))
            })
            .collect();
        let mut light = Self { low, nodes_per_m: 1.0 / cell_m, nodes };
        (0..BLURS).for_each(|_| light.blur());
        light
    }

    /// A 5 x 5 mean, as means along rows and then along columns.
    fn blur(&mut self) {
        for (stride, other) in [(1, SIDE), (SIDE, 1)] {
            let line = |start: usize| {
                let nodes = &self.nodes;
                (0..SIDE).map(move |k| {
                    let near = k.saturating_sub(2)..(k + 3).min(SIDE);
                    let count = near.len() as f32;
                    (start + k * stride, near.map(|n| nodes[start + n * stride]).sum::<Vec3>() / count)
                })
            };
            let means: Vec<(usize, Vec3)> = (0..SIDE).flat_map(|k| line(k * other)).collect();
            means.into_iter().for_each(|(at, mean)| self.nodes[at] = mean);
        }
    }

    /// Bilinear sample; positions beyond the grid take its edge value.
    pub fn at(&self, point: Vec3A) -> Vec3 {
        let last = (SIDE - 1) as f32;
        let p = ((Vec2::new(point.x, point.y) - self.low) * self.nodes_per_m)
            .clamp(Vec2::ZERO, Vec2::splat(last));
        let (x, y) = ((p.x as usize).min(SIDE - 2), (p.y as usize).min(SIDE - 2));
        let (tx, ty) = (p.x - x as f32, p.y - y as f32);
        let node = |x: usize, y: usize| self.nodes[y * SIDE + x];
        node(x, y).lerp(node(x + 1, y), tx).lerp(node(x, y + 1).lerp(node(x + 1, y + 1), tx), ty)
    }
}
