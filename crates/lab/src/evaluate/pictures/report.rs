//! The tables of the picture benchmark: as Markdown for people, as JSON for programs.

use std::collections::BTreeMap;
use std::fmt::Write;

use serde::Serialize;

use super::score::ThingScore;
use super::{PictureResult, SIZE_PX};
use crate::evaluate::statistics::{Quantiles, quantiles};
use crate::synthetic::{Split, TableShape};

/// Outlines count as right from this overlap up.
const RIGHT_OUTLINE: f64 = 0.9;

/// Results of a run.
#[derive(Clone, Debug, Serialize)]
pub struct Report {
    /// `pictures`.
    pub set: &'static str,
    pub version: &'static str,
    /// Whose pictures: `test`, unless thresholds are chosen.
    pub split: &'static str,
    /// Pictures of the whole set, and the longer side of each.
    pub set_size: usize,
    pub size_px: u32,
    pub all: Summary,
    pub shapes: Vec<(TableShape, Summary)>,
    /// Pictures that show the whole outline, and the others.
    pub whole: Summary,
    pub cut: Summary,
    /// How often each reason for a refusal was given.
    pub refusals: BTreeMap<String, usize>,
    pub pictures: Vec<PictureResult>,
}

/// The scores of a group of pictures.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Summary {
    pub pictures: usize,
    pub refused: usize,
    pub painted: usize,
    pub found: usize,
    pub invented: usize,
    /// Found over painted, and found over found and invented; `None` of nothing.
    pub recall: Option<f64>,
    pub precision: Option<f64>,
    /// Share of all pictures whose outline overlaps by at least 0.9.
    pub right_outlines: f64,
    /// Degrees; over the pictures that were read.
    pub elevation_deg: Option<Quantiles>,
    /// The median where a picture that was refused is off by more than any other; `None` where that is most.
    pub elevation_median_with_refusals_deg: Option<f64>,
    /// Of things found: meters, share, degrees.
    pub position_m: Option<Quantiles>,
    pub height: Option<Quantiles>,
    pub yaw_deg: Option<Quantiles>,
    /// Share of things found that were given a category, and of these the share that was given its own; made-up things have
    /// none.
    pub labeled: Option<f64>,
    pub label_precision: Option<f64>,
    /// Share of things found that are given a category where their own is left out of the catalog: all of these are wrong.
    pub labeled_as_foreign: Option<f64>,
}

/// Sums up a group of pictures.
pub fn summary(pictures: &[&PictureResult]) -> Summary {
    let sum = |of: fn(&PictureResult) -> usize| pictures.iter().map(|picture| of(picture)).sum::<usize>();
    let share = |part: usize, of: usize| (of > 0).then(|| part as f64 / of as f64);
    let (painted, found, invented) =
        (sum(|p| p.score.painted), sum(|p| p.score.found), sum(|p| p.score.invented));
    let things = |of: fn(&ThingScore) -> Option<f64>| {
        quantiles(pictures.iter().flat_map(|picture| &picture.score.things).filter_map(of).collect())
    };
    let found_things = || pictures.iter().flat_map(|picture| &picture.score.things);
    let of_things = |of: fn(&ThingScore) -> bool| found_things().filter(|thing| of(thing)).count();
    let (all_things, labeled) = (found_things().count(), of_things(|thing| thing.label.is_some()));
    let right = pictures.iter().filter(|picture| picture.score.outline_iou >= RIGHT_OUTLINE).count();
    let elevations = pictures.iter().map(|picture| picture.score.elevation_error_deg);
    let with_refusals = quantiles(elevations.clone().map(|error| error.unwrap_or(f64::INFINITY)).collect());
    Summary {
        pictures: pictures.len(),
        refused: pictures.iter().filter(|picture| picture.refused.is_some()).count(),
        painted,
        found,
        invented,
        recall: share(found, painted),
        precision: share(found, found + invented),
        right_outlines: share(right, pictures.len()).unwrap_or(0.0),
        elevation_deg: quantiles(elevations.flatten().collect()),
        elevation_median_with_refusals_deg: with_refusals.map(|q| q.median).filter(|m| m.is_finite()),
        position_m: things(|thing| thing.position_error_m),
        height: things(|thing| Some(thing.height_error)),
        yaw_deg: things(|thing| thing.yaw_error_deg),
        labeled: share(labeled, all_things),
        label_precision: share(of_things(ThingScore::is_labeled_right), labeled),
        labeled_as_foreign: share(of_things(|thing| thing.label_as_foreign.is_some()), all_things),
    }
}

impl Report {
    /// Of pictures in the order of their numbers.
    pub fn new(split: Split, set_size: usize, pictures: Vec<PictureResult>) -> Self {
        let group = |keep: &dyn Fn(&PictureResult) -> bool| {
            summary(&pictures.iter().filter(|picture| keep(picture)).collect::<Vec<_>>())
        };
        let mut shapes: Vec<TableShape> = pictures.iter().map(|picture| picture.score.shape).collect();
        shapes.sort_unstable();
        shapes.dedup();
        let mut refusals = BTreeMap::new();
        for code in pictures.iter().filter_map(|picture| picture.refused.clone()) {
            *refusals.entry(code).or_default() += 1;
        }
        Self {
            set: "pictures",
            version: env!("CARGO_PKG_VERSION"),
            split: split.name(),
            set_size,
            size_px: SIZE_PX,
            all: group(&|_| true),
            shapes: shapes.iter().map(|shape| (*shape, group(&|p| p.score.shape == *shape))).collect(),
            whole: group(&|p| p.score.table_is_whole),
            cut: group(&|p| !p.score.table_is_whole),
            refusals,
            pictures,
        }
    }

    /// The whole report.
    pub fn markdown(&self) -> String {
        let mut text = String::from("# Picture benchmark\n\n");
        let _ = writeln!(
            text,
            "`tabletopgen evaluate --set pictures`, tabletopgen {}: {} of {} painted pictures of the {} split, {} pixels \
             wide or high. Categories, tops and backdrops are of no other split. Found: overlap of masks at least 0.5. \
             Refusals find nothing and have no outline. Places, heights and yaws are those of things found, after one \
             scale a picture that gives the top its true area. Labeled: things found that were given a category of the \
             catalog; right labels: those of them that were given their own (made-up things have none); labeled if foreign: \
             things found that are given a category where their own is left out of the catalog, all of them wrongly.\n",
            self.version,
            self.pictures.len(),
            self.set_size,
            self.split,
            self.size_px
        );
        text += "| | pictures | refused | things | recall | precision | outline >= 0.9 | elevation deg, median | 95 % \
                 | position mm, median | 95 % | height %, median | 95 % | yaw deg, median | 95 % \
                 | labeled | right labels | labeled if foreign |\n";
        text += "| --- | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: |\n";
        text += &row("all", &self.all);
        text += &row("whole table shows", &self.whole);
        text += &row("table is cut", &self.cut);
        for (shape, of) in &self.shapes {
            text += &row(&format!("{shape:?}").to_lowercase(), of);
        }
        text += "| bar | | | | 90.0 % | 90.0 % | 95.0 % | 1.50 | | 15.0 | | 8.0 | | 5.00 | | | | |\n";
        let elevation = self.all.elevation_median_with_refusals_deg;
        let elevation =
            elevation.map_or("none: most are refused".to_owned(), |median| format!("{median:.2} degrees"));
        let _ = writeln!(text, "\nMedian elevation error with every refusal as the largest: {elevation}.");
        for (code, count) in &self.refusals {
            let _ = writeln!(text, "\nRefused as `{code}`: {count}");
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
        "| {name} | {} | {} | {} | {} | {} | {} | {} | {} | {} | {} | {} | {} | {} |\n",
        of.pictures,
        of.refused,
        of.painted,
        percent(of.recall),
        percent(of.precision),
        percent(Some(of.right_outlines)),
        pair(of.elevation_deg, 1.0, 2),
        pair(of.position_m, 1e3, 1),
        pair(of.height, 100.0, 1),
        pair(of.yaw_deg, 1.0, 1),
        percent(of.labeled),
        percent(of.label_precision),
        percent(of.labeled_as_foreign),
    )
}
