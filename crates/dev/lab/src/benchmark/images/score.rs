//! Errors of an estimate against the ground truth.
//!
//! - *objects*: a true object counts if it covers at least [`MIN_SHARE_OF_IMAGE`] of the image and at least
//!   [`MIN_VISIBLE_SHARE`] of its silhouette within the frame. It is detected if an estimated object overlaps it
//!   with an intersection over union of at least one half. Estimates that lie mostly on true objects that do not
//!   count are ignored; the remaining unmatched ones are false positives;
//! - *outline*: intersection over union of the estimated and the true outline of the top, hidden parts included,
//!   within the image;
//! - *elevation*: absolute difference of the camera elevations;
//! - *scale*: relative error of the reader's meters per unit, where the scale that gives the visible part of the top
//!   its true area is the true one;
//! - *position, height, yaw* of detected objects: after the scale that gives the visible part of the top its true
//!   area, and the shift that gives it its true center. The rotation of the table frame is arbitrary except for
//!   rectangles, where it is one of four: the estimate is rotated until the camera azimuths agree, or as nearly as
//!   possible. The position is the area centroid of the footprint's hull. The yaw is that of the longer side of the
//!   minimum bounding rectangle: modulo 180 degrees for an aspect of at least 1.2, modulo 90 degrees from 1.1, none
//!   below; if several rectangles are equally small, the nearest yaw counts.

use std::f64::consts::FRAC_PI_2;

use glam::DVec2;
use serde::Serialize;

use super::estimate::{ObjectEstimate, TableEstimate};
use super::rectangle::{Rectangle, smallest_around};
use crate::synthetic_images::{ImageTruth, Labels, ObjectTruth, TableShape};
use geometry::Outline;
use geometry::polygon::convex_hull_2d;
use imaging::Mask;

/// Minimum share of the image that a counting object covers.
pub const MIN_SHARE_OF_IMAGE: f64 = 0.0003;
/// Minimum visible share of a counting object's silhouette within the frame.
pub const MIN_VISIBLE_SHARE: f64 = 0.25;
/// Minimum intersection over union of a detection.
pub const DETECTION_IOU: f64 = 0.5;

/// Scores of one image.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ImageScore {
    pub shape: TableShape,
    pub finish: String,
    pub backdrop: String,
    /// Whether the whole outline lies within the image.
    pub table_is_whole: bool,
    /// Number of counting true objects, of detected ones, and of false positives.
    pub expected: usize,
    pub detected: usize,
    pub false_positives: usize,
    /// False positives with a name of the text.
    pub named_false_positives: usize,
    /// 0 without an estimate.
    pub outline_iou: f64,
    /// `None` without an estimate.
    pub elevation_error_deg: Option<f64>,
    /// True meters per unit of the estimate.
    pub scale: Option<f64>,
    /// Relative error of the reader's scale.
    pub scale_error: Option<f64>,
    pub objects: Vec<ObjectScore>,
}

/// Scores of a detected object.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ObjectScore {
    pub name: String,
    pub on_another: bool,
    pub iou: f64,
    pub position_error_m: Option<f64>,
    /// Relative error of the height.
    pub height_error: f64,
    /// `None` if the footprint has no direction.
    pub yaw_error_deg: Option<f64>,
    /// Assigned category, and the category assigned if the catalog lacks the object's own.
    pub label: Option<&'static str>,
    pub label_as_foreign: Option<&'static str>,
    /// Category assigned beside a text, if there is one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub label_with_text: Option<&'static str>,
}

impl ObjectScore {
    /// Whether the assigned category is correct.
    pub fn is_label_correct(&self) -> bool {
        self.label.is_some_and(|label| label == self.name)
    }
}

/// Compares an estimate, or none, with the ground truth.
pub fn score(truth: &ImageTruth, labels: &Labels, estimate: Option<&TableEstimate>) -> ImageScore {
    let masks: Vec<Mask> = (0..truth.objects.len()).map(|k| labels.object(k)).collect();
    let counts: Vec<bool> = truth.objects.iter().map(|object| counts(object, truth)).collect();
    let objects: &[ObjectEstimate] = estimate.map_or(&[], |estimate| &estimate.objects);
    let pairs = match_objects(&masks, objects);
    let detections: Vec<(usize, usize, f64)> =
        pairs.iter().copied().filter(|(object, _, _)| counts[*object]).collect();
    let is_matched = |detection: usize| pairs.iter().any(|(_, other, _)| *other == detection);
    let false_positives: Vec<&ObjectEstimate> = (0..objects.len())
        .filter(|&detection| {
            !is_matched(detection) && !is_uncounted(&objects[detection].mask, &masks, &counts)
        })
        .map(|detection| &objects[detection])
        .collect();
    let aligned = estimate.and_then(|estimate| Alignment::of(estimate, truth));
    let scores = estimate.zip(aligned).map_or_else(Vec::new, |(estimate, aligned)| {
        let one = |&(object, detection, iou): &(usize, usize, f64)| {
            let (object, detection) = (&truth.objects[object], &estimate.objects[detection]);
            let footprint: Vec<DVec2> = detection.footprint.iter().map(|p| aligned.in_world(*p)).collect();
            ObjectScore {
                label: detection.label,
                label_as_foreign: detection.label_as_foreign,
                label_with_text: detection.label_with_text,
                ..object_score(object, iou, &footprint, aligned.scale * detection.height)
            }
        };
        detections.iter().map(one).collect()
    });
    ImageScore {
        shape: truth.table.shape,
        finish: truth.table.finish.clone(),
        backdrop: truth.backdrop.clone(),
        table_is_whole: truth.table.is_whole,
        expected: counts.iter().filter(|counts| **counts).count(),
        detected: detections.len(),
        false_positives: false_positives.len(),
        named_false_positives: false_positives.iter().filter(|object| object.named_by_text).count(),
        outline_iou: estimate.map_or(0.0, |estimate| outline_iou(truth, &estimate.outline_px)),
        elevation_error_deg: estimate
            .map(|estimate| (estimate.elevation_rad - truth.elevation_rad).abs().to_degrees()),
        scale: aligned.map(|aligned| aligned.scale),
        scale_error: estimate
            .zip(aligned)
            .map(|(estimate, aligned)| (estimate.meters_per_unit / aligned.scale - 1.0).abs()),
        objects: scores,
    }
}

/// Per estimated object, the name of the true object that it matches.
pub fn true_names<'a>(
    truth: &'a ImageTruth,
    labels: &Labels,
    estimate: &TableEstimate,
) -> Vec<Option<&'a str>> {
    let masks: Vec<Mask> = (0..truth.objects.len()).map(|k| labels.object(k)).collect();
    let mut names = vec![None; estimate.objects.len()];
    for (object, detection, _) in match_objects(&masks, &estimate.objects) {
        names[detection] = Some(truth.objects[object].name.as_str());
    }
    names
}

/// Whether an object is large enough and visible enough to count.
pub fn counts(object: &ObjectTruth, truth: &ImageTruth) -> bool {
    let image_px = f64::from(truth.width_px) * f64::from(truth.height_px);
    object.visible_px as f64 >= MIN_SHARE_OF_IMAGE * image_px && object.visible_share >= MIN_VISIBLE_SHARE
}

/// Similarity transform from the estimate's frame to the true one.
#[derive(Clone, Copy)]
struct Alignment {
    /// Meters per unit.
    scale: f64,
    turn_rad: f64,
    shift_m: DVec2,
}

impl Alignment {
    /// `None` if one of the tops has no area.
    fn of(estimate: &TableEstimate, truth: &ImageTruth) -> Option<Self> {
        let shown_m = shown_top(truth);
        let area = |points: &[DVec2]| Outline::new(points.to_vec()).ok().map(|outline| outline.area_m2());
        let scale = (area(&shown_m)? / area(&estimate.top)?).sqrt();
        let apart_rad = truth.azimuth_rad - estimate.azimuth_rad;
        let quarters = (apart_rad / FRAC_PI_2).round();
        let is_squared = truth.table.shape == TableShape::Rectangle && truth.table.is_whole;
        let turn_rad = if is_squared { quarters * FRAC_PI_2 } else { apart_rad };
        let turned = scale * DVec2::from_angle(turn_rad).rotate(centroid(&estimate.top)?);
        Some(Self { scale, turn_rad, shift_m: centroid(&shown_m)? - turned })
    }

    fn in_world(&self, p: DVec2) -> DVec2 {
        self.scale * DVec2::from_angle(self.turn_rad).rotate(p) + self.shift_m
    }
}

/// Visible part of the true top, meters.
fn shown_top(truth: &ImageTruth) -> Vec<DVec2> {
    let (width, height) = (f64::from(truth.width_px), f64::from(truth.height_px));
    let mut left = truth.table.outline_px.clone();
    let borders: [&dyn Fn(DVec2) -> f64; 4] = [&|p| p.x, &|p| width - p.x, &|p| p.y, &|p| height - p.y];
    // Sutherland-Hodgman: clips the outline at each side of the image.
    for inside in borders {
        let before = std::mem::take(&mut left);
        for k in 0..before.len() {
            let (a, b) = (before[(k + before.len() - 1) % before.len()], before[k]);
            let (from, to) = (inside(a), inside(b));
            if (from < 0.0) != (to < 0.0) {
                left.push(a + (b - a) * (from / (from - to)));
            }
            if to >= 0.0 {
                left.push(b);
            }
        }
    }
    left.iter().filter_map(|p| truth.camera.meet_plane(*p, 0.0)).map(|p| p.truncate()).collect()
}

/// Greedy one-to-one matching by overlap: (true object, estimated object, overlap), best first.
fn match_objects(masks: &[Mask], objects: &[ObjectEstimate]) -> Vec<(usize, usize, f64)> {
    let mut pairs: Vec<(usize, usize, f64)> = Vec::new();
    for (object, mask) in masks.iter().enumerate() {
        for (detection, estimate) in objects.iter().enumerate() {
            let iou = mask.iou(&estimate.mask);
            if iou >= DETECTION_IOU {
                pairs.push((object, detection, iou));
            }
        }
    }
    pairs.sort_by(|a, b| b.2.total_cmp(&a.2));
    let mut kept: Vec<(usize, usize, f64)> = Vec::new();
    for pair in pairs {
        if kept.iter().all(|other| other.0 != pair.0 && other.1 != pair.1) {
            kept.push(pair);
        }
    }
    kept
}

/// Whether most of the estimate lies on true objects that do not count.
fn is_uncounted(estimate: &Mask, masks: &[Mask], counts: &[bool]) -> bool {
    let on_uncounted =
        (0..masks.len()).filter(|&k| !counts[k]).map(|k| both_px(estimate, &masks[k])).sum::<usize>();
    2 * on_uncounted > estimate.area_px()
}

fn both_px(a: &Mask, b: &Mask) -> usize {
    a.bits().iter().zip(b.bits()).filter(|(a, b)| **a && **b).count()
}

/// Overlap of the estimated outline with the true top, sampled at every second pixel of every second row.
fn outline_iou(truth: &ImageTruth, outline_px: &[DVec2]) -> f64 {
    let (Ok(top), Ok(estimate)) =
        (Outline::new(truth.table.outline_m.clone()), Outline::new(outline_px.to_vec()))
    else {
        return 0.0;
    };
    let (mut both, mut either) = (0_usize, 0_usize);
    for y in (0..truth.height_px).step_by(2) {
        for x in (0..truth.width_px).step_by(2) {
            let pixel = DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5);
            let in_truth = truth.camera.meet_plane(pixel, 0.0).is_some_and(|p| top.contains(p.truncate()));
            let in_estimate = estimate.contains(pixel);
            both += usize::from(in_truth && in_estimate);
            either += usize::from(in_truth || in_estimate);
        }
    }
    both as f64 / either.max(1) as f64
}

fn object_score(object: &ObjectTruth, iou: f64, footprint_m: &[DVec2], height_m: f64) -> ObjectScore {
    let (expected, estimated) = (smallest_around(&object.footprint_m), smallest_around(footprint_m));
    let directed = expected.iter().all(|rectangle| rectangle.aspect >= 1.1);
    let yaw_error_deg = estimated.first().filter(|_| directed).and_then(|estimated| {
        let off_deg = |expected: &Rectangle| {
            let modulo_deg = if expected.aspect >= 1.2 { 180.0 } else { 90.0 };
            let off = (estimated.yaw_rad - expected.yaw_rad).to_degrees().rem_euclid(modulo_deg);
            off.min(modulo_deg - off)
        };
        expected.iter().map(off_deg).min_by(f64::total_cmp)
    });
    let apart = center(&object.footprint_m).zip(center(footprint_m));
    ObjectScore {
        name: object.name.clone(),
        on_another: object.stands_on.is_some(),
        iou,
        label: None,
        label_as_foreign: None,
        label_with_text: None,
        position_error_m: apart.map(|(expected, estimated)| (estimated - expected).length()),
        height_error: (height_m / object.size_m.z.max(1e-9) - 1.0).abs(),
        yaw_error_deg,
    }
}

/// Area centroid of the hull; `None` if it has no area.
pub(super) fn center(points: &[DVec2]) -> Option<DVec2> {
    centroid(&convex_hull_2d(points))
}

/// Area centroid of a simple polygon; `None` if it has no area.
fn centroid(polygon: &[DVec2]) -> Option<DVec2> {
    let corner = *polygon.first()?;
    let (mut area, mut moment) = (0.0, DVec2::ZERO);
    for pair in polygon.windows(2) {
        let (a, b) = (pair[0] - corner, pair[1] - corner);
        area += 0.5 * a.perp_dot(b);
        moment += 0.5 * a.perp_dot(b) * (a + b) / 3.0;
    }
    (area.abs() > 1e-12).then(|| corner + moment / area)
}
