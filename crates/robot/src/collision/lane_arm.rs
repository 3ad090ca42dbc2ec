//! The arm in `f32`, eight configurations at a time.

use super::arm::{Arm, JointMotion, MAX_JOINTS, Sphere};
use super::lanes::Lanes;
use super::sine::sin_cos;

/// Radii are larger by this in the fast checks: more than their rounding errors add up to.
///
/// Measured on the Panda within one meter of its base, positions are off by at most 2e-6 m.
pub const ROUNDING_MARGIN_M: f64 = 1e-5;
/// A rotation is used without products if its entries are this close to 0, 1 and -1.
const AXIS_TOLERANCE: f64 = 1e-9;

/// Positions of all joints; those that the arm lacks are zero.
pub type Configuration = [f32; MAX_JOINTS];

/// The constants of an arm.
#[derive(Clone, Debug)]
pub struct LaneArm {
    joints: Vec<LaneJoint>,
    pub bodies: Vec<LaneBody>,
    pub pairs: Vec<(usize, usize)>,
}

#[derive(Clone, Debug)]
struct LaneJoint {
    rotation: LaneRotation,
    translation_m: [f32; 3],
    motion: JointMotion,
}

#[derive(Clone, Debug)]
enum LaneRotation {
    /// Axis `k` of the child is `sign` times axis `source` of the parent.
    Axes([(usize, f32); 3]),
    /// `columns[k]` is axis `k` of the child in the parent.
    Columns([[f32; 3]; 3]),
}

/// A sphere in the frame of its body.
#[derive(Clone, Copy, Debug)]
pub struct LaneSphere {
    pub center_m: [f32; 3],
    pub radius_m: f32,
}

/// A body: its spheres, and one that encloses them.
#[derive(Clone, Debug)]
pub struct LaneBody {
    pub frame: usize,
    pub bounding: LaneSphere,
    pub spheres: Vec<LaneSphere>,
}

/// The axes and the origin of a frame in the frame of the base.
#[derive(Clone, Copy)]
pub struct LaneFrame<L> {
    axes: [[L; 3]; 3],
    origin_m: [L; 3],
}

impl LaneArm {
    /// The constants of `arm` with all radii larger by `padding_m`.
    pub fn new(arm: &Arm, padding_m: f64) -> Self {
        let lane_sphere = |sphere: &Sphere| LaneSphere {
            center_m: sphere.center_m.coords.map(|c| c as f32).into(),
            radius_m: (sphere.radius_m + padding_m + ROUNDING_MARGIN_M) as f32,
        };
        let bodies = arm.bodies().iter().zip(arm.bounding_spheres()).map(|(body, bounding)| LaneBody {
            frame: body.frame,
            bounding: lane_sphere(bounding),
            spheres: body.spheres.iter().map(lane_sphere).collect(),
        });
        let joints = arm.joints().iter().map(|joint| {
            let matrix = joint.parent_from_joint.rotation.to_rotation_matrix();
            let axis = |column: usize| {
                let parts: [f64; 3] = matrix.matrix().column(column).into_owned().into();
                let source = (0..3).find(|&row| (parts[row].abs() - 1.0).abs() < AXIS_TOLERANCE)?;
                let rest = (0..3).filter(|&row| row != source).all(|row| parts[row].abs() < AXIS_TOLERANCE);
                rest.then_some((source, parts[source].signum() as f32))
            };
            let rotation = match [axis(0), axis(1), axis(2)] {
                [Some(x), Some(y), Some(z)] => LaneRotation::Axes([x, y, z]),
                _ => LaneRotation::Columns(std::array::from_fn(|column| {
                    std::array::from_fn(|row| matrix[(row, column)] as f32)
                })),
            };
            let translation_m = joint.parent_from_joint.translation.vector.map(|c| c as f32).into();
            LaneJoint { rotation, translation_m, motion: joint.motion }
        });
        Self { joints: joints.collect(), bodies: bodies.collect(), pairs: arm.pairs().to_vec() }
    }

    pub fn dof(&self) -> usize {
        self.joints.len()
    }

    /// The frames of the base and of all joints; those beyond the last joint are copies of the base.
    #[inline(always)]
    pub fn frames<L: Lanes>(&self, token: L::Token, positions: &[L; MAX_JOINTS]) -> [LaneFrame<L>; MAX_JOINTS + 1] {
        let mut frames = [LaneFrame::base(token); MAX_JOINTS + 1];
        for (index, joint) in self.joints.iter().enumerate() {
            frames[index + 1] = frames[index].child(joint, positions[index]);
        }
        frames
    }
}

impl<L: Lanes> LaneFrame<L> {
    #[inline(always)]
    fn base(token: L::Token) -> Self {
        let (zero, one) = (L::splat(token, 0.0), L::splat(token, 1.0));
        Self { axes: [[one, zero, zero], [zero, one, zero], [zero, zero, one]], origin_m: [zero; 3] }
    }

    /// A direction of this frame in the frame of the base.
    #[inline(always)]
    fn turn(&self, [x, y, z]: [f32; 3]) -> [L; 3] {
        let [ax, ay, az] = self.axes;
        std::array::from_fn(|row| {
            let like = |value: f32| ax[row].like(value);
            ax[row] * like(x) + ay[row] * like(y) + az[row] * like(z)
        })
    }

    /// A point of this frame in the frame of the base.
    #[inline(always)]
    pub fn place(&self, point_m: [f32; 3]) -> [L; 3] {
        let turned = self.turn(point_m);
        std::array::from_fn(|row| turned[row] + self.origin_m[row])
    }

    #[inline(always)]
    fn child(&self, joint: &LaneJoint, position: L) -> Self {
        let [x, y, z] = match &joint.rotation {
            LaneRotation::Axes(sources) => {
                sources.map(|(source, sign)| self.axes[source].map(|part| part * part.like(sign)))
            }
            LaneRotation::Columns(columns) => columns.map(|column| self.turn(column)),
        };
        let mut origin_m = self.origin_m;
        for (axis, along_m) in self.axes.iter().zip(joint.translation_m) {
            if along_m != 0.0 {
                origin_m = std::array::from_fn(|row| origin_m[row] + axis[row] * axis[row].like(along_m));
            }
        }
        match joint.motion {
            JointMotion::Turn => {
                let (sine, cosine) = sin_cos(position);
                let turned_x = std::array::from_fn(|row| x[row] * cosine + y[row] * sine);
                let turned_y = std::array::from_fn(|row| y[row] * cosine - x[row] * sine);
                Self { axes: [turned_x, turned_y, z], origin_m }
            }
            JointMotion::Slide => {
                let origin_m = std::array::from_fn(|row| origin_m[row] + z[row] * position);
                Self { axes: [x, y, z], origin_m }
            }
        }
    }
}
