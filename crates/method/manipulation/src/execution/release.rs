//! Motion of an object after the hand lets it go, simulated without the arm.
//!
//! Where an object rests by geometry alone it may still roll off, or tip the bowl that it was leaned into.

use std::cell::RefCell;

use geometry::collision_shape::CollisionShape;
use geometry::{DVec3, Pose};
use physics::settle::settle;
use physics::{Body, SettleSettings};
use runtime::CancelFlag;
use tasks::{GoalPredicate, PosedObject, Situation, evaluation::evaluate_predicate};

use super::scene::{Shapes, TaskScene};

/// Objects farther than this from the place, meters, have no part in what happens there.
const REACH_M: f64 = 0.05;

/// The most releases that are simulated in one situation.
const MAX_TRIALS: usize = 96;

/// Two seconds are enough to roll off or to tip; contacts are those of the settings for settling.
const SETTLING: SettleSettings = SettleSettings {
    duration_s: 2.0,
    steps_per_s: 240.0,
    solver_iterations: 8,
    contact_frequency_hz: 350.0,
    length_unit_m: 0.02,
    damping_per_s: 0.05,
    rest_speed_m_s: 0.003,
    rest_time_s: 0.2,
};

/// Tries of one object in one situation; each pose is simulated once.
pub(crate) struct ReleaseTrials<'a> {
    scene: &'a TaskScene,
    shapes: &'a Shapes,
    start: &'a [PosedObject],
    /// Of all objects before the release.
    poses: &'a [Pose],
    object: usize,
    /// Predicates that have to hold afterward.
    predicates: Vec<&'a GoalPredicate>,
    known: RefCell<Vec<(Pose, bool)>>,
}

impl<'a> ReleaseTrials<'a> {
    /// `predicates` is what the release shall bring about, `kept` what it must not undo. Without predicates every
    /// release is as good as any other.
    pub fn new(
        scene: &'a TaskScene,
        shapes: &'a Shapes,
        start: &'a [PosedObject],
        poses: &'a [Pose],
        object: usize,
        predicates: &'a [GoalPredicate],
        kept: &'a [GoalPredicate],
    ) -> Self {
        let kept = if predicates.is_empty() { &[] } else { kept };
        let predicates = predicates.iter().chain(kept).collect();
        Self { scene, shapes, start, poses, object, predicates, known: RefCell::default() }
    }

    /// Whether the predicates hold once the object, let go in a pose, and everything near it have come to rest; false
    /// for poses beyond the most that are simulated.
    pub fn succeeds(&self, released: &Pose) -> bool {
        if self.predicates.is_empty() {
            return true;
        }
        if let Some((_, succeeds)) = self.known.borrow().iter().find(|(pose, _)| pose == released) {
            return *succeeds;
        }
        if self.known.borrow().len() >= MAX_TRIALS {
            return false;
        }
        let succeeds = self.simulated(released);
        self.known.borrow_mut().push((*released, succeeds));
        succeeds
    }

    fn simulated(&self, released: &Pose) -> bool {
        let mut poses = self.poses.to_vec();
        poses[self.object] = *released;
        let near = self.near(&poses);
        let mut bodies = vec![Body { fixed: true, ..self.scene.table.clone() }];
        bodies.extend(
            near.iter()
                .map(|index| Body { world_from_object: poses[*index], ..self.scene.objects[*index].clone() }),
        );
        // What cannot be simulated is no worse than without a trial.
        let Ok(settled) = settle(&bodies, &SETTLING, &CancelFlag::default()) else { return true };
        for (index, pose) in near.iter().zip(&settled.poses[1..]) {
            poses[*index] = *pose;
        }
        let now = self.shapes.posed(&poses);
        let situation = Situation { table: &self.scene.outline, start: self.start, now: &now, contacts: &[] };
        self.predicates.iter().all(|predicate| evaluate_predicate(predicate, &situation).holds)
    }

    /// The object, what the predicates name, and what is close to any of these.
    fn near(&self, poses: &[Pose]) -> Vec<usize> {
        let is_named = |index: usize| {
            let name = &self.shapes.names[index];
            self.predicates.iter().any(|predicate| {
                predicate.target.iter().chain(&predicate.second_target).any(|target| target == name)
            })
        };
        let boxes: Vec<(DVec3, DVec3)> = (0..poses.len())
            .map(|index| {
                let shape: &CollisionShape = self.shapes.shapes[index].collision();
                shape.bounds(&poses[index])
            })
            .collect();
        let is_close = |a: usize, b: usize| {
            (boxes[a].0 - boxes[b].1).max(boxes[b].0 - boxes[a].1).max_element() < REACH_M
        };
        let core: Vec<usize> =
            (0..poses.len()).filter(|index| *index == self.object || is_named(*index)).collect();
        (0..poses.len()).filter(|index| core.iter().any(|member| is_close(*index, *member))).collect()
    }
}

#[cfg(test)]
mod tests {
    use geometry::shapes::block;
    use geometry::{DVec2, Outline};
    use tasks::Goal;

    use super::*;
    use crate::test_scenes::box_body;

    /// A post 6 cm wide with a bar of 20 cm beside it.
    fn scene() -> TaskScene {
        let corners = [(-0.6, -0.4), (0.6, -0.4), (0.6, 0.4), (-0.6, 0.4)].map(DVec2::from);
        let top = block(DVec3::new(1.2, 0.8, 0.03)).translated(DVec3::new(0.0, 0.0, -0.03));
        let post = block(DVec3::new(0.06, 0.06, 0.05));
        let bar = block(DVec3::new(0.2, 0.03, 0.03));
        TaskScene {
            table: Body { fixed: true, ..box_body("table", top, 10.0, Pose::IDENTITY) },
            outline: Outline::new(corners.to_vec()).expect("a rectangle"),
            objects: vec![
                box_body("post_1", post, 0.5, Pose::IDENTITY),
                box_body("bar_1", bar, 0.2, Pose::upright(DVec3::new(0.0, 0.3, 0.0), 0.0)),
            ],
        }
    }

    #[test]
    fn a_bar_stays_on_a_post_where_its_center_is_over_it_and_tips_off_elsewhere() {
        let scene = scene();
        let shapes = Shapes::new(&scene).expect("boxes");
        let (poses, goal) =
            (scene.poses(), r#"[{"predicate": "on", "object": "bar_1", "target": "post_1"}]"#);
        let start = shapes.posed(&poses);
        let goal: Goal = serde_json::from_str(goal).expect("a goal");
        let wanted = goal.predicates().to_vec();
        let trials = ReleaseTrials::new(&scene, &shapes, &start, &poses, 1, &wanted, &[]);
        for (x_m, stays) in [(0.0, true), (0.02, true), (0.05, false), (-0.05, false)] {
            let released = Pose::upright(DVec3::new(x_m, 0.0, 0.052), 0.0);
            assert_eq!(trials.succeeds(&released), stays, "{x_m} m");
        }
        let free = ReleaseTrials::new(&scene, &shapes, &start, &poses, 1, &[], &wanted);
        assert!(free.succeeds(&Pose::upright(DVec3::new(0.05, 0.0, 0.052), 0.0)));
    }
}
