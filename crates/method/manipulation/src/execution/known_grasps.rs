//! The grasps of the objects of a scene with one robot, each found once: those that are known from elsewhere, or those
//! that trials find.
//!
//! Whether an object of a scene can be grasped is decided here, so that there is one answer. Known grasps cost
//! nothing; trials take up to some seconds for an object. Equal scenes, settings and seeds give equal grasps.

use std::collections::BTreeMap;

use robot::model::Robot;
use runtime::seed::child_rng;
use tasks::Goal;

use super::{GraspBook, TaskScene};
use crate::grasp::{Grasp, GraspSettings, Verdict, grasps};
use crate::world::WorldError;

/// The grasps of the objects of a scene.
pub struct KnownGrasps<'a> {
    scene: &'a TaskScene,
    robot: &'a Robot,
    settings: &'a GraspSettings,
    seed: u64,
    known: GraspBook,
}

impl<'a> KnownGrasps<'a> {
    /// None is known. Those of an object depend on the seed and on nothing else in the scene.
    pub fn new(scene: &'a TaskScene, robot: &'a Robot, settings: &'a GraspSettings, seed: u64) -> Self {
        Self { scene, robot, settings, seed, known: BTreeMap::new() }
    }

    /// As [`Self::new`], where the grasps of some objects are known: these are not tried again.
    pub fn with(self, known: GraspBook) -> Self {
        Self { known, ..self }
    }

    /// The scene whose objects these are.
    pub fn scene(&self) -> &'a TaskScene {
        self.scene
    }

    pub fn robot(&self) -> &'a Robot {
        self.robot
    }

    /// Whether the grasps of an object are known without a trial.
    pub fn is_known(&self, name: &str) -> bool {
        self.known.contains_key(name)
    }

    /// The grasps of an object, the best first; none of an object that the scene does not have.
    ///
    /// # Errors
    /// If the object cannot be simulated.
    pub fn of(&mut self, name: &str) -> Result<&[Grasp], WorldError> {
        if !self.known.contains_key(name) {
            let object = self.scene.index(name).map(|index| &self.scene.objects[index]);
            let found = object.map(|object| {
                let mut rng = child_rng(self.seed, &format!("grasps of {name}"));
                grasps(object, self.robot, self.settings, &mut rng)
            });
            self.known.insert(name.to_owned(), found.transpose()?.unwrap_or_default());
        }
        Ok(self.known.get(name).map_or(&[], Vec::as_slice))
    }

    /// Whether a grasp of an object held it.
    ///
    /// # Errors
    /// As for [`Self::of`].
    pub fn one_held(&mut self, name: &str) -> Result<bool, WorldError> {
        Ok(self.of(name)?.iter().any(|grasp| grasp.verdict == Verdict::Stable))
    }

    /// The grasps of the objects that a goal moves.
    ///
    /// # Errors
    /// If one of them cannot be simulated.
    pub fn book(&mut self, goal: &Goal) -> Result<GraspBook, WorldError> {
        let mut book = GraspBook::new();
        for name in goal.moved_objects() {
            if self.scene.index(name.as_str()).is_some() {
                book.insert(name.to_string(), self.of(name.as_str())?.to_vec());
            }
        }
        Ok(book)
    }
}
