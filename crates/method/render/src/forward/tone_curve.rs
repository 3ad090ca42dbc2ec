//! The tone curve from scene light to image light.

use glam::Vec3;

/// Leaves dark and medium values unchanged and compresses highlights softly below 1.
#[inline]
pub fn compress(linear: Vec3) -> Vec3 {
    const KNEE: f32 = 0.72;
    // Both pieces have slope 1 at the knee, so that no edge shows there.
    let bend = |c: f32| {
        if c <= KNEE { c } else { KNEE + (1.0 - KNEE) * (1.0 - (-(c - KNEE) / (1.0 - KNEE)).exp()) }
    };
    Vec3::new(bend(linear.x), bend(linear.y), bend(linear.z))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn compress_is_monotone_and_at_most_one() {
        let values: Vec<f32> = (0..400).map(|k| compress(Vec3::splat(k as f32 * 0.01)).x).collect();
        assert!(values.windows(2).all(|w| w[0] <= w[1]) && values.iter().all(|&v| v <= 1.0));
        assert_eq!(values[50], 0.5);
    }
}
