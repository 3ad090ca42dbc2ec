//! Description of a dataset: the robot, the rate, the numbers of states and actions, cameras and tasks.

use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

use crate::EpisodeError;
use crate::names::check_name;
use crate::point_cloud::MAX_POINTS;
use crate::vector_layout::VectorLayout;

/// Depth is written as 16-bit millimeters, so nothing may be further away.
pub const MAX_DEPTH_M: f32 = 65.535;

/// Width of the ids of instances.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum InstanceIdWidth {
    U16,
    U32,
}

/// One camera of a dataset.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct CameraDescription {
    pub name: String,
    pub width_px: u32,
    pub height_px: u32,
    /// Whether each frame has depth along the optical axis, in meters.
    pub depth: bool,
    /// Width of the ids in the image of instances at each pixel, if frames have one; id 0 is none.
    pub instance_ids: Option<InstanceIdWidth>,
}

/// The description of a dataset. It is valid: [`DatasetDescription::new`] is the only way to make one.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct DatasetDescription {
    robot_type: String,
    fps: u32,
    state: VectorLayout,
    action: VectorLayout,
    #[serde(skip_serializing_if = "Option::is_none")]
    servo_command: Option<VectorLayout>,
    cameras: Vec<CameraDescription>,
    tasks: Vec<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    points: Option<u32>,
}

impl DatasetDescription {
    /// Describes a dataset.
    ///
    /// `tasks` are instructions in words, and an episode names one by its place in the list.
    ///
    /// # Errors
    ///
    /// [`EpisodeError::Description`] for a rate outside 1 to 1000, names that a format could not carry, equal names,
    /// sizes that H.264 does not have (both sides even, from 16 to 4096), and for no task or an empty one.
    pub fn new(
        robot_type: &str,
        fps: u32,
        state: VectorLayout,
        action: VectorLayout,
        cameras: Vec<CameraDescription>,
        tasks: Vec<String>,
    ) -> Result<Self, EpisodeError> {
        check_name("a robot type", robot_type)?;
        if !(1..=1000).contains(&fps) {
            let what = format!("the rate is {fps} frames per second");
            return Err(EpisodeError::description(what, "choose 1 to 1000"));
        }
        for (i, camera) in cameras.iter().enumerate() {
            check_name("a camera", &camera.name)?;
            if cameras[..i].iter().any(|earlier| earlier.name == camera.name) {
                let what = format!("two cameras are named `{}`", camera.name);
                return Err(EpisodeError::description(what, "give each another name"));
            }
            let fits = |side: u32| (16..=4096).contains(&side) && side.is_multiple_of(2);
            if !(fits(camera.width_px) && fits(camera.height_px)) {
                let (width_px, height_px) = (camera.width_px, camera.height_px);
                let what = format!("camera `{}` has {width_px} x {height_px} pixels", camera.name);
                return Err(EpisodeError::description(what, "choose even sides from 16 to 4096 pixels"));
            }
        }
        if tasks.is_empty() {
            return Err(EpisodeError::description("there are no tasks", "state at least one instruction"));
        }
        for (i, task) in tasks.iter().enumerate() {
            if task.trim().is_empty() || task.chars().any(char::is_control) {
                let what = format!("task {i} has the instruction `{}`", task.escape_debug());
                return Err(EpisodeError::description(what, "state it in words on one line"));
            }
            if tasks[..i].contains(task) {
                let what = format!("two tasks have the instruction `{task}`");
                return Err(EpisodeError::description(what, "name each instruction once"));
            }
        }
        let robot_type = robot_type.to_owned();
        Ok(Self { robot_type, fps, state, action, servo_command: None, cameras, tasks, points: None })
    }

    /// Returns the description with servo targets beside the action. They lead a motion, because damping and weights
    /// hold it back, perhaps beyond the range of the joints.
    pub fn with_servo_commands(self, layout: VectorLayout) -> Self {
        Self { servo_command: Some(layout), ..self }
    }

    /// Returns the description with a cloud of `points` points in every frame, which all cameras see together.
    ///
    /// # Errors
    ///
    /// [`EpisodeError::Description`] for no points, more than [`MAX_POINTS`], and a dataset without cameras.
    pub fn with_points(self, points: u32) -> Result<Self, EpisodeError> {
        if !(1..=MAX_POINTS).contains(&points) {
            let what = format!("the point cloud has {points} points");
            return Err(EpisodeError::description(what, "choose 1 to 65536"));
        }
        if self.cameras.is_empty() {
            return Err(EpisodeError::description(
                "there is a point cloud and no camera",
                "describe a camera, or no point cloud",
            ));
        }
        Ok(Self { points: Some(points), ..self })
    }

    pub fn robot_type(&self) -> &str {
        &self.robot_type
    }

    /// Frames per second.
    pub fn fps(&self) -> u32 {
        self.fps
    }

    pub fn state(&self) -> &VectorLayout {
        &self.state
    }

    pub fn action(&self) -> &VectorLayout {
        &self.action
    }

    /// Layout of the servo targets; `None` without such numbers.
    pub fn servo_command(&self) -> Option<&VectorLayout> {
        self.servo_command.as_ref()
    }

    pub fn cameras(&self) -> &[CameraDescription] {
        &self.cameras
    }

    pub fn tasks(&self) -> &[String] {
        &self.tasks
    }

    /// Points in the cloud of a frame; `None` without clouds.
    pub fn points(&self) -> Option<u32> {
        self.points
    }

    /// SHA-256 of the description, in hexadecimal; units of episodes carry it.
    pub fn digest(&self) -> String {
        let text = serde_json::to_vec(self).unwrap_or_default();
        Sha256::digest(text).iter().map(|byte| format!("{byte:02x}")).collect()
    }
}
