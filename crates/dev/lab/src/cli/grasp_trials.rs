//! `grasp-trials`: tries grasps of the objects in the scene of a bundle, and tells what became of each.
//!
//! The robot is written as MJCF to the folder of `--out`. The first line of JSON describes its gripper and the trial;
//! then each object gives one line with the grasps that were tried, stable or not. Another simulator can repeat them
//! from that and from the bundle: `tests/judges/robots/replay_grasps.py`. Equal scenes and seeds give equal lines.

use std::fs;
use std::path::PathBuf;

use clap::Args;
use serde::Serialize;

use geometry::Pose;
use manipulation::grasp::{Grasp, TrialSettings, Verdict, grasps};
use physics::Body;
use robot::export::write_mjcf;
use robot::model::Robot;
use runtime::seed::child_rng;
use tabletopgen::app::executions::task_scene;
use tabletopgen::cli::bundle_input::BundleInput;
use tabletopgen::cli::options::ConfigOptions;
use tabletopgen::cli::{Exit, Failure, terminal};
use tabletopgen::pipeline::task_scene::of_archive;

/// Arguments of `grasp-trials`.
#[derive(Debug, Args)]
pub struct Arguments {
    /// The bundle of the scene: its folder, or its archive
    #[arg(long, value_name = "DIR_OR_ZIP")]
    bundle: PathBuf,
    /// The robot whose gripper is tried
    #[arg(long, value_name = "NAME", default_value = "panda")]
    robot: String,
    /// Same scene and seed: same grasps
    #[arg(long, value_name = "N", default_value_t = 0)]
    seed: u64,
    /// Folder for `robot.xml`
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    #[command(flatten)]
    config: ConfigOptions,
}

/// Values that all trials have in common.
#[derive(Debug, Serialize)]
struct Header<'a> {
    robot: &'a str,
    /// Names in `robot.xml`.
    hand_body: &'a str,
    tool_site: &'a str,
    gripper_joint: &'a str,
    /// Distance between the pads for each meter that the gripper's joint is from closed.
    opening_per_position: f64,
    trial: &'a TrialSettings,
}

/// The trials of one object.
#[derive(Debug, Serialize)]
struct Trials<'a> {
    object: &'a str,
    mass_kg: f64,
    /// A plane is at this height, the lowest point of the object.
    plane_z_m: f64,
    world_from_object: Pose,
    trials: Vec<&'a Grasp>,
}

/// Tries the grasps, and prints them.
pub fn run(arguments: Arguments) -> Result<Exit, Failure> {
    let config = arguments.config.load(Vec::new())?.config;
    let robot = Robot::built_in(&arguments.robot, None)
        .map_err(|error| Failure::usage(format!("--robot {}: {error}", arguments.robot)))?;
    let archive = BundleInput::open(&arguments.bundle)?.into_archive()?;
    let bundle = of_archive(&archive).map_err(|error| Failure::usage(error.message))?;
    let scene = task_scene(&bundle).map_err(|problem| Failure::usage(problem.detail))?;
    let written = fs::create_dir_all(&arguments.out)
        .and_then(|()| fs::write(arguments.out.join("robot.xml"), write_mjcf(&robot)));
    written.map_err(|error| {
        Failure::new(
            Exit::Error,
            format!("the robot was not written to {}: {error}", arguments.out.display()),
        )
    })?;
    let gripper_link = &robot.links()[robot.gripper().link];
    print(&Header {
        robot: robot.name(),
        hand_body: &robot.links()[robot.tool().link].name,
        tool_site: &robot.tool().name,
        gripper_joint: gripper_link.joint.as_ref().map_or("", |joint| &joint.name),
        opening_per_position: robot.gripper().opening_per_position,
        trial: &config.grasps.trial,
    })?;
    for body in &scene.objects {
        let mut rng = child_rng(arguments.seed, &format!("grasps of {}", body.name));
        let found = grasps(body, &robot, &config.grasps, &mut rng).map_err(|error| {
            Failure::new(Exit::Error, format!("grasps of {} could not be tried: {error}", body.name))
        })?;
        print(&Trials {
            object: &body.name,
            mass_kg: body.mass.mass_kg,
            plane_z_m: lowest_m(body),
            world_from_object: body.world_from_object,
            trials: found.iter().filter(|grasp| grasp.verdict != Verdict::Untested).collect(),
        })?;
    }
    Ok(Exit::Success)
}

/// The height of the lowest point of an object.
fn lowest_m(body: &Body) -> f64 {
    let points = body.hulls.iter().flat_map(|hull| &hull.points);
    points.map(|point| body.world_from_object.transform_point(*point).z).fold(f64::INFINITY, f64::min)
}

fn print<T: Serialize>(line: &T) -> Result<(), Failure> {
    let text = serde_json::to_string(line)
        .map_err(|error| Failure::new(Exit::Error, format!("a result has no JSON form: {error}; a bug")))?;
    terminal::print(&(text + "\n"));
    Ok(())
}
