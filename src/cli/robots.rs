//! `robots`: the robots that tasks are done with.

use clap::Args;
use serde_json::json;

use super::generate::refused;
use super::{Exit, Failure, terminal};
use crate::app::catalog::{RobotView, robots};

/// Arguments of `robots`.
#[derive(Debug, Args)]
pub struct Arguments {
    /// Print JSON
    #[arg(long)]
    json: bool,
}

/// Lists them.
pub fn run(arguments: &Arguments) -> Result<Exit, Failure> {
    let list = robots().map_err(|problem| refused(problem, "--robot"))?;
    terminal::print(&match arguments.json {
        true => format!("{:#}\n", json!(list)),
        false => list.robots.iter().map(line).collect(),
    });
    Ok(Exit::Success)
}

fn line(robot: &RobotView) -> String {
    let gripper = &robot.gripper;
    format!(
        "{:<8} {}: {} joints, gripper opens {:.0} mm and grips with {:.0} N\n",
        robot.name,
        robot.title,
        robot.dof,
        1000.0 * gripper.max_opening_m,
        gripper.grip_force_n
    )
}
