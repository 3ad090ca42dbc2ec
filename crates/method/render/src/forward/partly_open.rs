//! Light from the surroundings where nearby surfaces hide a part of them, and reflect light in turn.
//!
//! What hides the sky from a point is lit itself. With neighbors as light as the surface, the light that arrives is a
//! polynomial of the open share and of the albedo, fitted to path-traced images (Jimenez et al., "Practical real-time
//! strategies for accurate indirect occlusion", 2016, equation 10).

use glam::Vec3;

use super::sky::SkyShare;

/// Light on a surface, by what can hide it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PartlyOpen {
    /// From far surroundings if nothing hid them.
    pub far: Vec3,
    /// Share of `far` that arrives, 0..1.
    pub arriving: f32,
    /// From a place of tabletop or floor if nothing shaded it.
    pub near: Vec3,
    /// Share of the sky's light that arrives at that place, 0..1.
    pub near_open: f32,
}

/// Share of the light of a place that arrives where no sky is seen from there.
pub const SHADED: f32 = 0.16;

impl PartlyOpen {
    /// Light of which nothing is hidden.
    pub fn whole(light: Vec3) -> Self {
        Self { far: light, arriving: 1.0, near: Vec3::ZERO, near_open: 1.0 }
    }

    /// Light that arrives between surfaces of that albedo, the surface's own. What shades the place near it is mostly
    /// the object itself.
    #[inline]
    pub fn between(&self, albedo: Vec3) -> Vec3 {
        let lit = Vec3::splat(SHADED) + (1.0 - SHADED) * with_reflections(self.near_open, albedo);
        self.far * with_reflections(self.arriving, albedo) + self.near * lit
    }
}

/// Share of light from far surroundings that arrives without reflections. Corners darken faster than openness falls,
/// since the open directions that are left there are near the horizon, which the maps do not reach.
pub fn arriving(seen: SkyShare) -> f32 {
    seen.arriving * (0.6 + 0.4 * seen.arriving)
}

/// Share of light that arrives, with that of reflections between surfaces of that albedo.
#[inline]
fn with_reflections(arriving: f32, albedo: Vec3) -> Vec3 {
    let a = 2.0404 * albedo - Vec3::splat(0.3324);
    let b = -4.7951 * albedo + Vec3::splat(0.6417);
    let c = 2.7552 * albedo + Vec3::splat(0.6903);
    let reflected = ((a * arriving + b) * arriving + c) * arriving;
    // The fit differs from the ends of its range by a thousandth.
    reflected.clamp(Vec3::splat(arriving), Vec3::ONE)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn surfaces_that_hide_the_sky_reflect_the_more_light_the_lighter_they_are() {
        let at = |arriving: f32, gray: f32| with_reflections(arriving, Vec3::splat(gray)).x;
        for arriving in [0.1, 0.3, 0.5, 0.8] {
            assert!(at(arriving, 0.0) >= arriving);
            assert!(at(arriving, 0.8) > at(arriving, 0.4));
            assert!(at(arriving, 0.4) > at(arriving, 0.05));
        }
        // Half open between white walls: an infinite series of reflections, 0.5 / (1 - 0.5 * albedo).
        assert!((at(0.5, 0.8) - 0.5 / (1.0 - 0.4)).abs() < 0.1);
        for gray in [0.0, 0.5, 1.0] {
            assert_eq!([at(0.0, gray), at(1.0, gray)], [0.0, 1.0]);
        }
    }
}
