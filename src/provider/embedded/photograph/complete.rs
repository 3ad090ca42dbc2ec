//! A thing cut out of its picture; what others hide of it is taken from its mirror image.
//!
//! Most things people put on tables look alike left and right. Where another thing's pixels hide a part, the
//! axis is sought about which the visible part is most symmetric, and hidden pixels whose mirror image is
//! visible are filled with it. What is hidden on both sides stays missing.

use crate::geometry::distance_transform::distance_transform;
use crate::geometry::{Image, Interrupt, Mask};
use crate::provider::{Completion, CompletionRequest, Port, ProviderError};

/// Share of the outline that must border on other things before anything is completed.
const HIDDEN_BORDER: f64 = 0.04;
/// Least symmetry of the visible part about the axis found, intersection over union.
const LEAST_SYMMETRY: f64 = 0.6;

/// The completed picture of one instance.
pub fn complete(request: &CompletionRequest, interrupt: &Interrupt) -> Result<Completion, ProviderError> {
    interrupt.check()?;
    let (picture, visible) = (&*request.reference.picture, &request.visible);
    let (width, height) = (picture.width_px(), picture.height_px());
    let same_size = |mask: &Mask| (mask.width_px(), mask.height_px()) == (width, height);
    let bbox = visible.bbox_px().filter(|_| same_size(visible) && same_size(&request.others));
    let Some([x0, _, x1, _]) = bbox else {
        return Err(ProviderError::Rejected {
            port: Port::Painter,
            code: "nothing_visible",
            reason: format!(
                "no pixel of {} shows in the picture, so it cannot be completed; leave it out",
                request.object.id
            ),
        });
    };
    let mut whole = visible.clone();
    // Twice the axis: pixel columns x and axis - 1 - x are mirror images.
    let mut mirror: Option<u32> = None;
    let own: Vec<(u32, u32)> = pixels(visible).collect();
    if hidden_border(&own, visible, &request.others) > HIDDEN_BORDER {
        let axes = (2 * x0 + (x1 - x0) / 2..=2 * x1 - (x1 - x0) / 2)
            .map(|axis| (axis, symmetry(&own, visible, &request.others, axis)));
        let best = axes.max_by(|a, b| a.1.total_cmp(&b.1).then(b.0.cmp(&a.0)));
        if let Some((axis, symmetry)) = best
            && symmetry >= LEAST_SYMMETRY
        {
            mirror = Some(axis);
            for &(x, y) in &own {
                if let Some(u) = (axis - 1).checked_sub(x).filter(|&u| u < width)
                    && request.others.contains(u, y)
                {
                    whole.set(u, y, true);
                }
            }
        }
    }
    interrupt.check()?;
    let area = whole.area_px();
    let completed_share = (area - visible.area_px()) as f64 / area.max(1) as f64;
    let [x0, y0, x1, y1] = whole.bbox_px().unwrap_or([0, 0, width, height]);
    let margin = (0.05 * f64::from((x1 - x0).max(y1 - y0))).ceil() as u32;
    let (x0, y0) = (x0.saturating_sub(margin), y0.saturating_sub(margin));
    let (x1, y1) = ((x1 + margin).min(width), (y1 + margin).min(height));
    let mut cut = Image::filled(x1 - x0, y1 - y0, [0; 4]);
    for y in y0..y1 {
        for x in x0..x1 {
            if !whole.contains(x, y) {
                continue;
            }
            let from = match mirror {
                Some(axis) if !visible.contains(x, y) => axis - 1 - x,
                _ => x,
            };
            let [r, g, b, _] = picture.pixel(from, y);
            cut.set_pixel(x - x0, y - y0, [r, g, b, 255]);
        }
    }
    let shown_px = [x0, y0, x1, y1].map(f64::from);
    Ok(Completion { picture: cut, shown_px, silhouette: whole, completed_share })
}

fn pixels(mask: &Mask) -> impl Iterator<Item = (u32, u32)> + '_ {
    let width = mask.width_px();
    let set = mask.bits().iter().enumerate().filter(|(_, inside)| **inside);
    set.map(move |(index, _)| (index as u32 % width, index as u32 / width))
}

/// Share of the outline's pixels with another thing within three pixels.
fn hidden_border(own: &[(u32, u32)], visible: &Mask, others: &Mask) -> f64 {
    let near = distance_transform(others.bits(), others.width_px() as usize, others.height_px() as usize);
    let (mut border, mut hidden) = (0_u32, 0_u32);
    for &(x, y) in own {
        let inner = x > 0
            && y > 0
            && visible.contains(x - 1, y)
            && visible.contains(x + 1, y)
            && visible.contains(x, y - 1)
            && visible.contains(x, y + 1);
        if !inner {
            border += 1;
            hidden += u32::from(near[(y * visible.width_px() + x) as usize] <= 3.0);
        }
    }
    f64::from(hidden) / f64::from(border.max(1))
}

/// How alike the visible part, whose pixels are listed, is to its mirror image, where nothing hides either.
fn symmetry(own: &[(u32, u32)], visible: &Mask, others: &Mask, axis: u32) -> f64 {
    let (mut both, mut either) = (0_u32, 0_u32);
    for &(x, y) in own {
        let Some(u) = (axis - 1).checked_sub(x).filter(|&u| u < visible.width_px()) else {
            either += 2;
            continue;
        };
        if visible.contains(u, y) {
            both += 1;
            either += 1;
        } else if !others.contains(u, y) {
            // The lone pixel and its missing image.
            either += 2;
        }
    }
    f64::from(both) / f64::from(either.max(1))
}
