//! The files of an execution: verdict, task, motion, and the robot in the scene for other simulators.

use serde_json::{Value, json};

use super::Executed;
use super::parquet_table::parquet_table;
use super::video::video;
use crate::problem::{Problem, ProblemType};
use demonstrations::vectors::shares_of_limits;
use export::BundleFile;
use export::archive::wanted_files;
use manipulation::frames::to_isometry;
use robot::export::{
    write_mjcf, write_mjcf_in_scene, write_urdf, write_urdf_in_scene, write_usd, write_usd_in_scene,
};

/// Folders of a bundle that hold the scene for simulators.
const FORMATS: [&str; 3] = ["mjcf/", "urdf/", "usd/"];
/// Root of the scene's tree in its URDF and USD files.
const URDF_ROOT: &str = "world";
const USD_ROOT: &str = "World";

/// The verdict, without the motion.
pub fn verdict(executed: &Executed) -> Value {
    let mut verdict = json!(executed.execution);
    if let Some(members) = verdict.as_object_mut() {
        members.remove("recording");
        let shares = shares_of_limits(&executed.robot, &executed.execution.recording);
        members.insert("limit_shares".to_owned(), json!(shares));
    }
    json!({ "task": executed.task, "seed": executed.seed, "execution": verdict })
}

/// The verdict with the motion.
pub fn document(executed: &Executed) -> Value {
    let mut document = verdict(executed);
    document["trajectory"] = json!(executed.execution.recording);
    document
}

/// [`files`], with a video if one is wanted. Where not even the first motion was found, there is nothing to show.
///
/// # Errors
///
/// As [`files`], and where the video cannot be made.
pub fn all_files(archive: &[u8], executed: &Executed, with_video: bool) -> Result<Vec<BundleFile>, Problem> {
    let mut written = files(archive, executed)?;
    if with_video && !executed.execution.recording.frames.is_empty() {
        written.push(BundleFile::new("video.mp4", video(archive, executed)?, "video", "video/mp4"));
    }
    Ok(written)
}

/// `execution.json`, `task.json`, `trajectory.json`, `trajectory.parquet`, and in `mjcf/`, `urdf/` and `usd/` the files
/// of the scene with those of the robot: alone (`panda.xml`), and in the scene where it stood (`scene_with_panda.xml`).
///
/// # Errors
///
/// A [`Problem`] for a bundle without the files of a format.
pub fn files(archive: &[u8], executed: &Executed) -> Result<Vec<BundleFile>, Problem> {
    let json_file = |path: &str, text: String| file(path, "application/json", text);
    let mut files = vec![
        json_file("execution.json", format!("{:#}\n", verdict(executed))),
        json_file("task.json", format!("{:#}\n", json!(executed.task))),
        json_file("trajectory.json", format!("{}\n", json!(executed.execution.recording))),
    ];
    let table = parquet_table(&executed.execution.recording).map_err(|error| {
        Problem::new(ProblemType::Internal, "parquet_failed", format!("the table of the motion: {error}"))
    })?;
    files.push(BundleFile::new("trajectory.parquet", table, "execution", "application/vnd.apache.parquet"));
    files.extend(in_scene(archive, executed)?);
    Ok(files)
}

/// The scene's files for simulators, and the robot's beside them.
fn in_scene(archive: &[u8], executed: &Executed) -> Result<Vec<BundleFile>, Problem> {
    let robot = &executed.robot;
    let base = to_isometry(&executed.execution.world_from_base);
    let broken = |why: String| {
        Problem::new(ProblemType::Conflict, "bundle_unreadable", format!("the robot in the scene: {why}"))
    };
    let of_scene = wanted_files(archive, |path| FORMATS.iter().any(|folder| path.starts_with(folder)))
        .map_err(|error| broken(error.to_string()))?;
    let urdf = of_scene.get("urdf/scene.urdf").and_then(|bytes| std::str::from_utf8(bytes).ok());
    let urdf = urdf.and_then(|scene| write_urdf_in_scene(robot, scene, URDF_ROOT, &base));
    let urdf = urdf.ok_or_else(|| broken("the bundle has no usable urdf/scene.urdf".to_owned()))?;
    let name = robot.name();
    let (mjcf_name, usd_name) = (format!("{name}.xml"), format!("{name}.usda"));
    let mjcf = write_mjcf_in_scene(robot, &mjcf_name, "scene.xml", &base);
    let usd = write_usd_in_scene(robot, &usd_name, "scene.usda", USD_ROOT, &base);
    let (xml, usda) = ("application/xml", "model/vnd.usda");
    let added = [
        file(&format!("mjcf/{mjcf_name}"), xml, write_mjcf(robot)),
        file(&format!("mjcf/scene_with_{mjcf_name}"), xml, mjcf),
        file(&format!("urdf/{name}.urdf"), xml, write_urdf(robot)),
        file(&format!("urdf/scene_with_{name}.urdf"), xml, urdf),
        file(&format!("usd/{usd_name}"), usda, write_usd(robot)),
        file(&format!("usd/scene_with_{usd_name}"), usda, usd),
    ];
    let copied = of_scene
        .into_iter()
        .map(|(path, bytes)| BundleFile::new(path, bytes, "scene", "application/octet-stream"));
    Ok(copied.chain(added).collect())
}

fn file(path: &str, media_type: &str, text: String) -> BundleFile {
    BundleFile::new(path, text.into_bytes(), "execution", media_type)
}
