//! SS, the support metric: whether an object's contacts carry it.
//!
//! Contacts are pairs closer than the gap: surface points of the visual meshes, and the corners of the contact patches
//! of the hulls, since hulls carry in every simulator and may stand off the visual surface by a fraction of a
//! millimeter. The hulls are tested first: they are cheap, and more contacts can only widen the support region. The
//! visual meshes are searched only where the hulls alone do not carry. World frame, meters.

use glam::DVec2;

use super::metrics::{CertifySettings, world_box};
use super::{Body, hull_set::HullSet};
use geometry::collide::{PlacedSolid, contact_region};
use geometry::collision_shape::to_parry;
use geometry::polygon::{convex_hull_2d, depth_in_convex_m};
use runtime::{CancelFlag, Cancelled};
use scene::SupportTree;

/// Support of one object.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SupportFinding {
    /// Signed distance of the projected center of mass inside the dilated support region, meters: a lower
    /// bound where positive, since the search ends with the first contacts that carry;
    /// `f64::NEG_INFINITY` where nothing is touched.
    pub margin_m: f64,
    /// Points that span the support region; 0 where nothing is touched.
    pub contacts: usize,
}

impl SupportFinding {
    pub fn is_supported(&self) -> bool {
        self.margin_m >= 0.0
    }
}

/// The bodies that may carry a body: its supporter, and for a contained body the other bodies in its container. Body 0
/// is the table, which nothing carries; body k + 1 is object k of the tree.
pub fn carriers(supports: &SupportTree, body: usize) -> Vec<usize> {
    let Some(object) = body.checked_sub(1) else { return Vec::new() };
    let below = supports.supporter(object).parent.map_or(0, |parent| parent + 1);
    std::iter::once(below).chain(supports.container_mates(object).map(|mate| mate + 1)).collect()
}

/// SS of one object: is the center of mass above the hull of all contacts (gap at most 1 mm) with all
/// its supporters, projected and dilated by 2 mm? Supporters are `carriers` (every contact counts: what it
/// stands on or in, and what lies in the same container, since heaped objects lean on each other) and any other
/// object it touches from above. `solids` give the poses; `bodies`, in the same order, the hulls and the
/// center of mass.
pub fn support(
    solids: &[PlacedSolid],
    bodies: &[Body],
    object: usize,
    carriers: &[usize],
    settings: &CertifySettings,
    cancel: &CancelFlag,
) -> Result<SupportFinding, Cancelled> {
    let scene = ContactCandidates::new(solids, bodies, object, carriers, settings);
    let mut points = scene.hull_contacts();
    for &other in &scene.others {
        if scene.finding(&points).is_supported() {
            break;
        }
        let slope = scene.min_slope(other);
        let (object, other) = (&solids[object], &solids[other]);
        points = contact_region(object, other, settings.contact_gap_m, slope, &points, cancel)?;
    }
    Ok(scene.finding(&points))
}

/// [`support`] by contacts of the hulls alone: a lower bound of the margin, hundreds of times cheaper where
/// the hulls do not carry.
pub fn support_by_hulls(
    solids: &[PlacedSolid],
    bodies: &[Body],
    object: usize,
    carriers: &[usize],
    settings: &CertifySettings,
) -> SupportFinding {
    let scene = ContactCandidates::new(solids, bodies, object, carriers, settings);
    scene.finding(&scene.hull_contacts())
}

/// An object and the objects it may touch.
struct ContactCandidates<'a> {
    solids: &'a [PlacedSolid<'a>],
    bodies: &'a [Body],
    object: usize,
    carriers: &'a [usize],
    settings: &'a CertifySettings,
    others: Vec<usize>,
}

impl<'a> ContactCandidates<'a> {
    fn new(
        solids: &'a [PlacedSolid<'a>],
        bodies: &'a [Body],
        object: usize,
        carriers: &'a [usize],
        settings: &'a CertifySettings,
    ) -> Self {
        let (low, high) = world_box(&solids[object]);
        let near = |other: &usize| {
            let (other_low, other_high) = world_box(&solids[*other]);
            let apart_m = (low - other_high).max(other_low - high).max_element();
            // Hulls may stick out of the visual mesh a little.
            *other != object && apart_m <= 5.0 * settings.contact_gap_m
        };
        let others = (0..solids.len()).filter(near).collect();
        Self { solids, bodies, object, carriers, settings, others }
    }

    fn min_slope(&self, other: usize) -> Option<f64> {
        (!self.carriers.contains(&other)).then_some(self.settings.carrying_slope)
    }

    /// Corners of the contact patches of the hulls that carry, seen from above.
    fn hull_contacts(&self) -> Vec<DVec2> {
        let own_pose = self.solids[self.object].world_from_object;
        let own_hulls = HullSet::new(&self.bodies[self.object].hulls);
        let mut points: Vec<DVec2> = Vec::new();
        for &other in &self.others {
            let own_from_other = to_parry(&(own_pose.inverse() * self.solids[other].world_from_object));
            let hulls = HullSet::new(&self.bodies[other].hulls);
            for patch in own_hulls.patches(&hulls, &own_from_other, self.settings.contact_gap_m) {
                let down = -own_pose.transform_vector(patch.normal).z;
                if self.min_slope(other).is_none_or(|slope| down >= slope) {
                    points.extend(patch.points.iter().map(|p| own_pose.transform_point(p.on_a).truncate()));
                }
            }
        }
        points
    }

    fn finding(&self, points: &[DVec2]) -> SupportFinding {
        let center = self.bodies[self.object].mass.center_of_mass_m;
        let center = self.solids[self.object].world_from_object.transform_point(center).truncate();
        SupportFinding {
            margin_m: depth_in_convex_m(&convex_hull_2d(points), center) + self.settings.support_dilation_m,
            contacts: points.len(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_bodies::{body, certify_settings, mesh};
    use geometry::shapes::block;
    use geometry::solid_query::MeshSolid;
    use geometry::{Pose, Solid};
    use glam::DVec3;

    struct Scenery {
        solids: Vec<MeshSolid>,
        bodies: Vec<Body>,
    }

    impl Scenery {
        fn new(solids: &[(&str, Solid, DVec3)]) -> Self {
            let bodies = solids
                .iter()
                .map(|(name, solid, at)| body(name, solid.clone(), Pose::upright(*at, 0.0)))
                .collect();
            let solids =
                solids.iter().map(|(_, s, _)| MeshSolid::new(&mesh(s.clone())).expect("a solid")).collect();
            Self { solids, bodies }
        }

        fn finding(&self, object: usize) -> SupportFinding {
            let placed: Vec<PlacedSolid> = self
                .solids
                .iter()
                .zip(&self.bodies)
                .map(|(solid, body)| PlacedSolid { solid, world_from_object: body.world_from_object })
                .collect();
            support(&placed, &self.bodies, object, &[0], &certify_settings(), &CancelFlag::default())
                .expect("no interrupt")
        }
    }

    #[test]
    fn carriers_are_supporter_and_container_mates() {
        use scene::Supporter;
        // A bowl (body 1) with two apples (2, 3), a saucer (4) with a mug (5).
        let apple = Supporter::containing(0);
        let supporters = vec![Supporter::TABLE, apple, apple, Supporter::TABLE, Supporter::on(3)];
        let tree = SupportTree::new(supporters).expect("a tree");
        let found: Vec<Vec<usize>> = (0..6).map(|body| carriers(&tree, body)).collect();
        assert_eq!(found, [vec![], vec![0], vec![1, 3], vec![1, 2], vec![0], vec![4]]);
    }

    #[test]
    fn support_margin_is_edge_distance_plus_dilation() {
        let top = block(DVec3::new(1.0, 1.0, 0.03)).translated(DVec3::new(0.0, 0.0, -0.03));
        let margin = |x, z| {
            let cube = block(DVec3::splat(0.05));
            Scenery::new(&[("top", top.clone(), DVec3::ZERO), ("cube", cube, DVec3::new(x, 0.0, z))])
                .finding(1)
        };
        assert!((margin(0.0, 0.0).margin_m - 0.027).abs() < 1e-6);
        assert!((margin(0.49, 0.0).margin_m - 0.012).abs() < 1e-3, "{:?}", margin(0.49, 0.0));
        assert!(!margin(0.505, 0.0).is_supported() && margin(0.5, 0.0).is_supported());
        assert_eq!(margin(0.0, 0.01).contacts, 0);
        assert!(!margin(0.0, 0.01).is_supported());
    }

    #[test]
    fn support_of_bridge_counts_both_piers_only() {
        let (pier, beam) = (block(DVec3::splat(0.05)), block(DVec3::new(0.3, 0.04, 0.02)));
        let mut scene = Scenery::new(&[
            ("pier", pier.clone(), DVec3::new(-0.1, 0.0, 0.0)),
            ("other_pier", pier, DVec3::new(0.1, 0.0, 0.0)),
            ("beam", beam, DVec3::new(0.0, 0.0, 0.05)),
        ]);
        assert!((scene.finding(2).margin_m - 0.022).abs() < 1e-6, "half the beam's width plus 2 mm");
        // Without the second pier a block standing beside it does not carry.
        scene.bodies[1].world_from_object.translation_m = DVec3::new(0.1755, 0.0, 0.05);
        assert!(scene.finding(2).margin_m < 0.0);
    }

    #[test]
    fn support_accepts_hull_contacts_alone() {
        // The coaster's hull is half a millimeter thicker than its mesh, so the visual gap is too wide.
        let (coaster, mug) = (block(DVec3::new(0.1, 0.1, 0.004)), block(DVec3::splat(0.06)));
        let mut scene =
            Scenery::new(&[("coaster", coaster, DVec3::ZERO), ("mug", mug, DVec3::new(0.0, 0.0, 0.0055))]);
        assert_eq!(scene.finding(1).contacts, 0);
        for p in &mut scene.bodies[0].hulls[0].points {
            p.z *= 0.0055 / 0.004;
        }
        assert!((scene.finding(1).margin_m - 0.032).abs() < 1e-6, "{:?}", scene.finding(1));
    }
}
