//! `repeat-motion`: steps the world of an execution along its recorded targets, as often as asked, for timing.
//!
//! The targets of a frame hold until the next, so that other simulators can be stepped in the same way:
//! `tests/judges/episodes/stepping.py`. Nothing is planned, measured or recorded.

use std::fs;
use std::path::PathBuf;

use clap::Args;
use geometry::Pose;
use serde::Deserialize;
use serde_json::json;

use manipulation::execution::Recording;
use manipulation::frames::to_isometry;
use manipulation::world::{ManipulationWorld, WorldOptions};
use robot::model::Robot;
use tabletopgen::app::executions::task_scene;
use tabletopgen::cli::bundle_input::BundleInput;
use tabletopgen::cli::{Exit, Failure, terminal};
use tabletopgen::pipeline::task_scene::of_archive;

/// Speed of the pads, m/s.
const FINGER_SPEED_M_S: f64 = 0.1;

/// Arguments of `repeat-motion`.
#[derive(Debug, Args)]
pub struct Arguments {
    /// The bundle of the scene: its folder, or its archive
    #[arg(long, value_name = "DIR_OR_ZIP")]
    bundle: PathBuf,
    /// The folder that `tabletopgen execute --out` wrote
    #[arg(long, value_name = "DIR")]
    execution: PathBuf,
    /// Number of times that the motion is made, each from its start
    #[arg(long, value_name = "N", default_value_t = 1)]
    times: u32,
}

#[derive(Deserialize)]
struct Executed {
    execution: Verdict,
}

#[derive(Deserialize)]
struct Verdict {
    robot: String,
    world_from_base: Pose,
}

/// Repeats the motion, and prints how many steps that were.
pub fn run(arguments: Arguments) -> Result<Exit, Failure> {
    let Executed { execution } = read(&arguments, "execution.json")?;
    let recording: Recording = read(&arguments, "trajectory.json")?;
    let robot = Robot::built_in(&execution.robot, None)
        .map_err(|error| Failure::usage(format!("the robot {}: {error}", execution.robot)))?;
    let archive = BundleInput::open(&arguments.bundle)?.into_archive()?;
    let bundle = of_archive(&archive).map_err(|error| Failure::usage(error.message))?;
    let scene = task_scene(&bundle).map_err(|problem| Failure::usage(problem.detail))?;
    let [first, ..] = &recording.frames[..] else {
        return Err(Failure::usage("the execution has no motion; execute a task that moves something"));
    };
    let bodies: Vec<_> = std::iter::once(&scene.table).chain(&scene.objects).cloned().collect();
    let base = to_isometry(&execution.world_from_base);
    let options = WorldOptions::default();
    let steps_a_frame = (options.steps_per_s / recording.rate_hz).round() as usize;
    let mut steps = 0_u64;
    for _ in 0..arguments.times {
        let (start, opening_m) = (&first.joint_positions, first.opening_m);
        let mut world = ManipulationWorld::new(&bodies, &robot, &base, start, opening_m, &options)
            .map_err(|error| Failure::new(Exit::Error, format!("the scene cannot be simulated: {error}")))?;
        for frame in &recording.frames {
            world.set_joint_targets(&frame.joint_targets, &frame.joint_velocities);
            world.set_gripper(
                frame.opening_target_m.max(0.0),
                FINGER_SPEED_M_S,
                robot.gripper().grip_force_n,
            );
            for _ in 0..steps_a_frame {
                world.step();
            }
            steps += steps_a_frame as u64;
        }
    }
    let report = json!({
        "steps": steps,
        "steps_per_s": options.steps_per_s,
        "objects": scene.objects.len(),
        "hulls": bodies.iter().map(|body| body.hulls.len()).sum::<usize>(),
    });
    terminal::print(&format!("{report}\n"));
    Ok(Exit::Success)
}

fn read<T: serde::de::DeserializeOwned>(arguments: &Arguments, name: &str) -> Result<T, Failure> {
    let path = arguments.execution.join(name);
    let text = fs::read_to_string(&path)
        .map_err(|error| Failure::usage(format!("cannot read {}: {error}", path.display())))?;
    serde_json::from_str(&text)
        .map_err(|error| Failure::usage(format!("{} is of no execution: {error}", path.display())))
}
