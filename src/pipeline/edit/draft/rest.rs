//! Placing and settling of the objects of a draft.

use glam::DVec3;

use super::Draft;
use crate::pipeline::edit::error::EditError;
use editing::{Candidate, PlaceQuery, RestFault, RestSettings, Workspace};
use geometry::Pose;
use physics::settle::angle_between_rad;
use scene::{RelationKind, SupportRelation, Supporter};

/// Contents that move and turn by less stay where they are, meters and radians.
const STAYS_M: f64 = 0.0005;
const STAYS_RAD: f64 = 0.01;

/// An upright axis that turns farther than this has fallen over, radians.
const FALLEN_RAD: f64 = 0.2;

impl Draft<'_> {
    /// The surface that carries an object, within a distance of the object's place.
    pub fn near_by(&self, object: usize, within_m: f64) -> PlaceQuery {
        let supporter = self.supporter(object);
        let relation = supporter.parent.map(|_| RelationKind::from(supporter.relation));
        PlaceQuery {
            relation,
            target: supporter.parent,
            near_m: Some(self.center_m(object)),
            within_m: Some(within_m),
            usual_yaw_rad: self.pose(object).yaw_rad().unwrap_or(0.0),
            ..PlaceQuery::default()
        }
    }

    /// Lets everything in containers come to rest together where one of the contents has moved, as each was put down
    /// while the others were fixed, or has left: the others may have leaned on it. What stays where it is keeps its
    /// exact pose.
    ///
    /// # Errors
    ///
    /// [`EditError::RestlessContents`] for a container whose contents do not come to rest.
    pub fn settle_containers(&mut self) -> Result<(), EditError> {
        for container in 0..self.len() {
            let contents: Vec<usize> = self
                .load(container)
                .into_iter()
                .filter(|object| self.supporter(*object).relation == SupportRelation::In)
                .collect();
            let has_moved =
                |object: &usize| self.parent_poses.get(self.name(*object)) != Some(&self.pose(*object));
            let is_new_together = contents.len() > 1 && contents.iter().any(has_moved);
            if contents.is_empty() || !(is_new_together || self.has_lost(container, &contents)) {
                continue;
            }
            let moving: Vec<usize> =
                contents.iter().flat_map(|object| self.workspace.branch(*object)).collect();
            let cause = format!("it lies in {}, whose contents changed", self.name(container));
            let mut settled = self.workspace.clone();
            settled.come_to_rest(&moving, self.rest, &self.cancel).map_err(|fault| {
                EditError::RestlessContents { container: self.name(container).to_owned(), fault }
            })?;
            if !self.stay_in(&settled, &moving) {
                self.workspace = settled;
                self.may_move(&moving, &cause);
            }
        }
        Ok(())
    }

    /// Whether something that was in a container of the parent is not among its contents.
    fn has_lost(&self, container: usize, contents: &[usize]) -> bool {
        let is_there = |name: &String| contents.iter().any(|object| self.name(*object) == name);
        let before = self.parent_contents.get(self.name(container));
        before.is_some_and(|names| !names.iter().all(is_there))
    }

    /// Searches a place for an object and lets it come to rest there, with what rests on it. For what falls over there,
    /// such as a pen that leaned in its holder, a place is searched again as it lies.
    ///
    /// # Errors
    ///
    /// [`EditError`] if there is no place, or the object does not stay there.
    pub fn find_and_rest(&mut self, object: usize, query: &PlaceQuery) -> Result<(), EditError> {
        let Err(why) = self.find_as_it_is(object, query) else { return Ok(()) };
        let Some(lying) = self.fallen_over(object, query) else { return Err(why) };
        let standing = std::mem::replace(&mut self.workspace, lying);
        self.find_as_it_is(object, query).map_err(|_| {
            self.workspace = standing;
            why
        })
    }

    /// The workspace with an object in the orientation in which it comes to rest where a query would have it; `None` if
    /// that is the one of now, or something rests on it.
    fn fallen_over(&self, object: usize, query: &PlaceQuery) -> Option<Workspace> {
        if self.workspace.branch(object).len() > 1 {
            return None;
        }
        let first = *self.workspace.places(object, query).ok()?.first()?;
        let (may_roll, mut fallen) = (RestSettings { may_roll: true, ..self.rest }, self.workspace.clone());
        fallen.put_down(object, &first, may_roll, &self.cancel).ok()?;
        let (now, then) = (self.pose(object), fallen.objects[object].body.world_from_object);
        let up = |pose: &Pose| pose.transform_vector(DVec3::Z);
        let mut lying = self.workspace.clone();
        lying.objects[object].body.world_from_object.rotation = then.rotation;
        (up(&now).angle_between(up(&then)) > FALLEN_RAD).then_some(lying)
    }

    /// As [`Self::find_and_rest`], in the orientation of now or turned about the vertical.
    fn find_as_it_is(&mut self, object: usize, query: &PlaceQuery) -> Result<(), EditError> {
        let candidates = self.workspace.places(object, query)?;
        let mut fault = RestFault::LeftPlace;
        for candidate in &candidates {
            self.cancel.check()?;
            let mut rested = self.workspace.clone();
            match rested.put_down(object, candidate, self.rest, &self.cancel) {
                Ok(()) if rested.meets(object, query) => {
                    self.workspace = rested;
                    return Ok(());
                }
                Ok(()) => fault = RestFault::LeftPlace,
                Err(error) => fault = error,
            }
        }
        // A round object rolls wherever it is put; it may, as long as its relation still holds where it rests.
        let may_roll = RestSettings { may_roll: true, ..self.rest };
        let has_slipped = matches!(fault, RestFault::Slipped { .. })
            && query.position_m.is_none()
            && query.yaw_rad.is_none();
        for candidate in candidates.iter().filter(|_| has_slipped) {
            let mut rolled = self.workspace.clone();
            let put = rolled.put_down(object, candidate, may_roll, &self.cancel);
            if put.is_ok() && rolled.meets(object, query) && rolled.is_on_table(object) {
                self.workspace = rolled;
                return Ok(());
            }
        }
        Err(self.leaves(object, self.workspace.place_in_words(query), fault))
    }

    /// Lets an object come to rest straight below or above a pose.
    ///
    /// # Errors
    ///
    /// [`EditError`] if there is no room, or the object does not stay.
    pub fn rest_at(&mut self, object: usize, pose: Pose, supporter: Supporter) -> Result<(), EditError> {
        self.rest_with(object, pose, supporter, None)
    }

    /// As [`Self::rest_at`], with a stated yaw at rest.
    ///
    /// # Errors
    ///
    /// [`EditError`] if there is no room, or the object does not stay.
    pub fn rest_turned(
        &mut self,
        object: usize,
        pose: Pose,
        supporter: Supporter,
        yaw_rad: f64,
    ) -> Result<(), EditError> {
        self.rest_with(object, pose, supporter, Some(yaw_rad))
    }

    fn rest_with(
        &mut self,
        object: usize,
        pose: Pose,
        supporter: Supporter,
        stated_yaw_rad: Option<f64>,
    ) -> Result<(), EditError> {
        let place = self.workspace.place_at(object, pose, supporter)?;
        let candidate = Candidate { stated_yaw_rad, ..place };
        self.workspace
            .put_down(object, &candidate, self.rest, &self.cancel)
            .map_err(|fault| self.leaves(object, "there".to_owned(), fault))
    }

    fn leaves(&self, object: usize, place: String, fault: RestFault) -> EditError {
        EditError::LeavesPlace { object: self.name(object).to_owned(), place, fault }
    }

    /// Lets objects come to rest again on or in what carries them now: where they are, or else near.
    ///
    /// # Errors
    ///
    /// [`EditError`] if there is no room for one of them.
    pub fn rest_again(&mut self, objects: &[(usize, Supporter)], cause: &str) -> Result<(), EditError> {
        for &(object, supporter) in objects {
            self.may_move(&self.workspace.branch(object), cause);
            let mut anchored = self.workspace.objects[object].clone();
            anchored.is_placed = true;
            anchored.supporter = supporter;
            self.workspace.objects[object] = anchored;
            let pose = self.pose(object);
            let is_container = supporter.relation == SupportRelation::In && supporter.parent.is_some();
            if !is_container && self.rest_at(object, pose, supporter).is_ok() {
                continue;
            }
            let query = PlaceQuery { within_m: None, ..self.near_by(object, 0.0) };
            let found = self.find_and_rest(object, &query);
            let anywhere = PlaceQuery { relation: None, target: None, ..query };
            match found {
                Err(_) if supporter.parent.is_some() => self.find_and_rest(object, &anywhere)?,
                found => found?,
            }
        }
        if objects.len() > 1 {
            self.rest_together(objects, cause);
        }
        Ok(())
    }

    /// Lets objects move at the same time that came to rest one by one: each of them took those before it as fixed, and
    /// round ones that lean on each other roll on. Where they do not come to rest together they stay as they are.
    fn rest_together(&mut self, objects: &[(usize, Supporter)], cause: &str) {
        let moving: Vec<usize> =
            objects.iter().flat_map(|(object, _)| self.workspace.branch(*object)).collect();
        let mut settled = self.workspace.clone();
        let rolling = RestSettings { may_roll: true, ..self.rest };
        if settled.come_to_rest(&moving, rolling, &self.cancel).is_err() {
            return;
        }
        if !self.stay_in(&settled, &moving) {
            self.workspace = settled;
            self.may_move(&moving, cause);
        }
    }

    /// Whether all of these objects are where they are in another workspace.
    fn stay_in(&self, settled: &Workspace, moving: &[usize]) -> bool {
        moving.iter().all(|object| {
            let (before, after) = (self.pose(*object), settled.objects[*object].body.world_from_object);
            before.translation_m.distance(after.translation_m) < STAYS_M
                && angle_between_rad(&before, &after) < STAYS_RAD
        })
    }
}
