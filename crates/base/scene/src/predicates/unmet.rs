//! The demands of a description that a finished layout does not meet.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::{
    POSITION_TOLERANCE_M, PosedFootprint, PosedRelation, YAW_TOLERANCE_RAD, arrangement_holds, holds,
    seat_yaw_rad,
};
use crate::InstanceId;
use crate::description::{ArrangementKind, RelationKind, SceneDescription};
use crate::name::Names;
use geometry::Outline;
use geometry::pose::wrap_angle_rad;

/// A demand that is not met, and the objects that it names.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[schemars(description = "A demand of the text that the layout does not meet, and its objects.")]
pub struct Unmet {
    /// The object of a relation or property; all objects of an arrangement.
    #[schemars(with = "Names")]
    pub objects: Vec<InstanceId>,
    #[serde(flatten)]
    pub demand: UnmetDemand,
}

impl Unmet {
    /// Every object that the demand names.
    pub fn names(&self) -> impl Iterator<Item = &InstanceId> {
        let targets = match &self.demand {
            UnmetDemand::Relation { targets, .. } => targets.as_slice(),
            _ => &[],
        };
        self.objects.iter().chain(targets)
    }
}

/// The kind of a demand.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "kind", rename_all = "snake_case")]
pub enum UnmetDemand {
    /// A relation; without targets, to the table.
    Relation {
        relation: RelationKind,
        #[serde(default, skip_serializing_if = "Vec::is_empty")]
        targets: Vec<InstanceId>,
        #[serde(default, skip_serializing_if = "Option::is_none")]
        distance_m: Option<f64>,
    },
    /// The arrangement with this index in the description.
    Arrangement {
        index: usize,
        #[serde(flatten)]
        arrangement: ArrangementKind,
    },
    /// A stated rotation about the vertical axis.
    Yaw { yaw_rad: f64 },
    /// A stated position.
    Position { x_m: f64, y_m: f64 },
}

/// Every demand of the description that posed footprints, in the order of its objects, do not meet. Positions and yaws
/// have the tolerances [`POSITION_TOLERANCE_M`] and [`YAW_TOLERANCE_RAD`]. Relations to unknown objects are unmet.
pub fn unmet(description: &SceneDescription, footprints: &[PosedFootprint], table: &Outline) -> Vec<Unmet> {
    let find = |id: &InstanceId| {
        let index = description.objects.iter().position(|object| &object.id == id)?;
        footprints.get(index)
    };
    let (low, high) = table.bounds();
    let center = 0.5 * (low + high);
    let mut found = Vec::new();
    for (object, footprint) in description.objects.iter().zip(footprints) {
        let mut add = |demand| found.push(Unmet { objects: vec![object.id.clone()], demand });
        for relation in &object.relations {
            let targets: Vec<&InstanceId> = relation.target.iter().chain(&relation.second_target).collect();
            let is_known = targets.iter().all(|id| find(id).is_some());
            let target = relation.target.as_ref().and_then(find);
            // As the person at the target sees both.
            let seat = target.filter(|_| relation.seated).map(|target| {
                let turn_rad = -seat_yaw_rad(target.center(), table);
                [footprint.turned(turn_rad), target.turned(turn_rad)]
            });
            let posed = PosedRelation {
                kind: relation.kind,
                object: seat.as_ref().map_or(footprint, |[object, _]| object),
                target: seat.as_ref().map(|[_, target]| target).or(target),
                second_target: relation.second_target.as_ref().and_then(find),
                distance_m: relation.distance_m,
            };
            if !is_known || !holds(&posed, table) {
                let targets = targets.into_iter().cloned().collect();
                let distance_m = relation.distance_m;
                add(UnmetDemand::Relation { relation: relation.kind, targets, distance_m });
            }
        }
        if let Some(yaw_rad) = object.yaw_rad
            && wrap_angle_rad(footprint.yaw_rad - yaw_rad).abs() > YAW_TOLERANCE_RAD
        {
            add(UnmetDemand::Yaw { yaw_rad });
        }
        if let Some(at) = object.position_m
            && footprint.center().distance(center + at) > POSITION_TOLERANCE_M
        {
            add(UnmetDemand::Position { x_m: at.x, y_m: at.y });
        }
    }
    for (index, arrangement) in description.arrangements.iter().enumerate() {
        let members: Option<Vec<&PosedFootprint>> = arrangement.objects.iter().map(find).collect();
        let around = arrangement.center.as_ref().and_then(find);
        let is_met = members
            .is_some_and(|members| arrangement_holds(arrangement.kind, &members, arrangement.gap_m, around));
        if !is_met {
            let demand = UnmetDemand::Arrangement { index, arrangement: arrangement.kind };
            found.push(Unmet { objects: arrangement.objects.clone(), demand });
        }
    }
    found
}
