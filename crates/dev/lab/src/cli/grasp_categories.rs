//! `grasp-categories`: tries to grasp the typical object of each category of the catalog that is for grippers.
//!
//! Each object stands alone on a plane, and is tried until one grasp is stable, as often as the settings allow. One
//! line of JSON for each category. It fits the gripper if its hulls have any candidate for a grasp. Equal settings,
//! catalogs and seeds give equal lines.

use std::fmt::Display;

use clap::Args;
use rayon::prelude::*;
use serde::Serialize;

use catalog::{Affordance, Category, Recipe, categories};
use geometry::decompose::DecomposeSettings;
use manipulation::grasp::{Grasp, GraspSettings, Verdict, grasps};
use manipulation::world::WorldError;
use physics::Body;
use robot::model::Robot;
use runtime::seed::child_rng;
use tabletopgen::cli::options::ConfigOptions;
use tabletopgen::cli::{Exit, Failure, terminal};
use tabletopgen::pipeline::catalog_body::catalog_body;

/// Arguments of `grasp-categories`.
#[derive(Debug, Args)]
pub struct Arguments {
    /// The robot whose gripper is tried
    #[arg(long, value_name = "NAME", default_value = "panda")]
    robot: String,
    /// Same categories and seed: same grasps
    #[arg(long, value_name = "N", default_value_t = 0)]
    seed: u64,
    /// Also tell each grasp that was tried
    #[arg(long)]
    trials: bool,
    /// Only these categories
    #[arg(value_name = "CATEGORY")]
    categories: Vec<String>,
    #[command(flatten)]
    config: ConfigOptions,
}

/// Results of a category.
#[derive(Debug, Serialize)]
struct Outcome<'a> {
    category: &'a str,
    mass_kg: f64,
    /// The smallest side of the box around it.
    thinnest_m: f64,
    candidates: usize,
    tried: usize,
    /// Distance that the object slipped while it was shaken, in the grasp that was stable.
    stable_slip_m: Option<f64>,
    /// Distance that the object slipped in the best of the unstable grasps.
    unstable_slip_m: Option<f64>,
    /// The grasps that were tried, the stable ones first.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    trials: Vec<Grasp>,
}

/// Tries the categories, and prints what became of them in the order of the catalog.
pub fn run(arguments: Arguments) -> Result<Exit, Failure> {
    let config = arguments.config.load(Vec::new())?.config;
    let robot = Robot::built_in(&arguments.robot, None)
        .map_err(|error| Failure::usage(format!("--robot {}: {error}", arguments.robot)))?;
    let all = categories().iter().filter(|category| category.affords(Affordance::Graspable));
    let all: Vec<&Category> = all.collect();
    let asked = &arguments.categories;
    if let Some(unknown) = asked.iter().find(|name| all.iter().all(|category| category.name != **name)) {
        return Err(Failure::usage(format!("{unknown} is no category that is for grippers")));
    }
    let chosen = all.into_iter().filter(|category| asked.is_empty() || asked.contains(&category.name));
    let chosen: Vec<&Category> = chosen.collect();
    let settings = GraspSettings { wanted_stable: 1, ..config.grasps.clone() };
    let tried = |category: &&'static Category| {
        let body = object(category, &config.decompose)?;
        outcome(category, &body, &robot, &settings, &arguments).map_err(|error| not_tried(category, error))
    };
    let outcomes: Vec<Outcome> = chosen.par_iter().map(tried).collect::<Result<_, Failure>>()?;
    for outcome in &outcomes {
        let text = serde_json::to_string(outcome).map_err(|error| {
            Failure::new(Exit::Error, format!("a result has no JSON form: {error}; a bug"))
        })?;
        terminal::print(&(text + "\n"));
    }
    Ok(Exit::Success)
}

/// The typical object of a category, upright at the origin.
fn object(category: &Category, settings: &DecomposeSettings) -> Result<Body, Failure> {
    let recipe = Recipe::typical(&category.name, None, None);
    let recipe = recipe.ok_or_else(|| not_tried(category, "it has no typical recipe"))?;
    let made = catalog_body(&category.name, &recipe, settings);
    made.map(|(body, _)| body).map_err(|why| not_tried(category, why))
}

fn not_tried(category: &Category, why: impl Display) -> Failure {
    Failure::new(Exit::Error, format!("{} could not be tried: {why}", category.name))
}

fn outcome<'a>(
    category: &'a Category,
    body: &Body,
    robot: &Robot,
    settings: &GraspSettings,
    arguments: &Arguments,
) -> Result<Outcome<'a>, WorldError> {
    let mut rng = child_rng(arguments.seed, &format!("grasps of {}", body.name));
    let found = grasps(body, robot, settings, &mut rng)?;
    let points = || body.hulls.iter().flat_map(|hull| &hull.points);
    let low = points().fold(geometry::DVec3::INFINITY, |low, p| low.min(*p));
    let high = points().fold(geometry::DVec3::NEG_INFINITY, |high, p| high.max(*p));
    let tried: Vec<Grasp> =
        found.iter().filter(|grasp| grasp.verdict != Verdict::Untested).copied().collect();
    Ok(Outcome {
        category: &category.name,
        mass_kg: body.mass.mass_kg,
        thinnest_m: (high - low).min_element(),
        candidates: found.len(),
        tried: tried.len(),
        stable_slip_m: smallest_slip_m(&found, |verdict| verdict == Verdict::Stable),
        unstable_slip_m: smallest_slip_m(&found, |v| !matches!(v, Verdict::Stable | Verdict::Untested)),
        trials: if arguments.trials { tried } else { Vec::new() },
    })
}

/// Of the grasps with such a verdict that held the object at all; those that never did have no slip.
fn smallest_slip_m(grasps: &[Grasp], is_meant: impl Fn(Verdict) -> bool) -> Option<f64> {
    let meant = grasps.iter().filter(|grasp| is_meant(grasp.verdict)).map(|grasp| grasp.slip_m);
    let meant = meant.filter(|slip_m| *slip_m > 0.0);
    meant.min_by(f64::total_cmp)
}
