//! Relighting of a finished image: a brightness gradient and a color cast.

use glam::DVec2;
use rand::RngExt;

use super::Noise;
use imaging::Image;
use runtime::seed::child_rng;

/// The part of the whole image that a crop shows.
#[derive(Clone, Copy, Debug)]
pub struct CropRegion {
    /// x0, y0, x1, y1 in pixels of the whole image.
    pub part_px: [f64; 4],
    /// Width and height of the whole image.
    pub whole_px: [f64; 2],
}

/// Changes the light of an image. A crop (`region`) gets the light of its place in the whole image. Transparency is
/// unchanged.
pub fn relight(image: &mut Image, noise: &Noise, seed: u64, region: Option<CropRegion>) {
    let mut rng = child_rng(seed, "light noise");
    let turn_rad = rng.random_range(0.0..std::f64::consts::TAU);
    let slope = noise.light_slope_share * DVec2::from_angle(turn_rad);
    let cast = [0; 3].map(|_| 1.0 + noise.light_cast_share * rng.random_range(-1.0..1.0));
    let (width, height) = (image.width_px(), image.height_px());
    let own = DVec2::new(f64::from(width), f64::from(height));
    let CropRegion { part_px: [x0, y0, x1, y1], whole_px } =
        region.unwrap_or(CropRegion { part_px: [0.0, 0.0, own.x, own.y], whole_px: own.to_array() });
    let (low, size) = (DVec2::new(x0, y0), DVec2::new(x1 - x0, y1 - y0));
    for (k, pixel) in image.as_rgba_mut().chunks_exact_mut(4).enumerate() {
        let at = DVec2::new((k % width as usize) as f64 + 0.5, (k / width as usize) as f64 + 0.5);
        let in_whole = (low + at / own * size) / DVec2::from(whole_px);
        let brightness = 1.0 + slope.dot(2.0 * in_whole - 1.0);
        for (channel, factor) in pixel.iter_mut().zip(cast) {
            *channel = (f64::from(*channel) * brightness * factor).round().clamp(0.0, 255.0) as u8;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn relight_of_crop_matches_whole_image() {
        let mut whole = Image::filled(80, 60, [120, 120, 120, 255]);
        let mut detail = Image::filled(20, 20, [120, 120, 120, 255]);
        relight(&mut whole, &Noise::NOISY, 5, None);
        let region = CropRegion { part_px: [40.0, 20.0, 60.0, 40.0], whole_px: [80.0, 60.0] };
        relight(&mut detail, &Noise::NOISY, 5, Some(region));
        assert_eq!(detail.pixel(3, 7), whole.pixel(43, 27));
        assert_ne!(whole.pixel(0, 0), whole.pixel(79, 59));
    }
}
