//! Hulls prepared for queries: parry's convex polyhedra with their boxes.
//!
//! The one place where our hulls become parry shapes; casts, contacts and rigid-body simulation share it.
//! Object frame, meters.

use glam::{DQuat, DVec3};
use parry3d_f64::math::Pose as ParryPose;
use parry3d_f64::shape::{ConvexPolyhedron, SharedShape};

use super::{ConvexHull, Pose};

/// Convex parts of one object.
#[derive(Clone)]
pub struct CollisionShape {
    parts: Vec<Part>,
}

#[derive(Clone)]
pub(crate) struct Part {
    pub polyhedron: SharedShape,
    pub points: Vec<DVec3>,
}

/// A hull that no query can use.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("hull {hull} with {points} corners is flat or broken; decompose the mesh again")]
pub struct BrokenHull {
    pub hull: usize,
    pub points: usize,
}

impl CollisionShape {
    pub fn new(hulls: &[ConvexHull]) -> Result<Self, BrokenHull> {
        let parts = hulls
            .iter()
            .enumerate()
            .map(|(index, hull)| {
                ConvexPolyhedron::from_convex_mesh(hull.points.clone(), &hull.triangles)
                    .or_else(|| ConvexPolyhedron::from_convex_hull(&hull.points))
                    .map(|polyhedron| Part {
                        points: polyhedron.points().to_vec(),
                        polyhedron: SharedShape::new(polyhedron),
                    })
                    .ok_or(BrokenHull { hull: index, points: hull.points.len() })
            })
            .collect::<Result<_, _>>()?;
        Ok(Self { parts })
    }

    pub(crate) fn parts(&self) -> &[Part] {
        &self.parts
    }

    /// Box of each part after the pose.
    pub(crate) fn part_boxes(&self, world_from_object: &Pose) -> Vec<(DVec3, DVec3)> {
        self.parts.iter().map(|part| bounds(&part.points, world_from_object)).collect()
    }

    /// Lowest and highest corner of the axis-aligned box after the pose.
    pub fn bounds(&self, world_from_object: &Pose) -> (DVec3, DVec3) {
        self.part_boxes(world_from_object)
            .into_iter()
            .fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), (l, h)| (low.min(l), high.max(h)))
    }

    /// Middle of the parts' volumes, object frame; where parts overlap, twice.
    pub fn center_of_volume_m(&self) -> DVec3 {
        let parts = self.parts.iter().map(|part| part.polyhedron.mass_properties(1.0));
        let (moment, volume) = parts.fold((DVec3::ZERO, 0.0), |(moment, volume), part| {
            (moment + part.mass() * part.local_com, volume + part.mass())
        });
        moment / volume.max(f64::MIN_POSITIVE)
    }

    /// The same with each part drawn together toward its own middle; `share` of its size is left.
    pub fn slimmer(&self, share: f64) -> Self {
        let slim = |part: &Part| {
            let middle = part.points.iter().sum::<DVec3>() / part.points.len().max(1) as f64;
            let points: Vec<DVec3> = part.points.iter().map(|p| middle.lerp(*p, share)).collect();
            let slim = ConvexPolyhedron::from_convex_hull(&points);
            slim.map_or_else(|| part.clone(), |slim| Part { points, polyhedron: SharedShape::new(slim) })
        };
        Self { parts: self.parts.iter().map(slim).collect() }
    }

    /// Every corner of every part after the pose.
    pub fn points(&self, world_from_object: &Pose) -> impl Iterator<Item = DVec3> + '_ {
        let pose = *world_from_object;
        self.parts.iter().flat_map(move |part| part.points.iter().map(move |&p| pose.transform_point(p)))
    }
}

fn bounds(points: &[DVec3], pose: &Pose) -> (DVec3, DVec3) {
    points
        .iter()
        .map(|&p| pose.transform_point(p))
        .fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), p| (low.min(p), high.max(p)))
}

/// Our pose as parry's.
pub fn to_parry(pose: &Pose) -> ParryPose {
    ParryPose::from_parts(pose.translation_m, pose.rotation)
}

/// Parry's pose as ours.
pub fn from_parry(pose: &ParryPose) -> Pose {
    let rotation: DQuat = pose.rotation;
    Pose { translation_m: pose.translation, rotation: rotation.normalize() }
}
