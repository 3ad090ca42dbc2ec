//! The paper's solver: its loss has the derivative it says, it agrees with the default on known yaws, and colors in
//! its loss tell sides apart.

use super::*;

fn paper() -> DroSettings {
    DroSettings { solver: DroSolver::Paper, ..settings() }
}

fn solved(mesh: &TexturedMesh, mask: &Mask, settings: &DroSettings) -> RotationEstimate {
    let (camera, none) = (camera(), Mask::empty(WIDTH_PX, HEIGHT_PX));
    let problem =
        RotationProblem { mesh, camera: &camera, mask, unknown: &none, seat_height_m: 0.0, picture: None };
    estimate_yaw(&problem, settings, &Interrupt::default()).expect("estimated")
}

/// Twenty pictures: as the box moves, the crop's zoom and the re-centering move; where a side is hidden,
/// otherwise.
#[test]
fn the_soft_loss_has_the_derivative_it_says() {
    // The silhouettes are f32: a smaller step drowns in rounding, a larger one steps over vertices.
    const STEP_RAD: f64 = 2e-4;
    let (camera, none) = (camera(), Mask::empty(WIDTH_PX, HEIGHT_PX));
    let mut errors = Vec::new();
    for (name, hidden) in [("mug", false), ("banana", false), ("book", false), ("laptop", true)] {
        let mesh = built(name);
        let whole = seen(&mesh, DVec3::new(0.1, -0.05, 0.0), 0.9);
        let bbox = whole.bbox_px().expect("in view");
        let hides = |x: u32, _: u32| hidden && x > (2 * bbox[0] + bbox[2]) / 3;
        let mask = Mask::from_fn(WIDTH_PX, HEIGHT_PX, |x, y| whole.contains(x, y) && !hides(x, y));
        let unknown = if hidden { Mask::from_fn(WIDTH_PX, HEIGHT_PX, hides) } else { none.clone() };
        let crop = Crop::new(&mask, &unknown, mask.bbox_px().expect("in view"), 256);
        let outline = OutlineMesh::new(&mesh, 128);
        let soft = SoftComparison::new(&outline, &camera, 0.0, &crop, &paper());
        let pairs: Vec<(f64, f64)> = (0..5)
            .map(|k| {
                let yaw_rad = 0.23 + 1.31 * f64::from(k);
                let [behind, ahead] = [-STEP_RAD, STEP_RAD].map(|step| soft.loss(yaw_rad + step).0);
                (soft.loss(yaw_rad).1, (ahead - behind) / (2.0 * STEP_RAD))
            })
            .collect();
        let mut sizes: Vec<f64> = pairs.iter().map(|p| p.1.abs()).collect();
        sizes.sort_by(f64::total_cmp);
        for (told, difference) in pairs {
            errors.push(((told - difference).abs() / difference.abs().max(sizes[2]), name, told, difference));
        }
    }
    errors.sort_by(|a, b| b.0.total_cmp(&a.0));
    // Found: 0.0015 at worst, 0.0002 in the middle.
    assert!(errors[0].0 < 0.01 && errors[errors.len() / 2].0 < 0.002, "{errors:.4?}");
}

#[test]
fn both_solvers_find_the_same_yaws() {
    let both = [settings(), paper()];
    for (name, order, yaw_rad) in [("mug", 1, 0.37), ("spoon", 1, 2.2), ("book", 2, -1.1)] {
        let mesh = built(name);
        let mask = seen(&mesh, DVec3::new(0.11, -0.04, 0.0), yaw_rad);
        let [golden, paper] = both.each_ref().map(|settings| solved(&mesh, &mask, settings));
        let apart_deg = symmetry::representative(golden.yaw_rad - paper.yaw_rad, order).to_degrees().abs();
        let errors_deg = [&golden, &paper].map(|found| error_deg(found, yaw_rad, order));
        assert!(errors_deg.iter().all(|e| *e < 0.5) && apart_deg < 0.5, "{name}: {errors_deg:?}");
        assert_eq!((golden.symmetry_order, paper.symmetry_order), (order, order), "{name}");
        assert_eq!((paper.curve.len(), paper.top.len()), (72, 8));
        assert!(paper.confidence > 0.0 && paper.top.is_sorted_by(|a, b| a.1 <= b.1), "{name}: {paper:?}");
    }
}

/// On whatever adapter there is; the tests of [`crate::render::soft::gpu`] say when there is none.
#[test]
fn a_gpu_finds_the_paper_solver_s_yaw_and_a_lost_one_is_an_error() {
    use crate::render::gpu::{DeviceChoice, Gpu};
    let Ok(Some(gpu)) = Gpu::open(DeviceChoice::Gpu) else { return };
    let (mesh, camera, none) = (built("mug"), camera(), Mask::empty(WIDTH_PX, HEIGHT_PX));
    let mask = seen(&mesh, DVec3::ZERO, 1.0);
    let problem = RotationProblem {
        mesh: &mesh,
        camera: &camera,
        mask: &mask,
        unknown: &none,
        seat_height_m: 0.0,
        picture: None,
    };
    let quick = DroSettings { coarse_yaws: 24, keep: 2, ..paper() };
    let on = |gpu| estimate_yaw_on(gpu, &problem, &quick, &Interrupt::default());
    let (on_gpu, on_cpu) = (on(Some(&gpu)).expect("estimated"), on(None).expect("estimated"));
    for ((yaw_rad, loss), expected) in on_gpu.curve.iter().zip(&on_cpu.curve) {
        assert!(*yaw_rad == expected.0 && (loss - expected.1).abs() < 1e-5, "{loss} {expected:?}");
    }
    assert!((on_gpu.yaw_rad - on_cpu.yaw_rad).abs() < 2e-3, "{} {}", on_gpu.yaw_rad, on_cpu.yaw_rad);
    gpu.give_up("asked to by a test");
    assert!(matches!(on(Some(&gpu)), Err(DroError::Gpu(_))));
}

#[test]
fn threads_do_not_change_the_paper_solver_s_answer_and_requests_to_stop_are_heard() {
    let mesh = built("mug");
    let mask = seen(&mesh, DVec3::ZERO, 1.0);
    let quick = DroSettings { coarse_yaws: 8, keep: 3, ..paper() };
    let with = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
        pool.install(|| solved(&mesh, &mask, &quick))
    };
    assert_eq!(with(1), with(3));
    let (interrupt, camera) = (Interrupt::default(), camera());
    interrupt.raise();
    let unknown = Mask::empty(WIDTH_PX, HEIGHT_PX);
    let problem = RotationProblem {
        mesh: &mesh,
        camera: &camera,
        mask: &mask,
        unknown: &unknown,
        seat_height_m: 0.0,
        picture: None,
    };
    assert!(matches!(estimate_yaw(&problem, &paper(), &interrupt), Err(DroError::Interrupted(_))));
}

/// The mesh in that pose as the renderer paints it under a key light from that side, and its mask.
fn painted(mesh: &TexturedMesh, at: DVec3, yaw_rad: f64, light_rad: f64) -> (Image, Mask) {
    use crate::render::{Background, Lighting, RenderScene, RenderSettings, render};
    let scene = RenderScene {
        objects: vec![RenderObject { mesh, world_from_object: Pose::upright(at, yaw_rad), id: 1 }],
        lighting: Lighting::studio(light_rad, 0.9, 0.4),
        background: Background::light(),
    };
    let quick = RenderSettings { supersampling: 2, shadow_map_px: 256, sky_directions: 0, sky_map_px: 32 };
    let frame = render(&scene, &View::Perspective(camera()), &quick);
    let mask = frame.mask(1);
    (frame.color, mask)
}

fn solved_in_colors(
    mesh: &TexturedMesh,
    (picture, mask): &(Image, Mask),
    settings: &DroSettings,
) -> RotationEstimate {
    let (camera, none) = (camera(), Mask::empty(WIDTH_PX, HEIGHT_PX));
    let problem = RotationProblem {
        mesh,
        camera: &camera,
        mask,
        unknown: &none,
        seat_height_m: 0.0,
        picture: Some(picture),
    };
    estimate_yaw(&problem, settings, &Interrupt::default()).expect("estimated")
}

/// A closed book: cover and spine of one color, pages, and a title across the upper part of the cover.
fn book() -> TexturedMesh {
    use crate::geometry::{Material, Rgb, shapes};
    let mut mesh = TexturedMesh::default();
    mesh.add(shapes::block(DVec3::new(0.15, 0.22, 0.03)), &Material::plain("cover", Rgb::hex(0x28508c), 0.6));
    let title = shapes::block(DVec3::new(0.11, 0.03, 0.0305)).translated(DVec3::new(0.0, 0.06, 0.0));
    mesh.add(title, &Material::plain("title", Rgb::hex(0xe8d8a0), 0.6));
    mesh
}

/// The term's derivative, the appearance alone: on a mug, whose parts are large, and on a book with a title. Where
/// parts are about a pixel large it is coarser: of a keyboard and a laptop it was off by a half in the
/// middle, on pictures twice as fine.
#[test]
fn the_appearance_term_has_the_derivative_it_says() {
    const STEP_RAD: f64 = 1e-3;
    let (camera, none) = (camera(), Mask::empty(WIDTH_PX, HEIGHT_PX));
    let mut errors = Vec::new();
    for (name, mesh) in [("book", book()), ("mug", built("mug"))] {
        let (picture, mask) = painted(&mesh, DVec3::new(0.1, -0.05, 0.0), 0.9, -0.5);
        let bbox = mask.bbox_px().expect("in view");
        let crop = Crop::new(&mask, &none, bbox, 256);
        let outline = OutlineMesh::new(&mesh, 128);
        let problem = RotationProblem {
            mesh: &mesh,
            camera: &camera,
            mask: &mask,
            unknown: &none,
            seat_height_m: 0.0,
            picture: Some(&picture),
        };
        let alone =
            DroSettings { silhouette_weight: 0.0, edge_weight: 0.0, descriptor_weight: 1.0, ..paper() };
        let soft = SoftComparison::new(&outline, &camera, 0.0, &crop, &alone);
        let term = AppearanceTerm::new(&problem, &picture, &outline, bbox, soft.surface(), &alone);
        let soft = soft.with_appearance(term);
        let pairs: Vec<(f64, f64)> = (0..5)
            .map(|k| {
                let yaw_rad = 0.23 + 1.31 * f64::from(k);
                let [behind, ahead] = [-STEP_RAD, STEP_RAD].map(|step| soft.loss(yaw_rad + step).0);
                (soft.loss(yaw_rad).1, (ahead - behind) / (2.0 * STEP_RAD))
            })
            .collect();
        let mut sizes: Vec<f64> = pairs.iter().map(|p| p.1.abs()).collect();
        sizes.sort_by(f64::total_cmp);
        for (told, difference) in pairs {
            errors.push(((told - difference).abs() / difference.abs().max(sizes[2]), name, told, difference));
        }
    }
    errors.sort_by(|a, b| b.0.total_cmp(&a.0));
    // Found: 3.7 (a jump between the two looks of the difference), 0.8, 0.4, 0.3, 0.26, the others below 0.07.
    assert!(errors[errors.len() / 2].0 < 0.3 && errors[1].0 < 1.0, "{errors:.4?}");
}

/// Without the choice among equal outlines: the loss itself knows the side.
#[test]
fn the_paper_solver_finds_the_side_by_its_loss() {
    let (mesh, at) = (book(), DVec3::new(0.02, 0.03, 0.0));
    for (yaw_rad, light_rad) in [(0.6, -0.5), (0.6 - std::f64::consts::PI, 1.4)] {
        let seen = painted(&mesh, at, yaw_rad, light_rad);
        let found = solved_in_colors(&mesh, &seen, &paper());
        assert!(error_deg(&found, yaw_rad, 1) < 0.5, "{yaw_rad}: {}", found.yaw_rad);
        assert_eq!(found.symmetry_order, 1);
        let other_side = |c: &&(f64, f64)| wrap_angle_rad(c.0 - yaw_rad).abs() > 2.5;
        let opposite = found.curve.iter().filter(other_side).map(|c| c.1).fold(f64::INFINITY, f64::min);
        assert!(opposite > found.loss + 0.01, "{opposite} {}", found.loss);
        let blind = DroSettings { descriptor_weight: 0.0, ..paper() };
        let outline_only = solved(&mesh, &seen.1, &blind);
        assert_eq!(outline_only.symmetry_order, 2);
    }
    half_turns_of_a_block_with_a_badge(0xb02020, &paper(), 1);
}

/// The title's half is hidden by something that looks like the other half.
#[test]
fn what_hides_a_part_has_no_color() {
    let (mesh, at, yaw_rad) = (book(), DVec3::new(0.02, 0.03, 0.0), 0.4);
    let (mut picture, whole) = painted(&mesh, at, yaw_rad, -0.5);
    let [x0, y0, x1, y1] = whole.bbox_px().expect("in view");
    let hides = |x: u32, y: u32| x > (x0 + x1) / 2 && y < y0 + (y1 - y0) / 3;
    let unknown = Mask::from_fn(WIDTH_PX, HEIGHT_PX, hides);
    let visible = Mask::from_fn(WIDTH_PX, HEIGHT_PX, |x, y| whole.contains(x, y) && !hides(x, y));
    let camera = camera();
    let mut found = Vec::new();
    for color in [[40, 80, 140, 255], [232, 216, 160, 255]] {
        for (x, y) in (0..HEIGHT_PX).flat_map(|y| (0..WIDTH_PX).map(move |x| (x, y))) {
            if hides(x, y) {
                picture.set_pixel(x, y, color);
            }
        }
        let problem = RotationProblem {
            mesh: &mesh,
            camera: &camera,
            mask: &visible,
            unknown: &unknown,
            seat_height_m: 0.0,
            picture: Some(&picture),
        };
        found.push(estimate_yaw(&problem, &paper(), &Interrupt::default()).expect("estimated"));
    }
    assert!(error_deg(&found[0], yaw_rad, 1) < 2.0, "{}", found[0].yaw_rad);
    assert_eq!(found[0], found[1]);
}

/// `cargo test --lib -- --ignored --nocapture solvers_cost`: seconds of one thread and degrees off, each
/// solver; the third with the picture in its loss.
#[test]
#[ignore = "a measurement"]
fn what_the_solvers_cost() {
    use std::time::Instant;
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("a thread");
    for (k, &(name, order)) in DOZEN.iter().enumerate() {
        let yaw_rad = wrap_angle_rad(0.37 + 0.71 * k as f64);
        let at = DVec3::new(0.16 - 0.05 * (k % 6) as f64, 0.1 - 0.07 * (k % 4) as f64, 0.0);
        let mesh = built(name);
        let seen = painted(&mesh, at, yaw_rad, -0.5);
        let measured = [(settings(), false), (paper(), false), (paper(), true)].map(|(settings, colors)| {
            let begun = Instant::now();
            let found = pool.install(|| match colors {
                true => solved_in_colors(&mesh, &seen, &settings),
                false => solved(&mesh, &seen.1, &settings),
            });
            let secs = begun.elapsed().as_secs_f64();
            let off_deg = error_deg(&found, yaw_rad, if colors { 1 } else { order });
            format!(
                "{secs:.2} s, off {off_deg:.3}, loss {:.4}, symmetry {}, confidence {:.2}",
                found.loss, found.symmetry_order, found.confidence
            )
        });
        eprintln!("{name}, {} triangles: {}", mesh.triangle_count(), measured.join(" | "));
    }
}

/// `cargo test --lib -- --ignored --nocapture weight_of_the_descriptor`: degrees off, per weight, with the light where
/// the term has it and with light from the other side.
#[test]
#[ignore = "a measurement"]
fn which_weight_of_the_descriptor_suits() {
    for light_rad in [-0.4, 1.8] {
        for weight in [0.0, 0.05, 0.2, 0.5, 2.0] {
            let few = DroSettings { descriptor_weight: weight, keep: 4, ..paper() };
            let mut errors: Vec<(f64, &str)> = DOZEN
                .par_iter()
                .enumerate()
                .map(|(k, &(name, _))| {
                    let yaw_rad = wrap_angle_rad(0.37 + 0.71 * k as f64);
                    let at = DVec3::new(0.16 - 0.05 * (k % 6) as f64, 0.1 - 0.07 * (k % 4) as f64, 0.0);
                    let mesh = built(name);
                    let found = solved_in_colors(&mesh, &painted(&mesh, at, yaw_rad, light_rad), &few);
                    (error_deg(&found, yaw_rad, 1), name)
                })
                .collect();
            errors.sort_by(|a, b| a.0.total_cmp(&b.0));
            let median = 0.5 * (errors[5].0 + errors[6].0);
            eprintln!("light {light_rad}, weight {weight}: median {median:.3}, worst {:.2?}", &errors[9..]);
        }
    }
}
