//! Report of the image benchmark, as Markdown and JSON.

use std::collections::BTreeMap;
use std::fmt::Write;

use serde::Serialize;

use super::score::ObjectScore;
use super::text_beside::TextSummary;
use super::{ImageResult, SIZE_PX};
use crate::benchmark::statistics::{Quantiles, quantiles};
use crate::synthetic_images::{Split, TableShape};

/// Minimum overlap of a correct outline.
const CORRECT_OUTLINE_IOU: f64 = 0.9;

/// Result of a run.
#[derive(Clone, Debug, Serialize)]
pub struct Report {
    /// `images`.
    pub set: &'static str,
    pub version: &'static str,
    /// Split of the images: `test`, unless thresholds are chosen.
    pub split: &'static str,
    /// Number of images of the whole set, and their longer side.
    pub set_size: usize,
    pub size_px: u32,
    pub all: Summary,
    pub shapes: Vec<(TableShape, Summary)>,
    /// Images that show the whole outline, and the others.
    pub whole: Summary,
    pub cut: Summary,
    /// Number of refusals by error code.
    pub refusals: BTreeMap<String, usize>,
    /// Labels beside texts, if the images had any.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub with_text: Option<TextSummary>,
    pub images: Vec<ImageResult>,
}

/// Scores of a group of images.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Summary {
    pub images: usize,
    pub refused: usize,
    pub expected: usize,
    pub detected: usize,
    pub false_positives: usize,
    /// Detected over true objects, and detected over detected and false positives; `None` without objects.
    pub recall: Option<f64>,
    pub precision: Option<f64>,
    /// Share of all images whose outline overlap is at least 0.9.
    pub correct_outlines: f64,
    /// Degrees; over the images that were not refused.
    pub elevation_deg: Option<Quantiles>,
    /// Median with every refusal counted as the largest error; `None` if most images are refused.
    pub elevation_median_with_refusals_deg: Option<f64>,
    /// Relative error of the reader's scale, over the images that were not refused.
    pub scale: Option<Quantiles>,
    /// Of detected objects: meters, share, degrees.
    pub position_m: Option<Quantiles>,
    pub height: Option<Quantiles>,
    pub yaw_deg: Option<Quantiles>,
    /// Share of detected objects that were assigned a category, and the share of these with the correct one;
    /// composites have none.
    pub labeled: Option<f64>,
    pub label_precision: Option<f64>,
    /// Share of detected objects that are assigned a category if their own is left out of the catalog; all of these
    /// are wrong.
    pub labeled_as_foreign: Option<f64>,
}

/// Summarizes a group of images.
pub fn summary(images: &[&ImageResult]) -> Summary {
    let sum = |of: fn(&ImageResult) -> usize| images.iter().map(|image| of(image)).sum::<usize>();
    let share = |part: usize, of: usize| (of > 0).then(|| part as f64 / of as f64);
    let (expected, detected, false_positives) =
        (sum(|p| p.score.expected), sum(|p| p.score.detected), sum(|p| p.score.false_positives));
    let objects = |of: fn(&ObjectScore) -> Option<f64>| {
        quantiles(images.iter().flat_map(|image| &image.score.objects).filter_map(of).collect())
    };
    let detected_objects = || images.iter().flat_map(|image| &image.score.objects);
    let count_objects = |of: fn(&ObjectScore) -> bool| detected_objects().filter(|object| of(object)).count();
    let (all_objects, labeled) = (detected_objects().count(), count_objects(|object| object.label.is_some()));
    let right = images.iter().filter(|image| image.score.outline_iou >= CORRECT_OUTLINE_IOU).count();
    let elevations = images.iter().map(|image| image.score.elevation_error_deg);
    let with_refusals = quantiles(elevations.clone().map(|error| error.unwrap_or(f64::INFINITY)).collect());
    Summary {
        images: images.len(),
        refused: images.iter().filter(|image| image.refused.is_some()).count(),
        expected,
        detected,
        false_positives,
        recall: share(detected, expected),
        precision: share(detected, detected + false_positives),
        correct_outlines: share(right, images.len()).unwrap_or(0.0),
        elevation_deg: quantiles(elevations.flatten().collect()),
        elevation_median_with_refusals_deg: with_refusals.map(|q| q.median).filter(|m| m.is_finite()),
        scale: quantiles(images.iter().filter_map(|image| image.score.scale_error).collect()),
        position_m: objects(|object| object.position_error_m),
        height: objects(|object| Some(object.height_error)),
        yaw_deg: objects(|object| object.yaw_error_deg),
        labeled: share(labeled, all_objects),
        label_precision: share(count_objects(ObjectScore::is_label_correct), labeled),
        labeled_as_foreign: share(count_objects(|object| object.label_as_foreign.is_some()), all_objects),
    }
}

impl Report {
    /// Report of images in number order.
    pub fn new(split: Split, set_size: usize, images: Vec<ImageResult>) -> Self {
        let group = |keep: &dyn Fn(&ImageResult) -> bool| {
            summary(&images.iter().filter(|image| keep(image)).collect::<Vec<_>>())
        };
        let mut shapes: Vec<TableShape> = images.iter().map(|image| image.score.shape).collect();
        shapes.sort_unstable();
        shapes.dedup();
        let mut refusals = BTreeMap::new();
        for code in images.iter().filter_map(|image| image.refused.clone()) {
            *refusals.entry(code).or_default() += 1;
        }
        Self {
            set: "images",
            version: env!("CARGO_PKG_VERSION"),
            split: split.name(),
            set_size,
            size_px: SIZE_PX,
            all: group(&|_| true),
            shapes: shapes.iter().map(|shape| (*shape, group(&|p| p.score.shape == *shape))).collect(),
            whole: group(&|p| p.score.table_is_whole),
            cut: group(&|p| !p.score.table_is_whole),
            refusals,
            with_text: None,
            images,
        }
    }

    /// The whole report as Markdown.
    pub fn markdown(&self) -> String {
        let mut text = String::from("# Image benchmark\n\n");
        let _ = writeln!(
            text,
            "`tabletopgen-lab evaluate --set images`, tabletopgen {}: {} of {} synthetic images of the {} split, {} pixels \
             wide or high. Categories, tops and backdrops are of no other split. Detected: overlap of masks at least 0.5. \
             A refusal detects no object and has no outline. Positions, heights and yaws are those of detected objects, after one \
             scale per image that gives the top its true area. Labeled: detected objects that were assigned a category of the \
             catalog; right labels: those with their own category (composites have none); labeled if foreign: \
             detected objects that are assigned a category if their own is left out of the catalog, all of them wrongly.\n",
            self.version,
            self.images.len(),
            self.set_size,
            self.split,
            self.size_px
        );
        text += "| | images | refused | objects | recall | precision | outline >= 0.9 | elevation deg, median | 95 % \
                 | scale %, median | 95 % | position mm, median | 95 % | height %, median | 95 % | yaw deg, median | 95 % \
                 | labeled | right labels | labeled if foreign |\n";
        text += "| --- | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: |\n";
        text += &row("all", &self.all);
        text += &row("whole table shows", &self.whole);
        text += &row("table is cut", &self.cut);
        for (shape, of) in &self.shapes {
            text += &row(&format!("{shape:?}").to_lowercase(), of);
        }
        text += "| bar | | | | 90.0 % | 90.0 % | 95.0 % | 1.50 | | | | 15.0 | | 8.0 | | 5.00 | | | | |\n";
        let elevation = self.all.elevation_median_with_refusals_deg;
        let elevation =
            elevation.map_or("none: most are refused".to_owned(), |median| format!("{median:.2} degrees"));
        let _ = writeln!(text, "\nMedian elevation error with every refusal as the largest: {elevation}.");
        for (code, count) in &self.refusals {
            let _ = writeln!(text, "\nRefused as `{code}`: {count}");
        }
        if let Some(with_text) = &self.with_text {
            text += &with_text.markdown();
        }
        text
    }
}

fn row(name: &str, of: &Summary) -> String {
    let pair = |quantiles: Option<Quantiles>, unit: f64, digits: usize| match quantiles {
        Some(q) => format!("{:.digits$} | {:.digits$}", unit * q.median, unit * q.p95),
        None => "- | -".to_owned(),
    };
    let percent =
        |share: Option<f64>| share.map_or("-".to_owned(), |share| format!("{:.1} %", 100.0 * share));
    format!(
        "| {name} | {} | {} | {} | {} | {} | {} | {} | {} | {} | {} | {} | {} | {} | {} |\n",
        of.images,
        of.refused,
        of.expected,
        percent(of.recall),
        percent(of.precision),
        percent(Some(of.correct_outlines)),
        pair(of.elevation_deg, 1.0, 2),
        pair(of.scale, 100.0, 1),
        pair(of.position_m, 1e3, 1),
        pair(of.height, 100.0, 1),
        pair(of.yaw_deg, 1.0, 1),
        percent(of.labeled),
        percent(of.label_precision),
        percent(of.labeled_as_foreign),
    )
}
