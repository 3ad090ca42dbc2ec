//! What the servo of the gripper is asked for, so that another simulator moves and presses alike.
//!
//! The simulated fingers have a speed and a force of their own. A position servo has neither: a target that jumps has
//! it slam the fingers shut. So the recorded target moves with the wanted speed, and stays as far before the fingers as
//! the servo's stiffness needs for the wanted force. Between closed pads, that is below an opening of 0.

use robot::model::Robot;

/// The commanded opening over time.
#[derive(Clone, Debug)]
pub(crate) struct FingerCommand {
    goal_m: f64,
    target_m: f64,
    speed_m_s: f64,
    force_n: f64,
    max_opening_m: f64,
    /// How the opening follows the position of the servo's joint.
    opening_per_position: f64,
    /// By how much the target and the opening differ for each newton of each finger.
    opening_per_n: f64,
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
    }

    /// What the pads are asked to be apart; below 0 where thin objects are pressed.
    pub fn opening_target_m(&self) -> f64 {
        self.target_m
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
