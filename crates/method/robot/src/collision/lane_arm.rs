//! The arm in `f32`, eight configurations at a time.

use super::arm::{Arm, JointMotion, MAX_JOINTS, Sphere};
use super::lane_vector::LaneVector;
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
    axes: [LaneVector<L>; 3],
    origin_m: LaneVector<L>,
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

    /// Computes the frame of each joint; entry 0 is the base, which `frames` must hold already.
    #[inline(always)]
    pub fn place_frames<L: Lanes>(
        &self,
        positions: &[L; MAX_JOINTS],
        frames: &mut [LaneFrame<L>; MAX_JOINTS + 1],
    ) {
        for index in 0..self.joints.len().min(MAX_JOINTS) {
            frames[index + 1] = frames[index].child(&self.joints[index], positions[index]);
        }
    }
}

impl<L: Lanes> LaneFrame<L> {
    #[inline(always)]
    pub fn base(token: L::Token) -> Self {
        let axes = [
            LaneVector::splat(token, [1.0, 0.0, 0.0]),
            LaneVector::splat(token, [0.0, 1.0, 0.0]),
            LaneVector::splat(token, [0.0, 0.0, 1.0]),
        ];
        Self { axes, origin_m: LaneVector::splat(token, [0.0; 3]) }
    }

    /// A direction of this frame in the frame of the base.
    #[inline(always)]
    fn turn(&self, [x, y, z]: [f32; 3]) -> LaneVector<L> {
        self.axes[0].scaled(x) + self.axes[1].scaled(y) + self.axes[2].scaled(z)
    }

    /// A point of this frame in the frame of the base.
    #[inline(always)]
    pub fn place(&self, point_m: [f32; 3]) -> LaneVector<L> {
        self.turn(point_m) + self.origin_m
    }

    #[inline(always)]
    fn child(&self, joint: &LaneJoint, position: L) -> Self {
        let [x, y, z] = match &joint.rotation {
            LaneRotation::Axes([(x, x_sign), (y, y_sign), (z, z_sign)]) => {
                [self.axes[*x].scaled(*x_sign), self.axes[*y].scaled(*y_sign), self.axes[*z].scaled(*z_sign)]
            }
            LaneRotation::Columns([x, y, z]) => [self.turn(*x), self.turn(*y), self.turn(*z)],
        };
        let mut origin_m = self.origin_m;
        for axis in 0..3 {
            if joint.translation_m[axis] != 0.0 {
                origin_m = origin_m + self.axes[axis].scaled(joint.translation_m[axis]);
            }
        }
        match joint.motion {
            JointMotion::Turn => {
                let (sine, cosine) = sin_cos(position);
                let turned_x = x.times(cosine) + y.times(sine);
                let turned_y = y.times(cosine) - x.times(sine);
                Self { axes: [turned_x, turned_y, z], origin_m }
            }
            JointMotion::Slide => Self { axes: [x, y, z], origin_m: origin_m + z.times(position) },
        }
    }
}
