//! Proposals of feasible tasks, by rules over affordances and shapes.
//!
//! What a robot can grasp and lift, and nothing rests on, may be moved: into containers, onto supports and stacks,
//! beside others, to another's place, or up. Each proposal passes [`crate::validate`]: its goal is not reached yet, and
//! there is a free place for it, with ample space. Kinds take turns, and objects that few proposals have come first, so
//! that a few proposals differ. The same scene, seed and robot give the same proposals. Up to half a second per
//! proposal.

mod candidates;
mod difficulty;
mod references;
mod wordings;

use std::collections::BTreeMap;

use rand::seq::SliceRandom;
use scene::InstanceId;
use scene::text_account::GoalPredicate;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use self::candidates::{Candidate, candidates, pairs};
pub use self::difficulty::Difficulty;
pub use self::wordings::Wordings;
use crate::goal::Goal;
use crate::robot_limits::RobotLimits;
use crate::task::Task;
use crate::task_scene::TaskScene;
use crate::validation::{is_spacious, validate_spacious};
use runtime::seed::child_rng;

/// Candidates of one kind that are tried in one turn.
const MAX_TRIES: usize = 12;

/// Kind of a proposed task.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum ProposalKind {
    In,
    On,
    Stack,
    NextTo,
    LeftOf,
    RightOf,
    Swap,
    Lift,
    TwoSteps,
}

impl ProposalKind {
    /// In the order of their turns.
    pub const ALL: [Self; 9] = [
        Self::In,
        Self::On,
        Self::NextTo,
        Self::TwoSteps,
        Self::Stack,
        Self::LeftOf,
        Self::Swap,
        Self::RightOf,
        Self::Lift,
    ];
}

/// A proposed task.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(description = "A feasible task by rules over shapes and affordances.")]
pub struct ProposedTask {
    pub kind: ProposalKind,
    /// With the default wording as its instruction.
    pub task: Task,
    pub wordings: Wordings,
    pub difficulty: Difficulty,
}

/// Up to `count` tasks for a robot; fewer where the scene has no more.
pub fn propose(scene: &TaskScene, count: usize, seed: u64, robot: &RobotLimits) -> Vec<ProposedTask> {
    propose_if(scene, count, seed, robot, &mut |_| true)
}

/// As [`propose`], of the tasks that pass one more check, such as a rehearsal of the arm's motions. It is asked last,
/// once for each task.
pub fn propose_if(
    scene: &TaskScene,
    count: usize,
    seed: u64,
    robot: &RobotLimits,
    can_be_done: &mut dyn FnMut(&Task) -> bool,
) -> Vec<ProposedTask> {
    let mut rng = child_rng(seed, "proposals");
    let mut pool: BTreeMap<ProposalKind, Vec<Candidate>> = BTreeMap::new();
    for candidate in candidates(scene, robot) {
        pool.entry(candidate.kind).or_default().push(candidate);
    }
    for list in pool.values_mut() {
        list.shuffle(&mut rng);
    }
    let two_steps = pairs(&pool, &mut rng);
    pool.insert(ProposalKind::TwoSteps, two_steps);
    let mut uses: BTreeMap<InstanceId, usize> = BTreeMap::new();
    let mut infeasible: Vec<GoalPredicate> = Vec::new();
    let mut proposed = Vec::new();
    let mut idle_turns = 0;
    for kind in ProposalKind::ALL.into_iter().cycle() {
        if proposed.len() >= count || idle_turns >= ProposalKind::ALL.len() {
            break;
        }
        let list = pool.get_mut(&kind);
        let found =
            list.and_then(|list| next_feasible(list, &uses, &mut infeasible, scene, robot, can_be_done));
        idle_turns = if found.is_some() { 0 } else { idle_turns + 1 };
        if let Some(proposal) = found {
            for name in proposal.task.goal.named_objects() {
                *uses.entry(name.clone()).or_default() += 1;
            }
            proposed.push(proposal);
        }
    }
    proposed
}

/// Takes the first feasible candidate from a list, those with the least used objects first. Goals of one step that are
/// not feasible are noted, and goals of two steps with one of these are left out.
fn next_feasible(
    list: &mut Vec<Candidate>,
    uses: &BTreeMap<InstanceId, usize>,
    infeasible: &mut Vec<GoalPredicate>,
    scene: &TaskScene,
    robot: &RobotLimits,
    can_be_done: &mut dyn FnMut(&Task) -> bool,
) -> Option<ProposedTask> {
    let used = |goal: &Goal| -> usize {
        goal.named_objects().into_iter().map(|name| uses.get(name).copied().unwrap_or_default()).sum()
    };
    list.retain(|candidate| !candidate.goal.predicates().iter().any(|step| infeasible.contains(step)));
    list.sort_by_key(|candidate| used(&candidate.goal));
    let mut tries = 0;
    while tries < MAX_TRIES && !list.is_empty() {
        let candidate = list.remove(0);
        if candidate.goal.predicates().iter().any(|step| infeasible.contains(step)) {
            continue;
        }
        tries += 1;
        let steps: Vec<Goal> =
            candidate.goal.predicates().iter().filter_map(|step| Goal::new([step.clone()]).ok()).collect();
        match proposal(candidate, scene, robot).filter(|found| can_be_done(&found.task)) {
            Some(proposal) => return Some(proposal),
            // Of two steps, the first one that fails alone is at fault.
            None => {
                let failed = steps.iter().find(|step| steps.len() == 1 || !is_spacious(step, scene));
                infeasible.extend(failed.into_iter().flat_map(|step| step.predicates().to_vec()));
            }
        }
    }
    None
}

/// The proposal of a candidate that is feasible.
fn proposal(candidate: Candidate, scene: &TaskScene, robot: &RobotLimits) -> Option<ProposedTask> {
    let difficulty = Difficulty::of(&candidate.goal, scene);
    let wordings = Wordings::of(&candidate, scene)?;
    let task = Task::new(wordings.default.clone(), candidate.goal, &*robot.name);
    validate_spacious(&task, scene, robot).ok()?;
    Some(ProposedTask { kind: candidate.kind, task, wordings, difficulty })
}
