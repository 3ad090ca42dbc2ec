//! Chroma keying: removes a uniform background from generated images whose model cannot output alpha.
//!
//! Background is every pixel of the border's color that is connected to the border, and every enclosed pixel of
//! nearly the same color (the hole of a handle). Pixels next to it mix both colors and are removed as well.
//! [`pick_key_color`] selects a key color far from the object's colors.

use imaging::{Image, Mask};

/// Key colors with their names.
const KEY_COLORS: [KeyColor; 4] = [
    KeyColor { name: "white", rgb: [255, 255, 255] },
    KeyColor { name: "green", rgb: [0, 200, 60] },
    KeyColor { name: "magenta", rgb: [240, 0, 240] },
    KeyColor { name: "blue", rgb: [0, 60, 240] },
];

/// Maximum difference in a channel from the border's color: of connected pixels, and of enclosed ones.
const NEIGHBOR_TOLERANCE: u8 = 40;
const ENCLOSED_TOLERANCE: u8 = 20;

/// Minimum share of border pixels of one color in a uniform background.
const MIN_PLAIN_SHARE: f64 = 0.9;

/// Share of the object's pixels that may be near a key color.
const OUTLIER_SHARE: f64 = 0.05;

/// A background color.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct KeyColor {
    pub name: &'static str,
    pub rgb: [u8; 3],
}

/// The key color farthest from the colors below the mask.
pub fn pick_key_color(image: &Image, visible: &Mask) -> KeyColor {
    let contrast = |key: &KeyColor| {
        let all = (0..image.height_px()).flat_map(|y| (0..image.width_px()).map(move |x| (x, y)));
        let mut differences: Vec<u8> = all
            .filter(|&(x, y)| visible.contains(x, y))
            .map(|(x, y)| difference(image.pixel(x, y), key.rgb))
            .collect();
        differences.sort_unstable();
        differences.get((OUTLIER_SHARE * differences.len() as f64) as usize).copied().unwrap_or(0)
    };
    // Of equal contrasts the first.
    let best = KEY_COLORS.iter().rev().max_by_key(|key| contrast(key));
    best.copied().unwrap_or(KEY_COLORS[0])
}

/// The image with its background transparent; `None` if the background is not uniform.
pub fn remove_background(drawing: &Image) -> Option<Image> {
    let (width, height) = (drawing.width_px(), drawing.height_px());
    let on_border = |x: u32, y: u32| x == 0 || y == 0 || x + 1 == width || y + 1 == height;
    let all = || (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
    let border: Vec<(u32, u32)> = all().filter(|&(x, y)| on_border(x, y)).collect();
    let rgb = [0, 1, 2].map(|channel| {
        let mut values: Vec<u8> = border.iter().map(|&(x, y)| drawing.pixel(x, y)[channel]).collect();
        values.sort_unstable();
        values.get(values.len() / 2).copied().unwrap_or(0)
    });
    let differs_by = |x, y| difference(drawing.pixel(x, y), rgb);
    let plain = border.iter().filter(|&&(x, y)| differs_by(x, y) <= NEIGHBOR_TOLERANCE).count();
    if (plain as f64) < MIN_PLAIN_SHARE * border.len() as f64 || border.is_empty() {
        return None;
    }
    let at = |x: u32, y: u32| y as usize * width as usize + x as usize;
    let mut is_background: Vec<bool> = all().map(|(x, y)| differs_by(x, y) <= ENCLOSED_TOLERANCE).collect();
    let mut open: Vec<(u32, u32)> =
        border.into_iter().filter(|&(x, y)| differs_by(x, y) <= NEIGHBOR_TOLERANCE).collect();
    let mut seen = vec![false; is_background.len()];
    open.iter().for_each(|&(x, y)| seen[at(x, y)] = true);
    while let Some((x, y)) = open.pop() {
        is_background[at(x, y)] = true;
        for (u, v) in neighbors(x, y, width, height) {
            if !seen[at(u, v)] && differs_by(u, v) <= NEIGHBOR_TOLERANCE {
                seen[at(u, v)] = true;
                open.push((u, v));
            }
        }
    }
    let mut cut = drawing.clone();
    for (x, y) in all() {
        if is_background[at(x, y)] || neighbors(x, y, width, height).any(|(u, v)| is_background[at(u, v)]) {
            cut.set_pixel(x, y, [0; 4]);
        }
    }
    Some(cut)
}

/// The object over a uniform background.
pub fn composite_over(object: &Image, key: [u8; 3]) -> Image {
    let mut composite = object.clone();
    for y in 0..object.height_px() {
        for x in 0..object.width_px() {
            let [r, g, b, alpha] = object.pixel(x, y);
            let share = f64::from(alpha) / 255.0;
            let mixed = |own: u8, behind: u8| {
                (share * f64::from(own) + (1.0 - share) * f64::from(behind)).round() as u8
            };
            let color = [mixed(r, key[0]), mixed(g, key[1]), mixed(b, key[2]), 255];
            composite.set_pixel(x, y, color);
        }
    }
    composite
}

/// Maximum difference over the channels.
fn difference([r, g, b, _]: [u8; 4], to: [u8; 3]) -> u8 {
    r.abs_diff(to[0]).max(g.abs_diff(to[1])).max(b.abs_diff(to[2]))
}

/// The four neighbors of a pixel.
fn neighbors(x: u32, y: u32, width: u32, height: u32) -> impl Iterator<Item = (u32, u32)> {
    let around = [(x.wrapping_sub(1), y), (x + 1, y), (x, y.wrapping_sub(1)), (x, y + 1)];
    around.into_iter().filter(move |&(u, v)| u < width && v < height)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A red ring of radii 20 and 40 around 60, 60 with soft edges, before a slightly uneven green.
    fn ring() -> Image {
        let mut object = Image::filled(120, 120, [0; 4]);
        for y in 0..120_u32 {
            for x in 0..120_u32 {
                let away = (f64::from(x) - 60.0).hypot(f64::from(y) - 60.0);
                let alpha = (40.5 - away).clamp(0.0, 1.0) * (away - 19.5).clamp(0.0, 1.0);
                object.set_pixel(x, y, [200, 20, 20, (255.0 * alpha) as u8]);
            }
        }
        let mut drawing = composite_over(&object, [0, 200, 60]);
        (0..120).step_by(7).for_each(|x| drawing.set_pixel(x, 3, [8, 210, 50, 255]));
        drawing
    }

    #[test]
    fn remove_background_clears_hole_of_ring() {
        let cut = remove_background(&ring()).expect("the key is plain");
        let solid = |x: u32, y: u32| cut.pixel(x, y)[3] > 0;
        let mut area = 0;
        for y in 0..120_u32 {
            for x in 0..120_u32 {
                let away = (f64::from(x) - 60.0).hypot(f64::from(y) - 60.0);
                assert!(!solid(x, y) || (20.0..40.0).contains(&away), "{x}, {y}");
                assert!(solid(x, y) || !(22.5..37.5).contains(&away), "{x}, {y}");
                area += u32::from(solid(x, y));
            }
        }
        assert!(area > 3000 && solid(60, 30) && cut.pixel(60, 30) == [200, 20, 20, 255]);
    }

    #[test]
    fn remove_background_rejects_nonuniform_background() {
        let mut scene = ring();
        (0..120).for_each(|x| (60..120).for_each(|y| scene.set_pixel(x, y, [90, 60, 40, 255])));
        assert_eq!(remove_background(&scene), None);
    }

    #[test]
    fn key_color_contrasts_with_object() {
        let all = Mask::from_fn(8, 8, |_, _| true);
        let of = |color: [u8; 4]| pick_key_color(&Image::filled(8, 8, color), &all).name;
        assert_eq!(of([250, 250, 250, 255]), "green");
        assert_eq!(of([10, 190, 70, 255]), "white");
        assert_ne!(of([230, 20, 230, 255]), "magenta");
    }
}
