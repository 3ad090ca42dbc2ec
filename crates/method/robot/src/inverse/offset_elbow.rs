//! Seven joints arranged as those of Franka arms, in closed form for each position of the last joint.
//!
//! The first three axes meet in the shoulder, the fourth lies beside the line of the arm, the fifth and sixth meet in
//! the wrist, and the seventh lies beside the sixth. With the last joint at a stated position the wrist follows from
//! the pose of the tool. The triangle of shoulder, elbow and wrist gives the fourth joint; the forearm's direction
//! must be square to the sixth axis and leave the wrist at the triangle's angle, which gives the sixth; the rest are
//! angles of rotations. Method: He and Liu, "Analytical inverse kinematics for Franka Emika Panda" (2021), with both
//! signs of the elbow's angle. Each position of the last joint has at most eight solutions, mostly up to four.
//!
//! Where no sampled position of the last joint has a solution, the search goes on where one is nearly there: the excess
//! of a position is how far the nearest branch is beyond a joint limit, and its minima are narrowed down.

use std::f64::consts::FRAC_PI_2;

use nalgebra::{Isometry3, Matrix3, UnitQuaternion, Vector2, Vector3};

use super::angles::{about_x, about_z, all_within, beyond, zyz};
use crate::model::{JointLimits, MovingKind, Robot};

/// The geometry of an arm like Franka's.
#[derive(Clone, Debug)]
pub struct OffsetElbow {
    base_from_shoulder: Isometry3<f64>,
    last_from_tool: Isometry3<f64>,
    /// From the shoulder to the elbow, along the upper arm.
    upper_arm_m: f64,
    /// From the line of the upper arm to the fourth axis.
    upper_offset_m: f64,
    forearm_m: f64,
    /// From the fourth axis back to the line of the forearm.
    lower_offset_m: f64,
    /// From the sixth axis to the seventh.
    wrist_offset_m: f64,
    limits: [JointLimits; 7],
}

/// Deviations above this are another geometry.
const TOLERANCE: f64 = 1e-9;

/// Numbers of positions of the last joint that are tried; the second one only where the first found nothing.
const SAMPLES: [usize; 2] = [64, 512];

/// The steps that narrow down a minimum of the excess: each leaves 0.618 of the interval.
const NARROWING_STEPS: usize = 40;

/// The excess where the links cannot meet is above every excess over a limit.
const OUT_OF_REACH: f64 = std::f64::consts::TAU;

/// Result of one position of the last joint.
struct Attempt {
    solutions: Vec<[f64; 7]>,
    /// Excess of the nearest branch over the joint limits, radians; 0 where there is a solution, [`OUT_OF_REACH`] where
    /// the links cannot meet.
    excess: f64,
}

impl OffsetElbow {
    /// Finds the geometry of `robot`; `None` where its arm has another one.
    pub fn recognize(robot: &Robot) -> Option<Self> {
        let limits: [JointLimits; 7] = robot.limits().try_into().ok()?;
        let turns = |joint: &crate::model::MovingJoint| {
            joint.kind == MovingKind::Revolute && joint.axis == Vector3::z_axis()
        };
        if !robot.arm_joints().all(turns) {
            return None;
        }
        let origins = origins(robot)?;
        let quarters = [0.0, -1.0, 1.0, 1.0, -1.0, 1.0, 1.0];
        for (origin, quarter) in origins.iter().zip(quarters).skip(1) {
            let expected = UnitQuaternion::from_axis_angle(&Vector3::x_axis(), quarter * FRAC_PI_2);
            if origin.rotation.angle_to(&expected) > TOLERANCE {
                return None;
            }
        }
        let offsets: Vec<Vector3<f64>> = origins.iter().map(|origin| origin.translation.vector).collect();
        let (elbow, forearm) = (offsets[3].x, offsets[4]);
        let expected = [
            Vector3::zeros(),
            Vector3::new(0.0, offsets[2].y, 0.0),
            Vector3::new(elbow, 0.0, 0.0),
            Vector3::new(forearm.x, forearm.y, 0.0),
            Vector3::zeros(),
            Vector3::new(offsets[6].x, 0.0, 0.0),
        ];
        if offsets[1..].iter().zip(expected).any(|(offset, expected)| (offset - expected).norm() > TOLERANCE)
        {
            return None;
        }
        Some(Self {
            base_from_shoulder: origins[0],
            last_from_tool: last_from_tool(robot)?,
            upper_arm_m: -offsets[2].y,
            upper_offset_m: elbow,
            forearm_m: forearm.y,
            lower_offset_m: -forearm.x,
            wrist_offset_m: offsets[6].x,
            limits,
        })
    }

    /// Computes the configurations within limits that put the tool at `base_from_tool`, for 64 positions of the last
    /// joint. Where these have none, 512 are tried, each time also the minima of the excess between them.
    pub fn solve(&self, base_from_tool: &Isometry3<f64>) -> Vec<[f64; 7]> {
        let target = self.shoulder_from_last(base_from_tool);
        let JointLimits { min_position: first, max_position: last, .. } = self.limits[6];
        for samples in SAMPLES {
            let step = (last - first) / samples as f64;
            let position = |k: usize| first + step * (k as f64 + 0.5);
            let attempts: Vec<Attempt> = (0..samples).map(|k| self.attempt(&target, position(k))).collect();
            if attempts.iter().any(|attempt| !attempt.solutions.is_empty()) {
                return attempts.into_iter().flat_map(|attempt| attempt.solutions).collect();
            }
            let excess = |k: usize| attempts.get(k).map_or(f64::INFINITY, |attempt| attempt.excess);
            let is_minimum =
                |k: &usize| excess(*k) <= excess(k.wrapping_sub(1)) && excess(*k) <= excess(k + 1);
            for k in (0..samples).filter(is_minimum) {
                let around = [(position(k) - step).max(first), (position(k) + step).min(last)];
                let solutions = self.narrow_down(&target, around);
                if !solutions.is_empty() {
                    return solutions;
                }
            }
        }
        Vec::new()
    }

    /// Computes all configurations within limits that put the tool at `base_from_tool` with the last joint at
    /// `last_rad`, at most eight.
    pub fn solve_at(&self, base_from_tool: &Isometry3<f64>, last_rad: f64) -> Vec<[f64; 7]> {
        self.attempt(&self.shoulder_from_last(base_from_tool), last_rad).solutions
    }

    fn shoulder_from_last(&self, base_from_tool: &Isometry3<f64>) -> Isometry3<f64> {
        self.base_from_shoulder.inverse() * base_from_tool * self.last_from_tool.inverse()
    }

    /// Golden-section search for the least excess, up to the first position that has solutions.
    fn narrow_down(&self, target: &Isometry3<f64>, [mut low, mut high]: [f64; 2]) -> Vec<[f64; 7]> {
        let golden = (5f64.sqrt() - 1.0) / 2.0;
        let (mut left, mut right) = (high - golden * (high - low), low + golden * (high - low));
        let (mut at_left, mut at_right) = (self.attempt(target, left), self.attempt(target, right));
        for _ in 0..NARROWING_STEPS {
            for attempt in [&mut at_left, &mut at_right] {
                if !attempt.solutions.is_empty() {
                    return std::mem::take(&mut attempt.solutions);
                }
            }
            if at_left.excess < at_right.excess {
                (high, right, at_right) = (right, left, at_left);
                left = high - golden * (high - low);
                at_left = self.attempt(target, left);
            } else {
                (low, left, at_left) = (left, right, at_right);
                right = low + golden * (high - low);
                at_right = self.attempt(target, right);
            }
        }
        Vec::new()
    }

    fn attempt(&self, shoulder_from_last: &Isometry3<f64>, last_rad: f64) -> Attempt {
        let last = shoulder_from_last.rotation.to_rotation_matrix().into_inner();
        // Columns are the axes of the sixth link in the frame of the shoulder.
        let sixth = last * about_z(-last_rad) * about_x(-FRAC_PI_2);
        let wrist = shoulder_from_last.translation.vector - sixth.column(0) * self.wrist_offset_m;
        let mut attempt = Attempt { solutions: Vec::new(), excess: f64::INFINITY };
        let elbow = self.elbow_cosine(wrist.norm());
        if elbow.abs() > 1.0 {
            attempt.misses(OUT_OF_REACH + elbow.abs() - 1.0);
        }
        for elbow_rad in self.elbow_angles(elbow) {
            let to_wrist = self.shoulder_to_wrist(elbow_rad);
            let local = sixth.transpose() * wrist;
            let cosine = to_wrist.y / local.x.hypot(local.y);
            if cosine.abs() > 1.0 {
                attempt.misses(OUT_OF_REACH + cosine.abs() - 1.0);
            }
            for wrist_rad in wrist_angles(&local, cosine) {
                let Some(fourth) = forearm_frame(&sixth, &wrist, wrist_rad, &to_wrist) else { continue };
                let fifth = sixth * about_z(-wrist_rad) * about_x(-FRAC_PI_2);
                let turn = (fourth * about_x(-FRAC_PI_2)).transpose() * fifth;
                let forearm_rad = f64::atan2(turn[(1, 0)], turn[(0, 0)]);
                let third = fourth * (about_x(FRAC_PI_2) * about_z(elbow_rad)).transpose();
                for [a, b, c] in zyz(&third) {
                    let angles = [a, b, c, elbow_rad, forearm_rad, wrist_rad, last_rad];
                    let excesses =
                        self.limits.iter().zip(angles).map(|(limits, angle)| beyond(limits, angle));
                    attempt.misses(excesses.fold(0.0, f64::max));
                    attempt.solutions.extend(all_within(&self.limits, angles));
                }
            }
        }
        attempt
    }

    /// The cosine of the angle at the fourth axis at which shoulder and wrist are `distance_m` apart; beyond 1 where
    /// they cannot be.
    fn elbow_cosine(&self, distance_m: f64) -> f64 {
        let (upper, lower) =
            (self.upper_offset_m.hypot(self.upper_arm_m), self.lower_offset_m.hypot(self.forearm_m));
        (upper * upper + lower * lower - distance_m * distance_m) / (2.0 * upper * lower)
    }

    /// The positions of the fourth joint at which the angle at its axis has the cosine, regardless of limits.
    fn elbow_angles(&self, cosine: f64) -> impl Iterator<Item = f64> {
        let opening = (cosine.abs() <= 1.0).then(|| cosine.acos());
        // Directions from the fourth axis, in its frame at position zero.
        let to_wrist = f64::atan2(self.forearm_m, -self.lower_offset_m);
        let to_shoulder = f64::atan2(-self.upper_arm_m, -self.upper_offset_m);
        let both = opening.into_iter().flat_map(|opening| [opening, -opening]);
        both.map(move |opening| opening - to_wrist + to_shoulder)
    }

    /// From the shoulder to the wrist in the frame of the fourth link, whose z axis is square to both.
    fn shoulder_to_wrist(&self, elbow_rad: f64) -> Vector2<f64> {
        let (sin, cos) = elbow_rad.sin_cos();
        let shoulder = Vector2::new(-self.upper_offset_m, -self.upper_arm_m);
        let turned = Vector2::new(cos * shoulder.x + sin * shoulder.y, cos * shoulder.y - sin * shoulder.x);
        Vector2::new(-self.lower_offset_m, self.forearm_m) - turned
    }
}

impl Attempt {
    /// Notes a branch that is `excess` from a solution.
    fn misses(&mut self, excess: f64) {
        self.excess = self.excess.min(excess);
    }
}

/// The positions of the sixth joint at which the forearm, square to the sixth axis, is at the angle with the `cosine`
/// to the vector from shoulder to wrist, whose coordinates along the axes of the sixth link are `local`.
fn wrist_angles(local: &Vector3<f64>, cosine: f64) -> impl Iterator<Item = f64> {
    let center = f64::atan2(local.x, local.y);
    let opening = (cosine.abs() <= 1.0).then(|| cosine.acos());
    opening.into_iter().flat_map(|opening| [opening, -opening]).map(move |opening| center + opening)
}

/// The axes of the fourth link; `None` where shoulder, elbow and wrist lie on the line of the forearm.
fn forearm_frame(
    sixth: &Matrix3<f64>,
    wrist: &Vector3<f64>,
    wrist_rad: f64,
    to_wrist: &Vector2<f64>,
) -> Option<Matrix3<f64>> {
    let y = sixth * Vector3::new(wrist_rad.sin(), wrist_rad.cos(), 0.0);
    let x = ((wrist - y * to_wrist.y) / to_wrist.x).try_normalize(1e-9)?;
    x.iter().all(|c| c.is_finite()).then(|| Matrix3::from_columns(&[x, y, x.cross(&y)]))
}

/// The frame of each joint of the arm in that of the joint before; `None` where fixed joints stand between them.
fn origins(robot: &Robot) -> Option<Vec<Isometry3<f64>>> {
    let mut before = 0;
    let mut origins = Vec::new();
    for link in robot.arm_links() {
        let joint = robot.links()[*link].joint.as_ref().filter(|joint| joint.parent == before)?;
        origins.push(joint.parent_from_joint);
        before = *link;
    }
    Some(origins)
}

/// The tool in the frame of the last link of the arm; `None` where the gripper moves it.
fn last_from_tool(robot: &Robot) -> Option<Isometry3<f64>> {
    let last = *robot.arm_links().last()?;
    let (mut link, mut pose) = (robot.tool().link, robot.tool().link_from_tool);
    while link != last {
        let joint = robot.links()[link].joint.as_ref().filter(|joint| joint.moving().is_none())?;
        pose = joint.parent_from_joint * pose;
        link = joint.parent;
    }
    Some(pose)
}
