//! Interpenetration and contact regions of visual meshes.
//!
//! Two meshes collide if a surface sample (spacing at most 1 mm) of one lies deeper in the other's solid than
//! min(1 mm, a quarter of the local wall thickness). Samples come from subdividing triangles by branch and bound: a
//! triangle that cannot reach deep enough is discarded, so only the overlap is sampled and the deepest sample is found
//! exactly. A solid inside another is found the same way. Depths are bounded from above by 26 planes around the solid
//! (a k-DOP), so touching flat faces cost almost nothing. World frame, meters.

use glam::{DVec2, DVec3};

use super::Pose;
use super::polygon::{convex_hull_2d, is_in_convex};
use super::solid_query::MeshSolid;
use runtime::{CancelFlag, Cancelled};

/// A solid with its pose in the world.
#[derive(Clone, Copy)]
pub struct PlacedSolid<'a> {
    pub solid: &'a MeshSolid,
    pub world_from_object: Pose,
}

/// Thresholds above which an overlap counts as a collision.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CollisionRule {
    /// Penetration depth above which a pair always collides, meters.
    pub penetration_m: f64,
    /// Share of the local wall thickness above which a penetration depth collides too, 0..1.
    pub wall_share: f64,
    /// Lower bound of wall thicknesses, meters. Depths below `wall_share` times this are ignored.
    pub min_wall_m: f64,
    /// Largest distance between samples, meters.
    pub spacing_m: f64,
}

/// The deepest sample that violates the rule.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Penetration {
    pub depth_m: f64,
    pub at_world: DVec3,
}

/// The deepest sample of either surface that violates the rule in the other solid.
///
/// # Errors
///
/// [`Cancelled`] if the flag was raised.
pub fn penetration(
    a: &PlacedSolid,
    b: &PlacedSolid,
    rule: &CollisionRule,
    cancel: &CancelFlag,
) -> Result<Option<Penetration>, Cancelled> {
    let mut worst: Option<Penetration> = None;
    for (surface, solid) in [(a, b), (b, a)] {
        deepest_in(surface, solid, rule, &mut worst, cancel)?;
    }
    Ok(worst)
}

fn deepest_in(
    surface: &PlacedSolid,
    solid: &PlacedSolid,
    rule: &CollisionRule,
    worst: &mut Option<Penetration>,
    cancel: &CancelFlag,
) -> Result<(), Cancelled> {
    let here_from_surface = solid.world_from_object.inverse() * surface.world_from_object;
    let min_m = rule.wall_share * rule.min_wall_m;
    let (low, high) = solid.solid.bounds();
    let (low, high) = (low + min_m, high - min_m);
    let wrap = Wrap::new(solid.solid);
    let mut stack: Vec<[DVec3; 3]> = Vec::new();
    let mut tested = 0_u32;
    for triangle in surface.solid.triangles() {
        stack.push(triangle.map(|p| here_from_surface.transform_point(p)));
        while let Some([a, b, c]) = stack.pop() {
            let bound = worst.map_or(min_m, |w| w.depth_m.max(min_m));
            if a.max(b).max(c).cmplt(low).any()
                || a.min(b).min(c).cmpgt(high).any()
                || wrap.deepest_m([a, b, c]) <= bound
            {
                continue;
            }
            tested += 1;
            if tested.is_multiple_of(1024) {
                cancel.check()?;
            }
            let center = (a + b + c) / 3.0;
            let radius = (a - center).length().max((b - center).length()).max((c - center).length());
            if solid.solid.deepest_possible_m([a, b, c]) <= bound {
                continue;
            }
            if solid.solid.depth_m(center) > bound
                && let Some((depth_m, wall_m)) = solid.solid.depth_and_wall_m(center)
                && depth_m > rule.penetration_m.min(rule.wall_share * wall_m.max(rule.min_wall_m))
            {
                let at_world = solid.world_from_object.transform_point(center);
                *worst = Some(Penetration { depth_m, at_world });
            }
            if radius > 0.5 * rule.spacing_m {
                stack.extend(quarters(a, b, c));
            }
        }
    }
    Ok(())
}

fn quarters(a: DVec3, b: DVec3, c: DVec3) -> [[DVec3; 3]; 4] {
    // Splitting the longest edge first keeps slivers from staying long.
    let (ab, bc, ca) = (0.5 * (a + b), 0.5 * (b + c), 0.5 * (c + a));
    let longest = [(b - a).length_squared(), (c - b).length_squared(), (a - c).length_squared()];
    if longest[0] > 4.0 * longest[1].min(longest[2]) || longest[1] > 4.0 * longest[2].min(longest[0]) {
        if longest[0] >= longest[1] && longest[0] >= longest[2] {
            // Three pieces; the fourth has no area and only completes the array.
            return [[a, ab, c], [ab, 0.5 * (ab + b), c], [0.5 * (ab + b), b, c], [c, c, c]];
        }
        if longest[1] >= longest[2] {
            return [[b, bc, a], [bc, 0.5 * (bc + c), a], [0.5 * (bc + c), c, a], [a, a, a]];
        }
    }
    [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
}

/// The 26-DOP of a solid: its extents along the edges, face diagonals and space diagonals of a cube.
struct Wrap {
    planes: Vec<(DVec3, f64)>,
}

impl Wrap {
    fn new(solid: &MeshSolid) -> Self {
        let mut planes: Vec<(DVec3, f64)> = (0..27)
            .map(|k| DVec3::new(f64::from(k % 3) - 1.0, f64::from(k / 3 % 3) - 1.0, f64::from(k / 9) - 1.0))
            .filter_map(|direction| Some((direction.try_normalize()?, f64::NEG_INFINITY)))
            .collect();
        for p in solid.triangles().flatten() {
            for (normal, offset_m) in &mut planes {
                *offset_m = offset_m.max(normal.dot(p));
            }
        }
        Self { planes }
    }

    /// Upper bound of the depth of the triangle's points in the solid, which lies inside the wrap.
    fn deepest_m(&self, corners: [DVec3; 3]) -> f64 {
        let depth = |(normal, offset): &(DVec3, f64)| {
            corners.iter().map(|p| offset - normal.dot(*p)).fold(f64::NEG_INFINITY, f64::max)
        };
        self.planes.iter().map(depth).fold(f64::INFINITY, f64::min)
    }
}

/// Upper bound of the distance of the triangle's points from their nearest corner.
fn reach_m([a, b, c]: [DVec3; 3]) -> f64 {
    // Exact for the equilateral triangle, whose circumradius is its side over the root of 3.
    (b - a).length().max((c - b).length()).max((a - c).length()) / 3.0_f64.sqrt()
}

/// Convex hull, in the xy plane, of the contact between `object` and `supporter` and of the `known` points.
///
/// Contact points are points of `object`'s surface within `gap_m` of `supporter` or inside it; the hull is exact to
/// half a millimeter. With `min_slope`, only points that the supporter carries from below count: a step down must lead
/// toward its inside by at least this share of the step (1 = perpendicular to its surface, 0 = along it). World frame.
///
/// # Errors
///
/// [`Cancelled`] if the flag was raised.
pub fn contact_region(
    object: &PlacedSolid,
    supporter: &PlacedSolid,
    gap_m: f64,
    min_slope: Option<f64>,
    known: &[DVec2],
    cancel: &CancelFlag,
) -> Result<Vec<DVec2>, Cancelled> {
    let here_from_object = supporter.world_from_object.inverse() * object.world_from_object;
    let (low, high) = supporter.solid.bounds();
    let (low, high) = (low - gap_m, high + gap_m);
    let wrap = Wrap::new(supporter.solid);
    let step = supporter.world_from_object.inverse().transform_vector(-0.5 * gap_m * DVec3::Z);
    let carries = |p: DVec3, depth_m: f64| {
        min_slope.is_none_or(|slope| supporter.solid.depth_m(p + step) - depth_m >= slope * step.length())
    };
    let flat = |p: DVec3| supporter.world_from_object.transform_point(p).truncate();
    let mut region = convex_hull_2d(known);
    // Corners with their depths; minus infinity if too far away to matter.
    let mut stack: Vec<[(DVec3, f64); 3]> = Vec::new();
    let mut tested = 0_u32;
    for triangle in object.solid.triangles() {
        let corners = triangle.map(|p| here_from_object.transform_point(p));
        // Upward faces are not carried; objects lying on them would cost a futile search.
        let outward = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
        if min_slope.is_some() && outward.dot(step) < 0.0 {
            continue;
        }
        let outside = |[a, b, c]: [DVec3; 3], region: &[DVec2]| {
            a.max(b).max(c).cmplt(low).any()
                || a.min(b).min(c).cmpgt(high).any()
                || wrap.deepest_m([a, b, c]) < -gap_m
                // A triangle inside the region cannot extend it.
                || [a, b, c].iter().all(|&p| is_in_convex(region, flat(p)))
        };
        if outside(corners, &region) {
            continue;
        }
        let floor_m = -gap_m - reach_m(corners);
        stack.push(corners.map(|p| (p, supporter.solid.depth_above(p, floor_m))));
        while let Some(corners) = stack.pop() {
            let [a, b, c] = corners.map(|(p, _)| p);
            if outside([a, b, c], &region) {
                continue;
            }
            tested += 1;
            if tested.is_multiple_of(256) {
                cancel.check()?;
            }
            let on = corners.map(|(p, depth_m)| depth_m >= -gap_m && carries(p, depth_m));
            let spanned = region.len();
            region.extend(corners.iter().zip(on).filter(|(_, on)| *on).map(|((p, _), _)| flat(*p)));
            if region.len() > spanned {
                region = convex_hull_2d(&region);
            }
            let deepest_m = corners.iter().map(|(_, depth_m)| *depth_m).fold(f64::NEG_INFINITY, f64::max);
            let reach_m = reach_m([a, b, c]);
            if on.iter().all(|&on| on) || reach_m < 0.0005 || deepest_m + reach_m < -gap_m {
                continue;
            }
            let floor_m = -gap_m - reach_m;
            let known = |p: DVec3| corners.iter().find(|(q, _)| *q == p).map(|(_, depth_m)| *depth_m);
            // Neighboring quarters share new corners.
            let mut new: Vec<(DVec3, f64)> = Vec::with_capacity(3);
            for quarter in quarters(a, b, c) {
                stack.push(quarter.map(|p| {
                    let measured = known(p).or_else(|| new.iter().find(|(q, _)| *q == p).map(|(_, d)| *d));
                    let depth_m = measured.unwrap_or_else(|| {
                        let depth_m = supporter.solid.depth_above(p, floor_m);
                        new.push((p, depth_m));
                        depth_m
                    });
                    (p, depth_m)
                }));
            }
        }
    }
    Ok(region)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::polygon::depth_in_convex_m;
    use crate::shapes::{block, shell_of_revolution, sphere};
    use crate::{Material, Rgb, Solid, TexturedMesh};
    use glam::DQuat;
    use proptest::prelude::*;

    const RULE: CollisionRule =
        CollisionRule { penetration_m: 0.001, wall_share: 0.25, min_wall_m: 0.0004, spacing_m: 0.001 };

    fn solid(solid: Solid) -> MeshSolid {
        let mut mesh = TexturedMesh::default();
        mesh.add(solid, &Material::plain("plain", Rgb::hex(0x80_80_80), 0.5));
        MeshSolid::new(&mesh).expect("a solid")
    }

    fn at(solid: &MeshSolid, x: f64, y: f64, z: f64) -> PlacedSolid<'_> {
        PlacedSolid { solid, world_from_object: Pose::upright(DVec3::new(x, y, z), 0.2) }
    }

    fn depth(a: &PlacedSolid, b: &PlacedSolid) -> Option<f64> {
        penetration(a, b, &RULE, &CancelFlag::default()).expect("not cancelled").map(|p| p.depth_m)
    }

    #[test]
    fn penetration_of_blocks_starts_at_one_millimeter() {
        let cube = solid(block(DVec3::splat(0.05)));
        let below = at(&cube, 0.0, 0.0, 0.0);
        assert_eq!(depth(&below, &at(&cube, 0.0, 0.0, 0.05)), None);
        assert_eq!(depth(&below, &at(&cube, 0.0, 0.0, 0.0492)), None);
        let deep = depth(&below, &at(&cube, 0.0, 0.0, 0.048)).expect("2 mm deep");
        assert!((deep - 0.002).abs() < 1e-6, "{deep}");
        assert_eq!(depth(&below, &at(&cube, 0.2, 0.0, 0.0)), None);
        let inner = solid(block(DVec3::splat(0.01)));
        assert!(depth(&below, &at(&inner, 0.0, 0.0, 0.02)).expect("swallowed whole") > 0.019);
    }

    #[test]
    fn penetration_ignores_the_cavity_of_a_mug_and_limits_a_quarter_of_its_wall() {
        let profile = [DVec2::new(0.04, 0.0), DVec2::new(0.04, 0.1)];
        let mug = solid(shell_of_revolution(&profile, 0.003, 0.006, 64));
        let ball = solid(sphere(0.02, 48));
        assert_eq!(depth(&at(&mug, 0.0, 0.0, 0.0), &at(&ball, 0.0, 0.0, 0.006)), None);
        // The wall is 3 mm thick, so 0.75 mm is the limit: 0.6 passes, 0.9 does not.
        assert_eq!(depth(&at(&mug, 0.0, 0.0, 0.0), &at(&ball, 0.0176, 0.0, 0.03)), None);
        let hit = depth(&at(&mug, 0.0, 0.0, 0.0), &at(&ball, 0.0180, 0.0, 0.03));
        assert!(hit.is_some_and(|d| d > 0.0008 && d < 0.0011), "{hit:?}");
    }

    #[test]
    fn contact_region_spans_the_supporting_face() {
        let cube = solid(block(DVec3::splat(0.05)));
        let table = solid(block(DVec3::new(1.0, 1.0, 0.03)).translated(DVec3::new(0.0, 0.0, -0.03)));
        let placed = |solid, z| PlacedSolid {
            solid,
            world_from_object: Pose { translation_m: DVec3::new(0.3, 0.1, z), rotation: DQuat::IDENTITY },
        };
        let on = |z| {
            let table = at(&table, 0.0, 0.0, 0.0);
            contact_region(&placed(&cube, z), &table, 0.001, None, &[], &CancelFlag::default())
                .expect("not cancelled")
        };
        let hull = on(0.0009);
        let center = DVec2::new(0.3, 0.1);
        assert!((depth_in_convex_m(&hull, center) - 0.025).abs() < 1e-6);
        assert!((depth_in_convex_m(&hull, center + DVec2::new(0.03, 0.0)) + 0.005).abs() < 1e-6);
        assert!(on(0.0011).is_empty());
    }

    /// Slow reference: every triangle of both surfaces sampled evenly, no pruning.
    fn reference(a: &PlacedSolid, b: &PlacedSolid) -> f64 {
        let mut worst = f64::NEG_INFINITY;
        for (x, y) in [(a, b), (b, a)] {
            let y_from_x = y.world_from_object.inverse() * x.world_from_object;
            for [p, q, r] in x.solid.triangles() {
                for i in 0..=24 {
                    for j in 0..=24 - i {
                        let (u, v) = (f64::from(i) / 24.0, f64::from(j) / 24.0);
                        let point = p + u * (q - p) + v * (r - p);
                        worst = worst.max(y.solid.depth_m(y_from_x.transform_point(point)));
                    }
                }
            }
        }
        worst
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(24))]
        #[test]
        fn penetration_agrees_with_exhaustive_sampling(x in -0.03..0.03_f64, z in 0.01..0.06_f64, tilt in -1.5..1.5_f64) {
            let (cube, bar) = (solid(block(DVec3::splat(0.03))), solid(block(DVec3::new(0.06, 0.01, 0.02))));
            let a = at(&cube, 0.0, 0.0, 0.0);
            let b = PlacedSolid {
                solid: &bar,
                world_from_object: Pose {
                    translation_m: DVec3::new(x, 0.5 * x, z),
                    rotation: DQuat::from_rotation_y(tilt) * DQuat::from_rotation_z(x * 30.0),
                },
            };
            let slow = reference(&a, &b);
            let fast = depth(&a, &b);
            if slow > 0.0025 {
                prop_assert!(fast.is_some_and(|d| (d - slow).abs() < 0.0015), "{:?} against {}", fast, slow);
            }
            if slow < 0.0 {
                prop_assert_eq!(fast, None);
            }
        }
    }
}
