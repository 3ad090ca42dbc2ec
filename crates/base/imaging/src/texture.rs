//! A texture: an image on a surface, with its mipmap levels and its PNG files.

use std::ops::Deref;
use std::sync::{Arc, OnceLock};

use super::Image;
use super::codec::encode_png;
use super::srgb::{LINEAR_OF_SRGB, SrgbEncoder};

/// A base-color image that repeats in both directions; v = 0 is the image's *bottom* row
/// (the convention of USD and OBJ; the glTF writer flips). Clones share one image.
#[derive(Clone, Debug)]
pub struct Texture(Arc<Pyramid>);

#[derive(Debug)]
struct Pyramid {
    image: Image,
    /// Mipmap levels without the full size, each half as large as the one before, the last a single texel; computed on
    /// first use.
    halved: OnceLock<Vec<Image>>,
    /// The image as a PNG file, and upside down; computed on first use.
    png: OnceLock<Vec<u8>>,
    upside_down_png: OnceLock<Vec<u8>>,
}

impl Texture {
    pub fn new(image: Image) -> Self {
        let (halved, png, upside_down_png) = (OnceLock::new(), OnceLock::new(), OnceLock::new());
        Self(Arc::new(Pyramid { image, halved, png, upside_down_png }))
    }

    /// Whether both are clones of one texture, which implies equality. O(1).
    pub fn is_clone_of(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.0, &other.0)
    }

    /// The image as a PNG file, encoded once for all clones.
    pub fn png(&self) -> &[u8] {
        self.0.png.get_or_init(|| encode_png(&self.0.image))
    }

    /// The image upside down, as glTF has textures, as a PNG file that is encoded once for all clones.
    pub fn upside_down_png(&self) -> &[u8] {
        self.0.upside_down_png.get_or_init(|| encode_png(&self.0.image.upside_down()))
    }

    /// Mipmap levels of half the size, a quarter and so on down to one texel, averaged in linear light. Computed
    /// once for all clones.
    pub fn halved(&self) -> &[Image] {
        self.0.halved.get_or_init(|| {
            let mut levels: Vec<Image> = Vec::new();
            loop {
                let last = levels.last().unwrap_or(&self.0.image);
                if last.width_px() <= 1 && last.height_px() <= 1 {
                    return levels;
                }
                levels.push(halved(last));
            }
        })
    }
}

impl Deref for Texture {
    type Target = Image;

    fn deref(&self) -> &Image {
        &self.0.image
    }
}

impl From<Image> for Texture {
    fn from(image: Image) -> Self {
        Self::new(image)
    }
}

impl PartialEq for Texture {
    fn eq(&self, other: &Self) -> bool {
        self.is_clone_of(other) || **self == **other
    }
}

fn halved(image: &Image) -> Image {
    let (width, height) = (image.width_px() as usize, image.height_px() as usize);
    let (half_width, half_height) = ((width / 2).max(1), (height / 2).max(1));
    let bytes = image.as_rgba();
    let (linear, srgb) = (&*LINEAR_OF_SRGB, SrgbEncoder::default());
    let mut rgba = Vec::with_capacity(half_width * half_height * 4);
    for y in 0..half_height {
        let (upper, lower) = ((2 * y).min(height - 1) * width, (2 * y + 1).min(height - 1) * width);
        for x in 0..half_width {
            let (left, right) = ((2 * x).min(width - 1), (2 * x + 1).min(width - 1));
            let corners = [4 * (upper + left), 4 * (upper + right), 4 * (lower + left), 4 * (lower + right)];
            for channel in 0..3 {
                let sum: f32 = corners.iter().map(|at| linear[bytes[at + channel] as usize]).sum();
                rgba.push(srgb.byte(0.25 * sum));
            }
            rgba.push(255);
        }
    }
    Image::from_rgba(half_width as u32, half_height as u32, rgba).expect("exactly width x height x 4 bytes")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::codec::decode_png;
    use crate::srgb::encode_srgb;

    #[test]
    fn mipmap_levels_halve_down_to_one_texel_of_mean_linear_light() {
        let mut image = Image::filled(8, 4, [0, 0, 0, 255]);
        (0..4).for_each(|y| (0..4).for_each(|x| image.set_pixel(x, y, [255, 255, 255, 255])));
        let texture = Texture::new(image);
        let sizes: Vec<(u32, u32)> =
            texture.halved().iter().map(|level| (level.width_px(), level.height_px())).collect();
        assert_eq!(sizes, [(4, 2), (2, 1), (1, 1)]);
        assert_eq!(texture.halved()[2].pixel(0, 0)[0], encode_srgb(0.5));
    }

    #[test]
    fn files_hold_the_image_and_its_mirror_image() {
        let mut image = Image::filled(3, 5, [9, 8, 7, 255]);
        image.set_pixel(2, 0, [1, 2, 3, 40]);
        let texture = Texture::new(image.clone());
        assert_eq!(decode_png(texture.png()).expect("a PNG file"), image);
        let mirrored = decode_png(texture.upside_down_png()).expect("a PNG file");
        assert_eq!((mirrored.pixel(2, 4), mirrored.pixel(2, 0)), ([1, 2, 3, 40], [9, 8, 7, 255]));
        assert_eq!(mirrored.upside_down(), image);
    }

    #[test]
    fn clones_share_mipmap_levels_and_files() {
        let texture = Texture::new(Image::filled(16, 16, [9, 8, 7, 255]));
        assert!(std::ptr::eq(texture.halved(), texture.clone().halved()));
        assert!(std::ptr::eq(texture.png(), texture.clone().png()));
        assert!(std::ptr::eq(texture.upside_down_png(), texture.clone().upside_down_png()));
        assert_eq!(texture, Texture::new(Image::filled(16, 16, [9, 8, 7, 255])));
    }
}
