//! Tests of dropped bodies: heaps of blocks, boards, cylinders and balls on a table of two meters.

use glam::DVec3;

use super::*;
use crate::metrics::{collisions, stability};
use crate::support::support;
use crate::test_bodies::{body, certify_settings, mesh, settle_settings, table, table_solid};
use geometry::Solid;
use geometry::collide::PlacedSolid;
use geometry::shapes::{block, cylinder, rectangle, rounded_block, sphere};
use scene::{SupportTree, Supporter};

struct Scenery {
    bodies: Vec<Body>,
    solids: Vec<MeshSolid>,
    roles: Vec<DropRole>,
    outline: Outline,
    resolve: ResolveSettings,
    settle: SettleSettings,
    certify: CertifySettings,
}

impl Scenery {
    /// The bodies stand in a row along the back edge.
    fn new(solids: Vec<(Solid, DropRole)>) -> Self {
        let count = solids.len();
        let mut scenery = Self {
            bodies: vec![table()],
            solids: vec![MeshSolid::new(&mesh(table_solid())).expect("a solid")],
            roles: solids.iter().map(|(_, role)| *role).collect(),
            outline: Outline::new(rectangle(2.0, 2.0)).expect("a square"),
            resolve: ResolveSettings {
                clearances_m: vec![0.001],
                separation_passes: 10,
                directions: 8,
                outline_margin_m: 0.002,
                container_depth_share: 0.3,
                rest_displacement_m: 0.001,
                rest_rotation_rad: 0.02,
                settles: 3,
                fallen_rotation_rad: std::f64::consts::FRAC_PI_6,
            },
            settle: settle_settings(),
            certify: certify_settings(),
        };
        for (k, (solid, _)) in solids.into_iter().enumerate() {
            let x = 1.8 * (k as f64 + 0.5) / count as f64 - 0.9;
            let lowest = solid.positions.iter().map(|p| p.z).fold(f64::INFINITY, f64::min);
            let pose = Pose::upright(DVec3::new(x, 0.8, -lowest), 0.0);
            scenery.solids.push(MeshSolid::new(&mesh(solid.clone())).expect("a solid"));
            scenery.bodies.push(body(&format!("body_{k}"), solid, pose));
        }
        scenery
    }

    /// Twelve bodies of five shapes, all of which may fall on any side.
    fn mixed() -> Self {
        let solids = (0..12)
            .map(|k| {
                let grown = 1.0 + 0.05 * f64::from(k);
                match k % 5 {
                    0 => block(DVec3::new(0.09, 0.06, 0.04) * grown),
                    1 => cylinder(0.03 * grown, 0.1 * grown, 0.0, 24),
                    2 => rounded_block(DVec3::new(0.17, 0.12, 0.02) * grown, 0.002, 0.002),
                    3 => sphere(0.03 * grown, 10),
                    _ => block(DVec3::new(0.15, 0.012, 0.012) * grown),
                }
            })
            .map(|solid| (solid, DropRole::AnySide))
            .collect();
        Self::new(solids)
    }

    fn drop(&self, density: f64, seed: u64) -> DroppedLayout {
        self.try_drop(density, seed, &CancelFlag::default()).expect("a heap")
    }

    fn try_drop(&self, density: f64, seed: u64, cancel: &CancelFlag) -> Result<DroppedLayout, ClutterError> {
        let solids: Vec<&MeshSolid> = self.solids.iter().collect();
        let problem = ClutterProblem {
            bodies: &self.bodies,
            solids: &solids,
            roles: &self.roles,
            outline: &self.outline,
            density,
            seed,
        };
        let settings =
            ClutterSettings { settle: &self.settle, resolve: &self.resolve, certify: &self.certify };
        drop_clutter(problem, settings, cancel)
    }

    fn placed(&self, layout: &DroppedLayout) -> Vec<Body> {
        let placed = |(body, pose): (&Body, &Pose)| Body { world_from_object: *pose, ..body.clone() };
        self.bodies.iter().zip(&layout.poses).map(placed).collect()
    }

    fn covered(&self, layout: &DroppedLayout) -> f64 {
        let placed = self.placed(layout);
        covered_share(&placed[1..].iter().collect::<Vec<_>>(), &self.outline)
    }
}

/// Everything that the certificate demands of poses.
fn assert_sound(scenery: &Scenery, layout: &DroppedLayout) {
    assert_eq!(layout.faults, Vec::<String>::new());
    let bodies = scenery.placed(layout);
    let cancel = CancelFlag::default();
    for body in &bodies[1..] {
        for corner in body.hulls.iter().flat_map(|hull| &hull.points) {
            let corner = body.world_from_object.transform_point(*corner);
            assert!(corner.z > -0.001, "{} reaches {} m below the table", body.name, -corner.z);
            assert!(scenery.outline.depth_inside_m(corner.truncate()) > -0.001, "{} {corner}", body.name);
        }
    }
    let rest = stability(&bodies, &scenery.certify, &scenery.settle, &cancel).expect("a simulation");
    assert!(
        rest.movements.iter().all(|movement| movement.at_rest && movement.stable),
        "{:?}",
        rest.movements
    );
    let placed: Vec<PlacedSolid> = scenery
        .solids
        .iter()
        .zip(&layout.poses)
        .map(|(solid, pose)| PlacedSolid { solid, world_from_object: *pose })
        .collect();
    let found = collisions(&placed, &scenery.certify, &cancel).expect("no interrupt");
    assert!(found.colliding.is_empty(), "{found:?}");
    let all: Vec<usize> = (0..bodies.len()).collect();
    for k in 1..bodies.len() {
        let finding = support(&placed, &bodies, k, &all, &scenery.certify, &cancel).expect("no interrupt");
        assert!(finding.is_supported(), "{k}: {finding:?}");
    }
}

#[test]
fn dropped_bodies_rest_on_the_table_and_are_sound() {
    let scenery = Scenery::mixed();
    for (density, seed) in [(0.0, 1), (0.6, 2), (1.0, 3)] {
        let layout = scenery.drop(density, seed);
        assert_sound(&scenery, &layout);
        assert!(layout.drops >= 12 && layout.set_down.len() <= 3, "{layout:?}");
    }
}

#[test]
fn equal_seeds_give_equal_heaps_with_any_number_of_threads_and_others_do_not() {
    let scenery = Scenery::mixed();
    let with = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
        pool.install(|| scenery.drop(0.7, 5))
    };
    let once = with(1);
    assert_eq!(once, with(3));
    assert_ne!(once.poses, scenery.drop(0.7, 6).poses);
}

#[test]
fn density_orders_the_covered_share_and_the_contacts() {
    let scenery = Scenery::mixed();
    let mut last = (0.0, 0);
    for density in [0.05, 0.5, 1.0] {
        let (mut share, mut touching) = (0.0, 0);
        for seed in 0..2 {
            let layout = scenery.drop(density, seed);
            share += scenery.covered(&layout) / 2.0;
            let found = contacts(&scenery.placed(&layout), scenery.certify.contact_gap_m);
            touching += found[1..].iter().flatten().filter(|contact| contact.other != TABLE).count();
        }
        assert!(
            share > last.0 + 0.05 && touching >= last.1,
            "{density}: {share} {touching}, not above {last:?}"
        );
        last = (share, touching);
    }
    assert!(last.1 >= 12, "{last:?}");
}

#[test]
fn kept_bodies_stay_and_standing_ones_stand() {
    let vessel = || cylinder(0.035, 0.08, 0.001, 32);
    let mut solids: Vec<(Solid, DropRole)> = (0..10).map(|_| (vessel(), DropRole::Standing)).collect();
    solids.push((block(DVec3::new(0.3, 0.2, 0.2)), DropRole::Kept));
    let mut scenery = Scenery::new(solids);
    scenery.bodies[11].world_from_object.translation_m = DVec3::new(0.1, 0.05, 0.0);
    let layout = scenery.drop(0.3, 4);
    assert_sound(&scenery, &layout);
    let kept = (layout.poses[11].translation_m - DVec3::new(0.1, 0.05, 0.0)).length();
    assert!(kept < 0.005, "{kept}");
    let standing = layout.poses[1..11].iter().filter(|pose| pose.transform_vector(DVec3::Z).z > 0.99).count();
    assert!(standing >= 7, "{standing}");
}

#[test]
fn dropping_is_cancelable_and_needs_a_role_for_each_object() {
    let mut scenery = Scenery::mixed();
    let cancel = CancelFlag::default();
    cancel.cancel();
    assert!(matches!(
        scenery.try_drop(0.5, 1, &cancel),
        Err(ClutterError::Cancelled(_) | ClutterError::Settle(SettleError::Cancelled(_)))
    ));
    scenery.roles.pop();
    let refused = scenery.try_drop(0.5, 1, &CancelFlag::default());
    assert_eq!(refused, Err(ClutterError::BadRoles { bodies: 13, roles: 11 }));
}

#[test]
fn supporters_are_those_with_the_largest_contact() {
    let at = |x: f64, z: f64| Pose::upright(DVec3::new(x, 0.0, z), 0.0);
    let bodies = [
        table(),
        body("low", block(DVec3::splat(0.1)), at(0.0, 0.0)),
        body("other", block(DVec3::splat(0.1)), at(0.11, 0.0)),
        // Eight centimeters of it on the first cube, five on the second.
        body("board", block(DVec3::new(0.14, 0.1, 0.02)), at(0.04, 0.1)),
        body("tray", block(DVec3::new(0.2, 0.2, 0.05)), at(0.5, 0.0)),
        body("apple", block(DVec3::splat(0.03)), at(0.5, 0.05)),
    ];
    let before = SupportTree::new(vec![Supporter::TABLE; 5]).expect("a tree");
    let dropped = [false, true, true, true, false, true];
    let found = supporters(&bodies, &before, &dropped, &[false; 6], 0.001);
    let on = Supporter::on;
    let table = Supporter::TABLE;
    assert_eq!(found.supporters(), [table, table, on(0), table, on(3)]);
    // The center of mass is not below the top of what would contain it.
    let containers = [false, false, false, false, true, false];
    assert_eq!(supporters(&bodies, &before, &dropped, &containers, 0.001), found);
    let touching = contacts(&bodies, 0.001);
    let names: Vec<usize> = touching[3].iter().map(|contact| contact.other).collect();
    assert_eq!(names, [1, 2]);
    assert!((touching[3][0].carrying_m2 - 0.008).abs() < 1e-3, "{:?}", touching[3]);
    assert_eq!(touching[1].iter().find(|contact| contact.other == 3).map(|c| c.carrying_m2), Some(0.0));
}
