//! Objects on others and on the table.

use geometry::drop_cast::are_closer;
use geometry::polygon::depth_in_convex_m;
use scene::predicates::CONTACT_TOLERANCE_M;

use super::{Measured, Reason, Situation};
use crate::contact::ContactBody;
use crate::posed_object::PosedObject;

/// Gap up to which hulls count as touching, meters.
pub const CONTACT_GAP_M: f64 = 0.003;
/// Distance of the center of mass beyond the edge of its support that is tolerated, meters.
pub const OVERHANG_M: f64 = 0.01;
/// Maximum offset of the upper object's center from the lower object's, beyond half the diagonal of the lower one
/// (ManiSkill's StackCube), meters.
pub const STACK_MARGIN_M: f64 = 0.005;

/// Rise of the lowest point above that of the target, from which an object is on it rather than beside it, meters.
const MIN_RISE_M: f64 = 0.001;

impl Situation<'_> {
    /// Whether two objects touch: by a reported contact, or with hulls at most [`CONTACT_GAP_M`] apart.
    pub(super) fn touches(&self, a: &PosedObject, b: &PosedObject) -> bool {
        let body = |object: &PosedObject| ContactBody::Object(object.name.clone());
        self.reports(&body(a), &body(b)) || are_closer(&a.posed_shape(), &b.posed_shape(), CONTACT_GAP_M)
    }

    /// On a target are objects that touch it, whose lowest point is above that of the target and whose center of mass
    /// is above the target.
    pub(super) fn supported(&self, object: &PosedObject, target: &PosedObject) -> Measured {
        let (above, below) = (object.footprint(), target.footprint());
        let gap_m = above.bottom_m - below.top_m;
        if !self.touches(object, target) {
            let measured = Measured::at_most_m(gap_m, CONTACT_GAP_M, Reason::NoContact);
            return Measured { holds: false, ..measured };
        }
        let rise_m = above.bottom_m - below.bottom_m;
        if rise_m < MIN_RISE_M {
            return Measured::at_least_m(rise_m, MIN_RISE_M, Reason::NotAbove);
        }
        let overhang_m = -depth_in_convex_m(below.corners(), object.center_of_mass_m().truncate());
        Measured::at_most_m(overhang_m, OVERHANG_M, Reason::NoSupportUnderCenter)
    }

    /// On the table are objects that touch it, with the center of mass above it.
    pub(super) fn on_table(&self, object: &PosedObject) -> Measured {
        let name = ContactBody::Object(object.name.clone());
        let bottom_m = object.footprint().bottom_m;
        if !self.reports(&name, &ContactBody::Table) && bottom_m.abs() > CONTACT_TOLERANCE_M {
            return Measured::at_most_m(bottom_m.abs(), CONTACT_TOLERANCE_M, Reason::NoContact);
        }
        let overhang_m = -self.table.depth_inside_m(object.center_of_mass_m().truncate());
        Measured::at_most_m(overhang_m, 0.0, Reason::NoSupportUnderCenter)
    }

    /// Stacked are objects on a target whose centers are near each other, seen from above.
    pub(super) fn stacked(&self, object: &PosedObject, target: &PosedObject) -> Measured {
        let supported = self.supported(object, target);
        if !supported.holds {
            return supported;
        }
        let (above, below) = (object.footprint(), target.footprint());
        let (low, high) = below.bounds();
        let limit_m = 0.5 * (high - low).length() + STACK_MARGIN_M;
        Measured::at_most_m(above.center().distance(below.center()), limit_m, Reason::OffCenter)
    }

    /// Whether any other object is below it in this sense.
    pub(super) fn is_on_any(&self, object: &PosedObject) -> bool {
        self.now.iter().any(|other| other.name != object.name && self.supported(object, other).holds)
    }
}
