//! Two images and their difference side by side.

use imaging::Image;
use render::annotate::{fitted, side_by_side};

/// Both images, the second as large as the first, and the difference of each channel of each pixel.
pub fn comparison(before: &Image, after: &Image) -> Image {
    let after = fitted(after, before.width_px(), before.height_px());
    side_by_side(&[before, &after, &difference(before, &after)])
}

/// Absolute differences per channel, opaque, as large as the first image; white where the second has no pixel.
fn difference(before: &Image, after: &Image) -> Image {
    let (width_px, height_px) = (before.width_px(), before.height_px());
    let mut image = Image::filled(width_px, height_px, [255; 4]);
    for y in 0..height_px.min(after.height_px()) {
        for x in 0..width_px.min(after.width_px()) {
            let (a, b) = (before.pixel(x, y), after.pixel(x, y));
            let [red, green, blue] = [0, 1, 2].map(|channel| a[channel].abs_diff(b[channel]));
            image.set_pixel(x, y, [red, green, blue, 255]);
        }
    }
    image
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_pixels_are_black_and_others_have_their_difference() {
        let before = Image::filled(4, 3, [100, 20, 30, 255]);
        let mut after = before.clone();
        after.set_pixel(2, 1, [90, 25, 30, 0]);
        let image = difference(&before, &after);
        assert_eq!(image.pixel(2, 1), [10, 5, 0, 255]);
        assert_eq!(image.pixel(1, 1), [0, 0, 0, 255]);
    }

    #[test]
    fn an_image_of_another_shape_is_compared_where_both_are() {
        let (before, after) = (Image::filled(4, 4, [9, 9, 9, 255]), Image::filled(8, 4, [9, 9, 9, 255]));
        let page = comparison(&before, &after);
        // The second becomes 4 x 2 pixels to be compared, and 8 x 4 beside the others; gaps have 6 columns.
        assert_eq!((page.width_px(), page.height_px()), (4 + 6 + 8 + 6 + 4, 4));
        let image = difference(&before, &fitted(&after, 4, 4));
        assert_eq!((image.pixel(0, 0), image.pixel(0, 3)), ([0, 0, 0, 255], [255; 4]));
    }
}
