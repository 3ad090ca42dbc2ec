//! The part of a silhouette that other things hide.
//!
//! Two guesses at it: what a shape that was fitted to the visible part covers besides ([`hidden_within`]), and where nothing
//! was, the visible part's convex outline, which goes on straight across the bites that others take ([`bitten_off`]).
//! Nothing is ever added but where others are, nothing thin, and nothing that does not border on the visible part.

use super::polygon::{contains, hull_of_pixels};
use super::regions;
use imaging::Mask;

/// How far the visible part may be from what hides it, pixels.
const NEAR_PX: f32 = 3.0;
/// Least radius of a disc that fits into what is added, pixels and shares of the thing's extent.
const LEAST_RADIUS_PX: f64 = 1.5;
const LEAST_RADIUS: f64 = 0.015;
/// Least share of a bite's edge that borders on the visible part: what only touches a thing takes nothing from it.
const BITTEN: f64 = 0.4;
/// Least overlap of a shape with the visible part, where nothing hides either, that is believed behind others as well.
const FITS: f64 = 0.75;

/// Pixels of `others` that hide parts of a thing which looks like `shape`; `None` where the visible part does not. All masks
/// are as large as one picture.
pub fn hidden_within(visible: &Mask, others: &Mask, shape: &Mask) -> Option<Mask> {
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
    if (both as f64) < FITS * either as f64 {
        return None;
    }
    // What does not fit by so much anywhere does not fit by so much before things that stand behind, either.
    let misfit_px = (either - both) as f64 / (2 * border).max(1) as f64;
    let crop = Crop::around(visible, Some(shape))?;
    let inside = |k: usize| crop.of(others, k) && crop.of(shape, k) && !crop.of(visible, k);
    Some(crop.added(inside, visible, LEAST_RADIUS_PX + 1.5 * misfit_px, 0.0))
}

/// Pixels of `others` that take bites out of the visible part's convex outline.
pub fn bitten_off(visible: &Mask, others: &Mask) -> Mask {
    let Some(crop) = Crop::around(visible, None) else {
        return Mask::empty(visible.width_px(), visible.height_px());
    };
    let width = visible.width_px() as usize;
    let set = visible.bits().iter().enumerate().filter(|(_, inside)| **inside);
    let hull = hull_of_pixels(set.map(|(index, _)| index), width);
    let middle = |k: usize| {
        let [x, y] = crop.place(k);
        glam::DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5)
    };
    let inside = |k: usize| crop.of(others, k) && !crop.of(visible, k) && contains(&hull, middle(k));
    crop.added(inside, visible, LEAST_RADIUS_PX, BITTEN)
}

/// What of `added` pixels borders on the visible part and is not thin.
pub fn attached(visible: &Mask, added: &Mask) -> Mask {
    let Some(crop) = Crop::around(visible, Some(added)) else {
        return Mask::empty(visible.width_px(), visible.height_px());
    };
    crop.added(|k| crop.of(added, k) && !crop.of(visible, k), visible, LEAST_RADIUS_PX, 0.0)
}

/// As [`bitten_off`], of pixel indices in a picture `width` wide, together with them.
pub(crate) fn with_what_is_bitten_off(indices: &[usize], others: &[bool], width: usize) -> Vec<usize> {
    let height = others.len() / width.max(1);
    let mut bits = vec![false; others.len()];
    indices.iter().for_each(|&index| bits[index] = true);
    let mut all = Mask::from_bits(width as u32, height as u32, bits);
    let added = bitten_off(&all, &Mask::from_bits(width as u32, height as u32, others.to_vec()));
    all.unite(&added);
    all.bits().iter().enumerate().filter(|(_, inside)| **inside).map(|(index, _)| index).collect()
}

/// A part of the picture, by its corner and size.
struct Crop {
    corner: [u32; 2],
    size: [usize; 2],
}

impl Crop {
    /// Around one or two masks with a margin; `None` where the first is empty.
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

    /// The pixels chosen, without what is thinner than `radius_px` and the parts whose edges border less than `share` on
    /// the visible part, or not at all.
    fn added(&self, chosen: impl Fn(usize) -> bool, visible: &Mask, radius_px: f64, share: f64) -> Mask {
        let [width, height] = self.size;
        let chosen: Vec<bool> = (0..width * height).map(chosen).collect();
        let own: Vec<bool> = (0..width * height).map(|k| self.of(visible, k)).collect();
        let radius_px = radius_px.max(LEAST_RADIUS * width.max(height) as f64) as f32;
        // Thin is what is thin together with the visible part beside it, or it could not go on into a corner.
        let together: Vec<bool> = chosen.iter().zip(&own).map(|(a, b)| *a || *b).collect();
        let thick = regions::opened(&chosen, width, height, radius_px);
        let reach = regions::grown(&thick, width, height, 2.0 * radius_px);
        let smooth = regions::opened(&together, width, height, radius_px);
        let kept: Vec<bool> =
            (0..width * height).map(|k| chosen[k] && (thick[k] || (reach[k] && smooth[k]))).collect();
        let near = regions::grown(&own, width, height, NEAR_PX);
        let mut mask = Mask::empty(visible.width_px(), visible.height_px());
        for part in regions::parts(&kept, width, height) {
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
    fn a_bite_is_closed_where_something_takes_it_and_nowhere_else() {
        let whole = rectangle(30..100, 30..90);
        let front = rectangle(55..80, 60..110);
        let visible = whole.without(&front);
        let added = bitten_off(&visible, &front);
        assert_eq!(added, whole.without(&visible));
        assert_eq!(bitten_off(&visible, &Mask::empty(160, 120)).area_px(), 0);
        // It stands beside the thing, in its way from corner to corner.
        let corner = rectangle(30..100, 30..50);
        let mut bent = corner.clone();
        bent.unite(&rectangle(30..50, 30..90));
        assert_eq!(bitten_off(&bent, &rectangle(70..90, 52..100)).area_px(), 0);
        assert_eq!(bitten_off(&Mask::empty(160, 120), &front).area_px(), 0);
    }

    #[test]
    fn a_shape_goes_on_behind_what_is_in_front_and_slivers_before_what_is_behind_do_not_count() {
        let whole = rectangle(30..100, 30..90);
        let front = rectangle(70..140, 50..110);
        let visible = whole.without(&front);
        assert_eq!(hidden_within(&visible, &front, &whole).expect("fits"), whole.without(&visible));
        // A shape two pixels too high, before something behind.
        let behind = rectangle(30..100, 0..30);
        let mut others = front.clone();
        others.unite(&behind);
        let high = rectangle(30..100, 28..90);
        assert_eq!(hidden_within(&visible, &others, &high).expect("fits"), whole.without(&visible));
        assert_eq!(hidden_within(&visible, &front, &rectangle(0..60, 0..120)), None, "another shape");
    }
}
