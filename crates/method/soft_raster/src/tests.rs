//! Soft silhouettes agree with the reference in value and derivative, and with the published soft rasterizer.

use glam::DVec2;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::loss::terms;
use super::turntable::{Turntable, random_object};
use super::*;

const SIDE_PX: usize = 64;
const SIGMA_PX2: f32 = 1.0;

fn rng() -> ChaCha8Rng {
    ChaCha8Rng::seed_from_u64(7)
}

fn drawn(object: &Turntable, yaw_rad: f64, sigma_px2: f32) -> SoftSilhouette<1> {
    let mut drawn = SoftSilhouette::default();
    drawn.draw(&object.surface(), &object.points(yaw_rad), Grid::square(object.side_px), sigma_px2);
    drawn
}

fn still(points: &[[f32; 2]]) -> Vec<MovingPoint<0>> {
    points.iter().map(|&at_px| MovingPoint { at_px, slopes: [] }).collect()
}

#[test]
fn soft_result_agrees_with_reference() {
    let mut rng = rng();
    for kind in 0..25 {
        let object = random_object(&mut rng, kind, SIDE_PX);
        let yaw_rad = rng.random_range(0.0..6.3);
        let exact = reference::coverage(&object.faces(yaw_rad), SIDE_PX, SIDE_PX, f64::from(SIGMA_PX2));
        let fast = drawn(&object, yaw_rad, SIGMA_PX2);
        let worst = fast.coverage().iter().zip(&exact).map(|(f, e)| (f64::from(*f) - e).abs());
        let worst = worst.fold(0.0, f64::max);
        assert!(worst < 1e-3, "kind {kind}: {worst}");
        let planes = object.planes(yaw_rad + 0.4, |x, y| x + y < SIDE_PX / 2);
        let found = terms(&fast, &planes.target(SIDE_PX));
        let side_px = SIDE_PX as f64;
        let (silhouette, edge) =
            reference::terms(&exact, SIDE_PX, &planes.mask, &planes.known, &planes.distance_px, side_px);
        assert!((found.silhouette.value - silhouette).abs() < 1e-4, "{found:?} {silhouette}");
        assert!((found.edge.value - edge).abs() < 1e-4, "{found:?} {edge}");
    }
}

/// 25 objects, 5 yaws each: the weighted loss's derivative against central differences of the reference.
#[test]
fn derivatives_agree_with_central_differences_of_reference() {
    const YAWS: usize = 5;
    const STEP_RAD: f64 = 2e-6;
    let mut rng = rng();
    let (mut worst, mut errors) = (0.0_f64, Vec::new());
    for kind in 0..25 {
        let object = random_object(&mut rng, kind, SIDE_PX);
        let planes = object.planes(rng.random_range(0.0..6.3), |x, y| x > 40 && y > 40);
        let target = planes.target(SIDE_PX);
        let loss = |yaw_rad: f64| {
            let sigma_px2 = f64::from(SIGMA_PX2);
            let soft = reference::coverage(&object.faces(yaw_rad), SIDE_PX, SIDE_PX, sigma_px2);
            let (mask, known, distance_px) = (&planes.mask, &planes.known, &planes.distance_px);
            let (s, e) = reference::terms(&soft, SIDE_PX, mask, known, distance_px, target.side_px);
            0.5 * s + 0.5 * e
        };
        let pairs: Vec<(f64, f64)> = (0..YAWS)
            .map(|_| {
                let yaw_rad = rng.random_range(0.0..6.3);
                let difference = (loss(yaw_rad + STEP_RAD) - loss(yaw_rad - STEP_RAD)) / (2.0 * STEP_RAD);
                let found = terms(&drawn(&object, yaw_rad, SIGMA_PX2), &target).weighted(0.5, 0.5);
                (found.slopes[0], difference)
            })
            .collect();
        let mut sizes: Vec<f64> = pairs.iter().map(|p| p.1.abs()).collect();
        sizes.sort_by(f64::total_cmp);
        for (found, difference) in pairs {
            let error = (found - difference).abs() / difference.abs().max(sizes[YAWS / 2]);
            errors.push((error, kind));
            worst = worst.max(error);
        }
    }
    errors.sort_by(|a, b| b.0.total_cmp(&a.0));
    eprintln!("relative errors, worst first: {:.5?}, median {:.6}", &errors[..6], errors[62].0);
    assert!(worst < 0.01, "{:?}", &errors[..10]);
}

/// Yaw and elevation together: each plane is what it is alone, and elevation's is right.
#[test]
fn derivatives_by_two_parameters_are_independent() {
    const STEP_RAD: f64 = 1e-6;
    let mut rng = rng();
    for kind in 0..5 {
        let mut object = random_object(&mut rng, kind, SIDE_PX);
        let (yaw_rad, elevation_rad) = (rng.random_range(0.0..6.3), object.elevation_rad);
        let planes = object.planes(yaw_rad + 0.3, |_, _| false);
        let by_yaw = object.points(yaw_rad);
        let alone = drawn(&object, yaw_rad, SIGMA_PX2);
        let mut at = |step_rad: f64| {
            object.elevation_rad = elevation_rad + step_rad;
            let soft = reference::coverage(&object.faces(yaw_rad), SIDE_PX, SIDE_PX, f64::from(SIGMA_PX2));
            let (mask, known, distance_px) = (&planes.mask, &planes.known, &planes.distance_px);
            let terms = reference::terms(&soft, SIDE_PX, mask, known, distance_px, SIDE_PX as f64);
            (object.projected(yaw_rad), terms)
        };
        let ((low, low_terms), (high, high_terms)) = (at(-STEP_RAD), at(STEP_RAD));
        let slope = |low: f64, high: f64| (high - low) / (2.0 * STEP_RAD);
        let points: Vec<MovingPoint<2>> = (by_yaw.iter().zip(low.iter().zip(&high)))
            .map(|(p, (low, high))| {
                let by_elevation = ((high.0 - low.0) / (2.0 * STEP_RAD)).as_vec2();
                MovingPoint { at_px: p.at_px, slopes: [p.slopes[0], by_elevation.into()] }
            })
            .collect();
        let mut both = SoftSilhouette::<2>::default();
        both.draw(&object.surface(), &points, Grid::square(SIDE_PX), SIGMA_PX2);
        assert_eq!(both.slopes()[0], alone.slopes()[0]);
        let found = terms(&both, &planes.target(SIDE_PX));
        for (found, exact) in [
            (found.silhouette.slopes[1], slope(low_terms.0, high_terms.0)),
            (found.edge.slopes[1], slope(low_terms.1, high_terms.1)),
        ] {
            assert!((found - exact).abs() < 0.01 * exact.abs().max(0.01), "kind {kind}: {found} {exact}");
        }
    }
}

#[test]
fn bits_do_not_depend_on_thread_count() {
    let object = random_object(&mut rng(), 4, 128);
    let with = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        pool.install(|| {
            let drawn = drawn(&object, 0.7, SIGMA_PX2);
            (drawn.coverage().to_vec(), drawn.slopes().clone())
        })
    };
    assert_eq!(with(1), with(3));
}

#[test]
fn single_triangle_equals_published_soft_rasterizer() {
    let corners = [[10.3, 8.1], [50.2, 20.7], [22.8, 55.5]];
    let mut drawn = SoftSilhouette::<0>::default();
    drawn.draw(&Surface::new(&[[0, 1, 2]]), &still(&corners), Grid::square(64), 2.0);
    let face = corners.map(|[x, y]| DVec2::new(f64::from(x), f64::from(y)));
    let theirs = reference::coverage_by_product(&[face], 64, 64, 2.0);
    for (ours, theirs) in drawn.coverage().iter().zip(&theirs) {
        assert!((f64::from(*ours) - theirs).abs() < 2e-4, "{ours} {theirs}");
    }
}

/// The product over faces depends on the triangulation: it dents inside and swells outside with the number of faces.
#[test]
fn coverage_does_not_depend_on_triangulation() {
    let (n, low, size) = (8_u32, 12.3_f32, 40.0_f32);
    let at = |k: u32| low + size * k as f32 / n as f32;
    let points: Vec<[f32; 2]> = (0..(n + 1) * (n + 1)).map(|k| [at(k % (n + 1)), at(k / (n + 1))]).collect();
    let fine: Vec<[u32; 3]> = (0..n * n)
        .map(|k| k / n * (n + 1) + k % n)
        .flat_map(|a| [[a, a + 1, a + n + 2], [a, a + n + 2, a + n + 1]])
        .collect();
    let corners = [0, n, (n + 1) * (n + 1) - 1, n * (n + 1)];
    let coarse = [[corners[0], corners[1], corners[2]], [corners[0], corners[2], corners[3]]];
    let draw = |triangles: &[[u32; 3]]| {
        let mut drawn = SoftSilhouette::<0>::default();
        drawn.draw(&Surface::new(triangles), &still(&points), Grid::square(64), SIGMA_PX2);
        drawn.coverage().to_vec()
    };
    let (fine_drawn, coarse_drawn) = (draw(&fine), draw(&coarse));
    for (a, b) in fine_drawn.iter().zip(&coarse_drawn) {
        assert!((a - b).abs() < 1e-4, "{a} {b}");
    }
    let face = |t: &[u32; 3]| t.map(|v| DVec2::from(points[v as usize].map(f64::from)));
    let faces: Vec<[DVec2; 3]> = fine.iter().map(face).collect();
    let product = reference::coverage_by_product(&faces, 64, 64, f64::from(SIGMA_PX2));
    let center = 32 * 64 + 20..32 * 64 + 44;
    let dent = product[center.clone()].iter().fold(1.0_f64, |a, &b| a.min(b));
    assert!(dent < 0.9 && fine_drawn[center].iter().all(|&s| s > 0.999), "{dent}");
    // A surface seen twice, front and back, is one silhouette.
    let both: Vec<[u32; 3]> = fine.iter().flat_map(|&[a, b, c]| [[a, b, c], [a, c, b]]).collect();
    assert_eq!(draw(&both), fine_drawn);
}

#[test]
fn small_sigma_gives_hard_silhouette() {
    let object = random_object(&mut rng(), 4, SIDE_PX);
    let faces = object.faces(0.3);
    let hard = reference::coverage(&faces, SIDE_PX, SIDE_PX, 1e-12);
    let area = |soft: &[f32]| soft.iter().map(|&s| f64::from(s)).sum::<f64>();
    let exact_area: f64 = hard.iter().sum();
    for sigma_px2 in [0.3, 0.03, 1e-3] {
        let soft = drawn(&object, 0.3, sigma_px2);
        let outline = reference::outline(&faces);
        let mut far = 0;
        for (at, (&s, &h)) in soft.coverage().iter().zip(&hard).enumerate() {
            let p = DVec2::new((at % SIDE_PX) as f64 + 0.5, (at / SIDE_PX) as f64 + 0.5);
            let distance = |[a, b]: &[DVec2; 2]| {
                let t = ((p - *a).dot(*b - *a) / (*b - *a).length_squared()).clamp(0.0, 1.0);
                p.distance(a.lerp(*b, t))
            };
            if outline.iter().map(distance).fold(f64::INFINITY, f64::min) > f64::from(3.1 * sigma_px2.sqrt())
            {
                far += 1;
                assert!((f64::from(s) - h).abs() < 1e-4);
            }
        }
        assert!(far > SIDE_PX * SIDE_PX / 2);
        let length: f64 = outline.iter().map(|[a, b]| a.distance(*b)).sum();
        let off = (area(soft.coverage()) - exact_area).abs();
        assert!(off < 0.1 * length * f64::from(sigma_px2.sqrt()) + 1.5, "{sigma_px2}: {off} of {length}");
    }
}

#[test]
fn surface_beyond_image_is_drawn_up_to_border() {
    let corners = [[-500.0, -300.0], [40.0, 20.0], [-200.0, 900.0], [-5000.0, 30.0]];
    let triangles = [[0, 1, 2], [0, 2, 3]];
    let mut drawn = SoftSilhouette::<0>::default();
    drawn.draw(&Surface::new(&triangles), &still(&corners), Grid::square(64), SIGMA_PX2);
    let face = |t: &[u32; 3]| t.map(|v| DVec2::from(corners[v as usize].map(f64::from)));
    let exact = reference::coverage(&triangles.map(|t| face(&t)), 64, 64, f64::from(SIGMA_PX2));
    for (ours, exact) in drawn.coverage().iter().zip(&exact) {
        assert!((f64::from(*ours) - exact).abs() < 1e-3, "{ours} {exact}");
    }
    let gone = still(&[[900.0, 1.0], [950.0, 3.0], [910.0, 80.0]]);
    drawn.draw(&Surface::new(&[[0, 1, 2]]), &gone, Grid::square(64), SIGMA_PX2);
    assert!(drawn.coverage().iter().all(|&s| s == 0.0));
    drawn.draw(&Surface::new(&[]), &[], Grid::square(64), SIGMA_PX2);
    assert!(drawn.coverage().iter().all(|&s| s == 0.0));
}
