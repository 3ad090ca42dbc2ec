//! Transparent surfaces: a dielectric with a tinted surface, and a body that covers part of it.
//!
//! Opacity is one number for all that keeps light from passing. Up to [`CLEAR_OPACITY`] it is tint alone: light that
//! passes a surface is multiplied with the base color to the power of the opacity. Beyond, a growing share of the
//! surface is as an opaque one, so that juice, wax and frosted plastic have a body; at 1 all of it is.

use glam::{Vec3, Vec3A};

use crate::forward::shading_materials::ShadingMaterial;

/// Refractive index of glass.
pub const GLASS_INDEX: f32 = 1.5;
/// Largest opacity of a surface without a body.
const CLEAR_OPACITY: f32 = 0.4;

/// Share of the surface that reflects as an opaque one.
pub fn body(opacity: f32) -> f32 {
    let beyond = ((opacity - CLEAR_OPACITY) / (1.0 - CLEAR_OPACITY)).clamp(0.0, 1.0);
    beyond * beyond
}

/// Factor on light that passes the surface.
pub fn tint(material: &ShadingMaterial, albedo: Vec3) -> Vec3 {
    albedo.clamp(Vec3::ZERO, Vec3::ONE).powf(material.opacity)
}

/// Share that an interface reflects of light that meets it with that cosine; `index` is that of the far side over that
/// of the near side.
pub fn fresnel(cosine: f32, index: f32) -> f32 {
    let cosine = cosine.clamp(0.0, 1.0);
    let inside = 1.0 - (1.0 - cosine * cosine) / (index * index);
    if inside <= 0.0 {
        return 1.0;
    }
    let refracted = inside.sqrt();
    let across = (cosine - index * refracted) / (cosine + index * refracted);
    let along = (index * cosine - refracted) / (index * cosine + refracted);
    0.5 * (across * across + along * along)
}

/// Share that passes a surface without being bent: one interface of a closed body, or both of a sheet, whose inner
/// reflections are summed.
pub fn passing(cosine: f32, is_sheet: bool) -> f32 {
    let reflected = fresnel(cosine, GLASS_INDEX);
    if is_sheet { (1.0 - reflected) / (1.0 + reflected) } else { 1.0 - reflected }
}

/// Direction behind an interface of a ray with unit `direction` and `normal`, which faces it; `None` where all light is
/// reflected.
pub fn refracted(direction: Vec3A, normal: Vec3A, index: f32) -> Option<Vec3A> {
    let cosine = -direction.dot(normal);
    let inside = 1.0 - (1.0 - cosine * cosine) / (index * index);
    (inside > 0.0).then(|| (direction / index + (cosine / index - inside.sqrt()) * normal).normalize())
}

/// Direction of the mirrored ray.
pub fn mirrored(direction: Vec3A, normal: Vec3A) -> Vec3A {
    direction - 2.0 * direction.dot(normal) * normal
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fresnel_has_the_known_values() {
        assert!((fresnel(1.0, 1.5) - 0.04).abs() < 1e-6);
        assert!((fresnel(1.0, 1.0 / 1.5) - 0.04).abs() < 1e-6);
        assert_eq!(fresnel(0.5, 1.0 / 1.5), 1.0);
        // At Brewster's angle only light across the plane of incidence is reflected.
        let brewster = 1.5_f32.atan();
        assert!((fresnel(brewster.cos(), 1.5) - 0.5 * (2.0 * brewster).cos().powi(2)).abs() < 1e-5);
    }

    #[test]
    fn refraction_follows_snell_and_is_reversible() {
        let direction = Vec3A::new(0.6, 0.0, -0.8);
        let inside = refracted(direction, Vec3A::Z, 1.5).expect("passes");
        assert!((inside.x - 0.6 / 1.5).abs() < 1e-6);
        let outside = refracted(inside, Vec3A::Z, 1.0 / 1.5).expect("passes");
        assert!(outside.abs_diff_eq(direction, 1e-5), "{outside}");
        assert!(refracted(Vec3A::new(0.8, 0.0, -0.6), Vec3A::Z, 1.0 / 1.5).is_none());
    }
}
