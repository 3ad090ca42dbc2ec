//! Contacts of bodies at rest, and the one supporter that the support tree gives each.

use glam::DVec2;

use crate::Body;
use crate::hull_set::HullSet;
use geometry::Pose;
use geometry::collision_shape::to_parry;
use geometry::polygon::{convex_hull_2d, depth_in_convex_m};
use scene::{SupportTree, Supporter};

/// Area that a contact in a point counts as, square meters: points and edges carry too.
const POINT_AREA_M2: f64 = 1e-6;

/// A supporter contains only if its axis leans by less than this, as a cosine.
const UPRIGHT: f64 = 0.7;

/// Contact of a body with another one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Contact {
    /// Index of the other body.
    pub other: usize,
    /// Area of the contact that carries the body, seen from above, square meters; 0 where the other one is above it or
    /// beside it.
    pub carrying_m2: f64,
}

/// Contacts of each body with any other, by hulls closer than a gap.
pub fn contacts(bodies: &[Body], gap_m: f64) -> Vec<Vec<Contact>> {
    let sets: Vec<HullSet> = bodies.iter().map(|body| HullSet::new(&body.hulls)).collect();
    let mut found: Vec<Vec<Contact>> = vec![Vec::new(); bodies.len()];
    for b in 1..bodies.len() {
        for a in 0..b {
            let a_from_b = to_parry(&(bodies[a].world_from_object.inverse() * bodies[b].world_from_object));
            let patches = sets[a].patches(&sets[b], &a_from_b, gap_m);
            if patches.is_empty() {
                continue;
            }
            let (mut carries_a_m2, mut carries_b_m2) = (0.0, 0.0);
            for patch in &patches {
                let pose = &bodies[a].world_from_object;
                let up = pose.transform_vector(patch.normal).z;
                let points: Vec<DVec2> =
                    patch.points.iter().map(|point| pose.transform_point(point.on_a).truncate()).collect();
                let area_m2 = area_m2(&convex_hull_2d(&points)) + POINT_AREA_M2 * up.abs();
                // The normal points from a to b: if it points up, a carries b.
                carries_b_m2 += if up > 0.0 { area_m2 } else { 0.0 };
                carries_a_m2 += if up < 0.0 { area_m2 } else { 0.0 };
            }
            found[a].push(Contact { other: b, carrying_m2: carries_a_m2 });
            found[b].push(Contact { other: a, carrying_m2: carries_b_m2 });
        }
    }
    found
}

fn area_m2(outline: &[DVec2]) -> f64 {
    let sides = (0..outline.len()).map(|k| (outline[k], outline[(k + 1) % outline.len()]));
    (0.5 * sides.map(|(a, b)| a.perp_dot(b)).sum::<f64>()).max(0.0)
}

/// Supports of the objects after some were dropped: each of these rests on what carries it with the largest contact,
/// or in it if it is one of `containers` and the center of mass is below its top. The others keep their supporters.
/// Body 0 is the table; the lists are of the bodies.
pub fn supporters(
    bodies: &[Body],
    before: &SupportTree,
    dropped: &[bool],
    containers: &[bool],
    gap_m: f64,
) -> SupportTree {
    let touching = contacts(bodies, gap_m);
    let mut supporters: Vec<Supporter> = before.supporters().to_vec();
    let center_m =
        |body: usize| bodies[body].world_from_object.transform_point(bodies[body].mass.center_of_mass_m);
    let mut order: Vec<usize> = (1..bodies.len()).filter(|&body| dropped[body]).collect();
    order.iter().for_each(|&body| supporters[body - 1] = Supporter::TABLE);
    order.sort_by(|&a, &b| center_m(a).z.total_cmp(&center_m(b).z).then(a.cmp(&b)));
    for body in order {
        let mut carrying: Vec<Contact> =
            touching[body].iter().copied().filter(|contact| contact.carrying_m2 > 0.0).collect();
        carrying.sort_by(|a, b| b.carrying_m2.total_cmp(&a.carrying_m2).then(a.other.cmp(&b.other)));
        let rests_on_body = |start: usize| {
            let below = |other: &usize| supporters[other - 1].parent.map(|parent| parent + 1);
            std::iter::successors(Some(start), below).any(|other| other == body)
        };
        let free = carrying.iter().find(|contact| contact.other == 0 || !rests_on_body(contact.other));
        supporters[body - 1] = match free.map(|contact| contact.other) {
            None | Some(0) => Supporter::TABLE,
            Some(below) if containers[below] && is_inside(&bodies[below], center_m(body)) => {
                Supporter::containing(below - 1)
            }
            Some(below) => Supporter::on(below - 1),
        };
    }
    SupportTree::without_contradictions(&supporters)
}

/// Whether a point is above the footprint of an upright container, below its top.
fn is_inside(container: &Body, point: glam::DVec3) -> bool {
    let pose: &Pose = &container.world_from_object;
    let corners = || container.hulls.iter().flat_map(|hull| &hull.points).map(|p| pose.transform_point(*p));
    let top_m = corners().map(|corner| corner.z).fold(f64::NEG_INFINITY, f64::max);
    let outline: Vec<DVec2> = corners().map(|corner| corner.truncate()).collect();
    pose.transform_vector(glam::DVec3::Z).z > UPRIGHT
        && point.z < top_m
        && depth_in_convex_m(&convex_hull_2d(&outline), point.truncate()) > 0.0
}
