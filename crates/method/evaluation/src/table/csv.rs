//! The table as comma-separated values (RFC 4180), for spreadsheets and scripts.

use super::EvaluationTable;
use crate::perceptual_models::Metric;

/// Rates of the last columns. `col_o` of the last line is the mean over scenes.
const PHYSICS: [&str; 5] = ["col_o", "col_s", "ss", "dss_aligned", "dss_shipped"];

/// The whole file; lines end with CR LF.
pub(super) fn text(table: &EvaluationTable) -> String {
    let mut header = vec!["scene".to_owned()];
    for metric in Metric::ALL {
        let columns = ["best", "best_elevation_deg", "best_distance_radii", "mean"];
        header.extend(columns.map(|column| format!("{}_{column}", metric.name())));
    }
    header.extend(PHYSICS.map(str::to_owned));
    let mut lines = vec![header];
    for row in &table.scenes {
        let mut cells = vec![row.scene.clone()];
        for metric in Metric::ALL {
            cells.extend(match row.scores.as_ref().and_then(|scores| scores.of(metric).measured()) {
                Some(scores) => {
                    let view = scores.best.view;
                    let [score, mean] = [scores.best.score, scores.mean].map(number);
                    [score, view.elevation_deg.to_string(), view.distance_radii.to_string(), mean]
                }
                None => [const { String::new() }; 4],
            });
        }
        let metrics = row.physics.metrics;
        let rates = [metrics.col_o, metrics.col_s, metrics.ss, metrics.dss_aligned, metrics.dss_shipped];
        cells.extend(rates.map(number));
        lines.push(cells);
    }
    lines.push(means(table));
    let line =
        |cells: Vec<String>| cells.iter().map(|cell| quoted(cell)).collect::<Vec<_>>().join(",") + "\r\n";
    lines.into_iter().map(line).collect()
}

fn means(table: &EvaluationTable) -> Vec<String> {
    let mut cells = vec!["mean".to_owned()];
    for metric in Metric::ALL {
        cells.extend(match table.means.of(metric) {
            Some(means) => [number(means.best), String::new(), String::new(), number(means.mean)],
            None => [const { String::new() }; 4],
        });
    }
    cells.extend(match &table.means.physics {
        Some(rates) => [rates.col_o, rates.col_s, rates.ss, rates.dss_aligned, rates.dss_shipped].map(number),
        None => PHYSICS.map(|_| String::new()),
    });
    cells
}

fn number(value: f64) -> String {
    format!("{value:.6}")
}

/// A cell in quotes if it needs them.
fn quoted(cell: &str) -> String {
    if cell.contains([',', '"', '\r', '\n']) {
        format!("\"{}\"", cell.replace('"', "\"\""))
    } else {
        cell.to_owned()
    }
}
