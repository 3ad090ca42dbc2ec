//! Known yaws are recovered from rendered images, also under symmetry, occlusion and wrong sizes.

mod solvers;

use glam::DVec3;

use super::*;
use geometry::Pose;
use render::{RenderObject, View, render_geometry};

pub fn settings() -> YawSettings {
    YawSettings {
        solver: YawSolver::Golden,
        silhouette_weight: 0.5,
        edge_weight: 0.5,
        descriptor_weight: 0.1,
        coarse_yaws: 72,
        keep: 8,
        coarse_px: 96,
        fine_px: 256,
        tolerance_rad: 0.002,
        soft_sigma_px2: 1.6,
        outline_cells: 128,
        flat_spread: 0.012,
        periodic_share: 0.03,
        same_outline: 0.012,
        appearance_weight: 0.05,
        flat_appearance: 0.06,
        refine_camera: true,
        hopeless_loss: 0.3,
        clear_lead: 0.01,
    }
}

const WIDTH_PX: u32 = 800;
const HEIGHT_PX: u32 = 600;

fn built(name: &str) -> TexturedMesh {
    let category = catalog::category(name).expect("in the catalog");
    let recipe = catalog::Recipe {
        category: name.to_owned(),
        size_m: category.size.typical_m(),
        color: None,
        material: None,
        seed: 3,
    };
    catalog::build(&recipe).expect("builds")
}

fn camera() -> Camera {
    Camera::orbit(WIDTH_PX, HEIGHT_PX, 0.61, DVec3::ZERO, 0.2, 0.75, 1.4)
}

fn seen(mesh: &TexturedMesh, at: DVec3, yaw_rad: f64) -> Mask {
    let object = RenderObject { mesh, world_from_object: Pose::upright(at, yaw_rad), id: 1 };
    render_geometry(&[object], &View::Perspective(camera())).mask(1)
}

fn estimated(mesh: &TexturedMesh, mask: &Mask, unknown: &Mask) -> YawEstimate {
    let camera = camera();
    let problem = YawProblem {
        mesh,
        camera: &camera,
        mask,
        unknown,
        support_height_m: 0.0,
        image: None,
        stated_yaw_rad: None,
    };
    estimate_yaw(&problem, &settings(), &CancelFlag::default()).expect("estimated")
}

fn error_deg(estimate: &YawEstimate, yaw_rad: f64, order: u32) -> f64 {
    symmetry::representative(estimate.yaw_rad - yaw_rad, order).to_degrees().abs()
}

/// Name and the order of the outline's symmetry.
const DOZEN: [(&str, u32); 12] = [
    ("mug", 1),
    ("fork", 1),
    ("knife", 1),
    ("spoon", 1),
    ("banana", 1),
    ("carrot", 1),
    ("laptop", 1),
    ("mouse", 1),
    ("calculator", 1),
    ("game_controller", 1),
    ("book", 2),
    ("keyboard", 2),
];

#[test]
fn estimate_yaw_recovers_catalog_yaws() {
    let none = Mask::empty(WIDTH_PX, HEIGHT_PX);
    let mut errors: Vec<(f64, &str)> = DOZEN
        .iter()
        .enumerate()
        .map(|(k, &(name, order))| {
            let yaw_rad = wrap_angle_rad(0.37 + 0.71 * k as f64);
            let at = DVec3::new(0.16 - 0.05 * (k % 6) as f64, 0.1 - 0.07 * (k % 4) as f64, 0.0);
            let mesh = built(name);
            let estimate = estimated(&mesh, &seen(&mesh, at, yaw_rad), &none);
            (error_deg(&estimate, yaw_rad, order), name)
        })
        .collect();
    errors.sort_by(|a, b| a.0.total_cmp(&b.0));
    assert!(errors[errors.len() / 2].0 <= 0.3, "{errors:?}");
    assert!(errors[errors.len() - 1].0 <= 2.0, "{errors:?}");
}

#[test]
fn estimate_yaw_reports_full_symmetry_of_plate() {
    let mesh = built("saucer");
    let estimate =
        estimated(&mesh, &seen(&mesh, DVec3::new(0.1, 0.0, 0.0), 0.7), &Mask::empty(WIDTH_PX, HEIGHT_PX));
    assert_eq!((estimate.symmetry_order, estimate.representative_yaw_rad), (0, 0.0));
}

#[test]
fn estimate_yaw_is_robust_to_wrong_size() {
    let mesh = built("mug");
    let mask = seen(&mesh, DVec3::new(-0.12, 0.1, 0.0), 0.3);
    let none = Mask::empty(WIDTH_PX, HEIGHT_PX);
    for factor in [0.7, 1.4] {
        let estimate = estimated(&mesh.clone().scaled(DVec3::splat(factor)), &mask, &none);
        assert!(error_deg(&estimate, 0.3, 1) < 1.5, "{factor}: {}", estimate.yaw_rad);
    }
}

#[test]
fn estimate_yaw_ignores_occluder_outline() {
    let mesh = built("laptop");
    let (at, yaw_rad) = (DVec3::new(0.0, 0.05, 0.0), 0.4);
    let whole = seen(&mesh, at, yaw_rad);
    let [x0, y0, x1, y1] = whole.bbox_px().expect("in view");
    let (cut_x, cut_y) = (x0 + (x1 - x0) * 3 / 5, y0 + (y1 - y0) / 2);
    let hides = |x: u32, y: u32| x > cut_x && y > cut_y;
    let unknown = Mask::from_fn(WIDTH_PX, HEIGHT_PX, hides);
    let visible = Mask::from_fn(WIDTH_PX, HEIGHT_PX, |x, y| whole.contains(x, y) && !hides(x, y));
    let estimate = estimated(&mesh, &visible, &unknown);
    assert!(error_deg(&estimate, yaw_rad, 1) < 3.0, "{}", estimate.yaw_rad);
}

#[test]
fn estimate_yaw_uses_support_height() {
    let mesh = built("mug");
    let (camera, none) = (camera(), Mask::empty(WIDTH_PX, HEIGHT_PX));
    for yaw_rad in [-2.1, 0.3, 2.4] {
        let mask = seen(&mesh, DVec3::new(0.12, -0.05, 0.12), yaw_rad);
        let problem = YawProblem {
            mesh: &mesh,
            camera: &camera,
            mask: &mask,
            unknown: &none,
            support_height_m: 0.12,
            image: None,
            stated_yaw_rad: None,
        };
        let estimate = estimate_yaw(&problem, &settings(), &CancelFlag::default()).expect("estimated");
        assert!(error_deg(&estimate, yaw_rad, 1) < 0.5, "{yaw_rad}: {}", estimate.yaw_rad);
    }
}

#[test]
fn own_sides_exclude_sides_of_hidden_foot() {
    use geometry::{Material, Rgb, shapes};
    let mut mesh = TexturedMesh::default();
    let brass = Material::plain("brass", Rgb::hex(0xb09040), 0.4);
    mesh.add(shapes::block(DVec3::new(0.16, 0.1, 0.02)), &brass);
    mesh.add(shapes::block(DVec3::new(0.04, 0.04, 0.14)).translated(DVec3::new(0.04, 0.02, 0.02)), &brass);
    for yaw_rad in [0.4, 2.9, -1.3] {
        let whole = seen(&mesh, DVec3::new(-0.03, 0.04, 0.0), yaw_rad);
        let [x0, y0, x1, y1] = whole.bbox_px().expect("in view");
        // An occluder stands before the lower left.
        let hides = |x: u32, y: u32| x < x0 + 2 * (x1 - x0) / 5 && y > y0 + (y1 - y0) / 2;
        let unknown = Mask::from_fn(WIDTH_PX, HEIGHT_PX, hides);
        let visible = Mask::from_fn(WIDTH_PX, HEIGHT_PX, |x, y| whole.contains(x, y) && !hides(x, y));
        let estimate = estimated(&mesh, &visible, &unknown);
        assert!(error_deg(&estimate, yaw_rad, 1) < 1.0, "{yaw_rad}: {}", estimate.yaw_rad);
    }
}

#[test]
fn estimate_yaw_is_thread_independent_and_cancellable() {
    let mesh = built("mug");
    let mask = seen(&mesh, DVec3::ZERO, 1.0);
    let none = Mask::empty(WIDTH_PX, HEIGHT_PX);
    let with = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
        pool.install(|| estimated(&mesh, &mask, &none))
    };
    assert_eq!(with(1), with(3));
    let cancel = CancelFlag::default();
    cancel.cancel();
    let camera = camera();
    let problem = YawProblem {
        mesh: &mesh,
        camera: &camera,
        mask: &mask,
        unknown: &none,
        support_height_m: 0.0,
        image: None,
        stated_yaw_rad: None,
    };
    assert!(matches!(estimate_yaw(&problem, &settings(), &cancel), Err(YawError::Cancelled(_))));
    let nothing = YawProblem { mask: &none, ..problem };
    assert_eq!(estimate_yaw(&nothing, &settings(), &CancelFlag::default()), Err(YawError::EmptyMask));
}

#[test]
fn colors_separate_poses_with_equal_outline() {
    half_turns_of_a_block_with_a_badge(0xb02020, &settings(), 1);
    // Its lines are as clear as those of a bright one.
    half_turns_of_a_block_with_a_badge(0xdad8d8, &settings(), 1);
}

#[test]
fn reported_symmetry_keeps_preferred_yaw() {
    let lenient = YawSettings { flat_appearance: 2.0, ..settings() };
    half_turns_of_a_block_with_a_badge(0xdad8d8, &lenient, 2);
}

/// Both half turns come back, and the order that is reported.
fn half_turns_of_a_block_with_a_badge(color: u32, settings: &YawSettings, order: u32) {
    let mut mesh = TexturedMesh::default();
    use geometry::{Material, Rgb, shapes};
    use render::{Background, Lighting, RenderScene, RenderSettings, render};
    mesh.add(shapes::block(DVec3::new(0.12, 0.2, 0.04)), &Material::plain("white", Rgb::hex(0xe0e0e0), 0.6));
    let badge = shapes::block(DVec3::new(0.08, 0.04, 0.0405)).translated(DVec3::new(0.0, 0.07, 0.0));
    mesh.add(badge, &Material::plain("red", Rgb::hex(color), 0.6));
    for yaw_rad in [0.6, 0.6 - std::f64::consts::PI] {
        let object =
            RenderObject { mesh: &mesh, world_from_object: Pose::upright(DVec3::ZERO, yaw_rad), id: 1 };
        let scene = RenderScene {
            objects: vec![object],
            lighting: Lighting::studio(-0.5, 0.9, 0.4),
            background: Background::light(),
        };
        let quick =
            RenderSettings { supersampling: 1, shadow_map_px: 256, sky_directions: 0, sky_map_px: 32 };
        let frame = render(&scene, &View::Perspective(camera()), &quick);
        let (mask, none) = (frame.mask(1), Mask::empty(WIDTH_PX, HEIGHT_PX));
        let camera = camera();
        let problem = YawProblem {
            mesh: &mesh,
            camera: &camera,
            mask: &mask,
            unknown: &none,
            support_height_m: 0.0,
            image: Some(&frame.color),
            stated_yaw_rad: None,
        };
        let estimate = estimate_yaw(&problem, settings, &CancelFlag::default()).expect("estimated");
        assert!(error_deg(&estimate, yaw_rad, 1) < 0.5, "{yaw_rad}: {}", estimate.yaw_rad);
        assert_eq!(estimate.symmetry_order, order);
        let canonical = symmetry::representative(yaw_rad, order) - estimate.representative_yaw_rad;
        assert!(canonical.abs() < 0.01);
        let blind = estimated(&mesh, &mask, &none);
        assert_eq!(blind.symmetry_order, 2);
        // What a text states decides between the half turns, against the colors; it is no yaw of its own.
        let stated_yaw_rad = Some(yaw_rad + std::f64::consts::PI - 0.3);
        let stated = YawProblem { stated_yaw_rad, ..problem };
        let turned = estimate_yaw(&stated, settings, &CancelFlag::default()).expect("estimated");
        assert!(error_deg(&turned, yaw_rad + std::f64::consts::PI, 1) < 0.5, "{}", turned.yaw_rad);
    }
}
