//! Orientation of the mesh on a contact sheet. The sheet is compared with sheets of the embedded generator's mesh
//! in every axis-aligned rotation. The embedded analyst's upright rotation of that mesh then applies to the shown
//! one.

use glam::{DQuat, DVec3};
use serde_json::{Value, json};

use super::Question;
use crate::mock_vendors::error_response::VendorError;
use crate::mock_vendors::image_sessions::ImageSessions;
use geometry::TexturedMesh;
use imaging::Image;
use pose_estimation::upright::axis_aligned;
use render::annotate::{fitted, sheet};
use render::side_views::{Side, side_views};

/// Width of the compared sheets, pixels.
const COMPARED_PX: u32 = 240;

/// Maximum mean color difference, 0..1, of equal sheets.
const SAME_SHEET: f64 = 0.012;

pub(super) async fn answer(sessions: &ImageSessions, question: &Question) -> Result<Value, VendorError> {
    let [object, shown] = &question.images[..] else {
        return Err(VendorError::Invalid("two images are wanted".into()));
    };
    let (known, index) = sessions.whole_object(&cut_out(object)).await?;
    let mesh = sessions.mesh(&known.recognized, index).await?;
    let canonical_from_mesh = sessions.upright(&known.recognized, index, &mesh).await?;
    let shown = shown.clone();
    let shown_from_mesh = sessions.compute(move || turn_shown(&mesh, &shown, canonical_from_mesh)).await?;
    let shown_from_canonical = shown_from_mesh * canonical_from_mesh.conjugate();
    let side = |canonical: DVec3| Side::facing(shown_from_canonical * canonical).name();
    Ok(json!({ "top": side(DVec3::Z), "front": side(-DVec3::Y) }))
}

/// The mesh rotation whose sheet is most similar to the shown one. The identity and the upright rotation come
/// first, being the most likely.
fn turn_shown(mesh: &TexturedMesh, shown: &Image, canonical_from_mesh: DQuat) -> DQuat {
    let shown = fitted(shown, COMPARED_PX, COMPARED_PX);
    let mut best = (f64::INFINITY, DQuat::IDENTITY);
    for turn in [DQuat::IDENTITY, canonical_from_mesh].into_iter().chain(axis_aligned()) {
        let views = side_views(&mesh.clone().rotated(turn), COMPARED_PX / 3);
        let cells: Vec<(&Image, &str)> = views.iter().map(|(_, view)| (view, "")).collect();
        let distance = apart(&fitted(&sheet(&cells, 3, COMPARED_PX / 3), COMPARED_PX, COMPARED_PX), &shown);
        if distance < best.0 {
            best = (distance, turn);
        }
        if distance <= SAME_SHEET {
            break;
        }
    }
    best.1
}

/// Mean color difference, 0..1, over the common area.
fn apart(one: &Image, other: &Image) -> f64 {
    let (width, height) = (one.width_px().min(other.width_px()), one.height_px().min(other.height_px()));
    let mut sum = 0.0;
    for (x, y) in (0..height).flat_map(|y| (0..width).map(move |x| (x, y))) {
        let (a, b) = (one.pixel(x, y), other.pixel(x, y));
        sum += (0..3).map(|k| f64::from(a[k].abs_diff(b[k]))).sum::<f64>();
    }
    sum / (765.0 * f64::from(width) * f64::from(height)).max(1.0)
}

/// The image with its backdrop, the color of the corner pixel, made transparent.
fn cut_out(object: &Image) -> Image {
    let mut cut_out = object.clone();
    let backdrop = object.pixel(0, 0);
    for pixel in cut_out.as_rgba_mut().chunks_exact_mut(4) {
        if (0..3).all(|k| pixel[k].abs_diff(backdrop[k]) <= 2) {
            pixel[3] = 0;
        }
    }
    cut_out
}

#[cfg(test)]
mod tests {
    use super::*;
    use geometry::{Material, Rgb, shapes};

    #[test]
    fn turn_shown_recovers_rotation_from_sheet() {
        let mut mesh = TexturedMesh::default();
        mesh.add(shapes::cone(0.05, 0.02, 0.12, 24), &Material::plain("body", Rgb::hex(0xb04020), 0.6));
        let handle = shapes::block(DVec3::new(0.02, 0.06, 0.03)).translated(DVec3::new(0.0, 0.06, 0.02));
        mesh.add(handle, &Material::plain("handle", Rgb::hex(0x203060), 0.6));
        for turn in axis_aligned().into_iter().step_by(5) {
            let turned = mesh.clone().rotated(turn);
            let views = side_views(&turned, 128);
            let cells: Vec<(&Image, &str)> = views.iter().map(|(side, view)| (view, side.name())).collect();
            let found = turn_shown(&mesh, &sheet(&cells, 3, 128), DQuat::IDENTITY);
            assert!(found.dot(turn).abs() > 0.99, "{turn:?}: {found:?}");
        }
    }
}
