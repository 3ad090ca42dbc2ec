//! Scores computed by hand; layouts drawn as boxes and recovered.

use glam::DVec3;
use proptest::prelude::*;

use super::*;
use geometry::{Material, Rgb, shapes};

fn settings() -> TopViewSettings {
    TopViewSettings {
        scale: TopViewScale::Anchor,
        tau: 0.25,
        strong_deviation: 0.3,
        size_spread: 0.1,
        origin: TopViewOrigin::Table,
        camera_spread: 0.05,
    }
}

fn plain(w: f64, h: f64) -> Footprint {
    let half = 0.5 * DVec2::new(w, h);
    Footprint { low_m: -half, high_m: half }
}

fn instance(box_px: BoxPx, footprint: Footprint) -> TopViewInstance {
    TopViewInstance { box_px, footprint, may_anchor: true, seen_m: None }
}

#[test]
fn rma_scores_match_manual_values() {
    // A plausible 100 x 50 box, and one twice as large whose footprint is square: e = ln 2.
    let problem = TopViewProblem {
        table_box_px: [0.0, 0.0, 1000.0, 600.0],
        table_size_m: DVec2::new(1.0, 0.6),
        instances: vec![
            instance([100.0, 100.0, 200.0, 150.0], plain(0.2, 0.1)),
            instance([300.0, 100.0, 440.0, 170.0], plain(0.2, 0.2)),
        ],
        meters_per_px: None,
    };
    let layout = align_top_view(&problem, &settings()).expect("aligned");
    assert!((layout.rma_scores[0] - 5000.0).abs() < 1e-9);
    let e = 2.0_f64.ln() / 0.25;
    assert!((layout.rma_scores[1] - 9800.0 / (1.0 + e * e)).abs() < 1e-9);
    assert_eq!(layout.anchor, Some(0));
    assert!((layout.alpha_m_per_px - 0.002).abs() < 1e-12);
    // The table's box is twice its commonsense size; image y points down.
    assert!(layout.table_rescaled && (layout.table_size_m - DVec2::new(2.0, 1.2)).length() < 1e-9);
    assert!((layout.instances[0].xy_m - DVec2::new(-0.7, 0.35)).length() < 1e-9);
    // With a given scale there is no anchor.
    let given = TopViewProblem { meters_per_px: Some(0.001), ..problem.clone() };
    let layout = align_top_view(&given, &settings()).expect("aligned");
    assert_eq!((layout.anchor, layout.table_rescaled), (None, false));
    assert!(layout.instances[0].rescaled && (layout.instances[0].scale - 0.5).abs() < 1e-9);
    // The table never sets the scale while an object can.
    let doubtful = TopViewInstance { may_anchor: false, ..problem.instances[0] };
    let alone = TopViewProblem { instances: vec![doubtful], ..problem };
    let layout = align_top_view(&alone, &settings()).expect("aligned");
    assert!(layout.anchor.is_none() && (layout.alpha_m_per_px - 0.001).abs() < 1e-12);
}

/// Ten blocks on boxes of their true size; the first is three times the area of any other and its
/// commonsense size is a quarter too large, the others' are a little off.
#[test]
fn consensus_scale_ignores_one_large_wrong_size() {
    let alpha = 0.002;
    let off = [1.25, 0.97, 1.04, 1.0, 0.95, 1.02, 0.99, 1.05, 0.96, 1.01];
    let instances = off.iter().enumerate().map(|(k, off)| {
        let (w, d) = if k == 0 { (0.36, 0.24) } else { (0.18, 0.1 + 0.01 * k as f64) };
        let at = DVec2::new(100.0 * k as f64, 0.0);
        let corner = at + DVec2::new(w, d) / alpha;
        instance([at.x, at.y, corner.x, corner.y], plain(off * w, off * d))
    });
    let problem = TopViewProblem {
        table_box_px: [0.0, 0.0, 1100.0, 500.0],
        table_size_m: DVec2::new(2.2, 1.0),
        instances: instances.collect(),
        meters_per_px: None,
    };
    let with = |scale| {
        align_top_view(&problem, &TopViewSettings { scale, ..settings() }).expect("aligned").alpha_m_per_px
    };
    assert!((with(TopViewScale::Anchor) / alpha - 1.25).abs() < 1e-9);
    assert!((with(TopViewScale::Consensus) / alpha - 1.0).abs() < 0.02);
    // Boxes of exactly the right shape are more accurate than every size.
    let voted = align_top_view(&problem, &TopViewSettings { scale: TopViewScale::Consensus, ..settings() });
    let voted = voted.expect("aligned");
    for (found, off) in voted.instances.iter().zip(off) {
        assert!((found.scale * off - 1.0).abs() < 0.03, "{} of {off}", found.scale);
    }
    let consensus = voted.consensus.expect("they voted");
    assert!((0.02..0.08).contains(&consensus.size_spread) && consensus.log_alpha_error < 0.02);
}

/// The table's box is read 3 % of its width too far right; the camera saw every object where it is.
#[test]
fn sightings_correct_shifted_table_box() {
    let alpha = 0.002;
    let at_m = |k: usize| DVec2::new(-0.4 + 0.1 * k as f64, 0.07 * (k % 3) as f64 - 0.1);
    let instances = (0..9).map(|k| {
        let extent = DVec2::new(0.06, 0.04 + 0.005 * k as f64);
        let low_px = DVec2::new(500.0 + at_m(k).x / alpha, 300.0 - at_m(k).y / alpha) - 0.5 * extent / alpha;
        let high_px = low_px + extent / alpha;
        let seen = instance([low_px.x, low_px.y, high_px.x, high_px.y], plain(extent.x, extent.y));
        TopViewInstance { seen_m: Some(at_m(k)), ..seen }
    });
    let problem = TopViewProblem {
        table_box_px: [18.0, 50.0, 1018.0, 550.0],
        table_size_m: DVec2::new(2.0, 1.0),
        instances: instances.collect(),
        meters_per_px: None,
    };
    let worst_m = |origin| {
        let settings = TopViewSettings { origin, scale: TopViewScale::Consensus, ..settings() };
        let layout = align_top_view(&problem, &settings).expect("aligned");
        (0..9).map(|k| (layout.instances[k].xy_m - at_m(k)).length()).fold(0.0, f64::max)
    };
    assert!((worst_m(TopViewOrigin::Table) - 0.036).abs() < 1e-3);
    assert!(worst_m(TopViewOrigin::Sightings) < 0.004, "{}", worst_m(TopViewOrigin::Sightings));
    // An object without a sighting is positioned by the table's box.
    let unseen = problem.instances.iter().map(|seen| TopViewInstance { seen_m: None, ..*seen }).collect();
    let unseen = TopViewProblem { instances: unseen, ..problem.clone() };
    let settings =
        TopViewSettings { origin: TopViewOrigin::Sightings, scale: TopViewScale::Consensus, ..settings() };
    assert_eq!(align_top_view(&unseen, &settings).expect("aligned").registered, None);
}

#[test]
fn align_top_view_rejects_invalid_input() {
    let good = TopViewProblem {
        table_box_px: [0.0, 0.0, 10.0, 10.0],
        table_size_m: DVec2::ONE,
        instances: vec![instance([1.0, 1.0, 2.0, 2.0], plain(0.1, 0.1))],
        meters_per_px: None,
    };
    let with = |change: fn(&mut TopViewProblem)| {
        let mut problem = good.clone();
        change(&mut problem);
        align_top_view(&problem, &settings())
    };
    assert!(with(|_| ()).is_ok());
    assert_eq!(with(|p| p.table_box_px[2] = 0.0), Err(TopViewError::NoTableBox));
    assert_eq!(with(|p| p.instances[0].box_px = [1.0, 1.0, f64::NAN, 2.0]), Err(TopViewError::NoBox(0)));
    assert_eq!(with(|p| p.instances[0].footprint = plain(0.0, 0.1)), Err(TopViewError::NoFootprint(0)));
    assert_eq!(with(|p| p.meters_per_px = Some(-1.0)), Err(TopViewError::NoScale(-1.0)));
}

#[test]
fn footprint_of_round_object_keeps_width_at_any_yaw() {
    let mut mesh = TexturedMesh::default();
    mesh.add(shapes::cylinder(0.1, 0.02, 0.0, 48), &Material::plain("clay", Rgb::hex(0xc08060), 0.8));
    let turned = footprint(&mesh, 0.785);
    assert!(((turned.high_m - turned.low_m) - DVec2::splat(0.2)).length() < 0.002);
}

proptest! {
    /// Boxes drawn from a known layout give the layout back, whatever the scale.
    #[test]
    fn align_top_view_recovers_drawn_layout(
        alpha in 0.0005..0.004_f64,
        objects in proptest::collection::vec((-0.5..0.5_f64, -0.3..0.3_f64, 0.03..0.3_f64, 0.03..0.3_f64, -3.0..3.0_f64), 1..12),
    ) {
        let origin = DVec2::new(512.0, 384.0);
        let to_px = |p: DVec2| origin + DVec2::new(p.x, -p.y) / alpha;
        let boxed = |low: DVec2, high: DVec2| {
            let (a, b) = (to_px(low), to_px(high));
            [a.x, b.y, b.x, a.y]
        };
        let table = DVec2::new(1.4, 0.8);
        let mut instances = Vec::new();
        for &(x, y, w, d, yaw) in &objects {
            let mut mesh = TexturedMesh::default();
            // Off-center on purpose: a turned mesh's box is not centered on its origin.
            let block = shapes::block(DVec3::new(w, d, 0.1)).translated(DVec3::new(0.3 * w, 0.0, 0.0));
            mesh.add(block, &Material::plain("wood", Rgb::hex(0x806040), 0.8));
            let seen = footprint(&mesh, yaw);
            let at = DVec2::new(x, y);
            instances.push(instance(boxed(at + seen.low_m, at + seen.high_m), seen));
        }
        let problem = TopViewProblem {
            table_box_px: boxed(-0.5 * table, 0.5 * table),
            table_size_m: table,
            instances,
            meters_per_px: None,
        };
        for scale in [TopViewScale::Anchor, TopViewScale::Consensus] {
            let settings = TopViewSettings { scale, ..settings() };
            let layout = align_top_view(&problem, &settings).expect("aligned");
            prop_assert!((layout.alpha_m_per_px / alpha - 1.0).abs() < 1e-9);
            prop_assert!(!layout.table_rescaled);
            for (found, &(x, y, ..)) in layout.instances.iter().zip(&objects) {
                prop_assert!((found.xy_m - DVec2::new(x, y)).length() < 1e-6 && !found.rescaled);
                prop_assert!((found.scale - 1.0).abs() < 1e-9);
            }
        }
    }
}
