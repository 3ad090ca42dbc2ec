//! Judgment of a heap, with the measurements of the certificate.

use rayon::prelude::*;

use super::{ClutterError, Heap, TABLE, contacts, footprint};
use crate::metrics::{CertifySettings, collisions};
use crate::resolve::inside;
use crate::settle::{SettledPoses, angle_between_rad};
use crate::support::{SupportFinding, support};
use geometry::Pose;
use geometry::collide::PlacedSolid;
use runtime::Cancelled;

/// Watches until bodies that move on slowly must stay.
const WATCHES: usize = 3;

/// A kept body that moved or turned farther was pushed away by the heap, meters and radians.
const PUSHED_M: f64 = 0.005;
const PUSHED_RAD: f64 = 0.1;

/// Share of what the certificate lets a body move that it may move here.
const STRICTER: f64 = 0.5;

/// A defect of a heap at rest.
pub(super) struct HeapFault {
    pub reason: String,
    /// Bodies that are dropped again; none where that does not help.
    pub lift: Vec<usize>,
}

impl Heap<'_> {
    /// Lets everything come to rest, and judges it.
    pub(super) fn come_to_rest(&mut self) -> Result<Vec<HeapFault>, ClutterError> {
        self.settle()?;
        let mut faults = self.misplaced();
        if !faults.is_empty() {
            return Ok(faults);
        }
        for watch in 1..=WATCHES {
            let (present, later) = self.after_watching()?;
            let moving: Vec<usize> =
                (0..present.len()).filter(|&k| self.is_moving(present[k], k, &later)).collect();
            if moving.is_empty() {
                break;
            }
            self.take(&present, &later);
            if watch == WATCHES {
                faults = moving
                    .iter()
                    .map(|&k| {
                        let way_mm = 1e3 * later.displacements_m[k];
                        let reason =
                            format!("{} does not come to rest ({way_mm:.1} mm)", self.name(present[k]));
                        HeapFault { reason, lift: self.to_lift(present[k]) }
                    })
                    .collect();
            }
        }
        faults.extend(self.misplaced());
        // What follows costs far more.
        if faults.is_empty() { self.unsound() } else { Ok(faults) }
    }

    fn is_moving(&self, body: usize, k: usize, later: &SettledPoses) -> bool {
        let resolve = self.settings.resolve;
        let limit_m = STRICTER * self.settings.certify.rest_limit_m(&self.problem.bodies[body]);
        body != TABLE
            && (later.displacements_m[k] > limit_m.min(resolve.rest_displacement_m)
                || later.rotations_rad[k] > resolve.rest_rotation_rad)
    }

    /// Bodies that are beyond the table's edge, and kept ones that were pushed away.
    fn misplaced(&self) -> Vec<HeapFault> {
        let mut faults = Vec::new();
        for body in self.present().into_iter().filter(|&body| body != TABLE) {
            let Some(pose) = self.poses[body] else { continue };
            let name = self.name(body);
            let (over_m, _) =
                inside::missing(self.problem.outline, &footprint(&self.shapes[body], &pose), 0.0);
            if self.is_off(body) {
                faults.push(HeapFault { reason: format!("{name} fell off"), lift: self.to_lift(body) });
            } else if over_m > 0.0 {
                let reason = format!("{name} reaches {:.0} mm over the table's edge", 1e3 * over_m);
                faults.push(HeapFault { reason, lift: self.to_lift(body) });
            } else if !self.is_dropped(body) && self.is_pushed(body, &pose) {
                faults
                    .push(HeapFault { reason: format!("{name} was pushed away"), lift: self.to_lift(body) });
            }
        }
        faults
    }

    fn is_pushed(&self, body: usize, pose: &Pose) -> bool {
        let before = self.problem.bodies[body].world_from_object;
        before.translation_m.distance(pose.translation_m) > PUSHED_M
            || angle_between_rad(&before, pose) > PUSHED_RAD
    }

    /// The body itself if it was dropped, or else those that were and touch it.
    fn to_lift(&self, body: usize) -> Vec<usize> {
        if self.is_dropped(body) {
            return vec![body];
        }
        let (present, bodies) = self.bodies();
        let touching = contacts(&bodies, self.settings.certify.contact_gap_m);
        let Some(at) = present.iter().position(|&other| other == body) else { return Vec::new() };
        let touched = touching[at].iter().map(|contact| present[contact.other]);
        touched.filter(|&other| self.is_dropped(other)).collect()
    }

    /// Bodies whose contacts do not carry them, and meshes inside each other.
    fn unsound(&self) -> Result<Vec<HeapFault>, ClutterError> {
        let certify: &CertifySettings = self.settings.certify;
        let (present, bodies) = self.bodies();
        let placed: Vec<PlacedSolid> = present
            .iter()
            .zip(&bodies)
            .map(|(&body, placed)| PlacedSolid {
                solid: self.problem.solids[body],
                world_from_object: placed.world_from_object,
            })
            .collect();
        let everything: Vec<usize> = (0..bodies.len()).collect();
        let movable: Vec<usize> =
            everything.iter().copied().filter(|&k| self.is_dropped(present[k])).collect();
        let findings: Vec<SupportFinding> = movable
            .par_iter()
            // Whatever a body in a heap touches may hold it.
            .map(|&k| support(&placed, &bodies, k, &everything, certify, self.cancel))
            .collect::<Result<_, Cancelled>>()?;
        let mut faults = Vec::new();
        for (&k, _) in movable.iter().zip(&findings).filter(|(_, finding)| !finding.is_supported()) {
            let reason = format!("{} is not carried by what it touches", self.name(present[k]));
            faults.push(HeapFault { reason, lift: vec![present[k]] });
        }
        for pair in collisions(&placed, certify, self.cancel)?.colliding {
            let (a, b) = (present[pair.a], present[pair.b]);
            let reason =
                format!("{} and {} overlap by {:.1} mm", self.name(a), self.name(b), 1e3 * pair.depth_m);
            let height_m =
                |k: usize| bodies[k].world_from_object.transform_point(bodies[k].mass.center_of_mass_m).z;
            let upper = if height_m(pair.a) > height_m(pair.b) { a } else { b };
            let lift = [upper, a, b].into_iter().find(|&body| self.is_dropped(body));
            faults.push(HeapFault { reason, lift: lift.into_iter().collect() });
        }
        Ok(faults)
    }
}
