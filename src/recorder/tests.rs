//! Work on a recording that fails is tried again after a delay, as often as a job, and ends the recording then.

use std::io::ErrorKind;
use std::sync::atomic::{AtomicU32, Ordering};
use std::time::Instant;

use serde_json::json;

use super::*;
use crate::config::{Sources, layers};
use store::recordings::{MadeAttempt, NewRecording, RecordingState, SubmitRecordingOutcome};
use store::{BlobPlace, DEFAULT_TENANT, Digest, Intent};

const BASE: Duration = Duration::from_millis(200);

/// A recorder of one attempt at a time, three tries, and the delays 200 and 400 ms; it prepares with `prepare`.
async fn recorder(
    directory: &Path,
    prepare: impl Fn() -> Result<Preparation, Refusal> + Send + Sync + 'static,
) -> Recorder {
    let config = layers::load(Sources::default()).expect("the defaults are valid").config;
    let settings =
        Settings { max_attempts: 3, backoff_base_ms: 200, cpu_threads: 1, poll_ms: 20, ..config.worker };
    let store_settings = store::Settings { fsync: false, blobs: BlobPlace::Memory, ..config.store };
    let store = Store::open(directory, &store_settings, Intent::Create).await.expect("opens");
    Recorder::new(store, directory, Arc::new(move |_, _| prepare()), "process", Arc::new(settings))
}

/// Orders one episode in one attempt.
async fn ordered(recorder: &Recorder) -> RecordingId {
    let bundle = recorder.store.blobs().put(&b"bundle"[..]).await.expect("puts");
    let new = NewRecording {
        tenant_id: DEFAULT_TENANT.clone(),
        scene_id: "scene".parse().expect("an id"),
        request: json!({}),
        bundle,
        wanted: 1,
        max_attempts: 1,
        idempotency_key: None,
        body_digest: Digest::of(b"body"),
    };
    match recorder.store.submit_recording(new).await.expect("submits") {
        SubmitRecordingOutcome::Created(id) => id,
        other => panic!("{other:?}"),
    }
}

async fn row(recorder: &Recorder, id: &RecordingId) -> RecordingRow {
    recorder.store.recording(&DEFAULT_TENANT, id).await.expect("reads").expect("is there")
}

async fn claimed(recorder: &Recorder) -> Option<RecordingClaim> {
    let claimed = recorder.store.claim_recording("process", recorder.lease(), 9);
    claimed.await.expect("answers")
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_panic_in_an_attempt_is_tried_again_and_ends_the_recording_in_the_end() {
    let directory = tempfile::tempdir().expect("temporary directory");
    let tries = Arc::new(AtomicU32::new(0));
    let counted = tries.clone();
    let recorder = recorder(directory.path(), move || {
        counted.fetch_add(1, Ordering::Relaxed);
        panic!("a bug")
    })
    .await;
    let id = ordered(&recorder).await;
    let (began, shutdown) = (Instant::now(), CancellationToken::new());
    let running = tokio::spawn(recorder.clone().run(shutdown.clone()));
    let failed = async {
        while row(&recorder, &id).await.state != RecordingState::Failed {
            tokio::time::sleep(Duration::from_millis(10)).await;
        }
    };
    tokio::time::timeout(Duration::from_secs(20), failed).await.expect("it ends");
    shutdown.cancel();
    running.await.expect("ends");
    assert_eq!(tries.load(Ordering::Relaxed), 3);
    assert!(began.elapsed() >= BASE * 3, "it waited between");
    let row = row(&recorder, &id).await;
    assert_eq!(row.failure_code.as_deref(), Some("internal_error"));
    assert!(row.failure_message.expect("says what to do").contains("log"));
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_disk_that_refuses_ends_the_recording_after_its_tries() {
    let directory = tempfile::tempdir().expect("temporary directory");
    let recorder = recorder(directory.path(), || panic!("nothing is prepared")).await;
    let id = ordered(&recorder).await;
    let claim = claimed(&recorder).await.expect("there is work");
    let RecordingWork::Attempt(lease) = &claim.work else { panic!("an attempt") };
    let made = MadeAttempt { outcome: "success".into(), detail: String::new(), unit: None };
    recorder.store.keep_attempt(lease, made).await.expect("keeps");
    for tries in 1..=3 {
        let claim = loop {
            match claimed(&recorder).await {
                Some(claim) => break claim,
                None => tokio::time::sleep(Duration::from_millis(10)).await,
            }
        };
        assert_eq!(claim.tries, tries);
        let RecordingWork::Assembly(lease) = &claim.work else { panic!("all attempts are made") };
        let refused = RecordError::file("create", &recorder.folder)(ErrorKind::PermissionDenied.into());
        recorder.conclude_assembly(&claim, lease, Err(refused)).await;
        assert_eq!(claimed(&recorder).await, None, "it waits, or is over");
    }
    let row = row(&recorder, &id).await;
    assert_eq!(
        (row.state, row.failure_code.as_deref()),
        (RecordingState::Failed, Some("work_folder_unusable"))
    );
    let message = row.failure_message.expect("says what to do");
    assert!(message.contains("cannot create") && message.contains("permissions"), "{message}");
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_full_disk_is_waited_for() {
    let directory = tempfile::tempdir().expect("temporary directory");
    let recorder = recorder(directory.path(), || panic!("nothing is prepared")).await;
    let id = ordered(&recorder).await;
    let claim = claimed(&recorder).await.expect("there is work");
    let RecordingWork::Attempt(lease) = &claim.work else { panic!("an attempt") };
    let full = EpisodeError::DiskFull { path: directory.path().to_owned() };
    let verdict = RecordError::from(full).verdict();
    assert_eq!(verdict, Verdict::Again { code: "work_folder_unusable", charged: false });
    recorder.conclude_attempt(&claim, lease, Err(EpisodeError::DiskFull { path: "x".into() }.into())).await;
    assert_eq!(claimed(&recorder).await, None, "it waits long");
    assert_eq!(row(&recorder, &id).await.state, RecordingState::Running);
}
