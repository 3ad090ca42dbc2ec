//! Benchmark environment: one job in its own data directory, without a worker.

use std::path::Path;
use std::sync::Arc;
use std::time::Duration;

use serde_json::json;

use crate::benchmark::images::{BesideImage, ImageBench, Reader};
use crate::benchmark::layout::LayoutBench;
use embedded::single_view_reconstruction::{ImageReader, ReadingNetwork};
use gpu::Compute;
use runtime::CpuPool;
use scene::{SceneId, SceneRequest};
use store::queue::Scope;
use store::scenes::{NewScene, SubmitOutcome};
use store::{DEFAULT_TENANT, Intent, Store, StoreError};
use tabletopgen::app::{AppError, BACKEND};
use tabletopgen::config::{Config, ConfigErrors, Resolved};
use tabletopgen::pipeline::checkpoint::{CancelFlag, Checkpoints, JobScope, StageRuntime};

/// No other process uses the directory, so the lease is never renewed.
const LEASE: Duration = Duration::from_secs(30 * 24 * 3600);

/// The layout benchmark with the settings of `generate`.
pub fn layout_bench(config: &Config) -> LayoutBench {
    LayoutBench {
        compute: Arc::new(Compute::new(&config.compute)),
        embedded: tabletopgen::app::pipeline::adapters(config),
        network: ReadingNetwork::built_in(config.network.reading.clone()),
        stages: Arc::new(tabletopgen::app::pipeline::stages(config)),
    }
}

/// The image benchmark with the settings of `generate`; with `perfect_maps`, ground-truth maps replace the
/// network's.
pub fn image_bench(
    resolved: &Resolved,
    perfect_maps: bool,
    with_text: bool,
    beside: BesideImage,
) -> Result<ImageBench, ConfigErrors> {
    let single_view = tabletopgen::app::pipeline::adapters(&resolved.config).photograph;
    let network = tabletopgen::app::network::load(resolved)?;
    let reader = if perfect_maps {
        Reader::PerfectMaps(resolved.config.network.reading.clone())
    } else {
        Reader::Usual(ImageReader::new(network.clone(), single_view.clone()))
    };
    let text_parser = with_text.then(|| resolved.config.analyst.clone());
    Ok(ImageBench { reader, network, single_view, text_parser, beside })
}

/// The CPU pool shared by all computation of a run.
pub fn cpu(config: &Config) -> Result<CpuPool, AppError> {
    let threads = config.worker.cpu_threads;
    CpuPool::new(threads).map_err(|source| AppError::CpuPool { threads, source })
}

/// A claimed scene without a worker.
pub struct Opened {
    pub checkpoints: Checkpoints,
    pub store: Store,
    pub scene_id: SceneId,
}

/// Submits the request in the data directory and claims its job.
pub async fn opened(
    data_dir: &Path,
    config: &Config,
    cpu: &CpuPool,
    cancel: &CancelFlag,
    request: &SceneRequest,
) -> Result<Opened, AppError> {
    let store = tabletopgen::app::open(data_dir, config, Intent::Create).await?;
    let new = NewScene {
        tenant_id: DEFAULT_TENANT.clone(),
        parent_id: None,
        request: json!(request),
        labels: Default::default(),
        budget_micro_usd: request.options.budget(config.server.usual_budget_usd).0,
        idempotency: None,
    };
    let lost =
        |reason: &str| AppError::Store(StoreError::Corrupt { table: "jobs", reason: reason.to_owned() });
    let SubmitOutcome::Created { job_id, scene_id, .. } = store.submit(new).await? else {
        return Err(lost("a submission without a key was not new"));
    };
    let claim = store.claim("evaluation", LEASE, 1, &Scope::Job(job_id.clone())).await?;
    let claim = claim.ok_or_else(|| lost("the job just submitted cannot be claimed"))?;
    let salt = claim.scene().and_then(|scene| scene.salt.clone());
    let stage_timeout = Duration::from_secs(config.worker.stage_timeout_secs);
    let runtime =
        StageRuntime::new(store.clone(), cpu.clone(), BACKEND, config.worker.fan_out, stage_timeout);
    let checkpoints = runtime.open(JobScope {
        lease: claim.lease,
        tenant_id: claim.tenant_id,
        salt,
        cancel: cancel.clone(),
        drain: CancelFlag::default(),
    });
    Ok(Opened { checkpoints, store, scene_id })
}
