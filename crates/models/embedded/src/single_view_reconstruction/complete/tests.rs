//! Tests of the completion of partly occluded objects.

use std::sync::Arc;

use glam::{DVec2, DVec3};

use super::*;
use geometry::Camera;
use ports::ReferenceImage;
use scene::{InstanceId, RecognizedObject, StandsOn};
use vision::{PosedPrimitive, PrimitiveKind};

fn camera() -> Camera {
    Camera::orbit(320, 240, 0.5, DVec3::new(0.0, 0.0, 0.05), 0.0, 0.5, 0.8)
}

/// A recognized box of 120 x 60 x 100 mm, a little off the center.
fn solid() -> PosedPrimitive {
    PosedPrimitive {
        kind: PrimitiveKind::Block,
        center: DVec2::new(0.02, 0.0),
        yaw_rad: 0.25,
        size: DVec3::new(0.12, 0.06, 0.1),
        overlap: 0.95,
    }
}

fn stripe(y: u32) -> [u8; 4] {
    if (y / 12).is_multiple_of(2) { [190, 40, 40, 255] } else { [235, 230, 215, 255] }
}

/// The box with horizontal stripes, gray occluders in front of it, and its whole silhouette.
fn scene(others: impl Fn(u32, u32) -> bool, seen_as: Option<PosedPrimitive>) -> (CompletionRequest, Mask) {
    let camera = camera();
    let whole = primitive_mesh::silhouette(&solid(), &camera).expect("before the camera");
    let others = Mask::from_fn(320, 240, others);
    let visible = whole.without(&others);
    let mut image = Image::filled(320, 240, [250, 250, 250, 255]);
    for y in 0..240 {
        for x in 0..320 {
            if others.contains(x, y) {
                image.set_pixel(x, y, [60, 60, 60, 255]);
            } else if visible.contains(x, y) {
                image.set_pixel(x, y, stripe(y));
            }
        }
    }
    let object = RecognizedObject {
        id: InstanceId::new("box_1").expect("a name"),
        label: "box".into(),
        category: "box".into(),
        size_m: DVec3::new(0.12, 0.06, 0.1),
        tipped: None,
        color: None,
        material: None,
        seed: 1,
        stands_on: StandsOn::Table,
        seen_px: None,
        seen_as,
        seen_like: None,
        mass_kg: None,
        stand_in: None,
    };
    let reference = ReferenceImage { image: Arc::new(image), known: None, depth: None };
    (CompletionRequest { reference, object, visible, others, camera: Some(camera), alone: None }, whole)
}

fn completed(request: &CompletionRequest) -> Completion {
    complete(request, &CancelFlag::default()).expect("completed")
}

/// The center and more: most of the mirror image of the occluded part is occluded as well.
fn the_center(x: u32, y: u32) -> bool {
    (150..230).contains(&x) && y > 40
}

#[test]
fn occluded_striped_box_is_completed_with_continued_stripes() {
    let (request, whole) = scene(the_center, Some(solid()));
    let hidden = whole.without(&request.visible);
    assert!(hidden.area_px() * 4 > whole.area_px(), "hardly hidden");
    let completion = completed(&request);
    assert!(completion.silhouette.iou(&whole) > 0.97, "{}", completion.silhouette.iou(&whole));
    let ways: Vec<CompletionWay> = completion.completed_by.iter().map(|by| by.way).collect();
    assert!(ways.contains(&CompletionWay::NeighboringTexture), "{ways:?}");
    let shares: f64 = completion.completed_by.iter().map(|by| by.share).sum();
    assert!((shares - completion.completed_share).abs() < 1e-9 && completion.completed_share > 0.2);
    let [x0, y0, ..] = completion.crop_px.map(|side| side as u32);
    let new: Vec<(u32, u32)> = pixels(&completion.silhouette.without(&request.visible)).collect();
    let alike = new.iter().filter(|(x, y)| {
        let [r, g, _, a] = completion.image.pixel(x - x0, y - y0);
        a == 255 && r > 120 && (g < 130) == (stripe(*y)[1] < 130)
    });
    let share = alike.count() as f64 / new.len() as f64;
    assert!(share > 0.75, "{share} of the hidden pixels are in their stripe");
    assert_eq!(completed(&request), completion, "twice the same");
}

#[test]
fn completion_adds_occluder_pixels_only() {
    let (request, _) =
        scene(the_center, Some(PosedPrimitive { size: DVec3::new(0.14, 0.07, 0.115), ..solid() }));
    let completion = completed(&request);
    let grown = completion.silhouette.without(&request.visible);
    assert!(pixels(&grown).all(|(x, y)| request.others.contains(x, y)));
    let (alone, whole) = scene(|_, _| false, Some(PosedPrimitive { size: DVec3::splat(0.3), ..solid() }));
    let completion = completed(&alone);
    assert!(completion.silhouette == whole && completion.completed_by.is_empty());
    assert_eq!(completion.completed_share, 0.0);
    // A separate object.
    let (apart, whole) = scene(|x, y| x < 60 && y > 100, Some(solid()));
    assert_eq!(completed(&apart).silhouette, whole);
}

#[test]
fn object_without_primitive_is_completed_by_convexity() {
    let occluder = |x: u32, y: u32| (150..185).contains(&x) && y > 150;
    let (request, whole) = scene(occluder, None);
    let completion = completed(&request);
    assert!(completion.completed_share > 0.02);
    assert!(completion.silhouette.iou(&whole) > request.visible.iou(&whole) + 0.01);
}
