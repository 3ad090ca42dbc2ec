//! The search for a free place: a grid over a surface, by yaw, with the hulls of everything else as obstacles.
//!
//! The search is exhaustive within its grid (1 cm, and 5 mm where that finds nothing; 16 yaws), so that a refusal
//! means that there is no room. Candidates are ordered by how well they fit the relation; the caller lets them come to
//! rest in this order ([`crate::rest`]). World frame, meters, radians.

mod search;

use std::f64::consts::FRAC_PI_2;

use glam::DVec2;

use crate::workspace::Workspace;
use geometry::Pose;
use geometry::pose::wrap_angle_rad;
use scene::predicates::{PosedFootprint, PosedRelation, holds};
use scene::{RelationKind, SupportRelation, Supporter};
use search::{Orientation, Search, reaches_into};

/// Free space that the search keeps around an object where there is enough of it, and at least.
const CLEARANCES_M: [f64; 2] = [0.01, 0.003];

/// Grid steps, meters.
const STEPS_M: [f64; 2] = [0.01, 0.005];

/// Cells along the longer side of a container.
const CONTAINER_CELLS: f64 = 14.0;

/// Wanted place of an object.
#[derive(Clone, Debug, Default)]
pub struct PlaceQuery {
    /// `None` for anywhere on the table, or for `position_m`.
    pub relation: Option<RelationKind>,
    pub target: Option<usize>,
    pub second_target: Option<usize>,
    /// Stated free distance to the target or edge.
    pub distance_m: Option<f64>,
    /// Stated center on the table.
    pub position_m: Option<DVec2>,
    /// Stated yaw.
    pub yaw_rad: Option<f64>,
    /// Ideal place, if there is room: the present place of the object.
    pub near_m: Option<DVec2>,
    /// Largest distance from `near_m`.
    pub within_m: Option<f64>,
    /// The yaw to prefer where none is stated.
    pub usual_yaw_rad: f64,
    /// Free distance to the outlines of what stands beside it, seen from above; 0 if only the bodies keep apart.
    pub outline_gap_m: f64,
    /// Whether every place where the relation holds is as good as any other, and only `near_m` decides.
    pub by_nearness: bool,
}

/// A pose from which an object may come to rest.
#[derive(Clone, Copy, Debug)]
pub struct Candidate {
    pub world_from_object: Pose,
    pub supporter: Supporter,
    /// The yaw that it must have at rest, up to its symmetry; `None` if any will do.
    pub stated_yaw_rad: Option<f64>,
}

/// There is no free place.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum NoPlace {
    /// The stated place is not on the surface, or not wholly.
    #[error(
        "{object} would reach {beyond_m:.2} m over the edge of {surface}{}",
        way(.way_m)
    )]
    BeyondEdge {
        object: String,
        surface: String,
        beyond_m: f64,
        /// Distance that the object can go toward that place, meters; `None` for an object that is there already.
        way_m: Option<f64>,
    },
    #[error("{object} does not fit {place}: it is larger than the space there")]
    TooLarge { object: String, place: String },
    #[error("there is no free place {place} for {object}: {} in the way", blockers(.by))]
    Blocked { object: String, place: String, by: Vec<String> },
}

fn way(way_m: &Option<f64>) -> String {
    way_m.map_or_else(String::new, |way_m| format!("; in that direction it can go {way_m:.2} m"))
}

fn blockers(by: &[String]) -> String {
    match by {
        [] => "the edge of the table is".to_owned(),
        [only] => format!("{only} is"),
        [first, last] => format!("{first} and {last} are"),
        [first, second, ..] => format!("{first}, {second} and others are"),
    }
}

impl Workspace {
    /// Places where an object may be let down, the best first; at least one.
    ///
    /// # Errors
    ///
    /// [`NoPlace`] if no place of the grid is free.
    pub fn places(&self, object: usize, query: &PlaceQuery) -> Result<Vec<Candidate>, NoPlace> {
        let mut blocked_by: Vec<usize> = Vec::new();
        let mut fits_nowhere = true;
        for supporter in self.surfaces(query) {
            for (clearance_m, step_m) in self.passes(supporter) {
                let search = Search::new(self, object, query, supporter, clearance_m, step_m);
                let found = search.run(&mut blocked_by);
                if !found.candidates.is_empty() {
                    return Ok(found.candidates);
                }
                fits_nowhere &= !found.has_fitted;
                if !found.has_fitted && step_m <= STEPS_M[1] {
                    break;
                }
            }
        }
        if let Some(position_m) = query.position_m.filter(|_| fits_nowhere) {
            let search = Search::new(self, object, query, Supporter::TABLE, CLEARANCES_M[1], STEPS_M[1]);
            let orientation = Orientation::new(search.object, search.object.body.world_from_object.rotation);
            return Err(search.beyond_edge(&orientation, position_m));
        }
        let (object, place) = (self.objects[object].body.name.clone(), self.place_in_words(query));
        if fits_nowhere {
            return Err(NoPlace::TooLarge { object, place });
        }
        blocked_by.sort_unstable();
        blocked_by.dedup();
        let by = blocked_by.into_iter().map(|other| self.objects[other].body.name.clone()).collect();
        Err(NoPlace::Blocked { object, place, by })
    }

    /// The place straight below or above a pose: same position and orientation in the plane, let down onto the
    /// supporter.
    ///
    /// # Errors
    ///
    /// [`NoPlace`] if the object would reach over the edge of the surface, or into another one.
    pub fn place_at(
        &self,
        object: usize,
        world_from_object: Pose,
        supporter: Supporter,
    ) -> Result<Candidate, NoPlace> {
        let query = PlaceQuery::default();
        let search = Search::new(self, object, &query, supporter, 0.001, STEPS_M[0]);
        let orientation = Orientation::new(search.object, world_from_object.rotation);
        let center_m = world_from_object.translation_m.truncate() + orientation.offset_m;
        let posed = search.posed(&orientation, center_m);
        let pose = posed.ok_or_else(|| search.beyond_edge(&orientation, center_m))?;
        match search.obstacle_of(&pose) {
            None => Ok(Candidate { world_from_object: pose, supporter, stated_yaw_rad: None }),
            Some(other) => {
                let by = vec![self.objects[other].body.name.clone()];
                let object = self.objects[object].body.name.clone();
                Err(NoPlace::Blocked { object, place: "there".to_owned(), by })
            }
        }
    }

    /// Whether an object that is placed meets the relation of a query.
    pub fn meets(&self, object: usize, query: &PlaceQuery) -> bool {
        let Some(kind) = query.relation else { return true };
        let footprint = |index: usize| self.objects[index].footprint();
        let (target, second) = (query.target.map(footprint), query.second_target.map(footprint));
        let relation = PosedRelation {
            kind,
            object: &footprint(object),
            target: target.as_ref(),
            second_target: second.as_ref(),
            distance_m: query.distance_m,
        };
        let is_within = |container: &PosedFootprint| {
            let placed = &self.objects[object];
            kind != RelationKind::In || reaches_into(placed, &placed.body.world_from_object, container)
        };
        holds(&relation, &self.outline) && target.as_ref().is_none_or(is_within)
    }

    /// Clearance and grid step of each pass over a surface.
    fn passes(&self, supporter: Supporter) -> Vec<(f64, f64)> {
        if let (Some(parent), SupportRelation::In) = (supporter.parent, supporter.relation) {
            // Objects in a container touch each other, and every place costs a cast onto all hulls.
            let (low, high) = self.objects[parent].footprint().bounds();
            let step_m = ((high - low).max_element() / CONTAINER_CELLS).clamp(0.004, 0.02);
            return vec![(CLEARANCES_M[1], step_m)];
        }
        CLEARANCES_M.iter().flat_map(|clearance_m| STEPS_M.map(|step_m| (*clearance_m, step_m))).collect()
    }

    /// The surfaces to search, in order.
    fn surfaces(&self, query: &PlaceQuery) -> Vec<Supporter> {
        match (query.relation, query.target) {
            (Some(RelationKind::On | RelationKind::StackedOn), Some(target)) => vec![Supporter::on(target)],
            (Some(RelationKind::In), Some(target)) => vec![Supporter::containing(target)],
            (Some(_), Some(target)) => {
                let beside = self.surface_beside(target);
                if beside == Supporter::TABLE { vec![beside] } else { vec![beside, Supporter::TABLE] }
            }
            _ => vec![Supporter::TABLE],
        }
    }

    /// The place in words, for messages.
    pub fn place_in_words(&self, query: &PlaceQuery) -> String {
        let name = |index: Option<usize>| match index {
            Some(index) => self.objects[index].body.name.clone(),
            None => "the table".to_owned(),
        };
        match query.relation {
            None if query.position_m.is_some() => "at the stated position".to_owned(),
            None => "on the table".to_owned(),
            Some(RelationKind::Between) => {
                format!("between {} and {}", name(query.target), name(query.second_target))
            }
            Some(relation) => {
                let words = serde_json::to_value(relation).ok();
                let words = words.as_ref().and_then(|value| value.as_str()).unwrap_or("at").replace('_', " ");
                match query.target {
                    Some(_) => format!("{words} {}", name(query.target)),
                    None => format!("{words} of the table"),
                }
            }
        }
    }
}

/// The multiple of a right angle that is nearest to a yaw.
pub fn nearest_right_angle_rad(yaw_rad: f64) -> f64 {
    wrap_angle_rad((yaw_rad / FRAC_PI_2).round() * FRAC_PI_2)
}
