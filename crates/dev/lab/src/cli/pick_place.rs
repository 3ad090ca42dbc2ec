//! `pick-place`: makes pick-and-place motion problems in the scene of a bundle, and plans them.
//!
//! Each object is put to a random free place of the table, and on one random other object, where that is possible.
//! Each pick and place leaves two motions to the planner, and each of these gives one line of JSON: whether an
//! execution would have planned it, in what time, and what the exact check says of the path and of the motion along
//! it. What is not planned, or touches something, is tried by all other means for ten seconds. An object without a
//! problem gives one line with the reason. Equal scenes and seeds give equal lines but for the seconds, and but for
//! what the ten seconds are enough for.

use std::path::PathBuf;
use std::time::{Duration, Instant};

use clap::Args;
use rand::seq::SliceRandom;
use serde::Serialize;

use crate::benchmark::persistent_planner;
use manipulation::execution::{ExecutionSettings, MotionProblem, NoProblem, PickAndPlaces, TaskScene};
use robot::model::Robot;
use robot::trajectory::Trajectory;
use runtime::seed::child_rng;
use tabletopgen::app::executions::task_scene;
use tabletopgen::cli::bundle_input::BundleInput;
use tabletopgen::cli::options::ConfigOptions;
use tabletopgen::cli::{Exit, Failure, terminal};
use tabletopgen::pipeline::task_scene::of_archive;

/// Time limit for the persistent planner, which tries a motion again that was not planned.
const ANYTHING: Duration = Duration::from_secs(10);
/// Objects that are tried as a support before an object is put on the table only.
const SUPPORTS: usize = 4;
/// The motion is certified as a chain of configurations so far apart in time, seconds: at 6 rad/s^2 it is 1 mrad off.
const CERTIFIED_EVERY_S: f64 = 0.04;

/// Arguments of `pick-place`.
#[derive(Debug, Args)]
pub struct Arguments {
    /// The bundle of the scene: its folder, or its archive
    #[arg(long, value_name = "DIR_OR_ZIP")]
    bundle: PathBuf,
    /// The robot that moves the objects
    #[arg(long, value_name = "NAME", default_value = "panda")]
    robot: String,
    /// Same scene and seed: same problems and paths
    #[arg(long, value_name = "N", default_value_t = 0)]
    seed: u64,
    /// The most picks and places
    #[arg(long, value_name = "N", default_value_t = 10)]
    max_problems: usize,
    #[command(flatten)]
    config: ConfigOptions,
}

/// One line of the output.
#[derive(Debug, Serialize)]
#[serde(untagged)]
enum Line {
    Motion(MotionRecord),
    None { object: String, support: Option<String>, no_problem: NoProblem },
}

/// Result of a motion problem.
#[derive(Debug, Serialize)]
struct MotionRecord {
    /// The name of the pick and place in its scene; its two motions share it.
    problem: String,
    object: String,
    support: Option<String>,
    /// `transit` or `carry`.
    kind: &'static str,
    obstacles: usize,
    /// The planner of an execution has a path, and the path a motion.
    solved: bool,
    /// The path keeps the full distance from obstacles.
    is_padded: bool,
    /// Of the planner, and of the planner and the time law.
    plan_s: f64,
    total_s: f64,
    /// The exact check certifies the path, and the motion along it.
    path_is_free: bool,
    motion_is_free: bool,
    /// A free path exists, whatever found it.
    solvable: bool,
    /// Reason why it was not solved, or the contact on its path.
    detail: Option<String>,
}

/// Makes and plans the problems, and prints them.
pub fn run(arguments: Arguments) -> Result<Exit, Failure> {
    let config = arguments.config.load(Vec::new())?.config;
    let robot = Robot::built_in(&arguments.robot, None)
        .map_err(|error| Failure::usage(format!("--robot {}: {error}", arguments.robot)))?;
    let archive = BundleInput::open(&arguments.bundle)?.into_archive()?;
    let bundle = of_archive(&archive).map_err(|error| Failure::usage(error.message))?;
    let scene = task_scene(&bundle).map_err(|problem| Failure::usage(problem.detail))?;
    let problems = PickAndPlaces::new(&scene, &robot, &config.grasps, &config.execution, arguments.seed)
        .map_err(|error| Failure::usage(error.to_string()))?;
    let mut left = arguments.max_problems;
    for object in shuffled(&scene, arguments.seed, "objects") {
        if left == 0 {
            break;
        }
        left -= print_object(&problems, &scene, object, left, &config.execution, arguments.seed)?;
    }
    Ok(Exit::Success)
}

/// Plans the problems with one object, at most `max_problems`; returns how many there were.
fn print_object(
    problems: &PickAndPlaces,
    scene: &TaskScene,
    object: usize,
    max_problems: usize,
    settings: &ExecutionSettings,
    seed: u64,
) -> Result<usize, Failure> {
    let name = |index: usize| scene.objects[index].name.clone();
    let none = |support: Option<usize>, no_problem: NoProblem| {
        print(&Line::None { object: name(object), support: support.map(name), no_problem })
    };
    let grasps = match problems.grasps(object) {
        Ok(grasps) => grasps,
        Err(why_not) => return none(None, why_not).map(|()| 0),
    };
    let mut made = 0;
    let mut others = shuffled(scene, seed, &format!("supports of {}", name(object)));
    others.retain(|other| *other != object);
    let supports = others.into_iter().take(SUPPORTS).map(Some);
    for support in std::iter::once(None).chain(supports) {
        if made == max_problems {
            break;
        }
        match problems.problem(object, support, &grasps) {
            Ok(found) => {
                let problem = format!("{}/{}", found.object, found.support.as_deref().unwrap_or("table"));
                for (kind, motion) in [("transit", &found.transit), ("carry", &found.carry)] {
                    let stream = format!("{kind} of {problem}");
                    let record = MotionRecord {
                        problem: problem.clone(),
                        object: found.object.clone(),
                        support: found.support.clone(),
                        kind,
                        ..measured(motion, settings, seed, &stream)
                    };
                    print(&Line::Motion(record))?;
                }
                made += 1;
                // One place on another object is enough.
                if support.is_some() {
                    break;
                }
            }
            // Most objects carry nothing, which is no finding.
            Err(NoProblem::NoFreePlace) if support.is_some() => {}
            Err(why_not) => none(support, why_not)?,
        }
    }
    Ok(made)
}

/// Plans one motion, and finds out whether it can be planned at all.
fn measured(problem: &MotionProblem, settings: &ExecutionSettings, seed: u64, stream: &str) -> MotionRecord {
    let mut record = MotionRecord {
        problem: String::new(),
        object: String::new(),
        support: None,
        kind: "",
        obstacles: problem.obstacles.len(),
        solved: false,
        is_padded: false,
        plan_s: 0.0,
        total_s: 0.0,
        path_is_free: false,
        motion_is_free: false,
        solvable: false,
        detail: None,
    };
    let begin = Instant::now();
    let planned = problem.plan(settings, &mut child_rng(seed, stream));
    record.plan_s = begin.elapsed().as_secs_f64();
    match planned {
        Err(failure) => record.detail = Some(failure.to_string()),
        Ok(found) => {
            let timed = problem.time(&found);
            record.total_s = begin.elapsed().as_secs_f64();
            record.is_padded = found.padding_m > 0.0;
            let path = persistent_planner::certify(problem, &found.path);
            record.path_is_free = path.is_ok();
            record.detail = path.err().map(|contact| contact.to_string());
            match timed {
                Err(failure) => record.detail = Some(failure.to_string()),
                Ok(trajectory) => {
                    record.solved = true;
                    let motion = persistent_planner::certify(problem, &chain(&trajectory));
                    record.motion_is_free = motion.is_ok();
                    record.detail = record.detail.or(motion.err().map(|contact| contact.to_string()));
                }
            }
        }
    }
    record.total_s = record.total_s.max(record.plan_s);
    record.solvable = record.path_is_free || is_solvable(problem, seed, stream);
    record
}

/// Whether anything has a path within the time.
fn is_solvable(problem: &MotionProblem, seed: u64, stream: &str) -> bool {
    let begin = Instant::now();
    let mut rng = child_rng(seed, &format!("anything for {stream}"));
    persistent_planner::solve(problem, &mut || begin.elapsed() < ANYTHING, &mut rng).is_some()
}

/// Configurations of a motion, close to each other.
fn chain(trajectory: &Trajectory) -> Vec<Vec<f64>> {
    let count = (trajectory.duration_s() / CERTIFIED_EVERY_S).ceil().max(1.0) as usize;
    let at = |k: usize| trajectory.at(trajectory.duration_s() * k as f64 / count as f64).position;
    (0..=count).map(at).collect()
}

/// The indices of all objects in a random order.
fn shuffled(scene: &TaskScene, seed: u64, stream: &str) -> Vec<usize> {
    let mut order: Vec<usize> = (0..scene.objects.len()).collect();
    order.shuffle(&mut child_rng(seed, stream));
    order
}

fn print(line: &Line) -> Result<(), Failure> {
    let text = serde_json::to_string(line)
        .map_err(|error| Failure::new(Exit::Error, format!("a result has no JSON form: {error}; a bug")))?;
    terminal::print(&(text + "\n"));
    Ok(())
}
