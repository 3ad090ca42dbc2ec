//! One scene, built in this process the way the server builds it: submitted to the store, taken by a
//! worker, followed through its events.

use tokio_util::sync::CancellationToken;

use super::AppError;
use super::submission::Submission;
use crate::config::Config;
use crate::worker::BuildScene;
use scene::{JobId, SceneId};
use store::events::Event;
use store::jobs::JobRow;
use store::scenes::{SceneRow, SubmitOutcome};
use store::{DEFAULT_TENANT, Outage, Store, StoreError};

/// End of a local job.
#[derive(Debug)]
pub enum Ended {
    /// The job came to an end of its own, or was cancelled.
    Job { scene: Box<SceneRow>, job: Box<JobRow> },
    /// Storage took no writes, so that not even the end could be written down.
    Storage(Outage),
}

/// Submits, works, follows. `tell` gets every event in order, `cancel` asks the job to stop. Other jobs
/// of the data directory are left alone.
pub async fn run(
    store: &Store,
    config: &Config,
    build: BuildScene,
    submission: Submission,
    cancel: CancellationToken,
    mut tell: impl FnMut(&Event),
) -> Result<Ended, AppError> {
    let budget_usd = config.server.usual_budget_usd;
    let new = submission.into_row(store, DEFAULT_TENANT.clone(), budget_usd, None).await?;
    // The caller of this process has the first place, however many jobs the data directory holds.
    let (scene_id, job_id) = match store.submit(new).await? {
        SubmitOutcome::Created { scene_id, job_id, .. } | SubmitOutcome::Replayed { scene_id, job_id } => {
            (scene_id, job_id)
        }
        SubmitOutcome::KeyReused | SubmitOutcome::Refused(_) => {
            return Err(lost("a submission without a key and without limits was refused"));
        }
    };
    let stop = CancellationToken::new();
    let worker = super::worker(store, config, &super::cpu_pool(config)?, build).only(&job_id);
    let worker = tokio::spawn(worker.run(stop.clone()));
    let ended = follow(store, &scene_id, &job_id, &cancel, &mut tell).await;
    stop.cancel();
    match worker.await {
        Ok(result) => result?,
        Err(died) => return Err(AppError::WorkerEnded { reason: died.to_string() }),
    }
    ended
}

async fn follow(
    store: &Store,
    scene_id: &SceneId,
    job_id: &JobId,
    cancel: &CancellationToken,
    tell: &mut impl FnMut(&Event),
) -> Result<Ended, AppError> {
    let (mut changes, mut outage) = (store.changes(), store.outage());
    let (mut seen, mut cancelled) = (0, false);
    loop {
        changes.mark_unchanged();
        // The state first: when it is final, the events read after it are all there will be.
        let job = store.job(&DEFAULT_TENANT, job_id).await?.ok_or_else(|| lost("the job's row is gone"))?;
        let events = store.events(&DEFAULT_TENANT, job_id, seen, 1000).await?;
        for event in &events {
            seen = event.seq;
            tell(event);
        }
        if job.state.is_final() && events.is_empty() {
            let scene = store.scene(&DEFAULT_TENANT, scene_id).await?;
            let scene = scene.ok_or_else(|| lost("the scene's row is gone"))?;
            return Ok(Ended::Job { scene: Box::new(scene), job: Box::new(job) });
        }
        if !events.is_empty() {
            continue;
        }
        tokio::select! {
            _ = changes.changed() => {}
            // A user waits for this process, so it does not wait until the disk has space again.
            Ok(why) = outage.wait_for(Option::is_some) => {
                return Ok(Ended::Storage(why.unwrap_or(Outage::Other)));
            }
            () = cancel.cancelled(), if !cancelled => {
                cancelled = true;
                store.cancel(&DEFAULT_TENANT, job_id).await?;
            }
        }
    }
}

fn lost(reason: &str) -> AppError {
    AppError::Store(StoreError::Corrupt { table: "jobs", reason: reason.to_owned() })
}
