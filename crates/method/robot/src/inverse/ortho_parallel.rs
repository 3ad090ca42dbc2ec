//! Six joints with an ortho-parallel base and a spherical wrist, in closed form.
//!
//! The first axis is perpendicular to the second, the third parallel to the second, and the last three meet.
//! Lengths are those of Brandstötter, Angerer and Hofbaur, "An analytical solution of the inverse kinematics problem
//! of industrial serial manipulators with an ortho-parallel basis and a spherical wrist" (2014). They are found from
//! the joint axes at position zero, so that any placement of frames, sign and zero of the joints is accepted.
//!
//! The wrist's center decides the first three joints: two ways to face it, two ways to bend the elbow. The rest of the
//! rotation decides the last three, in two ways. Each way is one solution, eight in all.

use nalgebra::{Isometry3, Matrix3, Point3, Rotation3, Translation3, UnitQuaternion, Vector3};

use super::angles::{about_y, about_z, all_within, zyz};
use crate::kinematics::link_poses;
use crate::model::{JointLimits, MovingKind, Robot};

/// The geometry of an arm with an ortho-parallel base and a spherical wrist.
#[derive(Clone, Debug)]
pub struct OrthoParallel {
    /// z along the first axis, y along the second, the origin where the first axis is nearest to the second.
    base_from_shoulder: Isometry3<f64>,
    wrist_from_tool: Isometry3<f64>,
    /// Distance of the second axis in front of the first.
    shoulder_m: f64,
    /// Distance of the arm's plane beside the first axis.
    side_m: f64,
    upper_arm_m: f64,
    /// From the third axis to the wrist's center: along the fourth axis, and across it.
    forearm_m: f64,
    elbow_m: f64,
    /// The third joint turns against the second where this is -1.
    elbow_sign: f64,
    /// The angles of the geometry at position zero of the joints.
    zero_rad: [f64; 6],
    limits: [JointLimits; 6],
}

/// Deviations above this are another geometry.
const TOLERANCE: f64 = 1e-9;

impl OrthoParallel {
    /// Finds the geometry of `robot`; `None` where its arm has another one.
    pub fn recognize(robot: &Robot) -> Option<Self> {
        let limits: [JointLimits; 6] = robot.limits().try_into().ok()?;
        if robot.arm_joints().any(|joint| joint.kind != MovingKind::Revolute) {
            return None;
        }
        let poses = link_poses(robot, &[0.0; 6], 0.0);
        let carried = || robot.arm_links().iter().map(|link| &poses[*link]);
        let axes: Vec<Vector3<f64>> = carried()
            .zip(robot.arm_joints())
            .map(|(pose, joint)| pose.rotation * joint.axis.into_inner())
            .collect();
        let points: Vec<Vector3<f64>> = carried().map(|pose| pose.translation.vector).collect();
        let are_square = |a: usize, b: usize| axes[a].dot(&axes[b]).abs() < TOLERANCE;
        let are_parallel = axes[1].cross(&axes[2]).norm() < TOLERANCE;
        if !are_parallel || ![(0, 1), (1, 3), (3, 4), (4, 5)].iter().all(|(a, b)| are_square(*a, *b)) {
            return None;
        }
        let center = crossing(&points[3], &axes[3], &points[4], &axes[4])?;
        let misses = (center - points[5]).cross(&axes[5]).norm();
        if misses > TOLERANCE {
            return None;
        }

        let origin = points[0] + axes[0] * (points[1] - points[0]).dot(&axes[0]);
        let rotation = Rotation3::from_matrix_unchecked(Matrix3::from_columns(&[
            axes[1].cross(&axes[0]),
            axes[1],
            axes[0],
        ]));
        let base_from_shoulder = Isometry3::from_parts(
            Translation3::from(origin),
            UnitQuaternion::from_rotation_matrix(&rotation),
        );
        let local =
            |point: &Vector3<f64>| base_from_shoulder.inverse_transform_point(&Point3::from(*point)).coords;
        let turned = |axis: &Vector3<f64>| rotation.inverse() * axis;
        let (shoulder, elbow, wrist) = (local(&points[1]), local(&points[2]), local(&center));
        let upper_arm = elbow - shoulder;
        let along = turned(&axes[3]);
        let pitch = f64::atan2(along.x, along.z);
        let raise = f64::atan2(upper_arm.x, upper_arm.z);
        let forearm = wrist - elbow;

        let beyond = about_y(-pitch) * turned(&axes[4]);
        let roll = f64::atan2(-beyond.x, beyond.y);
        let last = about_z(-roll) * about_y(-pitch) * turned(&axes[5]);
        let bend = f64::atan2(last.x, last.z);
        let wrist_rotation = about_y(pitch) * about_z(roll) * about_y(bend);
        let shoulder_from_wrist = Isometry3::from_parts(
            Translation3::from(wrist),
            UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(wrist_rotation)),
        );
        let tool = robot.tool();
        let base_from_tool = poses[tool.link] * tool.link_from_tool;
        Some(Self {
            wrist_from_tool: (base_from_shoulder * shoulder_from_wrist).inverse() * base_from_tool,
            base_from_shoulder,
            shoulder_m: shoulder.x,
            side_m: wrist.y,
            upper_arm_m: upper_arm.x.hypot(upper_arm.z),
            forearm_m: forearm.x * pitch.sin() + forearm.z * pitch.cos(),
            elbow_m: forearm.x * pitch.cos() - forearm.z * pitch.sin(),
            elbow_sign: axes[1].dot(&axes[2]).signum(),
            zero_rad: [0.0, raise, pitch - raise, roll, bend, 0.0],
            limits,
        })
    }

    /// Computes all configurations within limits that put the tool at `base_from_tool`, at most eight.
    pub fn solve(&self, base_from_tool: &Isometry3<f64>) -> Vec<[f64; 6]> {
        let shoulder_from_wrist =
            self.base_from_shoulder.inverse() * base_from_tool * self.wrist_from_tool.inverse();
        let center = shoulder_from_wrist.translation.vector;
        let rotation = shoulder_from_wrist.rotation.to_rotation_matrix().into_inner();
        let mut solutions = Vec::new();
        for [first, second, third] in self.reach(&center) {
            let rest = (about_z(first) * about_y(second + third)).transpose() * rotation;
            for [fourth, fifth, sixth] in zyz(&rest) {
                let angles = [first, second, third, fourth, fifth, sixth];
                let mut positions: [f64; 6] = std::array::from_fn(|k| angles[k] - self.zero_rad[k]);
                positions[2] *= self.elbow_sign;
                solutions.extend(all_within(&self.limits, positions));
            }
        }
        solutions
    }

    /// The angles of the first three joints that put the wrist's center at `center`, at most four triples.
    fn reach(&self, center: &Vector3<f64>) -> impl Iterator<Item = [f64; 3]> {
        let ahead = (center.x.powi(2) + center.y.powi(2) - self.side_m.powi(2)).max(0.0).sqrt();
        let (upper, fore) = (self.upper_arm_m, self.forearm_m.hypot(self.elbow_m));
        let skew = f64::atan2(self.elbow_m, self.forearm_m);
        let (center, side, shoulder) = (*center, self.side_m, self.shoulder_m);
        [ahead, -ahead].into_iter().flat_map(move |ahead| {
            let first = f64::atan2(center.y, center.x) - f64::atan2(side, ahead);
            let (x, z) = (ahead - shoulder, center.z);
            let cosine = (x * x + z * z - upper * upper - fore * fore) / (2.0 * upper * fore);
            // Rounding may put a stretched arm just out of reach.
            let bend = (cosine.abs() <= 1.0 + 1e-12).then(|| cosine.clamp(-1.0, 1.0).acos());
            bend.into_iter().flat_map(|bend| [bend, -bend]).map(move |bend| {
                let second = f64::atan2(x, z) - f64::atan2(fore * bend.sin(), upper + fore * bend.cos());
                [first, second, bend - skew]
            })
        })
    }
}

/// The point where two lines cross; `None` where they are parallel or miss each other.
fn crossing(
    point: &Vector3<f64>,
    axis: &Vector3<f64>,
    other_point: &Vector3<f64>,
    other_axis: &Vector3<f64>,
) -> Option<Vector3<f64>> {
    let normal = axis.cross(other_axis);
    let between = other_point - point;
    if normal.norm() < TOLERANCE || between.dot(&normal).abs() > TOLERANCE * normal.norm() {
        return None;
    }
    Some(point + axis * (between.cross(other_axis).dot(&normal) / normal.norm_squared()))
}
