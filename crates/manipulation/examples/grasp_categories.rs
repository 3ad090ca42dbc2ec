//! Tries to grasp the typical object of every category of the catalog, and prints which have a stable grasp.
//!
//! ```
//! cargo run --release -p tabletopgen-manipulation --example grasp_categories -- panda [CATEGORY...]
//! ```
//!
//! A category fits the gripper if any candidate was found, or the object has a side that is thin enough.

use std::error::Error;
use std::time::Instant;

use catalog::{Affordance, Category, Recipe, build, categories, physical_properties};
use geometry::Pose;
use geometry::decompose::{DecomposeSettings, decompose};
use manipulation::grasp::{GraspSettings, Verdict, grasps};
use physics::Body;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;
use robot::model::Robot;
use runtime::CancelFlag;

/// What became of a category.
struct Outcome {
    name: String,
    candidates: usize,
    tried: usize,
    stable: usize,
    best_slip_m: f64,
    thinnest_m: f64,
    mass_kg: f64,
    hulls: usize,
    seconds: f64,
}

fn object(category: &Category) -> Result<Body, Box<dyn Error + Send + Sync>> {
    let recipe = Recipe::typical(&category.name, None, None).ok_or("no recipe")?;
    let mesh = build(&recipe).ok_or("no mesh")?;
    let defaults: toml::Table = include_str!("../../../config/default.toml").parse()?;
    let settings: DecomposeSettings = defaults["decompose"].clone().try_into()?;
    let physical = physical_properties(&mesh, &category.name, None)?;
    Ok(Body {
        name: category.name.clone(),
        hulls: decompose(&mesh, &settings, &CancelFlag::default())?.hulls,
        world_from_object: Pose::IDENTITY,
        mass: physical.mass,
        friction: physical.friction,
        restitution: physical.restitution,
        rolling_friction_m: physical.rolling_friction_m,
        fixed: false,
    })
}

fn outcome(category: &Category, robot: &Robot) -> Result<Outcome, Box<dyn Error + Send + Sync>> {
    let begin = Instant::now();
    let body = object(category)?;
    let settings = GraspSettings { wanted_stable: 1, ..test_settings::section("grasps") };
    let found = grasps(&body, robot, &settings, &mut ChaCha8Rng::seed_from_u64(1))?;
    let points = || body.hulls.iter().flat_map(|hull| &hull.points);
    let low = points().fold(geometry::DVec3::INFINITY, |low, p| low.min(*p));
    let high = points().fold(geometry::DVec3::NEG_INFINITY, |high, p| high.max(*p));
    let slips = found.iter().filter(|g| g.verdict != Verdict::Untested && g.slip_m > 0.0).map(|g| g.slip_m);
    Ok(Outcome {
        name: category.name.clone(),
        candidates: found.len(),
        tried: found.iter().filter(|grasp| grasp.verdict != Verdict::Untested).count(),
        stable: found.iter().filter(|grasp| grasp.verdict == Verdict::Stable).count(),
        best_slip_m: slips.fold(f64::INFINITY, f64::min),
        thinnest_m: (high - low).min_element(),
        mass_kg: body.mass.mass_kg,
        hulls: body.hulls.len(),
        seconds: begin.elapsed().as_secs_f64(),
    })
}

#[expect(clippy::print_stdout, reason = "an example that reports")]
fn main() -> Result<(), Box<dyn Error + Send + Sync>> {
    let mut arguments = std::env::args().skip(1);
    let robot = Robot::built_in(&arguments.next().unwrap_or_else(|| "panda".to_owned()), None)?;
    let asked: Vec<String> = arguments.collect();
    let chosen: Vec<&Category> = categories()
        .iter()
        .filter(|category| category.affords(Affordance::Graspable))
        .filter(|category| asked.is_empty() || asked.contains(&category.name))
        .collect();
    let report = |category: &&Category| {
        let found = outcome(category, &robot)?;
        let Outcome { name, candidates, tried, stable, best_slip_m, thinnest_m, mass_kg, hulls, seconds } =
            &found;
        let fits = *candidates > 0;
        let word = if *stable > 0 {
            "stable"
        } else if fits {
            "UNSTABLE"
        } else {
            "no candidate"
        };
        println!(
            "{name}: {word}, {candidates} candidates, {tried} tried, slip {:.3} mm, thinnest {:.0} mm, {mass_kg:.3} \
             kg, {hulls} hulls, {seconds:.1} s",
            1e3 * best_slip_m,
            1e3 * thinnest_m
        );
        Ok(found)
    };
    let outcomes: Vec<Outcome> =
        chosen.par_iter().map(report).collect::<Result<_, Box<dyn Error + Send + Sync>>>()?;
    let fitting = outcomes.iter().filter(|outcome| outcome.candidates > 0).count();
    let held = outcomes.iter().filter(|outcome| outcome.stable > 0).count();
    println!(
        "{}: {} graspable categories, {fitting} fit the gripper, {held} of these have a stable grasp ({:.1} %)",
        robot.name(),
        outcomes.len(),
        100.0 * held as f64 / f64::from(u32::try_from(fitting.max(1))?)
    );
    Ok(())
}
