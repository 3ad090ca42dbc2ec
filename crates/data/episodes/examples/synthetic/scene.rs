//! Synthetic episodes: a colored square moves over a color card, and numbers follow formulas.
//!
//! | what | formula |
//! | --- | --- |
//! | frames of episode e | `17 + 6 * (e % 3)` |
//! | action | first joint `((7 t + 3 e) mod 32) / 8 - 2`, gripper `t mod 2` |
//! | servo command | first joint a quarter radian ahead of the action |
//! | state | halfway from the last state to the last action: `s[t+1] = s[t] + 0.5 (a[t] - s[t])` |
//! | image | top rows red, next green, next blue, the rest gray; a yellow square at `x = 2 t + 3 e` |
//! | depth | `0.5 + 0.001 x + 0.002 y` meters, 0 in the first column |
//! | instance ids | 1 in the square, 0 elsewhere; the wrist camera adds 70,000 |
//! | point i of 6 | at `(0.1 i, 0.01 t, 0.5)` meters, colors `(i, t, e)`, instance `1000 i + t` |
//! | cameras | `front` stands still, `wrist` moves along x by 1 cm a frame |

use episodes::card::DatasetCard;
use episodes::description::{CameraDescription, DatasetDescription, InstanceIdWidth};
use episodes::episode::{EpisodeHeader, Outcome};
use episodes::format::Format;
use episodes::frame::{CameraFrame, Frame};
use episodes::point_cloud::PointCloud;
use episodes::unit_of_measure::Unit;
use episodes::vector_layout::{MotionLimits, VectorElement, VectorLayout};
use episodes::{EpisodeEncoder, EpisodeError, EpisodeUnit};
use imaging::Image;
use serde_json::json;

pub const EPISODES: u64 = 5;
pub const FPS: u32 = 15;
pub const WIDTH_PX: u32 = 96;
pub const HEIGHT_PX: u32 = 64;
pub const POINTS: u32 = 6;
/// Side of the square.
const SIDE_PX: u32 = 16;
/// Rows of each stripe of the color card.
const STRIPE_PX: u32 = 8;
const RED: [u8; 4] = [220, 30, 40, 255];
const GREEN: [u8; 4] = [30, 200, 50, 255];
const BLUE: [u8; 4] = [40, 50, 210, 255];
const GRAY: [u8; 4] = [120, 120, 120, 255];
const YELLOW: [u8; 4] = [230, 210, 40, 255];

pub fn description() -> Result<DatasetDescription, EpisodeError> {
    let joint = || VectorElement::new("arm", "joint_1", Unit::Radians).within(-2.0, 2.0);
    let mut state = vec![joint(), VectorElement::gripper_fraction(), VectorElement::gripper_opening()];
    state.extend(VectorElement::end_effector_pose());
    let limits =
        MotionLimits { position: [-2.0, 2.0], velocity: 100.0, acceleration: 1000.0, jerk: 40_000.0 };
    let action = vec![joint().with_limits(limits), VectorElement::gripper_fraction()];
    let servo_command = vec![joint().with_limits(limits)];
    let camera = |name: &str, depth: bool, instance_ids: Option<InstanceIdWidth>| CameraDescription {
        name: name.to_owned(),
        width_px: WIDTH_PX,
        height_px: HEIGHT_PX,
        depth,
        instance_ids,
    };
    DatasetDescription::new(
        "synthetic_arm",
        FPS,
        VectorLayout::new("state", state)?,
        VectorLayout::new("action", action)?,
        vec![
            camera("front", true, Some(InstanceIdWidth::U16)),
            camera("wrist", false, Some(InstanceIdWidth::U32)),
        ],
        vec!["push the square".to_owned(), "lift the square".to_owned()],
    )?
    .with_servo_commands(VectorLayout::new("servo command", servo_command)?)
    .with_points(POINTS)
}

pub fn card() -> DatasetCard {
    DatasetCard {
        title: "Synthetic episodes".to_owned(),
        license: "cc0-1.0".to_owned(),
        versions: vec![("tabletopgen-episodes".to_owned(), env!("CARGO_PKG_VERSION").to_owned())],
        randomization: "The square starts 3 pixels further right in each episode.".to_owned(),
        regeneration: "`cargo run -p tabletopgen-episodes --example synthetic -- OUT`".to_owned(),
        attempts: [("success".to_owned(), 4), ("dropped".to_owned(), 1)].into(),
    }
}

pub fn frames(number: u64) -> u64 {
    17 + 6 * (number % 3)
}

pub fn action(number: u64, t: u64) -> [f32; 2] {
    [((7 * t + 3 * number) % 32) as f32 / 8.0 - 2.0, (t % 2) as f32]
}

pub fn servo_command(number: u64, t: u64) -> [f32; 1] {
    [(action(number, t)[0] + 0.25).min(2.0)]
}

/// States of an episode; each begins with joint and gripper, which follow the action with a delay.
pub fn states(number: u64) -> Vec<[f32; 16]> {
    let (mut joint, mut gripper) = (0.1 * number as f32, 0.5);
    let of_time = |t: u64| {
        // The rotation is none: its quaternion, and the first two columns of its matrix.
        #[rustfmt::skip]
        let state = [
            joint, gripper, 0.08 * gripper, 0.3, 0.01 * t as f32, 0.2,
            1.0, 0.0, 0.0, 0.0,
            1.0, 0.0, 0.0, 0.0, 1.0, 0.0,
        ];
        let [to_joint, to_gripper] = action(number, t);
        joint += 0.5 * (to_joint - joint);
        gripper += 0.5 * (to_gripper - gripper);
        state
    };
    (0..frames(number)).map(of_time).collect()
}

pub fn image(number: u64, t: u64) -> Image {
    let mut image = Image::filled(WIDTH_PX, HEIGHT_PX, GRAY);
    for y in 0..3 * STRIPE_PX {
        for x in 0..WIDTH_PX {
            image.set_pixel(x, y, [RED, GREEN, BLUE][(y / STRIPE_PX) as usize]);
        }
    }
    for (x, y) in square(number, t) {
        image.set_pixel(x, y, YELLOW);
    }
    image
}

fn square(number: u64, t: u64) -> impl Iterator<Item = (u32, u32)> {
    let left = (2 * t + 3 * number) as u32 % (WIDTH_PX - SIDE_PX);
    (0..SIDE_PX * SIDE_PX).map(move |i| (left + i % SIDE_PX, 40 + i / SIDE_PX))
}

pub fn depth_m() -> Vec<f32> {
    let pixels = (0..HEIGHT_PX).flat_map(|y| (0..WIDTH_PX).map(move |x| (x, y)));
    pixels.map(|(x, y)| if x == 0 { 0.0 } else { 0.5 + 0.001 * x as f32 + 0.002 * y as f32 }).collect()
}

pub fn instance_ids(number: u64, t: u64, offset: u32) -> Vec<u32> {
    let mut ids = vec![offset; (WIDTH_PX * HEIGHT_PX) as usize];
    for (x, y) in square(number, t) {
        ids[(y * WIDTH_PX + x) as usize] = offset + 1;
    }
    ids
}

/// Coordinates, colors and instance ids of the points at one time.
pub fn points(number: u64, t: u64) -> (Vec<f32>, Vec<u8>, Vec<u16>) {
    let all = || 0..POINTS as u16;
    let positions_m = all().flat_map(|i| [0.1 * f32::from(i), 0.01 * t as f32, 0.5]).collect();
    let colors = all().flat_map(|i| [i as u8, t as u8, number as u8]).collect();
    (positions_m, colors, all().map(|i| 1000 * i + t as u16).collect())
}

pub const INTRINSICS: [f64; 9] = [100.0, 0.0, 48.0, 0.0, 100.0, 32.0, 0.0, 0.0, 1.0];

/// A camera 1 m above the origin that sees straight down, its x axis along the world's; moved along x.
#[rustfmt::skip]
pub fn world_from_camera(x_m: f64) -> [f64; 16] {
    [
        1.0, 0.0, 0.0, x_m,
        0.0, -1.0, 0.0, 0.0,
        0.0, 0.0, -1.0, 1.0,
        0.0, 0.0, 0.0, 1.0,
    ]
}

/// The unit of an episode.
pub fn unit(number: u64, formats: &[Format]) -> Result<EpisodeUnit, EpisodeError> {
    let header = EpisodeHeader {
        number,
        seed: 1000 + number,
        task: (number % 2) as usize,
        record: json!({"example": "synthetic", "number": number}),
    };
    let description = description()?;
    let mut encoder = EpisodeEncoder::new(&description, formats, header)?;
    let depth_m = depth_m();
    for (t, state) in (0..).zip(&states(number)) {
        let (image, action) = (image(number, t), action(number, t));
        let (front_ids, wrist_ids) = (instance_ids(number, t, 0), instance_ids(number, t, 70_000));
        let front = CameraFrame {
            image: &image,
            depth_m: Some(&depth_m),
            instance_ids: Some(&front_ids),
            intrinsics: INTRINSICS,
            world_from_camera: world_from_camera(0.0),
        };
        let wrist = CameraFrame {
            depth_m: None,
            instance_ids: Some(&wrist_ids),
            world_from_camera: world_from_camera(0.01 * t as f64),
            ..front
        };
        let (positions_m, colors, ids) = points(number, t);
        let points = PointCloud { positions_m: &positions_m, colors: &colors, instance_ids: &ids };
        let servo_command = servo_command(number, t);
        let cameras = &[front, wrist];
        let points = Some(points);
        encoder.add(&Frame { state, action: &action, servo_command: &servo_command, cameras, points })?;
    }
    let failed = number == 3;
    let outcome = if failed { Outcome::Failure { reason: "dropped".to_owned() } } else { Outcome::Success };
    encoder.finish(outcome)
}
