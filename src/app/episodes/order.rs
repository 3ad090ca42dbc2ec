//! Order of episodes: the tasks, their number, the variation, and the recorded data.

use crate::api::error::{FieldError, Problem};
use crate::app::executions::TaskSource;
use demonstrations::camera::USUAL;
use demonstrations::{CameraSpec, Randomization};
use episodes::format::{Encodings, Format};

/// Largest number of episodes of an order.
pub const MAX_COUNT: u64 = 100_000;
/// Frames per second that can be recorded: the simulation has 500 steps a second.
pub const MAX_FPS: u32 = 100;

/// An order of demonstrations.
#[derive(Clone, Debug)]
pub struct EpisodesOrder {
    /// Tasks that take turns.
    pub tasks: Vec<TaskSource>,
    pub robot: String,
    /// Episodes that succeed.
    pub count: u64,
    /// Everything is drawn from it.
    pub seed: u64,
    pub randomization: Randomization,
    pub cameras: Cameras,
    pub fps: u32,
    pub depth: bool,
    pub instance_ids: bool,
    /// Points in the cloud of each frame; `None` without clouds.
    pub points: Option<u32>,
    pub formats: Vec<Format>,
    /// Whether failures become episodes, too; they do not count.
    pub keeps_failures: bool,
    /// Attempts until the order is given up.
    pub max_attempts: u64,
}

/// Most points in the cloud of a frame. Choosing them takes time with their square.
pub const MAX_POINTS: u32 = 8192;

/// The cameras of an order.
#[derive(Clone, Debug)]
pub enum Cameras {
    /// Some of the usual ones, with square images.
    Usual {
        names: Vec<String>,
        side_px: u32,
    },
    Own(Vec<CameraSpec>),
}

impl Cameras {
    fn is_empty(&self) -> bool {
        match self {
            Self::Usual { names, .. } => names.is_empty(),
            Self::Own(cameras) => cameras.is_empty(),
        }
    }
}

/// The format of a name.
///
/// # Errors
///
/// For people, with all names.
pub fn format_named(name: &str) -> Result<Format, String> {
    let names: Vec<&str> = Format::ALL.iter().map(|format| format.folder()).collect();
    Format::ALL
        .into_iter()
        .find(|format| format.folder() == name)
        .ok_or_else(|| format!("no format is named {name}; there are {}", names.join(", ")))
}

impl EpisodesOrder {
    /// The usual number of attempts for so many episodes.
    pub fn usual_max_attempts(count: u64) -> u64 {
        4 * count + 20
    }

    /// Checks what needs no scene.
    ///
    /// # Errors
    ///
    /// A [`Problem`] with every value that will not do.
    pub fn check(&self) -> Result<(), Problem> {
        let mut errors = Vec::new();
        let mut require = |holds: bool, pointer: &str, detail: String| {
            if !holds {
                errors.push(FieldError::new(pointer, detail));
            }
        };
        require(!self.tasks.is_empty(), "/tasks", "must name at least one task".into());
        let count = (1..=MAX_COUNT).contains(&self.count);
        require(count, "/count", format!("must be from 1 to {MAX_COUNT}"));
        require(self.max_attempts >= self.count, "/max_attempts", "must not be below the count".into());
        let fps = (1..=MAX_FPS).contains(&self.fps);
        require(fps, "/fps", format!("must be from 1 to {MAX_FPS}"));
        require(!self.formats.is_empty(), "/formats", "must name at least one format".into());
        if let Cameras::Usual { names, .. } = &self.cameras {
            for name in names {
                let known = USUAL.contains(&name.as_str());
                let detail = format!("{name} is none of the usual cameras: {}", USUAL.join(", "));
                require(known, "/cameras", detail);
            }
        }
        let points = self.points.is_none_or(|points| (1..=MAX_POINTS).contains(&points));
        require(points, "/point_cloud", format!("must be from 1 to {MAX_POINTS} points"));
        let kept = Encodings::of(&self.formats).kept_measures();
        let wanted = [self.depth, self.instance_ids, self.points.is_some()];
        for (index, pointer) in ["/depth", "/instance_ids", "/point_cloud"].into_iter().enumerate() {
            let is_wanted = wanted[index];
            require(!is_wanted || !self.cameras.is_empty(), pointer, "needs a camera".into());
            // Where there are no formats, that is the fault.
            let is_kept = kept[index] || self.formats.is_empty();
            let keeps = |format: &&Format| Encodings::of(&[**format]).kept_measures()[index];
            let names: Vec<&str> = Format::ALL.iter().filter(keeps).map(|format| format.folder()).collect();
            let detail = format!("is kept by none of the formats; add one of {}", names.join(", "));
            require(!is_wanted || is_kept, pointer, detail);
        }
        for violation in self.randomization.violations() {
            require(false, &format!("/randomize{}", violation.pointer), violation.detail);
        }
        if errors.is_empty() { Ok(()) } else { Err(Problem::invalid(errors)) }
    }
}
