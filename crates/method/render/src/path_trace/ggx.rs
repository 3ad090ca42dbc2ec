//! The GGX microfacet distribution in the frame of a surface, whose normal is z.
//!
//! Distribution and visible normals: Walter et al., "Microfacet models for refraction through rough surfaces" (2007);
//! Heitz, "Understanding the masking-shadowing function in microfacet-based BRDFs" (2014), height-correlated. Visible
//! normals are sampled as in Dupuy and Benyoub, "Sampling visible GGX normals with spherical caps" (2023).

use std::f32::consts::{PI, TAU};

use glam::{Vec2, Vec3A};

/// A GGX surface of one width of lobe.
#[derive(Clone, Copy, Debug)]
pub struct Ggx {
    alpha: f32,
}

impl Ggx {
    /// The lobe of a roughness; alpha is its square.
    pub fn new(roughness: f32) -> Self {
        Self { alpha: (roughness * roughness).clamp(1e-4, 1.0) }
    }

    /// Density of normals at a half vector.
    pub fn density(self, h: Vec3A) -> f32 {
        // In components along the surface: for a narrow lobe 1 - z^2 would be rounding alone.
        let t = (h.x * h.x + h.y * h.y) / (self.alpha * self.alpha) + h.z * h.z;
        1.0 / (PI * self.alpha * self.alpha * t * t)
    }

    /// Share of the facets visible from a direction with cosine `c`.
    pub fn visible(self, c: f32) -> f32 {
        2.0 * c / (c + self.slope(c))
    }

    /// Share of the facets visible from two directions.
    pub fn visible_from_both(self, v: f32, l: f32) -> f32 {
        2.0 * v * l / (v * self.slope(l) + l * self.slope(v))
    }

    fn slope(self, c: f32) -> f32 {
        let a2 = self.alpha * self.alpha;
        (a2 + (1.0 - a2) * c * c).sqrt()
    }

    /// Probability per solid angle of reflecting `v` about a visible normal to the direction with half vector `h`.
    pub fn reflection_density(self, v: Vec3A, h: Vec3A) -> f32 {
        self.density(h) * self.visible(v.z) / (4.0 * v.z)
    }

    /// A visible normal as seen from `v`, whose z is positive.
    pub fn visible_normal(self, v: Vec3A, u: Vec2) -> Vec3A {
        let stretch = Vec3A::new(self.alpha, self.alpha, 1.0);
        let v = (v * stretch).normalize();
        let (sin, cos) = (TAU * u.x).sin_cos();
        let z = (1.0 - u.y) * (1.0 + v.z) - v.z;
        let radius = (1.0 - z * z).max(0.0).sqrt();
        let h = Vec3A::new(radius * cos, radius * sin, z) + v;
        (h * stretch).normalize_or(Vec3A::Z)
    }
}
