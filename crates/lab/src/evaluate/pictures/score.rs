//! How far a reading lies from what was painted.
//!
//! - *things*: a painted thing counts where it shows in at least [`LEAST_SHARE_OF_PICTURE`] of the picture and at least
//!   [`LEAST_VISIBLE_SHARE`] of its silhouette within the frame. It is found where a thing that was read overlaps it by an
//!   intersection over union of at least one half. What was read and lies mostly on painted things that do not count
//!   is left out; the rest of what was read and matches nothing is invented;
//! - *outline*: intersection over union of the top's outline as read and as painted, hidden parts included, within the
//!   picture;
//! - *elevation*: of the camera, absolute difference;
//! - *place, height, yaw* of things found: after the scale that gives what the picture shows of the top its true area, and
//!   the shift that gives it its true middle. How the table's frame is turned is anybody's choice but for rectangles, where
//!   it is one of four: the reading is turned until the cameras' azimuths agree, or as nearly. The place is the middle
//!   of the footprint's hull by area. The yaw is that of the longer side of the smallest rectangle around it: modulo 180
//!   degrees from an aspect of 1.2 up, modulo 90 from 1.1, none below; where several rectangles are as small, the
//!   nearest.

use std::f64::consts::FRAC_PI_2;

use glam::DVec2;
use serde::Serialize;

use super::reading::{TableRead, ThingRead};
use super::rectangle::{Rectangle, smallest_around};
use crate::synthetic::{Labels, ObjectTruth, PictureTruth, TableShape};
use geometry::Outline;
use geometry::collide::convex_hull_2d;
use imaging::Mask;

/// Least share of the picture that a thing must show to count.
pub const LEAST_SHARE_OF_PICTURE: f64 = 0.0003;
/// Least share of its own silhouette within the frame.
pub const LEAST_VISIBLE_SHARE: f64 = 0.25;
/// Least intersection over union at which a thing is found.
pub const FOUND_IOU: f64 = 0.5;

/// Scores of one picture.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PictureScore {
    pub shape: TableShape,
    pub finish: String,
    pub backdrop: String,
    /// Whether the whole outline lies within the picture.
    pub table_is_whole: bool,
    /// Painted things that count, how many of them were found, and how many things were read that are none.
    pub painted: usize,
    pub found: usize,
    pub invented: usize,
    /// 0 where nothing was read.
    pub outline_iou: f64,
    /// `None` where nothing was read.
    pub elevation_error_deg: Option<f64>,
    /// Meters a unit of the reading stands for; how far off a reader's own scale was is not looked at.
    pub scale: Option<f64>,
    pub things: Vec<ThingScore>,
}

/// Scores of a thing that was found.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ThingScore {
    pub name: String,
    pub on_another: bool,
    pub iou: f64,
    pub position_error_m: Option<f64>,
    /// Share of the true height.
    pub height_error: f64,
    /// `None` where the footprint has no direction.
    pub yaw_error_deg: Option<f64>,
    /// Category it was given, and the one it is given where its own is left out of the catalog.
    pub label: Option<&'static str>,
    pub label_as_foreign: Option<&'static str>,
}

impl ThingScore {
    /// Whether it was given a name, and its own.
    pub fn is_labeled_right(&self) -> bool {
        self.label.is_some_and(|label| label == self.name)
    }
}

/// Compares a reading, or none, with the truth.
pub fn score(truth: &PictureTruth, labels: &Labels, read: Option<&TableRead>) -> PictureScore {
    let masks: Vec<Mask> = (0..truth.objects.len()).map(|k| labels.object(k)).collect();
    let counts: Vec<bool> = truth.objects.iter().map(|object| counts(object, truth)).collect();
    let things: &[ThingRead] = read.map_or(&[], |read| &read.things);
    let pairs = matched(&masks, things);
    let found: Vec<(usize, usize, f64)> =
        pairs.iter().copied().filter(|(object, _, _)| counts[*object]).collect();
    let is_matched = |thing: usize| pairs.iter().any(|(_, other, _)| *other == thing);
    let invented = (0..things.len())
        .filter(|&thing| !is_matched(thing) && !is_uncounted(&things[thing].mask, &masks, &counts))
        .count();
    let aligned = read.and_then(|read| Alignment::of(read, truth));
    let scores = read.zip(aligned).map_or_else(Vec::new, |(read, aligned)| {
        let one = |&(object, thing, iou): &(usize, usize, f64)| {
            let (object, thing) = (&truth.objects[object], &read.things[thing]);
            let footprint: Vec<DVec2> = thing.footprint.iter().map(|p| aligned.in_world(*p)).collect();
            ThingScore {
                label: thing.label,
                label_as_foreign: thing.label_as_foreign,
                ..thing_score(object, iou, &footprint, aligned.scale * thing.height)
            }
        };
        found.iter().map(one).collect()
    });
    PictureScore {
        shape: truth.table.shape,
        finish: truth.table.finish.clone(),
        backdrop: truth.backdrop.clone(),
        table_is_whole: truth.table.is_whole,
        painted: counts.iter().filter(|counts| **counts).count(),
        found: found.len(),
        invented,
        outline_iou: read.map_or(0.0, |read| outline_iou(truth, &read.outline_px)),
        elevation_error_deg: read.map(|read| (read.elevation_rad - truth.elevation_rad).abs().to_degrees()),
        scale: aligned.map(|aligned| aligned.scale),
        things: scores,
    }
}

/// Of each thing that was read, the name of the painted one that it is.
pub fn true_names<'a>(truth: &'a PictureTruth, labels: &Labels, read: &TableRead) -> Vec<Option<&'a str>> {
    let masks: Vec<Mask> = (0..truth.objects.len()).map(|k| labels.object(k)).collect();
    let mut names = vec![None; read.things.len()];
    for (object, thing, _) in matched(&masks, &read.things) {
        names[thing] = Some(truth.objects[object].name.as_str());
    }
    names
}

fn counts(object: &ObjectTruth, truth: &PictureTruth) -> bool {
    let picture_px = f64::from(truth.width_px) * f64::from(truth.height_px);
    object.visible_px as f64 >= LEAST_SHARE_OF_PICTURE * picture_px
        && object.visible_share >= LEAST_VISIBLE_SHARE
}

/// The reading's frame brought to the truth's.
#[derive(Clone, Copy)]
struct Alignment {
    /// Meters a unit.
    scale: f64,
    turn_rad: f64,
    shift_m: DVec2,
}

impl Alignment {
    /// `None` where one of the tops has no area.
    fn of(read: &TableRead, truth: &PictureTruth) -> Option<Self> {
        let shown_m = shown_top(truth);
        let area = |points: &[DVec2]| Outline::new(points.to_vec()).ok().map(|outline| outline.area_m2());
        let scale = (area(&shown_m)? / area(&read.top)?).sqrt();
        let apart_rad = truth.azimuth_rad - read.azimuth_rad;
        let quarters = (apart_rad / FRAC_PI_2).round();
        let is_squared = truth.table.shape == TableShape::Rectangle && truth.table.is_whole;
        let turn_rad = if is_squared { quarters * FRAC_PI_2 } else { apart_rad };
        let turned = scale * DVec2::from_angle(turn_rad).rotate(centroid(&read.top)?);
        Some(Self { scale, turn_rad, shift_m: centroid(&shown_m)? - turned })
    }

    fn in_world(&self, p: DVec2) -> DVec2 {
        self.scale * DVec2::from_angle(self.turn_rad).rotate(p) + self.shift_m
    }
}

/// What the picture shows of the true top, meters.
fn shown_top(truth: &PictureTruth) -> Vec<DVec2> {
    let (width, height) = (f64::from(truth.width_px), f64::from(truth.height_px));
    let mut left = truth.table.outline_px.clone();
    let borders: [&dyn Fn(DVec2) -> f64; 4] = [&|p| p.x, &|p| width - p.x, &|p| p.y, &|p| height - p.y];
    // Sutherland and Hodgman: the outline cut off at each side of the picture.
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

/// Painted and read things that overlap enough, best first, each in one pair at most: (object, thing, overlap).
fn matched(masks: &[Mask], things: &[ThingRead]) -> Vec<(usize, usize, f64)> {
    let mut pairs: Vec<(usize, usize, f64)> = Vec::new();
    for (object, mask) in masks.iter().enumerate() {
        for (thing, read) in things.iter().enumerate() {
            let iou = mask.iou(&read.mask);
            if iou >= FOUND_IOU {
                pairs.push((object, thing, iou));
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

/// Whether most of what was read lies on painted things that do not count.
fn is_uncounted(read: &Mask, masks: &[Mask], counts: &[bool]) -> bool {
    let on_uncounted =
        (0..masks.len()).filter(|&k| !counts[k]).map(|k| both_px(read, &masks[k])).sum::<usize>();
    2 * on_uncounted > read.area_px()
}

fn both_px(a: &Mask, b: &Mask) -> usize {
    a.bits().iter().zip(b.bits()).filter(|(a, b)| **a && **b).count()
}

/// Overlap of the outline read with the painted top, at every second pixel of every second row.
fn outline_iou(truth: &PictureTruth, outline_px: &[DVec2]) -> f64 {
    let (Ok(top), Ok(read)) =
        (Outline::new(truth.table.outline_m.clone()), Outline::new(outline_px.to_vec()))
    else {
        return 0.0;
    };
    let (mut both, mut either) = (0_usize, 0_usize);
    for y in (0..truth.height_px).step_by(2) {
        for x in (0..truth.width_px).step_by(2) {
            let pixel = DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5);
            let painted = truth.camera.meet_plane(pixel, 0.0).is_some_and(|p| top.contains(p.truncate()));
            let read = read.contains(pixel);
            both += usize::from(painted && read);
            either += usize::from(painted || read);
        }
    }
    both as f64 / either.max(1) as f64
}

fn thing_score(object: &ObjectTruth, iou: f64, footprint_m: &[DVec2], height_m: f64) -> ThingScore {
    let (painted, read) = (smallest_around(&object.footprint_m), smallest_around(footprint_m));
    let directed = painted.iter().all(|rectangle| rectangle.aspect >= 1.1);
    let yaw_error_deg = read.first().filter(|_| directed).and_then(|read| {
        let off_deg = |painted: &Rectangle| {
            let modulo_deg = if painted.aspect >= 1.2 { 180.0 } else { 90.0 };
            let off = (read.yaw_rad - painted.yaw_rad).to_degrees().rem_euclid(modulo_deg);
            off.min(modulo_deg - off)
        };
        painted.iter().map(off_deg).min_by(f64::total_cmp)
    });
    let apart = middle(&object.footprint_m).zip(middle(footprint_m));
    ThingScore {
        name: object.name.clone(),
        on_another: object.stands_on.is_some(),
        iou,
        label: None,
        label_as_foreign: None,
        position_error_m: apart.map(|(painted, read)| (read - painted).length()),
        height_error: (height_m / object.size_m.z.max(1e-9) - 1.0).abs(),
        yaw_error_deg,
    }
}

/// Centroid of the hull's area; `None` where it has none.
pub(super) fn middle(points: &[DVec2]) -> Option<DVec2> {
    centroid(&convex_hull_2d(points))
}

/// Centroid of a simple polygon's area; `None` where it has none.
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
