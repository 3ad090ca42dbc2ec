//! Demands of a description beyond plain relations: distances, positions, yaws and arrangements, by object index.

use glam::DVec2;

use scene::{ArrangementKind, InstanceId, RelationKind, SceneDescription};

/// All demands of a description that need more than the kind and target of a relation. The default has none.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct StatedDemands {
    pub demands: Vec<Demand>,
    pub arrangements: Vec<StatedArrangement>,
    /// Relations of an object to another one whose directions are those of the person at the latter.
    pub seated: Vec<(usize, RelationKind, usize)>,
}

/// One demand on the placement of an object.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Demand {
    pub object: usize,
    pub kind: DemandKind,
}

/// Kinds of demands. Objects are indices, lengths meters; the world frame has its origin at the center of the table.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum DemandKind {
    Yaw {
        yaw_rad: f64,
    },
    /// The front points to the target, or to the center of the table.
    Facing {
        target: Option<usize>,
    },
    /// The yaw equals that of the target, or 0.
    Parallel {
        target: Option<usize>,
    },
    /// Center relative to the center of the table.
    Position {
        at_m: DVec2,
    },
    /// Free distance to an edge; without a value, near it.
    Edge {
        edge: RelationKind,
        distance_m: Option<f64>,
    },
    /// Free distance to an object in the direction of the relation.
    Distance {
        relation: RelationKind,
        target: usize,
        distance_m: f64,
    },
    Between {
        first: usize,
        second: usize,
    },
}

/// A regular arrangement of objects by index, in its order.
#[derive(Clone, Debug, PartialEq)]
pub struct StatedArrangement {
    pub kind: ArrangementKind,
    pub objects: Vec<usize>,
    pub gap_m: Option<f64>,
    pub center: Option<usize>,
}

impl StatedDemands {
    /// The demands of a description; indices are those of its objects. Parts that name unknown objects are left out.
    pub fn of(description: &SceneDescription) -> Self {
        let objects = &description.objects;
        let find = |id: &InstanceId| objects.iter().position(|object| &object.id == id);
        let (mut demands, mut seated) = (Vec::new(), Vec::new());
        for (object, spec) in objects.iter().enumerate() {
            let mut add = |kind| demands.push(Demand { object, kind });
            for relation in &spec.relations {
                let target = relation.target.as_ref().and_then(find).filter(|target| *target != object);
                if relation.target.is_some() && target.is_none() {
                    continue;
                }
                seated.extend(target.filter(|_| relation.seated).map(|to| (object, relation.kind, to)));
                match (relation.kind, target, relation.distance_m) {
                    (RelationKind::Facing, target, _) => add(DemandKind::Facing { target }),
                    (RelationKind::ParallelTo, target, _) => add(DemandKind::Parallel { target }),
                    (RelationKind::Between, Some(first), _) => {
                        if let Some(second) = relation.second_target.as_ref().and_then(find) {
                            add(DemandKind::Between { first, second });
                        }
                    }
                    (edge, None, distance_m) if is_edge(edge) => add(DemandKind::Edge { edge, distance_m }),
                    (relation, Some(target), Some(distance_m)) if has_distance(relation) => {
                        add(DemandKind::Distance { relation, target, distance_m });
                    }
                    _ => {}
                }
            }
            if let Some(at_m) = spec.position_m {
                add(DemandKind::Position { at_m });
            }
            if let Some(yaw_rad) = spec.yaw_rad {
                add(DemandKind::Yaw { yaw_rad });
            }
        }
        let arrangements = description
            .arrangements
            .iter()
            .map(|arrangement| StatedArrangement {
                kind: arrangement.kind,
                objects: arrangement.objects.iter().filter_map(find).collect(),
                gap_m: arrangement.gap_m,
                center: arrangement.center.as_ref().and_then(find),
            })
            .collect();
        Self { demands, arrangements, seated }
    }

    /// Whether a demand or an arrangement determines where the object stands.
    pub fn determine(&self, object: usize) -> bool {
        self.demands.iter().any(|demand| demand.object == object)
            || self.arrangements.iter().any(|a| a.objects.contains(&object) || a.center == Some(object))
    }

    /// The stated free distance of a relation of `from` to `to`.
    pub fn distance_m(&self, from: usize, kind: RelationKind, to: usize) -> Option<f64> {
        self.demands.iter().filter(|demand| demand.object == from).find_map(|demand| match demand.kind {
            DemandKind::Distance { relation, target, distance_m } if relation == kind && target == to => {
                Some(distance_m)
            }
            _ => None,
        })
    }

    /// Whether the directions of a relation of `from` to `to` are those of the person at `to`.
    pub fn is_seated(&self, from: usize, kind: RelationKind, to: usize) -> bool {
        self.seated.contains(&(from, kind, to))
    }

    /// A yaw stated as an angle.
    pub fn yaw_rad(&self, object: usize) -> Option<f64> {
        self.demands.iter().filter(|demand| demand.object == object).find_map(|demand| match demand.kind {
            DemandKind::Yaw { yaw_rad } => Some(yaw_rad),
            _ => None,
        })
    }
}

fn is_edge(kind: RelationKind) -> bool {
    use RelationKind::{FromBackEdge, FromFrontEdge, FromLeftEdge, FromRightEdge};
    matches!(kind, FromLeftEdge | FromRightEdge | FromFrontEdge | FromBackEdge)
}

fn has_distance(kind: RelationKind) -> bool {
    use RelationKind::{Around, Behind, InFrontOf, LeftOf, NextTo, RightOf};
    matches!(kind, LeftOf | RightOf | InFrontOf | Behind | NextTo | Around)
}

impl DemandKind {
    /// The objects that the demand refers to.
    pub fn targets(&self) -> [Option<usize>; 2] {
        match *self {
            Self::Facing { target } | Self::Parallel { target } => [target, None],
            Self::Distance { target, .. } => [Some(target), None],
            Self::Between { first, second } => [Some(first), Some(second)],
            Self::Yaw { .. } | Self::Position { .. } | Self::Edge { .. } => [None, None],
        }
    }

    /// Whether it fixes a coordinate on the table.
    pub fn is_pinning(&self) -> bool {
        matches!(self, Self::Position { .. } | Self::Edge { .. })
    }
}
