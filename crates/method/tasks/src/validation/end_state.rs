//! A state of the scene in which the goal holds, if the search for free places finds one.
//!
//! Objects are let down one after the other at the best free place where their predicates hold, supports before what
//! they carry. Only one order is tried, and objects that the goal does not name stay where they are: a refusal means
//! that there is no room without clearing some.

use editing::{Candidate, NoPlace, PlaceQuery, Workspace};
use geometry::Pose;
use scene::predicates::direction_of;
use scene::text_account::{GoalPredicate, PredicateKind};
use scene::{InstanceId, RelationKind};

use super::free_spot::{NO_SPACE_M, may_be_free};
use super::in_words;
use crate::convex_width::narrowest_width_m;
use crate::evaluation::{MAX_DIRECTION_OVERLAP_M, Reason, Situation, evaluate_predicate, relation_of};
use crate::goal::Goal;
use crate::posed_object::PosedObject;
use crate::refusal::Refusal;
use crate::task_scene::TaskScene;

/// The objects of the scene, in its order, at places where every predicate holds that is about places. Postures, lifts
/// and turns are not carried out.
///
/// # Errors
///
/// [`Refusal::TargetTooSmall`] where objects fit a target alone but not together, [`Refusal::NoFreePlace`] where one
/// does not fit, and [`Refusal::BrokenScene`] for hulls that cannot be searched.
pub fn end_state(goal: &Goal, scene: &TaskScene) -> Result<Vec<PosedObject>, Refusal> {
    end_state_with(goal, scene, NO_SPACE_M)
}

/// As [`end_state`], for places with this distance to other objects.
///
/// # Errors
///
/// As for [`end_state`].
pub(super) fn end_state_with(
    goal: &Goal,
    scene: &TaskScene,
    space_m: f64,
) -> Result<Vec<PosedObject>, Refusal> {
    let broken = |error: crate::task_scene::SceneFault| Refusal::BrokenScene { reason: error.to_string() };
    let mut end =
        EndState { scene, workspace: scene.workspace().map_err(broken)?, placed: Vec::new(), space_m };
    for predicates in by_object(goal) {
        end.place(&predicates)?;
    }
    Ok(end.posed())
}

/// The predicates of each moved object, supports before what they carry.
fn by_object(goal: &Goal) -> Vec<Vec<&GoalPredicate>> {
    let mut groups: Vec<Vec<&GoalPredicate>> = Vec::new();
    for predicate in goal.predicates() {
        match groups.iter_mut().find(|group| group[0].object == predicate.object) {
            Some(group) => group.push(predicate),
            None => groups.push(vec![predicate]),
        }
    }
    let mut ordered: Vec<Vec<&GoalPredicate>> = Vec::new();
    while !groups.is_empty() {
        let waits = |group: &Vec<&GoalPredicate>| {
            let targets = || group.iter().filter_map(|predicate| predicate.target.as_ref());
            groups.iter().any(|other| {
                other[0].object != group[0].object && targets().any(|target| *target == other[0].object)
            })
        };
        // Objects that are next to each other wait for each other; the first one goes first.
        let next = groups.iter().position(|group| !waits(group)).unwrap_or_default();
        ordered.push(groups.remove(next));
    }
    ordered
}

/// Reason why an object has no place.
#[derive(Debug, thiserror::Error)]
enum Unplaced {
    #[error(transparent)]
    NoPlace(#[from] NoPlace),
    #[error("other objects are in the way")]
    Obstructed,
    #[error("it does not hold at any free place")]
    HoldsNowhere,
}

struct EndState<'a> {
    scene: &'a TaskScene,
    workspace: Workspace,
    /// Objects that have their place, with the target of their support.
    placed: Vec<(usize, Option<usize>)>,
    space_m: f64,
}

impl EndState<'_> {
    fn index(&self, name: &InstanceId) -> Result<usize, Refusal> {
        self.scene
            .index_of(name)
            .ok_or_else(|| Refusal::AbsentObject { phrase: name.to_string(), candidates: Vec::new() })
    }

    /// Finds the place of one object.
    fn place(&mut self, predicates: &[&GoalPredicate]) -> Result<(), Refusal> {
        let Some(main) = predicates.iter().min_by_key(|predicate| rank(predicate.predicate)) else {
            return Ok(());
        };
        let object = self.index(&main.object)?;
        let target = main.target.as_ref().map(|name| self.index(name)).transpose()?;
        if main.predicate == PredicateKind::Swapped {
            return target.map_or(Ok(()), |target| self.swap(main, object, target));
        }
        let Some(query) = self.query(main, object, target)? else { return Ok(()) };
        if let (Some(relation), Some(target)) = (query.relation, target)
            && !self.has_room(object, relation, target)
        {
            let reason = "there is too little space up to the edge of the table".to_owned();
            return Err(Refusal::NoFreePlace { predicate: in_words(main), reason });
        }
        let chosen =
            match may_be_free(&self.workspace, &self.scene.posed()[object], object, &query, self.space_m) {
                true => self.first_holding(object, &query, predicates),
                false => Err(Unplaced::Obstructed),
            };
        match (chosen, target) {
            (Ok(candidate), _) => {
                self.put(object, candidate);
                self.placed.push((object, target));
                Ok(())
            }
            (Err(unplaced), target) => {
                let crowded = target.and_then(|target| self.crowded(object, target, &query, predicates));
                let reason = unplaced.to_string();
                Err(crowded.unwrap_or(Refusal::NoFreePlace { predicate: in_words(main), reason }))
            }
        }
    }

    /// Whether the object is not wider than the space between the target and the edge of the table. Without it, the
    /// search would find that out in seconds.
    fn has_room(&self, object: usize, relation: RelationKind, target: usize) -> bool {
        let Some(way) = direction_of(relation) else { return true };
        let (low, high) = self.scene.table.bounds();
        let edge_m = (0.5 * (low + high)).dot(way) + (0.5 * (high - low)).dot(way.abs());
        let footprint = self.workspace.objects[target].footprint();
        let target_m = footprint.center().dot(way) + footprint.extent_m(way);
        let width_m = narrowest_width_m(self.workspace.objects[object].footprint().corners());
        edge_m - target_m >= width_m - MAX_DIRECTION_OVERLAP_M
    }

    /// The search for the place of an object; `None` if its predicates are about no place.
    fn query(
        &self,
        main: &GoalPredicate,
        object: usize,
        target: Option<usize>,
    ) -> Result<Option<PlaceQuery>, Refusal> {
        use PredicateKind as P;
        let second_target = main.second_target.as_ref().map(|name| self.index(name)).transpose()?;
        let pose = self.workspace.objects[object].body.world_from_object;
        let usual_yaw_rad = pose.yaw_rad().unwrap_or(0.0);
        let anywhere = PlaceQuery { usual_yaw_rad, ..PlaceQuery::default() };
        Ok(match main.predicate {
            P::OutOf | P::Off | P::AwayFrom => Some(anywhere),
            P::On if target.is_none() => Some(anywhere),
            P::Lifted | P::Opened | P::Closed | P::Upright | P::LyingOnSide | P::UpsideDown => None,
            P::Rotated | P::Moved | P::PouredInto | P::UsedOn | P::Pressed | P::Swapped => None,
            kind => Some(PlaceQuery { relation: Some(relation_of(kind)), target, second_target, ..anywhere }),
        })
    }

    /// The first free place where all predicates of the object hold, or why there is none.
    fn first_holding(
        &self,
        object: usize,
        query: &PlaceQuery,
        predicates: &[&GoalPredicate],
    ) -> Result<Candidate, Unplaced> {
        let candidates = self.workspace.places(object, query)?;
        let holds = |candidate: &&Candidate| {
            let mut trial = self.posed();
            trial[object] = trial[object].at(candidate.world_from_object);
            let situation =
                Situation { table: &self.scene.table, start: self.scene.posed(), now: &trial, contacts: &[] };
            predicates.iter().filter(|predicate| is_of_place(predicate.predicate)).all(|predicate| {
                let outcome = evaluate_predicate(predicate, &situation);
                // What is not there yet does not decide.
                outcome.holds || outcome.reason == Reason::NotExchanged
            })
        };
        candidates.iter().find(holds).copied().ok_or(Unplaced::HoldsNowhere)
    }

    /// The refusal of an object that would fit its target if the objects placed there before were not.
    fn crowded(
        &self,
        object: usize,
        target: usize,
        query: &PlaceQuery,
        predicates: &[&GoalPredicate],
    ) -> Option<Refusal> {
        let others: Vec<usize> =
            self.placed.iter().filter(|(_, at)| *at == Some(target)).map(|(other, _)| *other).collect();
        if others.is_empty() {
            return None;
        }
        let alone = EndState {
            scene: self.scene,
            workspace: self.scene.workspace().ok()?,
            placed: Vec::new(),
            space_m: self.space_m,
        };
        alone.first_holding(object, query, predicates).ok()?;
        let name = |index: usize| self.scene.posed()[index].name.clone();
        let objects = others.into_iter().chain([object]).map(name).collect();
        Some(Refusal::TargetTooSmall { objects, target: name(target) })
    }

    /// Each object at the other one's place, with its own orientation.
    fn swap(&mut self, predicate: &GoalPredicate, a: usize, b: usize) -> Result<(), Refusal> {
        let pair = [a, b];
        let before = pair.map(|object| self.workspace.objects[object].footprint());
        let supporters = pair.map(|object| self.workspace.objects[object].supporter);
        pair.iter().for_each(|object| self.workspace.objects[*object].is_placed = false);
        for k in 0..2 {
            let (object, other) = (pair[k], 1 - k);
            let pose = self.workspace.objects[object].body.world_from_object;
            let shift = (before[other].center() - before[k].center()).extend(0.0);
            let moved = Pose { translation_m: pose.translation_m + shift, ..pose };
            let found = self.workspace.place_at(object, moved, supporters[other]).map_err(|error| {
                Refusal::NoFreePlace { predicate: in_words(predicate), reason: error.to_string() }
            })?;
            self.put(object, found);
            self.workspace.objects[object].is_placed = true;
        }
        Ok(())
    }

    fn put(&mut self, object: usize, candidate: Candidate) {
        self.workspace.move_branch(object, candidate.world_from_object);
        self.workspace.objects[object].supporter = candidate.supporter;
    }

    fn posed(&self) -> Vec<PosedObject> {
        let objects = self.scene.posed().iter().zip(&self.workspace.objects);
        objects.map(|(posed, searched)| posed.at(searched.body.world_from_object)).collect()
    }
}

/// Order in which predicates of an object lead the search: supports, then relations, then the rest.
fn rank(kind: PredicateKind) -> u8 {
    use PredicateKind as P;
    match kind {
        P::In | P::StackedOn | P::Swapped => 0,
        P::On => 1,
        P::Between => 2,
        P::OutOf | P::Off => 5,
        P::AwayFrom => 4,
        kind if is_of_place(kind) => 3,
        _ => 6,
    }
}

/// Whether a predicate is about where objects are.
fn is_of_place(kind: PredicateKind) -> bool {
    use PredicateKind as P;
    !matches!(
        kind,
        P::Lifted
            | P::Opened
            | P::Closed
            | P::Upright
            | P::LyingOnSide
            | P::UpsideDown
            | P::Rotated
            | P::Moved
    )
}
