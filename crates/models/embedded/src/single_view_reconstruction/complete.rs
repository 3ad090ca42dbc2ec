//! Completion of partly occluded objects, from their mirror image and their own texture.
//!
//! Behind occluders the silhouette follows the recognized primitive if that fits the visible part, else its convex
//! hull. Most objects on tables are mirror-symmetric. So occluded pixels with a visible mirror image take its
//! color. The axis is that of the primitive, or of the visible part without one. Asymmetric pixels, and pixels
//! occluded on both sides, take the texture of the visible part. Only occluder pixels are completed; the rest
//! stays missing.

use super::neighboring_texture;
use super::primitive_mesh;
use imaging::distance_transform::distance_transform;
use imaging::{Image, Mask};
use ports::{CompletedBy, Completion, CompletionRequest, CompletionWay, Port, ProviderError};
use runtime::CancelFlag;
use vision::{attached_component, occluded_by_convexity, occluded_by_shape};

/// Minimum share of the outline next to other objects from which on an object is completed.
const HIDDEN_BORDER: f64 = 0.04;
/// Minimum symmetry of the visible part about its axis, intersection over union.
const MIN_SYMMETRY: f64 = 0.6;

/// Minimum symmetry of the recognized primitive about its axis.
const MIN_SHAPE_SYMMETRY: f64 = 0.9;
/// Minimum share of the visible part whose mirror image is visible too; less does not determine an axis.
const MIN_MIRRORED: f64 = 0.25;

/// Completes the image of one instance.
///
/// # Errors
///
/// [`ProviderError::Rejected`] with `nothing_visible` if no pixel of the instance is visible.
pub fn complete(request: &CompletionRequest, cancel: &CancelFlag) -> Result<Completion, ProviderError> {
    cancel.check()?;
    let (image, visible) = (&*request.reference.image, &request.visible);
    let (width, height) = (image.width_px(), image.height_px());
    let same_size = |mask: &Mask| (mask.width_px(), mask.height_px()) == (width, height);
    if visible.area_px() == 0 || !same_size(visible) || !same_size(&request.others) {
        return Err(ProviderError::Rejected {
            port: Port::ImageGenerator,
            code: "nothing_visible",
            reason: format!(
                "no pixel of {} shows in the image, so it cannot be completed; leave it out",
                request.object.id
            ),
        });
    }
    let own: Vec<(u32, u32)> = pixels(visible).collect();
    let is_hidden = hidden_border(&own, visible, &request.others) > HIDDEN_BORDER;
    let OcclusionEstimate { shape, hidden } =
        if is_hidden { estimate_occlusion(request) } else { OcclusionEstimate::none(visible) };
    let mirror = match &shape {
        // The visible part of a symmetric object may be symmetric about another axis.
        Some(shape) => {
            let nothing = Mask::empty(width, height);
            mirror(&pixels(shape).collect::<Vec<_>>(), shape, &nothing, MIN_SHAPE_SYMMETRY)
        }
        None if is_hidden => mirror(&own, visible, &request.others, MIN_SYMMETRY),
        None => None,
    };
    let mut known = visible.clone();
    if let Some(mirror) = mirror {
        let mut images = Mask::empty(width, height);
        let all = own.iter().filter_map(|&(x, y)| Some((mirror.image(x, width)?, y)));
        let behind = if shape.is_some() { &hidden } else { &request.others };
        all.filter(|&(u, y)| behind.contains(u, y)).for_each(|(u, y)| images.set(u, y, true));
        // Occluded parts of a primitive adjoin the visible part; mirror images may be isolated.
        known.unite(&if shape.is_some() { images } else { attached_component(visible, &images) });
    }
    cancel.check()?;
    let mut whole = known.clone();
    if is_hidden {
        for (x, y) in pixels(&hidden) {
            // Without a primitive, the mirror image of an occluded pixel decides whether it belongs to the object.
            let image = mirror.and_then(|mirror| mirror.image(x, width));
            if shape.is_some() || image.is_none_or(|u| request.others.contains(u, y)) {
                whole.set(x, y, true);
            }
        }
    }
    cancel.check()?;
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
        let [r, g, b, _] = image.pixel(from.unwrap_or(x), y);
        cut.set_pixel(x - x0, y - y0, [r, g, b, 255]);
    }
    if known != whole {
        let flags = |mask: &Mask| -> Vec<bool> {
            (y0..y1).flat_map(|y| (x0..x1).map(move |x| (x, y))).map(|(x, y)| mask.contains(x, y)).collect()
        };
        let new = flags(&whole.without(&known));
        for (index, [r, g, b]) in neighboring_texture::filled(&cut, &flags(&known), &new, cancel)? {
            let index = index as u32;
            cut.set_pixel(index % (x1 - x0), index / (x1 - x0), [r, g, b, 255]);
        }
    }
    Ok(Completion {
        image: cut,
        crop_px: [x0, y0, x1, y1].map(f64::from),
        completed_share: share(&whole, visible),
        silhouette: whole,
        completed_by: ways.into_iter().filter(|by| by.share > 0.0).collect(),
    })
}

/// Estimate of the occluded part.
struct OcclusionEstimate {
    /// Silhouette of the recognized primitive, if it fits the visible part.
    shape: Option<Mask>,
    /// Occluder pixels in front of the object.
    hidden: Mask,
}

impl OcclusionEstimate {
    fn none(visible: &Mask) -> Self {
        Self { shape: None, hidden: Mask::empty(visible.width_px(), visible.height_px()) }
    }
}

fn estimate_occlusion(request: &CompletionRequest) -> OcclusionEstimate {
    let (visible, others) = (&request.visible, &request.others);
    let solid = request.object.seen_as.as_ref().zip(request.camera.as_ref());
    let shape = solid
        .filter(|(_, camera)| {
            (camera.width_px, camera.height_px) == (visible.width_px(), visible.height_px())
        })
        .and_then(|(fit, camera)| primitive_mesh::silhouette(fit, camera));
    match shape.as_ref().and_then(|shape| occluded_by_shape(visible, others, shape)) {
        Some(hidden) => OcclusionEstimate { shape, hidden },
        None => OcclusionEstimate { shape: None, hidden: occluded_by_convexity(visible, others) },
    }
}

/// A vertical axis of symmetry: pixel columns x and twice - 1 - x are mirror images.
#[derive(Clone, Copy)]
struct Mirror {
    twice: u32,
}

impl Mirror {
    /// Column of the mirror image, if it lies in an image of this width.
    fn image(self, x: u32, width: u32) -> Option<u32> {
        (self.twice - 1).checked_sub(x).filter(|&u| u < width)
    }
}

/// The axis of maximum symmetry of the visible part, if the symmetry is at least `lowest`.
fn mirror(own: &[(u32, u32)], visible: &Mask, others: &Mask, lowest: f64) -> Option<Mirror> {
    let [x0, _, x1, _] = visible.bbox_px()?;
    let axes = (2 * x0 + (x1 - x0) / 2..=2 * x1 - (x1 - x0) / 2)
        .filter(|twice| *twice > 0)
        .map(|twice| (twice, symmetry(own, visible, others, Mirror { twice })));
    let (twice, symmetry) = axes.max_by(|a, b| a.1.total_cmp(&b.1).then(b.0.cmp(&a.0)))?;
    (symmetry >= lowest).then_some(Mirror { twice })
}

fn pixels(mask: &Mask) -> impl Iterator<Item = (u32, u32)> + '_ {
    let width = mask.width_px();
    let set = mask.bits().iter().enumerate().filter(|(_, inside)| **inside);
    set.map(move |(index, _)| (index as u32 % width, index as u32 / width))
}

/// Share of the outline's pixels with another object within three pixels.
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

/// Intersection over union of the visible part (pixels listed in `own`) with its mirror image, outside occluders.
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
            // The pixel and its missing mirror image.
            either += 2;
        }
    }
    if f64::from(both) < MIN_MIRRORED * own.len() as f64 {
        return 0.0;
    }
    f64::from(both) / f64::from(either.max(1))
}

#[cfg(test)]
mod tests;
