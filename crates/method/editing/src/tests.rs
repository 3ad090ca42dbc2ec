//! Free places and rest, on made scenes of blocks and a box without a lid.

use std::f64::consts::FRAC_PI_2;
use std::sync::Arc;

use glam::{DQuat, DVec2, DVec3};

use crate::place::{NoPlace, PlaceQuery};
use crate::rest::{RestFault, RestSettings};
use crate::workspace::{Workspace, WorkspaceObject};
use geometry::convex_hull::convex_hull;
use geometry::mass_properties::solid_mass_properties;
use geometry::shapes::{block, prism, sphere};
use geometry::solid_query::MeshSolid;
use geometry::{Friction, Material, Outline, Pose, Rgb, Solid, TexturedMesh};
use physics::{Body, CertifySettings, SettleSettings};
use runtime::CancelFlag;
use scene::predicates::{PosedRelation, holds};
use scene::{RelationKind, Supporter};

fn settle_settings() -> SettleSettings {
    SettleSettings {
        duration_s: 5.0,
        steps_per_s: 240.0,
        solver_iterations: 8,
        contact_frequency_hz: 350.0,
        length_unit_m: 0.02,
        damping_per_s: 0.05,
        rest_speed_m_s: 0.0005,
        rest_time_s: 0.25,
    }
}

fn certify_settings() -> CertifySettings {
    CertifySettings {
        penetration_m: 0.001,
        wall_share: 0.25,
        min_wall_m: 0.0004,
        sample_spacing_m: 0.001,
        contact_gap_m: 0.001,
        support_dilation_m: 0.002,
        carrying_slope: 0.2,
        dss_displacement_m: 0.03,
        dss_rotation_rad: 30_f64.to_radians(),
        dss_duration_s: 5.0,
        rest_side_share: 0.25,
        rest_rotation_rad: 2_f64.to_radians(),
    }
}

/// A body of several solids.
fn object(name: &str, solids: &[Solid], at_m: DVec2) -> WorkspaceObject {
    let mut mesh = TexturedMesh::default();
    for solid in solids {
        mesh.add(solid.clone(), &Material::plain("wood", Rgb::hex(0x80_60_40), 0.5));
    }
    let hulls = solids.iter().map(|s| convex_hull(&s.positions, 64, 0.001).expect("a solid")).collect();
    let body = Body {
        name: name.into(),
        hulls,
        world_from_object: Pose::upright(at_m.extend(0.0), 0.0),
        mass: solid_mass_properties(&mesh, 700.0).expect("a solid"),
        friction: Friction { static_coefficient: 0.5, dynamic_coefficient: 0.4 },
        restitution: 0.1,
        rolling_friction_m: 0.0003,
        fixed: false,
    };
    let solid = Arc::new(MeshSolid::new(&mesh).expect("a solid"));
    WorkspaceObject::new(body, solid, Supporter::TABLE, true).expect("convex hulls")
}

fn cube(name: &str, side_m: f64, at_m: DVec2) -> WorkspaceObject {
    object(name, &[block(DVec3::splat(side_m))], at_m)
}

/// A box without a lid: 20 cm wide, 10 cm high, walls of 1 cm.
fn open_box(at_m: DVec2) -> WorkspaceObject {
    let wall = |size: DVec3, at: DVec3| block(size).translated(at);
    object(
        "box_1",
        &[
            block(DVec3::new(0.2, 0.2, 0.01)),
            wall(DVec3::new(0.2, 0.01, 0.09), DVec3::new(0.0, 0.095, 0.01)),
            wall(DVec3::new(0.2, 0.01, 0.09), DVec3::new(0.0, -0.095, 0.01)),
            wall(DVec3::new(0.01, 0.18, 0.09), DVec3::new(0.095, 0.0, 0.01)),
            wall(DVec3::new(0.01, 0.18, 0.09), DVec3::new(-0.095, 0.0, 0.01)),
        ],
        at_m,
    )
}

fn table(side_m: f64, objects: Vec<WorkspaceObject>) -> Workspace {
    let half = 0.5 * side_m;
    let corners = [(-half, -half), (half, -half), (half, half), (-half, half)].map(DVec2::from).to_vec();
    let top = block(DVec3::new(side_m, side_m, 0.03)).translated(DVec3::new(0.0, 0.0, -0.03));
    let mut table = object("table", &[top], DVec2::ZERO);
    table.body.fixed = true;
    Workspace { outline: Outline::new(corners).expect("a square"), table, objects }
}

/// Puts an object down at the best place where it may stay.
fn put(workspace: &mut Workspace, object: usize, query: &PlaceQuery) -> Result<(), String> {
    let (settle, certify) = (settle_settings(), certify_settings());
    let settings = RestSettings { settle: &settle, certify: &certify, may_roll: false };
    let mut fault = String::new();
    for candidate in workspace.places(object, query).map_err(|error| error.to_string())? {
        match workspace.put_down(object, &candidate, settings, &CancelFlag::default()) {
            Ok(()) => return Ok(()),
            Err(error) => fault = error.to_string(),
        }
    }
    Err(fault)
}

fn related(relation: RelationKind, target: usize) -> PlaceQuery {
    PlaceQuery { relation: Some(relation), target: Some(target), ..PlaceQuery::default() }
}

#[test]
fn an_object_comes_to_rest_where_its_relation_holds_and_the_others_stay() {
    use RelationKind::{Behind, In, InFrontOf, LeftOf, NextTo, On, RightOf};
    for relation in [LeftOf, RightOf, InFrontOf, Behind, NextTo, On, In] {
        let mut scene =
            table(1.0, vec![open_box(DVec2::new(0.1, 0.05)), cube("cube_1", 0.04, DVec2::new(-0.3, -0.3))]);
        let board = object("board_1", &[block(DVec3::new(0.1, 0.1, 0.02))], DVec2::new(-0.1, 0.3));
        scene.objects.push(board);
        let target = if relation == On { 2 } else { 0 };
        let before: Vec<Pose> = scene.objects.iter().map(|o| o.body.world_from_object).collect();
        put(&mut scene, 1, &related(relation, target)).unwrap_or_else(|why| panic!("{relation:?}: {why}"));
        for other in [0, 2] {
            assert_eq!(scene.objects[other].body.world_from_object, before[other], "{relation:?}");
        }
        let (own, other) = (scene.objects[1].footprint(), scene.objects[target].footprint());
        let posed = PosedRelation {
            kind: relation,
            object: &own,
            target: Some(&other),
            second_target: None,
            distance_m: None,
        };
        assert!(holds(&posed, &scene.outline), "{relation:?}: {own:?}");
        let parent = scene.objects[1].supporter.parent;
        assert_eq!(parent, matches!(relation, On | In).then_some(target), "{relation:?}");
    }
}

#[test]
fn a_stated_distance_and_a_stated_position_are_met() {
    let mut scene =
        table(1.0, vec![cube("cube_1", 0.06, DVec2::ZERO), cube("cube_2", 0.06, DVec2::new(0.3, 0.3))]);
    let query = PlaceQuery { distance_m: Some(0.12), ..related(RelationKind::LeftOf, 0) };
    put(&mut scene, 1, &query).expect("there is room");
    let free_m = scene.objects[1].footprint().distance_m(&scene.objects[0].footprint());
    assert!((free_m - 0.12).abs() < 0.01, "{free_m}");
    let query = PlaceQuery { position_m: Some(DVec2::new(-0.2, -0.35)), ..PlaceQuery::default() };
    put(&mut scene, 1, &query).expect("there is room");
    assert!(scene.objects[1].footprint().center().distance(DVec2::new(-0.2, -0.35)) < 0.002);
}

#[test]
fn an_object_that_is_larger_than_the_place_is_refused_as_too_large() {
    let scene = table(0.5, vec![open_box(DVec2::ZERO), cube("cube_1", 0.3, DVec2::new(5.0, 0.0))]);
    let error = scene.places(1, &related(RelationKind::In, 0)).expect_err("30 cm do not fit into 18");
    assert!(matches!(error, NoPlace::TooLarge { .. }), "{error}");
    let huge = table(0.25, vec![cube("cube_1", 0.3, DVec2::ZERO)]);
    let error = huge.places(0, &PlaceQuery::default()).expect_err("the table is smaller");
    assert_eq!(error.to_string(), "cube_1 does not fit on the table: it is larger than the space there");
}

/// Regression: an object that was to go 5 m to the left was said to be larger than the space there.
#[test]
fn a_stated_place_beyond_the_edge_says_how_far_the_object_can_go() {
    let scene = table(0.5, vec![cube("cube_1", 0.1, DVec2::new(0.1, 0.0))]);
    let mut pose = scene.objects[0].body.world_from_object;
    pose.translation_m.x -= 5.0;
    let error = scene.place_at(0, pose, Supporter::TABLE).expect_err("there is no table");
    let says = "cube_1 would reach 4.70 m over the edge of the table; in that direction it can go 0.29 m";
    assert_eq!(error.to_string(), says);
    let query = PlaceQuery { position_m: Some(DVec2::new(-4.9, 0.0)), ..PlaceQuery::default() };
    assert_eq!(scene.places(0, &query).expect_err("there is no table").to_string(), says);
}

#[test]
fn what_is_in_the_way_is_named() {
    let others = (0..9).map(|k| {
        let at = 0.16 * DVec2::new(f64::from(k % 3) - 1.0, f64::from(k / 3) - 1.0);
        cube(&format!("cube_{}", k + 1), 0.1, at)
    });
    let mut objects: Vec<WorkspaceObject> = others.collect();
    let mut new = cube("cube_10", 0.1, DVec2::ZERO);
    new.is_placed = false;
    objects.push(new);
    let scene = table(0.45, objects);
    let error = scene.places(9, &PlaceQuery::default()).expect_err("six centimeters are free");
    let NoPlace::Blocked { by, .. } = &error else { panic!("{error}") };
    assert!(!by.is_empty() && error.to_string().contains("cube_"), "{error}");
}

#[test]
fn a_slender_object_that_is_longer_than_the_box_leans_in_it() {
    let stick = object("stick_1", &[block(DVec3::new(0.22, 0.012, 0.012))], DVec2::new(-0.3, 0.0));
    let mut scene = table(1.0, vec![open_box(DVec2::new(0.2, 0.0)), stick]);
    put(&mut scene, 1, &related(RelationKind::In, 0)).expect("it leans or lies across");
    assert!(scene.objects[1].footprint().bottom_m < 0.05);
}

#[test]
fn what_rests_on_an_object_moves_with_it() {
    let mut scene =
        table(1.0, vec![open_box(DVec2::new(0.2, 0.0)), cube("cube_1", 0.04, DVec2::new(-0.3, -0.3))]);
    put(&mut scene, 1, &related(RelationKind::In, 0)).expect("there is room");
    let inside = scene.objects[0].body.world_from_object.inverse() * scene.objects[1].body.world_from_object;
    let query = PlaceQuery { position_m: Some(DVec2::new(-0.3, 0.2)), ..PlaceQuery::default() };
    put(&mut scene, 0, &query).expect("there is room");
    let now = scene.objects[0].body.world_from_object.inverse() * scene.objects[1].body.world_from_object;
    assert!((now.translation_m - inside.translation_m).length() < 0.003, "{now:?}");
    let loose = scene.remove(0);
    assert_eq!((loose, scene.objects[0].supporter), (vec![0], Supporter::TABLE));
}

#[test]
fn an_object_that_would_reach_into_another_is_not_left_there() {
    let (settle, certify) = (settle_settings(), certify_settings());
    let settings = RestSettings { settle: &settle, certify: &certify, may_roll: false };
    let mut scene =
        table(1.0, vec![cube("cube_1", 0.06, DVec2::ZERO), cube("cube_2", 0.06, DVec2::new(0.3, 0.0))]);
    let overlapping = crate::Candidate {
        world_from_object: Pose::upright(DVec3::new(0.03, 0.0, 0.0), 0.0),
        supporter: Supporter::TABLE,
        stated_yaw_rad: None,
    };
    let fault = scene.put_down(1, &overlapping, settings, &CancelFlag::default()).expect_err("they overlap");
    assert!(!matches!(fault, RestFault::Cancelled), "{fault}");
    assert_eq!(scene.objects[1].body.world_from_object.translation_m.x, 0.3);
}

#[test]
fn what_rolls_as_it_is_put_down_lies_at_its_place_with_its_yaw() {
    let (settle, certify) = (settle_settings(), certify_settings());
    let settings = RestSettings { settle: &settle, certify: &certify, may_roll: false };
    // A bar with three sides, on one of its edges, falls onto a side.
    let sides = [DVec2::new(-0.03, 0.0), DVec2::new(0.03, 0.0), DVec2::new(0.0, 0.052)];
    let bar = prism(&sides, 0.2).rotated(DQuat::from_rotation_x(FRAC_PI_2));
    let mut scene = table(1.0, vec![object("bar_1", &[bar], DVec2::new(0.3, 0.3))]);
    let wanted_m = DVec2::new(-0.1, 0.05);
    for yaw_rad in [0.0, 0.7, -2.0] {
        let on_edge = DQuat::from_rotation_z(yaw_rad) * DQuat::from_rotation_y(1.2);
        let footprint =
            scene.objects[0].footprint_at(&Pose { translation_m: DVec3::ZERO, rotation: on_edge });
        let at_m = (wanted_m - footprint.center()).extend(0.0);
        let pose = Pose { translation_m: at_m, rotation: on_edge };
        let place = scene.place_at(0, pose, Supporter::TABLE).expect("an empty table");
        let candidate = crate::Candidate { stated_yaw_rad: Some(yaw_rad), ..place };
        scene.put_down(0, &candidate, settings, &CancelFlag::default()).expect("it lies on a side");
        let found = &scene.objects[0];
        assert!(found.footprint().center().distance(wanted_m) < 0.01, "{:?}", found.footprint().center());
        let off_rad = found.body.world_from_object.yaw_rad().expect("a yaw") - yaw_rad;
        assert!(off_rad.abs() < 0.09, "{off_rad}");
    }
}

#[test]
fn a_board_may_lie_on_a_broad_block_and_balance_neither_on_a_narrow_one_nor_on_a_ball() {
    let square = |width_m: f64| block(DVec3::new(width_m, width_m, 0.03));
    for (post, refused) in
        [(square(0.06), None), (square(0.012), Some("too narrow")), (sphere(0.038, 32), Some(""))]
    {
        let post = object("post_1", &[post], DVec2::ZERO);
        let board = object("board_1", &[block(DVec3::new(0.2, 0.2, 0.02))], DVec2::new(0.3, 0.3));
        let mut scene = table(1.0, vec![post, board]);
        let fault = put(&mut scene, 1, &related(RelationKind::On, 0)).err();
        assert_eq!(fault.is_some(), refused.is_some(), "{fault:?}");
        assert!(refused.is_none_or(|words| fault.is_some_and(|why| why.contains(words))));
    }
}
