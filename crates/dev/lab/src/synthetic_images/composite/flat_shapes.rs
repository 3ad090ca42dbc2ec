//! Composites that lie flat: sheets, tools, wire.

use std::f64::consts::{FRAC_PI_2, TAU};

use glam::{DQuat, DVec2, DVec3};
use rand::RngExt;

use super::CompositeBuilder;
use crate::synthetic_images::sampling::{chance, uniform};
use geometry::Material;
use geometry::shapes::{
    block, circle, cylinder, ellipsoid, prism, rectangle, ring, rounded_rectangle, slab, smooth, sweep, tube,
};

impl CompositeBuilder<'_> {
    pub(super) fn sheet(&mut self) {
        let (width, depth) = (self.uniform(0.05, 0.38), self.uniform(0.05, 0.3));
        let material = self.printed_material();
        if chance(self.rng, 0.3) {
            // Two pages that rise toward the fold.
            let rise = self.uniform(0.004, 0.03);
            for side in [-1.0, 1.0] {
                let profile: Vec<DVec2> = (0..=8)
                    .map(|k| {
                        let t = f64::from(k) / 8.0;
                        DVec2::new(0.5 * width * t, 0.002 + rise * (1.0 - t) * (t * 9.0).min(1.0))
                    })
                    .collect();
                let mut outline = vec![DVec2::new(0.5 * width, 0.0)];
                outline.extend(profile.iter().rev());
                outline.push(DVec2::ZERO);
                let page = prism(&outline, depth)
                    .rotated(DQuat::from_rotation_x(FRAC_PI_2))
                    .translated(DVec3::new(0.0, 0.5 * depth, 0.0));
                let page = if side < 0.0 {
                    page.rotated(DQuat::from_rotation_z(std::f64::consts::PI))
                } else {
                    page
                };
                self.mesh.add(catalog::texture::mapped_from_above(page), &material);
            }
            return;
        }
        let outline = match self.rng.random_range(0..4) {
            0 => rounded_rectangle(width, depth, self.uniform(0.0, 0.3) * depth + 0.001, 4),
            1 => circle(0.5 * width.min(0.25), 40),
            2 => {
                let knots: Vec<DVec2> = (0..7)
                    .map(|k| {
                        0.5 * width.min(0.2)
                            * uniform(self.rng, 0.6, 1.0)
                            * DVec2::from_angle(TAU * f64::from(k) / 7.0)
                    })
                    .collect();
                smooth(&knots, 6)
            }
            _ => rectangle(width, depth),
        };
        let thick = self.uniform(0.001, 0.014);
        self.mesh
            .add(catalog::texture::mapped_from_above(slab(&outline, thick, 0.0).with_flat_ends()), &material);
    }

    pub(super) fn tool(&mut self) {
        let length = self.uniform(0.08, 0.34);
        let thick = self.uniform(0.006, 0.032);
        let (handle, head) = (self.material(), self.material());
        let bulge = self.uniform(0.6, 1.6);
        let path = [
            DVec3::new(-0.5 * length, 0.0, 0.5 * thick),
            DVec3::new(0.1 * length, 0.0, 0.5 * thick),
            DVec3::new(0.5 * length, 0.0, 0.5 * thick),
        ];
        let section =
            if chance(self.rng, 0.5) { circle(0.5 * thick, 14) } else { rectangle(1.4 * thick, thick) };
        self.add(sweep(&path, &section, DVec3::Z, |t| 1.0 + (bulge - 1.0) * (1.0 - t)), DVec3::ZERO, &handle);
        let end = DVec3::new(0.5 * length, 0.0, 0.0);
        let size = self.uniform(1.2, 4.0) * thick;
        let solid = match self.rng.random_range(0..5) {
            0 => block(DVec3::new(size, self.uniform(1.0, 3.0) * size, thick)),
            1 => ellipsoid(DVec3::new(2.0 * size, 1.3 * size, thick), 20),
            2 => ring(size, 0.4 * thick, 28, 10),
            3 => slab(
                &smooth(
                    &[
                        DVec2::new(-size, -0.4 * size),
                        DVec2::new(1.5 * size, -0.5 * size),
                        DVec2::new(2.2 * size, 0.1 * size),
                        DVec2::new(-size, 0.4 * size),
                    ],
                    5,
                ),
                0.4 * thick,
                0.0,
            ),
            _ => cylinder(0.6 * size, thick, 0.1 * thick, 20),
        };
        self.add(solid, end, &head);
    }

    pub(super) fn wire(&mut self) {
        let material = self.material();
        let material = Material { opacity: 1.0, ..material };
        let thick = self.uniform(0.0012, 0.005);
        let size = self.uniform(0.03, 0.1);
        for _ in 0..self.rng.random_range(1..3) {
            let at = DVec3::new(self.uniform(-1.0, 1.0), self.uniform(-1.0, 1.0), 0.0) * 0.4 * size;
            if chance(self.rng, 0.5) {
                let own = self.uniform(0.6, 1.0);
                self.add(ring(own * size, thick, 32, 8), at, &material);
            } else {
                let knots: Vec<DVec2> = (0..6)
                    .map(|_| DVec2::new(self.uniform(-1.0, 1.0), self.uniform(-1.0, 1.0)) * size)
                    .collect();
                let curve = smooth(&knots, 8);
                let path: Vec<DVec3> = curve[..curve.len() - 8].iter().map(|p| p.extend(thick)).collect();
                self.add(tube(&path, thick, 8), at, &material);
            }
        }
    }
}
