//! Tone curves from scene light to image light.

use glam::Vec3;

/// Mapping of scene light to image light.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ToneCurve {
    /// Equal to light up to a knee, then bent below 1, each channel for itself.
    #[default]
    Knee,
    /// Keeps hue and, up to bright lights, saturation.
    Photographic,
}

impl ToneCurve {
    #[inline]
    pub fn apply(self, linear: Vec3) -> Vec3 {
        match self {
            Self::Knee => bend(linear),
            Self::Photographic => photographic(linear),
        }
    }
}

/// Leaves dark and medium values unchanged and compresses highlights softly below 1.
#[inline]
fn bend(linear: Vec3) -> Vec3 {
    const KNEE: f32 = 0.72;
    // Both pieces have slope 1 at the knee, so that no edge shows there.
    let bend = |c: f32| {
        if c <= KNEE { c } else { KNEE + (1.0 - KNEE) * (1.0 - (-(c - KNEE) / (1.0 - KNEE)).exp()) }
    };
    Vec3::new(bend(linear.x), bend(linear.y), bend(linear.z))
}

/// Khronos "PBR Neutral" (2024): the black that Fresnel reflection adds is taken off, the strongest channel is
/// compressed, the others keep their ratio to it, and only what is far beyond white fades to white.
fn photographic(linear: Vec3) -> Vec3 {
    /// Half of what a dielectric reflects at normal incidence: all of it would make wood glow.
    const BLACK: f32 = 0.02;
    const START: f32 = 0.76;
    const DESATURATION: f32 = 0.15;
    let low = linear.min_element();
    let black = if low < 2.0 * BLACK { low - low * low / (4.0 * BLACK) } else { BLACK };
    let color = linear - Vec3::splat(black);
    let peak = color.max_element();
    if peak < START {
        return color;
    }
    let room = 1.0 - START;
    let compressed = 1.0 - room * room / (peak + room - START);
    let white = 1.0 - 1.0 / (DESATURATION * (peak - compressed) + 1.0);
    (color * (compressed / peak)).lerp(Vec3::splat(compressed), white)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn curves_are_monotone_and_at_most_one() {
        for curve in [ToneCurve::Knee, ToneCurve::Photographic] {
            let values: Vec<f32> = (0..400).map(|k| curve.apply(Vec3::splat(k as f32 * 0.01)).x).collect();
            assert!(values.windows(2).all(|w| w[0] <= w[1]) && values.iter().all(|&v| v <= 1.0), "{curve:?}");
        }
        assert_eq!(ToneCurve::Knee.apply(Vec3::splat(0.5)).x, 0.5);
    }

    #[test]
    fn photographic_curve_keeps_hue() {
        // Hue as the place of the medium channel between the others.
        let hue = |c: Vec3| (c.y - c.z) / (c.x - c.z);
        for (medium, low) in [(0.3, 0.05), (0.55, 0.2), (0.12, 0.02)] {
            for light in [0.2, 0.6, 1.0, 1.5, 3.0] {
                let color = light * Vec3::new(0.8, medium, low);
                let shown = ToneCurve::Photographic.apply(color);
                assert!((hue(shown) - hue(color)).abs() < 1e-3, "{color} becomes {shown}");
            }
        }
    }
}
