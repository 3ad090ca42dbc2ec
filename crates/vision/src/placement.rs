//! Where a redrawn thing lies in the picture it was redrawn from.
//!
//! Computes the scale and shift that lay the outline of a redrawn thing on the pixels where the thing shows. Method:
//! agreement is intersection over union, counted only where nothing else may hide the thing; it is sampled on a grid
//! around the visible pixels and climbed by a pattern search from several starts (as it was framed, and box on box, with
//! each side or the middle in common, since any side may be hidden). Inputs: masks; `visible` and `others` as large as the
//! picture, `redrawn` as it came. Guarantees: same masks, same placement. Cost: about 100 000 samples a start.
//! Turned or mirrored things are not found: they agree badly, which the caller judges.

use glam::DVec2;

use imaging::Mask;

/// Samples along the longer side of the region that is looked at.
const SAMPLES: f64 = 96.0;

/// Starts that are climbed from, the best ones.
const CLIMBED: usize = 3;

/// A redrawn picture's place: `picture = offset_px + scale * redrawn`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Placement {
    /// Pixels of the picture for one of the redrawn picture's.
    pub scale: f64,
    /// Where the redrawn picture's upper left corner lies, pixels of the picture.
    pub offset_px: DVec2,
}

impl Placement {
    /// A point of the picture on the redrawn one.
    pub fn redrawn_from_picture(&self, point_px: DVec2) -> DVec2 {
        (point_px - self.offset_px) / self.scale
    }
}

/// The best placement and its agreement, 0..1; `None` where one of the masks shows nothing. `framed` is where the
/// redrawn picture would lie if it kept the frame it was given.
pub fn placed(redrawn: &Mask, visible: &Mask, others: &Mask, framed: Placement) -> Option<(Placement, f64)> {
    let from = redrawn.bbox_px()?.map(f64::from);
    let to = visible.bbox_px()?.map(f64::from);
    let samples = Samples::around(to, visible, others);
    let mut starts: Vec<(Placement, f64)> = std::iter::once(framed)
        .chain(boxes_in_common(from, to))
        .map(|placement| (placement, samples.agreement(redrawn, placement)))
        .collect();
    starts.sort_by(|a, b| b.1.total_cmp(&a.1));
    let size_px = (to[2] - to[0]).max(to[3] - to[1]);
    let climbed =
        starts.into_iter().take(CLIMBED).map(|start| climb(start, redrawn, &samples, from, size_px));
    climbed.reduce(|best, next| if next.1 > best.1 { next } else { best })
}

/// One box on the other, as wide or as high, each side or the middle in common.
fn boxes_in_common(from: [f64; 4], to: [f64; 4]) -> impl Iterator<Item = Placement> {
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

/// Pattern search: shift and scale (about the middle of what was drawn) by steps that are halved where none helps.
fn climb(
    start: (Placement, f64),
    redrawn: &Mask,
    samples: &Samples,
    from: [f64; 4],
    size_px: f64,
) -> (Placement, f64) {
    let (mut best, mut agreement) = start;
    let middle = 0.5 * DVec2::new(from[0] + from[2], from[1] + from[3]);
    let mut step = 0.08;
    while step > 0.002 {
        let shifts = [DVec2::X, DVec2::NEG_X, DVec2::Y, DVec2::NEG_Y]
            .map(|way| Placement { offset_px: best.offset_px + step * size_px * way, ..best });
        let sizes = [1.0 + step, 1.0 / (1.0 + step)].map(|factor| {
            let scale = best.scale * factor;
            Placement { scale, offset_px: best.offset_px + (best.scale - scale) * middle }
        });
        let tried = shifts.into_iter().chain(sizes).map(|next| (next, samples.agreement(redrawn, next)));
        let next = tried.reduce(|best, next| if next.1 > best.1 { next } else { best });
        match next {
            Some(next) if next.1 > agreement => (best, agreement) = next,
            _ => step *= 0.5,
        }
    }
    (best, agreement)
}

/// Points of the picture where the thing shows, or could show and does not.
struct Samples(Vec<(DVec2, bool)>);

impl Samples {
    /// Around a box of visible pixels, as far out as it is large.
    fn around(bbox: [f64; 4], visible: &Mask, others: &Mask) -> Self {
        let (low, high) = (DVec2::new(bbox[0], bbox[1]), DVec2::new(bbox[2], bbox[3]));
        let reach = (high - low).max_element();
        let picture = DVec2::new(f64::from(visible.width_px()), f64::from(visible.height_px()));
        let (low, high) = ((low - reach).max(DVec2::ZERO), (high + reach).min(picture));
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

    fn agreement(&self, redrawn: &Mask, placement: Placement) -> f64 {
        let (mut both, mut either) = (0_u32, 0_u32);
        for &(point, shows) in &self.0 {
            let at = placement.redrawn_from_picture(point);
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
    fn a_thing_that_was_moved_and_resized_is_found_again() {
        let visible = mug(320, 240, DVec2::new(120.0, 80.0), 8.0);
        let redrawn = mug(512, 512, DVec2::new(60.0, 90.0), 36.0);
        let (found, agreement) =
            placed(&redrawn, &visible, &Mask::empty(320, 240), FRAMED).expect("both show");
        let corner = found.offset_px + found.scale * DVec2::new(60.0, 90.0);
        assert!(agreement > 0.93, "{agreement}");
        assert!((found.scale * 36.0 - 8.0).abs() < 0.15, "{found:?}");
        assert!((corner - DVec2::new(120.0, 80.0)).length() < 1.5, "{found:?}");
    }

    #[test]
    fn what_is_hidden_is_no_disagreement() {
        let whole = mug(320, 240, DVec2::new(120.0, 80.0), 8.0);
        // A box before its left and lower part.
        let others = Mask::from_fn(320, 240, |x, y| (90..150).contains(&x) && (110..200).contains(&y));
        let visible = Mask::from_fn(320, 240, |x, y| whole.contains(x, y) && !others.contains(x, y));
        let redrawn = mug(512, 512, DVec2::new(60.0, 90.0), 36.0);
        let (found, agreement) = placed(&redrawn, &visible, &others, FRAMED).expect("both show");
        assert!(agreement > 0.9, "{agreement}");
        assert!((found.scale * 36.0 - 8.0).abs() < 0.4, "{found:?}");
    }

    #[test]
    fn another_thing_agrees_badly() {
        let visible = mug(320, 240, DVec2::new(120.0, 80.0), 8.0);
        let fork = Mask::from_fn(512, 512, |x, y| (240..270).contains(&x) && (40..480).contains(&y));
        let (_, agreement) = placed(&fork, &visible, &Mask::empty(320, 240), FRAMED).expect("both show");
        assert!(agreement < 0.5, "{agreement}");
        assert_eq!(placed(&Mask::empty(9, 9), &visible, &Mask::empty(320, 240), FRAMED), None);
        assert_eq!(placed(&fork, &Mask::empty(320, 240), &Mask::empty(320, 240), FRAMED), None);
    }
}
