//! Planned motions in the simulated world, with a record.

use geometry::{DVec3, Pose};
use robot::trajectory::Trajectory;

use super::fingers::FingerCommand;
use super::motions::Motions;
use super::record::{Frame, Phase, Recording};
use crate::grasp::gripper_joint;
use crate::world::ManipulationWorld;

/// The table is the first body of the world.
const FIRST_OBJECT: usize = 1;
/// The servos take up the weight of an object in this time, seconds.
const LOAD_S: f64 = 0.2;

/// A world in which motions are made one after the other.
pub(crate) struct Runner<'a> {
    pub world: ManipulationWorld,
    pub recording: Recording,
    motions: &'a Motions<'a>,
    /// Last commanded positions of the arm's joints.
    pub commanded: Vec<f64>,
    /// Planned positions of the arm's joints at the last two times of the world.
    planned: [Vec<f64>; 2],
    fingers: FingerCommand,
    /// Mass and center of mass in the tool's frame of what is held, and the share of it that the servos carry now.
    load: Option<(f64, DVec3)>,
    load_share: f64,
    phase: Phase,
}

impl<'a> Runner<'a> {
    pub fn new(world: ManipulationWorld, motions: &'a Motions<'a>, rate_hz: f64) -> Self {
        let joint =
            |link: &usize| motions.robot.links()[*link].joint.as_ref().map(|joint| joint.name.clone());
        let joints = motions.robot.arm_links().iter().filter_map(joint).collect();
        let gripper_joint = gripper_joint(motions.robot).to_owned();
        let objects = motions.scene.objects.iter().map(|object| object.name.clone()).collect();
        Self {
            commanded: world.joint_positions(),
            planned: [world.joint_positions(), world.joint_positions()],
            fingers: FingerCommand::resting(motions.robot, world.opening_m()),
            recording: Recording { rate_hz, joints, gripper_joint, objects, frames: Vec::new() },
            load: None,
            load_share: 0.0,
            phase: Phase::Transit,
            motions,
            world,
        }
    }

    /// The poses of the objects now.
    pub fn poses(&self) -> Vec<Pose> {
        self.world.object_poses().split_off(FIRST_OBJECT)
    }

    /// Whether all fingers press on an object with at least `force_n`.
    pub fn holds(&self, object: usize, force_n: f64) -> bool {
        self.world.finger_forces(FIRST_OBJECT + object).hold(force_n)
    }

    /// `tool_from_object`.
    pub fn in_hand(&self, object: usize) -> Pose {
        self.world.tool_pose().inverse() * self.world.object_pose(FIRST_OBJECT + object)
    }

    /// The object whose weight the servos carry from now on, softly, or none.
    pub fn set_load(&mut self, object: Option<usize>) {
        self.load_share = 0.0;
        self.load = object.map(|object| {
            let mass = &self.motions.scene.objects[object].mass;
            (mass.mass_kg, self.in_hand(object).transform_point(mass.center_of_mass_m))
        });
    }

    /// Moves along a trajectory.
    pub fn follow(&mut self, phase: Phase, trajectory: &Trajectory) {
        self.phase = phase;
        let step_s = 1.0 / self.world.options().steps_per_s;
        let steps = (trajectory.duration_s() / step_s).ceil() as usize;
        for step in 1..=steps {
            let point = trajectory.at(step as f64 * step_s);
            self.step(&point.position, &point.velocity);
        }
        let end = trajectory.at(trajectory.duration_s()).position;
        self.commanded = end;
    }

    /// Moves the fingers, and waits until they have had the time for it and `settle_s` more.
    pub fn move_fingers(&mut self, phase: Phase, opening_m: f64, speed_m_s: f64, force_n: f64, wait_s: f64) {
        self.phase = phase;
        self.fingers.command(opening_m, speed_m_s, force_n);
        self.world.set_gripper(opening_m, speed_m_s, force_n);
        self.wait(phase, wait_s);
    }

    /// Waits until all fingers press on an object with at least `force_n`, or for `max_s`.
    pub fn wait_for_hold(&mut self, object: usize, force_n: f64, max_s: f64) {
        const STEP_S: f64 = 0.01;
        let mut waited_s = 0.0;
        while waited_s < max_s && !self.holds(object, force_n) {
            self.wait(self.phase, STEP_S);
            waited_s += STEP_S;
        }
    }

    /// Stays where the arm is.
    pub fn wait(&mut self, phase: Phase, duration_s: f64) {
        self.phase = phase;
        let steps = (duration_s * self.world.options().steps_per_s).round() as usize;
        let (at, rest) = (self.commanded.clone(), vec![0.0; self.commanded.len()]);
        for _ in 0..steps {
            self.step(&at, &rest);
        }
    }

    /// The greatest speed of any point of an object, roughly: of its center, and of a point 5 cm from it.
    pub fn fastest_m_s(&self) -> f64 {
        let objects = FIRST_OBJECT..FIRST_OBJECT + self.motions.scene.objects.len();
        let speed = |object: usize| {
            let (linear, angular) = self.world.object_velocity(object);
            linear.length() + 0.05 * angular.length()
        };
        objects.map(speed).fold(0.0, f64::max)
    }

    fn step(&mut self, positions: &[f64], velocities: &[f64]) {
        self.load_share = (self.load_share + 1.0 / (LOAD_S * self.world.options().steps_per_s)).min(1.0);
        let lead = match self.load {
            Some((mass_kg, center)) => self.motions.lead(positions, self.load_share * mass_kg, center),
            None => vec![0.0; positions.len()],
        };
        let targets: Vec<f64> = positions.iter().zip(&lead).map(|(q, lead)| q + lead).collect();
        self.fingers.advance(self.world.opening_m(), 1.0 / self.world.options().steps_per_s);
        self.record(&targets, velocities);
        self.world.set_joint_targets(&targets, velocities);
        self.world.step();
        self.planned.rotate_left(1);
        self.planned[1] = positions.to_vec();
    }

    /// Adds a frame where one is due.
    fn record(&mut self, targets: &[f64], velocities: &[f64]) {
        let due_s = self.recording.frames.len() as f64 / self.recording.rate_hz;
        if self.world.time_s() + 1e-9 < due_s {
            return;
        }
        let servos = self.motions.robot.arm_joints().zip(targets).zip(velocities);
        let joint_targets =
            servos.map(|((joint, q), v)| q + v * joint.drive.damping / joint.drive.stiffness).collect();
        // The step that is due may be up to one late, which differences of the references would show.
        let late = (self.world.time_s() - due_s).max(0.0) * self.world.options().steps_per_s;
        let [before, now] = &self.planned;
        let joint_references =
            before.iter().zip(now).map(|(before, now)| now + late * (before - now)).collect();
        self.recording.frames.push(Frame {
            time_s: self.world.time_s(),
            phase: self.phase,
            joint_targets,
            joint_references,
            joint_positions: self.world.joint_positions(),
            joint_velocities: self.world.joint_velocities(),
            opening_target_m: self.fingers.opening_target_m(),
            opening_reference_m: self.fingers.opening_reference_m(),
            opening_m: self.world.opening_m(),
            gripper_target: self.motions.robot.gripper_position(self.fingers.opening_target_m()),
            object_poses: self.poses_nearest_to_the_last(),
        });
    }

    /// The poses of the objects now, each rotation in the form that is nearer to that of the last frame.
    fn poses_nearest_to_the_last(&self) -> Vec<Pose> {
        let mut poses = self.poses();
        let last = self.recording.frames.last().map(|frame| &frame.object_poses);
        for (pose, last) in poses.iter_mut().zip(last.into_iter().flatten()) {
            if pose.rotation.dot(last.rotation) < 0.0 {
                pose.rotation = -pose.rotation;
            }
        }
        poses
    }
}
