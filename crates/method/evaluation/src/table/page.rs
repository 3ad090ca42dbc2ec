//! The table as a page: self-contained, without scripts, external links or files.

use markup::html::{Cell, Html};

use super::EvaluationTable;
use crate::perceptual_models::Metric;

/// Content security policy: the page loads nothing, whatever the name of a scene contains.
const POLICY: &str = "default-src 'none'; style-src 'unsafe-inline'";

/// Columns of the paper. An arrow points to where better numbers lie.
const HEAD: [&str; 12] = [
    "scene",
    "LPIPS best ↓",
    "LPIPS mean ↓",
    "DINOv2 best ↑",
    "DINOv2 mean ↑",
    "CLIP best ↑",
    "CLIP mean ↑",
    "Col_O % ↓",
    "Col_S (mean %) ↓",
    "SS % ↑",
    "DSS aligned % ↑",
    "DSS shipped % ↑",
];

/// The whole page.
pub(super) fn text(table: &EvaluationTable) -> String {
    let mut page = Html::default();
    page.open("html", &[("lang", "en"), ("xmlns", "http://www.w3.org/1999/xhtml")]);
    page.open("head", &[]);
    page.void("meta", &[("charset", "utf-8")]);
    page.void("meta", &[("http-equiv", "Content-Security-Policy"), ("content", POLICY)]);
    page.void("meta", &[("name", "viewport"), ("content", "width=device-width, initial-scale=1")]);
    page.leaf("title", &[], "Evaluation of scenes");
    page.style(include_str!("page.css"));
    page.close();
    page.open("body", &[]);
    page.leaf("h1", &[], "Evaluation of scenes");
    page.leaf("p", &[], &protocol(table));
    page.table("scenes", &HEAD, table.scenes.iter().map(row).chain([means(table)]).collect());
    for (metric, file) in table.missing() {
        let title = metric.title();
        page.leaf("p", &[], &format!("{title} has no numbers: the file {file} of its weights is missing."));
    }
    format!("<!DOCTYPE html>\n{}", page.finish())
}

/// The protocol in sentences.
fn protocol(table: &EvaluationTable) -> String {
    let protocol = &table.protocol;
    format!(
        "{} views of each scene, {} degrees wide along the shorter side and {} pixels along the longer one. Best is the \
         view closest to the reference image by that metric, mean is over all views. LPIPS has the network {}.",
        protocol.views, protocol.field_of_view_deg, protocol.longest_side_px, protocol.lpips_network
    )
}

fn row(row: &super::SceneRow) -> Vec<Cell> {
    let mut cells = vec![Cell::UserText(row.scene.clone())];
    for metric in Metric::ALL {
        let scores = row.scores.as_ref().and_then(|scores| scores.of(metric).measured());
        cells.extend(pair(scores.map(|scores| (scores.best.score, scores.mean))));
    }
    let metrics = row.physics.metrics;
    let col_s = if metrics.col_s > 0.0 { "collides" } else { "free" };
    cells.extend([percent(metrics.col_o), Cell::Words(col_s.to_owned())]);
    cells.extend([metrics.ss, metrics.dss_aligned, metrics.dss_shipped].map(percent));
    cells
}

fn means(table: &EvaluationTable) -> Vec<Cell> {
    let mut cells = vec![Cell::Words("mean".to_owned())];
    for metric in Metric::ALL {
        cells.extend(pair(table.means.of(metric).map(|means| (means.best, means.mean))));
    }
    match &table.means.physics {
        Some(rates) => {
            let rates = [rates.col_o, rates.col_s, rates.ss, rates.dss_aligned, rates.dss_shipped];
            cells.extend(rates.map(percent));
        }
        None => cells.extend([const { Cell::Number(String::new()) }; 5]),
    }
    cells
}

/// Best and mean with the digits of the paper, or two empty cells.
fn pair(scores: Option<(f64, f64)>) -> [Cell; 2] {
    match scores {
        Some((best, mean)) => [best, mean].map(|score| Cell::Number(format!("{score:.4}"))),
        None => [const { Cell::Number(String::new()) }; 2],
    }
}

fn percent(share: f64) -> Cell {
    Cell::Number(format!("{:.2}", 100.0 * share))
}
