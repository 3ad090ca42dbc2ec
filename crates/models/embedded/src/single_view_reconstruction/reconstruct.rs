//! Mesh from one view: the category's mesh, or a fitted primitive with the texture of the image.
//!
//! Primitives are solid, never hollow: a cup comes out filled. The hidden side mirrors the visible one; shading of
//! the image remains in the texture. A silhouette that fits no compact primitive becomes an extrusion with an
//! estimated depth.

use glam::DVec3;

use super::SingleViewSettings;
use super::category_mesh::{IMAGE_MATERIAL, dressed};
use super::primitive_mesh::primitive_mesh;
use super::texture::{Projection, subdivided};
use crate::orientation::randomly_oriented;
use geometry::{Camera, Pose, TexturedMesh};
use imaging::Image;
use ports::{Completion, Port, ProviderError, RawMesh, ReconstructionRequest};
use runtime::CancelFlag;
use scene::{RecognizedObject, ReconstructionMethod};
use vision::{PosedPrimitive, ShapePrior, fit_solid};

/// Reconstructs the request's instance.
///
/// # Errors
///
/// [`ProviderError::Rejected`] with `nothing_visible` if no primitive can be fitted.
pub fn reconstruct(
    request: &ReconstructionRequest,
    settings: &SingleViewSettings,
    cancel: &CancelFlag,
) -> Result<RawMesh, ProviderError> {
    cancel.check()?;
    if let Some(made) = of_category(request, settings) {
        return Ok(made);
    }
    let seen = stood_up(&request.object, &request.completion, &request.camera, settings);
    let (mesh, fit, method) = seen.ok_or_else(|| ProviderError::Rejected {
        port: Port::MeshGenerator,
        code: "nothing_visible",
        reason: format!(
            "no solid can be fitted to {}: its silhouette is empty or above the horizon; leave it out or use a \
             remote mesh generator",
            request.object.id
        ),
    })?;
    cancel.check()?;
    let mut notes = vec![
        format!("single view: {}, outline overlap {:.2}", words(method), fit.overlap),
        "solid inside; unseen side mirrored; the image's light is in the texture".to_owned(),
    ];
    let hidden = request.completion.completed_share;
    if hidden > 0.0 {
        let ways = request.completion.completed_by.iter();
        let ways: Vec<String> =
            ways.map(|by| format!("{:.0} % completed by {}", 100.0 * by.share, by.way.words())).collect();
        let ways = if ways.is_empty() { String::new() } else { format!(": {}", ways.join(", ")) };
        notes.push(format!("{:.0} % of its outline was hidden{ways}", 100.0 * hidden));
    }
    Ok(RawMesh {
        mesh: randomly_oriented(mesh, request.seed).snap_to_f32(),
        method,
        made_by: "embedded/photograph".to_owned(),
        licence: "LicenseRef-input-image".to_owned(),
        notes,
    })
}

/// The mesh of the object's category, if it was recognized as one.
fn of_category(request: &ReconstructionRequest, settings: &SingleViewSettings) -> Option<RawMesh> {
    let object = &request.object;
    let texture_px = settings.sizes.texture_px;
    let mesh = in_size(dressed(object, &request.completion, &request.camera, texture_px)?, object);
    let overlap = object.seen_like.as_ref().map_or(0.0, |like| like.overlap);
    let has_image = mesh.materials.iter().any(|material| material.name == IMAGE_MATERIAL);
    Some(RawMesh {
        mesh: randomly_oriented(mesh, request.seed).snap_to_f32(),
        method: ReconstructionMethod::Category,
        made_by: "embedded/photograph".to_owned(),
        licence: if has_image { "CC0-1.0 AND LicenseRef-input-image" } else { "CC0-1.0" }.to_owned(),
        notes: vec![
            format!(
                "recognized as {}: its shape from the catalog, outline overlap {overlap:.2}",
                object.label
            ),
            "each part in the color of its pixels; prints toward the camera are the image's".to_owned(),
        ],
    })
}

/// Scales the mesh to the recognized extents, which were measured in the whole image.
fn in_size(mesh: TexturedMesh, object: &RecognizedObject) -> TexturedMesh {
    let stretch = object.size_m / mesh.size_m().max(DVec3::splat(1e-9));
    let sound = stretch.is_finite() && stretch.min_element() > 0.0;
    if sound { mesh.scaled(stretch) } else { mesh }
}

fn words(method: ReconstructionMethod) -> &'static str {
    match method {
        ReconstructionMethod::Turned => "turned body",
        ReconstructionMethod::Box => "box",
        ReconstructionMethod::Slab => "flat outline",
        ReconstructionMethod::Extrusion => "upright outline",
        ReconstructionMethod::Inflation => "outline blown up",
        ReconstructionMethod::Category => "parametric category",
        ReconstructionMethod::Generated => "model",
    }
}

/// The object as it stands, from its category or its primitive: the reference for orienting generated meshes.
/// `None` if its recognition holds neither.
pub fn as_seen(
    object: &RecognizedObject,
    completion: &Completion,
    camera: &Camera,
    settings: &SingleViewSettings,
) -> Option<TexturedMesh> {
    if let Some(mesh) = dressed(object, completion, camera, settings.sizes.texture_px) {
        return Some(in_size(mesh, object));
    }
    object.seen_as.as_ref()?;
    stood_up(object, completion, camera, settings).map(|(mesh, ..)| mesh)
}

/// The upright mesh, base on z = 0, with the recognized extents; also its primitive and method.
pub(super) fn stood_up(
    object: &RecognizedObject,
    completion: &Completion,
    camera: &Camera,
    settings: &SingleViewSettings,
) -> Option<(TexturedMesh, PosedPrimitive, ReconstructionMethod)> {
    let fit = match &object.seen_as {
        Some(seen) => seen.clone(),
        None => {
            let canvas = on_canvas(completion, camera.width_px, camera.height_px);
            let expected = ShapePrior {
                base: None,
                height: object.size_m.z,
                log_height_sigma: ShapePrior::LOG_HEIGHT_SIGMA,
            };
            fit_solid(&completion.silhouette, camera, Some(&canvas), Some(&expected))?
        }
    };
    let (solid, method) = primitive_mesh(&fit);
    let finer = match method {
        ReconstructionMethod::Box => 3,
        ReconstructionMethod::Turned | ReconstructionMethod::Inflation => 0,
        _ => 1,
    };
    let (positions, triangles) = subdivided(&solid, finer);
    let projection = Projection {
        camera,
        completion,
        world_from_solid: Pose::upright(fit.center.extend(0.0), fit.yaw_rad),
        size: fit.size,
        texture_px: settings.sizes.texture_px,
    };
    Some((in_size(projection.dress(&positions, &triangles), object), fit, method))
}

/// The completed crop at its position in the original image.
fn on_canvas(completion: &Completion, width_px: u32, height_px: u32) -> Image {
    let mut canvas = Image::filled(width_px, height_px, [0; 4]);
    let [x0, y0, x1, y1] = completion.crop_px;
    let (own_x, own_y) = (f64::from(completion.image.width_px()), f64::from(completion.image.height_px()));
    let (low_x, high_x) = (x0.max(0.0) as u32, (x1.ceil().max(0.0) as u32).min(width_px));
    let (low_y, high_y) = (y0.max(0.0) as u32, (y1.ceil().max(0.0) as u32).min(height_px));
    for y in low_y..high_y {
        for x in low_x..high_x {
            let u = (f64::from(x) + 0.5 - x0) / (x1 - x0) * own_x;
            let v = (f64::from(y) + 0.5 - y0) / (y1 - y0) * own_y;
            if u >= 0.0 && v >= 0.0 && u < own_x && v < own_y {
                canvas.set_pixel(x, y, completion.image.pixel(u as u32, v as u32));
            }
        }
    }
    canvas
}
