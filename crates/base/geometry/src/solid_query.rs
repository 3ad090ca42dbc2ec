//! Signed-distance queries of a visual mesh as a solid.
//!
//! Each closed shell of the mesh becomes a triangle mesh with a bounding-volume hierarchy and
//! pseudo-normals (Baerentzen and Aanaes, "Signed distance computation using the angle weighted
//! pseudonormal", 2005; parry's implementation). The solid is the union of the outward shells without
//! the cavities that inward shells bound; shells may overlap. Depths are exact for one shell and a lower
//! bound where shells overlap. Object frame, meters. A query costs a few microseconds.

use glam::DVec3;
use parry3d_f64::query::{PointQuery, PointQueryWithLocation, Ray, RayCast};
use parry3d_f64::shape::{TriMesh, TriMeshFlags};

use super::TexturedMesh;
use super::shells::{Shell, shells};

/// Solid enclosed by the closed shells of a mesh.
pub struct MeshSolid {
    shells: Vec<SolidShell>,
    low: DVec3,
    high: DVec3,
    watertight: bool,
}

/// One shell of a solid.
pub(crate) struct SolidShell {
    /// With pseudo-normals.
    pub surface: TriMesh,
    low: DVec3,
    high: DVec3,
    /// Whether its faces are oriented outward; otherwise it bounds a cavity.
    pub outward: bool,
}

/// Reason why a mesh bounds no solid.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum SolidError {
    #[error("the mesh has no triangle with area, so it bounds no solid; repair or replace it")]
    Empty,
    #[error("shell {shell} of the mesh cannot be indexed ({reason}); repair or replace the mesh")]
    Unusable { shell: usize, reason: String },
}

impl MeshSolid {
    pub fn new(mesh: &TexturedMesh) -> Result<Self, SolidError> {
        Self::from_shells(&shells(mesh))
    }

    /// From shells welded already.
    pub fn from_shells(shells: &[Shell]) -> Result<Self, SolidError> {
        let watertight = !shells.is_empty() && shells.iter().all(Shell::is_closed);
        let mut parts = Vec::with_capacity(shells.len());
        for (index, shell) in shells.iter().enumerate() {
            let unusable = |reason: String| SolidError::Unusable { shell: index, reason };
            let surface =
                TriMesh::with_flags(shell.points.clone(), shell.triangles.clone(), TriMeshFlags::ORIENTED)
                    .map_err(|error| unusable(error.to_string()))?;
            let (low, high) = shell.bounds();
            parts.push(SolidShell { surface, low, high, outward: shell.volume_m3() >= 0.0 });
        }
        let first = parts.first().ok_or(SolidError::Empty)?;
        let (low, high) =
            parts.iter().fold((first.low, first.high), |(low, high), s| (low.min(s.low), high.max(s.high)));
        Ok(Self { shells: parts, low, high, watertight })
    }

    /// Lowest and highest corner of the axis-aligned box in the object's frame.
    pub fn bounds(&self) -> (DVec3, DVec3) {
        (self.low, self.high)
    }

    /// Whether every shell is closed.
    pub fn is_watertight(&self) -> bool {
        self.watertight
    }

    /// Distance to the surface: positive inside the solid, negative outside.
    pub fn depth_m(&self, point: DVec3) -> f64 {
        self.depth_above(point, f64::NEG_INFINITY)
    }

    /// As [`depth_m`](Self::depth_m), but for points outside by more than `-floor_m` (a negative number) the result
    /// may be `f64::NEG_INFINITY`, which is faster.
    pub fn depth_above(&self, point: DVec3, floor_m: f64) -> f64 {
        self.locate(point, floor_m).map_or(f64::NEG_INFINITY, |found| found.depth_m)
    }

    /// Distance of a point outside the solid; 0 inside. Faster than [`depth_m`](Self::depth_m), because the
    /// search stops at the nearest shell found.
    pub fn outside_m(&self, point: DVec3) -> f64 {
        let mut nearest = f64::INFINITY;
        for shell in self.shells.iter().filter(|shell| shell.outward) {
            let outside_box = shell.box_distance_m(point);
            if outside_box >= nearest {
                continue;
            }
            // A point in the box may be deep inside, farther from this surface than from that of another shell.
            let reach = if outside_box > 0.0 { nearest } else { f64::INFINITY };
            let found = shell.surface.project_local_point_with_max_dist(point, false, reach);
            if let Some(projection) = found {
                let distance = (projection.point - point).length();
                nearest = if projection.is_inside { 0.0 } else { nearest.min(distance) };
            }
            if nearest == 0.0 {
                break;
            }
        }
        let in_hole = self.shells.iter().filter(|shell| !shell.outward).map(|hole| {
            if hole.box_distance_m(point) > 0.0 {
                return 0.0;
            }
            let projection = hole.surface.project_local_point(point, false);
            if projection.is_inside { 0.0 } else { (projection.point - point).length() }
        });
        in_hole.fold(nearest, f64::max)
    }

    /// As [`depth_m`](Self::depth_m), for one shell alone.
    pub fn depth_in_shell_m(&self, shell: usize, point: DVec3) -> f64 {
        let projection = self.shells[shell].surface.project_local_point(point, false);
        let distance = (projection.point - point).length();
        if projection.is_inside { distance } else { -distance }
    }

    /// Depth of a point with the nearest surface point of the shell that determines it.
    fn locate(&self, point: DVec3, floor_m: f64) -> Option<Located> {
        let reach = (-floor_m).max(0.0);
        let mut inside: Option<Located> = None;
        let mut cavity: Option<Located> = None;
        for (index, shell) in self.shells.iter().enumerate() {
            let outside_box = shell.box_distance_m(point);
            if outside_box > reach {
                continue;
            }
            // A shell farther away than the best one so far has no effect.
            if shell.outward && inside.is_some_and(|best| -outside_box < best.depth_m && outside_box > 0.0) {
                continue;
            }
            let (projection, _) = shell.surface.project_local_point_and_get_location(point, false);
            let distance = (projection.point - point).length();
            let depth_m = if projection.is_inside { distance } else { -distance };
            let here = Located { depth_m, shell: index, surface_point: projection.point };
            if shell.outward {
                if inside.is_none_or(|best| here.depth_m > best.depth_m) {
                    inside = Some(here);
                }
            } else if cavity.is_none_or(|best| here.depth_m < best.depth_m) {
                cavity = Some(here);
            }
        }
        match (inside, cavity) {
            (Some(solid), Some(hole)) if hole.depth_m < solid.depth_m => Some(hole),
            (solid, _) => solid,
        }
    }

    /// Upper bound of the depth of the triangle's points in the solid. In each shell the depth is at most the
    /// distance to any one face, whose maximum over a triangle is at a corner. A triangle on a face thus costs one
    /// query, however large it is.
    pub fn deepest_possible_m(&self, corners: [DVec3; 3]) -> f64 {
        let center = (corners[0] + corners[1] + corners[2]) / 3.0;
        let radius = corners.iter().map(|p| (*p - center).length()).fold(0.0, f64::max);
        let in_shell = |shell: &SolidShell| {
            let (projection, (face, _)) = shell.surface.project_local_point_and_get_location(center, false);
            let distance = (projection.point - center).length();
            let max_m = if projection.is_inside { radius + distance } else { radius - distance };
            if max_m <= 0.0 {
                return max_m;
            }
            let face = shell.surface.triangle(face);
            let off_face_m = corners.iter().map(|&p| (face.project_local_point(p, true).point - p).length());
            max_m.min(off_face_m.fold(0.0, f64::max))
        };
        let outward = self.shells.iter().filter(|shell| shell.outward);
        outward
            .filter(|shell| shell.box_distance_m(center) <= radius)
            .map(in_shell)
            .fold(f64::NEG_INFINITY, f64::max)
    }

    /// For a point inside: (depth, thickness of the wall it lies in), the wall measured from the
    /// nearest surface point through the point to the far side. `None` outside.
    ///
    /// Beside slivers, whose normals are rounded, the nearest face may say that a point outside lies inside. Of closed
    /// shells, rays from the point decide.
    pub fn depth_and_wall_m(&self, point: DVec3) -> Option<(f64, f64)> {
        let nearest = self.locate(point, 0.0).filter(|found| found.depth_m > 0.0)?;
        let is_doubtful = self.watertight && self.shells[nearest.shell].outward;
        let found = match is_doubtful && !self.shells[nearest.shell].encloses(point) {
            true => self.deepest_enclosing(point)?,
            false => nearest,
        };
        let inward = (point - found.surface_point).normalize_or_zero();
        let shell = &self.shells[found.shell];
        let beyond = shell.surface.cast_local_ray(&Ray::new(point, inward), f64::MAX, true);
        Some((found.depth_m, found.depth_m + beyond.unwrap_or(0.0)))
    }

    /// Of the outward shells that rays find around a point, the one in which it is deepest.
    fn deepest_enclosing(&self, point: DVec3) -> Option<Located> {
        let around =
            self.shells.iter().enumerate().filter(|(_, shell)| shell.outward && shell.encloses(point));
        let located = around.map(|(index, shell)| {
            let surface_point = shell.surface.project_local_point(point, false).point;
            Located { depth_m: (surface_point - point).length(), shell: index, surface_point }
        });
        located.max_by(|a, b| a.depth_m.total_cmp(&b.depth_m))
    }

    /// The shells in their order.
    pub(crate) fn shells(&self) -> &[SolidShell] {
        &self.shells
    }

    /// Corners of every triangle, shell after shell.
    pub fn triangles(&self) -> impl Iterator<Item = [DVec3; 3]> + '_ {
        self.shells.iter().flat_map(|shell| shell.surface.triangles().map(|t| [t.a, t.b, t.c]))
    }
}

impl SolidShell {
    /// Distance of a point outside the shell's box; 0 in it.
    pub(crate) fn box_distance_m(&self, point: DVec3) -> f64 {
        (self.low - point).max(point - self.high).max(DVec3::ZERO).length()
    }

    /// Whether a point is inside a closed shell: most of three rays from it cross the surface an odd number of times.
    fn encloses(&self, point: DVec3) -> bool {
        if self.box_distance_m(point) > 0.0 {
            return false;
        }
        // Along no axis or diagonal of a modeled object.
        let directions = [
            DVec3::new(0.36, 0.48, 0.8),
            DVec3::new(-0.615, 0.332, -0.715),
            DVec3::new(0.271, -0.893, 0.359),
        ];
        let odd = directions.iter().filter(|direction| self.crossings(point, **direction) % 2 == 1);
        odd.count() >= 2
    }

    /// Number of times that a ray crosses the surface, at most [`MAX_CROSSINGS`].
    fn crossings(&self, point: DVec3, direction: DVec3) -> usize {
        let (mut from, mut count) = (point, 0);
        while count < MAX_CROSSINGS
            && let Some(distance_m) = self.surface.cast_local_ray(&Ray::new(from, direction), f64::MAX, false)
        {
            from += (distance_m + BEYOND_SURFACE_M) * direction;
            count += 1;
        }
        count
    }
}

/// Step past a crossing, meters.
const BEYOND_SURFACE_M: f64 = 1e-7;
/// A ray that crosses a surface more often is stuck in it.
const MAX_CROSSINGS: usize = 256;

#[derive(Clone, Copy)]
struct Located {
    depth_m: f64,
    shell: usize,
    surface_point: DVec3,
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shapes::{block, lathe, shell_of_revolution, sphere};
    use crate::{Material, Rgb, Solid};
    use glam::DVec2;
    use proptest::prelude::*;

    fn mesh(solids: impl IntoIterator<Item = Solid>) -> TexturedMesh {
        let mut mesh = TexturedMesh::default();
        for solid in solids {
            mesh.add(solid, &Material::plain("plain", Rgb::hex(0x80_80_80), 0.5));
        }
        mesh
    }

    #[test]
    fn depth_of_a_mug_is_positive_in_its_wall_and_negative_in_its_cavity() {
        let profile = [DVec2::new(0.04, 0.0), DVec2::new(0.04, 0.1)];
        let mug = MeshSolid::new(&mesh([shell_of_revolution(&profile, 0.004, 0.006, 128)])).expect("a mug");
        assert!(mug.is_watertight());
        assert!(mug.depth_m(DVec3::new(0.0, 0.0, 0.05)) < -0.035);
        let (depth, wall) = mug.depth_and_wall_m(DVec3::new(0.0385, 0.0, 0.05)).expect("in the wall");
        assert!((depth - 0.0015).abs() < 1e-4 && (wall - 0.004).abs() < 1e-4, "{depth} {wall}");
        assert!((mug.depth_m(DVec3::new(0.0, 0.0, 0.003)) - 0.003).abs() < 1e-6);
        assert_eq!(mug.depth_and_wall_m(DVec3::new(0.1, 0.0, 0.0)), None);
        assert_eq!(mug.depth_above(DVec3::new(0.1, 0.0, 0.0), -0.001), f64::NEG_INFINITY);
    }

    #[test]
    fn depth_treats_overlapping_shells_as_union_and_inward_shells_as_cavities() {
        let cube = block(DVec3::splat(0.1));
        let shifted = cube.clone().translated(DVec3::new(0.06, 0.0, 0.0));
        let pair = MeshSolid::new(&mesh([cube.clone(), shifted])).expect("two cubes");
        assert!(pair.depth_m(DVec3::new(0.03, 0.0, 0.05)) > 0.019);
        // A lid that reaches into the block a little: points deep in the block are nearer to the lid.
        let lid = block(DVec3::new(0.3, 0.3, 0.01)).translated(DVec3::new(0.0, 0.0, 0.099));
        let closed = MeshSolid::new(&mesh([lid, cube.clone()])).expect("a block with a lid");
        assert_eq!(closed.outside_m(DVec3::new(0.0, 0.0, 0.065)), 0.0);
        assert!((closed.outside_m(DVec3::new(0.1, 0.0, 0.065)) - 0.034).abs() < 1e-9);
        let mut hole = block(DVec3::splat(0.05)).translated(DVec3::new(0.0, 0.0, 0.025));
        hole.triangles.iter_mut().for_each(|t| t.swap(1, 2));
        let hollow = MeshSolid::new(&mesh([cube, hole])).expect("a hollow cube");
        assert!((hollow.depth_m(DVec3::new(0.0, 0.0, 0.05)) + 0.025).abs() < 1e-9);
        assert!((hollow.depth_m(DVec3::new(0.0, 0.0, 0.01)) - 0.01).abs() < 1e-9);
    }

    #[test]
    fn a_point_in_the_groove_of_a_lathed_body_is_outside() {
        // Ribs with an edge that is nearly a sliver. Rays from the grooves between them meet the next rib.
        let mut profile = vec![DVec2::ZERO, DVec2::new(0.03, 0.0)];
        for k in 0..12 {
            let z = 0.01 + 0.015 * f64::from(k);
            profile.extend(
                [(0.03, 0.0), (0.0288, 0.0008), (0.0288, 0.0062), (0.03, 0.00621)]
                    .map(|(radius, above)| DVec2::new(radius, z + above)),
            );
        }
        profile.push(DVec2::new(0.0, 0.2));
        let bottle = MeshSolid::new(&mesh([lathe(&profile, 40)])).expect("a bottle");
        for k in 0..20_000 {
            let (turn, height) = (f64::from(k) * 0.618_034, f64::from(k) * 0.754_878);
            let angle_rad = turn.fract() * std::f64::consts::TAU;
            let point = DVec3::new(0.0301 * angle_rad.cos(), 0.0301 * angle_rad.sin(), 0.2 * height.fract());
            assert_eq!(bottle.depth_and_wall_m(point), None, "{point}");
        }
    }

    #[test]
    fn mesh_solid_rejects_an_empty_mesh() {
        assert_eq!(MeshSolid::new(&TexturedMesh::default()).err(), Some(SolidError::Empty));
    }

    proptest! {
        #[test]
        fn deepest_possible_bounds_the_depth_of_a_triangle(
            at in prop::array::uniform9(-0.08..0.08_f64), u in 0.0..1.0_f64, v in 0.0..1.0_f64,
        ) {
            let cube = block(DVec3::splat(0.1));
            let shifted = cube.clone().translated(DVec3::new(0.06, 0.0, 0.0));
            let solid = MeshSolid::new(&mesh([cube, shifted])).expect("two cubes");
            let [a, b, c] = [0, 3, 6].map(|k| DVec3::new(at[k], at[k + 1], at[k + 2]));
            let (u, v) = if u + v > 1.0 { (1.0 - u, 1.0 - v) } else { (u, v) };
            let depth_m = solid.depth_m(a + u * (b - a) + v * (c - a));
            prop_assert!(depth_m <= solid.deepest_possible_m([a, b, c]) + 1e-12 || depth_m < 0.0);
        }

        #[test]
        fn depth_in_a_ball_is_radius_minus_distance_to_center(x in -0.2..0.2_f64, y in -0.2..0.2_f64, z in -0.1..0.3_f64) {
            let ball = MeshSolid::new(&mesh([sphere(0.1, 96)])).expect("a ball");
            let point = DVec3::new(x, y, z);
            let expected = 0.1 - (point - DVec3::new(0.0, 0.0, 0.1)).length();
            prop_assert!((ball.depth_m(point) - expected).abs() < 2e-4);
        }
    }
}
