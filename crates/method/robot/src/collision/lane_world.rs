//! Obstacles in `f32`, tested against eight spheres at a time.

use nalgebra::{Isometry3, Point3};

use super::lane_vector::LaneVector;
use super::lanes::{LANE_COUNT, Lanes};
use super::obstacle::{Obstacle, Solid};
use super::polyhedron::ConvexPolyhedron;

/// All obstacles, with their boxes in groups of eight.
#[derive(Clone, Debug, Default)]
pub struct LaneWorld {
    boxes: Vec<BoxGroup>,
    pub obstacles: Vec<LaneObstacle>,
}

/// The axis-aligned boxes of eight obstacles: `low_m[axis][obstacle]`.
#[derive(Clone, Debug)]
struct BoxGroup {
    low_m: [[f32; LANE_COUNT]; 3],
    high_m: [[f32; LANE_COUNT]; 3],
}

/// One obstacle.
#[derive(Clone, Debug)]
pub enum LaneObstacle {
    Sphere { center_m: [f32; 3], radius_m: f32 },
    Cuboid { frame: SolidFrame, half_extents_m: [f32; 3] },
    Cylinder { center_m: [f32; 3], axis: [f32; 3], radius_m: f32, half_length_m: f32 },
    Capsule { center_m: [f32; 3], axis: [f32; 3], radius_m: f32, half_length_m: f32 },
    Hull(Box<LaneHull>),
}

/// Pose of a solid: its center and its axes in the frame of the base.
#[derive(Clone, Debug)]
pub struct SolidFrame {
    center_m: [f32; 3],
    axes: [[f32; 3]; 3],
}

/// A convex polyhedron: planes in the frame of the base, and the exact solid for what is near an edge.
#[derive(Clone, Debug)]
pub struct LaneHull {
    planes: Vec<([f32; 3], f32)>,
    exact: ConvexPolyhedron,
    base_from_solid: Isometry3<f64>,
}

impl LaneWorld {
    pub fn new(obstacles: &[Obstacle]) -> Self {
        let bounds: Vec<_> = obstacles.iter().map(Obstacle::bounds_m).collect();
        let boxes = bounds.chunks(LANE_COUNT).map(|group| {
            // A place without an obstacle has a box that overlaps none.
            let corner = |empty: f32, pick: &dyn Fn(usize, usize) -> f64| {
                std::array::from_fn(|axis| {
                    std::array::from_fn(|k| if k < group.len() { pick(k, axis) as f32 } else { empty })
                })
            };
            BoxGroup {
                low_m: corner(f32::INFINITY, &|k, axis| group[k].0[axis]),
                high_m: corner(f32::NEG_INFINITY, &|k, axis| group[k].1[axis]),
            }
        });
        Self { boxes: boxes.collect(), obstacles: obstacles.iter().map(LaneObstacle::new).collect() }
    }

    /// The number of groups of eight obstacles.
    pub fn group_count(&self) -> usize {
        self.boxes.len()
    }

    /// The obstacles of a group whose boxes meet the one from `low` to `high`: bit `k` is obstacle `8 group + k`.
    #[inline(always)]
    pub fn near<L: Lanes>(&self, group: usize, low: LaneVector<L>, high: LaneVector<L>) -> u8 {
        let token = low.x.token();
        let [low_x, low_y, low_z] = self.boxes[group].low_m;
        let [high_x, high_y, high_z] = self.boxes[group].high_m;
        L::from_array(token, low_x).below(high.x)
            & L::from_array(token, low_y).below(high.y)
            & L::from_array(token, low_z).below(high.z)
            & low.x.below(L::from_array(token, high_x))
            & low.y.below(L::from_array(token, high_y))
            & low.z.below(L::from_array(token, high_z))
    }
}

impl LaneObstacle {
    fn new(obstacle: &Obstacle) -> Self {
        let pose = obstacle.base_from_solid();
        let center_m = pose.translation.vector.map(|c| c as f32).into();
        let rotation = pose.rotation.to_rotation_matrix();
        let axis = |k: usize| -> [f32; 3] { std::array::from_fn(|row| rotation[(row, k)] as f32) };
        match obstacle.solid() {
            Solid::Sphere { radius_m } => Self::Sphere { center_m, radius_m: *radius_m as f32 },
            Solid::Cuboid { half_extents_m } => Self::Cuboid {
                frame: SolidFrame { center_m, axes: [axis(0), axis(1), axis(2)] },
                half_extents_m: half_extents_m.map(|half_m| half_m as f32).into(),
            },
            Solid::Cylinder { radius_m, half_length_m } => Self::Cylinder {
                center_m,
                axis: axis(2),
                radius_m: *radius_m as f32,
                half_length_m: *half_length_m as f32,
            },
            Solid::Capsule { radius_m, half_length_m } => Self::Capsule {
                center_m,
                axis: axis(2),
                radius_m: *radius_m as f32,
                half_length_m: *half_length_m as f32,
            },
            Solid::Hull(hull) => Self::Hull(Box::new(LaneHull::new(hull, *pose))),
        }
    }

    /// The spheres that touch the obstacle: bit `k` for the sphere around lane `k` of `center_m`.
    #[inline(always)]
    pub fn hits<L: Lanes>(&self, center_m: LaneVector<L>, radius_m: f32) -> u8 {
        let zero = center_m.x.like(0.0);
        match self {
            Self::Sphere { center_m: origin_m, radius_m: other_m } => {
                let reach_m = radius_m + other_m;
                center_m.minus(*origin_m).square().below(zero.like(reach_m * reach_m))
            }
            Self::Cuboid { frame, half_extents_m: [half_x, half_y, half_z] } => {
                let offset = center_m.minus(frame.center_m);
                let excess = LaneVector {
                    x: (offset.dot(frame.axes[0]).abs() - zero.like(*half_x)).max(zero),
                    y: (offset.dot(frame.axes[1]).abs() - zero.like(*half_y)).max(zero),
                    z: (offset.dot(frame.axes[2]).abs() - zero.like(*half_z)).max(zero),
                };
                excess.square().below(zero.like(radius_m * radius_m))
            }
            Self::Cylinder { center_m: origin_m, axis, radius_m: other_m, half_length_m } => {
                let offset = center_m.minus(*origin_m);
                let along = offset.dot(*axis);
                let across = offset - LaneVector::splat(zero.token(), *axis).times(along);
                let radial = (across.square().sqrt() - zero.like(*other_m)).max(zero);
                let axial = (along.abs() - zero.like(*half_length_m)).max(zero);
                (radial * radial + axial * axial).below(zero.like(radius_m * radius_m))
            }
            Self::Capsule { center_m: origin_m, axis, radius_m: other_m, half_length_m } => {
                let offset = center_m.minus(*origin_m);
                let along = offset.dot(*axis).max(zero.like(-half_length_m)).min(zero.like(*half_length_m));
                let across = offset - LaneVector::splat(zero.token(), *axis).times(along);
                let reach_m = radius_m + other_m;
                across.square().below(zero.like(reach_m * reach_m))
            }
            Self::Hull(hull) => hull.hits(center_m, radius_m),
        }
    }
}

impl LaneHull {
    fn new(hull: &ConvexPolyhedron, base_from_solid: Isometry3<f64>) -> Self {
        let planes = hull.planes().iter().map(|plane| {
            let normal = base_from_solid.rotation * plane.normal;
            let offset_m = plane.offset_m + normal.dot(&base_from_solid.translation.vector);
            (normal.map(|c| c as f32).into(), offset_m as f32)
        });
        Self { planes: planes.collect(), exact: hull.clone(), base_from_solid }
    }

    /// A sphere farther than its radius from one plane is apart; one that is on the inner side of all touches. What is
    /// between, near an edge or a corner, is measured exactly.
    #[inline(always)]
    fn hits<L: Lanes>(&self, center_m: LaneVector<L>, radius_m: f32) -> u8 {
        let radius = center_m.x.like(radius_m);
        let mut highest = radius.like(f32::NEG_INFINITY);
        for (normal, offset_m) in &self.planes {
            highest = highest.max(center_m.dot(*normal) - radius.like(*offset_m));
            if highest.below(radius) == 0 {
                return 0;
            }
        }
        let near = highest.below(radius);
        let outside = near & radius.like(0.0).below(highest);
        if outside == 0 {
            return near;
        }
        let centers_m = [center_m.x.to_array(), center_m.y.to_array(), center_m.z.to_array()];
        near & !self.apart(outside, centers_m, radius_m)
    }

    /// The lanes of `asked` whose sphere does not touch the solid.
    #[cold]
    #[inline(never)]
    fn apart(&self, asked: u8, [x, y, z]: [[f32; LANE_COUNT]; 3], radius_m: f32) -> u8 {
        let is_apart = |lane: usize| {
            let center = Point3::new(f64::from(x[lane]), f64::from(y[lane]), f64::from(z[lane]));
            let in_solid = self.base_from_solid.inverse_transform_point(&center);
            self.exact.signed_distance_m(&in_solid) >= f64::from(radius_m)
        };
        (0..LANE_COUNT)
            .filter(|&lane| asked & (1 << lane) != 0 && is_apart(lane))
            .fold(0, |bits, lane| bits | 1 << lane)
    }
}
