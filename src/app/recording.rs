//! The recorder of a running service, and what requests for episodes are checked with.

use std::path::Path;
use std::sync::Arc;

use serde::Deserialize;
use serde_json::Value;

use super::activity::unwatched;
use super::episodes::{EpisodesOrder, card, ordered, setup};
use super::executions::TaskSource;
use crate::api::Problem;
use crate::api::episodes::{CheckEpisodes, CheckedEpisodes, EpisodesBody};
use crate::config::Resolved;
use crate::recorder::{Preparation, Prepare, Recorder, Refusal};
use runtime::CpuPool;
use store::Store;

/// The recorder of a service, which works in a folder of `data_dir`.
pub fn recorder(store: &Store, resolved: &Resolved, cpu: &CpuPool, data_dir: &Path) -> Recorder {
    Recorder::new(store.clone(), cpu.clone(), data_dir, prepare(resolved), &resolved.config.worker)
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
    Refusal { code: problem.own_code(), message: problem.message() }
}
