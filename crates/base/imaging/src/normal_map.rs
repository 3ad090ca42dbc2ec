//! Maps of normals from images of height.

use super::srgb::LINEAR_OF_SRGB;
use super::{Image, Texture};

/// Direction in which the green channel of a map of normals points.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum GreenAxis {
    /// Up in the image, as v grows: OpenGL's, USD's.
    Up,
    /// Down in the image.
    Down,
}

/// Map of the normals of a surface whose height is the luminance of the texture, in linear light, times `relief`: white
/// over black as a share of the length in which the texture repeats. Half as wide and high as the texture, in which
/// single texels are noise. A byte is `127.5 + 127.5 n`; red points to the right.
pub fn normal_map(texture: &Texture, relief: f32, green: GreenAxis) -> Texture {
    let image: &Image = texture.halved().first().unwrap_or(texture);
    let (width, height) = (image.width_px() as usize, image.height_px() as usize);
    let heights: Vec<f32> = image.as_rgba().chunks_exact(4).map(luminance).collect();
    let up = match green {
        GreenAxis::Up => 1.0,
        GreenAxis::Down => -1.0,
    };
    let mut rgba = Vec::with_capacity(4 * width * height);
    for y in 0..height {
        let (above, below) = ((y + height - 1) % height * width, (y + 1) % height * width);
        for x in 0..width {
            let (left, right) = ((x + width - 1) % width, (x + 1) % width);
            let along_u = 0.5 * width as f32 * (heights[y * width + right] - heights[y * width + left]);
            let along_v = 0.5 * height as f32 * (heights[above + x] - heights[below + x]);
            let normal = [-relief * along_u, -relief * along_v * up, 1.0];
            let length = normal.iter().map(|c| c * c).sum::<f32>().sqrt();
            rgba.extend(normal.map(|c| (127.5 + 127.5 * c / length).round() as u8));
            rgba.push(255);
        }
    }
    Texture::new(Image::from_rgba(width as u32, height as u32, rgba).expect("four bytes for each texel"))
}

/// Luminance of a texel in linear light, 0..1 (Rec. 709).
fn luminance(rgba: &[u8]) -> f32 {
    let linear = &*LINEAR_OF_SRGB;
    [0.2126, 0.7152, 0.0722].iter().zip(rgba).map(|(share, byte)| share * linear[usize::from(*byte)]).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 64 texels wide and high, dark at the left and at the bottom of a light square.
    fn square() -> Texture {
        let mut image = Image::filled(64, 64, [0, 0, 0, 255]);
        (16..48).for_each(|y| (16..48).for_each(|x| image.set_pixel(x, y, [255; 4])));
        Texture::new(image)
    }

    #[test]
    fn normals_lean_away_from_what_is_higher() {
        let map = normal_map(&square(), 0.1, GreenAxis::Up);
        assert_eq!((map.width_px(), map.height_px()), (32, 32));
        assert_eq!(map.pixel(16, 16), [128, 128, 255, 255]);
        // Left edge to the left, right edge to the right, upper edge up.
        let [red_left, red_right] = [7, 24].map(|x| map.pixel(x, 16)[0]);
        let [green_above, green_below] = [7, 24].map(|y| map.pixel(16, y)[1]);
        assert!(red_left < 80 && red_right > 175, "{red_left} {red_right}");
        assert!(green_above > 175 && green_below < 80, "{green_above} {green_below}");
        let down = normal_map(&square(), 0.1, GreenAxis::Down);
        assert!(down.pixel(16, 7)[1] < 80);
    }

    #[test]
    fn slopes_are_those_of_the_relief() {
        // One repeat of a ramp in linear light rises by one over half of its width.
        let mut image = Image::filled(256, 2, [0, 0, 0, 255]);
        for x in 0..256_u32 {
            let byte = crate::srgb::encode_srgb((x.min(255 - x)) as f32 / 128.0);
            (0..2).for_each(|y| image.set_pixel(x, y, [byte, byte, byte, 255]));
        }
        let map = normal_map(&Texture::new(image), 0.5, GreenAxis::Up);
        let [red, _, blue, _] = map.pixel(32, 0).map(|byte| (f32::from(byte) - 127.5) / 127.5);
        // Height 0.5 over half a repeat: a slope of one.
        assert!((red / blue + 1.0).abs() < 0.1, "{red} {blue}");
    }
}
