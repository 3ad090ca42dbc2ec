//! Single marks on an image of known scale.

use std::f32::consts::TAU;

use glam::Vec2;
use imaging::Image;
use rand::RngExt;
use runtime::seed::Rng;

use crate::texture::Noise;
use geometry::Rgb;

const DUST: Rgb = Rgb([0.8, 0.78, 0.73]);
const COFFEE: Rgb = Rgb([0.3, 0.19, 0.1]);

/// An image that is drawn on, with its scale. Places are meters from its top left corner and wrap around.
pub(super) struct Canvas {
    pub image: Image,
    /// Along x and y.
    meters_per_px: Vec2,
}

impl Canvas {
    /// Of an image that covers `size_m` along u and v.
    pub fn new(image: Image, size_m: Vec2) -> Self {
        let meters_per_px = size_m / Vec2::new(image.width_px() as f32, image.height_px() as f32);
        Self { image, meters_per_px }
    }

    fn size_m(&self) -> Vec2 {
        self.meters_per_px * Vec2::new(self.image.width_px() as f32, self.image.height_px() as f32)
    }

    fn place(&self, rng: &mut Rng) -> Vec2 {
        self.size_m() * Vec2::new(rng.random_range(0.0..1.0), rng.random_range(0.0..1.0))
    }

    /// Half the width of the soft edge of a mark, meters: a mark narrower than a pixel becomes fainter instead of
    /// disappearing between pixels.
    fn blur_m(&self) -> f32 {
        0.35 * (self.meters_per_px.x + self.meters_per_px.y)
    }

    /// Mixes every pixel in `reach_m` around a place toward a color, by `share` of the offset from there in meters.
    fn mix(&mut self, center_m: Vec2, reach_m: Vec2, color: Rgb, share: impl Fn(Vec2) -> f32) {
        let (width, height) = (self.image.width_px() as i32, self.image.height_px() as i32);
        let first = ((center_m - reach_m) / self.meters_per_px).floor();
        let last = ((center_m + reach_m) / self.meters_per_px).ceil();
        // A mark wider than the image covers each of its pixels once.
        let columns = first.x as i32..(last.x as i32).min(first.x as i32 + width);
        for row in first.y as i32..(last.y as i32).min(first.y as i32 + height) {
            for column in columns.clone() {
                let pixel_m = (Vec2::new(column as f32, row as f32) + 0.5) * self.meters_per_px;
                let share = share(pixel_m - center_m);
                if share > 0.002 {
                    self.mix_pixel(column.rem_euclid(width), row.rem_euclid(height), color, share);
                }
            }
        }
    }

    fn mix_pixel(&mut self, x: i32, y: i32, color: Rgb, share: f32) {
        let [r, g, b, alpha] = self.image.pixel(x as u32, y as u32);
        let before = Rgb([r, g, b].map(|byte| f32::from(byte) / 255.0));
        let [r, g, b, _] = before.mix(color, share.min(1.0)).to_rgba8();
        self.image.set_pixel(x as u32, y as u32, [r, g, b, alpha]);
    }

    fn color_at(&self, place_m: Vec2) -> Rgb {
        let at = place_m / self.meters_per_px;
        let (x, y) = (at.x as u32, at.y as u32);
        let [r, g, b, _] =
            self.image.pixel(x.min(self.image.width_px() - 1), y.min(self.image.height_px() - 1));
        Rgb([r, g, b].map(|byte| f32::from(byte) / 255.0))
    }

    /// Dust that lies unevenly, up to `share` of the color.
    pub fn dust(&mut self, share: f32, rng: &mut Rng) {
        let [broad, fine] = [(5, 4), (37, 29)].map(|(columns, rows)| Noise::new(columns, rows, rng));
        let (width, height) = (self.image.width_px(), self.image.height_px());
        for y in 0..height {
            for x in 0..width {
                let (u, v) = (x as f32 / width as f32, y as f32 / height as f32);
                let lies = broad.at(u, v) * (0.6 + 0.4 * fine.at(u, v));
                self.mix_pixel(x as i32, y as i32, DUST, share * lies * lies);
            }
        }
    }

    /// A blot with a darker rim, 6 to 40 mm in radius at most a sixth of the image.
    pub fn stain(&mut self, contrast: f32, rng: &mut Rng) {
        let center_m = self.place(rng);
        let largest_m = self.size_m().min_element() / 6.0;
        let radius_m = (0.006 * rng.random_range(1.0_f32..6.5)).min(largest_m);
        let [second, third] = [(2.0, 0.22), (3.0, 0.14)].map(|(times, share)| {
            (times, share * rng.random_range(0.3_f32..1.0), rng.random_range(0.0..TAU))
        });
        let color = self.color_at(center_m).mix(COFFEE, 0.4).scaled(0.6);
        let contrast = contrast * rng.random_range(0.4_f32..1.6);
        self.mix(center_m, Vec2::splat(1.5 * radius_m), color, |offset_m| {
            let angle = offset_m.to_angle();
            let wave = |(times, share, phase): (f32, f32, f32)| share * (times * angle + phase).sin();
            let distance = offset_m.length() / (radius_m * (1.0 + wave(second) + wave(third)));
            let inside = ((1.0 - distance) * 5.0).clamp(0.0, 1.0);
            let rim = (1.0 - (distance - 0.9).abs() * 9.0).max(0.0);
            contrast * (0.55 * inside + 0.75 * rim * inside.max(0.2))
        });
    }

    /// The ring that a wet cup leaves, broken in places.
    pub fn ring(&mut self, contrast: f32, rng: &mut Rng) {
        let center_m = self.place(rng);
        let radius_m = rng.random_range(0.03_f32..0.043);
        let half_m = rng.random_range(0.0008_f32..0.0019);
        let blur_m = self.blur_m();
        let phases: [f32; 3] = std::array::from_fn(|_| rng.random_range(0.0..TAU));
        let color = self.color_at(center_m).mix(COFFEE, 0.5).scaled(0.7);
        let contrast = contrast * rng.random_range(1.0_f32..2.2) * (half_m / (half_m + 0.5 * blur_m));
        self.mix(center_m, Vec2::splat(radius_m + half_m + blur_m), color, |offset_m| {
            let angle = offset_m.to_angle();
            let waves = (angle + phases[0]).sin()
                + 0.7 * (3.0 * angle + phases[1]).sin()
                + 0.4 * (7.0 * angle + phases[2]).sin();
            let wet = (0.55 + 0.5 * waves).clamp(0.0, 1.0);
            let beside_m = (offset_m.length() - radius_m).abs();
            contrast * wet * ((half_m + blur_m - beside_m) / (2.0 * blur_m)).clamp(0.0, 1.0)
        });
    }

    /// A slightly bent line that is deepest halfway, of a length in the range, more often short. It is lighter
    /// than a dark surface and darker than a light one.
    pub fn scratch(&mut self, length_m: (f64, f64), contrast: f32, rng: &mut Rng) {
        let center_m = self.place(rng);
        let (shortest, longest) = (length_m.0 as f32, length_m.1 as f32);
        let length_m = shortest * (longest / shortest).powf(rng.random_range(0.0_f32..1.0).powi(2));
        let direction = Vec2::from_angle(rng.random_range(0.0..TAU));
        let bend = rng.random_range(-0.12_f32..0.12) / length_m;
        let half_m = rng.random_range(0.00012_f32..0.0004);
        let blur_m = self.blur_m();
        let beneath = self.color_at(center_m);
        let is_dark = beneath.0.iter().sum::<f32>() < 1.5;
        let color = if is_dark { beneath.mix(Rgb([0.92, 0.88, 0.8]), 0.6) } else { beneath.scaled(0.55) };
        let contrast = contrast * rng.random_range(0.4_f32..1.3) * (half_m / blur_m).clamp(0.35, 1.0);
        let reach_m = 0.5 * length_m * direction.abs() + Vec2::splat(half_m + blur_m + 0.04 * length_m);
        self.mix(center_m, reach_m, color, |offset_m| {
            let along = offset_m.dot(direction) / (0.5 * length_m);
            if along.abs() >= 1.0 {
                return 0.0;
            }
            let bent_m = bend * (along * 0.5 * length_m).powi(2);
            let beside_m = (direction.perp_dot(offset_m) - bent_m).abs();
            let depth = 1.0 - along * along;
            contrast * depth * ((half_m + blur_m - beside_m) / (2.0 * blur_m)).clamp(0.0, 1.0)
        });
    }
}
