//! Prints for each pair of links that is checked how often its spheres meet in random configurations, and how far the
//! shapes of the robot stand from each other at home: what `ignored_pairs` of a new robot's file is decided by.
//!
//! ```text
//! cargo run -p tabletopgen-robot --example self_collision -- panda
//! ```

use std::error::Error;

use nalgebra::Point3;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use robot::kinematics::link_poses;
use robot::model::{ArmSpheres, Robot, SphereModel};

const SAMPLES: usize = 20_000;

#[expect(clippy::print_stdout, reason = "the table is what this program is for")]
fn main() -> Result<(), Box<dyn Error>> {
    let name = std::env::args().nth(1).ok_or("name a robot")?;
    let robot = Robot::built_in(&name, None)?;
    let arm = ArmSpheres::new(&robot, robot.home().opening_m);
    let pairs = arm.self_collision_pairs();
    let mut meetings = vec![0; pairs.len()];
    let mut random = ChaCha8Rng::seed_from_u64(0);
    for _ in 0..SAMPLES {
        let within = |l: &robot::model::JointLimits| random.random_range(l.min_position..=l.max_position);
        let positions: Vec<f64> = robot.limits().iter().map(within).collect();
        let gaps = gaps_m(&robot, &arm, &positions);
        for (meetings, gap) in meetings.iter_mut().zip(gaps) {
            *meetings += usize::from(gap < 0.0);
        }
    }
    let at_home = gaps_m(&robot, &arm, &robot.home().positions);
    println!("{} spheres", arm.spheres().len());
    println!("{:28} {:>9} {:>12}", "links", "meet", "gap at home");
    for (((a, b), meetings), gap) in pairs.iter().zip(meetings).zip(at_home) {
        let names = format!("{} {}", robot.links()[*a].name, robot.links()[*b].name);
        println!("{names:28} {:7.2} % {:9.1} mm", 100.0 * meetings as f64 / SAMPLES as f64, 1e3 * gap);
    }
    Ok(())
}

/// The smallest distance between the spheres of each checked pair, negative where they meet.
fn gaps_m(robot: &Robot, arm: &ArmSpheres, positions: &[f64]) -> Vec<f64> {
    let poses = link_poses(robot, positions, robot.home().opening_m);
    let spheres = |link: usize| {
        arm.spheres()
            .iter()
            .filter(move |s| s.link == link)
            .map(|s| (poses[s.link] * Point3::from(s.center_m.map(f64::from)), f64::from(s.radius_m)))
    };
    let gap = |(a, b): &(usize, usize)| {
        let pairs = spheres(*a).flat_map(|first| spheres(*b).map(move |second| (first, second)));
        pairs.map(|((p, r), (q, s))| (p - q).norm() - r - s).fold(f64::INFINITY, f64::min)
    };
    arm.self_collision_pairs().iter().map(gap).collect()
}
