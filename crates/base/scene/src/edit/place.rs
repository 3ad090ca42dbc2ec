//! Places that operations state.

use glam::DVec2;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::{ANGLE, is_angle};
use crate::description::RelationKind;
use crate::validation::{Violation, Violations};

/// A place: a relation to another object or to the table, coordinates, or a displacement.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct EditPlace {
    /// `on`, `in`, `left_of`, `right_of`, `in_front_of`, `behind`, `next_to`, `between`, a region of the table
    /// (`at_center`, `at_back_left`, ...), or a distance from an edge (`from_left_edge`, ...).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub relation: Option<RelationKind>,
    /// The other object; absent for the table.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub target: Option<String>,
    /// The second object of `between`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub second_target: Option<String>,
    /// Free distance to the target or to the edge, meters.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub distance_m: Option<f64>,
    /// Center of the object on the table top, from its center: x to the right, y to the back, meters.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(with = "Option<[f64; 2]>")]
    pub position_m: Option<DVec2>,
    /// Displacement from where a moved object is: x to the right, y to the back, meters.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(with = "Option<[f64; 2]>")]
    pub offset_m: Option<DVec2>,
    /// Rotation about the vertical axis; 0 faces the front edge. Chosen where it is absent.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub yaw_rad: Option<f64>,
}

impl EditPlace {
    /// A relation to an object.
    pub fn related(relation: RelationKind, target: impl Into<String>) -> Self {
        Self { relation: Some(relation), target: Some(target.into()), ..Self::default() }
    }

    /// A region of the table.
    pub fn at(region: RelationKind) -> Self {
        Self { relation: Some(region), ..Self::default() }
    }

    pub(super) fn violations(&self) -> Vec<Violation> {
        use RelationKind::{Around, Between, Facing, In, ParallelTo, StackedOn};
        let mut violations = Violations::default();
        let given = usize::from(self.relation.is_some())
            + usize::from(self.position_m.is_some())
            + usize::from(self.offset_m.is_some());
        violations.require(given == 1, "", "give one of `relation`, `position_m` and `offset_m`");
        if let Some(relation) = self.relation {
            let supported = !matches!(relation, Around | Facing | ParallelTo | StackedOn);
            violations.require(supported, "/relation", "is no place; give on, in, left_of, ... or a region");
            let needs_target = relation.target_is_object() || relation == In;
            violations.require(
                !needs_target || self.target.is_some(),
                "/target",
                "names the object that the relation is to; it is missing",
            );
            violations.require(
                needs_target || relation == RelationKind::On || self.target.is_none(),
                "/target",
                "a region of the table has no target",
            );
            violations.require(
                (relation == Between) == self.second_target.is_some(),
                "/second_target",
                "is the second object of `between`, and of nothing else",
            );
        }
        let distance = self.distance_m.is_none_or(|distance_m| (0.0..=5.0).contains(&distance_m));
        violations.require(distance, "/distance_m", "must be from 0 to 5 meters");
        let position = self.position_m.is_none_or(|at| at.is_finite() && at.abs().max_element() <= 5.0);
        violations.require(position, "/position_m", "must be within 5 meters of the center of the table");
        let offset = self.offset_m.is_none_or(|by| by.is_finite() && by.abs().max_element() <= 5.0);
        violations.require(offset, "/offset_m", "must be up to 5 meters");
        violations.require(is_angle(self.yaw_rad), "/yaw_rad", ANGLE);
        violations.into_vec()
    }
}
