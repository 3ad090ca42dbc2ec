//! Objects in containers.

use glam::DVec3;

use super::{Measured, Reason, Situation};
use crate::contact::ContactBody;
use crate::opening::Opening;
use crate::posed_object::PosedObject;

/// Least depth below the rim of what stands out of a container, meters.
pub const MIN_INSERTION_M: f64 = 0.01;

impl Situation<'_> {
    /// In a container are objects whose center of mass is inside the opening's hull and below the rim; and long ones
    /// that stand out of it, as a spoon does of a mug, if they touch it, do not reach the table, and their lowest
    /// point is in the cavity.
    pub(super) fn contained(&self, object: &PosedObject, container: &PosedObject) -> Measured {
        let Some(opening) = container.shape.opening() else { return Measured::failed(Reason::NoOpening) };
        let container_from_world = container.world_from_object.inverse();
        let center_m = container_from_world.transform_point(object.center_of_mass_m());
        let measured = [
            (opening.depth_inside_m(center_m), Reason::OutsideOpening),
            (opening.rim_m - center_m.z, Reason::AboveRim),
            (center_m.z - opening.floor_m, Reason::UnderFloor),
        ];
        let measured =
            measured.map(|(value_m, reason)| Measured::at_least_m(value_m, 0.0, reason)).into_iter();
        let nearest = |a: &Measured, b: &Measured| a.value.total_cmp(&b.value);
        let failed = measured.clone().find(|measured| !measured.holds);
        let Some(whole) = failed.or(measured.min_by(nearest)) else {
            return Measured::failed(Reason::NoOpening);
        };
        let inserted = (!whole.holds).then(|| self.inserted(object, container, opening)).flatten();
        inserted.filter(|inserted| inserted.holds).unwrap_or(whole)
    }

    /// An object that stands out of a container; `None` if it does not reach into the cavity or stands elsewhere.
    fn inserted(&self, object: &PosedObject, container: &PosedObject, opening: &Opening) -> Option<Measured> {
        let container_from_object = container.world_from_object.inverse() * object.world_from_object;
        let points = object.shape.collision().points(&container_from_object);
        let in_cavity =
            points.filter(|point| opening.depth_inside_m(*point) >= 0.0 && point.z > opening.floor_m - 0.005);
        let lowest: DVec3 = in_cavity.min_by(|a, b| a.z.total_cmp(&b.z))?;
        let limit_m = MIN_INSERTION_M.max(opening.depth_m() / 3.0);
        let rests_in = self.touches(object, container) && !self.touches_table(object);
        rests_in.then(|| Measured::at_least_m(opening.rim_m - lowest.z, limit_m, Reason::AboveRim))
    }

    fn touches_table(&self, object: &PosedObject) -> bool {
        let name = ContactBody::Object(object.name.clone());
        self.reports(&name, &ContactBody::Table) || object.footprint().bottom_m <= 0.001
    }
}
