//! A thing cut out of its picture; what others hide of it is taken from its mirror image and from its own texture.
//!
//! Where another thing's pixels hide a part, the silhouette goes on as the solid that the thing was recognized as, if that
//! looks like what is visible, and else across the bite. Most things people put on tables look alike left and right: hidden
//! pixels whose mirror image is visible are filled with it, about the axis of the solid, or of the visible part where no
//! solid is believed. What is not symmetric, or hidden on both sides, wears the texture of the visible part. Nothing is added
//! but where other things are; what no way reaches stays missing.

use super::body;
use super::neighboring_texture;
use imaging::distance_transform::distance_transform;
use imaging::{Image, Mask};
use ports::{CompletedBy, Completion, CompletionRequest, CompletionWay, Port, ProviderError};
use runtime::Interrupt;
use vision::{attached, bitten_off, hidden_within};

/// Share of the outline that must border on other things before anything is completed.
const HIDDEN_BORDER: f64 = 0.04;
/// Least symmetry of the visible part about the axis found, intersection over union.
const LEAST_SYMMETRY: f64 = 0.6;

/// Likewise of the solid that a thing was recognized as, about the axis that counts then.
const LEAST_SHAPE_SYMMETRY: f64 = 0.9;
/// Least share of the visible part whose mirror image is visible too: less says nothing of an axis.
const LEAST_MIRRORED: f64 = 0.25;

/// The completed picture of one instance.
pub fn complete(request: &CompletionRequest, interrupt: &Interrupt) -> Result<Completion, ProviderError> {
    interrupt.check()?;
    let (picture, visible) = (&*request.reference.picture, &request.visible);
    let (width, height) = (picture.width_px(), picture.height_px());
    let same_size = |mask: &Mask| (mask.width_px(), mask.height_px()) == (width, height);
    if visible.area_px() == 0 || !same_size(visible) || !same_size(&request.others) {
        return Err(ProviderError::Rejected {
            port: Port::Painter,
            code: "nothing_visible",
            reason: format!(
                "no pixel of {} shows in the picture, so it cannot be completed; leave it out",
                request.object.id
            ),
        });
    }
    let own: Vec<(u32, u32)> = pixels(visible).collect();
    let is_hidden = hidden_border(&own, visible, &request.others) > HIDDEN_BORDER;
    let Behind { shape, hidden } = if is_hidden { behind_others(request) } else { Behind::nothing(visible) };
    let mirror = match &shape {
        // The visible part of a symmetric thing may well be symmetric about another axis.
        Some(shape) => {
            let nothing = Mask::empty(width, height);
            mirror(&pixels(shape).collect::<Vec<_>>(), shape, &nothing, LEAST_SHAPE_SYMMETRY)
        }
        None if is_hidden => mirror(&own, visible, &request.others, LEAST_SYMMETRY),
        None => None,
    };
    let mut known = visible.clone();
    if let Some(mirror) = mirror {
        let mut images = Mask::empty(width, height);
        let all = own.iter().filter_map(|&(x, y)| Some((mirror.image(x, width)?, y)));
        let behind = if shape.is_some() { &hidden } else { &request.others };
        all.filter(|&(u, y)| behind.contains(u, y)).for_each(|(u, y)| images.set(u, y, true));
        // What is hidden of a solid hangs together with what is visible; of mirror images anything might be left.
        known.unite(&if shape.is_some() { images } else { attached(visible, &images) });
    }
    interrupt.check()?;
    let mut whole = known.clone();
    if is_hidden {
        for (x, y) in pixels(&hidden) {
            // Where no shape says so, the mirror image of what is hidden shows whether there is anything.
            let image = mirror.and_then(|mirror| mirror.image(x, width));
            if shape.is_some() || image.is_none_or(|u| request.others.contains(u, y)) {
                whole.set(x, y, true);
            }
        }
    }
    interrupt.check()?;
    let area = whole.area_px().max(1) as f64;
    let share = |more: &Mask, less: &Mask| (more.area_px() - less.area_px()) as f64 / area;
    let ways = [
        CompletedBy { way: CompletionWay::Symmetry, share: share(&known, visible) },
        CompletedBy { way: CompletionWay::NeighboringTexture, share: share(&whole, &known) },
    ];
    let [x0, y0, x1, y1] = whole.bbox_px().unwrap_or([0, 0, width, height]);
    let margin = (0.05 * f64::from((x1 - x0).max(y1 - y0))).ceil() as u32;
    let (x0, y0) = (x0.saturating_sub(margin), y0.saturating_sub(margin));
    let (x1, y1) = ((x1 + margin).min(width), (y1 + margin).min(height));
    let mut cut = Image::filled(x1 - x0, y1 - y0, [0; 4]);
    for (x, y) in pixels(&known) {
        let from = mirror.filter(|_| !visible.contains(x, y)).and_then(|mirror| mirror.image(x, width));
        let [r, g, b, _] = picture.pixel(from.unwrap_or(x), y);
        cut.set_pixel(x - x0, y - y0, [r, g, b, 255]);
    }
    if known != whole {
        let flags = |mask: &Mask| -> Vec<bool> {
            (y0..y1).flat_map(|y| (x0..x1).map(move |x| (x, y))).map(|(x, y)| mask.contains(x, y)).collect()
        };
        let new = flags(&whole.without(&known));
        for (index, [r, g, b]) in neighboring_texture::filled(&cut, &flags(&known), &new, interrupt)? {
            let index = index as u32;
            cut.set_pixel(index % (x1 - x0), index / (x1 - x0), [r, g, b, 255]);
        }
    }
    Ok(Completion {
        picture: cut,
        shown_px: [x0, y0, x1, y1].map(f64::from),
        completed_share: share(&whole, visible),
        silhouette: whole,
        completed_by: ways.into_iter().filter(|by| by.share > 0.0).collect(),
    })
}

/// What is thought to be behind others.
struct Behind {
    /// The whole of the thing as the solid that it was recognized as, if that looks like what is visible.
    shape: Option<Mask>,
    /// Pixels of others that hide the thing.
    hidden: Mask,
}

impl Behind {
    fn nothing(visible: &Mask) -> Self {
        Self { shape: None, hidden: Mask::empty(visible.width_px(), visible.height_px()) }
    }
}

fn behind_others(request: &CompletionRequest) -> Behind {
    let (visible, others) = (&request.visible, &request.others);
    let solid = request.object.seen_as.as_ref().zip(request.camera.as_ref());
    let shape = solid
        .filter(|(_, camera)| {
            (camera.width_px, camera.height_px) == (visible.width_px(), visible.height_px())
        })
        .and_then(|(fit, camera)| body::silhouette(fit, camera));
    match shape.as_ref().and_then(|shape| hidden_within(visible, others, shape)) {
        Some(hidden) => Behind { shape, hidden },
        None => Behind { shape: None, hidden: bitten_off(visible, others) },
    }
}

/// An upright axis of symmetry: pixel columns x and twice - 1 - x are mirror images.
#[derive(Clone, Copy)]
struct Mirror {
    twice: u32,
}

impl Mirror {
    /// Column of the mirror image, where it lies in a picture so wide.
    fn image(self, x: u32, width: u32) -> Option<u32> {
        (self.twice - 1).checked_sub(x).filter(|&u| u < width)
    }
}

/// The axis about which the visible part is most symmetric, if it is at least so much.
fn mirror(own: &[(u32, u32)], visible: &Mask, others: &Mask, least: f64) -> Option<Mirror> {
    let [x0, _, x1, _] = visible.bbox_px()?;
    let axes = (2 * x0 + (x1 - x0) / 2..=2 * x1 - (x1 - x0) / 2)
        .filter(|twice| *twice > 0)
        .map(|twice| (twice, symmetry(own, visible, others, Mirror { twice })));
    let (twice, symmetry) = axes.max_by(|a, b| a.1.total_cmp(&b.1).then(b.0.cmp(&a.0)))?;
    (symmetry >= least).then_some(Mirror { twice })
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
fn symmetry(own: &[(u32, u32)], visible: &Mask, others: &Mask, mirror: Mirror) -> f64 {
    let (mut both, mut either) = (0_u32, 0_u32);
    for &(x, y) in own {
        let Some(u) = mirror.image(x, visible.width_px()) else {
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
    if f64::from(both) < LEAST_MIRRORED * own.len() as f64 {
        return 0.0;
    }
    f64::from(both) / f64::from(either.max(1))
}

#[cfg(test)]
mod tests;
