//! Simulations of a heap.

use super::{ClutterError, Heap};
use crate::Body;
use crate::settle::{SettleSettings, SettledPoses, settle_together, simulate_to_the_end};
use geometry::Pose;

/// Longest simulated time of the fall of a group, seconds.
const FALL_S: f64 = 0.7;

/// Speed below which a group has fallen: the next one lands on it soon, and at last all come to rest together.
const FALLEN_M_S: f64 = 0.03;

/// Damping while groups fall, 1/s: less rolling and swinging, which costs time and room.
const FALL_DAMPING_PER_S: f64 = 1.0;

/// Share of a body's friction with which a heap must stay at rest: engines differ by more than this in how much a heap
/// on the verge of sliding holds.
const LESS_FRICTION: f64 = 0.8;

/// Depth of a body's origin below the table's top below which it has fallen off, meters.
const OFF_M: f64 = 0.05;

impl Heap<'_> {
    /// Simulates the fall of what was just put above the heap. What is kept does not move.
    pub(super) fn fall(&mut self) -> Result<(), ClutterError> {
        let settings = SettleSettings {
            duration_s: FALL_S,
            rest_speed_m_s: FALLEN_M_S,
            rest_time_s: 0.05,
            damping_per_s: FALL_DAMPING_PER_S,
            ..self.settings.settle.clone()
        };
        let (present, mut bodies) = self.bodies();
        for (&body, simulated) in present.iter().zip(&mut bodies) {
            simulated.fixed |= !self.is_dropped(body);
        }
        let settled = settle_together(&bodies, &settings, self.cancel)?;
        self.take(&present, &settled);
        Ok(())
    }

    /// Lets everything come to rest together, what is kept too.
    pub(super) fn settle(&mut self) -> Result<(), ClutterError> {
        let (present, bodies) = self.bodies();
        let settled = settle_together(&bodies, self.settings.settle, self.cancel)?;
        self.take(&present, &settled);
        Ok(())
    }

    /// Poses after the time under gravity in which nothing may move, with less friction than there is; what moves is
    /// left where it was then.
    pub(super) fn after_watching(&self) -> Result<(Vec<usize>, SettledPoses), ClutterError> {
        let duration_s = self.settings.certify.dss_duration_s;
        let settings = SettleSettings { duration_s, ..self.settings.settle.clone() };
        let (present, mut bodies) = self.bodies();
        for body in &mut bodies {
            body.friction.static_coefficient *= LESS_FRICTION;
            body.friction.dynamic_coefficient *= LESS_FRICTION;
            body.rolling_friction_m *= LESS_FRICTION;
        }
        let settled = simulate_to_the_end(&bodies, &settings, self.cancel)?;
        Ok((present, settled))
    }

    /// The bodies in the scene, in their poses of now.
    pub(super) fn bodies(&self) -> (Vec<usize>, Vec<Body>) {
        let placed = |(body, pose): (&Body, &Option<Pose>)| {
            pose.map(|world_from_object| Body { world_from_object, ..body.clone() })
        };
        let bodies = self.problem.bodies.iter().zip(&self.poses).filter_map(placed).collect();
        (self.present(), bodies)
    }

    pub(super) fn take(&mut self, present: &[usize], settled: &SettledPoses) {
        for (&body, pose) in present.iter().zip(&settled.poses) {
            self.poses[body] = Some(*pose);
        }
    }

    /// Whether a body is no longer on the table.
    pub(super) fn is_off(&self, body: usize) -> bool {
        self.poses[body].is_none_or(|pose| {
            let center_m = pose.transform_point(self.problem.bodies[body].mass.center_of_mass_m);
            center_m.z < -OFF_M || !self.problem.outline.contains(center_m.truncate())
        })
    }
}
