//! Open and closed containers: whether something covers the opening.

use geometry::polygon::depth_in_convex_m;

use super::{Measured, Reason, Situation};
use crate::posed_object::PosedObject;

/// Maximum depth of a cover's bottom below the rim, meters: lids reach into the containers that they close.
const LID_DEPTH_M: f64 = 0.015;

impl Situation<'_> {
    /// Closed are containers with an object that touches them, has its center of mass above the rim, and covers the
    /// center of the opening. Of other objects, poses do not show whether they are open.
    pub(super) fn closed(&self, container: &PosedObject) -> Measured {
        let Some(opening) = container.shape.opening() else { return Measured::failed(Reason::NotDecidable) };
        let center_m = container.world_from_object.transform_point(opening.center_m());
        let covers = self.now.iter().filter(|other| {
            other.name != container.name
                && other.center_of_mass_m().z > center_m.z
                && other.footprint().bottom_m >= center_m.z - LID_DEPTH_M
                && self.touches(other, container)
        });
        let depth_m = covers.map(|cover| depth_in_convex_m(cover.footprint().corners(), center_m.truncate()));
        // Without a cover, the distance from the center to the edge of the opening.
        let radius_m = opening.depth_inside_m(opening.center_m());
        Measured::at_least_m(depth_m.fold(-radius_m, f64::max), 0.0, Reason::NotCovered)
    }
}
