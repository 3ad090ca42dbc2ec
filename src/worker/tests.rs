//! Jobs of every kind by the same rules: panics, cancellations, a stop of the process, and slots.

use std::sync::atomic::{AtomicU32, Ordering};

use futures::future::BoxFuture;
use serde_json::json;

use super::*;
use crate::config::{Sources, layers};
use crate::pipeline::error::StageError;
use scene::{DatasetId, RecordingId};
use store::datasets::{FrozenVersion, NewDataset, SubmitDatasetOutcome};
use store::executions::{NewExecution, SubmitExecutionOutcome};
use store::lifecycle::JobState;
use store::queue::AttemptOutcome;
use store::recordings::{MadeAttempt, NewRecording, SubmitRecordingOutcome};
use store::scenes::{NewScene, SubmitOutcome};
use store::{BlobPlace, DEFAULT_TENANT, Digest, Intent};

const LEASE: Duration = Duration::from_secs(60);

/// Planted behavior of every kind of work.
#[derive(Clone, Copy)]
enum Plant {
    Panic,
    /// Goes on until it is stopped.
    Endless,
}

struct Planted {
    plant: Plant,
    runs: AtomicU32,
}

impl Work for Planted {
    fn kinds(&self) -> &'static [JobKind] {
        &JobKind::ALL
    }

    fn slots(&self, _: &Settings) -> usize {
        2
    }

    fn run(self: Arc<Self>, attempt: WorkAttempt) -> BoxFuture<'static, Result<AttemptOutcome, StageError>> {
        Box::pin(async move {
            self.runs.fetch_add(1, Ordering::Relaxed);
            match self.plant {
                Plant::Panic => panic!("a planted bug"),
                Plant::Endless => attempt.stopped().await,
            }
            Err(StageError::cancelled())
        })
    }
}

/// A store with what is needed to enqueue jobs of every kind.
struct TestQueue {
    store: Store,
    settings: Settings,
    _directory: tempfile::TempDir,
}

struct Running {
    planted: Arc<Planted>,
    stop: CancellationToken,
    worker: tokio::task::JoinHandle<Result<(), StoreError>>,
}

impl Running {
    async fn end(self) -> u32 {
        self.stop.cancel();
        self.worker.await.expect("ends").expect("in good order");
        self.planted.runs.load(Ordering::Relaxed)
    }
}

impl TestQueue {
    async fn new() -> Self {
        let directory = tempfile::tempdir().expect("temporary directory");
        let config = layers::load(Sources::default()).expect("the defaults are valid").config;
        let settings = Settings { max_attempts: 3, backoff_base_ms: 200, poll_ms: 20, ..config.worker };
        let store_settings = store::Settings { fsync: false, blobs: BlobPlace::Memory, ..config.store };
        let store = Store::open(directory.path(), &store_settings, Intent::Create).await.expect("opens");
        Self { store, settings, _directory: directory }
    }

    /// Ends a waiting job of this kind.
    async fn finish(&self, kind: JobKind, outcome: AttemptOutcome) {
        let scope = Scope::Kinds(vec![kind]);
        let claim = self.store.claim("setup", LEASE, 9, &scope).await.expect("answers");
        self.store.finish(&claim.expect("there is a job").lease, outcome).await.expect("finishes");
    }

    /// The id of a waiting job of this kind, after whatever has to come before it.
    async fn waiting(&self, kind: JobKind) -> JobId {
        match kind {
            JobKind::Generate => return self.scene().await,
            JobKind::Retry => {
                let job = self.scene().await;
                self.store.cancel(&DEFAULT_TENANT, &job).await.expect("answers");
                self.store.retry(&DEFAULT_TENANT, &job, None).await.expect("answers");
            }
            JobKind::FreezeDataset => {
                self.dataset().await;
            }
            JobKind::VerifyDataset => {
                let id = self.dataset().await;
                let (digest, summary) = ("d".to_owned(), json!({}));
                let version = FrozenVersion { version: 1, digest, summary, paths: Vec::new() };
                self.finish(JobKind::FreezeDataset, AttemptOutcome::Frozen(version)).await;
                self.store.verify_dataset(&DEFAULT_TENANT, &id).await.expect("answers");
            }
            JobKind::RecordAttempt => {
                self.recording().await;
            }
            JobKind::ExecuteTask => {
                let scene_id = "scene".parse().expect("an id");
                let (tenant_id, request) = (DEFAULT_TENANT.clone(), json!({ "version": 1 }));
                let (bundle, idempotency) = (Digest::of(b"bundle"), None);
                let new = NewExecution { tenant_id, scene_id, request, bundle, idempotency };
                match self.store.submit_execution(new).await.expect("submits") {
                    SubmitExecutionOutcome::Created(job_id) => return job_id,
                    other => panic!("{other:?}"),
                }
            }
            JobKind::AssembleRecording => {
                self.recording().await;
                let made = MadeAttempt { outcome: "success".into(), detail: String::new(), unit: None };
                self.finish(JobKind::RecordAttempt, AttemptOutcome::Attempted(made)).await;
            }
        }
        let filter = store::jobs::JobFilter { kind: Some(kind), limit: 1, ..Default::default() };
        self.store.jobs(&DEFAULT_TENANT, filter).await.expect("reads").remove(0).id
    }

    async fn scene(&self) -> JobId {
        let new = NewScene {
            tenant_id: DEFAULT_TENANT.clone(),
            parent_id: None,
            request: json!({ "version": 1 }),
            labels: Default::default(),
            budget_micro_usd: 0,
            idempotency: None,
        };
        match self.store.submit(new).await.expect("submits") {
            SubmitOutcome::Created { job_id, .. } => job_id,
            other => panic!("{other:?}"),
        }
    }

    async fn dataset(&self) -> DatasetId {
        let new = NewDataset {
            tenant_id: DEFAULT_TENANT.clone(),
            name: "mugs".into(),
            request: json!({ "version": 1 }),
            idempotency_key: None,
            body_digest: Digest::of(b"body"),
        };
        match self.store.submit_dataset(new).await.expect("submits") {
            SubmitDatasetOutcome::Created(id) => id,
            other => panic!("{other:?}"),
        }
    }

    async fn recording(&self) -> RecordingId {
        let new = NewRecording {
            tenant_id: DEFAULT_TENANT.clone(),
            scene_id: "scene".parse().expect("an id"),
            request: json!({ "version": 1 }),
            bundle: Digest::of(b"bundle"),
            wanted: 1,
            max_attempts: 1,
            idempotency_key: None,
            body_digest: Digest::of(b"body"),
        };
        match self.store.submit_recording(new).await.expect("submits") {
            SubmitRecordingOutcome::Created(id) => id,
            other => panic!("{other:?}"),
        }
    }

    /// Starts a worker with planted work.
    fn start(&self, plant: Plant) -> Running {
        let planted = Arc::new(Planted { plant, runs: AtomicU32::new(0) });
        let worker = Worker::new(self.store.clone(), self.settings.clone()).with(planted.clone());
        let stop = CancellationToken::new();
        Running { planted, stop: stop.clone(), worker: tokio::spawn(worker.run(stop)) }
    }

    async fn job(&self, id: &JobId) -> store::jobs::JobRow {
        self.store.job(&DEFAULT_TENANT, id).await.expect("reads").expect("is there")
    }

    /// Waits until a job has a state.
    async fn until(&self, id: &JobId, state: JobState) {
        let reached = async {
            while self.job(id).await.state != state {
                tokio::time::sleep(Duration::from_millis(10)).await;
            }
        };
        tokio::time::timeout(Duration::from_secs(20), reached).await.expect("comes to that state");
    }
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_job_of_any_kind_that_panics_is_tried_again_and_fails() {
    for kind in JobKind::ALL {
        let queue = TestQueue::new().await;
        let job = queue.waiting(kind).await;
        let running = queue.start(Plant::Panic);
        queue.until(&job, JobState::Failed).await;
        assert_eq!(running.end().await, 3, "{kind:?}");
        let row = queue.job(&job).await;
        assert_eq!(row.failure_code.as_deref(), Some("internal_error"), "{kind:?}");
        assert!(row.failure_message.expect("says what to do").contains("log"), "{kind:?}");
    }
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_running_job_of_any_kind_is_cancelled() {
    for kind in JobKind::ALL {
        let queue = TestQueue::new().await;
        let job = queue.waiting(kind).await;
        let running = queue.start(Plant::Endless);
        queue.until(&job, JobState::Running).await;
        queue.store.cancel(&DEFAULT_TENANT, &job).await.expect("answers");
        queue.until(&job, JobState::Cancelled).await;
        assert_eq!(running.end().await, 1, "{kind:?}");
    }
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_job_of_any_kind_is_given_back_when_the_process_stops() {
    for kind in JobKind::ALL {
        let queue = TestQueue::new().await;
        let job = queue.waiting(kind).await;
        let running = queue.start(Plant::Endless);
        queue.until(&job, JobState::Running).await;
        running.end().await;
        let row = queue.job(&job).await;
        assert_eq!((row.state, row.attempt), (JobState::Queued, 0), "{kind:?}");
    }
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_worker_holds_as_many_jobs_as_it_has_slots() {
    let queue = TestQueue::new().await;
    for _ in 0..3 {
        queue.scene().await;
    }
    let running = queue.start(Plant::Endless);
    let both = async {
        while running.planted.runs.load(Ordering::Relaxed) < 2 {
            tokio::time::sleep(Duration::from_millis(10)).await;
        }
    };
    tokio::time::timeout(Duration::from_secs(20), both).await.expect("two are begun");
    tokio::time::sleep(Duration::from_millis(100)).await;
    assert_eq!(running.end().await, 2);
}
