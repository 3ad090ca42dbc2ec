//! Plans in small worlds.

use nalgebra::{DMatrix, DVector, Isometry3, Point3, Translation3, Vector3};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use super::straight::{StraightOptions, ToolKinematics, approach, straight_by};
use super::*;
use crate::collision::tests::{random_positions, random_world, seven_joints};
use crate::collision::{Arm, Obstacle};

/// Configurations before and behind a wall.
const BEFORE: [f64; 7] = [-1.0, 0.8, 0.0, -1.4, 0.0, 2.2, 0.0];
const BEHIND: [f64; 7] = [1.0, 0.8, 0.0, -1.4, 0.0, 2.2, 0.0];

/// A wall along x that stands between the two; its height is what the arm must get over.
fn wall() -> Obstacle {
    Obstacle::cuboid(Isometry3::translation(0.55, 0.0, 0.2), Vector3::new(0.3, 0.02, 0.2)).expect("a wall")
}

fn plan_over_wall(seed: u64) -> (Arm, Plan) {
    let (arm, obstacles) = (seven_joints(), [wall()]);
    let goals = [BEHIND.to_vec()];
    let problem = Problem { arm: &arm, obstacles: &obstacles, start: &BEFORE, goals: &goals };
    let settings = PlanOptions { sample_order: SampleOrder::Shifted, ..PlanOptions::default() };
    let plan = plan(&problem, &settings, &mut ChaCha8Rng::seed_from_u64(seed)).expect("a plan");
    (arm, plan)
}

#[test]
fn a_path_leads_over_the_wall_and_is_free() {
    let (arm, plan) = plan_over_wall(1);
    assert_eq!(plan.path[0], BEFORE);
    assert_eq!(plan.path[plan.path.len() - 1], BEHIND);
    assert!(plan.path.len() > 2 && plan.length <= plan.found_length + 1e-4, "{plan:?}");
    // Between its points an edge may graze what its points miss, by less than the arm moves from one to the next.
    assert_eq!(arm.certify_path(&plan.path, &[wall()], -0.01, 1e-3), Ok(()));
}

#[test]
fn equal_random_numbers_give_equal_plans_and_others_give_others() {
    assert_eq!(plan_over_wall(2).1, plan_over_wall(2).1);
    assert_ne!(plan_over_wall(2).1, plan_over_wall(3).1);
}

#[test]
fn random_worlds_are_solved_with_free_paths() {
    let mut rng = ChaCha8Rng::seed_from_u64(7);
    let arm = seven_joints();
    let (mut solved, mut unsolved) = (0, 0);
    for _ in 0..60 {
        let obstacles = random_world(&mut rng, 5);
        let (start, goal) = (random_positions(&mut rng, &arm), random_positions(&mut rng, &arm));
        let goals = [goal];
        let problem = Problem { arm: &arm, obstacles: &obstacles, start: &start, goals: &goals };
        let settings = PlanOptions { padding_m: 0.01, max_samples: 2000, ..PlanOptions::default() };
        match plan(&problem, &settings, &mut rng) {
            Ok(plan) => {
                solved += 1;
                assert_eq!(arm.certify_path(&plan.path, &obstacles, 0.0, 1e-4), Ok(()));
            }
            Err(PlanFailure::StartInCollision { .. } | PlanFailure::GoalInCollision { .. }) => {}
            // Some goals are shut in.
            Err(PlanFailure::NoPath { .. }) => unsolved += 1,
            Err(failure) => panic!("{failure}"),
        }
    }
    assert!(solved > 5 && unsolved < solved, "{solved} solved, {unsolved} not");
}

#[test]
fn each_failure_has_its_reason() {
    let arm = seven_joints();
    let inside = |positions: &[f64]| {
        let tip = arm.frames(positions)[7] * Point3::new(0.0, 0.0, 0.1);
        [Obstacle::sphere(tip, 0.05).expect("a sphere")]
    };
    let code = |obstacles: &[Obstacle], start: &[f64], goals: &[Vec<f64>], settings: &PlanOptions| {
        let problem = Problem { arm: &arm, obstacles, start, goals };
        plan(&problem, settings, &mut ChaCha8Rng::seed_from_u64(1)).map_err(|failure| failure.code())
    };
    let settings = PlanOptions::default();
    let goals = [BEHIND.to_vec()];
    let mut bent = BEFORE;
    bent[3] = 3.0;
    assert_eq!(code(&[], &BEFORE[..6], &goals, &settings), Err("wrong_length"));
    assert_eq!(code(&[], &bent, &goals, &settings), Err("start_outside_limits"));
    assert_eq!(code(&inside(&BEFORE), &BEFORE, &goals, &settings), Err("start_in_collision"));
    assert_eq!(code(&[], &BEFORE, &[], &settings), Err("goal_unreachable"));
    assert_eq!(code(&[], &BEFORE, &[bent.to_vec()], &settings), Err("goal_outside_limits"));
    assert_eq!(code(&inside(&BEHIND), &BEFORE, &goals, &settings), Err("goal_in_collision"));
    let few = PlanOptions { max_samples: 3, ..settings.clone() };
    let high = [Obstacle::cuboid(Isometry3::translation(0.65, 0.0, 0.7), Vector3::new(0.5, 0.02, 0.7))
        .expect("a wall")];
    assert_eq!(code(&high, &BEFORE, &goals, &few), Err("no_path"));
    // One goal that can be reached is enough.
    assert!(code(&[], &BEFORE, &[bent.to_vec(), BEHIND.to_vec()], &settings).is_ok());
}

#[test]
fn every_operation_keeps_a_path_free_and_makes_it_no_longer() {
    let (arm, obstacles) = (seven_joints(), [wall()]);
    let goals = [BEHIND.to_vec()];
    let problem = Problem { arm: &arm, obstacles: &obstacles, start: &BEFORE, goals: &goals };
    let mut settings = PlanOptions { sample_order: SampleOrder::Shifted, ..PlanOptions::default() };
    (settings.simplify.reduce_attempts, settings.simplify.perturb_attempts) = (10, 10);
    for seed in 0..20 {
        let plan = plan(&problem, &settings, &mut ChaCha8Rng::seed_from_u64(seed)).expect("a plan");
        assert!(plan.length <= plan.found_length + 1e-4);
        assert_eq!(arm.certify_path(&plan.path, &obstacles, -0.01, 1e-3), Ok(()));
    }
}

/// Newton's steps with a damped inverse of a numeric Jacobian; enough to try straight motions with.
struct Numeric<'a>(&'a Arm);

impl Numeric<'_> {
    /// The way that is left to a pose: translation, then rotation.
    fn gap(&self, wanted: &Isometry3<f64>, positions: &[f64]) -> DVector<f64> {
        let now = self.base_from_tool(positions);
        let turn = (wanted.rotation * now.rotation.inverse()).scaled_axis();
        let move_m = wanted.translation.vector - now.translation.vector;
        DVector::from_iterator(6, move_m.iter().chain(turn.iter()).copied())
    }
}

impl ToolKinematics for Numeric<'_> {
    fn base_from_tool(&self, positions: &[f64]) -> Isometry3<f64> {
        self.0.frames(positions)[7] * Translation3::new(0.0, 0.0, 0.2)
    }

    fn solve_near(&self, wanted: &Isometry3<f64>, near: &[f64]) -> Option<Vec<f64>> {
        let mut positions = near.to_vec();
        for _ in 0..50 {
            let gap = self.gap(wanted, &positions);
            if gap.norm() < 1e-8 {
                return Some(positions);
            }
            let column = |joint: usize| {
                let mut moved = positions.clone();
                moved[joint] += 1e-6;
                (&gap - self.gap(wanted, &moved)) / 1e-6
            };
            let jacobian = DMatrix::from_columns(&(0..7).map(column).collect::<Vec<_>>());
            let damped = &jacobian * jacobian.transpose() + DMatrix::identity(6, 6) * 1e-6;
            let step = jacobian.transpose() * damped.lu().solve(&gap)?;
            positions.iter_mut().zip(step.iter()).for_each(|(position, change)| *position += change);
        }
        None
    }
}

#[test]
fn the_tool_moves_straight_up_and_back_along_its_axis() {
    let arm = seven_joints();
    let planner = Planner::new(&arm, &[], PlanOptions::default());
    let kinematics = Numeric(&arm);
    let settings = StraightOptions::default();
    let begin = kinematics.base_from_tool(&BEFORE);
    let lift =
        straight_by(&planner, &kinematics, &BEFORE, Vector3::new(0.0, 0.0, 0.1), &settings).expect("a lift");
    assert_eq!(lift.len(), 21);
    for ends in lift.windows(2) {
        let midpoint: Vec<f64> = ends[0].iter().zip(&ends[1]).map(|(a, b)| 0.5 * (a + b)).collect();
        let off = kinematics.base_from_tool(&midpoint).translation.vector - begin.translation.vector;
        assert!(off.xy().norm() < 1e-4 && (0.0..0.1).contains(&off.z), "{off}");
    }
    let path = approach(&planner, &kinematics, &BEFORE, 0.08, &settings).expect("an approach");
    assert_eq!(path[path.len() - 1], BEFORE);
    let way =
        begin.inverse_transform_point(&Point3::from(kinematics.base_from_tool(&path[0]).translation.vector));
    assert!((way.coords - Vector3::new(0.0, 0.0, -0.08)).norm() < 1e-6, "{way}");
}

#[test]
fn a_straight_motion_says_what_stops_it() {
    let arm = seven_joints();
    let kinematics = Numeric(&arm);
    let settings = StraightOptions::default();
    let begin = kinematics.base_from_tool(&BEFORE).translation.vector;
    let ceiling = Obstacle::cuboid(
        Isometry3::translation(begin.x, begin.y, begin.z + 0.9),
        Vector3::new(0.5, 0.5, 0.35),
    );
    let obstacles = [ceiling.expect("a ceiling")];
    let code = |obstacles: &[Obstacle], offset_m: Vector3<f64>| {
        let planner = Planner::new(&arm, obstacles, PlanOptions::default());
        straight_by(&planner, &kinematics, &BEFORE, offset_m, &settings).map_err(|failure| failure.code())
    };
    assert_eq!(code(&obstacles, Vector3::new(0.0, 0.0, 0.5)), Err("straight_motion_collision"));
    let far = code(&[], Vector3::new(0.0, 0.0, 2.0)).expect_err("out of reach");
    assert!(far.starts_with("straight_motion_"), "{far}");
}
