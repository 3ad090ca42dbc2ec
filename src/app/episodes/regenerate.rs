//! An episode of a dataset made again from its record, and whether it is the same to the byte.

use serde::Deserialize;
use serde_json::{Value, json};

use super::distractors::distractors;
use super::order::{FormatError, makeable_format};
use super::{parts_of, refused};
use crate::app::executions::bundle_of;
use crate::app::grasps::known_grasps;
use crate::app::tasks::robot_named;
use crate::config::Resolved;
use crate::problem::{Problem, ProblemType};
use demonstrations::setup::{Wanted, prepare};
use demonstrations::{Attempted, EpisodeRecord, Setup, TaskPlace, attempt, record};
use episodes::{EpisodeError, EpisodeUnit};

/// A line of `records.jsonl`, as far as it is needed.
#[derive(Clone, Debug, Deserialize)]
pub struct RecordedEpisode {
    pub episode_index: u64,
    pub number: u64,
    pub success: bool,
    /// Formats of the dataset: its encodings depend on them.
    pub formats: Vec<String>,
    /// Of the unit that the episode was assembled from.
    pub digest: String,
    pub record: EpisodeRecord,
}

/// An episode that was made again.
pub struct Regenerated {
    pub unit: EpisodeUnit,
    /// Whether it has the digest that was recorded.
    pub is_same: bool,
}

/// Reason why an episode is not read from its records.
#[derive(Debug, thiserror::Error)]
pub enum RecordsError {
    #[error("has {episodes} episodes, numbered from 0")]
    NoEpisode { episodes: usize },
    #[error("is damaged at episode {episode_index}: {source}")]
    Damaged { episode_index: u64, source: serde_json::Error },
    #[error("has records of the form {found}; this program repeats {}", record::FORMAT)]
    OtherFormat { found: Value },
}

/// An attempt that ended without a motion, so that there is no episode.
#[derive(Debug, thiserror::Error)]
#[error("this time the attempt ended with {reason}: {detail}")]
pub struct NoMotion {
    reason: String,
    detail: String,
}

/// Finds the episode of an index in the text of a `records.jsonl`.
///
/// # Errors
///
/// [`RecordsError`] if there is no such episode, and for a line of another version.
pub fn recorded_episode(records: &str, episode_index: u64) -> Result<RecordedEpisode, RecordsError> {
    let line = records.lines().nth(usize::try_from(episode_index).unwrap_or(usize::MAX));
    let line = line.ok_or_else(|| RecordsError::NoEpisode { episodes: records.lines().count() })?;
    let damaged = |source| RecordsError::Damaged { episode_index, source };
    let document: Value = serde_json::from_str(line).map_err(damaged)?;
    let found = &document["record"]["format"];
    if *found != json!(record::FORMAT) {
        return Err(RecordsError::OtherFormat { found: found.clone() });
    }
    serde_json::from_str(line).map_err(damaged)
}

/// The setup in which an episode was recorded, with its task alone.
///
/// # Errors
///
/// A [`Problem`] for a bundle that is not the one of the record, and those of [`super::setup`].
pub fn setup_of(archive: &[u8], episode: &RecordedEpisode, resolved: &Resolved) -> Result<Setup, Problem> {
    let record = &episode.record;
    let bundle = bundle_of(archive)?;
    let mut parts = parts_of(archive, &bundle)?;
    if parts.digest != record.scene {
        let detail = format!(
            "the episode was recorded in the bundle with the digest {}, this one has {}",
            record.scene, parts.digest
        );
        return Err(Problem::new(ProblemType::Conflict, "another_scene", detail));
    }
    let robot = robot_named(&record.task.robot)?;
    let formats = episode.formats.iter().map(|name| makeable_format(name)).collect::<Result<_, _>>();
    let unmade =
        |error: FormatError| Problem::new(ProblemType::InvalidRequest, "broken_record", error.to_string());
    let formats = formats.map_err(unmade)?;
    let config = &resolved.config;
    let task = record.task.clone();
    let mut known = known_grasps(&bundle, &parts.scene, &robot, &config.grasps, record.dataset_seed);
    let work = prepare(&robot, task, &mut known, &config.execution).map_err(|error| refused(&error))?;
    parts.distractors = distractors(&bundle, &record.randomization, record.dataset_seed, resolved);
    let wanted = Wanted {
        cameras: record.cameras.clone(),
        fps: record.fps,
        depth: record.depth,
        instance_ids: record.instance_ids,
        points: record.points,
        randomization: record.randomization,
        seed: record.dataset_seed,
        formats,
        place: Some(TaskPlace { index: record.task_index, instructions: record.tasks.clone() }),
    };
    Setup::new(parts, robot, vec![work], wanted, &config.execution).map_err(|error| refused(&error))
}

/// Makes the episode again.
///
/// # Errors
///
/// As [`attempt`]; the inner error says that there was no motion this time.
pub fn regenerate(
    setup: &Setup,
    episode: &RecordedEpisode,
) -> Result<Result<Regenerated, NoMotion>, EpisodeError> {
    let unit = match attempt(setup, episode.number, !episode.success)? {
        Attempted::Succeeded(unit) | Attempted::Failed { unit: Some(unit), .. } => unit,
        Attempted::Failed { reason, detail, unit: None } => {
            return Ok(Err(NoMotion { reason, detail }));
        }
    };
    let is_same = unit.digest() == episode.digest;
    Ok(Ok(Regenerated { unit: *unit, is_same }))
}
