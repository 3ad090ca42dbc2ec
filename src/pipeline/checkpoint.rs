//! A stage is a function of its key; what it returned is found again instead of computed again.
//!
//! ```ignore
//! let reference = checkpoints.run(reference::STAGE, reference::Inputs { .. }, reference::run).await?;
//! let meshes = checkpoints.run_each(reconstruct::STAGE, inputs_by_instance, reconstruct::run).await?;
//! ```
//!
//! A stage function captures nothing (checked at compile time), and the very struct it receives is what
//! is hashed, so the key cannot forget an input. The output is stored as a JSON blob and handed on as it
//! reads back, so a resumed job sees exactly what an undisturbed one saw. Blob first, row second: the row
//! is the commit point, written under the job's lease. A blob or a row that is missing or unreadable is
//! a warning and a second run. Two jobs that want the same key at the same time compute it once: within
//! the process by a lock, across processes by a claim in the store under the job's lease.

pub mod artifact;
pub mod context;
mod key;
mod single_flight;

use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use futures::{StreamExt, stream};
use serde::Serialize;
use serde::de::DeserializeOwned;
use tokio::task::JoinError;
use tokio_util::task::AbortOnDropHandle;
use tracing::Instrument;
use tracing::field::Empty;

use super::error::{StageError, StageErrorClass};
use runtime::CpuPool;
use runtime::panic_text;
use scene::{InstanceId, TenantId};
use store::checkpoints::{Checkpoint, StageKey};
use store::stage_claims::StageStart;
use store::{Lease, Store, StoreError};

pub use artifact::ArtifactRef;
pub use context::StageContext;
pub use runtime::CancelFlag;
use single_flight::InProgress;

/// A stage's name and the version of its meaning. Raise the version when the same inputs give other
/// outputs than before.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Stage {
    /// `[a-z][a-z_]*`; also the folder of its artifacts.
    pub name: &'static str,
    pub version: u32,
}

/// Resources that all jobs of the process share: the store, the CPU pool, and the keys in progress.
#[derive(Clone)]
pub struct StageRuntime {
    store: Store,
    cpu: CpuPool,
    /// Hardware that the results depend on besides their inputs (`cpu`, a SIMD class); part of every key.
    backend: Arc<str>,
    /// Instances of one stage worked on at the same time.
    fan_out: usize,
    /// Longest time one stage (of one instance) may take.
    stage_timeout: Duration,
    in_progress: Arc<Mutex<InProgress>>,
}

/// Time that a stage may ignore an interrupt before its job goes on without it.
const INTERRUPT_GRACE: Duration = Duration::from_secs(2);

/// One job's right to run stages.
#[derive(Clone, Debug)]
pub struct JobScope {
    pub lease: Lease,
    pub tenant_id: TenantId,
    /// From the stage of the first name on, keys are salted with the second text, so that these stages run again.
    pub salt: Option<(String, String)>,
    /// Stop now: polled inside stages.
    pub cancel: CancelFlag,
    /// Stop at the next stage: found work is still handed out, nothing new is started.
    pub drain: CancelFlag,
}

/// The checkpoint as an argument: runs stages for one job, with what the stages need (`S`).
pub struct Checkpoints<S = ()> {
    runtime: StageRuntime,
    job: Arc<JobScope>,
    /// The names of the pipeline's stages in order, which decides what "from this stage on" means.
    order: &'static [&'static str],
    services: Arc<S>,
}

impl<S> Clone for Checkpoints<S> {
    fn clone(&self) -> Self {
        Self {
            runtime: self.runtime.clone(),
            job: self.job.clone(),
            order: self.order,
            services: self.services.clone(),
        }
    }
}

impl StageRuntime {
    /// `backend` names everything about this machine that changes results.
    pub fn new(store: Store, cpu: CpuPool, backend: &str, fan_out: usize, stage_timeout: Duration) -> Self {
        Self {
            store,
            cpu,
            backend: backend.into(),
            fan_out: fan_out.max(1),
            stage_timeout,
            in_progress: Arc::default(),
        }
    }

    /// The checkpoints of one job.
    pub fn open(&self, job: JobScope) -> Checkpoints {
        Checkpoints { runtime: self.clone(), job: Arc::new(job), order: &[], services: Arc::new(()) }
    }
}

impl<S: Send + Sync + 'static> Checkpoints<S> {
    /// The same checkpoints for a pipeline of these stages, in this order, which need `services` (the ports).
    pub fn for_stages<T>(self, order: &'static [&'static str], services: Arc<T>) -> Checkpoints<T> {
        Checkpoints { runtime: self.runtime, job: self.job, order, services }
    }

    pub fn services(&self) -> &S {
        &self.services
    }

    pub fn cancel(&self) -> &CancelFlag {
        &self.job.cancel
    }

    /// The output of `function` for `inputs`: found, or computed and committed.
    pub async fn run<I, O, F, Fut>(&self, stage: Stage, inputs: I, function: F) -> Result<O, StageError>
    where
        I: Serialize + Send + Sync + 'static,
        O: Serialize + DeserializeOwned + Send + 'static,
        F: Fn(StageContext<S>, Arc<I>) -> Fut + Copy + Send + 'static,
        Fut: Future<Output = Result<O, StageError>> + Send + 'static,
    {
        let key = self.key(stage, None, &inputs)?;
        self.clone().run_one(stage, None, key, Arc::new(inputs), function).await
    }

    /// The outputs of `function` for every instance, a bounded number at a time, one key each; outputs in input order.
    /// When instances fail, the others are finished (and kept) before the first failure is returned.
    pub async fn run_each<I, O, F, Fut>(
        &self,
        stage: Stage,
        inputs: Vec<(InstanceId, I)>,
        function: F,
    ) -> Result<Vec<O>, StageError>
    where
        I: Serialize + Send + Sync + 'static,
        O: Serialize + DeserializeOwned + Send + 'static,
        F: Fn(StageContext<S>, Arc<I>) -> Fut + Copy + Send + 'static,
        Fut: Future<Output = Result<O, StageError>> + Send + 'static,
    {
        self.run_each_by(stage, inputs, |_| 0, function).await
    }

    /// The outputs for every instance; those with the most `effort` are begun first, so that none of them is still at
    /// work when all others are done.
    pub async fn run_each_by<I, O, F, Fut>(
        &self,
        stage: Stage,
        inputs: Vec<(InstanceId, I)>,
        effort: fn(&I) -> u64,
        function: F,
    ) -> Result<Vec<O>, StageError>
    where
        I: Serialize + Send + Sync + 'static,
        O: Serialize + DeserializeOwned + Send + 'static,
        F: Fn(StageContext<S>, Arc<I>) -> Fut + Copy + Send + 'static,
        Fut: Future<Output = Result<O, StageError>> + Send + 'static,
    {
        let mut turns = inputs
            .into_iter()
            .enumerate()
            .map(|(index, (id, inputs))| {
                let (key, effort) = (self.key(stage, Some(&id), &inputs)?, effort(&inputs));
                let turn = self.clone().run_one(stage, Some(id), key, Arc::new(inputs), function);
                Ok((effort, async move { (index, turn.await) }))
            })
            .collect::<Result<Vec<_>, StageError>>()?;
        turns.sort_by_key(|(effort, _)| std::cmp::Reverse(*effort));
        let turns = turns.into_iter().map(|(_, turn)| turn);
        // A slow one keeps no other from starting.
        let mut results: Vec<(usize, Result<O, StageError>)> =
            stream::iter(turns).buffer_unordered(self.runtime.fan_out).collect().await;
        results.sort_by_key(|(index, _)| *index);
        let mut outputs = Vec::with_capacity(results.len());
        let mut failure: Option<StageError> = None;
        for (_, result) in results {
            match result {
                Ok(output) => outputs.push(output),
                Err(error) => {
                    let says_less = |kept: &StageError| kept.class == StageErrorClass::Cancelled;
                    if failure.as_ref().is_none_or(says_less) {
                        failure = Some(error);
                    }
                }
            }
        }
        failure.map_or(Ok(outputs), Err)
    }

    async fn run_one<I, O, F, Fut>(
        self,
        stage: Stage,
        instance: Option<InstanceId>,
        key: StageKey,
        inputs: Arc<I>,
        function: F,
    ) -> Result<O, StageError>
    where
        I: Serialize + Send + Sync + 'static,
        O: Serialize + DeserializeOwned + Send + 'static,
        F: Fn(StageContext<S>, Arc<I>) -> Fut + Copy + Send + 'static,
        Fut: Future<Output = Result<O, StageError>> + Send + 'static,
    {
        const { assert!(size_of::<F>() == 0, "a stage function captures nothing: pass it as an input") };
        let store = &self.runtime.store;
        let lock = self.runtime.lock_of(&key);
        let _computing = loop {
            self.job.cancel.check()?;
            if let Ok(guard) = tokio::time::timeout(Duration::from_millis(50), lock.lock()).await {
                break guard;
            }
        };
        let mut has_key = false;
        loop {
            if let Some((output, checkpoint)) = self.find(&key).await? {
                match store.stage_finished(&self.job.lease, &key, &checkpoint, true).await {
                    // A sweep has removed it since it was read.
                    Err(StoreError::CheckpointGone) => {}
                    done => {
                        done?;
                        count(stage, "found");
                        return Ok(output);
                    }
                }
            }
            if has_key {
                break;
            }
            self.job.drain.check()?;
            match store.stage_started(&self.job.lease, &key).await? {
                // Another job may have committed between the look-up and the claim, so it is looked up once more.
                StageStart::Granted => has_key = true,
                StageStart::ComputedBy(job_id) => self.wait_for(&key, &job_id).await?,
            }
        }
        let of_instance = key.instance.clone();
        let context = StageContext::new(
            stage,
            instance,
            store.clone(),
            self.job.clone(),
            self.runtime.cpu.clone(),
            self.services.clone(),
        );
        let artifacts = context.artifacts();
        let started = Instant::now();
        let span = tracing::info_span!(
            "stage",
            stage = stage.name,
            instance = of_instance.as_str(),
            outcome = Empty
        );
        let computed = self.compute(stage, function(context, inputs)).instrument(span.clone()).await;
        let outcome = if computed.is_ok() { "computed" } else { "failed" };
        span.record("outcome", outcome);
        count(stage, outcome);
        let output = match computed {
            Ok(output) => output,
            Err(error) => {
                // The worker after a dead one reuses recorded answers, but unusable answers must be asked for again.
                if error.discards_recorded_answers {
                    store.forget_answers(&self.job.lease, stage.name, &of_instance).await?;
                }
                // A job that waits for this key need not wait for the end of this one.
                if let Err(kept) = store.release_stage(&self.job.lease, &key).await {
                    tracing::debug!(
                        error = kept.chain(),
                        stage = stage.name,
                        "the claim ends with the job's lease"
                    );
                }
                return Err(error);
            }
        };
        let elapsed_ms = i64::try_from(started.elapsed().as_millis()).unwrap_or(i64::MAX);
        metrics::histogram!("tabletopgen_stage_seconds", "stage" => stage.name)
            .record(started.elapsed().as_secs_f64());

        let bytes = key::encode(stage, &output)?;
        // What the next stage gets is what a resumed job would read.
        let output = decode(&bytes).map_err(|error| {
            StageError::permanent(
                "output_not_storable",
                format!("stage {} returned a value that does not survive JSON (not a number?)", stage.name),
            )
            .because(error)
        })?;
        let checkpoint =
            Checkpoint { output: store.blobs().put(bytes).await?, artifacts: artifacts.sorted(), elapsed_ms };
        store.stage_finished(&self.job.lease, &key, &checkpoint, false).await?;
        Ok(output)
    }

    /// Runs the stage as a task of its own: a panic is an error, and letting go of the job stops it.
    async fn compute<O, Fut>(&self, stage: Stage, work: Fut) -> Result<O, StageError>
    where
        O: Send + 'static,
        Fut: Future<Output = Result<O, StageError>> + Send + 'static,
    {
        let task = AbortOnDropHandle::new(tokio::spawn(work.in_current_span()));
        let answered = async {
            tokio::select! {
                result = task => Some(result),
                () = self.interrupt_ignored() => None,
            }
        };
        match tokio::time::timeout(self.runtime.stage_timeout, answered).await {
            Ok(Some(Ok(Err(_)))) if self.job.cancel.check().is_err() => Err(StageError::cancelled()),
            Ok(Some(Ok(result))) => result,
            Ok(Some(Err(died))) => {
                Err(StageError::crashed(format!("stage {} died: {}", stage.name, died_of(died))))
            }
            // The task is aborted, so it writes nothing more; what it computes on the CPU pool is dropped at its end.
            Ok(None) => {
                tracing::warn!(
                    stage = stage.name,
                    "the stage ignores the interrupt; its job goes on without it"
                );
                Err(StageError::cancelled())
            }
            Err(_) => {
                // Nothing of this attempt may go on in the background.
                self.job.cancel.cancel();
                Err(StageError::transient(
                    "stage_timeout",
                    format!(
                        "stage {} took longer than worker.stage_timeout_secs = {}",
                        stage.name,
                        self.runtime.stage_timeout.as_secs()
                    ),
                ))
            }
        }
    }

    /// Returns when the job has been asked to stop for longer than its stages may take to notice.
    async fn interrupt_ignored(&self) {
        while self.job.cancel.check().is_ok() {
            tokio::time::sleep(Duration::from_millis(50)).await;
        }
        tokio::time::sleep(INTERRUPT_GRACE).await;
    }

    /// The salt of a stage's keys: `None` before the stage from which the job starts over.
    fn salt_of(&self, stage: &str) -> Option<&str> {
        let (from, salt) = self.job.salt.as_ref()?;
        let position = |name: &str| self.order.iter().position(|known| *known == name);
        // A stage that the order does not list comes after all others.
        let first = position(from)?;
        position(stage).is_none_or(|at| at >= first).then_some(salt.as_str())
    }

    fn key<I: Serialize>(
        &self,
        stage: Stage,
        instance: Option<&InstanceId>,
        inputs: &I,
    ) -> Result<StageKey, StageError> {
        let salt = self.salt_of(stage.name);
        let instance = instance.map_or("", InstanceId::as_str);
        Ok(StageKey {
            tenant_id: self.job.tenant_id.clone(),
            stage: stage.name.to_owned(),
            version: stage.version,
            instance: instance.to_owned(),
            key: key::digest(stage, inputs, instance, &self.runtime.backend, &self.job.tenant_id, salt)?,
        })
    }

    /// The stored output, if all of it is still there.
    async fn find<O: DeserializeOwned>(&self, key: &StageKey) -> Result<Option<(O, Checkpoint)>, StageError> {
        let store = &self.runtime.store;
        let Some(checkpoint) = store.checkpoint(key).await? else { return Ok(None) };
        let missing = |what: &str| {
            tracing::warn!(
                stage = key.stage,
                instance = key.instance,
                what,
                "stored work is gone; running again"
            );
        };
        let Some(bytes) = store.blobs().get(&checkpoint.output).await? else {
            missing("output");
            return Ok(None);
        };
        for artifact in &checkpoint.artifacts {
            if !store.blobs().contains(&artifact.digest).await? {
                missing(&artifact.name);
                return Ok(None);
            }
        }
        match decode(&bytes) {
            Ok(output) => Ok(Some((output, checkpoint))),
            Err(error) => {
                missing(&format!("readable output ({error})"));
                Ok(None)
            }
        }
    }
}

fn count(stage: Stage, outcome: &'static str) {
    metrics::counter!("tabletopgen_stages_total", "stage" => stage.name, "outcome" => outcome).increment(1);
}

/// Message of a task that panicked or was aborted.
fn died_of(died: JoinError) -> String {
    died.try_into_panic().map_or_else(|_| "it was aborted".into(), |panic| panic_text(&*panic))
}

fn decode<O: DeserializeOwned>(bytes: &[u8]) -> Result<O, serde_json::Error> {
    serde_json::from_slice(bytes)
}
