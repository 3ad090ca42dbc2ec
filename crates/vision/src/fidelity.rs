//! How much the picture of a finished scene is like the picture the scene was made from, thing by thing.
//!
//! Inputs: the picture and the scene from the same camera (any sizes of one proportion), and of each thing its pixels in
//! both, as large as the picture. Computes intersection over union of those pixels, the mean CIELAB distance (CIE 1976) of
//! colors where both show the same thing, and two kinds of regions: what shows a thing in the picture and none in the scene
//! is missed, the other way round it is invented. Overlaps are counted at the masks' resolution, colors and regions at the
//! scene picture's. The light of the two differs, and color distances hold that too. Cost: a few milliseconds a thing.

use super::pixels::{Pixels, distance};
use super::regions::parts;
use imaging::{Image, Mask};
use render::overlay::fitted;

/// Regions that are listed, largest first.
const LISTED: usize = 8;

/// Least share of the picture a listed region fills.
const LEAST_REGION: f64 = 0.0002;

/// What was found out about a scene.
#[derive(Clone, Debug, PartialEq)]
pub struct Likeness {
    /// In the order of the masks.
    pub things: Vec<ThingLikeness>,
    /// Mean CIELAB distance over all pixels where both show the same thing; `None` where no pixel does.
    pub color_distance: Option<f64>,
    /// Of what shows things in the picture.
    pub missed: Regions,
    /// Of what shows things in the scene.
    pub invented: Regions,
}

/// One thing in both pictures.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ThingLikeness {
    /// Intersection over union of its pixels, 0..1.
    pub overlap: f64,
    /// Mean CIELAB distance where both show it; `None` where no pixel does.
    pub color_distance: Option<f64>,
}

/// Pixels that show something in one picture only.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Regions {
    /// Of all pixels that show something in that picture, 0..1.
    pub share: f64,
    /// The largest ones; specks are left out.
    pub largest: Vec<Region>,
}

/// Pixels that hang together.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Region {
    /// Which thing most of them show.
    pub thing: usize,
    /// x0, y0 inclusive; x1, y1 exclusive; pixels of the masks.
    pub box_px: [u32; 4],
    /// Of all pixels of the picture, 0..1.
    pub picture_share: f64,
}

/// Compares; also draws where both agree (green), what the scene misses (red) and what it invents (blue) on the picture in
/// gray, as large as the scene.
pub fn compare(picture: &Image, scene: &Image, in_picture: &[&Mask], in_scene: &[Mask]) -> (Likeness, Image) {
    let (width, height) = (scene.width_px() as usize, scene.height_px() as usize);
    let seen = Pixels::new(&resized(picture, scene), u32::MAX);
    let made = Pixels::new(scene, u32::MAX);
    let full = in_picture.first().map_or([1, 1], |mask| [mask.width_px(), mask.height_px()]);
    let owners = |contains: &dyn Fn(usize, u32, u32) -> bool, count: usize| -> Vec<Option<usize>> {
        let at = |k: usize, of: usize, all: u32| {
            (((k as f64 + 0.5) * f64::from(all) / of as f64) as u32).min(all.saturating_sub(1))
        };
        let owner = |(y, x): (usize, usize)| {
            let (u, v) = (at(x, width, full[0]), at(y, height, full[1]));
            (0..count).find(|&thing| contains(thing, u, v))
        };
        (0..height).flat_map(|y| (0..width).map(move |x| (y, x))).map(owner).collect()
    };
    let picture_of = owners(&|thing, x, y| in_picture[thing].contains(x, y), in_picture.len());
    let scene_of = owners(&|thing, x, y| in_scene[thing].contains(x, y), in_scene.len());

    let mut sums = vec![(0.0_f64, 0_usize); in_picture.len()];
    for (index, (a, b)) in picture_of.iter().zip(&scene_of).enumerate() {
        if let Some(thing) = a.filter(|_| a == b) {
            sums[thing].0 += f64::from(distance(seen.lab[index], made.lab[index]));
            sums[thing].1 += 1;
        }
    }
    let mean = |(sum, count): (f64, usize)| (count > 0).then(|| sum / count as f64);
    let things = in_picture.iter().zip(in_scene).zip(&sums);
    let likeness = Likeness {
        things: things
            .map(|((a, b), sum)| ThingLikeness { overlap: a.iou(b), color_distance: mean(*sum) })
            .collect(),
        color_distance: mean(sums.iter().fold((0.0, 0), |all, one| (all.0 + one.0, all.1 + one.1))),
        missed: regions(&picture_of, &scene_of, [width, height], full),
        invented: regions(&scene_of, &picture_of, [width, height], full),
    };
    let drawn = agreement(&seen.copy, &picture_of, &scene_of);
    (likeness, drawn)
}

/// The picture as large as the scene.
fn resized(picture: &Image, scene: &Image) -> Image {
    let small = fitted(picture, scene.width_px(), scene.height_px());
    if (small.width_px(), small.height_px()) == (scene.width_px(), scene.height_px()) {
        return small;
    }
    // Rounding may have left a row or column.
    let mut same = Image::filled(scene.width_px(), scene.height_px(), [255; 4]);
    for y in 0..scene.height_px() {
        for x in 0..scene.width_px() {
            same.set_pixel(x, y, small.pixel(x.min(small.width_px() - 1), y.min(small.height_px() - 1)));
        }
    }
    same
}

/// Where `here` shows something and `there` shows nothing.
fn regions(
    here: &[Option<usize>],
    there: &[Option<usize>],
    [width, height]: [usize; 2],
    full: [u32; 2],
) -> Regions {
    let bits: Vec<bool> =
        here.iter().zip(there).map(|(here, there)| here.is_some() && there.is_none()).collect();
    let count = |bits: &mut dyn Iterator<Item = bool>| bits.filter(|bit| *bit).count() as f64;
    let all = count(&mut here.iter().map(Option::is_some));
    let share = count(&mut bits.iter().copied()) / all.max(1.0);
    let least = (LEAST_REGION * bits.len() as f64).max(2.0);
    let mut found: Vec<Vec<usize>> =
        parts(&bits, width, height).into_iter().filter(|part| part.len() as f64 >= least).collect();
    found.sort_by_key(|part| (std::cmp::Reverse(part.len()), part[0]));
    let largest = found.iter().take(LISTED).map(|part| {
        let things = part.iter().filter_map(|&index| here[index]);
        let mut votes = std::collections::BTreeMap::<usize, usize>::new();
        things.for_each(|thing| *votes.entry(thing).or_default() += 1);
        let most = votes.into_iter().max_by_key(|(thing, votes)| (*votes, std::cmp::Reverse(*thing)));
        let places = || part.iter().map(|index| [index % width, index / width]);
        let low = places().fold([usize::MAX; 2], |low, p| [low[0].min(p[0]), low[1].min(p[1])]);
        let high = places().fold([0; 2], |high, p| [high[0].max(p[0] + 1), high[1].max(p[1] + 1)]);
        let scaled = |k: usize, axis: usize| {
            let of = [width, height][axis] as f64;
            (k as f64 * f64::from(full[axis]) / of).round() as u32
        };
        Region {
            thing: most.map_or(0, |(thing, _)| thing),
            box_px: [scaled(low[0], 0), scaled(low[1], 1), scaled(high[0], 0), scaled(high[1], 1)],
            picture_share: part.len() as f64 / bits.len() as f64,
        }
    });
    Regions { share, largest: largest.collect() }
}

const GREEN: [f64; 3] = [60.0, 180.0, 90.0];
const RED: [f64; 3] = [220.0, 50.0, 47.0];
const BLUE: [f64; 3] = [38.0, 100.0, 230.0];

fn agreement(picture: &Image, picture_of: &[Option<usize>], scene_of: &[Option<usize>]) -> Image {
    let mut drawn = picture.clone();
    for (index, pixel) in drawn.as_rgba_mut().chunks_exact_mut(4).enumerate() {
        let gray = 0.3 * f64::from(pixel[0]) + 0.59 * f64::from(pixel[1]) + 0.11 * f64::from(pixel[2]);
        let tint = match (picture_of[index], scene_of[index]) {
            (None, None) => None,
            (Some(_), Some(_)) => Some(GREEN),
            (Some(_), None) => Some(RED),
            (None, Some(_)) => Some(BLUE),
        };
        for (channel, value) in pixel.iter_mut().take(3).enumerate() {
            // Paler than the picture, so that colors stand out.
            let pale = 0.5 * gray + 127.5;
            *value = tint.map_or(pale, |tint| 0.35 * pale + 0.65 * tint[channel]).round() as u8;
        }
    }
    drawn
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 40 x 20 pixels in the picture; the scene's picture is half as large.
    fn mask(x0: u32, x1: u32) -> Mask {
        Mask::from_fn(40, 20, |x, y| (x0..x1).contains(&x) && (4..16).contains(&y))
    }

    fn painted(width_px: u32, color: [u8; 3]) -> Image {
        let mut image = Image::filled(width_px, width_px / 2, [255; 4]);
        for y in 0..width_px / 2 {
            for x in 0..width_px / 2 {
                image.set_pixel(x, y, [color[0], color[1], color[2], 255]);
            }
        }
        image
    }

    #[test]
    fn a_thing_beside_its_place_is_missed_there_and_invented_here() {
        let (picture, scene) = (painted(40, [119; 3]), painted(20, [119; 3]));
        let (likeness, drawn) =
            compare(&picture, &scene, &[&mask(4, 12), &mask(24, 32)], &[mask(4, 12), mask(28, 36)]);
        let overlaps: Vec<f64> = likeness.things.iter().map(|thing| thing.overlap).collect();
        assert!(overlaps[0] > 0.999 && (overlaps[1] - 1.0 / 3.0).abs() < 1e-9, "{overlaps:?}");
        let [missed] = likeness.missed.largest[..] else { panic!("{:?}", likeness.missed) };
        assert_eq!((missed.thing, missed.box_px), (1, [24, 4, 28, 16]));
        assert!((likeness.missed.share - 0.25).abs() < 1e-9);
        let [invented] = likeness.invented.largest[..] else { panic!("{:?}", likeness.invented) };
        assert_eq!((invented.thing, invented.box_px), (1, [32, 4, 36, 16]));
        assert!((invented.picture_share - 48.0 / 800.0).abs() < 1e-9);
        // Agreed, missed, invented, neither.
        let [green, red, blue, gray] = [4, 12, 17, 0].map(|x| drawn.pixel(x, 5));
        assert!(green[1] > green[0] && red[0] > red[1] && blue[2] > blue[0] && gray[0] == gray[2]);
    }

    #[test]
    fn colors_are_compared_where_both_show_the_thing() {
        let (gray, white) = (painted(40, [119; 3]), painted(20, [255; 3]));
        let (likeness, _) =
            compare(&gray, &white, &[&mask(4, 12), &mask(24, 32)], &[mask(4, 12), mask(0, 4)]);
        // CIELAB lightness 50 against 100.
        let color = likeness.things[0].color_distance.expect("both show it");
        assert!((color - 50.0).abs() < 0.5, "{color}");
        assert_eq!(likeness.things[1].color_distance, None);
        assert_eq!(likeness.color_distance, Some(color));
    }
}
