//! Stands every category of the catalog alone on a table, as it is made, and says what does not stay, is not
//! watertight or is slow to cut: `cargo run --release --example catalog_at_rest -- [CATEGORY]...`.
//!
//! A line a category: watertight, hulls, how far they stick out, milliseconds to cut them, and how far it moved and
//! turned while it settled and in the five seconds after. The exit code tells whether everything is closed and stays.

use std::io::Write;
use std::process::ExitCode;
use std::time::Instant;

use catalog::{Category, Recipe, build, categories, physical_properties};
use geometry::convex_hull::convex_hull;
use geometry::decompose::decompose;
use geometry::solid_query::MeshSolid;
use geometry::{DQuat, DVec3, Friction, MassProperties, Pose};
use physics::{Body, Stability, settle, stability};
use rayon::prelude::*;
use runtime::CancelFlag;
use tabletopgen::config::layers::load;
use tabletopgen::config::{Config, Sources};

/// Sizes and variants tried of each.
const SEEDS: [u64; 2] = [1, 2];

/// Displacement and rotation after settling that count as moving, meters and radians.
const MAX_M: f64 = 0.001;
const MAX_RAD: f64 = 0.02;

fn main() -> ExitCode {
    let config = load(Sources::default()).expect("the shipped defaults are valid").config;
    let wanted: Vec<String> = std::env::args().skip(1).collect();
    let tried: Vec<(&Category, u64)> = categories()
        .iter()
        .filter(|category| wanted.is_empty() || wanted.contains(&category.name))
        .flat_map(|category| SEEDS.map(|seed| (category, seed)))
        .collect();
    let mut lines: Vec<(bool, String)> =
        tried.par_iter().map(|(category, seed)| stand(category, *seed, &config)).collect();
    lines.sort();
    let bad = lines.iter().filter(|(good, _)| !good).count();
    lines.push((true, format!("{bad} of {} move, leak or cannot be cut", lines.len())));
    let mut out = std::io::stdout().lock();
    let message = lines.iter().try_for_each(|(_, line)| writeln!(out, "{line}"));
    if bad == 0 && message.is_ok() { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}

/// Whether it is closed and stays, and its line.
fn stand(category: &Category, seed: u64, config: &Config) -> (bool, String) {
    let label = format!("{:20} {seed}", category.name);
    let recipe = Recipe {
        category: category.name.clone(),
        size_m: if seed == 1 { category.size.low_m } else { category.size.high_m },
        color: None,
        material: None,
        seed,
    };
    let mesh = build(&recipe).expect("a category of the catalog");
    let watertight = MeshSolid::new(&mesh).is_ok_and(|solid| solid.is_watertight());
    let began = Instant::now();
    let (hulls, excess_m) = match decompose(&mesh, &config.decompose, &CancelFlag::default()) {
        Ok(found) => (found.hulls, found.max_excess_m),
        Err(error) => return (false, format!("{label} cannot be cut: {error}")),
    };
    let cut_ms = 1e3 * began.elapsed().as_secs_f64();
    let physical = match physical_properties(&mesh, &category.name, None) {
        Ok(physical) => physical,
        Err(error) => return (false, format!("{label} weighs nothing: {error}")),
    };
    let count = hulls.len();
    let lowest = hulls.iter().flat_map(|h| &h.points).map(|p| p.z).fold(f64::INFINITY, f64::min);
    let body = Body {
        name: category.name.clone(),
        hulls,
        world_from_object: Pose {
            translation_m: DVec3::new(0.1, 0.05, -lowest),
            rotation: DQuat::from_rotation_z(0.3),
        },
        mass: physical.mass,
        friction: physical.friction,
        restitution: physical.restitution,
        rolling_friction_m: physical.rolling_friction_m,
        fixed: false,
    };
    let mut bodies = vec![table(), body];
    let settled = match settle(&bodies, &config.settle, &CancelFlag::default()) {
        Ok(settled) => settled,
        Err(error) => return (false, format!("{label} cannot settle: {error}")),
    };
    bodies[1].world_from_object = settled.poses[1];
    let Stability { movements, .. } =
        stability(&bodies, &config.certify, &config.settle, &CancelFlag::default())
            .expect("it settled before");
    let stays = movements[1].displacement_m < MAX_M && movements[1].rotation_rad < MAX_RAD;
    let words = format!(
        "{} {label} {} {count:3} hulls {:4.1} mm off {cut_ms:6.0} ms; settled {:5.1} mm {:5.1} deg{}; then {:6.2} mm {:5.2} deg",
        if watertight && stays { "good" } else { "BAD " },
        if watertight { "closed" } else { "LEAKS " },
        1e3 * excess_m,
        1e3 * settled.displacements_m[1],
        settled.rotations_rad[1].to_degrees(),
        if settled.at_rest { "" } else { " RESTLESS" },
        1e3 * movements[1].displacement_m,
        movements[1].rotation_rad.to_degrees(),
    );
    (watertight && stays, words)
}

/// A fixed wooden top, 2 m square, at z = 0.
fn table() -> Body {
    let corners: Vec<DVec3> = (0..8)
        .map(|k| {
            let pick = |bit: usize, low: f64, high: f64| if k & bit == 0 { low } else { high };
            DVec3::new(pick(1, -1.0, 1.0), pick(2, -1.0, 1.0), pick(4, -0.03, 0.0))
        })
        .collect();
    Body {
        name: "table".into(),
        hulls: vec![convex_hull(&corners, 64, 0.001).expect("a block")],
        world_from_object: Pose::IDENTITY,
        mass: MassProperties {
            mass_kg: 50.0,
            center_of_mass_m: DVec3::ZERO,
            inertia_diagonal_kg_m2: DVec3::ONE,
            principal_axes_xyzw: DQuat::IDENTITY,
        },
        friction: Friction { static_coefficient: 0.45, dynamic_coefficient: 0.35 },
        restitution: 0.25,
        rolling_friction_m: 0.0003,
        fixed: true,
    }
}
