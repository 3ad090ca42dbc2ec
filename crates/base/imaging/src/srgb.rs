//! Conversion between linear light and 8-bit sRGB.

use std::sync::LazyLock;

/// Linear light of each sRGB byte.
pub static LINEAR_OF_SRGB: LazyLock<[f32; 256]> = LazyLock::new(|| {
    std::array::from_fn(|k| {
        let c = k as f32 / 255.0;
        if c <= 0.04045 { c / 12.92 } else { ((c + 0.055) / 1.055).powf(2.4) }
    })
});

/// sRGB byte by the square root of linear light, which spaces table entries about evenly over the bytes.
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
    SrgbEncoder::default().byte(linear)
}

/// As [`encode_srgb`], for inner loops: the lazily built table is resolved once, at construction.
#[derive(Clone, Copy)]
pub struct SrgbEncoder(&'static [u8; 4097]);

impl Default for SrgbEncoder {
    fn default() -> Self {
        Self(&SRGB_OF_ROOT)
    }
}

impl SrgbEncoder {
    /// As [`encode_srgb`].
    #[inline]
    pub fn byte(self, linear: f32) -> u8 {
        let root = linear.clamp(0.0, 1.0).sqrt();
        self.0[(root * 4096.0 + 0.5) as usize]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn encode_srgb_inverts_the_linear_table_for_every_byte() {
        for byte in 0..=255_u8 {
            assert_eq!(encode_srgb(LINEAR_OF_SRGB[byte as usize]), byte);
        }
    }
}
