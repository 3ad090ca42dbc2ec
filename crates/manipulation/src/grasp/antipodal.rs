//! Candidates: opposite points of the surface, and hands that reach them.

use geometry::{DMat3, DQuat, DVec3, Pose};
use physics::Body;
use rand::Rng;

use super::hand_shape::HandShape;
use super::patch::close_pads;
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
}

/// Finds candidates whose hands touch neither the object nor the table, by falling score.
pub fn candidates(
    object: &Body,
    hand: &HandShape,
    settings: &GraspSettings,
    rng: &mut impl Rng,
) -> Vec<Candidate> {
    let solid = HullSolid::new(&object.hulls);
    let standing = Pose { translation_m: DVec3::ZERO, ..object.world_from_object };
    let floor_m = object
        .hulls
        .iter()
        .flat_map(|hull| &hull.points)
        .map(|p| standing.transform_point(*p).z)
        .fold(f64::INFINITY, f64::min);
    let search = Search { object, solid, hand, settings, standing, floor_m };
    let mut drafts: Vec<Draft> = Vec::new();
    for _ in 0..settings.surface_points {
        if let Some((point, normal)) = search.solid.draw(rng) {
            search.at_point(point, normal, &mut drafts);
        }
    }
    drafts.sort_by(|a, b| b.score.total_cmp(&a.score));
    let mut tried: Vec<Pose> = Vec::new();
    let mut kept: Vec<Candidate> = Vec::new();
    for draft in drafts {
        if kept.len() == settings.max_candidates || tried.len() == MAX_TRIED {
            break;
        }
        let is_kept = kept.iter().any(|other| !differ(&other.object_from_tool, &draft.pose, 1.0));
        if is_kept || tried.iter().any(|other| !differ(other, &draft.pose, FAILED_SHARE)) {
            continue;
        }
        tried.push(draft.pose);
        kept.extend(search.candidate(&draft).filter(|candidate| search.is_free(candidate)));
    }
    kept.sort_by(|a, b| b.score.total_cmp(&a.score));
    kept
}

/// Whether two hands are far apart, by a share of the usual bounds, with or without swapping the fingers.
fn differ(a: &Pose, b: &Pose, share: f64) -> bool {
    let half_turn = DQuat::from_rotation_z(std::f64::consts::PI);
    let turn_rad = |rotation: DQuat| a.rotation.angle_between(rotation);
    a.translation_m.distance(b.translation_m) > share * SAME_M
        || turn_rad(b.rotation).min(turn_rad(b.rotation * half_turn)) > share * SAME_RAD
}

/// A hand before its pads and its collisions are computed.
struct Draft {
    /// `object_from_tool`, at the center of the part that the line passes through.
    pose: Pose,
    margin: f64,
    /// Without the share of the pads that touches.
    score: f64,
}

struct Search<'a> {
    object: &'a Body,
    solid: HullSolid,
    hand: &'a HandShape,
    settings: &'a GraspSettings,
    /// Turns the object as it stands.
    standing: Pose,
    /// Height of the table under it.
    floor_m: f64,
}

impl Search<'_> {
    fn at_point(&self, point: DVec3, normal: DVec3, found: &mut Vec<Draft>) {
        let up = self.standing.inverse().transform_vector(DVec3::Z);
        let inward = -normal;
        let flat = (inward - inward.dot(up) * up).try_normalize();
        let max_rad = CONE_SHARE * self.hand.friction.atan();
        let tilted = flat.filter(|flat| {
            let between = flat.angle_between(inward);
            between > 0.02 && between < max_rad
        });
        for direction in std::iter::once(inward).chain(tilted) {
            let spans = self.solid.spans(point, direction);
            let Some(span) = spans.iter().find(|span| span.from_m.abs() < 1e-4) else { continue };
            let width_m = span.to_m - span.from_m;
            let widest_m = self.hand.max_opening_m - self.settings.opening_margin_m;
            let angles = [(-span.enters).angle_between(direction), span.leaves.angle_between(direction)];
            let angle_rad = angles[0].max(angles[1]);
            if !(THINNEST_M..=widest_m).contains(&width_m) || angle_rad > max_rad {
                continue;
            }
            let center = point + 0.5 * (span.from_m + span.to_m) * direction;
            self.hands(center, direction, up, 1.0 - angle_rad / max_rad, found);
        }
    }

    /// Adds the hands that close along a line.
    fn hands(&self, center: DVec3, closing: DVec3, up: DVec3, margin: f64, found: &mut Vec<Draft>) {
        let downward = (closing.dot(up) * closing - up).try_normalize();
        let first = downward.unwrap_or_else(|| closing.any_orthonormal_vector());
        let count = self.settings.approach_angles;
        for k in 0..count {
            let turn = DQuat::from_axis_angle(closing, std::f64::consts::TAU * k as f64 / count as f64);
            let approach = turn * first;
            if approach.dot(up) > MAX_UPWARD {
                continue;
            }
            let across = closing.cross(approach);
            let rotation = DQuat::from_mat3(&DMat3::from_cols(across, closing, approach));
            let pose = Pose { translation_m: center, rotation };
            found.push(Draft { pose, margin, score: self.score(&pose, margin, up) });
        }
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
    fn candidate(&self, draft: &Draft) -> Option<Candidate> {
        let up = self.standing.inverse().transform_vector(DVec3::Z);
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
        Some(Candidate { object_from_tool, width_m: contact.width_m, pregrasp_opening_m, score })
    }

    /// The lowest point of the hand, as the object stands.
    fn lowest_m(&self, object_from_tool: &Pose, opening_m: f64) -> f64 {
        let pose = self.standing * *object_from_tool;
        let solids = self.hand.solids(opening_m, true);
        solids.iter().flatten().map(|p| pose.transform_point(*p).z).fold(f64::INFINITY, f64::min)
    }

    /// Whether the hand touches neither table nor object: on its way with the fingers opened, and with them closed.
    fn is_free(&self, candidate: &Candidate) -> bool {
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
