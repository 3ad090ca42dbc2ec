//! Cameras of the paper's "Camera Sweep Protocol": 160 views of a scene, from straight above to the front.
//!
//! The paper gives elevations from 90 to 0 degrees in steps of 10, and 16 distances from 1.0 to 2.5 times the scene's
//! radius: 10 x 16 views that differ in nothing else. It leaves open what the radius is, from which side the table is
//! seen, and the field of view. Here:
//!
//! - The scene is the table's top and the objects, without legs: the vertices of the objects, and those of the table
//!   within [`Tabletop::TOP_DEPTH_M`] of its highest point.
//! - Its center is the center of the axis-aligned box of these points, its radius the distance to the farthest of them.
//! - All cameras stand before the table's front edge (azimuth 0), with their optical axis through the center.
//! - The field of view is 60 degrees along the shorter side of the image, the default of PyTorch3D. The whole sphere is
//!   visible from twice the radius on; nearer cameras cut it.
//!
//! World frame, meters; straight from above, +y is up in the image.

use glam::DVec3;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use geometry::{Camera, Pose, TexturedMesh};
use imaging::Image;
use render::{RenderObject, Tabletop};
use vision::lpips::MIN_SIDE_PX;

/// Elevations of the sweep, degrees above the horizon, in its order.
const ELEVATIONS_DEG: [u32; 10] = [90, 80, 70, 60, 50, 40, 30, 20, 10, 0];

/// Distances of the sweep, tenths of the scene's radius, in its order.
const DISTANCES_TENTHS: std::ops::RangeInclusive<u32> = 10..=25;

/// A table with the objects on it, in the world.
#[derive(Clone, Debug)]
pub struct SweptScene<'a> {
    pub table: RenderObject<'a>,
    pub objects: Vec<RenderObject<'a>>,
}

/// Center and radius of a scene, meters.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BoundingSphere {
    pub center_m: DVec3,
    pub radius_m: f64,
}

/// One place of the sweep.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct SweepView {
    /// Above the horizon, degrees; 90 is straight from above.
    #[schemars(range(min = 0, max = 90))]
    pub elevation_deg: u32,
    /// Distance from the scene's center over the scene's radius.
    #[schemars(range(min = 1.0, max = 2.5))]
    pub distance_radii: f64,
}

/// The cameras around one scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sweep {
    sphere: BoundingSphere,
}

/// Reason why a scene has no sweep.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SweepError {
    #[error(
        "placing cameras around the scene: its table and objects have no extent (radius {radius_m} m); give meshes \
         with triangles and finite coordinates"
    )]
    NoExtent { radius_m: f64 },
}

impl<'a> SweptScene<'a> {
    /// The scene of meshes with their poses in the world, the table's first, as a bundle lists them; `None` without a
    /// table.
    pub fn of(meshes: &'a [(TexturedMesh, Pose)]) -> Option<Self> {
        let object = |((mesh, world_from_object), id): (&'a (TexturedMesh, Pose), u32)| RenderObject {
            mesh,
            world_from_object: *world_from_object,
            id,
        };
        let mut all = meshes.iter().zip(1..).map(object);
        Some(Self { table: all.next()?, objects: all.collect() })
    }

    /// The vertices that count for the sphere, in the world.
    fn points_m(&self) -> Vec<DVec3> {
        let mut table = points_m(&self.table);
        let highest_m = table.iter().fold(f64::NEG_INFINITY, |highest, point| highest.max(point.z));
        table.retain(|point| point.z > highest_m - Tabletop::TOP_DEPTH_M);
        table.extend(self.objects.iter().flat_map(points_m));
        table
    }
}

/// The vertices of an object in the world.
pub(crate) fn points_m(object: &RenderObject) -> Vec<DVec3> {
    object.mesh.positions.iter().map(|p| object.world_from_object.transform_point(*p)).collect()
}

impl BoundingSphere {
    /// The sphere of a scene.
    pub fn of(scene: &SweptScene) -> Self {
        let points_m = scene.points_m();
        let (low_m, high_m) = points_m
            .iter()
            .fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), p| (low.min(*p), high.max(*p)));
        let center_m = 0.5 * (low_m + high_m);
        let radius_m = points_m.iter().map(|point| point.distance(center_m)).fold(0.0, f64::max);
        Self { center_m, radius_m }
    }
}

impl Sweep {
    /// Field of view along the shorter side of the image, degrees.
    pub const FIELD_OF_VIEW_DEG: f64 = 60.0;

    /// Longest side of a view, pixels. LPIPS depends on it, so it is part of the protocol; the paper does not state its
    /// own.
    pub const LONGEST_SIDE_PX: u32 = 512;

    /// The sweep around a scene.
    ///
    /// # Errors
    ///
    /// [`SweepError::NoExtent`] if the scene has no size.
    pub fn around(scene: &SweptScene) -> Result<Self, SweepError> {
        let sphere = BoundingSphere::of(scene);
        let radius_m = sphere.radius_m;
        if radius_m.is_finite() && radius_m > 1e-6 && sphere.center_m.is_finite() {
            return Ok(Self { sphere });
        }
        Err(SweepError::NoExtent { radius_m })
    }

    /// The places of the sweep: elevations from above downward, for each the distances from near to far.
    pub fn views() -> impl Iterator<Item = SweepView> {
        ELEVATIONS_DEG.into_iter().flat_map(|elevation_deg| {
            let place = move |tenths| SweepView { elevation_deg, distance_radii: f64::from(tenths) / 10.0 };
            DISTANCES_TENTHS.map(place)
        })
    }

    /// Width and height of the views that are compared with a reference image, pixels: its proportions, with
    /// [`Self::LONGEST_SIDE_PX`] along the longer side. Very long images are compared in less extreme ones.
    pub fn size_px(reference: &Image) -> [u32; 2] {
        let sides = [reference.width_px(), reference.height_px()].map(f64::from);
        let longest = sides[0].max(sides[1]).max(1.0);
        let scaled = |side: f64| (f64::from(Self::LONGEST_SIDE_PX) * side / longest).round() as u32;
        sides.map(|side| scaled(side).max(MIN_SIDE_PX))
    }

    /// Center and radius of the scene.
    pub fn sphere(&self) -> BoundingSphere {
        self.sphere
    }

    /// The camera of a view, for images of that width and height in pixels.
    pub fn camera(&self, view: &SweepView, [width_px, height_px]: [u32; 2]) -> Camera {
        let half = (0.5 * Self::FIELD_OF_VIEW_DEG.to_radians()).tan();
        let across = half * f64::from(width_px) / f64::from(width_px.min(height_px));
        let elevation_rad = f64::from(view.elevation_deg).to_radians();
        let distance_m = view.distance_radii * self.sphere.radius_m;
        let fov_x_rad = 2.0 * across.atan();
        Camera::orbit(width_px, height_px, fov_x_rad, self.sphere.center_m, 0.0, elevation_rad, distance_m)
    }
}

#[cfg(test)]
mod tests;
