//! Means, CSV and page of a small table by hand.

use super::*;
use crate::perceptual_models::MissingWeights;
use crate::scores::{BestView, MetricScores};
use crate::sweep::SweepView;
use scene::Metrics;

fn measured(best: f64, mean: f64) -> MetricOutcome {
    let view = SweepView { elevation_deg: 20, distance_radii: 1.8 };
    MetricOutcome::Measured(MetricScores {
        best: BestView { view, score: best },
        mean,
        views: vec![best, mean],
    })
}

fn row(scene: &str, lpips: Option<(f64, f64)>, colliding_pairs: usize) -> SceneRow {
    let scores = lpips.map(|(best, mean)| SceneScores {
        lpips: measured(best, mean),
        dinov2: measured(0.8, 0.6),
        clip: MetricOutcome::MissingWeights(MissingWeights { file: "clip/model.safetensors".to_owned() }),
    });
    let col_o = colliding_pairs as f64 / 10.0;
    let col_s = if colliding_pairs > 0 { 1.0 } else { 0.0 };
    let metrics = Metrics { col_o, col_s, ss: 1.0, dss_aligned: 0.5, dss_shipped: 1.0 };
    SceneRow {
        scene: scene.to_owned(),
        scores,
        physics: ScenePhysics { metrics, pairs: 10, colliding_pairs },
    }
}

fn table() -> EvaluationTable {
    let rows = vec![
        row("tea, \"late\"", Some((0.4, 0.5)), 1),
        row("desk", Some((0.2, 0.4)), 0),
        row("text", None, 0),
    ];
    EvaluationTable::new(rows, LpipsNetwork::AlexNet, Vec::new())
}

#[test]
fn means_are_over_scenes_that_have_the_number() {
    let table = table();
    let lpips = table.means.lpips.expect("two scenes have it");
    assert_eq!(lpips.scenes, 2);
    assert!((lpips.best - 0.3).abs() < 1e-12 && (lpips.mean - 0.45).abs() < 1e-12);
    assert_eq!(table.means.clip, None);
    let physics = table.means.physics.expect("has scenes");
    assert_eq!(physics.scenes, 3);
    assert!((physics.col_o - 0.1 / 3.0).abs() < 1e-12 && (physics.col_s - 1.0 / 3.0).abs() < 1e-12);
    let nothing = EvaluationTable::new(Vec::new(), LpipsNetwork::Vgg16, Vec::new());
    assert_eq!((nothing.means.lpips, nothing.means.physics), (None, None));
    assert_eq!(nothing.protocol.lpips_network, "vgg16");
}

#[test]
fn document_is_read_back_equal() {
    let table = table();
    let json = serde_json::to_string(&table).expect("JSON");
    assert!(json.contains(r#""best":{"elevation_deg":20,"distance_radii":1.8,"score":0.4}"#), "{json}");
    let read: EvaluationTable = serde_json::from_str(&json).expect("the same form");
    assert_eq!(read, table);
}

#[test]
fn csv_has_empty_cells_for_missing_numbers() {
    let text = table().csv();
    let lines: Vec<&str> = text.split_terminator("\r\n").collect();
    assert_eq!(lines.len(), 5);
    assert!(
        lines[0]
            .starts_with("scene,lpips_best,lpips_best_elevation_deg,lpips_best_distance_radii,lpips_mean,")
    );
    let first = r#""tea, ""late""",0.400000,20,1.8,0.500000,0.800000,20,1.8,0.600000,,,,,0.100000,1.000000,"#;
    assert!(lines[1].starts_with(first), "{}", lines[1]);
    assert_eq!(lines[3], "text,,,,,,,,,,,,,0.000000,0.000000,1.000000,0.500000,1.000000");
    assert!(
        lines[4].starts_with("mean,0.300000,,,0.450000,0.800000,,,0.600000,,,,,0.033333,"),
        "{}",
        lines[4]
    );
    for line in &lines[2..] {
        assert_eq!(line.split(',').count(), 18, "{line}");
    }
}

#[test]
fn page_escapes_names_and_names_missing_files() {
    let mut table = table();
    table.scenes[1].scene = "<script>".to_owned();
    let page = table.html();
    assert!(page.contains("<bdi>&lt;script&gt;</bdi>") && !page.contains("<script>"), "{page}");
    assert!(
        page.contains("CLIP has no numbers: the file clip/model.safetensors of its weights is missing."),
        "{page}"
    );
    assert!(page.contains(">0.4500<") && page.contains(">3.33<") && page.contains(">33.33<"), "{page}");
}
