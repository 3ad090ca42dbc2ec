//! Contact patch of two convex hulls: every corner of the patch with its gap.
//!
//! The contact normal is the direction of largest separation: from GJK if the hulls are apart, from EPA if they overlap
//! (parry's implementations). A facet normal that separates as well replaces it, because the difference of two nearly
//! equal points determines a direction poorly. The patch is the overlap, projected along the normal, of the surfaces of
//! both hulls that are within reach; the gap at each corner is the exact distance of the two surfaces along the normal.
//! A plate thus has one contact per corner of its rim, however its facets are triangulated, and an edge on a facet has
//! two. The patch also includes corners of either hull inside the overlap, and corners of the overlap of the two flat
//! faces: a block with rounded edges stands on the corners of its flat face, which lie inside the outline of its
//! rounding, and two such blocks, rotated a little, touch where edges of flat faces cross.
//!
//! Frame of the first hull, meters. O(corners x facets).

use glam::{DVec2, DVec3};
use parry3d_f64::math::Pose as ParryPose;
use parry3d_f64::query::details::contact_support_map_support_map_with_params;
use parry3d_f64::query::gjk::{GJKResult, VoronoiSimplex};

use super::contact_hull::ContactHull;
use super::polygon::{convex_hull_2d, depth_in_convex_m};

/// Gaps below this do not determine a direction, meters.
const NEAR_M: f64 = 1e-4;

/// Corners of a hull closer than this to a corner of the overlap coincide with it, meters.
const SAME_CORNER_M: f64 = 1e-7;

/// Separation that a facet normal may lose and still be preferred, meters.
const FACET_PREFERENCE_M: f64 = 3e-6;

/// One corner of a patch; both points in the first hull's frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PatchPoint {
    pub on_a: DVec3,
    pub on_b: DVec3,
    /// Distance from `on_a` to `on_b` along the normal; negative where the hulls overlap.
    pub gap_m: f64,
}

/// Contact of two hulls.
#[derive(Clone, Debug, PartialEq)]
pub struct ContactPatch {
    /// Unit, from the first hull to the second, in the first hull's frame.
    pub normal: DVec3,
    /// At least one; all gaps at most the reach.
    pub points: Vec<PatchPoint>,
}

/// The patch within `reach_m`, or `None` if the hulls are farther apart. `hint` is the first direction to try, for
/// example the last known normal.
pub fn contact_patch(
    a: &ContactHull,
    b: &ContactHull,
    a_from_b: &ParryPose,
    reach_m: f64,
    hint: Option<DVec3>,
) -> Option<ContactPatch> {
    let b_points: Vec<DVec3> = b.points.iter().map(|&p| *a_from_b * p).collect();
    let separation = |normal: DVec3| {
        let far = b_points.iter().map(|p| p.dot(normal)).fold(f64::INFINITY, f64::min);
        far - a.reach_along(normal)
    };
    let found = contact_support_map_support_map_with_params(
        a_from_b,
        a,
        b,
        reach_m,
        &mut VoronoiSimplex::new(),
        hint,
    );
    let (mut normal, mut gap_m, witness) = match found {
        GJKResult::ClosestPoints(on_a, on_b, normal) => {
            (normal, separation(normal), Some((0.5 * (on_a + on_b), normal)))
        }
        // The result of a failed penetration search: use the facets alone.
        GJKResult::NoIntersection(direction) if direction == DVec3::X => (direction, f64::NEG_INFINITY, None),
        _ => return None,
    };
    if gap_m < NEAR_M {
        let (facet, facet_gap_m) = best_facet(a, b, &b_points, a_from_b, gap_m);
        if facet_gap_m > gap_m - FACET_PREFERENCE_M {
            (normal, gap_m) = (facet, facet_gap_m);
        }
    }
    if gap_m > reach_m || !gap_m.is_finite() {
        return None;
    }
    let (u, v) = normal.any_orthonormal_pair();
    let flat = |p: DVec3| DVec2::new(p.dot(u), p.dot(v));
    let facing = |points: &[DVec3], side: f64| -> Vec<DVec3> {
        let highest = points.iter().map(|p| side * p.dot(normal)).fold(f64::NEG_INFINITY, f64::max);
        points.iter().copied().filter(|p| side * p.dot(normal) >= highest - reach_m).collect()
    };
    let outline = |points: &[DVec3]| convex_hull_2d(&points.iter().map(|&p| flat(p)).collect::<Vec<_>>());
    let (a_near, b_near) = (facing(&a.points, 1.0), facing(&b_points, -1.0));
    let (a_face, b_face) = (outline(&a_near), outline(&b_near));
    let surfaces = Surfaces::new(a, b, a_from_b, normal);
    let point_at = |at: DVec2| {
        let base = at.x * u + at.y * v;
        let (on_a, on_b) = (surfaces.height_of_a(base), surfaces.height_of_b(base));
        PatchPoint { on_a: base + on_a * normal, on_b: base + on_b * normal, gap_m: on_b - on_a }
    };
    let mut points: Vec<PatchPoint> = overlap(&a_face, &b_face).into_iter().map(point_at).collect();
    // Where edges are rounded the outlines are those of the roundings, which hang a little higher; what carries
    // is where the two flat faces overlap, and its corners are mostly crossings of their edges.
    let turned_back = |direction: DVec3| a_from_b.rotation.inverse() * direction;
    let a_facet = a.facet_facing(normal);
    let b_facet = b.facet_facing(turned_back(-normal));
    if a_facet.len() < a_near.len() || b_facet.len() < b_near.len() {
        let b_facet: Vec<DVec3> = b_facet.into_iter().map(|p| *a_from_b * p).collect();
        let known = points.len();
        for corner in overlap(&outline(&a_facet), &outline(&b_facet)).into_iter().map(point_at) {
            let is_same =
                |p: &PatchPoint| p.on_a.distance_squared(corner.on_a) < SAME_CORNER_M * SAME_CORNER_M;
            if !points[..known].iter().any(is_same) {
                points.push(corner);
            }
        }
    }
    // Corners on the outlines are corners of the overlap already.
    let within =
        |face: &[DVec2], p: DVec3| face.len() > 2 && depth_in_convex_m(face, flat(p)) > SAME_CORNER_M;
    let inner = |p: &&DVec3| within(&a_face, **p) && within(&b_face, **p);
    for &p in a_near.iter().filter(inner) {
        let on_b = p + (surfaces.height_of_b(p - p.dot(normal) * normal) - p.dot(normal)) * normal;
        points.push(PatchPoint { on_a: p, on_b, gap_m: (on_b - p).dot(normal) });
    }
    for &p in b_near.iter().filter(inner) {
        let on_a = p + (surfaces.height_of_a(p - p.dot(normal) * normal) - p.dot(normal)) * normal;
        points.push(PatchPoint { on_a, on_b: p, gap_m: (p - on_a).dot(normal) });
    }
    points.retain(|point| point.gap_m <= reach_m && point.gap_m.is_finite());
    // The deepest point may lie inside the patch (a blunt tip on a facet).
    let min_m = points.iter().map(|point| point.gap_m).fold(f64::INFINITY, f64::min);
    if min_m > gap_m + 2e-6
        && let Some((center, direction)) = witness
        && direction.dot(normal) > 0.99
    {
        let half = 0.5 * gap_m * normal;
        points.push(PatchPoint { on_a: center - half, on_b: center + half, gap_m });
    }
    (!points.is_empty()).then_some(ContactPatch { normal, points })
}

/// The facet normal (from a to b) of largest separation, if that is nearly `floor_m` or more.
fn best_facet(
    a: &ContactHull,
    b: &ContactHull,
    b_points: &[DVec3],
    a_from_b: &ParryPose,
    floor_m: f64,
) -> (DVec3, f64) {
    let mut best = (DVec3::Z, f64::NEG_INFINITY);
    let mut offer = |normal: DVec3, offset_m: f64, points: &[DVec3], side: f64| {
        let enough = best.1.max(floor_m - FACET_PREFERENCE_M);
        let mut lowest = f64::INFINITY;
        for p in points {
            lowest = lowest.min(normal.dot(*p) - offset_m);
            if lowest <= enough {
                return;
            }
        }
        best = (side * normal, lowest);
    };
    for plane in &a.planes {
        offer(plane.normal, plane.offset_m, b_points, 1.0);
    }
    for plane in &b.planes {
        let normal = a_from_b.rotation * plane.normal;
        offer(normal, plane.offset_m + normal.dot(a_from_b.translation), &a.points, -1.0);
    }
    best
}

/// The facets of both hulls that face each other, as planes over the contact plane.
struct Surfaces {
    /// (normal, offset, normal along the contact direction).
    a: Vec<(DVec3, f64, f64)>,
    b: Vec<(DVec3, f64, f64)>,
}

impl Surfaces {
    fn new(a: &ContactHull, b: &ContactHull, a_from_b: &ParryPose, normal: DVec3) -> Self {
        // Facets nearly parallel to the direction bound the patch sideways, as its corners do already.
        const STEEP: f64 = 1e-3;
        let a = a
            .planes
            .iter()
            .map(|plane| (plane.normal, plane.offset_m, plane.normal.dot(normal)))
            .filter(|(_, _, along)| *along > STEEP)
            .collect();
        let b = b
            .planes
            .iter()
            .map(|plane| {
                let turned = a_from_b.rotation * plane.normal;
                (turned, plane.offset_m + turned.dot(a_from_b.translation), turned.dot(normal))
            })
            .filter(|(_, _, along)| *along < -STEEP)
            .collect();
        Self { a, b }
    }

    /// Height of the first hull's surface along the direction above `base`.
    fn height_of_a(&self, base: DVec3) -> f64 {
        let heights = self.a.iter().map(|(normal, offset, along)| (offset - normal.dot(base)) / along);
        heights.fold(f64::INFINITY, f64::min)
    }

    /// Height of the second hull's surface.
    fn height_of_b(&self, base: DVec3) -> f64 {
        let heights = self.b.iter().map(|(normal, offset, along)| (offset - normal.dot(base)) / along);
        heights.fold(f64::NEG_INFINITY, f64::max)
    }
}

/// Corners of the overlap of two convex polygons (counter-clockwise), segments or points.
fn overlap(a: &[DVec2], b: &[DVec2]) -> Vec<DVec2> {
    match (a.len(), b.len()) {
        (0, _) | (_, 0) => Vec::new(),
        (3.., _) => clipped(b, a),
        (_, 3..) => clipped(a, b),
        (2, 2) => segments_overlap([a[0], a[1]], [b[0], b[1]]),
        // A tip on an edge or a tip: the caller has the nearest point.
        _ => Vec::new(),
    }
}

/// Sutherland and Hodgman: the part of `subject` inside the polygon `window`.
fn clipped(subject: &[DVec2], window: &[DVec2]) -> Vec<DVec2> {
    let closed = subject.len() > 2;
    let mut kept = subject.to_vec();
    for (k, &from) in window.iter().enumerate() {
        let along = window[(k + 1) % window.len()] - from;
        let Some(inward) = along.perp().try_normalize() else { continue };
        let inside = |p: DVec2| (p - from).dot(inward);
        let mut next = Vec::with_capacity(kept.len() + 2);
        for (i, &p) in kept.iter().enumerate() {
            let d = inside(p);
            // The tolerance keeps corners that lie on the window's edge.
            if d >= -1e-9 {
                next.push(p);
            }
            if i + 1 == kept.len() && !closed {
                continue;
            }
            let q = kept[(i + 1) % kept.len()];
            let e = inside(q);
            if (d > 1e-9 && e < -1e-9) || (d < -1e-9 && e > 1e-9) {
                next.push(p + (q - p) * (d / (d - e)));
            }
        }
        kept = next;
    }
    kept
}

/// The common stretch of two nearly parallel segments, or their crossing.
fn segments_overlap(a: [DVec2; 2], b: [DVec2; 2]) -> Vec<DVec2> {
    let (along_a, along_b) = (a[1] - a[0], b[1] - b[0]);
    let cross = along_a.perp_dot(along_b);
    // Beyond 6 degrees the crossing is well defined; flatter edges touch along a stretch.
    if cross.abs() > 0.1 * along_a.length() * along_b.length() {
        let t = (b[0] - a[0]).perp_dot(along_b) / cross;
        let s = (b[0] - a[0]).perp_dot(along_a) / cross;
        let within = |x: f64| (-1e-6..=1.0 + 1e-6).contains(&x);
        return if within(t) && within(s) { vec![a[0] + t * along_a] } else { Vec::new() };
    }
    let length_squared = along_a.length_squared().max(1e-300);
    let onto = |p: DVec2| (p - a[0]).dot(along_a) / length_squared;
    let (low, high) = (onto(b[0]).min(onto(b[1])).max(0.0), onto(b[0]).max(onto(b[1])).min(1.0));
    if low > high { Vec::new() } else { vec![a[0] + low * along_a, a[0] + high * along_a] }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Pose;
    use crate::Solid;
    use crate::collision_shape::to_parry;
    use crate::convex_hull::convex_hull;
    use crate::shapes::{block, cylinder, rounded_block, sphere};
    use glam::DQuat;
    use proptest::prelude::*;

    fn hull(solid: Solid) -> ContactHull {
        ContactHull::new(&convex_hull(&solid.positions, 64, 0.001).expect("a solid"))
    }

    fn at(x: f64, y: f64, z: f64) -> ParryPose {
        to_parry(&Pose::upright(DVec3::new(x, y, z), 0.3))
    }

    fn area(patch: &ContactPatch) -> f64 {
        let (u, v) = patch.normal.any_orthonormal_pair();
        let flat: Vec<DVec2> =
            patch.points.iter().map(|p| DVec2::new(p.on_a.dot(u), p.on_a.dot(v))).collect();
        let polygon = convex_hull_2d(&flat);
        (0..polygon.len()).map(|k| polygon[k].perp_dot(polygon[(k + 1) % polygon.len()])).sum::<f64>() / 2.0
    }

    #[test]
    fn patch_of_a_can_on_a_table_is_its_whole_rim() {
        let (table, can) = (hull(block(DVec3::new(1.0, 0.8, 0.03))), hull(cylinder(0.03, 0.1, 0.0, 24)));
        for gap_m in [-1e-4, -1e-9, 0.0, 1e-9, 1e-6, 3e-4] {
            let patch = contact_patch(&table, &can, &at(0.3, 0.2, 0.03 + gap_m), 4e-4, None)
                .expect("it stands there");
            assert!(patch.normal.distance(DVec3::Z) < 1e-9, "{gap_m}: {}", patch.normal);
            assert_eq!(patch.points.len(), 24, "{gap_m}");
            assert!(patch.points.iter().all(|p| (p.gap_m - gap_m).abs() < 1e-9));
            assert!(
                (area(&patch) / (12.0 * 0.03 * 0.03 * (std::f64::consts::PI / 12.0).sin()) - 1.0).abs()
                    < 1e-6
            );
        }
        assert_eq!(contact_patch(&table, &can, &at(0.3, 0.2, 0.0305), 4e-4, None), None);
    }

    #[test]
    fn patch_ends_at_the_edge_of_the_smaller_face() {
        let (small, large) = (hull(block(DVec3::splat(0.04))), hull(block(DVec3::new(0.1, 0.1, 0.01))));
        let pose = to_parry(&Pose { translation_m: DVec3::new(0.03, 0.0, 0.04), rotation: DQuat::IDENTITY });
        let patch = contact_patch(&small, &large, &pose, 4e-4, None).expect("it lies there");
        assert!((area(&patch) - 0.04 * 0.04).abs() < 1e-9);
        let pose = to_parry(&Pose { translation_m: DVec3::new(0.06, 0.0, 0.04), rotation: DQuat::IDENTITY });
        let patch = contact_patch(&small, &large, &pose, 4e-4, None).expect("it lies there");
        assert!((area(&patch) - 0.01 * 0.04).abs() < 1e-9);
    }

    #[test]
    fn patch_of_rounded_boards_is_the_overlap_of_their_flat_faces() {
        // Only corners of the roundings were found, on one side, and the upper board sank in on the other.
        let lower = hull(rounded_block(DVec3::new(0.16, 0.23, 0.0025), 0.0012, 0.0008));
        let upper = hull(rounded_block(DVec3::new(0.155, 0.225, 0.0025), 0.0012, 0.0008));
        let turned = Pose::upright(DVec3::new(0.0005, -0.0007, 0.0025), 0.06);
        let patch = contact_patch(&lower, &upper, &to_parry(&turned), 4e-5, None).expect("it lies there");
        let carries = |p: &&PatchPoint| p.gap_m.abs() < 1e-7;
        for (x, y) in [(1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)] {
            let in_corner = |p: &PatchPoint| p.on_a.x * x > 0.06 && p.on_a.y * y > 0.09;
            let found = patch.points.iter().filter(carries).any(in_corner);
            assert!(found, "nothing carries at ({x}, {y}): {:?}", patch.points);
        }
    }

    #[test]
    fn patch_of_a_lying_can_is_a_line_and_of_a_ball_a_point() {
        let (table, can, ball) = (
            hull(block(DVec3::new(1.0, 0.8, 0.03))),
            hull(cylinder(0.03, 0.1, 0.0, 24)),
            hull(sphere(0.03, 24)),
        );
        let lying = Pose {
            translation_m: DVec3::new(0.0, 0.0, 0.06),
            rotation: DQuat::from_rotation_x(std::f64::consts::FRAC_PI_2) * DQuat::from_rotation_z(0.01),
        };
        let patch = contact_patch(&table, &can, &to_parry(&lying), 1e-4, None).expect("it lies there");
        assert!(patch.points.len() >= 2);
        let length = patch.points.iter().map(|p| p.on_a.y).fold(0.0_f64, |l, y| l.max(y.abs()));
        assert!(length > 0.09, "{patch:?}");
        assert!(contact_patch(&table, &ball, &at(0.0, 0.0, 0.03), 1e-4, None).is_some());
    }

    #[test]
    fn patch_of_crossed_bars_is_their_crossing() {
        // Square bars standing on an edge, one across the other.
        let bar = || block(DVec3::new(0.2, 0.02, 0.02)).translated(DVec3::new(0.0, 0.0, -0.01));
        let tilted = hull(bar().rotated(DQuat::from_rotation_x(std::f64::consts::FRAC_PI_4)));
        let half = 0.01 * 2.0_f64.sqrt();
        for gap_m in [-2e-5, 1e-5] {
            let pose = Pose {
                translation_m: DVec3::new(0.03, 0.0, 2.0 * half + gap_m),
                rotation: DQuat::from_rotation_z(std::f64::consts::FRAC_PI_2),
            };
            let patch = contact_patch(&tilted, &tilted, &to_parry(&pose), 4e-5, None).expect("they cross");
            let nearest = patch.points.iter().min_by(|p, q| p.gap_m.total_cmp(&q.gap_m)).expect("a point");
            assert!((nearest.on_a.truncate() - DVec2::new(0.03, 0.0)).length() < 2e-4, "{patch:?}");
            assert!((nearest.gap_m - gap_m).abs() < 2e-6, "{patch:?}");
        }
    }

    proptest! {
        #[test]
        fn patch_gaps_equal_nearest_distances_and_points_lie_on_surfaces(
            x in -0.03..0.03_f64, y in -0.03..0.03_f64, tilt in -1.5..1.5_f64, yaw in -3.0..3.0_f64, gap in 1e-6..3e-4_f64,
        ) {
            let (base, top) = (hull(block(DVec3::new(0.1, 0.1, 0.02))), hull(cylinder(0.02, 0.05, 0.0, 12)));
            let rotation = DQuat::from_rotation_z(yaw) * DQuat::from_rotation_x(tilt);
            let lowest = top.points.iter().map(|&p| (rotation * p).z).fold(f64::INFINITY, f64::min);
            let pose = Pose { translation_m: DVec3::new(x, y, 0.02 - lowest + gap), rotation };
            let patch = contact_patch(&base, &top, &to_parry(&pose), 4e-4, None);
            let patch = patch.expect("it hovers above the top");
            let lowest = patch.points.iter().map(|p| p.gap_m).fold(f64::INFINITY, f64::min);
            prop_assert!((lowest - gap).abs() < 3e-6, "{} against {}", lowest, gap);
            for p in &patch.points {
                prop_assert!((p.on_a.z - 0.02).abs() < 1e-9);
                let inside = pose.inverse().transform_point(p.on_b);
                let out = top.planes.iter().map(|f| f.normal.dot(inside) - f.offset_m).fold(f64::NEG_INFINITY, f64::max);
                prop_assert!(out.abs() < 1e-6, "{}", out);
            }
        }
    }
}
