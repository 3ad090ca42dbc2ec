//! A block, a plate that carries a lid, and a bystander, on a plain table.

use episodes::EpisodeUnit;
use episodes::format::{DepthStorage, Format};
use geometry::convex_hull::convex_hull;
use geometry::mass_properties::solid_mass_properties;
use geometry::shapes::{block, cylinder};
use geometry::{DVec2, DVec3, Friction, Material, Outline, Pose, Rgb, Solid, TexturedMesh};
use manipulation::execution::{ExecutionSettings, KnownGrasps, TaskScene};
use manipulation::grasp::GraspSettings;
use physics::Body;
use robot::model::Robot;
use runtime::seed::child_rng;
use scene::Supporter;
use tasks::Task;

use crate::arrangement;
use crate::camera::{Mount, usual};
use crate::sample::Sample;
use crate::setup::{SceneParts, Wanted, Work, prepare};
use crate::{Attempted, CameraSpec, Distractor, EpisodeRecord, Randomization, Setup, SetupError, attempt};

mod pitfalls;

fn mesh(solid: &Solid) -> TexturedMesh {
    let mut mesh = TexturedMesh::default();
    mesh.add(solid.clone(), &Material::plain("plain", Rgb::hex(0xc0_40_30), 0.5));
    mesh
}

fn body(name: &str, solid: &Solid, mass_kg: f64, at_m: DVec3) -> Body {
    Body {
        name: name.to_owned(),
        hulls: vec![convex_hull(&solid.positions, 64, 0.0005).expect("a solid")],
        world_from_object: Pose::upright(at_m, 0.0),
        mass: solid_mass_properties(&mesh(solid), 700.0).expect("a solid").with_mass(mass_kg),
        friction: Friction { static_coefficient: 0.6, dynamic_coefficient: 0.5 },
        restitution: 0.1,
        rolling_friction_m: 0.0003,
        fixed: false,
    }
}

fn parts() -> SceneParts {
    let top = block(DVec3::new(1.2, 0.8, 0.03)).translated(DVec3::new(0.0, 0.0, -0.03));
    let solids = [
        ("block_1", block(DVec3::splat(0.04)), 0.05, DVec3::new(-0.1, 0.05, 0.0)),
        ("plate_1", cylinder(0.09, 0.015, 0.0, 24), 0.3, DVec3::new(0.15, -0.05, 0.0)),
        ("lid_1", block(DVec3::new(0.02, 0.02, 0.01)), 0.02, DVec3::new(0.2, -0.05, 0.015)),
        ("tin_1", cylinder(0.03, 0.08, 0.0, 24), 0.3, DVec3::new(0.35, 0.2, 0.0)),
    ];
    let objects = solids.iter().map(|(name, solid, mass_kg, at_m)| body(name, solid, *mass_kg, *at_m));
    let corners = [(-0.6, -0.4), (0.6, -0.4), (0.6, 0.4), (-0.6, 0.4)].map(DVec2::from);
    SceneParts {
        scene: TaskScene {
            table: Body { fixed: true, ..body("table", &top, 10.0, DVec3::ZERO) },
            outline: Outline::new(corners.to_vec()).expect("a rectangle"),
            objects: objects.collect(),
        },
        supporters: vec![Supporter::TABLE, Supporter::TABLE, Supporter::on(1), Supporter::TABLE],
        meshes: std::iter::once(mesh(&top)).chain(solids.iter().map(|(_, solid, ..)| mesh(solid))).collect(),
        distractors: Vec::new(),
        digest: "a scene".to_owned(),
    }
}

fn task() -> Task {
    let goal = r#"[{"predicate": "on", "object": "block_1", "target": "plate_1"}]"#;
    Task::new("Put the block on the plate.", serde_json::from_str(goal).expect("a goal"), "panda")
}

fn wanted(cameras: Vec<CameraSpec>, randomization: Randomization) -> Wanted {
    let points = (!cameras.is_empty()).then_some(400);
    Wanted {
        cameras,
        fps: 10,
        depth: true,
        instance_ids: true,
        points,
        randomization,
        seed: 5,
        formats: vec![Format::ParquetAndPng { depth: DepthStorage::ParquetMeters }],
        place: None,
    }
}

/// Without grasps: nothing is simulated for it.
fn setup_with(wanted: Wanted) -> Result<Setup, SetupError> {
    setup_of(parts(), wanted)
}

fn setup_of(parts: SceneParts, wanted: Wanted) -> Result<Setup, SetupError> {
    let world_from_base = Pose::upright(DVec3::new(-0.5, 0.0, 0.02), 0.0);
    let work = Work { task: task(), grasps: manipulation::execution::GraspBook::new(), world_from_base };
    let robot = Robot::built_in("panda", None).expect("built in");
    Setup::new(parts, robot, vec![work], wanted, &test_settings::section::<ExecutionSettings>("execution"))
}

fn camera(eye_m: DVec3, target_m: DVec3) -> CameraSpec {
    let name = "own".to_owned();
    CameraSpec { name, mount: Mount::World, eye_m, target_m, fov_x_rad: 0.9, width_px: 64, height_px: 48 }
}

#[test]
fn what_is_carried_moves_along_and_nothing_overlaps_or_leaves_the_table() {
    let ranges = Randomization { position_m: 0.15, yaw_rad: 1.0, ..Randomization::NONE };
    let setup = setup_with(wanted(Vec::new(), ranges)).expect("a setup");
    let start = setup.scene.poses();
    let plate_from_lid = start[1].inverse() * start[2];
    for seed in 0..20 {
        let mut rng = child_rng(seed, "position");
        let poses = arrangement::poses(&setup, &[true; 4], &ranges, &mut rng).expect("room for all");
        let moved_m = (poses[1].translation_m - start[1].translation_m).abs();
        assert!(moved_m.x <= 0.15 && moved_m.y <= 0.15 && moved_m.z == 0.0, "{moved_m}");
        let carried = poses[1].inverse() * poses[2];
        assert!((carried.translation_m - plate_from_lid.translation_m).length() < 1e-12);
        for (index, pose) in poses.iter().enumerate() {
            let inside = |point: DVec3| setup.scene.outline.contains(point.truncate());
            assert!(setup.shapes[index].points(pose).all(inside), "object {index} of seed {seed}");
        }
        let apart =
            |a: usize, b: usize| (poses[a].translation_m - poses[b].translation_m).truncate().length();
        assert!(apart(0, 1) > 0.11 && apart(0, 3) > 0.05 && apart(1, 3) > 0.12, "seed {seed}");
    }
}

#[test]
fn what_the_task_names_is_never_absent_nor_what_it_carries() {
    let setup = setup_with(wanted(Vec::new(), Randomization::NONE)).expect("a setup");
    let present = arrangement::present(&setup, &setup.works[0], &[true; 4]);
    assert_eq!(present, [true, true, true, false]);
}

#[test]
fn cameras_inside_of_objects_are_refused() {
    for (eye_m, says) in [
        (DVec3::new(0.3, 0.3, -0.01), "inside the table"),
        (DVec3::new(0.35, 0.2, 0.04), "inside tin_1"),
        (DVec3::new(0.0, 0.0, 0.05), "must be apart"),
    ] {
        let own = camera(eye_m, DVec3::new(0.0, 0.0, 0.05));
        let refused = setup_with(wanted(vec![own], Randomization::NONE)).err().map(|error| error.to_string());
        assert!(refused.as_ref().is_some_and(|refused| refused.contains(says)), "{refused:?}");
    }
}

/// One successful episode with a camera at the side and the one of the wrist.
fn episode(ranges: Randomization) -> (Setup, EpisodeUnit) {
    let parts = parts();
    let robot = Robot::built_in("panda", None).expect("built in");
    let settings: ExecutionSettings = test_settings::section("execution");
    let grasps: GraspSettings = test_settings::section("grasps");
    let mut known = KnownGrasps::new(&parts.scene, &robot, &grasps, 5);
    let work = prepare(&robot, task(), &mut known, &settings).expect("feasible");
    let (work_m, base_m) = (work.center_m(&parts.scene), work.world_from_base.translation_m);
    let cameras = ["side", "wrist"].map(|name| usual(name, work_m, base_m, 48).expect("a usual camera"));
    let setup = Setup::new(parts, robot, vec![work], wanted(cameras.to_vec(), ranges), &settings);
    let setup = setup.expect("a setup");
    match attempt(&setup, 0, false).expect("recorded") {
        Attempted::Succeeded(unit) => (setup, *unit),
        Attempted::Failed { reason, detail, .. } => panic!("{reason}: {detail}"),
    }
}

#[test]
fn an_episode_is_as_it_is_described_and_the_same_again() {
    let ranges = Randomization { position_m: 0.02, ..Randomization::USUAL };
    let (setup, unit) = episode(ranges);
    let again = attempt(&setup, 0, false).expect("recorded");
    let Attempted::Succeeded(again) = again else { panic!("it succeeded before") };
    assert_eq!(unit.to_bytes(), again.to_bytes(), "the same number gives the same bytes");

    let description = setup.description();
    let (states, actions) = (description.state().dimension(), description.action().dimension());
    let rows = |numbers: &[f32], width: usize| -> Vec<Vec<f32>> {
        numbers.chunks_exact(width).map(<[f32]>::to_vec).collect()
    };
    let (state, action) = (rows(unit.state(), states), rows(unit.action(), actions));
    assert_eq!((state.len(), action.len()), (unit.frames(), unit.frames()));
    // The action of a frame is where the arm is at the next, but for what its servos lead by.
    let arm = 7;
    let mut largest: f32 = 0.0;
    for (action, next) in action.iter().zip(&state[1..]) {
        for joint in 0..arm {
            largest = largest.max((action[joint] - next[joint]).abs());
        }
    }
    assert!(largest < 0.25, "an action and the next state differ by {largest} rad");
    // No frame rests at the beginning, and few at the end.
    let moves = |k: usize| (0..arm).any(|joint| (action[k][joint] - action[k - 1][joint]).abs() > 1e-3);
    assert!((1..4).any(moves), "the arm moves within the first frames");
    // The gripper is open, closes, and is open again, in meters and as a share.
    let (opening, share) = (states - 2, states - 1);
    let closed = state.iter().map(|row| row[share]).fold(1.0, f32::min);
    assert!(state[0][share] > 0.9 && closed < 0.6 && state[state.len() - 1][share] > 0.55);
    assert!((state[0][opening] / 0.08 - state[0][share]).abs() < 1e-3);

    let record: EpisodeRecord = serde_json::from_value(unit.header().record.clone()).expect("a record");
    assert_eq!((record.number, record.dataset_seed, record.fps), (0, 5, 10));
    assert_eq!(record.instances[1..], ["table", "block_1", "plate_1", "lid_1", "tin_1", "robot"]);
    let [first, ..] = &record.initial_poses[..] else { panic!("objects are there") };
    let drawn = &record.sample.objects[0];
    assert_eq!(first.0, drawn.name);
    assert!((first.1.translation_m - drawn.world_from_object.translation_m).length() < 0.005);
}

#[test]
fn extrinsics_and_depth_take_pixels_to_the_objects_that_are_there() {
    let (setup, unit) = episode(Randomization { position_m: 0.02, ..Randomization::USUAL });
    let record: EpisodeRecord = serde_json::from_value(unit.header().record.clone()).expect("a record");
    let camera = &unit.cameras()[0];
    let size =
        (setup.description().cameras()[0].width_px * setup.description().cameras()[0].height_px) as usize;
    let depth_m: Vec<f32> = numbers(&camera.depth_zlib[0], 4, size)
        .chunks_exact(4)
        .map(|bytes| f32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]))
        .collect();
    let ids: Vec<u16> = numbers(&camera.ids_zlib[0], 2, size)
        .chunks_exact(2)
        .map(|bytes| u16::from_le_bytes([bytes[0], bytes[1]]))
        .collect();
    let exact = |numbers: &[f32]| -> Vec<f64> { numbers.iter().copied().map(f64::from).collect() };
    let (k, pose) = (exact(&camera.intrinsics[..9]), exact(&camera.world_from_camera[..16]));
    let width = setup.description().cameras()[0].width_px as usize;
    let plate = record.instances.iter().position(|name| name == "plate_1").expect("an instance") as u16;
    let (_, world_from_plate) =
        record.initial_poses.iter().find(|(name, _)| name == "plate_1").expect("present");
    let mut seen = 0;
    for (pixel, id) in ids.iter().enumerate().filter(|(_, id)| **id == plate) {
        assert_eq!(*id, plate);
        let (u, v) = ((pixel % width) as f64 + 0.5, (pixel / width) as f64 + 0.5);
        let z = f64::from(depth_m[pixel]);
        let in_camera = [(u - k[2]) / k[0] * z, (v - k[5]) / k[4] * z, z];
        let world = |row: usize| {
            (0..3).map(|column| pose[4 * row + column] * in_camera[column]).sum::<f64>() + pose[4 * row + 3]
        };
        let point = DVec3::new(world(0), world(1), world(2));
        let in_plate = world_from_plate.inverse().transform_point(point);
        assert!(in_plate.truncate().length() < 0.092 && (-0.002..0.017).contains(&in_plate.z), "{in_plate}");
        seen += 1;
    }
    assert!(seen > 20, "the plate covers {seen} pixels");

    // The cloud is in the same world.
    let points = &unit.points();
    let coordinates = numbers(&points.positions_zlib[0], 4, 3 * 400);
    let coordinates: Vec<f64> =
        coordinates.as_chunks().0.iter().map(|four| f64::from(f32::from_le_bytes(*four))).collect();
    let ids = numbers(&points.ids_zlib[0], 2, 400);
    let ids = ids.as_chunks().0.iter().map(|two| u16::from_le_bytes(*two));
    let of_plate = coordinates.chunks_exact(3).zip(ids).filter(|(_, id)| *id == plate);
    let mut points_seen = 0;
    for (at_m, _) in of_plate {
        let in_plate = world_from_plate.inverse().transform_point(DVec3::from_slice(at_m));
        assert!(in_plate.truncate().length() < 0.092 && (-0.002..0.017).contains(&in_plate.z), "{in_plate}");
        points_seen += 1;
    }
    assert!(points_seen > 4, "the plate has {points_seen} points");
}

#[test]
fn distractors_stand_free_on_the_table_away_from_the_robot() {
    let mut with_distractors = parts();
    let solids =
        [block(DVec3::new(0.05, 0.04, 0.06)), cylinder(0.03, 0.1, 0.0, 24), block(DVec3::splat(0.03))];
    with_distractors.distractors = solids
        .iter()
        .enumerate()
        .map(|(k, solid)| Distractor {
            body: body(&format!("distractor_{k}"), solid, 0.1, DVec3::ZERO),
            mesh: mesh(solid),
        })
        .collect();
    let ranges = Randomization { added_distractors: 2.0, object_material: 1.0, ..Randomization::USUAL };
    let setup = setup_of(with_distractors, wanted(Vec::new(), ranges)).expect("a setup");
    assert_eq!(setup.instances()[5..], ["tin_1", "distractor_0", "distractor_1", "distractor_2", "robot"]);
    let mut counts = [0; 4];
    for seed in 0..60 {
        let Some(sample) = Sample::draw(&setup, &setup.works[0], &ranges, seed) else { continue };
        assert_eq!(sample.objects.len(), 7);
        assert!(sample.objects.iter().all(|object| object.finish.is_some()), "all have one color");
        let posed: Vec<(usize, Pose)> = (0..7)
            .filter(|index| sample.objects[*index].present)
            .map(|index| (index, sample.objects[index].world_from_object))
            .collect();
        let added: Vec<&(usize, Pose)> = posed.iter().filter(|(index, _)| *index >= 4).collect();
        counts[added.len()] += 1;
        for (index, pose) in added {
            let inside = |point: DVec3| setup.scene.outline.depth_inside_m(point.truncate()) > 0.01;
            assert!(setup.shapes[*index].points(pose).all(inside), "seed {seed}");
            assert!(pose.translation_m.distance(setup.works[0].world_from_base.translation_m) > 0.29);
            for (other, other_pose) in posed.iter().filter(|(other, _)| other != index) {
                let apart_m = (pose.translation_m - other_pose.translation_m).truncate().length();
                assert!(apart_m > 0.05, "{index} and {other} of seed {seed}");
            }
        }
    }
    assert!(counts[..3].iter().all(|count| *count > 8) && counts[3] == 0, "{counts:?}");
}

fn numbers(stream: &[u8], bytes: usize, count: usize) -> Vec<u8> {
    use std::io::Read as _;
    let mut read = Vec::new();
    flate2::read::ZlibDecoder::new(stream).read_to_end(&mut read).expect("a zlib stream");
    assert_eq!(read.len(), bytes * count);
    read
}
