//! Rectified top view: the image under the homography of the table plane, with the footprints of the recognized
//! objects.
//!
//! Rectification smears objects away from the camera. So positions come from the fitted primitives or categories,
//! not from the rectified pixels.

use glam::DVec2;
use rayon::prelude::*;

use super::{SingleViewSettings, category_mesh};
use crate::recognized_table;
use geometry::{Camera, Outline};
use imaging::{Image, Mask};
use ports::{Port, ProviderError, TopViewAnnotations, TopViewImage, TopViewRequest};
use render::TopView;
use runtime::{CancelFlag, Cancelled};
use scene::InstanceMask;
use vision::{ShapePrior, fit_solid};

/// Margin around the table, as a share of its larger extent.
const MARGIN: f64 = 0.06;

/// Rectifies the request's image.
///
/// # Errors
///
/// [`ProviderError::Rejected`] for an unknown table model, or for an object without a footprint.
pub fn top_view(
    request: &TopViewRequest,
    settings: &SingleViewSettings,
    cancel: &CancelFlag,
) -> Result<TopViewImage, ProviderError> {
    let recognition = &*request.recognition;
    let camera = &recognition.camera;
    let table = &recognition.table;
    let outline = recognized_table::built(table).map(|built| built.outline_m.clone()).ok_or_else(|| {
        ProviderError::Rejected {
            port: Port::ImageGenerator,
            code: "no_table_model",
            reason: format!("there is no table model {}; recognize the image again", table.model),
        }
    })?;
    let footprints = footprints(request, &outline, cancel)?;
    let view = view_of(&outline, MARGIN, settings.sizes.top_view_px);
    let rendered = rectified(&request.reference.image, camera, &view, cancel)?;
    let known = TopViewAnnotations {
        table: mask_of(&outline, &view),
        objects: recognition
            .objects
            .iter()
            .zip(&footprints)
            .map(|(object, footprint)| InstanceMask {
                id: object.id.clone(),
                visible: mask_of(footprint, &view),
            })
            .collect(),
    };
    Ok(TopViewImage { image: rendered, known: Some(known) })
}

/// Footprint of each object on the table (or on its support, seen from above), meters. A footprint whose center
/// lies beside `top` is moved to the edge of the top.
fn footprints(
    request: &TopViewRequest,
    top: &Outline,
    cancel: &CancelFlag,
) -> Result<Vec<Outline>, ProviderError> {
    let recognition = &*request.recognition;
    let supports = recognition.support_tree().map_err(|error| ProviderError::Rejected {
        port: Port::ImageGenerator,
        code: "recognition_inconsistent",
        reason: format!("{error}; recognize the image again"),
    })?;
    let eye_m = recognition.camera.world_from_camera.translation_m;
    recognition
        .objects
        .par_iter()
        .zip(request.masks.par_iter())
        .enumerate()
        .map(|(index, (object, mask))| {
            cancel.check()?;
            let height_m = recognition.support_height_m(&supports, index);
            let nearer = ((eye_m.z - height_m) / eye_m.z).clamp(0.2, 1.0);
            let solid = object.seen_as.clone().or_else(|| {
                let expected = ShapePrior {
                    base: None,
                    height: object.size_m.z / nearer,
                    log_height_sigma: ShapePrior::LOG_HEIGHT_SIGMA,
                };
                let image = &request.reference.image;
                fit_solid(&mask.visible, &recognition.camera, Some(image), Some(&expected))
            });
            let of_solid = || solid.map(|solid| (solid.center, solid.footprint()));
            let of_category = category_mesh::footprint(object)
                .zip(object.seen_like.as_ref())
                .map(|(own, like)| (like.center, own));
            let corners = of_category.or_else(of_solid).map(|(center, corners)| {
                // An object on another one was fitted on the table plane; it moves toward the eye.
                let eye = eye_m.truncate();
                let lifted = |p: DVec2| eye + nearer * (p - eye);
                let way = top.nearest_inside(lifted(center)) - lifted(center);
                corners.into_iter().map(|p| lifted(p) + way).collect::<Vec<_>>()
            });
            corners.and_then(|corners| Outline::new(corners).ok()).ok_or_else(|| ProviderError::Rejected {
                port: Port::ImageGenerator,
                code: "nothing_visible",
                reason: format!(
                    "no place on the table can be found for {}: its pixels are too few or above the horizon; \
                     leave it out",
                    object.id
                ),
            })
        })
        .collect()
}

/// A view of a top from above, with a margin around it (a share of its longer side), its longer side that many pixels.
pub(super) fn view_of(outline: &Outline, margin: f64, longer_px: u32) -> TopView {
    let (low, high) = outline.bounds();
    let margin = margin * (high - low).max_element();
    let extent = high - low + DVec2::splat(2.0 * margin);
    let meters_per_px = extent.max_element() / f64::from(longer_px.max(16));
    TopView {
        width_px: (extent.x / meters_per_px).ceil() as u32,
        height_px: (extent.y / meters_per_px).ceil() as u32,
        meters_per_px,
        center_m: 0.5 * (low + high),
        eye_z_m: 1.0,
    }
}

/// Pixels whose centers lie within an outline on the table. Cost: linear in the pixels and in rows times corners.
pub(super) fn mask_of(outline: &Outline, view: &TopView) -> Mask {
    let corners: Vec<DVec2> = outline.corners().iter().map(|p| view.pixel_from_world(*p)).collect();
    let mut mask = Mask::empty(view.width_px, view.height_px);
    for row in 0..view.height_px {
        let y = f64::from(row) + 0.5;
        let crossing = |(k, b): (usize, &DVec2)| {
            let a = corners[(k + corners.len() - 1) % corners.len()];
            ((a.y > y) != (b.y > y)).then(|| a.x + (b.x - a.x) * (y - a.y) / (b.y - a.y))
        };
        let mut crossings: Vec<f64> = corners.iter().enumerate().filter_map(crossing).collect();
        crossings.sort_by(f64::total_cmp);
        for span in crossings.chunks_exact(2) {
            let column = |x: f64| (x - 0.5).ceil().clamp(0.0, f64::from(view.width_px)) as u32;
            (column(span[0])..column(span[1])).for_each(|x| mask.set(x, row, true));
        }
    }
    mask
}

/// The image on the table plane, bilinear; white beyond its border.
pub(super) fn rectified(
    image: &Image,
    camera: &Camera,
    view: &TopView,
    cancel: &CancelFlag,
) -> Result<Image, Cancelled> {
    let mut top = Image::filled(view.width_px, view.height_px, [255; 4]);
    for y in 0..view.height_px {
        cancel.check()?;
        for x in 0..view.width_px {
            let world = view.world_from_pixel(DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5));
            if let Some(color) = camera.project(world.extend(0.0)).and_then(|(p, _)| sample(image, p)) {
                top.set_pixel(x, y, color);
            }
        }
    }
    Ok(top)
}

fn sample(image: &Image, p: DVec2) -> Option<[u8; 4]> {
    let size = DVec2::new(f64::from(image.width_px()), f64::from(image.height_px()));
    if p.x < 0.0 || p.y < 0.0 || p.x >= size.x || p.y >= size.y {
        return None;
    }
    let q = (p - 0.5).clamp(DVec2::ZERO, size - 1.0);
    let (x, y) = (q.x as u32, q.y as u32);
    let (right, below) = ((x + 1).min(image.width_px() - 1), (y + 1).min(image.height_px() - 1));
    let (u, v) = (q.x.fract(), q.y.fract());
    let corners = [(x, y), (right, y), (x, below), (right, below)].map(|(x, y)| image.pixel(x, y));
    let weights = [(1.0 - u) * (1.0 - v), u * (1.0 - v), (1.0 - u) * v, u * v];
    let mut out = [255; 4];
    for (c, channel) in out.iter_mut().enumerate().take(3) {
        let sum: f64 = corners.iter().zip(weights).map(|(corner, w)| w * f64::from(corner[c])).sum();
        *channel = sum.round() as u8;
    }
    Some(out)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn mask_has_the_pixels_whose_centers_the_outline_contains() {
        // A star and a notched rectangle, not centered.
        let star = (0..22).map(|k| {
            let radius = if k % 2 == 0 { 0.61 } else { 0.27 };
            DVec2::new(0.11, -0.07)
                + radius * DVec2::from_angle(0.2 + f64::from(k) * std::f64::consts::TAU / 22.0)
        });
        let notched =
            [(-0.5, -0.3), (0.5, -0.3), (0.5, 0.3), (0.1, 0.3), (0.0, -0.21), (-0.13, 0.3), (-0.5, 0.3)];
        let notched = notched.map(|(x, y)| DVec2::new(x + 0.013, y));
        for corners in [star.collect(), notched.to_vec()] {
            let outline = Outline::new(corners).expect("an outline");
            let view = view_of(&outline, 0.05, 157);
            let slow = Mask::from_fn(view.width_px, view.height_px, |x, y| {
                outline.contains(view.world_from_pixel(DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5)))
            });
            let found = mask_of(&outline, &view);
            assert!(slow.area_px() > 5_000);
            assert_eq!(found.bits(), slow.bits());
        }
    }
}
