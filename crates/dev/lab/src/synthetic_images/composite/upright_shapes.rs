//! Composites that stand upright: lumps, jumbles, lamps, figures, racks.

use glam::{DQuat, DVec2, DVec3};
use rand::RngExt;

use super::CompositeBuilder;
use crate::synthetic_images::sampling::{chance, pale};
use geometry::Material;
use geometry::shapes::{block, cone, cylinder, ellipsoid, shell_of_revolution, tube};

impl CompositeBuilder<'_> {
    pub(super) fn lumps(&mut self) {
        let size = self.uniform(0.03, 0.12);
        let material = self.material();
        for k in 0..self.rng.random_range(1..6) {
            let own =
                DVec3::new(self.uniform(0.6, 1.4), self.uniform(0.6, 1.4), self.uniform(0.5, 1.3)) * size;
            let at = if k == 0 {
                DVec3::ZERO
            } else {
                DVec3::new(self.uniform(-1.0, 1.0), self.uniform(-1.0, 1.0), self.uniform(0.0, 0.6))
                    * 0.8
                    * size
            };
            let other = self.material();
            let material = if chance(self.rng, 0.25) { &other } else { &material };
            self.add(ellipsoid(own, 24), at, material);
        }
    }

    pub(super) fn jumble(&mut self) {
        let size = self.uniform(0.04, 0.14);
        let (mut top, first) = (0.0, self.material());
        for k in 0..self.rng.random_range(2..5) {
            // Parts that differ in every respect would appear as separate objects.
            let material = if chance(self.rng, 0.6) { first.clone() } else { self.material() };
            let own =
                DVec3::new(self.uniform(0.45, 1.0), self.uniform(0.45, 1.0), self.uniform(0.2, 0.9)) * size;
            let off = DVec2::new(self.uniform(-0.15, 0.15), self.uniform(-0.15, 0.15)) * size;
            let solid = match self.rng.random_range(0..4) {
                0 => block(own),
                1 => cylinder(0.5 * own.x, own.z, 0.1 * own.z, 24),
                2 => cone(0.5 * own.x, self.uniform(0.0, 0.6) * own.x, own.z, 24),
                _ => ellipsoid(own, 24),
            };
            let solid = if k > 0 && chance(self.rng, 0.3) {
                solid.rotated(DQuat::from_rotation_x(self.uniform(-0.6, 0.6)))
            } else {
                solid
            };
            let at = off.extend(if chance(self.rng, 0.7) { top } else { 0.0 });
            top = f64::max(top, at.z + 0.85 * own.z);
            self.add(solid, at, &material);
        }
    }

    pub(super) fn lamp(&mut self) {
        let (height, foot) = (self.uniform(0.18, 0.5), self.uniform(0.05, 0.1));
        let (body, shade) = (self.material(), self.material());
        let solid = cylinder(foot, self.uniform(0.01, 0.03), 0.003, 32);
        self.add(solid, DVec3::ZERO, &body);
        let lean = self.uniform(-0.12, 0.16);
        let tip = DVec3::new(lean, 0.0, 0.8 * height);
        let path = [DVec3::new(0.0, 0.0, 0.005), DVec3::new(-0.3 * lean, 0.0, 0.45 * height), tip];
        let solid = tube(&path, self.uniform(0.004, 0.01), 12);
        self.add(solid, DVec3::ZERO, &body);
        let (low, high) = (self.uniform(0.06, 0.12), self.uniform(0.02, 0.08));
        let turn = DQuat::from_rotation_y(self.uniform(-0.5, 0.5));
        let shade = if chance(self.rng, 0.5) { Material::plain("shade", pale(self.rng), 0.7) } else { shade };
        let profile = [DVec2::new(low, 0.0), DVec2::new(high, 0.3 * height)];
        let solid = shell_of_revolution(&profile, 0.002, 0.29 * height, 32);
        self.add(solid.rotated(turn), tip - DVec3::new(0.0, 0.0, 0.2 * height), &shade);
    }

    pub(super) fn figure(&mut self) {
        let size = self.uniform(0.05, 0.14);
        let (body, skin) = (self.material(), self.material());
        self.add(ellipsoid(DVec3::new(0.7, 0.55, 1.0) * size, 24), DVec3::new(0.0, 0.0, 0.25 * size), &body);
        self.add(ellipsoid(DVec3::new(0.5, 0.5, 0.55) * size, 24), DVec3::new(0.0, 0.0, 1.1 * size), &skin);
        for side in [-1.0, 1.0] {
            self.add(
                cylinder(0.12 * size, 0.5 * size, 0.02 * size, 16),
                DVec3::new(0.18 * side * size, 0.0, 0.0),
                &body,
            );
            let (reach, lift) = (self.uniform(0.5, 0.8), self.uniform(0.3, 1.2));
            let arm =
                [DVec3::new(0.2 * side, 0.0, 0.95) * size, DVec3::new(reach * side, -0.25, lift) * size];
            self.add(tube(&arm, 0.08 * size, 10), DVec3::ZERO, &skin);
            if chance(self.rng, 0.6) {
                self.add(
                    cone(0.12 * size, 0.02 * size, 0.35 * size, 14),
                    DVec3::new(0.15 * side, 0.0, 1.55) * size,
                    &body,
                );
            }
        }
        if chance(self.rng, 0.6) {
            self.add(
                cylinder(0.55 * size, 0.08 * size, 0.01 * size, 28),
                DVec3::new(0.0, 0.0, -0.07 * size),
                &skin,
            );
        }
    }

    pub(super) fn rack(&mut self) {
        let size = DVec3::new(self.uniform(0.08, 0.28), self.uniform(0.06, 0.16), self.uniform(0.05, 0.25));
        let material = self.material();
        let material = Material { opacity: 1.0, ..material };
        let bar = self.uniform(0.003, 0.012);
        for (x, y) in [(-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5)] {
            self.add(block(DVec3::new(bar, bar, size.z)), DVec3::new(x * size.x, y * size.y, 0.0), &material);
        }
        for z in [self.uniform(0.05, 0.4), self.uniform(0.6, 1.0)] {
            let z = z * size.z - bar;
            for side in [-0.5, 0.5] {
                self.add(block(DVec3::new(size.x, bar, bar)), DVec3::new(0.0, side * size.y, z), &material);
                self.add(block(DVec3::new(bar, size.y, bar)), DVec3::new(side * size.x, 0.0, z), &material);
            }
            if chance(self.rng, 0.5) {
                self.add(block(DVec3::new(size.x, size.y, 0.4 * bar)), DVec3::new(0.0, 0.0, z), &material);
            }
        }
    }
}
