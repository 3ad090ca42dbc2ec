//! Further candidates, and the order of their trials.

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use robot::model::Robot;

use super::*;
use crate::grasp::antipodal::candidates;
use crate::test_scenes::{block, box_body};

fn few() -> GraspSettings {
    GraspSettings { surface_points: 100, ..test_settings::section("grasps") }
}

fn more() -> Vec<Candidate> {
    let object = box_body("box", block(DVec3::new(0.04, 0.06, 0.12)), 0.2, Pose::IDENTITY);
    let hand = HandShape::new(&Robot::built_in("panda", None).expect("built in"));
    more_candidates(&object, &hand, &few(), &mut ChaCha8Rng::seed_from_u64(3))
}

fn dropped(candidate: &Candidate) -> Grasp {
    let grasp = crate::grasp::untested(candidate, 40.0);
    Grasp { verdict: Verdict::Dropped, ..grasp }
}

#[test]
fn the_second_search_finds_what_the_first_does_not() {
    let object = box_body("box", block(DVec3::new(0.04, 0.06, 0.12)), 0.2, Pose::IDENTITY);
    let hand = HandShape::new(&Robot::built_in("panda", None).expect("built in"));
    let first = candidates(&object, &hand, &few(), &mut ChaCha8Rng::seed_from_u64(3));
    let more = more();
    assert!(more.len() > first.len(), "{} after {}", more.len(), first.len());
    assert_eq!(more, super::tests::more());
}

#[test]
fn tilted_lines_are_within_the_cone() {
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    for _ in 0..100 {
        let line = tilted(DVec3::X, 0.5, &mut rng);
        assert!(line.is_normalized() && line.angle_between(DVec3::X) < 0.5 + 1e-9, "{line}");
    }
}

#[test]
fn where_a_hand_failed_another_place_is_tried() {
    let candidates = more();
    let mut experience = Experience::default();
    let best = experience.take_best(&mut candidates.clone()).expect("a candidate");
    experience.add(&dropped(&best), &few());
    let other = experience.take_best(&mut candidates.clone()).expect("another");
    assert!(nearness(&best.object_from_tool, &other) < 0.9, "{best:?} {other:?}");
    // What almost held is worth another try nearby.
    let mut experience = Experience::default();
    let almost = Grasp { verdict: Verdict::Slipped, slip_m: 2.0 * few().trial.max_slip_m, ..dropped(&other) };
    experience.add(&almost, &few());
    assert!(excess(&almost, &few()) < ALMOST);
    let near = experience.take_best(&mut candidates.clone()).expect("another");
    assert!(nearness(&almost.object_from_tool, &near) > nearness(&almost.object_from_tool, &best) - 1e-12);
}
