//! What a benchmark runs stages with: a job of its own in a data directory of its own, and no worker.

use std::path::Path;
use std::sync::Arc;
use std::time::Duration;

use serde_json::json;

use crate::evaluate::layout::LayoutBench;
use crate::evaluate::pictures::{PictureBench, Reader};
use embedded::photograph::PictureReader;
use gpu::Compute;
use runtime::Cpu;
use scene::SceneRequest;
use store::scenes::{NewScene, Submitted};
use store::{DEFAULT_TENANT, Store, StoreError};
use tabletopgen::app::{AppError, BACKEND};
use tabletopgen::config::{Config, ConfigErrors, Resolved};
use tabletopgen::pipeline::checkpoint::{Checkpoints, Interrupt, JobScope, StageRuntime};

/// Nobody else works in the directory, so the claim never has to be renewed.
const LEASE: Duration = Duration::from_secs(30 * 24 * 3600);

/// The layout benchmark with the settings that `generate` would have.
pub fn layout_bench(config: &Config) -> LayoutBench {
    LayoutBench {
        embedded: tabletopgen::app::scenes::adapters(config),
        stages: Arc::new(tabletopgen::app::scenes::stages(config)),
    }
}

/// The picture benchmark with the settings that `generate` would have; with maps of the truth in place of the network's
/// where they are to be perfect.
pub fn picture_bench(resolved: &Resolved, perfect_maps: bool) -> Result<PictureBench, ConfigErrors> {
    let photograph = tabletopgen::app::scenes::adapters(&resolved.config).photograph;
    let reader = if perfect_maps {
        Reader::WithPerfectMaps(resolved.config.network.reading.clone())
    } else {
        Reader::Usual(PictureReader::new(tabletopgen::app::network::load(resolved)?, photograph.clone()))
    };
    Ok(PictureBench { reader, photograph })
}

/// The pool all computation of a run shares.
pub fn cpu(config: &Config) -> Result<Cpu, AppError> {
    let threads = config.worker.cpu_threads;
    Cpu::new(threads).map_err(|source| AppError::CpuPool { threads, source })
}

/// A scene that is worked on without a worker.
pub struct Opened {
    pub checkpoints: Checkpoints,
    pub store: Store,
    pub scene_id: String,
}

/// Submits the request in the data directory and claims its job.
pub async fn opened(
    data_dir: &Path,
    config: &Config,
    cpu: &Cpu,
    interrupt: &Interrupt,
    request: &SceneRequest,
) -> Result<Opened, AppError> {
    let store = tabletopgen::app::open(data_dir, config).await?;
    let new = NewScene {
        tenant_id: DEFAULT_TENANT.to_owned(),
        request: json!(request),
        labels: Default::default(),
        budget_micro_usd: request.options.budget(config.server.usual_budget_usd).0,
        idempotency: None,
    };
    let lost =
        |reason: &str| AppError::Store(StoreError::Corrupt { table: "jobs", reason: reason.to_owned() });
    let Submitted::Created { job_id, scene_id, .. } = store.submit(new).await? else {
        return Err(lost("a submission without a key was not new"));
    };
    let claim = store.claim("evaluation", LEASE, 1, Some(&job_id)).await?;
    let claim = claim.ok_or_else(|| lost("the job just submitted cannot be claimed"))?;
    let stage_timeout = Duration::from_secs(config.worker.stage_timeout_secs);
    let compute = Arc::new(Compute::new(&config.compute));
    let runtime =
        StageRuntime::new(store.clone(), cpu.clone(), compute, BACKEND, config.worker.fan_out, stage_timeout);
    let checkpoints = runtime.open(JobScope {
        lease: claim.lease,
        tenant_id: claim.tenant_id,
        salt: claim.salt,
        interrupt: interrupt.clone(),
        drain: Interrupt::default(),
    });
    Ok(Opened { checkpoints, store, scene_id })
}
