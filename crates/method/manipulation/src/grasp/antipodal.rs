//! Candidates: opposite points of the surface, and hands that reach them.

use geometry::{DMat3, DQuat, DVec3, Pose};
use physics::Body;
use rand::Rng;

use super::hand_shape::HandShape;
use super::patch::{PadContact, close_pads};
use super::settings::GraspSettings;
use super::solid::HullSolid;
use crate::swept::Swept;

/// Thinnest part that is taken, meters.
const THINNEST_M: f64 = 5e-4;
/// Hands that come from below by more than this are not tried: the sine of the angle.
const MAX_UPWARD: f64 = 0.2;
/// Share of the cone of friction that a candidate may use.
const CONE_SHARE: f64 = 0.9;
/// Candidates nearer to each other than both are one.
const SAME_M: f64 = 0.006;
const SAME_RAD: f64 = 0.3;
/// Near hands that were not free others are not tried: within this share of these bounds.
const FAILED_SHARE: f64 = 0.5;
/// The most hands whose collisions are computed.
const MAX_TRIED: usize = 2000;
/// Distance from the center of mass at which half of the score for it is left, meters.
const HALF_DISTANCE_M: f64 = 0.04;
/// A grip with this share of the pads is as good as one with more.
const FULL_SHARE: f64 = 0.6;

/// A hand that can close at opposite points.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Candidate {
    pub object_from_tool: Pose,
    pub width_m: f64,
    pub pregrasp_opening_m: f64,
    /// 0..=1.
    pub score: f64,
    /// 0..=1: how far the closing line is inside the cone of friction.
    pub margin: f64,
    pub contact: PadContact,
}

/// Finds candidates whose hands touch neither the object nor the table, by falling score.
pub fn candidates(
    object: &Body,
    hand: &HandShape,
    settings: &GraspSettings,
    rng: &mut impl Rng,
) -> Vec<Candidate> {
    let search = Search::new(object, hand, settings);
    let mut drafts: Vec<Draft> = Vec::new();
    for _ in 0..settings.surface_points {
        if let Some((point, normal)) = search.solid.draw(rng) {
            search.at_point(point, normal, &mut drafts);
        }
    }
    search.free(drafts, settings.max_candidates, MAX_TRIED)
}

/// Whether two hands are far apart, by a share of the usual bounds, with or without swapping the fingers.
pub(super) fn differ(a: &Pose, b: &Pose, share: f64) -> bool {
    a.translation_m.distance(b.translation_m) > share * SAME_M || turn_between_rad(a, b) > share * SAME_RAD
}

/// The angle between two hands, with or without swapping the fingers, whichever is less.
pub(super) fn turn_between_rad(a: &Pose, b: &Pose) -> f64 {
    let half_turn = DQuat::from_rotation_z(std::f64::consts::PI);
    let turn_rad = |rotation: DQuat| a.rotation.angle_between(rotation);
    turn_rad(b.rotation).min(turn_rad(b.rotation * half_turn))
}

/// A hand before its pads and its collisions are computed.
pub(super) struct Draft {
    /// `object_from_tool`, at the center of the part that the line passes through.
    pose: Pose,
    margin: f64,
    /// Without the share of the pads that touches.
    score: f64,
}

pub(super) struct Search<'a> {
    object: &'a Body,
    pub solid: HullSolid,
    hand: &'a HandShape,
    settings: &'a GraspSettings,
    /// Turns the object as it stands.
    standing: Pose,
    /// Height of the table under it.
    floor_m: f64,
}

/// A line along which fingers can close.
#[derive(Clone, Copy, Debug)]
pub(super) struct ClosingLine {
    /// The center of the part that it passes through.
    pub center: DVec3,
    pub direction: DVec3,
    /// 0..=1: how far it is inside the cone of friction.
    pub margin: f64,
}

impl<'a> Search<'a> {
    pub fn new(object: &'a Body, hand: &'a HandShape, settings: &'a GraspSettings) -> Self {
        let solid = HullSolid::new(&object.hulls);
        let standing = Pose { translation_m: DVec3::ZERO, ..object.world_from_object };
        let floor_m = object
            .hulls
            .iter()
            .flat_map(|hull| &hull.points)
            .map(|p| standing.transform_point(*p).z)
            .fold(f64::INFINITY, f64::min);
        Self { object, solid, hand, settings, standing, floor_m }
    }

    /// The direction of up in the frame of the object.
    pub fn up(&self) -> DVec3 {
        self.standing.inverse().transform_vector(DVec3::Z)
    }

    /// The horizontal direction nearest to a normal's inward one, if the cone of friction has it and it is another.
    pub fn flat(&self, inward: DVec3) -> Option<DVec3> {
        let up = self.up();
        let flat = (inward - inward.dot(up) * up).try_normalize();
        flat.filter(|flat| {
            let between = flat.angle_between(inward);
            between > 0.02 && between < self.max_rad()
        })
    }

    /// The angle between a closing line and a normal is at most this.
    pub fn max_rad(&self) -> f64 {
        CONE_SHARE * self.hand.friction.atan()
    }

    /// The part of a line through a point of the surface that the fingers can close on.
    pub fn line(&self, point: DVec3, direction: DVec3) -> Option<ClosingLine> {
        let max_rad = self.max_rad();
        let spans = self.solid.spans(point, direction);
        let span = spans.iter().find(|span| span.from_m.abs() < 1e-4)?;
        let width_m = span.to_m - span.from_m;
        let widest_m = self.hand.max_opening_m - self.settings.opening_margin_m;
        let angles = [(-span.enters).angle_between(direction), span.leaves.angle_between(direction)];
        let angle_rad = angles[0].max(angles[1]);
        if !(THINNEST_M..=widest_m).contains(&width_m) || angle_rad > max_rad {
            return None;
        }
        let center = point + 0.5 * (span.from_m + span.to_m) * direction;
        Some(ClosingLine { center, direction, margin: 1.0 - angle_rad / max_rad })
    }

    /// The hands of drafts that are free and differ, by falling score. Drafts with the best score come first.
    pub fn free(&self, mut drafts: Vec<Draft>, max_count: usize, max_tried: usize) -> Vec<Candidate> {
        drafts.sort_by(|a, b| b.score.total_cmp(&a.score));
        let mut tried: Vec<Pose> = Vec::new();
        let mut kept: Vec<Candidate> = Vec::new();
        for draft in drafts {
            if kept.len() == max_count || tried.len() == max_tried {
                break;
            }
            let is_kept = kept.iter().any(|other| !differ(&other.object_from_tool, &draft.pose, 1.0));
            if is_kept || tried.iter().any(|other| !differ(other, &draft.pose, FAILED_SHARE)) {
                continue;
            }
            tried.push(draft.pose);
            kept.extend(self.candidate(&draft).filter(|candidate| self.is_free(candidate)));
        }
        kept.sort_by(|a, b| b.score.total_cmp(&a.score));
        kept
    }

    fn at_point(&self, point: DVec3, normal: DVec3, found: &mut Vec<Draft>) {
        let inward = -normal;
        for direction in std::iter::once(inward).chain(self.flat(inward)) {
            if let Some(line) = self.line(point, direction) {
                self.hands(&line, found);
            }
        }
    }

    /// Adds the hands that close along a line.
    fn hands(&self, line: &ClosingLine, found: &mut Vec<Draft>) {
        let count = self.settings.approach_angles;
        for k in 0..count {
            let angle_rad = std::f64::consts::TAU * k as f64 / count as f64;
            found.extend(self.draft(line, angle_rad, 0.0));
        }
    }

    /// The hand that closes along a line and is turned about it, from where it comes from above as far as it can. Its
    /// fingers reach deeper than the line by `deeper_m`. `None` if it comes from below.
    pub fn draft(&self, line: &ClosingLine, angle_rad: f64, deeper_m: f64) -> Option<Draft> {
        let (closing, up) = (line.direction, self.up());
        let downward = (closing.dot(up) * closing - up).try_normalize();
        let first = downward.unwrap_or_else(|| closing.any_orthonormal_vector());
        let approach = DQuat::from_axis_angle(closing, angle_rad) * first;
        if approach.dot(up) > MAX_UPWARD {
            return None;
        }
        let across = closing.cross(approach);
        let rotation = DQuat::from_mat3(&DMat3::from_cols(across, closing, approach));
        let pose = Pose { translation_m: line.center + deeper_m * approach, rotation };
        Some(Draft { pose, margin: line.margin, score: self.score(&pose, line.margin, up) })
    }

    /// The score of a hand but for the share of the pads that touches: for closing lines that are well inside the cone
    /// of friction and near the center of mass, and for coming from above.
    fn score(&self, object_from_tool: &Pose, margin: f64, up: DVec3) -> f64 {
        let (axis, approach) = (object_from_tool.rotation * DVec3::Y, object_from_tool.rotation * DVec3::Z);
        let to_mass = self.object.mass.center_of_mass_m - object_from_tool.translation_m;
        let distance_m = (to_mass - to_mass.dot(axis) * axis).length();
        let near = HALF_DISTANCE_M / (HALF_DISTANCE_M + distance_m);
        0.2 * margin + 0.35 * near + 0.2 * (-approach.dot(up)).max(0.0)
    }

    /// The hand moved back where the table is in its way, with the width that its pads meet.
    pub fn candidate(&self, draft: &Draft) -> Option<Candidate> {
        let up = self.up();
        let mut object_from_tool = draft.pose;
        let rotation = object_from_tool.rotation;
        let approach = rotation * DVec3::Z;
        let lowest_m = self.lowest_m(&object_from_tool, self.hand.max_opening_m);
        let missing_m = self.floor_m + self.settings.table_gap_m - lowest_m;
        if missing_m > 0.0 {
            // Moved back along the approach, the hand rises by the cosine of its tilt.
            let back_m = missing_m / (-approach.dot(up)).max(1e-3);
            if back_m > 2.0 * self.hand.pad_half_m[1] {
                return None;
            }
            object_from_tool.translation_m -= back_m * approach;
        }
        let widest_m = self.hand.max_opening_m - self.settings.opening_margin_m;
        let contact = close_pads(&self.solid, self.hand, &object_from_tool, 0.5 * self.hand.max_opening_m)?;
        if contact.width_m > widest_m {
            return None;
        }
        object_from_tool.translation_m += contact.center_m * (rotation * DVec3::Y);
        let pregrasp_opening_m =
            (contact.width_m + 2.0 * self.settings.clearance_m).min(self.hand.max_opening_m);
        let touching = 0.25 * contact.share.min(FULL_SHARE) / FULL_SHARE;
        let score = self.score(&object_from_tool, draft.margin, up) + touching;
        let margin = draft.margin;
        Some(Candidate {
            object_from_tool,
            width_m: contact.width_m,
            pregrasp_opening_m,
            score,
            margin,
            contact,
        })
    }

    /// The lowest point of the hand, as the object stands.
    fn lowest_m(&self, object_from_tool: &Pose, opening_m: f64) -> f64 {
        let pose = self.standing * *object_from_tool;
        let solids = self.hand.solids(opening_m, true);
        solids.iter().flatten().map(|p| pose.transform_point(*p).z).fold(f64::INFINITY, f64::min)
    }

    /// Whether the hand touches neither table nor object: on its way with the fingers opened, and with them closed.
    pub fn is_free(&self, candidate: &Candidate) -> bool {
        let Candidate { object_from_tool, width_m, pregrasp_opening_m, .. } = candidate;
        let floor_m = self.floor_m + 0.5 * self.settings.table_gap_m;
        let back = self.settings.approach_m * DVec3::NEG_Z;
        if self.lowest_m(object_from_tool, *pregrasp_opening_m) < floor_m {
            return false;
        }
        let before = Pose {
            translation_m: object_from_tool.transform_point(back),
            rotation: object_from_tool.rotation,
        };
        if self.lowest_m(&before, *pregrasp_opening_m) < floor_m {
            return false;
        }
        let solids = self.hand.solids(*pregrasp_opening_m, true);
        let opened = solids.iter().map(|solid| Swept::along(solid, object_from_tool, back));
        let closed = self.hand.solids(*width_m, false);
        let closed = closed.iter().map(|solid| Swept::along(solid, object_from_tool, DVec3::ZERO));
        let own = Pose::IDENTITY;
        opened
            .chain(closed)
            .all(|solid| !self.solid.hulls().iter().any(|hull| solid.is_near(hull, &own, 0.0)))
    }
}
