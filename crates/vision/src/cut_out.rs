//! A thing drawn before one plain color, cut out of it: for those who draw on no transparent background.
//!
//! What has the color of the drawing's border, and whatever looks just like it (the hole of a handle), is the backdrop; a pixel
//! around it mixes both and is given up. The color is agreed on before, far from those of the thing ([`far_from`]).

use imaging::{Image, Mask};

/// Colors that a backdrop may have, with their names.
const BACKDROPS: [Backdrop; 4] = [
    Backdrop { name: "white", rgb: [255, 255, 255] },
    Backdrop { name: "green", rgb: [0, 200, 60] },
    Backdrop { name: "magenta", rgb: [240, 0, 240] },
    Backdrop { name: "blue", rgb: [0, 60, 240] },
];

/// Largest difference in a channel from the border's color: of what is next to it, and of what is enclosed.
const ALIKE: u8 = 40;
const THE_SAME: u8 = 20;

/// Share of the border that has its color where the backdrop is plain.
const PLAIN_SHARE: f64 = 0.9;

/// Share of the thing's pixels whose difference from a backdrop decides about it: a few of any color do no harm.
const FEW: f64 = 0.05;

/// One plain color.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Backdrop {
    pub name: &'static str,
    pub rgb: [u8; 3],
}

/// The backdrop whose color is farthest from those of what the mask shows.
pub fn far_from(picture: &Image, visible: &Mask) -> Backdrop {
    let contrast = |backdrop: &Backdrop| {
        let all = (0..picture.height_px()).flat_map(|y| (0..picture.width_px()).map(move |x| (x, y)));
        let mut differences: Vec<u8> = all
            .filter(|&(x, y)| visible.contains(x, y))
            .map(|(x, y)| difference(picture.pixel(x, y), backdrop.rgb))
            .collect();
        differences.sort_unstable();
        differences.get((FEW * differences.len() as f64) as usize).copied().unwrap_or(0)
    };
    // Of equal ones the first.
    let best = BACKDROPS.iter().rev().max_by_key(|backdrop| contrast(backdrop));
    best.copied().unwrap_or(BACKDROPS[0])
}

/// The drawing with its backdrop transparent, or `None` where what is around the thing is not one color.
pub fn cut_out(drawing: &Image) -> Option<Image> {
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
    let plain = border.iter().filter(|&&(x, y)| differs_by(x, y) <= ALIKE).count();
    if (plain as f64) < PLAIN_SHARE * border.len() as f64 || border.is_empty() {
        return None;
    }
    let at = |x: u32, y: u32| y as usize * width as usize + x as usize;
    let mut is_backdrop: Vec<bool> = all().map(|(x, y)| differs_by(x, y) <= THE_SAME).collect();
    let mut open: Vec<(u32, u32)> = border.into_iter().filter(|&(x, y)| differs_by(x, y) <= ALIKE).collect();
    let mut seen = vec![false; is_backdrop.len()];
    open.iter().for_each(|&(x, y)| seen[at(x, y)] = true);
    while let Some((x, y)) = open.pop() {
        is_backdrop[at(x, y)] = true;
        for (u, v) in beside(x, y, width, height) {
            if !seen[at(u, v)] && differs_by(u, v) <= ALIKE {
                seen[at(u, v)] = true;
                open.push((u, v));
            }
        }
    }
    let mut cut = drawing.clone();
    for (x, y) in all() {
        if is_backdrop[at(x, y)] || beside(x, y, width, height).any(|(u, v)| is_backdrop[at(u, v)]) {
            cut.set_pixel(x, y, [0; 4]);
        }
    }
    Some(cut)
}

/// What a thing that was cut out looks like before a backdrop.
pub fn laid_on(thing: &Image, backdrop: [u8; 3]) -> Image {
    let mut laid = thing.clone();
    for y in 0..thing.height_px() {
        for x in 0..thing.width_px() {
            let [r, g, b, alpha] = thing.pixel(x, y);
            let share = f64::from(alpha) / 255.0;
            let mixed = |own: u8, behind: u8| {
                (share * f64::from(own) + (1.0 - share) * f64::from(behind)).round() as u8
            };
            let color = [mixed(r, backdrop[0]), mixed(g, backdrop[1]), mixed(b, backdrop[2]), 255];
            laid.set_pixel(x, y, color);
        }
    }
    laid
}

/// The largest difference in a channel.
fn difference([r, g, b, _]: [u8; 4], to: [u8; 3]) -> u8 {
    r.abs_diff(to[0]).max(g.abs_diff(to[1])).max(b.abs_diff(to[2]))
}

/// The four pixels next to one.
fn beside(x: u32, y: u32, width: u32, height: u32) -> impl Iterator<Item = (u32, u32)> {
    let around = [(x.wrapping_sub(1), y), (x + 1, y), (x, y.wrapping_sub(1)), (x, y + 1)];
    around.into_iter().filter(move |&(u, v)| u < width && v < height)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A red ring of radii 20 and 40 around 60, 60 with soft edges, before a slightly uneven green.
    fn ring() -> Image {
        let mut thing = Image::filled(120, 120, [0; 4]);
        for y in 0..120_u32 {
            for x in 0..120_u32 {
                let away = (f64::from(x) - 60.0).hypot(f64::from(y) - 60.0);
                let alpha = (40.5 - away).clamp(0.0, 1.0) * (away - 19.5).clamp(0.0, 1.0);
                thing.set_pixel(x, y, [200, 20, 20, (255.0 * alpha) as u8]);
            }
        }
        let mut drawing = laid_on(&thing, [0, 200, 60]);
        (0..120).step_by(7).for_each(|x| drawing.set_pixel(x, 3, [8, 210, 50, 255]));
        drawing
    }

    #[test]
    fn a_ring_is_cut_out_with_its_hole() {
        let cut = cut_out(&ring()).expect("the backdrop is plain");
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
    fn a_scene_has_no_plain_backdrop() {
        let mut scene = ring();
        (0..120).for_each(|x| (60..120).for_each(|y| scene.set_pixel(x, y, [90, 60, 40, 255])));
        assert_eq!(cut_out(&scene), None);
    }

    #[test]
    fn the_backdrop_is_far_from_the_thing() {
        let all = Mask::from_fn(8, 8, |_, _| true);
        let of = |color: [u8; 4]| far_from(&Image::filled(8, 8, color), &all).name;
        assert_eq!(of([250, 250, 250, 255]), "green");
        assert_eq!(of([10, 190, 70, 255]), "white");
        assert_ne!(of([230, 20, 230, 255]), "magenta");
    }
}
