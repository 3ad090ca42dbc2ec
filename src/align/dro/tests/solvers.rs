//! The paper's solver: its loss has the derivative it says, and it agrees with the default on known yaws.

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
    use crate::render::soft::gpu::{DeviceChoice, Gpu};
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

/// `cargo test --lib -- --ignored --nocapture solvers_cost`: seconds of one thread and degrees off, each
/// solver.
#[test]
#[ignore = "a measurement"]
fn what_the_solvers_cost() {
    use std::time::Instant;
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("a thread");
    for (k, &(name, order)) in DOZEN.iter().enumerate() {
        let yaw_rad = wrap_angle_rad(0.37 + 0.71 * k as f64);
        let at = DVec3::new(0.16 - 0.05 * (k % 6) as f64, 0.1 - 0.07 * (k % 4) as f64, 0.0);
        let mesh = built(name);
        let mask = seen(&mesh, at, yaw_rad);
        let measured = [settings(), paper()].map(|settings| {
            let begun = Instant::now();
            let found = pool.install(|| solved(&mesh, &mask, &settings));
            let secs = begun.elapsed().as_secs_f64();
            let off_deg = error_deg(&found, yaw_rad, order);
            format!(
                "{secs:.2} s, off {off_deg:.3}, loss {:.4}, symmetry {}, confidence {:.2}",
                found.loss, found.symmetry_order, found.confidence
            )
        });
        eprintln!("{name}, {} triangles: {}", mesh.triangle_count(), measured.join(" | "));
    }
}
