//! Catalog meshes in any of the 24 orientations are turned upright; invalid inputs give errors.

use super::*;
use catalog::{Recipe, build, category};
use geometry::Pose;
use render::{Background, Frame, Lighting, RenderObject, RenderScene, RenderSettings, View, render};

fn settings() -> UprightSettings {
    UprightSettings {
        yaws: 24,
        side_px: 64,
        extent_weight: 0.5,
        hopeless_extent_cost: 0.15,
        appearance_weight: 0.08,
        color_candidates: 5,
        example_weight: 0.25,
        detail_weight: 0.05,
        hint_up_weight: 0.03,
        hint_front_weight: 0.08,
        clear_lead: 0.02,
    }
}

fn built(name: &str, seed: u64) -> TexturedMesh {
    let category = category(name).expect("in the catalog");
    let recipe = Recipe {
        category: name.to_owned(),
        size_m: category.size.typical_m(),
        color: None,
        material: None,
        seed,
    };
    build(&recipe).expect("builds")
}

fn camera() -> Camera {
    Camera::orbit(640, 480, 0.61, DVec3::ZERO, 0.15, 0.7, 1.4)
}

fn rendered(mesh: &TexturedMesh, yaw_rad: f64) -> Frame {
    let pose = Pose::upright(DVec3::new(0.08, -0.04, 0.0), yaw_rad);
    let scene = RenderScene {
        objects: vec![RenderObject { mesh, world_from_object: pose, id: 1 }],
        lighting: Lighting::studio(-0.5, 0.9, 0.4),
        background: Background::light(),
    };
    let quick = RenderSettings { supersampling: 1, shadow_map_px: 256, sky_directions: 6, sky_map_px: 96 };
    render(&scene, &View::Perspective(camera()), &quick)
}

/// Turns the mesh, rotated the `k`-th way, upright; returns the remaining rotation.
fn left_over(mesh: &TexturedMesh, k: usize, example: Option<&TexturedMesh>) -> (DQuat, UprightPose) {
    left_over_hints(mesh, k, example, &[])
}

/// Turns the mesh upright with hints for the remaining rotation, and returns that rotation.
fn left_over_hints(
    mesh: &TexturedMesh,
    k: usize,
    example: Option<&TexturedMesh>,
    left_as_hinted: &[DQuat],
) -> (DQuat, UprightPose) {
    let raw_from_canonical = rotations::axis_aligned()[k % 24];
    let size_m = mesh.size_m();
    let raw = mesh.clone().rotated(raw_from_canonical).scaled(DVec3::splat(1.0 / size_m.max_element()));
    let frame = rendered(mesh, 0.4 + k as f64);
    let camera = camera();
    let problem = UprightProblem {
        raw_mesh: &raw,
        camera: &camera,
        mask: &frame.mask(1),
        image: Some((&frame.color, [0.0, 0.0, 640.0, 480.0])),
        size_m,
        example,
        hints: &left_as_hinted.iter().map(|left| *left * raw_from_canonical.conjugate()).collect::<Vec<_>>(),
    };
    let dro = crate::yaw::tests::settings();
    let pose = upright(&problem, &settings(), &dro, &CancelFlag::default()).expect("found");
    (pose.rotation * raw_from_canonical, pose)
}

const KINDS: [&str; 14] = [
    "mug",
    "plate",
    "wine_glass",
    "fork",
    "apple",
    "pear",
    "banana",
    "laptop",
    "keyboard",
    "book",
    "calculator",
    "mouse",
    "carrot",
    "bowl",
];

#[test]
fn upright_finds_up_for_catalog_meshes() {
    let wrong: Vec<_> = KINDS
        .iter()
        .enumerate()
        .filter_map(|(k, name)| {
            let (left, pose) = left_over(&built(name, 5), 7 * k + 3, None);
            ((left * DVec3::Z).z < 0.9).then_some((name, pose.cost, pose.confidence))
        })
        .collect();
    assert!(wrong.is_empty(), "{wrong:?}");
}

#[test]
fn example_determines_front() {
    for (k, name) in ["mug", "laptop", "fork", "mouse"].into_iter().enumerate() {
        let (left, _) = left_over(&built(name, 5), 5 * k + 2, Some(&built(name, 6)));
        assert!(left.w.abs() > 0.99, "{name}: {left:?}");
    }
}

#[test]
fn hint_determines_front_without_example() {
    for (k, name) in ["mug", "laptop", "fork", "mouse", "calculator"].into_iter().enumerate() {
        let (left, _) = left_over_hints(&built(name, 5), 5 * k + 2, None, &[DQuat::IDENTITY]);
        assert!(left.w.abs() > 0.99, "{name}: {left:?}");
    }
}

#[test]
fn image_overrules_wrong_hint() {
    let upside_down = DQuat::from_rotation_x(std::f64::consts::PI);
    let lying = DQuat::from_rotation_x(std::f64::consts::FRAC_PI_2);
    let mut followed = Vec::new();
    for (k, name) in KINDS.into_iter().enumerate() {
        for (what, wrong) in [("upside down", upside_down), ("lying", lying)] {
            let (left, _) = left_over_hints(&built(name, 5), 7 * k + 3, None, &[wrong]);
            if (left * DVec3::Z).z < 0.9 {
                followed.push((name, what));
            }
        }
    }
    // A mesh with the same image from below at this distance follows the hint.
    assert!(followed.len() <= 4, "{followed:?}");
}

#[test]
fn image_selects_correct_hint_of_two() {
    let upside_down = DQuat::from_rotation_x(std::f64::consts::PI);
    for name in ["mug", "wine_glass", "laptop"] {
        let (left, _) = left_over_hints(&built(name, 5), 11, None, &[upside_down, DQuat::IDENTITY]);
        assert!(left.w.abs() > 0.99, "{name}: {left:?}");
    }
}

#[test]
fn upright_rejects_invalid_input() {
    let (mesh, camera) = (built("mug", 1), camera());
    let none = Mask::empty(640, 480);
    let some = Mask::from_fn(640, 480, |x, y| (300..340).contains(&x) && (200..240).contains(&y));
    let problem = UprightProblem {
        raw_mesh: &mesh,
        camera: &camera,
        mask: &none,
        image: None,
        size_m: DVec3::ONE,
        example: None,
        hints: &[],
    };
    let dro = crate::yaw::tests::settings();
    let solve = |problem: &UprightProblem| upright(problem, &settings(), &dro, &CancelFlag::default());
    assert_eq!(solve(&problem), Err(UprightError::NoMask));
    let seen = UprightProblem { mask: &some, ..problem };
    assert!(solve(&seen).is_ok());
    assert_eq!(solve(&UprightProblem { size_m: DVec3::ZERO, ..seen }), Err(UprightError::NoSize));
    let empty = TexturedMesh::default();
    assert_eq!(solve(&UprightProblem { raw_mesh: &empty, ..seen }), Err(UprightError::EmptyMesh));
}
