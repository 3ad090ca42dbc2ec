//! Order of episodes: the tasks, their number, the variation, and the recorded data.

use serde::{Deserialize, Serialize};
use serde_json::{Value, json};

use super::draft::EpisodesDraft;
use super::reading::{ordered, stated};
use crate::app::executions::TaskSource;
use crate::problem::{FieldError, Problem, ProblemType};
use demonstrations::camera::USUAL;
use demonstrations::{CameraSpec, Randomization};
use episodes::format::{Encodings, Format};

/// Largest number of episodes of an order.
pub const MAX_COUNT: u64 = 100_000;
/// Frames per second that can be recorded: the simulation has 500 steps a second.
pub const MAX_FPS: u32 = 100;

/// An order of demonstrations. Its JSON form is stored.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct EpisodesOrder {
    /// Of the dataset's cards; the instructions if absent.
    pub title: Option<String>,
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
    #[serde(with = "format_names")]
    pub formats: Vec<Format>,
    /// Whether failures become episodes, too; they do not count.
    pub keeps_failures: bool,
    /// Attempts until the order is given up.
    pub max_attempts: u64,
}

/// Most points in the cloud of a frame. Choosing them takes time with their square.
pub const MAX_POINTS: u32 = 8192;

/// The cameras of an order.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
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

/// Reason why a format cannot be made.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum FormatError {
    #[error("no format is named {name}; there are {known}")]
    Unknown { name: String, known: String },
    #[error(
        "{name} holds H.264 video, and this program was built without it; build with `--features video`, or choose \
         {name}-images"
    )]
    NotBuilt { name: &'static str },
}

/// The format of a name.
///
/// # Errors
///
/// [`FormatError::Unknown`], with all names.
fn format_named(name: &str) -> Result<Format, FormatError> {
    let named = Format::ALL.into_iter().find(|format| format.folder() == name);
    named.ok_or_else(|| {
        let known: Vec<&str> = Format::ALL.iter().map(|format| format.folder()).collect();
        FormatError::Unknown { name: name.to_owned(), known: known.join(", ") }
    })
}

/// The format of a name in an order that this program carries out.
///
/// # Errors
///
/// [`FormatError`] for an unknown name, and for a format with video in a program that was built without it.
pub fn makeable_format(name: &str) -> Result<Format, FormatError> {
    makeable(format_named(name)?, video::CAN_ENCODE)
}

fn makeable(format: Format, can_encode: bool) -> Result<Format, FormatError> {
    match format.has_video() && !can_encode {
        true => Err(FormatError::NotBuilt { name: format.folder() }),
        false => Ok(format),
    }
}

/// Formats as the names of their folders.
mod format_names {
    use serde::de::Error;
    use serde::{Deserialize, Deserializer, Serializer};

    use super::{Format, format_named};

    pub fn serialize<S: Serializer>(formats: &[Format], serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_seq(formats.iter().map(|format| format.folder()))
    }

    pub fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Vec<Format>, D::Error> {
        let names = Vec::<String>::deserialize(deserializer)?;
        names.iter().map(|name| format_named(name).map_err(D::Error::custom)).collect()
    }
}

impl EpisodesOrder {
    /// Version of the stored form.
    const VERSION: u32 = 2;

    /// The order as it is stored.
    pub fn stored(&self) -> Value {
        json!({ "version": Self::VERSION, "order": self })
    }

    /// Inverse of [`Self::stored`]. Reads version 1, too, which is a draft.
    ///
    /// # Errors
    ///
    /// A [`Problem`]: another version wrote the order, or it will not do any more.
    pub fn of_stored(stored: &Value) -> Result<Self, Problem> {
        let another_version = |error: serde_json::Error| {
            let detail =
                format!("the stored order belongs to another version ({error}); order the episodes again");
            Problem::new(ProblemType::InvalidRequest, "another_version", detail)
        };
        match stored["version"] == 1 {
            true => ordered(&EpisodesDraft::deserialize(&stored["order"]).map_err(another_version)?),
            false => Self::deserialize(&stored["order"]).map_err(another_version),
        }
    }

    /// A stored order as a client could have stated it. Version 1 was stored so; what another version wrote stays as it
    /// is.
    pub fn statement(stored: &Value) -> Value {
        let order = &stored["order"];
        match Self::deserialize(order) {
            Ok(read) if stored["version"] == Self::VERSION => json!(stated(&read)),
            _ => order.clone(),
        }
    }

    /// The title that was given, or the instructions.
    pub fn title(&self) -> String {
        let instructions = || self.tasks.iter().map(TaskSource::instruction).collect::<Vec<_>>().join("; ");
        self.title.clone().unwrap_or_else(instructions)
    }

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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn formats_with_video_need_the_encoder() {
        let [with_video, without] =
            ["lerobot-v2.1", "robomimic"].map(|name| format_named(name).expect("is known"));
        assert_eq!(makeable(with_video, true), Ok(with_video));
        assert_eq!(makeable(without, false), Ok(without));
        let why = makeable(with_video, false).expect_err("holds video").to_string();
        assert!(why.contains("--features video") && why.ends_with("lerobot-v2.1-images"), "{why}");
    }

    #[test]
    fn orders_of_both_versions_are_read() {
        let draft = json!({ "tasks": ["lift the mug", "put the mug on the plate"], "count": 3, "title": " Mugs ",
                            "formats": ["robomimic", "lerobot-v3.0"], "record": { "point_cloud": 100 } });
        let first = json!({ "version": 1, "order": draft });
        let order = EpisodesOrder::of_stored(&first).expect("version 1 is read");
        let stored = order.stored();
        assert_eq!(stored["version"], 2);
        let again = EpisodesOrder::of_stored(&stored).expect("version 2 is read");
        assert_eq!(again.stored(), stored);
        assert_eq!((again.title().as_str(), again.points, again.formats.len()), ("Mugs", Some(100), 2));
    }
}
