//! Refusals of invalid descriptions state the place, the fault and the correction.

use episodes::description::{CameraDescription, DatasetDescription};
use episodes::episode::{EpisodeHeader, Outcome};
use episodes::frame::{CameraFrame, Frame};
use episodes::point_cloud::PointCloud;
use episodes::unit_of_measure::Unit;
use episodes::vector_layout::{MotionLimits, VectorElement, VectorLayout};
use episodes::{EpisodeEncoder, EpisodeError};
use imaging::Image;

use crate::reading::V30;
use crate::scene;

fn layout(elements: Vec<VectorElement>) -> Result<VectorLayout, EpisodeError> {
    VectorLayout::new("state", elements)
}

fn joint(name: &str) -> VectorElement {
    VectorElement::new("arm", name, Unit::Radians)
}

fn described(
    robot: &str,
    fps: u32,
    cameras: Vec<CameraDescription>,
    tasks: &[&str],
) -> Result<DatasetDescription, EpisodeError> {
    let joints = layout(vec![joint("j")])?;
    let tasks = tasks.iter().map(|task| (*task).to_owned()).collect();
    DatasetDescription::new(robot, fps, joints.clone(), joints, cameras, tasks)
}

fn camera(name: &str, width_px: u32, height_px: u32) -> CameraDescription {
    CameraDescription { name: name.to_owned(), width_px, height_px, depth: false, instance_ids: None }
}

fn refuses<T>(result: Result<T, EpisodeError>, part: &str) {
    let text = result.err().unwrap_or_else(|| panic!("accepted: {part}")).to_string();
    assert!(text.contains(part), "`{text}` lacks `{part}`");
    assert!(text.matches(';').count() >= 1, "`{text}` has no correction");
}

#[test]
fn layouts_refuse_what_formats_cannot_carry() {
    refuses(layout(vec![]), "no numbers");
    refuses(layout(vec![joint("a/b")]), "`a/b` is no name");
    refuses(layout(vec![joint("")]), "`` is no name");
    refuses(layout(vec![joint("a"), joint("a")]), "two numbers named `a_rad`");
    refuses(layout(vec![joint("a").within(1.0, 1.0)]), "range 1 to 1");
    refuses(layout(vec![joint("a").within(0.0, f32::INFINITY)]), "range 0 to inf");
    let split = vec![joint("a"), VectorElement::gripper_opening(), joint("b")];
    refuses(layout(split), "group `arm`");
    assert!(layout(vec![joint("a"), joint("b"), VectorElement::gripper_opening()]).is_ok());
}

#[test]
fn descriptions_refuse_what_formats_cannot_carry() {
    assert!(described("arm", 30, vec![camera("front", 64, 48)], &["push"]).is_ok());
    refuses(described("a robot", 30, vec![], &["push"]), "`a robot` is no name");
    refuses(described("arm", 0, vec![], &["push"]), "0 frames per second");
    refuses(described("arm", 30, vec![camera("a/b", 64, 48)], &["push"]), "`a/b` is no name");
    refuses(described("arm", 30, vec![camera("a", 63, 48)], &["push"]), "63 x 48");
    refuses(described("arm", 30, vec![camera("a", 64, 8)], &["push"]), "64 x 8");
    let twice = vec![camera("a", 64, 48), camera("a", 64, 48)];
    refuses(described("arm", 30, twice, &["push"]), "two cameras");
    refuses(described("arm", 30, vec![], &[]), "no tasks");
    refuses(described("arm", 30, vec![], &["push", "push"]), "two tasks");
    refuses(described("arm", 30, vec![], &["push\nlift"]), "task 0");
}

/// The answer to a frame of the synthetic dataset after a change.
fn changed(change: impl Fn(&mut [f32], &mut [f32], &mut CameraFrame)) -> Result<(), EpisodeError> {
    added(change, |_| {})
}

/// Result of a frame whose points were changed.
fn with_points(change: impl Fn(&mut Option<PointCloud>)) -> Result<(), EpisodeError> {
    added(|_, _, _| {}, change)
}

fn added(
    change: impl Fn(&mut [f32], &mut [f32], &mut CameraFrame),
    change_points: impl Fn(&mut Option<PointCloud>),
) -> Result<(), EpisodeError> {
    let description = scene::description().expect("a description");
    let header = EpisodeHeader { number: 7, seed: 0, task: 0, record: serde_json::Value::Null };
    let mut encoder = EpisodeEncoder::new(&description, &[V30], header).expect("an encoder");
    let (mut state, mut action) = (scene::states(0)[0], scene::action(0, 0));
    let (image, depth_m) = (scene::image(0, 0), scene::depth_m());
    let ids = scene::instance_ids(0, 0, 0);
    let mut front = CameraFrame {
        image: &image,
        depth_m: Some(&depth_m),
        instance_ids: Some(&ids),
        intrinsics: scene::INTRINSICS,
        world_from_camera: scene::world_from_camera(0.0),
    };
    let wrist = CameraFrame { depth_m: None, ..front };
    change(&mut state, &mut action, &mut front);
    let (positions_m, colors, ids) = scene::points(0, 0);
    let mut points = Some(PointCloud { positions_m: &positions_m, colors: &colors, instance_ids: &ids });
    change_points(&mut points);
    let servo_command = &scene::servo_command(0, 0);
    encoder.add(&Frame { state: &state, action: &action, servo_command, cameras: &[front, wrist], points })
}

#[test]
fn points_are_as_many_as_described() {
    with_points(|_| {}).expect("a valid frame");
    refuses(with_points(|points| *points = None), "the points are missing");
    let few = PointCloud { positions_m: &[0.0; 15], colors: &[0; 15], instance_ids: &[0; 5] };
    refuses(with_points(|points| *points = Some(few)), "15 coordinates, not 18");
    let wild = PointCloud { positions_m: &[f32::INFINITY; 18], colors: &[0; 18], instance_ids: &[0; 6] };
    refuses(with_points(|points| *points = Some(wild)), "is inf");
    let without = described("arm", 30, vec![camera("a", 64, 48)], &["push"]).expect("a description");
    refuses(without.clone().with_points(0), "0 points");
    refuses(without.with_points(70_000), "70000 points");
    refuses(described("arm", 30, vec![], &["push"]).and_then(|it| it.with_points(9)), "no camera");
}

#[test]
fn frames_refuse_numbers_outside_their_meaning() {
    changed(|_, _, _| {}).expect("a valid frame");
    refuses(
        changed(|state, _, _| state[0] = f32::NAN),
        "frame 0 of episode 7: `joint_1_rad` of the state is NaN",
    );
    refuses(changed(|_, action, _| action[0] = 2.5), "outside -2 to 2");
    refuses(changed(|_, action, _| action[1] = -0.1), "`gripper_0_closed_1_open` of the action is -0.1");
    refuses(changed(|_, _, front| front.depth_m = None), "camera `front`: depth is missing");
    refuses(changed(|_, _, front| front.instance_ids = None), "instance ids are missing");
    refuses(changed(|_, _, front| front.intrinsics[0] = 0.0), "the intrinsics");
    refuses(changed(|_, _, front| front.intrinsics.swap(2, 6)), "the intrinsics");
    // Mirrored axes, and a matrix in the order of columns.
    refuses(changed(|_, _, front| front.world_from_camera[0] = -1.0), "world_from_camera");
    refuses(changed(|_, _, front| front.world_from_camera.swap(11, 14)), "world_from_camera");
    // Millimeters where meters belong.
    let millimeters: Vec<f32> = scene::depth_m().iter().map(|depth| 1000.0 * depth).collect();
    let millimeters: &'static [f32] = millimeters.leak();
    refuses(changed(|_, _, front| front.depth_m = Some(millimeters)), "m;");
    let short: &'static [f32] = &[1.0];
    refuses(changed(|_, _, front| front.depth_m = Some(short)), "1 numbers");
    let large: &'static [u32] = vec![70_000; (scene::WIDTH_PX * scene::HEIGHT_PX) as usize].leak();
    refuses(changed(|_, _, front| front.instance_ids = Some(large)), "70000");
    let other: &'static Image = Box::leak(Box::new(Image::filled(64, 96, [0; 4])));
    refuses(changed(|_, _, front| front.image = other), "64 x 96");
}

#[test]
fn episodes_refuse_what_teaches_nothing() {
    let description = scene::description().expect("a description");
    let header = |task| EpisodeHeader { number: 7, seed: 0, task, record: serde_json::Value::Null };
    refuses(EpisodeEncoder::new(&description, &[V30], header(2)), "task 2");
    let empty = || EpisodeEncoder::new(&description, &[V30], header(0)).expect("an encoder");
    refuses(empty().finish(Outcome::Success), "no frames");
    let mut wrong = empty();
    let frame = Frame { state: &[0.0], action: &[0.0; 2], servo_command: &[], cameras: &[], points: None };
    refuses(wrong.add(&frame), "1 numbers");
}

#[test]
fn servo_commands_are_as_they_are_described() {
    let add = |description: DatasetDescription, servo_command: &[f32]| {
        let header = EpisodeHeader { number: 7, seed: 0, task: 0, record: serde_json::Value::Null };
        let mut encoder = EpisodeEncoder::new(&description, &[V30], header).expect("an encoder");
        encoder.add(&Frame { state: &[0.0], action: &[0.1], servo_command, cameras: &[], points: None })
    };
    let without = || described("arm", 30, vec![], &["push"]).expect("a description");
    let with = || without().with_servo_commands(layout(vec![joint("j")]).expect("a layout"));
    add(without(), &[]).expect("no servo commands");
    add(with(), &[0.3]).expect("servo commands");
    refuses(add(without(), &[0.3]), "a servo command is given");
    refuses(add(with(), &[]), "the servo command has 0 numbers");
    refuses(add(with(), &[f32::NAN]), "`j_rad` of the servo command is NaN");
    let limits = MotionLimits { position: [0.0, 1.0], velocity: 1.0, acceleration: 0.0, jerk: 1.0 };
    refuses(layout(vec![joint("j").with_limits(limits)]), "acceleration: 0.0");
}

#[test]
fn robomimic_needs_ranges_of_actions() {
    let description = described("arm", 30, vec![], &["push"]).expect("a description");
    let folder = tempfile::TempDir::new().expect("a folder");
    let formats = [episodes::format::Format::Robomimic];
    let path = folder.path().join("set");
    let result = episodes::DatasetAssembler::create(&path, description, &formats, scene::card());
    refuses(result.map(|_| ()), "`j_rad` has no range");
    assert!(!path.with_extension("part").exists(), "nothing is left behind");
}
