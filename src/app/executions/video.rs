//! A video of an execution: the scene and the robot from one fixed camera.

use std::f64::consts::TAU;

use super::Executed;
use super::meshes::scene_meshes;
use crate::problem::{Problem, ProblemType};
use geometry::{Camera, Pose, TexturedMesh};
use manipulation::execution::Frame;
use manipulation::frames::{to_isometry, to_pose};
use manipulation::link_meshes::{floor_m, link_meshes, stand_mesh};
use rayon::prelude::*;
use render::{Background, Lighting, RenderObject, RenderSettings, SceneCache, View};
use robot::kinematics::link_poses;
use video::{VideoEncoder, VideoError};

/// Both are even, as the format asks for.
const WIDTH_PX: u32 = 640;
const HEIGHT_PX: u32 = 480;
/// Images in a second, at most; the record may have more frames.
const IMAGES_PER_S: f64 = 25.0;
/// Images that are in memory at the same time.
const BATCH: usize = 16;
const FOV_X_RAD: f64 = 0.75;
const ELEVATION_RAD: f64 = 0.5;
/// The camera stands so far from the table, as a multiple of what has to be seen.
const DISTANCE: f64 = 1.9;

/// Refuses a video in a program that was built without them.
///
/// # Errors
///
/// [`VideoError::NotBuilt`], with the feature to build with.
pub fn check() -> Result<(), VideoError> {
    if video::CAN_ENCODE { Ok(()) } else { Err(VideoError::NotBuilt) }
}

/// The MP4 file of an execution. Renders on the CPU: some 50 ms an image.
///
/// # Errors
///
/// A [`Problem`] for a bundle without the meshes of its objects.
pub fn video(archive: &[u8], executed: &Executed) -> Result<Vec<u8>, Problem> {
    let recording = &executed.execution.recording;
    let names: Vec<&str> =
        std::iter::once("table").chain(recording.objects.iter().map(String::as_str)).collect();
    let scene = scene_meshes(archive, &names)?;
    let stage = Stage {
        links: link_meshes(&executed.robot),
        stand: stand_mesh(&scene[0], &executed.execution.world_from_base),
        scene,
        executed,
    };
    let camera = stage.camera();
    let every = (recording.rate_hz / IMAGES_PER_S).round().max(1.0) as usize;
    let shown: Vec<&Frame> = recording.frames.iter().step_by(every).collect();
    let made = |error: VideoError| Problem::new(ProblemType::Internal, "video_failed", error.to_string());
    let mut encoder =
        VideoEncoder::new(WIDTH_PX, HEIGHT_PX, recording.rate_hz / every as f64).map_err(made)?;
    for batch in shown.chunks(BATCH) {
        let images: Vec<_> = batch.par_iter().map(|frame| stage.image(frame, &camera)).collect();
        for image in &images {
            encoder.add(image).map_err(made)?;
        }
    }
    encoder.finish().map_err(made)
}

/// Content of the images.
struct Stage<'a> {
    links: Vec<TexturedMesh>,
    /// From the floor to the base, beside the table; empty on it.
    stand: TexturedMesh,
    /// The table first, then the objects in the order of the record.
    scene: Vec<TexturedMesh>,
    executed: &'a Executed,
}

impl Stage<'_> {
    /// From the side of the table that is opposite to the robot, a little to its left.
    fn camera(&self) -> Camera {
        let base_m = self.executed.execution.world_from_base.translation_m;
        let table_m = self.scene[0].size_m();
        let to_camera = -base_m.truncate();
        // Azimuth 0 is at the front edge, which is toward -y.
        let opposite_rad = to_camera.x.atan2(-to_camera.y);
        let target_m = (0.45 * base_m).with_z(0.2);
        let seen_m = table_m.truncate().length().max(1.2);
        Camera::orbit(
            WIDTH_PX,
            HEIGHT_PX,
            FOV_X_RAD,
            target_m,
            opposite_rad + 0.1 * TAU,
            ELEVATION_RAD,
            DISTANCE * seen_m,
        )
    }

    fn image(&self, frame: &Frame, camera: &Camera) -> imaging::Image {
        let Executed { robot, execution, .. } = self.executed;
        let base = to_isometry(&execution.world_from_base);
        let links = link_poses(robot, &frame.joint_positions, frame.opening_m);
        let links = links.iter().map(|pose| to_pose(&(base * pose)));
        let scene = std::iter::once(Pose::IDENTITY).chain(frame.object_poses.iter().copied());
        let stand = std::iter::once((&self.stand, Pose::IDENTITY));
        let shown = self.scene.iter().zip(scene).chain(stand).chain(self.links.iter().zip(links));
        let objects: Vec<RenderObject> = shown
            .filter(|(mesh, _)| !mesh.positions.is_empty())
            .zip(1..)
            .map(|((mesh, world_from_object), id)| RenderObject { mesh, world_from_object, id })
            .collect();
        let floor_m = floor_m(&self.scene[0]);
        let lighting = Lighting::studio(camera.azimuth_rad() - 0.7, 0.95, 0.6);
        let background = Background::light_with_floor(floor_m);
        SceneCache::new(objects, &RenderSettings::MOTION).color(
            lighting,
            background,
            &View::Perspective(*camera),
        )
    }
}
