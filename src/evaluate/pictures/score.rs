//! How far a reading lies from what was painted.
//!
//! - *things*: a painted thing counts where it shows in at least [`LEAST_SHARE_OF_PICTURE`] of the picture and at least
//!   [`LEAST_VISIBLE_SHARE`] of its silhouette within the frame. It is found where a thing that was read overlaps it by an
//!   intersection over union of at least one half. What was read and lies mostly on painted things that do not count
//!   is left out; the rest of what was read and matches nothing is invented;
//! - *outline*: intersection over union of the top's outline as read and as painted, hidden parts included, within the
//!   picture;
//! - *elevation*: of the camera, absolute difference;
//! - *place, height, yaw* of things found: after the scale that gives the top its true area. Where the top is round its
//!   turn is anybody's choice, and the reading is turned until the cameras' azimuths agree. The place is the middle of
//!   the footprint's hull by area. The yaw is that of the longer side of the smallest rectangle around it: modulo 180
//!   degrees from an aspect of 1.2 up, modulo 90 from 1.1, none below; where several rectangles are as small, the
//!   nearest.

use glam::DVec2;
use serde::Serialize;

use super::reading::{TableRead, ThingRead};
use super::rectangle::{Rectangle, smallest_around};
use crate::geometry::collide::convex_hull_2d;
use crate::geometry::{Mask, Outline};
use crate::synthetic::{Labels, ObjectTruth, PictureTruth, TableShape};

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
    let scale = read.map(|read| (area_m2(truth) / read.top_area.max(1e-12)).sqrt());
    let scores = read.zip(scale).map_or_else(Vec::new, |(read, scale)| {
        let turn = match truth.table.shape {
            TableShape::Round => truth.azimuth_rad - read.azimuth_rad,
            _ => 0.0,
        };
        let in_world = |p: DVec2| scale * DVec2::from_angle(turn).rotate(p);
        let one = |&(object, thing, iou): &(usize, usize, f64)| {
            let (object, thing) = (&truth.objects[object], &read.things[thing]);
            let footprint: Vec<DVec2> = thing.footprint.iter().map(|p| in_world(*p)).collect();
            thing_score(object, iou, &footprint, scale * thing.height)
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
        scale,
        things: scores,
    }
}

fn counts(object: &ObjectTruth, truth: &PictureTruth) -> bool {
    let picture_px = f64::from(truth.width_px) * f64::from(truth.height_px);
    object.visible_px as f64 >= LEAST_SHARE_OF_PICTURE * picture_px
        && object.visible_share >= LEAST_VISIBLE_SHARE
}

fn area_m2(truth: &PictureTruth) -> f64 {
    Outline::new(truth.table.outline_m.clone()).map_or(0.0, |outline| outline.area_m2())
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
        position_error_m: apart.map(|(painted, read)| (read - painted).length()),
        height_error: (height_m / object.size_m.z.max(1e-9) - 1.0).abs(),
        yaw_error_deg,
    }
}

/// Centroid of the hull's area; `None` where it has none.
fn middle(points: &[DVec2]) -> Option<DVec2> {
    let hull = convex_hull_2d(points);
    let corner = *hull.first()?;
    let (mut area, mut moment) = (0.0, DVec2::ZERO);
    for pair in hull.windows(2) {
        let (a, b) = (pair[0] - corner, pair[1] - corner);
        area += 0.5 * a.perp_dot(b);
        moment += 0.5 * a.perp_dot(b) * (a + b) / 3.0;
    }
    (area > 1e-12).then(|| corner + moment / area)
}
