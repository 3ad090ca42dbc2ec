//! Materials of composites: solid colors, metals, woods, glass, prints.

use rand::RngExt;

use super::CompositeBuilder;
use crate::synthetic_images::sampling::{any_color, chance, near, pale, weighted, wood_color};
use catalog::texture::{ceramic_speckle, fabric_weave, fill_disc, fill_rectangle, granite, wood_grain};
use geometry::{Material, Rgb};
use imaging::{Image, Texture};

impl CompositeBuilder<'_> {
    pub(super) fn color(&mut self) -> Rgb {
        match self.tone {
            Some(tone) => near(self.rng, tone, 0.06),
            None => any_color(self.rng),
        }
    }

    pub(super) fn material(&mut self) -> Material {
        let color = self.color();
        let rough = self.uniform(0.15, 0.9) as f32;
        match weighted(self.rng, &[(0, 7.0), (1, 1.2), (2, 0.8), (3, 0.5), (4, 0.5), (5, 0.4), (6, 0.5)]) {
            1 => Material::metal("metal", color.mix(Rgb([0.75; 3]), 0.6), self.uniform(0.1, 0.5) as f32),
            2 => {
                let color = self.tone.unwrap_or_else(|| wood_color(self.rng));
                Material::textured("wood", wood_grain(color, self.rng), rough)
            }
            3 => Material::textured("speckled", ceramic_speckle(color, self.rng), rough),
            4 => Material::textured("woven", fabric_weave(color, self.rng), 0.95),
            5 => Material::textured("grained", granite(color, self.rng), rough),
            6 => Material { opacity: self.uniform(0.3, 0.6) as f32, ..Material::plain("glass", color, 0.08) },
            _ => Material::plain("plain", color, rough),
        }
    }

    pub(super) fn printed_material(&mut self) -> Material {
        if self.tone.is_some() || chance(self.rng, 0.45) {
            return self.material();
        }
        let side = 128;
        let ground = if chance(self.rng, 0.4) { pale(self.rng) } else { any_color(self.rng) };
        let mut image = Image::filled(side, side, ground.to_rgba8());
        for _ in 0..self.rng.random_range(1..14) {
            let color = any_color(self.rng);
            let mut at = || self.rng.random_range(0..side as i32);
            let (x, y, w, h) = (at(), at(), 2 + at() / 3, 2 + at() / 6);
            match self.rng.random_range(0..3) {
                0 => fill_disc(&mut image, x, y, h / 2 + 1, color),
                _ => fill_rectangle(&mut image, x, y, w, h, color),
            }
        }
        if chance(self.rng, 0.4) {
            let ink = any_color(self.rng).scaled(0.5);
            let (left, right) = (self.rng.random_range(6..30), self.rng.random_range(80..122));
            for line in 0..self.rng.random_range(4..20) {
                let end = right - self.rng.random_range(0..30);
                fill_rectangle(&mut image, left, 8 + 6 * line, end - left, 2, ink);
            }
        }
        Material::textured("print", Texture::new(image), self.uniform(0.2, 0.9) as f32)
    }
}
