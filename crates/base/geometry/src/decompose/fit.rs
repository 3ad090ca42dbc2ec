//! Fit of hulls to a solid: volumes, distances, and the share of its openings that stays open.
//!
//! Measured at points spread evenly by area or volume in a fixed order, so the same hulls give the same figures: a
//! distance is exact at its point, and between points (about a hundredth of the size apart) it can be larger.
//! Object frame, meters. Tens of milliseconds.

use std::iter::repeat_n;

use glam::{DVec2, DVec3};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::DecomposeError;
use super::field::{Field, Nearby};
use super::openings::openings;
use crate::ConvexHull;
use crate::convex_hull::{FlatPlanes, planes};
use crate::json_numbers::Fraction;
use crate::solid_query::MeshSolid;
use runtime::CancelFlag;

/// Measures of fit of the hulls of a mesh.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct HullFit {
    /// Volume error: what of the union of the hulls lies outside the solid, over what lies in it.
    #[schemars(range(min = 0.0))]
    pub air_share: f64,
    /// Largest and mean distance of the surface of the hulls' union from the mesh, meters.
    #[schemars(range(min = 0.0))]
    pub hulls_from_mesh_max_m: f64,
    #[schemars(range(min = 0.0))]
    pub hulls_from_mesh_mean_m: f64,
    /// Largest and mean distance of the mesh from the surface of the hulls' union, meters.
    #[schemars(range(min = 0.0))]
    pub mesh_from_hulls_max_m: f64,
    #[schemars(range(min = 0.0))]
    pub mesh_from_hulls_mean_m: f64,
    /// Share of the openings that no hull fills. Openings are points in the mesh's convex hull farther from the mesh
    /// than a fiftieth of its size, and than 1.5 mm, that a ball of that radius reaches from outside: cavities and
    /// handles count; creases, what is sealed, and openings of less than 2 % of the convex hull do not. 1 if all
    /// openings stay open, or if there is none.
    #[schemars(with = "Fraction")]
    pub open_share: f64,
}

impl HullFit {
    /// Two-sided Hausdorff distance, meters.
    pub fn hausdorff_m(&self) -> f64 {
        self.hulls_from_mesh_max_m.max(self.mesh_from_hulls_max_m)
    }

    /// Mean of the two sides' mean distances, meters.
    pub fn mean_m(&self) -> f64 {
        0.5 * (self.hulls_from_mesh_mean_m + self.mesh_from_hulls_mean_m)
    }

    /// The figures of mesh and hulls both made `factor` times as large.
    pub fn scaled(&self, factor: f64) -> Self {
        Self {
            hulls_from_mesh_max_m: factor * self.hulls_from_mesh_max_m,
            hulls_from_mesh_mean_m: factor * self.hulls_from_mesh_mean_m,
            mesh_from_hulls_max_m: factor * self.mesh_from_hulls_max_m,
            mesh_from_hulls_mean_m: factor * self.mesh_from_hulls_mean_m,
            ..*self
        }
    }
}

/// Points on each surface, and in each hull.
const SURFACE_POINTS: usize = 1500;
const HULL_POINTS: usize = 48;
/// Surfaces closer than this are one, meters.
const SAME_M: f64 = 1e-6;

/// The figures of `hulls` as collision geometry of a solid, `field` being its own.
pub(super) fn fit(
    solid: &MeshSolid,
    field: &Field,
    hulls: &[ConvexHull],
    cancel: &CancelFlag,
) -> Result<HullFit, DecomposeError> {
    let mut depths = Depths { field, nearby: field.nearby() };
    let union = Union::of(hulls);
    cancel.check()?;
    let corners: Vec<[DVec3; 3]> = solid.triangles().collect();
    let shells = solid.shells().iter().enumerate();
    let shell_of: Vec<usize> = shells.flat_map(|(k, s)| repeat_n(k, s.surface.num_triangles())).collect();
    // Where shells overlap, part of their surface is inside.
    let bare = spread(&corners).into_iter().filter(|&(triangle, p)| depths.is_bare(shell_of[triangle], p));
    let mut deepest = 0;
    let from_hulls = Distances::of(bare.map(|(_, p)| union.depth_m(p, &mut deepest).abs()));
    cancel.check()?;
    let faces: Vec<[DVec3; 3]> =
        hulls.iter().flat_map(|h| h.triangles.iter().map(|t| t.map(|v| h.points[v as usize]))).collect();
    let on_hulls = spread(&faces).into_iter().filter(|&(_, p)| union.covers_of(p, SAME_M) < 2);
    let from_mesh = Distances::of(on_hulls.map(|(_, p)| depths.depth_m(p).abs()));
    cancel.check()?;
    Ok(HullFit {
        air_share: air_share(hulls, &mut depths, &union),
        hulls_from_mesh_max_m: from_mesh.max_m,
        hulls_from_mesh_mean_m: from_mesh.mean_m,
        mesh_from_hulls_max_m: from_hulls.max_m,
        mesh_from_hulls_mean_m: from_hulls.mean_m,
        open_share: open_share(solid, &mut depths, &union)?,
    })
}

/// Depths in the solid of points that lie close to each other.
pub(super) struct Depths<'a> {
    field: &'a Field<'a>,
    nearby: Nearby,
}

impl Depths<'_> {
    pub(super) fn depth_m(&mut self, point: DVec3) -> f64 {
        self.field.depth_m(point, &mut self.nearby)
    }

    fn is_outside(&mut self, point: DVec3) -> bool {
        self.field.is_outside(point, &mut self.nearby)
    }

    /// Whether a point on the surface of this shell lies on that of the solid.
    fn is_bare(&mut self, shell: usize, point: DVec3) -> bool {
        self.field.depth_on_m(shell, point, &mut self.nearby).abs() < SAME_M
    }
}

#[derive(Default)]
struct Distances {
    max_m: f64,
    mean_m: f64,
}

impl Distances {
    fn of(distances_m: impl Iterator<Item = f64>) -> Self {
        let (mut sum, mut count, mut max_m) = (0.0, 0_u32, 0.0_f64);
        for distance_m in distances_m {
            sum += distance_m;
            count += 1;
            max_m = max_m.max(distance_m);
        }
        Self { max_m, mean_m: sum / f64::from(count.max(1)) }
    }
}

/// Volume of air over volume of solid in the union of the hulls, from points spread evenly in each hull. A point in n
/// hulls counts 1/n in each.
fn air_share(hulls: &[ConvexHull], depths: &mut Depths<'_>, union: &Union) -> f64 {
    let (mut air_m3, mut solid_m3) = (0.0, 0.0);
    for hull in hulls {
        let each_m3 = hull.volume_m3() / HULL_POINTS as f64;
        for p in spread_inside(hull) {
            let part_m3 = each_m3 / union.covers_of(p, SAME_M).max(1) as f64;
            if depths.is_outside(p) {
                air_m3 += part_m3;
            } else {
                solid_m3 += part_m3;
            }
        }
    }
    air_m3 / f64::max(solid_m3, f64::MIN_POSITIVE)
}

/// Of the openings' points on a grid, the share in no hull.
fn open_share(solid: &MeshSolid, depths: &mut Depths<'_>, union: &Union) -> Result<f64, DecomposeError> {
    let openings = openings(solid, depths)?;
    if openings.is_empty() {
        return Ok(1.0);
    }
    let open = openings.iter().filter(|&&p| union.covers_of(p, 0.0) == 0).count();
    Ok(open as f64 / openings.len() as f64)
}

/// Hulls by the planes of their faces and their boxes.
struct Union(Vec<Convex>);

struct Convex {
    faces: FlatPlanes,
    low: DVec3,
    high: DVec3,
}

impl Union {
    fn of(hulls: &[ConvexHull]) -> Self {
        let convex = |hull: &ConvexHull| {
            let (low, high) = hull
                .points
                .iter()
                .fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), &p| (low.min(p), high.max(p)));
            Convex { faces: FlatPlanes::of(&planes(hull)), low, high }
        };
        Self(hulls.iter().map(convex).collect())
    }

    /// Hulls the point lies in, or outside by at most `slack_m`.
    fn covers_of(&self, point: DVec3, slack_m: f64) -> usize {
        let near = |c: &&Convex| point.cmpge(c.low - slack_m).all() && point.cmple(c.high + slack_m).all();
        let limit_m = slack_m.next_up();
        self.0.iter().filter(near).filter(|c| c.faces.distance_above_below(point, limit_m).is_some()).count()
    }

    /// Depth in the hull it is deepest in, at most the depth in the union; negative outside all, by at least what it
    /// is above the nearest face. `deepest` is that hull for a point nearby on entry and for this one on return.
    fn depth_m(&self, point: DVec3, deepest: &mut usize) -> f64 {
        let guess = *deepest;
        let mut lowest_m = self.0.get(guess).map_or(f64::INFINITY, |c| c.faces.distance_above(point));
        for (k, convex) in self.0.iter().enumerate().filter(|&(k, _)| k != guess) {
            if let Some(above_m) = convex.faces.distance_above_below(point, lowest_m) {
                (lowest_m, *deepest) = (above_m, k);
            }
        }
        -lowest_m
    }
}

/// Points spread evenly over triangles by area, each with the index of its triangle: Roberts' low-discrepancy
/// sequence R2 over the cumulative areas.
fn spread(triangles: &[[DVec3; 3]]) -> Vec<(usize, DVec3)> {
    const STEP: DVec2 = DVec2::new(0.754_877_666_246_693, 0.569_840_290_998_053_2);
    let areas: Vec<f64> = triangles.iter().map(|[a, b, c]| (*b - *a).cross(*c - *a).length()).collect();
    let total: f64 = areas.iter().sum();
    let mut points = Vec::with_capacity(SURFACE_POINTS);
    let (mut passed, mut index) = (0.0, 0);
    for k in 0..SURFACE_POINTS {
        let at = total * (k as f64 + 0.5) / SURFACE_POINTS as f64;
        while index + 1 < triangles.len() && passed + areas[index] < at {
            passed += areas[index];
            index += 1;
        }
        let Some(&[a, b, c]) = triangles.get(index) else { break };
        let mut uv = ((k + 1) as f64 * STEP).fract();
        if uv.x + uv.y > 1.0 {
            uv = DVec2::ONE - uv;
        }
        points.push((index, a + uv.x * (b - a) + uv.y * (c - a)));
    }
    points
}

/// Points spread evenly in a hull by volume: Roberts' sequence R3, folded into the tetrahedra between center and faces.
fn spread_inside(hull: &ConvexHull) -> Vec<DVec3> {
    const STEP: DVec3 = DVec3::new(0.819_172_513_396_164_4, 0.671_043_606_703_789_2, 0.549_700_477_901_970_3);
    let center = hull.points.iter().sum::<DVec3>() / hull.points.len().max(1) as f64;
    let cones: Vec<[DVec3; 3]> =
        hull.triangles.iter().map(|t| t.map(|v| hull.points[v as usize] - center)).collect();
    let volumes: Vec<f64> = cones.iter().map(|[a, b, c]| a.dot(b.cross(*c)).abs()).collect();
    let total: f64 = volumes.iter().sum();
    let mut points = Vec::with_capacity(HULL_POINTS);
    let (mut passed, mut index) = (0.0, 0);
    for k in 0..HULL_POINTS {
        let at = total * (k as f64 + 0.5) / HULL_POINTS as f64;
        while index + 1 < cones.len() && passed + volumes[index] < at {
            passed += volumes[index];
            index += 1;
        }
        let Some([a, b, c]) = cones.get(index) else { break };
        // Differences of three sorted numbers are spread evenly over a tetrahedron.
        let mut u = ((k + 1) as f64 * STEP).fract().to_array();
        u.sort_by(f64::total_cmp);
        points.push(center + u[0] * *a + (u[1] - u[0]) * *b + (u[2] - u[1]) * *c);
    }
    points
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::convex_hull::{convex_hull, distance_above};
    use crate::shapes::{block, sphere};
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn depth_in_a_union_is_the_largest_in_a_hull_whatever_is_guessed(
            point in prop::array::uniform3(-0.2..0.2_f64), mut deepest in 0..5_usize,
        ) {
            let point = DVec3::from(point);
            let solids = [block(DVec3::splat(0.1)), sphere(0.05, 16), block(DVec3::new(0.2, 0.02, 0.15))];
            let hulls = solids.map(|solid| convex_hull(&solid.positions, usize::MAX, 0.0).expect("a hull"));
            let depths = hulls.iter().map(|hull| -distance_above(&planes(hull), point));
            let expected = depths.fold(f64::NEG_INFINITY, f64::max);
            prop_assert_eq!(Union::of(&hulls).depth_m(point, &mut deepest), expected);
        }
    }
}
