//! Proposes tasks for the scenes of bundles and says how many of their default wordings are read back as the same goal.
//!
//! `cargo run --release -p tabletopgen-tasks --example propose -- COUNT BUNDLE...` prints a line per bundle. With
//! `TASKS_OUT=DIR` it also writes every task as JSON and BDDL, and the domain, for `tests/judges/tasks/check_bddl.py`.

#![expect(clippy::print_stdout, reason = "an example reports on standard output")]

use std::collections::BTreeMap;
use std::error::Error;
use std::path::Path;
use std::sync::Arc;
use std::time::Instant;

use catalog::{Affordance, category};
use geometry::convex_hull::convex_hull;
use geometry::{ConvexHull, Rgb};
use glam::DVec3;
use scene::Scene;
use tasks::goal::formula;
use tasks::{ObjectAppearance, ObjectShape, ProposedTask, RobotLimits, TaskScene, bddl, propose};

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1);
    let count: usize = arguments.next().ok_or("COUNT is missing")?.parse()?;
    let robot = RobotLimits::new("panda", 0.08, 0.005, 3.0);
    let out = std::env::var("TASKS_OUT").ok();
    if let Some(folder) = &out {
        std::fs::create_dir_all(folder)?;
        std::fs::write(Path::new(folder).join("domain.bddl"), bddl::domain())?;
    }
    let (mut total, mut same) = (0, 0);
    for bundle in arguments {
        let scene = load(Path::new(&bundle))?;
        let start = Instant::now();
        let proposed = propose(&scene, count, 1, &robot);
        let seconds = start.elapsed().as_secs_f64();
        let mut kinds: BTreeMap<String, usize> = BTreeMap::new();
        let mut kept = 0;
        for (number, proposal) in proposed.iter().enumerate() {
            *kinds.entry(format!("{:?}", proposal.kind)).or_default() += 1;
            match read_back(proposal, &scene) {
                Ok(()) => kept += 1,
                Err(fault) => println!("  {:?}: {fault}", proposal.wordings.default),
            }
            if let Some(folder) = &out {
                let stem = Path::new(folder).join(format!("{}_{number}", bundle.replace('/', "_")));
                std::fs::write(stem.with_extension("json"), serde_json::to_string_pretty(&proposal.task)?)?;
                let problem = bddl::problem(&format!("task_{number}"), &proposal.task, &scene);
                std::fs::write(stem.with_extension("bddl"), problem)?;
            }
            if std::env::var("TASKS_SHOW").is_ok() {
                println!("  {:.2} {:?}", proposal.difficulty.overall, proposal.wordings);
            }
        }
        total += proposed.len();
        same += kept;
        println!(
            "{bundle}: {} objects, {} proposals in {seconds:.2} s, {kept} read back, {kinds:?}",
            scene.posed().len(),
            proposed.len()
        );
    }
    println!("{same} of {total} default wordings are read back as the same goal");
    Ok(())
}

/// Checks that the default wording has the same goal when it is read as an instruction.
fn read_back(proposal: &ProposedTask, scene: &TaskScene) -> Result<(), String> {
    let goal = tasks::text::goal(&proposal.wordings.default, scene).map_err(|refusal| refusal.to_string())?;
    if goal == proposal.task.goal {
        return Ok(());
    }
    let formulas: Vec<String> = goal.predicates().iter().map(formula).collect();
    Err(format!("is read as {}", formulas.join(", ")))
}

/// The scene of a bundle with the hulls of its MJCF and the colors of its composition.
fn load(bundle: &Path) -> Result<TaskScene, Box<dyn Error>> {
    let scene: Scene = serde_json::from_str(&std::fs::read_to_string(bundle.join("scene.json"))?)?;
    let composition: serde_json::Value = std::fs::read_to_string(bundle.join("composition.json"))
        .map_or(Ok(serde_json::Value::Null), |text| serde_json::from_str(&text))?;
    let mjcf = std::fs::read_to_string(bundle.join("mjcf/scene.xml"))?;
    let document = roxmltree::Document::parse(&mjcf)?;
    let mut hulls: BTreeMap<String, Vec<ConvexHull>> = BTreeMap::new();
    for mesh in document.descendants().filter(|node| node.has_tag_name("mesh")) {
        let (Some(name), Some(vertices)) = (mesh.attribute("name"), mesh.attribute("vertex")) else {
            continue;
        };
        let Some((object, _)) = name.rsplit_once("_hull_") else { continue };
        let numbers: Vec<f64> =
            vertices.split_whitespace().filter_map(|number| number.parse().ok()).collect();
        let points: Vec<DVec3> = numbers.chunks_exact(3).map(DVec3::from_slice).collect();
        hulls.entry(object.to_owned()).or_default().extend(convex_hull(&points, 64, 0.0));
    }
    let mut appearances = Vec::new();
    for instance in &scene.instances {
        let known = composition["composition"]["recognition"]["objects"].as_array();
        let recognized =
            known.and_then(|all| all.iter().find(|object| object["id"] == instance.name.as_str()));
        let color = recognized.and_then(|object| serde_json::from_value::<Rgb>(object["color"].clone()).ok());
        let material = recognized.and_then(|object| object["material"].as_str()).map(str::to_owned);
        let is_graspable =
            category(&instance.category).is_none_or(|known| known.affords(Affordance::Graspable));
        let parts = hulls.remove(instance.name.as_str()).unwrap_or_default();
        let mass = &instance.mass;
        let shape = ObjectShape::new(parts, mass.center_of_mass_m, mass.mass_kg, is_graspable)?;
        appearances.push(ObjectAppearance { shape: Arc::new(shape), color, material });
    }
    Ok(TaskScene::of_scene(&scene, &appearances)?)
}
