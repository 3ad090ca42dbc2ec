//! Registration of a regenerated object's mask with the object's visible pixels.
//!
//! Computes scale and shift. The score is the intersection over union, counted only where no other object may
//! occlude. It is sampled on a grid around the visible pixels and maximized by pattern search from several starts:
//! the given frame, and box alignments with a common side or center, since any side may be occluded.
//!
//! Inputs: masks; `visible` and `others` at the size of the image, `redrawn` at its own. Deterministic. Cost:
//! about 100 000 samples a start. Rotated or mirrored objects score low; the caller decides on the score.

use glam::DVec2;

use imaging::Mask;

/// Samples along the longer side of the sampled region.
const SAMPLES: f64 = 96.0;

/// Number of starts that are refined, the best ones.
const REFINED_STARTS: usize = 3;

/// Position of the regenerated image: `image = offset_px + scale * redrawn`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Placement {
    /// Pixels of the image per pixel of the regenerated one.
    pub scale: f64,
    /// Upper left corner of the regenerated image, pixels of the image.
    pub offset_px: DVec2,
}

impl Placement {
    /// Maps a point of the image to the regenerated one.
    pub fn redrawn_from_image(&self, point_px: DVec2) -> DVec2 {
        (point_px - self.offset_px) / self.scale
    }
}

/// The best placement and its overlap, 0..1; `None` if a mask is empty. `framed` is the placement of the unchanged
/// frame.
pub fn register(
    redrawn: &Mask,
    visible: &Mask,
    others: &Mask,
    framed: Placement,
) -> Option<(Placement, f64)> {
    let from = redrawn.bbox_px()?.map(f64::from);
    let to = visible.bbox_px()?.map(f64::from);
    let samples = Samples::around(to, visible, others);
    let mut starts: Vec<(Placement, f64)> = std::iter::once(framed)
        .chain(box_alignments(from, to))
        .map(|placement| (placement, samples.overlap(redrawn, placement)))
        .collect();
    starts.sort_by(|a, b| b.1.total_cmp(&a.1));
    let size_px = (to[2] - to[0]).max(to[3] - to[1]);
    let refined = starts
        .into_iter()
        .take(REFINED_STARTS)
        .map(|start| pattern_search(start, redrawn, &samples, from, size_px));
    refined.reduce(|best, next| if next.1 > best.1 { next } else { best })
}

/// Alignments of the two boxes with equal width or height and a common side or center.
fn box_alignments(from: [f64; 4], to: [f64; 4]) -> impl Iterator<Item = Placement> {
    let scales = [(to[2] - to[0]) / (from[2] - from[0]), (to[3] - to[1]) / (from[3] - from[1])];
    let shares = [0.0, 0.5, 1.0];
    scales.into_iter().flat_map(move |scale| {
        shares.into_iter().flat_map(move |u| {
            shares.into_iter().map(move |v| {
                let at = |[x0, y0, x1, y1]: [f64; 4]| DVec2::new(x0 + u * (x1 - x0), y0 + v * (y1 - y0));
                Placement { scale, offset_px: at(to) - scale * at(from) }
            })
        })
    })
}

/// Pattern search over shift and scale about the object's center; steps are halved without a gain.
fn pattern_search(
    start: (Placement, f64),
    redrawn: &Mask,
    samples: &Samples,
    from: [f64; 4],
    size_px: f64,
) -> (Placement, f64) {
    let (mut best, mut overlap) = start;
    let center = 0.5 * DVec2::new(from[0] + from[2], from[1] + from[3]);
    let mut step = 0.08;
    while step > 0.002 {
        let shifts = [DVec2::X, DVec2::NEG_X, DVec2::Y, DVec2::NEG_Y]
            .map(|way| Placement { offset_px: best.offset_px + step * size_px * way, ..best });
        let sizes = [1.0 + step, 1.0 / (1.0 + step)].map(|factor| {
            let scale = best.scale * factor;
            Placement { scale, offset_px: best.offset_px + (best.scale - scale) * center }
        });
        let tried = shifts.into_iter().chain(sizes).map(|next| (next, samples.overlap(redrawn, next)));
        let next = tried.reduce(|best, next| if next.1 > best.1 { next } else { best });
        match next {
            Some(next) if next.1 > overlap => (best, overlap) = next,
            _ => step *= 0.5,
        }
    }
    (best, overlap)
}

/// Sample points where the object is visible, or would be visible if it were there.
struct Samples(Vec<(DVec2, bool)>);

impl Samples {
    /// Samples around the box of visible pixels, one box size in each direction.
    fn around(bbox: [f64; 4], visible: &Mask, others: &Mask) -> Self {
        let (low, high) = (DVec2::new(bbox[0], bbox[1]), DVec2::new(bbox[2], bbox[3]));
        let reach = (high - low).max_element();
        let image = DVec2::new(f64::from(visible.width_px()), f64::from(visible.height_px()));
        let (low, high) = ((low - reach).max(DVec2::ZERO), (high + reach).min(image));
        let step = ((high - low).max_element() / SAMPLES).max(1.0);
        let counts = ((high - low) / step).floor();
        let mut samples = Vec::new();
        for row in 0..counts.y as u32 {
            for column in 0..counts.x as u32 {
                let point = low + step * (DVec2::new(f64::from(column), f64::from(row)) + 0.5);
                let (x, y) = (point.x as u32, point.y as u32);
                let shows = visible.contains(x, y);
                if shows || !others.contains(x, y) {
                    samples.push((point, shows));
                }
            }
        }
        Self(samples)
    }

    fn overlap(&self, redrawn: &Mask, placement: Placement) -> f64 {
        let (mut both, mut either) = (0_u32, 0_u32);
        for &(point, shows) in &self.0 {
            let at = placement.redrawn_from_image(point);
            let drawn = at.min_element() >= 0.0 && redrawn.contains(at.x as u32, at.y as u32);
            both += u32::from(shows && drawn);
            either += u32::from(shows || drawn);
        }
        f64::from(both) / f64::from(either.max(1))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A mug: a body with a handle at its right, in a box of 10 x 8 units with its corner at `low`.
    fn mug(width_px: u32, height_px: u32, low: DVec2, unit: f64) -> Mask {
        Mask::from_fn(width_px, height_px, |x, y| {
            let p = (DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5) - low) / unit;
            let body = (0.0..7.0).contains(&p.x) && (0.0..8.0).contains(&p.y);
            let handle = (p - DVec2::new(7.0, 4.0)).length();
            body || (p.x >= 7.0 && (2.0..3.0).contains(&handle))
        })
    }

    const FRAMED: Placement = Placement { scale: 0.3, offset_px: DVec2::new(40.0, 30.0) };

    #[test]
    fn register_recovers_shift_and_scale() {
        let visible = mug(320, 240, DVec2::new(120.0, 80.0), 8.0);
        let redrawn = mug(512, 512, DVec2::new(60.0, 90.0), 36.0);
        let (found, overlap) =
            register(&redrawn, &visible, &Mask::empty(320, 240), FRAMED).expect("both show");
        let corner = found.offset_px + found.scale * DVec2::new(60.0, 90.0);
        assert!(overlap > 0.93, "{overlap}");
        assert!((found.scale * 36.0 - 8.0).abs() < 0.15, "{found:?}");
        assert!((corner - DVec2::new(120.0, 80.0)).length() < 1.5, "{found:?}");
    }

    #[test]
    fn register_ignores_occluded_pixels() {
        let whole = mug(320, 240, DVec2::new(120.0, 80.0), 8.0);
        // A box in front of its left and lower part.
        let others = Mask::from_fn(320, 240, |x, y| (90..150).contains(&x) && (110..200).contains(&y));
        let visible = Mask::from_fn(320, 240, |x, y| whole.contains(x, y) && !others.contains(x, y));
        let redrawn = mug(512, 512, DVec2::new(60.0, 90.0), 36.0);
        let (found, overlap) = register(&redrawn, &visible, &others, FRAMED).expect("both show");
        assert!(overlap > 0.9, "{overlap}");
        assert!((found.scale * 36.0 - 8.0).abs() < 0.4, "{found:?}");
    }

    #[test]
    fn register_scores_other_object_low() {
        let visible = mug(320, 240, DVec2::new(120.0, 80.0), 8.0);
        let fork = Mask::from_fn(512, 512, |x, y| (240..270).contains(&x) && (40..480).contains(&y));
        let (_, overlap) = register(&fork, &visible, &Mask::empty(320, 240), FRAMED).expect("both show");
        assert!(overlap < 0.5, "{overlap}");
        assert_eq!(register(&Mask::empty(9, 9), &visible, &Mask::empty(320, 240), FRAMED), None);
        assert_eq!(register(&fork, &Mask::empty(320, 240), &Mask::empty(320, 240), FRAMED), None);
    }
}
