//! Scale-invariant image fingerprints: color and coverage on a grid over the bounding box of the opaque pixels.
//! Cost: one pass over the pixels.

use imaging::{Image, Mask};

/// Cells along each side of the box.
const CELLS: usize = 24;

/// Weight of the aspect difference, per factor of e.
const ASPECT_WEIGHT: f64 = 0.5;

/// Fingerprint of a crop.
#[derive(Clone, Debug, PartialEq)]
pub struct Fingerprint {
    /// Natural logarithm of width over height.
    aspect: f64,
    /// Red, green, blue times coverage, and coverage; 0..1, row by row.
    cells: Vec<[f64; 4]>,
}

impl Fingerprint {
    /// Fingerprint of the opaque pixels; `None` if there are none.
    pub fn of(image: &Image) -> Option<Self> {
        Self::where_inside(image, |x, y| image.pixel(x, y)[3] >= 128)
    }

    /// Fingerprint of the masked pixels, mask in image size; `None` if the mask is empty.
    pub fn masked(image: &Image, mask: &Mask) -> Option<Self> {
        Self::where_inside(image, |x, y| mask.contains(x, y))
    }

    fn where_inside(image: &Image, inside: impl Fn(u32, u32) -> bool) -> Option<Self> {
        let shown = Mask::from_fn(image.width_px(), image.height_px(), inside);
        let [x0, y0, x1, y1] = shown.bbox_px()?;
        let (width, height) = (f64::from(x1 - x0), f64::from(y1 - y0));
        let mut cells = vec![[0.0; 4]; CELLS * CELLS];
        for row in 0..CELLS {
            for column in 0..CELLS {
                // At least one pixel per cell, so that small crops have no holes.
                let span = |low: u32, length: f64, at: usize| {
                    let from = low + (length * at as f64 / CELLS as f64) as u32;
                    let to = low + (length * (at + 1) as f64 / CELLS as f64).ceil() as u32;
                    from..to.max(from + 1)
                };
                let (mut sum, mut count) = ([0.0; 4], 0.0);
                for y in span(y0, height, row) {
                    for x in span(x0, width, column) {
                        count += 1.0;
                        if shown.contains(x, y) {
                            let [r, g, b, _] = image.pixel(x, y).map(|value| f64::from(value) / 255.0);
                            for (channel, value) in sum.iter_mut().zip([r, g, b, 1.0]) {
                                *channel += value;
                            }
                        }
                    }
                }
                cells[row * CELLS + column] = sum.map(|channel| channel / count);
            }
        }
        Some(Self { aspect: (width / height).ln(), cells })
    }

    /// 0 for equal crops; above about 0.1 they show different objects.
    pub fn distance(&self, other: &Self) -> f64 {
        let apart =
            |(a, b): (&[f64; 4], &[f64; 4])| a.iter().zip(b).map(|(a, b)| (a - b).abs()).sum::<f64>() / 4.0;
        let cells: f64 = self.cells.iter().zip(&other.cells).map(apart).sum();
        cells / self.cells.len() as f64 + ASPECT_WEIGHT * (self.aspect - other.aspect).abs()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn disk(side_px: u32, color: [u8; 3]) -> Image {
        let mut image = Image::filled(side_px + 20, side_px + 20, [0; 4]);
        let radius = 0.5 * f64::from(side_px);
        for y in 0..side_px {
            for x in 0..side_px {
                if (f64::from(x) + 0.5 - radius).hypot(f64::from(y) + 0.5 - radius) < radius {
                    image.set_pixel(x + 10, y + 5, [color[0], color[1], color[2], 255]);
                }
            }
        }
        image
    }

    #[test]
    fn distance_depends_on_color_and_shape_not_size_or_position() {
        let fingerprint = |image: &Image| Fingerprint::of(image).expect("shows something");
        let red = fingerprint(&disk(200, [200, 30, 30]));
        assert!(red.distance(&fingerprint(&disk(63, [200, 30, 30]))) < 0.02);
        assert!(red.distance(&fingerprint(&disk(200, [30, 30, 200]))) > 0.15);
        assert!(red.distance(&fingerprint(&Image::filled(40, 40, [200, 30, 30, 255]))) > 0.05);
        assert!(red.distance(&fingerprint(&Image::filled(80, 20, [200, 30, 30, 255]))) > 0.5);
        assert_eq!(Fingerprint::of(&Image::filled(9, 9, [1, 2, 3, 0])), None);
        let image = Image::filled(30, 30, [200, 30, 30, 255]);
        assert_eq!(
            Fingerprint::masked(&image, &Mask::from_fn(30, 30, |x, _| x < 15)),
            Fingerprint::of(&Image::filled(15, 30, [200, 30, 30, 255]))
        );
    }
}
