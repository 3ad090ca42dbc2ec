//! Amodal completion: the occluded part of a silhouette.
//!
//! Two estimates: the pixels that a fitted shape covers ([`occluded_by_shape`]), and, without one, the occluder
//! pixels inside the convex hull of the visible mask ([`occluded_by_convexity`]). Completed pixels always belong
//! to occluders, adjoin the visible part and are not thin.

use super::morphology;
use super::polygon::{contains, hull_of_pixels};
use imaging::Mask;

/// Maximum distance of the visible part from its occluder, pixels.
const NEAR_PX: f32 = 3.0;
/// Minimum radius of a disc inside a completed component: pixels, and a share of the object's extent.
const MIN_RADIUS_PX: f64 = 1.5;
const MIN_RADIUS: f64 = 0.015;
/// Minimum share of a completed component's edge that adjoins the visible part.
const MIN_EDGE_CONTACT: f64 = 0.4;
/// Minimum overlap of a shape with the visible part, outside occluders.
const MIN_SHAPE_OVERLAP: f64 = 0.75;

/// Pixels of `others` that occlude an object of this shape; `None` if the shape does not fit the visible part. All
/// masks have the size of the image.
pub fn occluded_by_shape(visible: &Mask, others: &Mask, shape: &Mask) -> Option<Mask> {
    let (mut both, mut either, mut border) = (0_usize, 0_usize, 0_usize);
    let width = visible.width_px() as usize;
    for (index, ((seen, hidden), fitted)) in
        visible.bits().iter().zip(others.bits()).zip(shape.bits()).enumerate()
    {
        if *hidden {
            continue;
        }
        both += usize::from(*seen && *fitted);
        either += usize::from(*seen || *fitted);
        border += usize::from(*fitted && index >= width && !shape.bits()[index - width]);
        border += usize::from(*fitted && index > 0 && !shape.bits()[index - 1]);
    }
    if (both as f64) < MIN_SHAPE_OVERLAP * either as f64 {
        return None;
    }
    // The mean misfit along the border is also the tolerance in front of farther objects.
    let misfit_px = (either - both) as f64 / (2 * border).max(1) as f64;
    let crop = Crop::around(visible, Some(shape))?;
    let inside = |k: usize| crop.of(others, k) && crop.of(shape, k) && !crop.of(visible, k);
    Some(crop.added(inside, visible, MIN_RADIUS_PX + 1.5 * misfit_px, 0.0))
}

/// Pixels of `others` inside the convex hull of the visible mask.
pub fn occluded_by_convexity(visible: &Mask, others: &Mask) -> Mask {
    let Some(crop) = Crop::around(visible, None) else {
        return Mask::empty(visible.width_px(), visible.height_px());
    };
    let width = visible.width_px() as usize;
    let set = visible.bits().iter().enumerate().filter(|(_, inside)| **inside);
    let hull = hull_of_pixels(set.map(|(index, _)| index), width);
    let center = |k: usize| {
        let [x, y] = crop.place(k);
        glam::DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5)
    };
    let inside = |k: usize| crop.of(others, k) && !crop.of(visible, k) && contains(&hull, center(k));
    crop.added(inside, visible, MIN_RADIUS_PX, MIN_EDGE_CONTACT)
}

/// Components of `added` that adjoin the visible part and are not thin.
pub fn attached_component(visible: &Mask, added: &Mask) -> Mask {
    let Some(crop) = Crop::around(visible, Some(added)) else {
        return Mask::empty(visible.width_px(), visible.height_px());
    };
    crop.added(|k| crop.of(added, k) && !crop.of(visible, k), visible, MIN_RADIUS_PX, 0.0)
}

/// As [`occluded_by_convexity`], on pixel indices of an image `width` wide; returns both parts together.
pub(crate) fn complete_by_convexity(indices: &[usize], others: &[bool], width: usize) -> Vec<usize> {
    let height = others.len() / width.max(1);
    let mut bits = vec![false; others.len()];
    indices.iter().for_each(|&index| bits[index] = true);
    let mut all = Mask::from_bits(width as u32, height as u32, bits);
    let added = occluded_by_convexity(&all, &Mask::from_bits(width as u32, height as u32, others.to_vec()));
    all.unite(&added);
    all.bits().iter().enumerate().filter(|(_, inside)| **inside).map(|(index, _)| index).collect()
}

/// A crop of the image, by its corner and size.
struct Crop {
    corner: [u32; 2],
    size: [usize; 2],
}

impl Crop {
    /// Around one or two masks with a margin; `None` if the first is empty.
    fn around(visible: &Mask, shape: Option<&Mask>) -> Option<Self> {
        let mut own = visible.bbox_px()?;
        if let Some(other) = shape.and_then(Mask::bbox_px) {
            own = [own[0].min(other[0]), own[1].min(other[1]), own[2].max(other[2]), own[3].max(other[3])];
        }
        let [x0, y0] = [own[0].saturating_sub(4), own[1].saturating_sub(4)];
        let size = [own[2] + 4, own[3] + 4].map(|side| side as usize);
        let limit = [visible.width_px(), visible.height_px()].map(|side| side as usize);
        let size = [size[0].min(limit[0]) - x0 as usize, size[1].min(limit[1]) - y0 as usize];
        Some(Self { corner: [x0, y0], size })
    }

    fn place(&self, k: usize) -> [u32; 2] {
        [self.corner[0] + (k % self.size[0]) as u32, self.corner[1] + (k / self.size[0]) as u32]
    }

    fn of(&self, mask: &Mask, k: usize) -> bool {
        let [x, y] = self.place(k);
        mask.contains(x, y)
    }

    /// The chosen pixels without parts thinner than `radius_px`, and without components whose edge adjoins the
    /// visible part by less than `share` or not at all.
    fn added(&self, chosen: impl Fn(usize) -> bool, visible: &Mask, radius_px: f64, share: f64) -> Mask {
        let [width, height] = self.size;
        let chosen: Vec<bool> = (0..width * height).map(chosen).collect();
        let own: Vec<bool> = (0..width * height).map(|k| self.of(visible, k)).collect();
        let radius_px = radius_px.max(MIN_RADIUS * width.max(height) as f64) as f32;
        // Thickness counts together with the adjacent visible part; otherwise corners could not be completed.
        let together: Vec<bool> = chosen.iter().zip(&own).map(|(a, b)| *a || *b).collect();
        let thick = morphology::open(&chosen, width, height, radius_px);
        let reach = morphology::dilate(&thick, width, height, 2.0 * radius_px);
        let smooth = morphology::open(&together, width, height, radius_px);
        let kept: Vec<bool> =
            (0..width * height).map(|k| chosen[k] && (thick[k] || (reach[k] && smooth[k]))).collect();
        let near = morphology::dilate(&own, width, height, NEAR_PX);
        let mut mask = Mask::empty(visible.width_px(), visible.height_px());
        for part in morphology::connected_components(&kept, width, height) {
            let is_edge = |k: usize| {
                let (x, y) = (k % width, k / width);
                x == 0
                    || y == 0
                    || x + 1 == width
                    || y + 1 == height
                    || [k - 1, k + 1, k - width, k + width].iter().any(|&next| !kept[next])
            };
            let edge: Vec<usize> = part.iter().copied().filter(|&k| is_edge(k)).collect();
            let bordering = edge.iter().filter(|&&k| near[k]).count();
            if bordering > 0 && bordering as f64 >= share * edge.len() as f64 {
                part.into_iter().map(|k| self.place(k)).for_each(|[x, y]| mask.set(x, y, true));
            }
        }
        mask
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rectangle(x: std::ops::Range<u32>, y: std::ops::Range<u32>) -> Mask {
        Mask::from_fn(160, 120, |u, v| x.contains(&u) && y.contains(&v))
    }

    #[test]
    fn convexity_completes_notch_behind_occluder_only() {
        let whole = rectangle(30..100, 30..90);
        let front = rectangle(55..80, 60..110);
        let visible = whole.without(&front);
        let added = occluded_by_convexity(&visible, &front);
        assert_eq!(added, whole.without(&visible));
        assert_eq!(occluded_by_convexity(&visible, &Mask::empty(160, 120)).area_px(), 0);
        // An occluder beside the object, inside its convex hull.
        let corner = rectangle(30..100, 30..50);
        let mut bent = corner.clone();
        bent.unite(&rectangle(30..50, 30..90));
        assert_eq!(occluded_by_convexity(&bent, &rectangle(70..90, 52..100)).area_px(), 0);
        assert_eq!(occluded_by_convexity(&Mask::empty(160, 120), &front).area_px(), 0);
    }

    #[test]
    fn shape_completes_occluded_part_and_ignores_slivers() {
        let whole = rectangle(30..100, 30..90);
        let front = rectangle(70..140, 50..110);
        let visible = whole.without(&front);
        assert_eq!(occluded_by_shape(&visible, &front, &whole).expect("fits"), whole.without(&visible));
        // A shape two pixels too high, in front of a farther object.
        let behind = rectangle(30..100, 0..30);
        let mut others = front.clone();
        others.unite(&behind);
        let high = rectangle(30..100, 28..90);
        assert_eq!(occluded_by_shape(&visible, &others, &high).expect("fits"), whole.without(&visible));
        assert_eq!(occluded_by_shape(&visible, &front, &rectangle(0..60, 0..120)), None, "another shape");
    }
}
