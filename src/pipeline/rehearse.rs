//! After `grasp`, where the request names a robot: what it can do in the finished scene.
//!
//! An object is pickable if one of its grasps is free of table and neighbors there, and the arm makes the straight
//! motions to it and up. Up to three tasks are proposed by the usual rules, of objects that are pickable, and executed
//! in simulation. Whether an object is pickable is decided by its grasps, not by its width. Seconds for each object and
//! each task.

use std::collections::BTreeSet;
use std::sync::Arc;

use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::certify::upright_frame::turned_upright;
use super::checkpoint::Stage;
use super::composition::Composition;
use super::error::StageError;
use super::grasp::robot_named;
use super::resolve::{Loaded, load};
use super::task_scene::{described, simulated};
use super::{Context, Settings};
use certificate::{RobotFinding, TaskTried};
use geometry::Pose;
use geometry::parallel_grasp::ParallelGrasp;
use glam::DVec3;
use manipulation::execution::{
    Execution, ExecutionSettings, GraspBook, Refusal, Rehearsal, RobotStart, execute,
};
use manipulation::grasp::{Grasp, GraspSettings, grasp_file, isaac_grasp_yaml};
use runtime::CancelFlag;
use runtime::seed::child_rng;
use scene::InstanceId;
use scene::grasps::GraspFile;
use tasks::propose;

pub const STAGE: Stage = Stage { name: "rehearse", version: 2 };

/// Most tasks that are proposed.
const MAX_TASKS: usize = 3;

#[derive(Serialize)]
pub struct Inputs {
    robot: String,
    seed: u64,
    composition: Composition,
    /// Of the objects in order, in the frames of the stages; `None` of those that are not for grippers.
    grasps: Vec<Option<Vec<Grasp>>>,
    grasp_settings: GraspSettings,
    execution: ExecutionSettings,
}

/// Abilities of a robot in the scene.
#[derive(Clone, Serialize, Deserialize)]
pub struct Output {
    pub finding: RobotFinding,
    /// Of the objects in order; `None` of those that are not for grippers.
    pub objects: Vec<Option<ObjectGrasps>>,
}

/// The grasps of one object in the frame of the bundle.
#[derive(Clone, Serialize, Deserialize)]
pub struct ObjectGrasps {
    pub file: GraspFile,
    /// Grasps as `isaac_grasp`.
    pub yaml: String,
}

impl ObjectGrasps {
    /// The best grasp, as the two points where the pads touch.
    pub fn best(&self) -> Option<ParallelGrasp> {
        let best = self.file.grasps.first()?;
        let pad = |side: f64| {
            best.object_from_tool.transform_point(DVec3::new(0.0, 0.5 * side * best.opening_m, 0.0))
        };
        Some(ParallelGrasp { contacts_m: [pad(-1.0), pad(1.0)] })
    }
}

impl Inputs {
    pub fn new(
        robot: &str,
        seed: u64,
        composition: &Composition,
        grasps: Vec<Option<Vec<Grasp>>>,
        settings: &Settings,
    ) -> Self {
        Self {
            robot: robot.to_owned(),
            seed,
            composition: composition.clone(),
            grasps,
            grasp_settings: settings.grasps.clone(),
            execution: settings.execution.clone(),
        }
    }
}

pub async fn run(context: Context, inputs: Arc<Inputs>) -> Result<Output, StageError> {
    let bodies = &inputs.composition.bodies;
    let parts = bodies.iter().map(|body| load(&context, &body.resolved.name, &body.mesh, &body.hulls));
    let loaded: Vec<Loaded> = futures::future::try_join_all(parts).await?;
    let cancel = context.cancel().clone();
    let output = context.cpu(move || rehearsed(&inputs, loaded, &cancel)).await??;
    context.put_json("robot.json", &output.finding).await?;
    Ok(output)
}

fn rehearsed(inputs: &Inputs, mut loaded: Vec<Loaded>, cancel: &CancelFlag) -> Result<Output, StageError> {
    let Inputs { seed, grasp_settings, execution: settings, .. } = inputs;
    let robot = robot_named(&inputs.robot)?;
    let mut composition = inputs.composition.clone();
    let turned = turned_upright(&mut composition, &mut loaded)?;
    let grasps: Vec<Option<Vec<Grasp>>> =
        inputs.grasps.iter().zip(&turned[1..]).map(|(grasps, turned)| in_frame(grasps, *turned)).collect();

    let broken = |why: String| StageError::permanent("not_rehearsed", format!("rehearsing the scene: {why}"));
    let hulls = loaded.iter().map(|body| &body.hulls);
    let scene = simulated(&composition, hulls).ok_or_else(|| broken("it has no table".to_owned()))?;
    let seen = described(&composition, &loaded)?;
    let rehearsal = Rehearsal::new(&scene, &robot, settings);
    let rehearsal = rehearsal.map_err(|error| broken(error.to_string()))?;
    let pickable: BTreeSet<&InstanceId> = seen
        .posed()
        .par_iter()
        .zip(&grasps)
        .filter_map(|(object, grasps)| {
            let can_be_picked =
                cancel.check().is_ok() && rehearsal.can_be_picked(&object.name, grasps.as_ref()?);
            can_be_picked.then_some(&object.name)
        })
        .collect();
    cancel.check()?;

    let mut limits = settings.limits_of(&robot, grasp_settings);
    limits.held =
        seen.posed().iter().map(|object| (object.name.clone(), pickable.contains(&object.name))).collect();
    let proposed = propose(&seen, MAX_TASKS, *seed, &limits);
    let named = seen.posed().iter().zip(&grasps);
    let book: GraspBook =
        named.map(|(object, grasps)| (object.name.to_string(), grasps.clone().unwrap_or_default())).collect();
    let tried: Vec<TaskTried> = proposed
        .par_iter()
        .map(|proposed| {
            cancel.check()?;
            let mut rng = child_rng(*seed, "execution");
            let done =
                execute(&scene, &robot, &proposed.task, &book, &RobotStart::default(), settings, &mut rng);
            Ok(TaskTried { instruction: proposed.task.instruction.clone(), outcome: outcome(done) })
        })
        .collect::<Result<_, StageError>>()?;
    cancel.check()?;

    let finding = RobotFinding {
        name: inputs.robot.clone(),
        objects: grasps.iter().flatten().count(),
        pickable: pickable.len(),
        tasks_proposed: tried.len(),
        tasks_done: tried.iter().filter(|task| task.outcome == DONE).count(),
        tasks: tried,
    };
    let objects = seen.posed().iter().zip(&grasps).map(|(object, grasps)| {
        let grasps = grasps.as_ref()?;
        let yaml = isaac_grasp_yaml(&robot, object.name.as_str(), grasps);
        Some(ObjectGrasps { file: grasp_file(&robot, grasps), yaml })
    });
    Ok(Output { finding, objects: objects.collect() })
}

/// The grasps in another frame of the object, where it has one.
fn in_frame(grasps: &Option<Vec<Grasp>>, upright_from_tipped: Option<Pose>) -> Option<Vec<Grasp>> {
    let turned = |grasp: &Grasp| match upright_from_tipped {
        Some(upright_from_tipped) => {
            Grasp { object_from_tool: upright_from_tipped * grasp.object_from_tool, ..*grasp }
        }
        None => *grasp,
    };
    grasps.as_ref().map(|grasps| grasps.iter().map(turned).collect())
}

/// The outcome of a task that was done.
const DONE: &str = "done";

/// The code of an outcome.
fn outcome(done: Result<Execution, Refusal>) -> String {
    match done {
        Err(refusal) => refusal.code().to_owned(),
        Ok(Execution { failure: None, .. }) => DONE.to_owned(),
        Ok(Execution { failure: Some(failure), .. }) => failure.code().to_owned(),
    }
}

#[cfg(test)]
mod tests;
