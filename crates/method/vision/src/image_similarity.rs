//! Similarity of a rendered scene to its reference image, per object.
//!
//! Inputs: the image and the scene from the same camera (any sizes of one aspect ratio), and the pixels of each
//! object in both, as masks at the size of the reference image.
//!
//! Computes the intersection over union of the masks, the mean CIELAB distance (CIE 1976) where both show the same
//! object, and mismatch regions. A region that shows an object only in the image is missed; one that shows an
//! object only in the scene is invented. What the image shows on the table but no object has counts as missed too,
//! else an image of which little was found would be compared with little. Overlaps are counted at the resolution of
//! the masks, colors and regions
//! at that of the scene.
//!
//! Color distances include the difference in lighting. Cost: a few milliseconds an object.

use super::morphology::connected_components;
use super::pixels::{LinearLight, distance, lab_of};
use imaging::{Image, Mask};
use render::annotate::fitted;

/// Maximum number of listed regions, largest first.
const MAX_REGIONS: usize = 8;

/// Minimum share of the image that a listed region fills.
const MIN_REGION: f64 = 0.0002;

/// Similarity of a scene to its reference image.
#[derive(Clone, Debug, PartialEq)]
pub struct SceneSimilarity {
    /// In the order of the masks.
    pub objects: Vec<ObjectSimilarity>,
    /// Mean CIELAB distance over all pixels where both show the same object; `None` without such pixels.
    pub color_distance: Option<f64>,
    /// Pixels with an object in the image only, those of no object included.
    pub missed: MismatchRegions,
    /// Pixels with an object in the scene only.
    pub invented: MismatchRegions,
}

/// Similarity of one object.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ObjectSimilarity {
    /// Intersection over union of its pixels, 0..1.
    pub overlap: f64,
    /// Mean CIELAB distance where both show it; `None` without such pixels.
    pub color_distance: Option<f64>,
}

/// Pixels that show an object in one of the two only.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MismatchRegions {
    /// Share of all object pixels of that side, 0..1.
    pub share: f64,
    /// The largest regions; small fragments are left out.
    pub largest: Vec<MismatchRegion>,
}

/// A connected region.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MismatchRegion {
    /// The object that most of its pixels show; `None` where the image shows something that no object is.
    pub object: Option<usize>,
    /// x0, y0 inclusive; x1, y1 exclusive; pixels of the masks.
    pub box_px: [u32; 4],
    /// Share of all pixels of the image, 0..1.
    pub image_share: f64,
}

/// Compares image and scene. `unread` has the pixels of the image that show something on the table which is none of the
/// objects. Also returns an overlay on the image in gray, at the size of the scene: agreement in
/// green, missed objects in red, invented ones in blue.
pub fn compare(
    image: &Image,
    scene: &Image,
    in_image: &[&Mask],
    in_scene: &[Mask],
    unread: Option<&Mask>,
) -> (SceneSimilarity, Image) {
    let (width, height) = (scene.width_px() as usize, scene.height_px() as usize);
    let image = resized(image, scene);
    let full = in_image.first().map_or([1, 1], |mask| [mask.width_px(), mask.height_px()]);
    let owners = |contains: &dyn Fn(usize, u32, u32) -> bool, count: usize| -> Vec<Option<usize>> {
        let at = |k: usize, of: usize, all: u32| {
            (((k as f64 + 0.5) * f64::from(all) / of as f64) as u32).min(all.saturating_sub(1))
        };
        let owner = |(y, x): (usize, usize)| {
            let (u, v) = (at(x, width, full[0]), at(y, height, full[1]));
            (0..count).find(|&object| contains(object, u, v))
        };
        (0..height).flat_map(|y| (0..width).map(move |x| (y, x))).map(owner).collect()
    };
    // The one behind the last object is what no object is.
    let unowned = in_image.len();
    let shows = |object: usize, x: u32, y: u32| match in_image.get(object) {
        Some(mask) => mask.contains(x, y),
        None => unread.is_some_and(|unread| unread.contains(x, y)),
    };
    let image_of = owners(&shows, unowned + 1);
    let scene_of = owners(&|object, x, y| in_scene[object].contains(x, y), in_scene.len());

    let mut sums = vec![(0.0_f64, 0_usize); in_image.len()];
    let linear = LinearLight::new();
    let lab = |image: &Image, index: usize| {
        let [x, y] = [index % width, index / width].map(|place| place as u32);
        lab_of(linear.of(image.pixel(x, y)))
    };
    for (index, (a, b)) in image_of.iter().zip(&scene_of).enumerate() {
        if let Some(object) = a.filter(|_| a == b) {
            sums[object].0 += f64::from(distance(lab(&image, index), lab(scene, index)));
            sums[object].1 += 1;
        }
    }
    let mean = |(sum, count): (f64, usize)| (count > 0).then(|| sum / count as f64);
    let objects = in_image.iter().zip(in_scene).zip(&sums);
    let similarity = SceneSimilarity {
        objects: objects
            .map(|((a, b), sum)| ObjectSimilarity { overlap: a.iou(b), color_distance: mean(*sum) })
            .collect(),
        color_distance: mean(sums.iter().fold((0.0, 0), |all, one| (all.0 + one.0, all.1 + one.1))),
        missed: mismatch_regions(&image_of, &scene_of, unowned, [width, height], full),
        invented: mismatch_regions(&scene_of, &image_of, unowned, [width, height], full),
    };
    let drawn = agreement_overlay(image, &image_of, &scene_of);
    (similarity, drawn)
}

/// The image at the size of the scene.
fn resized(image: &Image, scene: &Image) -> Image {
    let small = fitted(image, scene.width_px(), scene.height_px());
    if (small.width_px(), small.height_px()) == (scene.width_px(), scene.height_px()) {
        return small;
    }
    // Rounding may leave out a row or column.
    let mut same = Image::filled(scene.width_px(), scene.height_px(), [255; 4]);
    for y in 0..scene.height_px() {
        for x in 0..scene.width_px() {
            same.set_pixel(x, y, small.pixel(x.min(small.width_px() - 1), y.min(small.height_px() - 1)));
        }
    }
    same
}

/// Regions with an object in `here` and none in `there`; the object `unowned` is none of them.
fn mismatch_regions(
    here: &[Option<usize>],
    there: &[Option<usize>],
    unowned: usize,
    [width, height]: [usize; 2],
    full: [u32; 2],
) -> MismatchRegions {
    let bits: Vec<bool> =
        here.iter().zip(there).map(|(here, there)| here.is_some() && there.is_none()).collect();
    let count = |bits: &mut dyn Iterator<Item = bool>| bits.filter(|bit| *bit).count() as f64;
    let all = count(&mut here.iter().map(Option::is_some));
    let share = count(&mut bits.iter().copied()) / all.max(1.0);
    let lowest = (MIN_REGION * bits.len() as f64).max(2.0);
    let mut found: Vec<Vec<usize>> = connected_components(&bits, width, height)
        .into_iter()
        .filter(|part| part.len() as f64 >= lowest)
        .collect();
    found.sort_by_key(|part| (std::cmp::Reverse(part.len()), part[0]));
    let largest = found.iter().take(MAX_REGIONS).map(|part| {
        let objects = part.iter().filter_map(|&index| here[index]);
        let mut votes = std::collections::BTreeMap::<usize, usize>::new();
        objects.for_each(|object| *votes.entry(object).or_default() += 1);
        let highest = votes.into_iter().max_by_key(|(object, votes)| (*votes, std::cmp::Reverse(*object)));
        let places = || part.iter().map(|index| [index % width, index / width]);
        let low = places().fold([usize::MAX; 2], |low, p| [low[0].min(p[0]), low[1].min(p[1])]);
        let high = places().fold([0; 2], |high, p| [high[0].max(p[0] + 1), high[1].max(p[1] + 1)]);
        let scaled = |k: usize, axis: usize| {
            let of = [width, height][axis] as f64;
            (k as f64 * f64::from(full[axis]) / of).round() as u32
        };
        MismatchRegion {
            object: highest.map(|(object, _)| object).filter(|object| *object != unowned),
            box_px: [scaled(low[0], 0), scaled(low[1], 1), scaled(high[0], 0), scaled(high[1], 1)],
            image_share: part.len() as f64 / bits.len() as f64,
        }
    });
    MismatchRegions { share, largest: largest.collect() }
}

const GREEN: [f64; 3] = [60.0, 180.0, 90.0];
const RED: [f64; 3] = [220.0, 50.0, 47.0];
const BLUE: [f64; 3] = [38.0, 100.0, 230.0];

fn agreement_overlay(mut drawn: Image, image_of: &[Option<usize>], scene_of: &[Option<usize>]) -> Image {
    for (index, pixel) in drawn.as_rgba_mut().chunks_exact_mut(4).enumerate() {
        let gray = 0.3 * f64::from(pixel[0]) + 0.59 * f64::from(pixel[1]) + 0.11 * f64::from(pixel[2]);
        let tint = match (image_of[index], scene_of[index]) {
            (None, None) => None,
            (Some(_), Some(_)) => Some(GREEN),
            (Some(_), None) => Some(RED),
            (None, Some(_)) => Some(BLUE),
        };
        for (channel, value) in pixel.iter_mut().take(3).enumerate() {
            // Paler than the image, so that the tints stand out.
            let pale = 0.5 * gray + 127.5;
            *value = tint.map_or(pale, |tint| 0.35 * pale + 0.65 * tint[channel]).round() as u8;
        }
    }
    drawn
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A mask of 40 x 20 pixels; the scene is half as large.
    fn mask(x0: u32, x1: u32) -> Mask {
        Mask::from_fn(40, 20, |x, y| (x0..x1).contains(&x) && (4..16).contains(&y))
    }

    fn rendered(width_px: u32, color: [u8; 3]) -> Image {
        let mut image = Image::filled(width_px, width_px / 2, [255; 4]);
        for y in 0..width_px / 2 {
            for x in 0..width_px / 2 {
                image.set_pixel(x, y, [color[0], color[1], color[2], 255]);
            }
        }
        image
    }

    #[test]
    fn displaced_object_yields_missed_and_invented_region() {
        let (image, scene) = (rendered(40, [119; 3]), rendered(20, [119; 3]));
        let (similarity, drawn) =
            compare(&image, &scene, &[&mask(4, 12), &mask(24, 32)], &[mask(4, 12), mask(28, 36)], None);
        let overlaps: Vec<f64> = similarity.objects.iter().map(|object| object.overlap).collect();
        assert!(overlaps[0] > 0.999 && (overlaps[1] - 1.0 / 3.0).abs() < 1e-9, "{overlaps:?}");
        let [missed] = similarity.missed.largest[..] else { panic!("{:?}", similarity.missed) };
        assert_eq!((missed.object, missed.box_px), (Some(1), [24, 4, 28, 16]));
        assert!((similarity.missed.share - 0.25).abs() < 1e-9);
        let [invented] = similarity.invented.largest[..] else { panic!("{:?}", similarity.invented) };
        assert_eq!((invented.object, invented.box_px), (Some(1), [32, 4, 36, 16]));
        assert!((invented.image_share - 48.0 / 800.0).abs() < 1e-9);
        // Agreed, missed, invented, neither.
        let [green, red, blue, gray] = [4, 12, 17, 0].map(|x| drawn.pixel(x, 5));
        assert!(green[1] > green[0] && red[0] > red[1] && blue[2] > blue[0] && gray[0] == gray[2]);
    }

    #[test]
    fn what_was_not_read_counts_as_missed_unless_the_scene_shows_an_object_there() {
        let (image, scene) = (rendered(40, [119; 3]), rendered(20, [119; 3]));
        let compared =
            |unread: &Mask| compare(&image, &scene, &[&mask(4, 12)], &[mask(4, 16)], Some(unread)).0;
        let beside = compared(&mask(20, 28));
        assert!((beside.missed.share - 0.5).abs() < 1e-9, "{:?}", beside.missed);
        assert_eq!(
            (beside.missed.largest[0].object, beside.missed.largest[0].box_px),
            (None, [20, 4, 28, 16])
        );
        assert!((beside.invented.share - 1.0 / 3.0).abs() < 1e-9, "{:?}", beside.invented);
        let covered = compared(&mask(12, 16));
        assert_eq!((covered.missed.share, covered.invented.share), (0.0, 0.0));
        assert!((covered.objects[0].overlap - 2.0 / 3.0).abs() < 1e-9, "it is none of the object");
    }

    #[test]
    fn color_distance_covers_common_pixels_only() {
        let (gray, white) = (rendered(40, [119; 3]), rendered(20, [255; 3]));
        let (similarity, _) =
            compare(&gray, &white, &[&mask(4, 12), &mask(24, 32)], &[mask(4, 12), mask(0, 4)], None);
        // CIELAB lightness 50 against 100.
        let color = similarity.objects[0].color_distance.expect("both show it");
        assert!((color - 50.0).abs() < 0.5, "{color}");
        assert_eq!(similarity.objects[1].color_distance, None);
        assert_eq!(similarity.color_distance, Some(color));
    }
}
