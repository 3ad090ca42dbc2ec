//! Targets of the gripper's servo, so that another simulator moves and presses alike.
//!
//! The simulated fingers have a speed and a force of their own. A position servo has neither: a target that jumps has
//! it slam the fingers shut. So the recorded target moves with the wanted speed, and stays as far before the fingers as
//! the servo's stiffness needs for the wanted force. Between closed pads, that is below an opening of 0.
//!
//! That target jumps by the lead where a grip ends, and leaves the range of the fingers where a thin object is pressed.
//! Beside it is a reference within their limits: it follows the target, but for what is below 0, with bounded velocity
//! and acceleration, and a moving average bounds its jerk as in [`robot::trajectory`].

use std::collections::VecDeque;

use robot::model::{Joint, JointLimits, Robot};

/// The share of the acceleration that references use: the step that arrives brakes by up to an eighth more.
const BRAKING_SHARE: f64 = 8.0 / 9.0;

/// The commanded opening over time.
#[derive(Clone, Debug)]
pub(crate) struct FingerCommand {
    goal_m: f64,
    target_m: f64,
    speed_m_s: f64,
    force_n: f64,
    max_opening_m: f64,
    /// Opening per position of the servo's joint, meters per unit of the joint.
    opening_per_position: f64,
    /// Difference between target and opening for each newton of each finger, meters.
    opening_per_n: f64,
    reference: Reference,
}

/// An opening that follows the target within the limits of the fingers.
#[derive(Clone, Debug)]
struct Reference {
    max_velocity_m_s: f64,
    max_acceleration_m_s2: f64,
    /// Over this time the jerk is bounded, seconds.
    window_s: f64,
    opening_m: f64,
    velocity_m_s: f64,
    /// The openings of the window, the latest last.
    recent_m: VecDeque<f64>,
}

impl Reference {
    fn resting(robot: &Robot, opening_m: f64) -> Self {
        let (gripper, opening_m) = (robot.gripper(), opening_m.max(0.0));
        let joint = robot.links()[gripper.link].joint.as_ref().and_then(Joint::moving);
        let limit = |of: fn(&JointLimits) -> f64| {
            joint.map_or(0.0, |joint| gripper.opening_per_position * of(&joint.limits))
        };
        let limit_m_s2 = limit(|limits| limits.max_acceleration);
        Self {
            max_velocity_m_s: limit(|limits| limits.max_velocity),
            max_acceleration_m_s2: BRAKING_SHARE * limit_m_s2,
            window_s: 2.0 * limit_m_s2 / limit(|limits| limits.max_jerk),
            opening_m,
            velocity_m_s: 0.0,
            recent_m: VecDeque::from([opening_m]),
        }
    }

    /// A step of time towards a target.
    fn follow(&mut self, target_m: f64, step_s: f64) {
        // Full after the first step, before which the fingers rest.
        self.recent_m.resize(((self.window_s / step_s).round() as usize).max(1), self.opening_m);
        let way_m = target_m - self.opening_m;
        let change_m_s = self.max_acceleration_m_s2 * step_s;
        // So many steps it takes to brake on the way that is left: they go k, k - 1, ..., 1 times the same way.
        let steps = 0.5 * ((1.0 + 8.0 * way_m.abs() / (change_m_s * step_s)).sqrt() - 1.0);
        let wanted_m_s = way_m.signum() * (steps * change_m_s).min(self.max_velocity_m_s);
        let velocity_m_s = wanted_m_s.clamp(self.velocity_m_s - change_m_s, self.velocity_m_s + change_m_s);
        let moved_m = velocity_m_s * step_s;
        let reaches = moved_m * way_m > 0.0 && moved_m.abs() >= way_m.abs();
        let next_m = if reaches { target_m } else { self.opening_m + moved_m };
        self.velocity_m_s = (next_m - self.opening_m) / step_s;
        self.opening_m = next_m;
        self.recent_m.push_back(next_m);
        self.recent_m.pop_front();
    }

    fn mean_m(&self) -> f64 {
        self.recent_m.iter().sum::<f64>() / self.recent_m.len() as f64
    }
}

impl FingerCommand {
    /// Of fingers that stay where they are.
    pub fn resting(robot: &Robot, opening_m: f64) -> Self {
        let gripper = robot.gripper();
        Self {
            goal_m: opening_m,
            target_m: opening_m,
            speed_m_s: 0.0,
            force_n: gripper.grip_force_n,
            max_opening_m: gripper.max_opening_m,
            opening_per_position: gripper.opening_per_position,
            opening_per_n: gripper.opening_per_position * robot.gripper_lead(1.0),
            reference: Reference::resting(robot, opening_m),
        }
    }

    /// Asks for an opening, at most so fast (each finger) and with so much force (of each finger). Fingers that are
    /// asked to close press whatever they meet, also what is so thin that they are all but closed.
    pub fn command(&mut self, opening_m: f64, speed_m_s: f64, force_n: f64) {
        (self.goal_m, self.speed_m_s, self.force_n) = (opening_m, speed_m_s, force_n);
    }

    /// A step of time with the pads `opening_m` apart.
    pub fn advance(&mut self, opening_m: f64, step_s: f64) {
        let way_m = self.opening_per_position * self.speed_m_s * step_s;
        let lead_m = self.force_n * self.opening_per_n;
        let goal_m = if self.goal_m > 0.0 { self.goal_m } else { -lead_m };
        let target_m = self.target_m.clamp(opening_m - lead_m, opening_m + lead_m);
        // Fingers that press start to move back as soon as they are asked to.
        let from_m = if goal_m > opening_m { target_m.max(opening_m) } else { target_m };
        let moved_m = from_m + (goal_m - from_m).clamp(-way_m, way_m);
        self.target_m =
            moved_m.clamp(opening_m - lead_m, opening_m + lead_m).clamp(-lead_m, self.max_opening_m);
        self.reference.follow(self.target_m.max(0.0), step_s);
    }

    /// Target distance of the pads from each other, meters; below 0 where thin objects are pressed.
    pub fn opening_target_m(&self) -> f64 {
        self.target_m
    }

    /// Target distance within the limits of the fingers, meters.
    pub fn opening_reference_m(&self) -> f64 {
        self.reference.mean_m()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const STEP_S: f64 = 0.01;

    #[test]
    fn targets_move_with_the_speed_and_lead_by_the_force() {
        let robot = Robot::built_in("panda", None).expect("the Panda");
        let mut fingers = FingerCommand::resting(&robot, 0.08);
        fingers.command(0.0, 0.05, 20.0);
        let mut opening_m: f64 = 0.08;
        for _ in 0..20 {
            fingers.advance(opening_m, STEP_S);
            let target_m = fingers.opening_target_m();
            assert!((target_m - (opening_m - 0.001)).abs() < 1e-9, "two fingers of 5 cm/s: {target_m}");
            opening_m = target_m;
        }
        // Something 6 cm wide stops them: 20 N each are 40 N of the servo, which pulls 4000 N/m.
        for _ in 0..100 {
            fingers.advance(0.06, STEP_S);
        }
        assert!((fingers.opening_target_m() - (0.06 - 2.0 * 40.0 / 4000.0)).abs() < 1e-9);
        fingers.command(0.08, 0.05, 40.0);
        fingers.advance(0.06, STEP_S);
        assert!((fingers.opening_target_m() - 0.061).abs() < 1e-9, "no press is left at once");
    }

    #[test]
    fn references_stay_within_the_limits_of_the_fingers_and_arrive() {
        const STEP_S: f64 = 0.002;
        for name in ["panda", "piper"] {
            let robot = Robot::built_in(name, None).expect("built in");
            let max_m = robot.gripper().max_opening_m;
            let mut fingers = FingerCommand::resting(&robot, max_m);
            let mut references_m = vec![fingers.opening_reference_m()];
            let mut opening_m = max_m;
            let mut jump_m: f64 = 0.0;
            // Closed on something 4 mm wide, held, and opened: the servo's target is below 0, and jumps back.
            for (goal_m, force_n, thickness_m) in [(0.0, 20.0, 0.004), (max_m, 40.0, 0.004)] {
                fingers.command(goal_m, 0.05, force_n);
                for _ in 0..1000 {
                    let before_m = fingers.opening_target_m();
                    fingers.advance(opening_m, STEP_S);
                    jump_m = jump_m.max((fingers.opening_target_m() - before_m).abs());
                    opening_m = fingers.opening_target_m().max(thickness_m);
                    references_m.push(fingers.opening_reference_m());
                }
                let asked_m = fingers.opening_target_m().max(0.0);
                let reference_m = fingers.opening_reference_m();
                assert!((reference_m - asked_m).abs() < 1e-9, "{name}: {reference_m}, not {asked_m}");
            }
            assert!(jump_m > 0.005, "the target has no jump: {jump_m}");
            assert!(
                references_m.iter().all(|reference_m| (0.0..=max_m + 1e-12).contains(reference_m)),
                "{name}"
            );
            let mut rates = references_m;
            for limit in [0.2, 2.0, 200.0] {
                rates = rates.windows(2).map(|pair| (pair[1] - pair[0]) / STEP_S).collect();
                let peak = rates.iter().fold(0.0, |peak: f64, rate| peak.max(rate.abs()));
                assert!(peak <= 2.0 * limit * 1.001, "{name}: {peak} for two fingers of {limit}");
            }
        }
    }

    #[test]
    fn thin_objects_are_pressed_with_the_full_force() {
        for (name, force_n) in [("panda", 40.0), ("piper", 20.0)] {
            let robot = Robot::built_in(name, None).expect("built in");
            let lead_m = robot.gripper().opening_per_position * robot.gripper_lead(force_n);
            assert!((lead_m - 2.0 * 2.0 * force_n / 4000.0).abs() < 1e-12, "two fingers, 4000 N/m: {lead_m}");
            let mut fingers = FingerCommand::resting(&robot, 0.02);
            fingers.command(0.0, 0.05, force_n);
            for thickness_m in [0.004, 0.0] {
                for _ in 0..100 {
                    fingers.advance(thickness_m, STEP_S);
                }
                let target_m = fingers.opening_target_m();
                assert!(
                    (target_m - (thickness_m - lead_m)).abs() < 1e-9,
                    "{name}, {thickness_m} m: {target_m}"
                );
            }
            fingers.command(0.03, 0.05, force_n);
            fingers.advance(0.004, STEP_S);
            assert!((fingers.opening_target_m() - 0.005).abs() < 1e-9, "{name}: no press is left at once");
        }
    }
}
