//! Composites shaped like containers: surfaces of revolution, boxes, stepped piles.

use std::f64::consts::FRAC_PI_2;

use glam::{DVec2, DVec3};
use rand::RngExt;

use super::CompositeBuilder;
use crate::synthetic_images::sampling::chance;
use catalog::texture::mapped_on_box;
use geometry::shapes::{
    block, cone, cylinder, lathe, prism, rectangle, rounded_block, shell_of_revolution, tube,
};

impl CompositeBuilder<'_> {
    pub(super) fn turned(&mut self) {
        let height = self.uniform(0.03, 0.2);
        let radius = height * self.uniform(0.12, 0.7);
        let controls = self.rng.random_range(3..7);
        let mut outside: Vec<DVec2> = Vec::new();
        for k in 0..=controls {
            let t = f64::from(k) / f64::from(controls);
            outside.push(DVec2::new(radius * self.uniform(0.35, 1.0), t * height));
        }
        let outside = fair(&outside);
        let material = self.material();
        let solid = if chance(self.rng, 0.5) {
            shell_of_revolution(&outside, 0.06 * radius + 0.0015, 0.08 * height, 32)
        } else {
            let mut profile = vec![DVec2::new(0.0, 0.0)];
            profile.extend(&outside);
            profile.push(DVec2::new(0.0, height));
            lathe(&profile, 32)
        };
        self.add(solid, DVec3::ZERO, &material);
        if chance(self.rng, 0.35) {
            let (lid, size) = (self.material(), outside[outside.len() - 1].x);
            let tall = self.uniform(0.05, 0.25) * height;
            let solid = cylinder(size * self.uniform(0.6, 1.15), tall, 0.1 * tall, 28);
            self.add(solid, DVec3::new(0.0, 0.0, height - 0.001), &lid);
        }
        if chance(self.rng, 0.3) {
            let (z, size) = (self.uniform(0.4, 0.7) * height, self.uniform(0.15, 0.35) * height);
            let path: Vec<DVec3> = (0..=12)
                .map(|k| {
                    let angle = -FRAC_PI_2 + std::f64::consts::PI * f64::from(k) / 12.0;
                    DVec3::new(
                        0.55 * radius + (size + 0.4 * radius) * angle.cos(),
                        0.0,
                        z + size * angle.sin(),
                    )
                })
                .collect();
            let thick = 0.06 * height + 0.002;
            self.add(tube(&path, thick.min(0.012), 10), DVec3::ZERO, &material);
        }
    }

    pub(super) fn boxy(&mut self) {
        let size = DVec3::new(self.uniform(0.04, 0.34), self.uniform(0.03, 0.24), self.uniform(0.008, 0.22));
        let material = self.printed_material();
        let corner = self.uniform(0.0, 0.2) * size.x.min(size.y);
        let edge = self.uniform(0.02, 0.2) * size.min_element();
        let solid =
            if corner > 0.004 { rounded_block(size, corner, edge.min(0.9 * corner)) } else { block(size) };
        self.mesh.add(mapped_on_box(solid), &material);
        for _ in 0..self.rng.random_range(0..5) {
            let part = self.material();
            let scale = DVec3::new(self.uniform(0.08, 0.6), self.uniform(0.08, 0.6), self.uniform(0.1, 0.6));
            let own = scale * size;
            let spread = (size - own).truncate() * 0.5;
            let at = DVec2::new(self.uniform(-1.0, 1.0), self.uniform(-1.0, 1.0)) * spread;
            let high = if size.z < 0.05 && chance(self.rng, 0.6) { 0.006 } else { own.z };
            let solid = match self.rng.random_range(0..3) {
                0 => cylinder(0.5 * own.x.min(own.y), high, 0.1 * high, 20),
                1 => cone(0.5 * own.x.min(own.y), self.uniform(0.1, 0.5) * own.x.min(own.y), high, 20),
                _ => block(own.with_z(high)),
            };
            self.add(solid, at.extend(size.z - 0.001), &part);
        }
    }

    pub(super) fn stepped(&mut self) {
        let (mut size, mut z) = (self.uniform(0.06, 0.2), 0.0);
        for _ in 0..self.rng.random_range(2..5) {
            let (material, height) = (self.material(), self.uniform(0.008, 0.05));
            let solid = match self.rng.random_range(0..3) {
                0 => prism(&rectangle(size, size * 0.8), height),
                1 => cylinder(0.5 * size, height, 0.1 * height, 28),
                _ => cone(0.5 * size, 0.42 * size, height, 28),
            };
            self.add(solid, DVec3::new(0.0, 0.0, z), &material);
            z += height - 0.0005;
            size *= self.uniform(0.5, 0.85);
        }
    }
}

/// A smooth profile through the control points (radius, z), with positive radii.
fn fair(controls: &[DVec2]) -> Vec<DVec2> {
    let at = |t: f64| {
        let k = (t as usize).min(controls.len() - 2);
        let s = t - k as f64;
        let eased = s * s * (3.0 - 2.0 * s);
        DVec2::new(
            controls[k].x + eased * (controls[k + 1].x - controls[k].x),
            controls[k].y + s * (controls[k + 1].y - controls[k].y),
        )
    };
    let steps = 5 * (controls.len() - 1);
    (0..=steps).map(|k| at(k as f64 / 5.0)).collect()
}
