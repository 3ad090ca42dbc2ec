//! An arm as the planner sees it: joints with limits, and spheres that move with them, eight configurations at a time.
//!
//! All positions are in the frame of the robot's base, in meters. A *lane* is one of eight configurations: lane `k` of
//! every value belongs to configuration `k`.

use wide::f32x8;

use crate::model::limits::JointLimits;

/// A sphere that is fixed to a link.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LinkSphere {
    /// The index of the link, below `SphereModel::link_count`.
    pub link: usize,
    /// The center in the frame of the link.
    pub center_m: [f32; 3],
    pub radius_m: f32,
}

/// The poses of all links in eight configurations: `base_from_link` as a rotation matrix and a translation.
#[derive(Clone, Debug, Default)]
pub struct LinkPoses8 {
    pub links: Vec<LinkPose8>,
}

/// The pose of one link in eight configurations.
#[derive(Clone, Copy, Debug, Default)]
pub struct LinkPose8 {
    /// `rotation[row][column]`.
    pub rotation: [[f32x8; 3]; 3],
    pub translation_m: [f32x8; 3],
}

impl LinkPose8 {
    /// Position of a point of the link in the frame of the base: x, y and z.
    #[inline]
    pub fn place(&self, point_m: [f32; 3]) -> [f32x8; 3] {
        let [x, y, z] = point_m.map(f32x8::splat);
        let along = |row: usize| {
            let [rx, ry, rz] = self.rotation[row];
            rx.mul_add(x, ry.mul_add(y, rz.mul_add(z, self.translation_m[row])))
        };
        [along(0), along(1), along(2)]
    }
}

/// The centers of all spheres in eight configurations: entry `i` of each list belongs to `SphereModel::spheres()[i]`.
#[derive(Clone, Debug, Default)]
pub struct Spheres8 {
    pub x_m: Vec<f32x8>,
    pub y_m: Vec<f32x8>,
    pub z_m: Vec<f32x8>,
}

/// An arm with a fixed opening of the gripper, as a planner needs it.
///
/// Buffers are passed in and reused: a call makes them as long as it needs and allocates no more after the first one.
pub trait SphereModel: Sync {
    /// The number of joints that the planner moves.
    fn dof(&self) -> usize {
        self.limits().len()
    }

    /// The limits of each joint, in the order of the configuration.
    fn limits(&self) -> &[JointLimits];

    /// The number of links: the base, one for each joint, and those that are fixed to them.
    fn link_count(&self) -> usize;

    /// The spheres that cover the arm, ordered by link. Those of the base do not move.
    fn spheres(&self) -> &[LinkSphere];

    /// One sphere for each link that has spheres, ordered by link, that encloses all spheres of the link.
    fn bounding_spheres(&self) -> &[LinkSphere];

    /// The pairs of links, lower index first, whose spheres must not meet. A link is in no pair with its neighbors.
    fn self_collision_pairs(&self) -> &[(usize, usize)];

    /// Computes the pose of each link; `positions[joint]` holds the eight positions of a joint and has length `dof`.
    fn place_links8(&self, positions: &[f32x8], out: &mut LinkPoses8);

    /// Computes the center of each sphere; see `place_links8`.
    fn place_spheres8(&self, positions: &[f32x8], out: &mut Spheres8) {
        let mut poses = LinkPoses8::default();
        self.place_links8(positions, &mut poses);
        out.place(self.spheres(), &poses);
    }
}

impl Spheres8 {
    /// Computes the centers of `spheres` from the poses of their links.
    pub fn place(&mut self, spheres: &[LinkSphere], poses: &LinkPoses8) {
        for list in [&mut self.x_m, &mut self.y_m, &mut self.z_m] {
            list.resize(spheres.len(), f32x8::ZERO);
        }
        for (i, sphere) in spheres.iter().enumerate() {
            [self.x_m[i], self.y_m[i], self.z_m[i]] = poses.links[sphere.link].place(sphere.center_m);
        }
    }
}
