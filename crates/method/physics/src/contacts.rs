//! Contact generation between two bodies of many hulls: few points, well spread, and stable from step to step.
//!
//! The engine's own contacts consider four consecutive corners of a facet. A round foot then rests on one quarter of
//! its rim and walks, and a mat on a large table may have no contact at all. Here every pair of hulls gives its whole
//! patch ([`mod@geometry::contact_patch`]). Patches of the two bodies that share a direction form one contact plane.
//! Of its points those are kept that are lowest when the bodies tilt slightly in each direction ([`TILTS_RAD`]): a
//! corner that is left out is found only when it is deep already, and the push that follows keeps the body rocking and
//! walking. Impulses of the last step are carried over to the nearest point.

use std::f64::consts::TAU;

use glam::{DVec2, DVec3};
use rapier3d_f64::geometry::{ContactData, ContactManifold, ContactManifoldData, TrackedContact};
use rapier3d_f64::math::Pose as RapierPose;
use rapier3d_f64::parry::query::details::{
    ContactManifoldsWorkspace, NormalConstraints, ShapeCastOptions, TypedWorkspaceData, WorkspaceData,
};
use rapier3d_f64::parry::query::{
    ClosestPoints, Contact, NonlinearRigidMotion, PersistentQueryDispatcher, QueryDispatcher, ShapeCastHit,
    ShapeDistance, ShapeIntersection, Unsupported,
};
use rapier3d_f64::parry::shape::{PackedFeatureId, Shape};

use super::hull_set::HullSet;
use geometry::contact_patch::{ContactPatch, PatchPoint};

/// A plane keeps the points that come first when the bodies tilt by this much against each other, radians,
/// toward each of [`DIRECTIONS`] directions: the small tilt finds the corners of what touches, the large
/// one those that touch next when it rocks.
const TILTS_RAD: [f64; 2] = [0.002, 0.02];

/// See [`TILTS_RAD`].
const DIRECTIONS: usize = 8;

/// A point of the last step is kept where another is not lower by more than this, meters.
const LOYALTY_M: f64 = 2e-6;

/// Patches whose normals differ by less (as a cosine, 1.8 degrees) are one contact plane.
const SAME_PLANE: f64 = 0.9995;

/// A point this close to one of the last step is the same point, meters.
const SAME_POINT_M: f64 = 5e-4;

/// The solver takes the points of a plane in groups of this many.
const MANIFOLD_POINTS: usize = 4;

/// Contact queries of the engine between pairs of [`HullSet`]s.
pub struct HullContacts;

/// Informs the engine that the number of contact planes changes from step to step.
struct Composite;

impl WorkspaceData for Composite {
    fn as_typed_workspace_data(&self) -> TypedWorkspaceData<'_> {
        TypedWorkspaceData::Custom
    }

    fn clone_dyn(&self) -> Box<dyn WorkspaceData> {
        Box::new(Composite)
    }
}

impl PersistentQueryDispatcher<ContactManifoldData, ContactData> for HullContacts {
    fn contact_manifolds(
        &self,
        a_from_b: &RapierPose,
        a: &dyn Shape,
        b: &dyn Shape,
        prediction: f64,
        manifolds: &mut Vec<ContactManifold>,
        workspace: &mut Option<ContactManifoldsWorkspace>,
    ) -> Result<(), Unsupported> {
        let (Some(a), Some(b)) = (a.as_shape::<HullSet>(), b.as_shape::<HullSet>()) else {
            return Err(Unsupported);
        };
        workspace.get_or_insert_with(|| ContactManifoldsWorkspace(Box::new(Composite)));
        let mut known: Vec<Known> = manifolds
            .iter()
            .flat_map(|m| m.points.iter().map(|p| Known { at: p.local_p1, normal: m.local_n1, data: p.data }))
            .collect();
        let planes = contact_planes(&a.patches(b, a_from_b, prediction));
        manifolds.clear();
        for plane in &planes {
            for group in plane.groups(&known) {
                let mut manifold = ContactManifold::new();
                manifold.local_n1 = plane.normal;
                manifold.local_n2 = a_from_b.rotation.inverse() * -plane.normal;
                for point in group {
                    let mut contact = TrackedContact::new(
                        point.on_a,
                        a_from_b.inverse_transform_point(point.on_b),
                        PackedFeatureId::UNKNOWN,
                        PackedFeatureId::UNKNOWN,
                        point.gap_m,
                    );
                    contact.data = take_known(&mut known, &point, plane.normal);
                    manifold.points.push(contact);
                }
                manifolds.push(manifold);
            }
        }
        Ok(())
    }

    fn contact_manifold_convex_convex(
        &self,
        _: &RapierPose,
        _: &dyn Shape,
        _: &dyn Shape,
        _: Option<&dyn NormalConstraints>,
        _: Option<&dyn NormalConstraints>,
        _: f64,
        _: &mut ContactManifold,
    ) -> Result<(), Unsupported> {
        Err(Unsupported)
    }
}

/// A point of the last step with its impulses.
struct Known {
    at: DVec3,
    normal: DVec3,
    data: ContactData,
}

impl Known {
    fn is(&self, point: &PatchPoint, normal: DVec3) -> bool {
        self.at.distance_squared(point.on_a) < SAME_POINT_M * SAME_POINT_M && self.normal.dot(normal) > 0.98
    }
}

/// The impulses of the nearest known point, which is used up.
fn take_known(known: &mut Vec<Known>, point: &PatchPoint, normal: DVec3) -> ContactData {
    let nearest = known.iter().enumerate().filter(|(_, k)| k.is(point, normal)).min_by(|(_, k), (_, l)| {
        k.at.distance_squared(point.on_a).total_cmp(&l.at.distance_squared(point.on_a))
    });
    match nearest {
        Some((index, _)) => known.swap_remove(index).data,
        None => ContactData::default(),
    }
}

/// Points that share a direction.
struct ContactPlane {
    normal: DVec3,
    points: Vec<PatchPoint>,
}

fn contact_planes(patches: &[ContactPatch]) -> Vec<ContactPlane> {
    let mut planes: Vec<ContactPlane> = Vec::new();
    for patch in patches {
        match planes.iter_mut().find(|plane| plane.normal.dot(patch.normal) > SAME_PLANE) {
            Some(plane) => plane.points.extend(&patch.points),
            None => planes.push(ContactPlane { normal: patch.normal, points: patch.points.clone() }),
        }
    }
    planes
}

impl ContactPlane {
    /// The selected points, in groups of the solver's size. Points of the last step are preferred.
    fn groups(&self, known: &[Known]) -> Vec<Vec<PatchPoint>> {
        let (u, v) = self.normal.any_orthonormal_pair();
        let flat = |p: &PatchPoint| DVec2::new(p.on_a.dot(u), p.on_a.dot(v));
        let is_known = |p: &PatchPoint| known.iter().any(|k| k.is(p, self.normal));
        let points: Vec<(DVec2, f64, &PatchPoint)> = self
            .points
            .iter()
            .map(|p| (flat(p), if is_known(p) { p.gap_m - LOYALTY_M } else { p.gap_m }, p))
            .collect();
        let mut kept: Vec<(DVec2, PatchPoint)> = Vec::with_capacity(TILTS_RAD.len() * DIRECTIONS);
        for tilt_rad in TILTS_RAD {
            for k in 0..DIRECTIONS {
                let slope = tilt_rad * DVec2::from_angle(TAU * k as f64 / DIRECTIONS as f64);
                let first = points
                    .iter()
                    .map(|&(at, gap_m, point)| (gap_m - slope.dot(at), at, point))
                    .min_by(|a, b| a.0.total_cmp(&b.0));
                if let Some((_, at, point)) = first
                    && kept.iter().all(|(other, _)| other.distance_squared(at) > SAME_POINT_M * SAME_POINT_M)
                {
                    kept.push((at, *point));
                }
            }
        }
        dealt(kept.into_iter().map(|(_, point)| point).collect())
    }
}

/// Points in groups of four, dealt in turn so that each group spans the plane.
fn dealt(points: Vec<PatchPoint>) -> Vec<Vec<PatchPoint>> {
    let hands = points.len().div_ceil(MANIFOLD_POINTS);
    let mut groups = vec![Vec::with_capacity(MANIFOLD_POINTS); hands];
    for (k, point) in points.into_iter().enumerate() {
        groups[k % hands].push(point);
    }
    groups
}

/// The simulation uses contact queries only: no joints, rays or continuous collision.
impl QueryDispatcher for HullContacts {
    fn intersection_test(
        &self,
        _: &RapierPose,
        _: &dyn Shape,
        _: &dyn Shape,
    ) -> Result<ShapeIntersection, Unsupported> {
        Err(Unsupported)
    }

    fn distance(&self, _: &RapierPose, _: &dyn Shape, _: &dyn Shape) -> Result<ShapeDistance, Unsupported> {
        Err(Unsupported)
    }

    fn contact(
        &self,
        _: &RapierPose,
        _: &dyn Shape,
        _: &dyn Shape,
        _: f64,
    ) -> Result<Option<Contact>, Unsupported> {
        Err(Unsupported)
    }

    fn closest_points(
        &self,
        _: &RapierPose,
        _: &dyn Shape,
        _: &dyn Shape,
        _: f64,
    ) -> Result<ClosestPoints, Unsupported> {
        Err(Unsupported)
    }

    fn cast_shapes(
        &self,
        _: &RapierPose,
        _: DVec3,
        _: &dyn Shape,
        _: &dyn Shape,
        _: ShapeCastOptions,
    ) -> Result<Option<ShapeCastHit>, Unsupported> {
        Err(Unsupported)
    }

    fn cast_shapes_nonlinear(
        &self,
        _: &NonlinearRigidMotion,
        _: &dyn Shape,
        _: &NonlinearRigidMotion,
        _: &dyn Shape,
        _: f64,
        _: f64,
        _: bool,
    ) -> Result<Option<ShapeCastHit>, Unsupported> {
        Err(Unsupported)
    }
}

#[cfg(test)]
mod tests {
    use glam::{DQuat, DVec3};

    use crate::settle::{settle, simulate_to_the_end};
    use crate::test_bodies::{body, settle_settings, table};
    use crate::{Body, SettledPoses};
    use geometry::Pose;
    use geometry::convex_hull::convex_hull;
    use geometry::shapes::{block, cylinder, prism, rounded_block, rounded_rectangle, shell_of_revolution};
    use runtime::CancelFlag;

    fn five_seconds(bodies: &[Body]) -> SettledPoses {
        simulate_to_the_end(bodies, &settle_settings(), &CancelFlag::default()).expect("a simulation")
    }

    /// Nothing moved by more than a tenth of a millimeter or turned by more than a milliradian.
    fn assert_still(settled: &SettledPoses) {
        for (k, (way_m, turned_rad)) in settled.displacements_m.iter().zip(&settled.rotations_rad).enumerate()
        {
            assert!(*way_m < 1e-4 && *turned_rad < 1e-3, "{k} moved {way_m} m and turned {turned_rad}");
        }
    }

    #[test]
    fn round_mug_does_not_walk() {
        let mug = |name, x| {
            body(name, cylinder(0.04, 0.09, 0.001, 48), Pose::upright(DVec3::new(x, 0.1, 0.0), 0.2))
        };
        assert_still(&five_seconds(&[table(), mug("mug", 0.0), mug("other", 0.3)]));
    }

    #[test]
    fn mug_of_many_wedges_does_not_walk() {
        // Sixteen wedges share the foot: many facets in one plane.
        let whole = shell_of_revolution(
            &[glam::DVec2::new(0.03, 0.0), glam::DVec2::new(0.04, 0.09)],
            0.004,
            0.006,
            48,
        );
        let mut mug = body("mug", whole, Pose::upright(DVec3::new(0.1, 0.0, 0.0), 0.0));
        mug.hulls = (0..16)
            .map(|k| {
                let turn = DQuat::from_rotation_z(std::f64::consts::TAU * f64::from(k) / 16.0);
                let wedge = [(0.02, 0.0), (0.03, 0.0), (0.034, 0.09), (0.04, 0.09)];
                let half = (std::f64::consts::PI / 16.0).tan();
                let corners: Vec<DVec3> = wedge
                    .iter()
                    .flat_map(|&(r, z)| [-1.0, 1.0].map(|side| turn * DVec3::new(r, side * half * r, z)))
                    .collect();
                convex_hull(&corners, 64, 0.001).expect("a wedge")
            })
            .collect();
        assert_still(&five_seconds(&[table(), mug]));
    }

    #[test]
    fn mat_stays_on_table_with_round_corners() {
        // Seventeen corners at each end of the top: four consecutive ones do not span its center.
        let mut top = table();
        let outline = rounded_rectangle(1.4, 0.8, 0.05, 16);
        let solid = prism(&outline, 0.03).translated(DVec3::new(0.0, 0.0, -0.03));
        top.hulls = vec![convex_hull(&solid.positions, 255, 0.001).expect("a top")];
        let mat =
            body("mat", block(DVec3::new(0.3, 0.22, 0.0015)), Pose::upright(DVec3::new(0.2, -0.1, 0.0), 0.3));
        let settled = five_seconds(&[top, mat]);
        assert_still(&settled);
        assert!(settled.poses[1].translation_m.z.abs() < 2e-4);
    }

    #[test]
    fn loaded_plate_does_not_tilt() {
        let plate = body("plate", cylinder(0.12, 0.01, 0.001, 40), Pose::upright(DVec3::ZERO, 0.0));
        let load = body("load", block(DVec3::splat(0.05)), Pose::upright(DVec3::new(0.06, 0.03, 0.01), 0.7));
        assert_still(&five_seconds(&[table(), plate, load]));
    }

    #[test]
    fn rounded_block_does_not_rock_or_walk() {
        // The rim of the rounding lies outside the face it stands on, a little higher.
        for (size, radius) in [(DVec3::splat(0.018), 0.002), (DVec3::new(0.19, 0.06, 0.28), 0.003)] {
            let block = rounded_block(size, radius, radius);
            let lowest = block.positions.iter().map(|p| p.z).fold(f64::INFINITY, f64::min);
            let at = Pose::upright(DVec3::new(0.1, 0.05, -lowest), 0.3);
            let mut bodies = [table(), body("block", block, at)];
            bodies[1].world_from_object = five_seconds(&bodies).poses[1];
            assert_still(&five_seconds(&bodies));
        }
    }

    #[test]
    fn stack_of_rotated_boards_comes_to_rest() {
        // Regression: three books lay on each other, oscillated, and the top one moved by a millimeter a second.
        let sizes =
            [DVec3::new(0.16, 0.23, 0.03), DVec3::new(0.155, 0.235, 0.033), DVec3::new(0.14, 0.21, 0.026)];
        let mut bodies = vec![table()];
        let mut height_m = 0.0;
        for (k, size) in sizes.into_iter().enumerate() {
            let at = DVec3::new(0.001 * k as f64, -0.0015 * k as f64, height_m);
            let pose = Pose::upright(at, -0.2 - 0.05 * k as f64);
            bodies.push(body(&format!("book_{k}"), rounded_block(size, 0.0012, 0.0008), pose));
            height_m += size.z;
        }
        let rest = settle(&bodies, &settle_settings(), &CancelFlag::default()).expect("a simulation");
        assert!(rest.at_rest && rest.simulated_s < 1.0, "{rest:?}");
        bodies.iter_mut().zip(&rest.poses).for_each(|(body, pose)| body.world_from_object = *pose);
        assert_still(&five_seconds(&bodies));
    }

    #[test]
    fn lying_can_rests_on_facet() {
        let lying = Pose {
            translation_m: DVec3::new(0.0, 0.05, 0.0299),
            rotation: DQuat::from_rotation_x(std::f64::consts::FRAC_PI_2),
        };
        let settled = five_seconds(&[table(), body("can", cylinder(0.03, 0.1, 0.0, 24), lying)]);
        assert!(settled.at_rest && settled.displacements_m[1] < 0.006, "{settled:?}");
    }
}
