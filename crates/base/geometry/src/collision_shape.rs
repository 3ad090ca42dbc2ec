//! Convex hulls prepared for queries: parry's convex polyhedra with their bounding boxes.
//!
//! Casts, contacts and rigid-body simulation share this conversion of hulls to parry shapes. Object frame, meters.

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

/// A hull that is not a valid convex polyhedron.
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

    /// Axis-aligned box of each part in the world.
    pub(crate) fn part_boxes(&self, world_from_object: &Pose) -> Vec<(DVec3, DVec3)> {
        self.parts.iter().map(|part| bounds(&part.points, world_from_object)).collect()
    }

    /// Lowest and highest corner of the axis-aligned box in the world.
    pub fn bounds(&self, world_from_object: &Pose) -> (DVec3, DVec3) {
        self.part_boxes(world_from_object)
            .into_iter()
            .fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), (l, h)| (low.min(l), high.max(h)))
    }

    /// Volume-weighted mean of the parts' centers, object frame; overlaps count twice.
    pub fn center_of_volume_m(&self) -> DVec3 {
        let parts = self.parts.iter().map(|part| part.polyhedron.mass_properties(1.0));
        let (moment, volume) = parts.fold((DVec3::ZERO, 0.0), |(moment, volume), part| {
            (moment + part.mass() * part.local_com, volume + part.mass())
        });
        moment / volume.max(f64::MIN_POSITIVE)
    }

    /// The shape with each part scaled by `share` about its own center.
    pub fn slimmer(&self, share: f64) -> Self {
        let slim = |part: &Part| {
            let center = part.points.iter().sum::<DVec3>() / part.points.len().max(1) as f64;
            let points: Vec<DVec3> = part.points.iter().map(|p| center.lerp(*p, share)).collect();
            let slim = ConvexPolyhedron::from_convex_hull(&points);
            slim.map_or_else(|| part.clone(), |slim| Part { points, polyhedron: SharedShape::new(slim) })
        };
        Self { parts: self.parts.iter().map(slim).collect() }
    }

    /// All corners of all parts in the world.
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

/// Converts a pose to parry's type.
pub fn to_parry(pose: &Pose) -> ParryPose {
    ParryPose::from_parts(pose.translation_m, pose.rotation)
}

/// Converts a pose from parry's type.
pub fn from_parry(pose: &ParryPose) -> Pose {
    let rotation: DQuat = pose.rotation;
    Pose { translation_m: pose.translation, rotation: rotation.normalize() }
}
