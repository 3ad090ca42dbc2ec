//! Properties of proposed tasks in made scenes.

use std::collections::BTreeSet;

use crate::made_scene::made_scene;
use tasks::evaluation::{Situation, evaluate};
use tasks::goal::formula;
use tasks::validation::end_state;
use tasks::{Goal, PredicateKind, ProposalKind, RobotLimits, TaskScene, propose, validate};

fn robot() -> RobotLimits {
    RobotLimits::new("panda", 0.08, 0.005, 3.0)
}

fn goal_of(text: &str, scene: &TaskScene) -> Option<Goal> {
    tasks::text::goal(text, scene).ok()
}

#[test]
fn proposals_are_open_and_reachable() {
    let (scene, robot) = (made_scene(), robot());
    for seed in 0..3 {
        for proposal in propose(&scene, 18, seed, &robot) {
            let goal = &proposal.task.goal;
            let situation = scene.situation();
            assert!(!evaluate(goal, &situation).iter().all(|outcome| outcome.holds), "{goal:?}");
            assert_eq!(validate(&proposal.task, &scene, std::slice::from_ref(&robot)), Ok(()));
            // Independent of the search: the state that it found satisfies the goal, lifts aside.
            let end = end_state(goal, &scene).expect("a free place");
            let reached = Situation { now: &end, ..situation };
            for outcome in evaluate(goal, &reached) {
                let lifted = outcome.predicate.predicate == PredicateKind::Lifted;
                assert!(outcome.holds || lifted, "{outcome:?}");
            }
        }
    }
}

#[test]
fn default_wordings_are_read_as_the_same_goals() {
    let scene = made_scene();
    let (mut total, mut wrong) = (0, Vec::new());
    for seed in 0..4 {
        for proposal in propose(&scene, 27, seed, &robot()) {
            total += 1;
            let read = goal_of(&proposal.wordings.default, &scene);
            if read.as_ref() != Some(&proposal.task.goal) {
                let formulas = read.map(|goal| goal.predicates().iter().map(formula).collect::<Vec<_>>());
                wrong.push(format!("{:?}: {formulas:?}", proposal.wordings.default));
            }
        }
    }
    assert!(total >= 80, "{total} proposals");
    assert!(wrong.len() * 20 <= total, "{} of {total}\n{}", wrong.len(), wrong.join("\n"));
}

#[test]
fn proposals_are_diverse_and_repeat() {
    let (scene, robot) = (made_scene(), robot());
    let proposed = propose(&scene, 9, 5, &robot);
    assert_eq!(proposed, propose(&scene, 9, 5, &robot));
    assert_ne!(proposed, propose(&scene, 9, 6, &robot));
    let kinds: BTreeSet<ProposalKind> = proposed.iter().map(|proposal| proposal.kind).collect();
    assert_eq!(kinds.len(), 9, "{kinds:?}");
    let goals: BTreeSet<String> =
        proposed.iter().map(|proposal| format!("{:?}", proposal.task.goal)).collect();
    assert_eq!(goals.len(), 9);
}

#[test]
fn difficulty_grows_with_steps() {
    let proposed = propose(&made_scene(), 27, 5, &robot());
    let mean = |kind: ProposalKind| {
        let of_kind: Vec<f64> = proposed
            .iter()
            .filter(|proposal| proposal.kind == kind)
            .map(|proposal| proposal.difficulty.overall)
            .collect();
        of_kind.iter().sum::<f64>() / of_kind.len() as f64
    };
    assert!(proposed.iter().all(|proposal| (0.0..=1.0).contains(&proposal.difficulty.overall)));
    assert!(mean(ProposalKind::Lift) < mean(ProposalKind::TwoSteps));
    assert!(mean(ProposalKind::NextTo) < mean(ProposalKind::Swap));
}
