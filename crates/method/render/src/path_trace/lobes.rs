//! Reflection of an opaque surface: GGX over Lambert, after the metallic-roughness model of glTF 2.0 (appendix B).
//!
//! The matte share is what the glossy layer lets in and out again, in the form of Kelemen and Szirmay-Kalos, "A
//! microfacet based coupled specular-matte BRDF model" (2001), so that a white surface reflects all light at every
//! roughness. The glossy share includes light that facets reflect more than once. Directions are unit vectors of the
//! surface's frame, whose normal is z, and point away from it.

use std::f32::consts::{FRAC_1_PI, TAU};

use glam::{Vec2, Vec3, Vec3A};

use super::albedo_table::{GGX_ALBEDO, SplitSum};
use super::ggx::Ggx;
use crate::room::luminance;

/// Reflectance of a dielectric at normal incidence.
const DIELECTRIC: f32 = 0.04;
/// Smallest share of samples of a lobe that reflects anything.
const MIN_SHARE: f32 = 0.1;

/// Reflection toward one direction.
pub struct Lobes {
    v: Vec3A,
    ggx: Ggx,
    roughness: f32,
    f0: Vec3,
    /// Factor for light reflected more than once.
    repeated: Vec3,
    /// Lambert's share of light that has entered from above, over pi.
    matte: Vec3,
    /// Probability of sampling the glossy lobe.
    glossy_share: f32,
}

/// A sampled direction.
pub struct Bounce {
    pub l: Vec3A,
    /// Reflectance times cosine over `density`.
    pub weight: Vec3,
    /// Probability per solid angle.
    pub density: f32,
}

impl Lobes {
    /// The lobes of a surface seen from `v`.
    pub fn new(v: Vec3A, albedo: Vec3, roughness: f32, metalness: f32) -> Self {
        let v = v.with_z(v.z.max(1e-4)).normalize();
        let f0 = Vec3::splat(DIELECTRIC).lerp(albedo, metalness);
        let seen = GGX_ALBEDO.at(v.z, roughness);
        // That of the dielectric and of the metal, in their shares of the glossy light.
        let metal = (albedo * seen.x + seen.y) * (Vec3::ONE + albedo * (1.0 / (seen.x + seen.y) - 1.0));
        let of_both = Vec3::splat(layer(seen)).lerp(metal, metalness);
        let repeated = of_both / (f0 * seen.x + seen.y);
        let entered = 1.0 - layer(seen);
        let base = albedo * (1.0 - metalness);
        let matte = base * (FRAC_1_PI * entered / (1.0 - layer(GGX_ALBEDO.mean(roughness))));
        let glossy = luminance((f0 * seen.x + seen.y) * repeated);
        let total = glossy + luminance(base) * entered;
        let glossy_share = match metalness < 1.0 {
            true => (glossy / total.max(1e-6)).clamp(MIN_SHARE, 1.0 - MIN_SHARE),
            false => 1.0,
        };
        Self { v, ggx: Ggx::new(roughness), roughness, f0, repeated, matte, glossy_share }
    }

    /// Reflectance times cosine, and the density with which [`Self::sample`] finds the direction.
    pub fn toward(&self, l: Vec3A) -> (Vec3, f32) {
        if l.z <= 0.0 {
            return (Vec3::ZERO, 0.0);
        }
        let h = (self.v + l).normalize_or(Vec3A::Z);
        let density = self.glossy_share * self.ggx.reflection_density(self.v, h)
            + (1.0 - self.glossy_share) * l.z * FRAC_1_PI;
        let grazing = (1.0 - self.v.dot(h)).clamp(0.0, 1.0).powi(5);
        let fresnel = self.f0 + (Vec3::ONE - self.f0) * grazing;
        let facets = self.ggx.density(h) * self.ggx.visible_from_both(self.v.z, l.z) / (4.0 * self.v.z);
        let left = 1.0 - layer(GGX_ALBEDO.at(l.z, self.roughness));
        (fresnel * self.repeated * facets + self.matte * (left * l.z), density)
    }

    /// A direction for two numbers and one that selects the lobe; `None` for one below the surface.
    pub fn sample(&self, u: Vec2, lobe: f32) -> Option<Bounce> {
        let l = if lobe < self.glossy_share {
            let h = self.ggx.visible_normal(self.v, u);
            2.0 * self.v.dot(h) * h - self.v
        } else {
            cosine_direction(u)
        };
        let (reflected, density) = self.toward(l);
        (density > 0.0).then(|| Bounce { l, weight: reflected / density, density })
    }
}

/// Share of light that the glossy layer of a dielectric reflects.
fn layer(split: SplitSum) -> f32 {
    (DIELECTRIC * split.x + split.y) * (1.0 + DIELECTRIC * (1.0 / (split.x + split.y) - 1.0))
}

/// A direction with a density of its cosine over pi.
pub fn cosine_direction(u: Vec2) -> Vec3A {
    let radius = u.x.sqrt();
    let (sin, cos) = (TAU * u.y).sin_cos();
    Vec3A::new(radius * cos, radius * sin, (1.0 - u.x).max(0.0).sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Mean of sampled weights, and of a uniform integral over the hemisphere.
    fn reflected(v: Vec3A, albedo: f32, roughness: f32, metalness: f32) -> (f32, f32) {
        const SIDE: usize = 128;
        let lobes = Lobes::new(v, Vec3::splat(albedo), roughness, metalness);
        let (mut sampled, mut integral) = (0.0, 0.0);
        for k in 0..SIDE * SIDE {
            let u = (Vec2::new((k % SIDE) as f32, (k / SIDE) as f32) + 0.5) / SIDE as f32;
            // A third dimension from the golden ratio.
            let lobe = (k as f32 * 0.618_034).fract();
            sampled += lobes.sample(u, lobe).map_or(0.0, |bounce| bounce.weight.x);
            let (sin, cos) = (TAU * u.y).sin_cos();
            let radius = (1.0 - u.x * u.x).sqrt();
            integral += TAU * lobes.toward(Vec3A::new(radius * cos, radius * sin, u.x)).0.x;
        }
        (sampled / (SIDE * SIDE) as f32, integral / (SIDE * SIDE) as f32)
    }

    fn from_elevation(elevation: f32) -> Vec3A {
        Vec3A::new(elevation.cos(), 0.0, elevation.sin())
    }

    #[test]
    fn white_surfaces_reflect_all_light() {
        for elevation in [0.2, 0.5, 0.9, 1.5] {
            for roughness in [0.03, 0.2, 0.5, 0.8, 1.0] {
                for metalness in [0.0, 0.5, 1.0] {
                    let (sampled, _) = reflected(from_elevation(elevation), 1.0, roughness, metalness);
                    assert!(
                        (sampled - 1.0).abs() < 0.02,
                        "{sampled} at {elevation}, roughness {roughness}, metalness {metalness}"
                    );
                }
            }
        }
    }

    #[test]
    fn samples_agree_with_the_integral() {
        for elevation in [0.3, 0.9, 1.4] {
            for (albedo, roughness, metalness) in [(0.3, 0.4, 0.0), (0.6, 0.3, 1.0), (0.0, 0.9, 0.0)] {
                let (sampled, integral) = reflected(from_elevation(elevation), albedo, roughness, metalness);
                assert!((sampled - integral).abs() < 0.01 + 0.02 * integral, "{sampled} {integral}");
            }
        }
    }
}
