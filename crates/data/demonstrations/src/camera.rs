//! Cameras of a dataset: where they are, and what they see.

use std::f64::consts::TAU;

use geometry::{Camera, DQuat, DVec3, Pose};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::sample::CameraSample;

/// Frame that a camera is fixed to.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
#[schemars(
    rename = "CameraMount",
    description = "Frame that a camera is fixed to. The table's top is at z = 0 in the world; +z of the tool points out of the hand."
)]
pub enum Mount {
    /// The world: the table's top is at z = 0.
    World,
    /// The tool: its origin is between the pads, +z points out of the hand.
    Tool,
}

/// Meters.
#[derive(JsonSchema)]
#[expect(dead_code, reason = "the schema of fields")]
struct CameraPoint(#[schemars(inner(range(min = -99.0, max = 99.0)))] [f64; 3]);

/// A camera: its place and direction in the frame of what it is fixed to, and its size.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "EpisodeCamera")]
pub struct CameraSpec {
    #[schemars(regex(pattern = r"^[A-Za-z0-9_-]{1,24}$"))]
    pub name: String,
    pub mount: Mount,
    #[schemars(with = "CameraPoint")]
    pub eye_m: DVec3,
    /// The point in the center of its image; up in the image is the mount's +z, or its +y if it is directed along z.
    #[schemars(with = "CameraPoint")]
    pub target_m: DVec3,
    /// Horizontal field of view, radians.
    #[schemars(range(min = 0.1, max = 2.8))]
    pub fov_x_rad: f64,
    #[schemars(range(min = 16, max = 4096), extend("multipleOf" = 2))]
    pub width_px: u32,
    #[schemars(range(min = 16, max = 4096), extend("multipleOf" = 2))]
    pub height_px: u32,
}

/// Names of the usual cameras.
pub const USUAL: [&str; 3] = ["side", "front", "wrist"];

/// The usual camera of a name: `front` sees the work from opposite to the robot, `side` from the robot's left,
/// `wrist` is fixed to the hand. `work_m` is the center of what the task is about.
pub fn usual(name: &str, work_m: DVec3, base_m: DVec3, side_px: u32) -> Option<CameraSpec> {
    const DISTANCE_M: f64 = 0.95;
    let world = |azimuth_rad: f64, elevation_rad: f64| {
        let away = (work_m - base_m).with_z(0.0).normalize_or(DVec3::X);
        let outward = DQuat::from_rotation_z(azimuth_rad) * away;
        let direction = elevation_rad.cos() * outward + elevation_rad.sin() * DVec3::Z;
        (Mount::World, work_m + DISTANCE_M * direction, work_m, 0.9)
    };
    let (mount, eye_m, target_m, fov_x_rad) = match name {
        // Left of the robot, which faces the work; a little to the front, so that the hand hides less.
        "side" => world(0.18 * TAU, 0.55),
        "front" => world(0.0, 0.65),
        "wrist" => (Mount::Tool, DVec3::new(0.08, 0.0, -0.05), DVec3::new(0.0, 0.0, 0.04), 1.2),
        _ => return None,
    };
    Some(CameraSpec {
        name: name.to_owned(),
        mount,
        eye_m,
        target_m,
        fov_x_rad,
        width_px: side_px,
        height_px: side_px,
    })
}

impl CameraSpec {
    /// Describes the fault of the values, if there is one.
    pub fn fault(&self) -> Option<String> {
        if !(0.1..=2.8).contains(&self.fov_x_rad) {
            return Some(format!("fov_x_rad is {}, choose 0.1 to 2.8", self.fov_x_rad));
        }
        let distance_m = (self.target_m - self.eye_m).length();
        // Also without a number.
        let is_directed = distance_m > 1e-3 && distance_m < 100.0 && self.eye_m.length() < 100.0;
        (!is_directed).then(|| "eye_m and target_m must be apart, and within 100 m".to_owned())
    }

    /// The camera in an episode, with the tool at a time.
    pub(crate) fn posed(&self, sample: &CameraSample, world_from_tool: &Pose) -> Camera {
        let nominal =
            Camera::look_at(self.width_px, self.height_px, self.fov_x_rad, self.eye_m, self.target_m);
        let turned = Pose {
            translation_m: sample.offset_m,
            rotation: DQuat::from_scaled_axis(sample.turn_rad).normalize(),
        };
        let mount_from_camera = nominal.world_from_camera * turned;
        let world_from_camera = match self.mount {
            Mount::World => mount_from_camera,
            Mount::Tool => *world_from_tool * mount_from_camera,
        };
        let (fx, fy) = (nominal.fx * sample.focal_factor, nominal.fy * sample.focal_factor);
        Camera { fx, fy, world_from_camera, ..nominal }
    }
}
