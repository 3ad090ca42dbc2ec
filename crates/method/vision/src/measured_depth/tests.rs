//! Depths of rendered boxes on a table: the plane, its heights, noise, holes and contradictions.

use glam::DVec2;

use super::*;
use geometry::Camera;
use imaging::Image;

const SIZE_PX: [u32; 2] = [320, 240];

/// A camera 0.6 rad above a table, rolled by 0.08 rad, with a principal point beside the center.
fn camera() -> Camera {
    let level = Camera::orbit(SIZE_PX[0], SIZE_PX[1], 0.9, DVec3::ZERO, 0.2, 0.6, 1.1);
    let pose = level.world_from_camera;
    let rotation = pose.rotation * glam::DQuat::from_rotation_z(0.08);
    Camera { cx: 170.0, cy: 112.0, world_from_camera: geometry::Pose { rotation, ..pose }, ..level }
}

/// Height of the box of the scene, and its half extent.
const BOX_M: f64 = 0.12;
const HALF_M: f64 = 0.08;

/// Depth of a table with a box at its center, and the pixels of the box.
fn scene(camera: &Camera, noise: impl Fn(usize, f64) -> f64) -> (DepthImage, Vec<bool>) {
    let eye = camera.world_from_camera.translation_m;
    let (mut depths_mm, mut is_box) = (Vec::new(), Vec::new());
    for index in 0..(SIZE_PX[0] * SIZE_PX[1]) as usize {
        let (x, y) = (index % SIZE_PX[0] as usize, index / SIZE_PX[0] as usize);
        let ray = camera.ray_direction_in_world(DVec2::new(x as f64 + 0.5, y as f64 + 0.5));
        let bounds = [(-HALF_M, HALF_M), (-HALF_M, HALF_M), (0.0, BOX_M)];
        let slabs = (0..3).map(|k| {
            let (a, b) = ((bounds[k].0 - eye[k]) / ray[k], (bounds[k].1 - eye[k]) / ray[k]);
            (a.min(b), a.max(b))
        });
        let (enter, leave) =
            slabs.fold((0.0_f64, f64::INFINITY), |(enter, leave), (a, b)| (enter.max(a), leave.min(b)));
        let hits_box = enter < leave;
        let along = if hits_box { enter } else { -eye.z / ray.z };
        let forward = camera.world_from_camera.transform_vector(DVec3::Z);
        let depth_m = along * ray.dot(forward);
        depths_mm.push((1e3 * noise(index, depth_m)).round().max(0.0) as u16);
        is_box.push(hits_box);
    }
    (DepthImage::new(SIZE_PX[0], SIZE_PX[1], depths_mm).expect("a depth a pixel"), is_box)
}

fn copy_of(depth: &DepthImage, camera: &Camera) -> DepthCopy {
    let intrinsics = Intrinsics {
        focal_px: DVec2::new(camera.fx, camera.fy),
        center_px: Some(DVec2::new(camera.cx, camera.cy)),
    };
    let image = Image::filled(SIZE_PX[0], SIZE_PX[1], [128, 128, 128, 255]);
    DepthCopy::new(depth, &intrinsics, &Pixels::new(&image, 1024))
}

/// Deterministic noise, about normal: sum of four uniform numbers, unit variance.
fn normal(index: usize) -> f64 {
    let uniform = |k: u64| {
        let mut z = (4 * index as u64 + k + 1).wrapping_mul(0x9E37_79B9_7F4A_7C15);
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        (z >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
    };
    (0..4).map(uniform).sum::<f64>() * 3.0_f64.sqrt()
}

fn off(bits: &[bool]) -> Vec<bool> {
    bits.iter().map(|bit| !bit).collect()
}

#[test]
fn plane_gives_height_elevation_and_roll() {
    let camera = camera();
    let (depth, is_box) = scene(&camera, |_, depth_m| depth_m);
    let plane = TopPlane::fit(&copy_of(&depth, &camera), &off(&is_box)).expect("a plane");
    let eye = camera.world_from_camera.translation_m;
    assert!((plane.camera_height_m() - eye.z).abs() < 5e-4, "{}", plane.camera_height_m());
    assert!((plane.elevation_rad() - camera.elevation_rad()).abs() < 5e-4);
    assert!((plane.roll_rad() - 0.08).abs() < 1e-3, "{}", plane.roll_rad());
    assert!(plane.rms_m < 1e-3);
}

#[test]
fn plane_and_heights_survive_noise_holes_and_stray_points() {
    let camera = camera();
    let noisy = |index: usize, depth_m: f64| match index % 10 {
        // Holes, and points of no surface.
        0 | 1 => 0.0,
        2 => 0.7 * depth_m,
        _ => depth_m + 0.003 * depth_m * depth_m * normal(index),
    };
    let (depth, is_box) = scene(&camera, noisy);
    let copy = copy_of(&depth, &camera);
    let plane = TopPlane::fit(&copy, &off(&is_box)).expect("a plane");
    let eye = camera.world_from_camera.translation_m;
    assert!((plane.camera_height_m() / eye.z - 1.0).abs() < 3e-3, "{}", plane.camera_height_m());
    assert!((plane.elevation_rad() - camera.elevation_rad()).abs() < 3e-3);
    let heights = HeightRange::of(&copy, &plane, &is_box).expect("most pixels are measured");
    let top_m = heights.top * plane.camera_height_m();
    assert!((top_m - BOX_M).abs() < 0.006, "{top_m}");
    assert!(heights.bottom * plane.camera_height_m() < 0.02, "{heights:?}");
}

#[test]
fn contradictions_are_named() {
    let camera = camera();
    let everywhere = vec![true; (SIZE_PX[0] * SIZE_PX[1]) as usize];
    let doubt = |noise: &dyn Fn(usize, f64) -> f64, bits: &[bool]| {
        let (depth, _) = scene(&camera, noise);
        TopPlane::fit(&copy_of(&depth, &camera), bits).expect_err("no plane")
    };
    let sparse = doubt(&|index, depth_m| if index % 20 == 0 { depth_m } else { 0.0 }, &everywhere);
    assert!(matches!(sparse, DepthDoubt::FewMeasured { .. }), "{sparse}");
    let scattered = doubt(&|index, depth_m| depth_m + 0.3 * normal(index).abs(), &everywhere);
    assert!(matches!(scattered, DepthDoubt::NoPlane { .. }), "{scattered}");
    // A wall before the camera.
    let wall = doubt(&|_, _| 1.0, &everywhere);
    assert!(matches!(wall, DepthDoubt::NoTableView { .. }), "{wall}");
}

#[test]
fn few_measured_pixels_give_no_height() {
    let camera = camera();
    let (depth, is_box) = scene(&camera, |_, depth_m| depth_m);
    let plane = TopPlane::fit(&copy_of(&depth, &camera), &off(&is_box)).expect("a plane");
    let (hollow, _) = scene(&camera, |index, depth_m| if is_box[index] { 0.0 } else { depth_m });
    assert_eq!(HeightRange::of(&copy_of(&hollow, &camera), &plane, &is_box), None);
}

#[test]
fn pixels_show_the_plane_pass_it_or_leave_it_open() {
    let camera = camera();
    let (depth, is_box) = scene(&camera, |_, depth_m| depth_m);
    let plane = TopPlane::fit(&copy_of(&depth, &camera), &off(&is_box)).expect("a plane");
    // The left half of the table lies 10 cm deeper along the rays, and every seventh pixel has no depth.
    let (torn, _) = scene(&camera, |index, depth_m| match index {
        _ if index % 7 == 0 => 0.0,
        _ if index % (SIZE_PX[0] as usize) < 100 => depth_m + 0.1,
        _ => depth_m,
    });
    let torn = copy_of(&torn, &camera);
    assert_eq!(torn.len(), is_box.len());
    for (index, is_box) in is_box.iter().enumerate() {
        let shown = plane.is_shown_at(&torn, index);
        match index {
            _ if index % 7 == 0 => assert_eq!(shown, None),
            _ if index % (SIZE_PX[0] as usize) < 100 => assert_eq!(shown, Some(false)),
            _ if *is_box => assert_ne!(shown, Some(false)),
            _ => assert_eq!(shown, Some(true)),
        }
    }
    let noisy = |index: usize, depth_m: f64| depth_m + 0.006 * normal(index);
    let (noisy, _) = scene(&camera, noisy);
    let noisy = copy_of(&noisy, &camera);
    let plane = TopPlane::fit(&noisy, &off(&is_box)).expect("a plane");
    assert!(
        (0..noisy.len()).all(|index| plane.is_shown_at(&noisy, index) != Some(true)),
        "too noisy to tell"
    );
}
