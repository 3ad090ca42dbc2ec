//! Clauses about what surrounds objects, and about what is not seen of them: table, light, camera, places of
//! everything, meshes, masses.

use scene::edit::CameraMove;
use scene::{EditOperation, Light};

use super::discourse::Changes;
use super::error::Reason;
use super::fold::{Fold, Outcome, Step};
use crate::clause::{Clause, Filler};
use crate::measures::Change;

impl Fold<'_, '_> {
    pub fn rearrange(&mut self) -> Outcome<()> {
        self.push(EditOperation::Rearrange);
        self.discourse.topic = None;
        Ok(())
    }

    pub fn remake(&mut self, clause: &Clause) -> Outcome<()> {
        let targets = self.targets(clause.objects(""))?;
        for target in &targets {
            self.push(EditOperation::Remake { target: target.phrase.clone() });
        }
        self.now_about(targets, Changes::Nothing);
        Ok(())
    }

    pub fn set_physics(&mut self, clause: &Clause) -> Outcome<()> {
        let change = clause.fillers.iter().find_map(|(_, filler)| match filler {
            Filler::Change(change, value) => Some((*change, *value)),
            _ => None,
        });
        let stated = |factor: f64| match change {
            None => factor,
            Some((Change::To, value)) => value,
            Some((Change::Factor, value)) if factor < 1.0 => 1.0 / value,
            Some((Change::Factor, value)) => value,
            Some((Change::Part, value)) if factor < 1.0 => 1.0 - value,
            Some((Change::Part, value)) => 1.0 + value,
        };
        let (mass_factor, friction_factor) =
            (clause.means.mass_factor.map(stated), clause.means.friction_factor.map(stated));
        let targets = self.targets(clause.objects(""))?;
        for target in &targets {
            let target = target.phrase.clone();
            self.push(EditOperation::SetPhysics { target, mass_factor, friction_factor });
        }
        self.now_about(targets, Changes::Nothing);
        Ok(())
    }

    pub fn restyle_table(&mut self, clause: &Clause) -> Outcome<()> {
        let Some(appearance) = clause.appearance().cloned() else { return self.refuse(Reason::Empty) };
        self.push(EditOperation::RestyleTable { material: appearance.material, color: appearance.color });
        self.discourse.topic = None;
        Ok(())
    }

    /// A light that several clauses describe ("from the left, and dim it") is one.
    pub fn relight(&mut self, clause: &Clause) -> Outcome<()> {
        let means = clause.means;
        let changed = |light: &mut Light| {
            light.azimuth_rad = means.azimuth_deg.map_or(light.azimuth_rad, f64::to_radians);
            light.elevation_rad = means.elevation_deg.map_or(light.elevation_rad, f64::to_radians);
            light.intensity = means.intensity.unwrap_or(light.intensity);
        };
        if let Some(Step::Operation(EditOperation::Relight(light))) = self.steps.last_mut() {
            changed(light);
            return Ok(());
        }
        let mut light = Light::USUAL;
        changed(&mut light);
        self.push(EditOperation::Relight(light));
        self.discourse.topic = None;
        Ok(())
    }

    pub fn move_camera(&mut self, clause: &Clause) -> Outcome<()> {
        let means = clause.means;
        let angle = clause.fillers.iter().find_map(|(_, filler)| match filler {
            Filler::Angle(rad) => Some(*rad),
            _ => None,
        });
        // "by 30 degrees" has no direction of its own where the words state one.
        let by = |deg: f64| angle.map_or(deg.to_radians(), |angle| angle.abs().copysign(deg));
        let is_raised = means.raise_deg.is_some();
        self.push(EditOperation::MoveCamera(CameraMove {
            turn_rad: means.turn_deg.map(by).or(angle.filter(|_| !is_raised)),
            raise_rad: means.raise_deg.map(by),
            distance_factor: means.distance_factor,
            focal_factor: means.focal_factor,
        }));
        self.discourse.topic = None;
        Ok(())
    }
}
