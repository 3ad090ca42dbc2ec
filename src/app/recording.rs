//! The recorder of a running service, and what requests for episodes are checked with.

use std::path::Path;
use std::sync::Arc;

use serde::Deserialize;
use serde_json::Value;
use tokio_util::sync::CancellationToken;

use super::activity::unwatched;
use super::episodes::{EpisodesOrder, card, ordered, setup};
use super::executions::TaskSource;
use crate::api::Problem;
use crate::api::episodes::{CheckEpisodes, CheckedEpisodes, EpisodesBody};
use crate::background::kept_running;
use crate::config::Resolved;
use crate::recorder::{Preparation, Prepare, Recorder, Refusal};
use store::Store;

/// Records episodes from now on until `shutdown`, in a folder of `data_dir`, as `owner`.
pub fn start(store: &Store, resolved: &Resolved, data_dir: &Path, owner: &str, shutdown: &CancellationToken) {
    let settings = Arc::new(resolved.config.worker.clone());
    let recorder = Recorder::new(store.clone(), data_dir, prepare(resolved), owner, settings);
    let shutdown = shutdown.clone();
    tokio::spawn(kept_running("recorder of episodes", move || recorder.clone().run(shutdown.clone())));
}

/// Checks orders of episodes, for the interface.
pub fn check(_: &Resolved) -> CheckEpisodes {
    Arc::new(|body| {
        let order = ordered(body)?;
        Ok(CheckedEpisodes { count: order.count, max_attempts: order.max_attempts })
    })
}

/// Prepares what was ordered, for the recorder.
fn prepare(resolved: &Resolved) -> Prepare {
    let resolved = resolved.clone();
    Arc::new(move |archive: &[u8], request: &Value| {
        let body = EpisodesBody::deserialize(&request["order"]).map_err(|error| Refusal {
            code: "another_version",
            message: format!(
                "the stored order belongs to another version ({error}); order the episodes again"
            ),
        })?;
        let order = ordered(&body).map_err(refusal)?;
        let setup = setup(archive, &order, &resolved, &unwatched).map_err(refusal)?;
        let card = card(title(&body, &order), &resolved, &setup);
        Ok(Preparation { setup, card, keeps_failures: order.keeps_failures })
    })
}

/// The title that was given, or the instructions.
fn title(body: &EpisodesBody, order: &EpisodesOrder) -> String {
    let instruction = |task: &TaskSource| match task {
        TaskSource::Text(text) => text.trim().to_owned(),
        TaskSource::Task(task) => task.instruction.clone(),
    };
    let instructions = || order.tasks.iter().map(instruction).collect::<Vec<_>>().join("; ");
    body.title.as_ref().map_or_else(instructions, |title| title.trim().to_owned())
}

/// A problem as the failure of a recording.
fn refusal(problem: Problem) -> Refusal {
    let errors: Vec<String> =
        problem.errors.iter().map(|error| format!("{} {}", error.pointer, error.detail)).collect();
    let message = if errors.is_empty() { problem.detail } else { errors.join("; ") };
    Refusal { code: problem.code, message }
}
