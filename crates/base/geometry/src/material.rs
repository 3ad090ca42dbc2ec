//! Surface materials: the metallic-roughness model that glTF, UsdPreviewSurface and the renderer share.

use serde::{Deserialize, Serialize};

use imaging::{GreenAxis, Texture, normal_map};

/// sRGB-encoded color, each channel 0..1.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(transparent)]
pub struct Rgb(pub [f32; 3]);

impl Rgb {
    /// From a hexadecimal `0xRRGGBB`.
    pub const fn hex(rgb: u32) -> Self {
        Self([
            ((rgb >> 16) & 0xff) as f32 / 255.0,
            ((rgb >> 8) & 0xff) as f32 / 255.0,
            (rgb & 0xff) as f32 / 255.0,
        ])
    }

    /// Linear-light channels, for shading.
    pub fn to_linear(self) -> [f32; 3] {
        self.0.map(|c| if c <= 0.04045 { c / 12.92 } else { ((c + 0.055) / 1.055).powf(2.4) })
    }

    /// Mix toward `other`: 0 keeps this color, 1 gives the other.
    pub fn mix(self, other: Rgb, amount: f32) -> Rgb {
        let mut mixed = self.0;
        for (channel, to) in mixed.iter_mut().zip(other.0) {
            *channel += (to - *channel) * amount;
        }
        Rgb(mixed)
    }

    /// Lighter (`factor` > 1) or darker (< 1), clamped.
    pub fn scaled(self, factor: f32) -> Rgb {
        Rgb(self.0.map(|c| (c * factor).clamp(0.0, 1.0)))
    }

    /// Bytes with full alpha.
    pub fn to_rgba8(self) -> [u8; 4] {
        let [r, g, b] = self.0.map(|c| nearest_byte(c.clamp(0.0, 1.0) * 255.0));
        [r, g, b, 255]
    }

    /// `#rrggbb`.
    pub fn to_hex(self) -> String {
        let [r, g, b, _] = self.to_rgba8();
        format!("#{r:02x}{g:02x}{b:02x}")
    }
}

/// Rounds a number in 0..=255, halves up. Without SSE 4.1, `f32::round` is a function call.
#[inline]
fn nearest_byte(x: f32) -> u8 {
    let below = x as u8;
    below + u8::from(x - f32::from(below) >= 0.5)
}

/// Metallic-roughness material.
#[derive(Clone, Debug, PartialEq)]
pub struct Material {
    /// `[a-z0-9_]`, unique in its mesh.
    pub name: String,
    /// Multiplied with the texture, if there is one.
    pub base_color: Rgb,
    pub base_color_texture: Option<Texture>,
    /// 0 = mirror, 1 = chalk.
    pub roughness: f32,
    /// 0 = dielectric, 1 = metal.
    pub metalness: f32,
    /// 1 = opaque. Below 1 the renderer blends the surface (glass).
    pub opacity: f32,
    /// Height of what is white in the texture over what is black, as a share of the length in which the texture
    /// repeats; 0 = flat.
    pub relief: f32,
}

impl Material {
    /// An opaque, untextured dielectric.
    pub fn plain(name: &str, base_color: Rgb, roughness: f32) -> Self {
        Self {
            name: name.to_owned(),
            base_color,
            base_color_texture: None,
            roughness,
            metalness: 0.0,
            opacity: 1.0,
            relief: 0.0,
        }
    }

    /// An opaque, untextured metal.
    pub fn metal(name: &str, base_color: Rgb, roughness: f32) -> Self {
        Self { metalness: 1.0, ..Self::plain(name, base_color, roughness) }
    }

    /// Normals of the relief; `None` of a flat material.
    pub fn normal_map(&self, green: GreenAxis) -> Option<Texture> {
        let texture = self.base_color_texture.as_ref().filter(|_| self.relief > 0.0)?;
        Some(normal_map(texture, self.relief, green))
    }

    /// An opaque dielectric colored by a texture alone.
    pub fn textured(name: &str, texture: Texture, roughness: f32) -> Self {
        Self { base_color_texture: Some(texture), ..Self::plain(name, Rgb([1.0, 1.0, 1.0]), roughness) }
    }
}
