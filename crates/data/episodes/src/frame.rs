//! One time of an episode, as a recorder hands it over, and what makes it invalid.
//!
//! Conventions: `state` is measured before `action` is sent; `action` is the commanded target. Images have row 0 at
//! the top. Cameras have OpenCV axes (x right, y down, z forward), and `world_from_camera` takes points of the camera
//! to the world, in meters.

use imaging::Image;

use crate::description::{CameraDescription, DatasetDescription, InstanceIdWidth, MAX_DEPTH_M};
use crate::point_cloud::{self, PointCloud};

/// Maximum deviation of a camera's axes from an orthonormal right-handed basis.
const RIGIDITY_TOLERANCE: f64 = 1e-4;

/// Measurements and commands of a robot at one time.
#[derive(Clone, Copy, Debug)]
pub struct Frame<'a> {
    /// The measured state, before the action.
    pub state: &'a [f32],
    /// The commanded target, which is sent after the state was measured.
    pub action: &'a [f32],
    /// Servo targets for the action, where the dataset has them beside it; else empty.
    pub servo_command: &'a [f32],
    /// One for each camera of the dataset, in its order.
    pub cameras: &'a [CameraFrame<'a>],
    /// Points that all cameras see, where the dataset has them.
    pub points: Option<PointCloud<'a>>,
}

/// Image and measurements of one camera at one time.
#[derive(Clone, Copy, Debug)]
pub struct CameraFrame<'a> {
    /// Row 0 is the top; transparency is ignored.
    pub image: &'a Image,
    /// Depth along the optical axis in meters, row by row from the top; 0 where nothing is in sight.
    pub depth_m: Option<&'a [f32]>,
    /// The instance at each pixel, row by row from the top; 0 is none.
    pub instance_ids: Option<&'a [u32]>,
    /// K, row by row, in pixels: fx, 0, cx; 0, fy, cy; 0, 0, 1.
    pub intrinsics: [f64; 9],
    /// The pose of the camera with OpenCV axes, row by row, in meters.
    pub world_from_camera: [f64; 16],
}

type Fault = (String, &'static str);

/// First fault of a frame, if it does not fit the description.
pub(crate) fn fault_of(frame: &Frame, description: &DatasetDescription) -> Option<Fault> {
    let vectors = description
        .state()
        .fault_of("state", frame.state)
        .or_else(|| description.action().fault_of("action", frame.action))
        .or_else(|| match description.servo_command() {
            Some(layout) => layout.fault_of("servo command", frame.servo_command),
            None if frame.servo_command.is_empty() => None,
            None => Some(("a servo command is given".into(), "describe the dataset with servo commands")),
        });
    if vectors.is_some() {
        return vectors;
    }
    let (given, expected) = (frame.cameras.len(), description.cameras().len());
    if given != expected {
        let what = format!("it has {given} camera images, the dataset {expected} cameras");
        return Some((what, "give one image for each camera, in the order of the description"));
    }
    let pairs = frame.cameras.iter().zip(description.cameras());
    let cameras = pairs.into_iter().find_map(|(frame, camera)| {
        camera_fault(frame, camera)
            .map(|(what, correction)| (format!("camera `{}`: {what}", camera.name), correction))
    });
    cameras.or_else(|| point_cloud::fault_of(frame.points.as_ref(), description.points()))
}

fn camera_fault(frame: &CameraFrame, camera: &CameraDescription) -> Option<Fault> {
    let (width_px, height_px) = (frame.image.width_px(), frame.image.height_px());
    if (width_px, height_px) != (camera.width_px, camera.height_px) {
        let what = format!(
            "the image has {width_px} x {height_px} pixels, the dataset {} x {}",
            camera.width_px, camera.height_px
        );
        return Some((what, "render in the described size"));
    }
    let pixels = (width_px * height_px) as usize;
    depth_fault(frame.depth_m, camera.depth, pixels)
        .or_else(|| ids_fault(frame.instance_ids, camera.instance_ids, pixels))
        .or_else(|| intrinsics_fault(&frame.intrinsics))
        .or_else(|| pose_fault(&frame.world_from_camera))
}

fn depth_fault(depth_m: Option<&[f32]>, is_recorded: bool, pixels: usize) -> Option<Fault> {
    let depth_m = match (depth_m, is_recorded) {
        (None, false) => return None,
        (Some(depth_m), true) => depth_m,
        (None, true) => {
            return Some(("depth is missing".into(), "give it, or describe the camera without depth"));
        }
        (Some(_), false) => return Some(("depth is given".into(), "describe the camera with depth")),
    };
    if depth_m.len() != pixels {
        let what = format!("depth has {} numbers for {pixels} pixels", depth_m.len());
        return Some((what, "give one for each pixel"));
    }
    let invalid = depth_m.iter().find(|depth| !(0.0..=MAX_DEPTH_M).contains(*depth));
    invalid.map(|depth| {
        (format!("a depth is {depth} m"), "use meters from 0 to 65.535, 0 where nothing is in sight")
    })
}

fn ids_fault(ids: Option<&[u32]>, width: Option<InstanceIdWidth>, pixels: usize) -> Option<Fault> {
    let (ids, width) = match (ids, width) {
        (None, None) => return None,
        (Some(ids), Some(width)) => (ids, width),
        (None, Some(_)) => return Some(("instance ids are missing".into(), "give them, or describe none")),
        (Some(_), None) => return Some(("instance ids are given".into(), "describe the camera with them")),
    };
    if ids.len() != pixels {
        return Some((format!("{} instance ids for {pixels} pixels", ids.len()), "give one for each pixel"));
    }
    let too_large = ids.iter().find(|id| width == InstanceIdWidth::U16 && **id > u32::from(u16::MAX));
    too_large.map(|id| (format!("an instance id is {id}"), "describe ids of 32 bits, or number from 1"))
}

fn intrinsics_fault(k: &[f64; 9]) -> Option<Fault> {
    let is_valid = k.iter().all(|number| number.is_finite())
        && k[0] > 0.0
        && k[4] > 0.0
        && [k[3], k[6], k[7]] == [0.0; 3]
        && k[8] == 1.0;
    let what = || format!("the intrinsics are {k:?}");
    (!is_valid).then(|| (what(), "give K row by row: fx, skew, cx, 0, fy, cy, 0, 0, 1, in pixels"))
}

fn pose_fault(pose: &[f64; 16]) -> Option<Fault> {
    let axis = |column: usize| [pose[column], pose[4 + column], pose[8 + column]];
    let dot = |a: [f64; 3], b: [f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    let [x, y, z] = [axis(0), axis(1), axis(2)];
    let cross = [x[1] * y[2] - x[2] * y[1], x[2] * y[0] - x[0] * y[2], x[0] * y[1] - x[1] * y[0]];
    let errors = [
        dot(x, x) - 1.0,
        dot(y, y) - 1.0,
        dot(z, z) - 1.0,
        dot(x, y),
        dot(x, z),
        dot(y, z),
        dot(cross, z) - 1.0,
    ];
    let is_rigid = pose.iter().all(|number| number.is_finite())
        && errors.iter().all(|error| error.abs() < RIGIDITY_TOLERANCE)
        && pose[12..] == [0.0, 0.0, 0.0, 1.0];
    let what = || format!("world_from_camera is {pose:?}");
    (!is_rigid).then(|| (what(), "give a rigid transform row by row, with OpenCV axes, in meters"))
}
