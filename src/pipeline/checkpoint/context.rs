//! Resources of a stage function besides its inputs: a place for bytes, the CPU pool, the interrupt, the services. None
//! of them may change the result; everything that may is in the inputs.

use std::sync::Arc;

use bytes::Bytes;
use serde::Serialize;
use serde::de::DeserializeOwned;

use super::artifact::{ArtifactRef, Artifacts, is_valid_name};
use super::{CancelFlag, JobScope, Stage};
use crate::pipeline::error::StageError;
use crate::pipeline::ledger::JobLedger;
use ports::call::Call;
use runtime::CpuPool;
use scene::InstanceId;
use store::{Digest, Store};

/// One run of one stage.
pub struct StageContext<S = ()> {
    stage: Stage,
    instance: Option<InstanceId>,
    store: Store,
    job: Arc<JobScope>,
    cpu: CpuPool,
    services: Arc<S>,
    artifacts: Artifacts,
}

impl<S> Clone for StageContext<S> {
    fn clone(&self) -> Self {
        Self {
            stage: self.stage,
            instance: self.instance.clone(),
            store: self.store.clone(),
            job: self.job.clone(),
            cpu: self.cpu.clone(),
            services: self.services.clone(),
            artifacts: self.artifacts.clone(),
        }
    }
}

impl<S> StageContext<S> {
    pub(super) fn new(
        stage: Stage,
        instance: Option<InstanceId>,
        store: Store,
        job: Arc<JobScope>,
        cpu: CpuPool,
        services: Arc<S>,
    ) -> Self {
        Self { stage, instance, store, job, cpu, services, artifacts: Artifacts::default() }
    }

    pub(super) fn artifacts(&self) -> Artifacts {
        self.artifacts.clone()
    }

    pub fn stage_name(&self) -> &'static str {
        self.stage.name
    }

    /// The instance this run is for, inside `run_each`.
    pub fn instance(&self) -> Option<&InstanceId> {
        self.instance.as_ref()
    }

    /// Services that the pipeline hands to its stages (the ports).
    pub fn services(&self) -> &Arc<S> {
        &self.services
    }

    /// Hand this to computations; they poll it at least every 50 ms.
    pub fn cancel(&self) -> &CancelFlag {
        &self.job.cancel
    }

    /// Runs a blocking computation on the CPU pool.
    pub async fn cpu<T, W>(&self, work: W) -> Result<T, StageError>
    where
        T: Send + 'static,
        W: FnOnce() -> T + Send + 'static,
    {
        self.job.cancel.check()?;
        Ok(self.cpu.run(work).await?)
    }

    /// Context of a call to a port.
    pub fn call(&self) -> Call {
        let (store, lease) = (self.store.clone(), self.job.lease.clone());
        let ledger = JobLedger::new(store, lease, self.stage.name, self.instance.clone());
        Call { cpu: self.cpu.clone(), cancel: self.job.cancel.clone(), ledger: Arc::new(ledger) }
    }

    /// Stores bytes under `<stage>/[<instance>/]<name>`; they appear among the scene's artifacts once
    /// the stage is finished.
    pub async fn put(
        &self,
        name: &str,
        media_type: &str,
        bytes: impl Into<Bytes>,
    ) -> Result<ArtifactRef, StageError> {
        if !is_valid_name(name) {
            return Err(StageError::permanent(
                "invalid_artifact_name",
                format!("stage {} named an artifact {name:?}", self.stage.name),
            ));
        }
        let name = match &self.instance {
            Some(instance) => format!("{}/{instance}/{name}", self.stage.name),
            None => format!("{}/{name}", self.stage.name),
        };
        let bytes = bytes.into();
        let size = bytes.len() as u64;
        let digest = self.store.blobs().put(bytes).await?;
        let artifact = ArtifactRef { name, digest, media_type: media_type.to_owned(), size };
        self.artifacts.add(&artifact);
        Ok(artifact)
    }

    /// Stores a value as readable JSON.
    pub async fn put_json<T: Serialize>(&self, name: &str, value: &T) -> Result<ArtifactRef, StageError> {
        let mut bytes = serde_json::to_vec_pretty(value).map_err(|error| {
            StageError::permanent("artifact_not_storable", format!("{name} cannot be written as JSON"))
                .because(error)
        })?;
        bytes.push(b'\n');
        self.put(name, "application/json", bytes).await
    }

    /// Bytes an earlier stage (or this one) put.
    pub async fn get(&self, artifact: &ArtifactRef) -> Result<Bytes, StageError> {
        self.blob(&artifact.digest, &artifact.name).await
    }

    /// Value of an artifact that was put as JSON.
    pub async fn get_json<T: DeserializeOwned>(&self, artifact: &ArtifactRef) -> Result<T, StageError> {
        let bytes = self.get(artifact).await?;
        serde_json::from_slice(&bytes).map_err(|error| {
            StageError::permanent("artifact_unreadable", format!("artifact {} cannot be read", artifact.name))
                .because(error)
        })
    }

    /// Bytes known by digest alone, such as the image of a request; `what` names them in an error.
    pub async fn blob(&self, digest: &Digest, what: &str) -> Result<Bytes, StageError> {
        // The stage that made them runs again on the next attempt, because its blob is gone.
        self.store.blobs().get(digest).await?.ok_or_else(|| {
            StageError::transient("artifact_missing", format!("stored bytes of {what} are gone"))
        })
    }

    /// Publishes a progress message for the watchers of the job.
    pub async fn note(&self, message: impl Into<String>) -> Result<(), StageError> {
        Ok(self.store.note(&self.job.lease, self.stage.name, message.into()).await?)
    }
}
