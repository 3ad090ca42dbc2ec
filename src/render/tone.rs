//! Between linear light and 8-bit sRGB.

use std::sync::LazyLock;

use glam::Vec3;

/// Linear light of each sRGB byte.
pub static LINEAR_OF_SRGB: LazyLock<[f32; 256]> = LazyLock::new(|| {
    std::array::from_fn(|k| {
        let c = k as f32 / 255.0;
        if c <= 0.04045 { c / 12.92 } else { ((c + 0.055) / 1.055).powf(2.4) }
    })
});

/// sRGB byte by the square root of linear light: finely spaced where bytes are.
static SRGB_OF_ROOT: LazyLock<[u8; 4097]> = LazyLock::new(|| {
    std::array::from_fn(|k| {
        let root = k as f32 / 4096.0;
        let c = root * root;
        let s = if c <= 0.003_130_8 { 12.92 * c } else { 1.055 * c.powf(1.0 / 2.4) - 0.055 };
        (s * 255.0).round() as u8
    })
});

/// sRGB byte of linear light, clamped to 0..1.
#[inline]
pub fn encode_srgb(linear: f32) -> u8 {
    let root = linear.clamp(0.0, 1.0).sqrt();
    SRGB_OF_ROOT[(root * 4096.0 + 0.5) as usize]
}

/// Leaves darks and middles as they are and bends highlights softly below 1.
#[inline]
pub fn compress(linear: Vec3) -> Vec3 {
    const KNEE: f32 = 0.72;
    let bend = |c: f32| {
        if c <= KNEE { c } else { KNEE + (1.0 - KNEE) * (1.0 - (-(c - KNEE) / (1.0 - KNEE)).exp()) }
    };
    Vec3::new(bend(linear.x), bend(linear.y), bend(linear.z))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_byte_comes_back() {
        for byte in 0..=255_u8 {
            assert_eq!(encode_srgb(LINEAR_OF_SRGB[byte as usize]), byte);
        }
    }

    #[test]
    fn compression_keeps_order_and_stays_below_one() {
        let values: Vec<f32> = (0..400).map(|k| compress(Vec3::splat(k as f32 * 0.01)).x).collect();
        assert!(values.windows(2).all(|w| w[0] <= w[1]) && values.iter().all(|&v| v <= 1.0));
        assert_eq!(values[50], 0.5);
    }
}
