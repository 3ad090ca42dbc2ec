//! A freeze that panics is tried again after a delay, as often as a job, and fails then.

use std::time::Instant;

use serde_json::json;

use super::*;
use crate::config::{Sources, layers};
use store::datasets::{DatasetState, NewDataset, SubmitDatasetOutcome};
use store::{BlobPlace, DEFAULT_TENANT, Digest, Intent};

const BASE: Duration = Duration::from_millis(200);

async fn freezer(directory: &Path) -> Freezer {
    let config = layers::load(Sources::default()).expect("the defaults are valid").config;
    let settings = Settings { max_attempts: 3, backoff_base_ms: 200, ..config.worker };
    let store_settings = store::Settings { fsync: false, blobs: BlobPlace::Memory, ..config.store };
    let store = Store::open(directory, &store_settings, Intent::Create).await.expect("opens");
    Freezer::new(store, directory, "process", Arc::new(settings))
}

async fn claimed(freezer: &Freezer) -> Option<DatasetClaim> {
    freezer.store.claim_dataset("process", freezer.lease(), 9).await.expect("answers")
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_freeze_that_panics_waits_and_fails_in_the_end() {
    let directory = tempfile::tempdir().expect("temporary directory");
    let freezer = freezer(directory.path()).await;
    let new = NewDataset {
        tenant_id: DEFAULT_TENANT.clone(),
        name: "mugs".into(),
        request: json!({}),
        idempotency_key: None,
        body_digest: Digest::of(b"body"),
    };
    let SubmitDatasetOutcome::Created(id) = freezer.store.submit_dataset(new).await.expect("submits") else {
        panic!("it is new")
    };
    let folder = directory.path().join("work");
    let mut free_at = Instant::now();
    for attempt in 1..=3 {
        let claim = loop {
            match claimed(&freezer).await {
                Some(claim) => break claim,
                None => tokio::time::sleep(Duration::from_millis(10)).await,
            }
        };
        assert!(Instant::now() >= free_at, "attempt {attempt} comes too early");
        assert_eq!(claim.attempt, attempt);
        std::fs::create_dir_all(&folder).expect("creates");
        // On a thread of its own, as the work that blocks; and in the task itself.
        let worked = match attempt {
            1 => guarded(async { apart(|| panic!("a bug")).await }).await,
            _ => guarded(async { panic!("a bug") }).await,
        };
        assert!(matches!(worked, Err(FreezeError::Panicked)), "{worked:?}");
        freezer.conclude(&claim, &folder, worked).await;
        free_at = Instant::now() + BASE * (1 << (attempt - 1)) - Duration::from_millis(50);
        assert_eq!(claimed(&freezer).await, None, "it is not taken at once");
        assert_eq!(folder.exists(), attempt < 3, "what was copied is used again, until the end");
    }
    let row = freezer.store.dataset(&DEFAULT_TENANT, &id).await.expect("reads").expect("is there");
    assert_eq!((row.state, row.failure_code.as_deref()), (DatasetState::Failed, Some("internal_error")));
    assert!(row.failure_message.expect("says what to do").contains("log"));
}
