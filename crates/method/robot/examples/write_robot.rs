//! Writes a robot of `config/robots/` as files for simulators, with sampled poses for independent programs to check.
//!
//! ```text
//! cargo run -p tabletopgen-robot --example write_robot -- panda out/panda
//! cargo run -p tabletopgen-robot --example write_robot -- piper out/piper_old old_zero
//! ```
//!
//! Beside `robot.urdf`, `robot.xml` and `robot.usda` stands `kinematics.json`: names of links and joints, and for each
//! sampled configuration `base_from_link` of every link and `base_from_tool`, as rows of 4x4 matrices in meters.

use std::error::Error;
use std::fs;
use std::path::Path;

use nalgebra::Isometry3;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde_json::{Value, json};

use robot::export::{write_mjcf, write_urdf, write_usd};
use robot::kinematics::{jacobian, link_poses, tool_pose};
use robot::model::Robot;

const SAMPLES: usize = 500;

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [name, folder, variant @ ..] = arguments.as_slice() else {
        return Err("name a robot, a folder and optionally a variant".into());
    };
    let robot = Robot::built_in(name, variant.first().map(String::as_str))?;
    let folder = Path::new(folder);
    fs::create_dir_all(folder)?;
    fs::write(folder.join("robot.urdf"), write_urdf(&robot))?;
    fs::write(folder.join("robot.xml"), write_mjcf(&robot))?;
    fs::write(folder.join("robot.usda"), write_usd(&robot))?;
    fs::write(folder.join("kinematics.json"), serde_json::to_vec(&kinematics(&robot))?)?;
    Ok(())
}

fn kinematics(robot: &Robot) -> Value {
    let mut random = ChaCha8Rng::seed_from_u64(0);
    let home = robot.home();
    let samples = (0..SAMPLES).map(|_| {
        let within = |l: &robot::model::JointLimits| random.random_range(l.min_position..=l.max_position);
        let positions: Vec<f64> = robot.limits().iter().map(within).collect();
        let opening_m = random.random_range(0.0..=robot.gripper().max_opening_m);
        sample(robot, &positions, opening_m)
    });
    let samples: Vec<Value> = samples.collect();
    let arm = robot.arm_links().iter().filter_map(|link| robot.links()[*link].joint.as_ref());
    json!({
        "name": robot.name(),
        "variant": robot.variant(),
        "links": robot.links().iter().map(|link| &link.name).collect::<Vec<_>>(),
        "masses_kg": robot.links().iter().map(|l| l.inertia.map(|i| i.mass_kg)).collect::<Vec<_>>(),
        "arm_joints": arm.map(|joint| &joint.name).collect::<Vec<_>>(),
        "gripper_joint": robot.links()[robot.gripper().link].joint.as_ref().map(|joint| &joint.name),
        "tool": robot.tool().name,
        "grip_force_n": robot.gripper().grip_force_n,
        "max_force_n": robot.gripper().max_force_n,
        "max_opening_m": robot.gripper().max_opening_m,
        "home": sample(robot, &home.positions, home.opening_m),
        "samples": samples,
    })
}

fn sample(robot: &Robot, positions: &[f64], opening_m: f64) -> Value {
    let jacobian = jacobian(robot, positions);
    json!({
        "positions": positions,
        "gripper_position": robot.gripper_position(opening_m),
        "base_from_link": link_poses(robot, positions, opening_m).iter().map(rows).collect::<Vec<_>>(),
        "base_from_tool": rows(&tool_pose(robot, positions)),
        "jacobian": jacobian.row_iter().map(|row| row.iter().copied().collect()).collect::<Vec<Vec<f64>>>(),
    })
}

fn rows(pose: &Isometry3<f64>) -> Vec<Vec<f64>> {
    pose.to_homogeneous().row_iter().map(|row| row.iter().copied().collect()).collect()
}
