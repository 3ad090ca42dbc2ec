//! Datasets: one process works on each, freezes of one name follow each other, and files outlive sweeps.

use super::*;
use crate::datasets::{
    DatasetFile, DatasetFilter, DatasetRow, DatasetState, FrozenVersion, NewDataset, SubmitDatasetOutcome,
    VerifyOutcome,
};
use crate::jobs::RetryOutcome;
use crate::queue::{AttemptOutcome, CancelOutcome, ClaimedWork};
use crate::retention::RetentionSettings;
use scene::DatasetId;

const LEASE: Duration = Duration::from_secs(60);

pub(super) fn new_dataset(name: &str) -> NewDataset {
    NewDataset {
        tenant_id: DEFAULT_TENANT.clone(),
        name: name.into(),
        request: json!({ "version": 1 }),
        idempotency_key: None,
        body_digest: Digest::of(b"body"),
    }
}

pub(super) async fn submitted_dataset(store: &Store, name: &str) -> DatasetId {
    match store.submit_dataset(new_dataset(name)).await.expect("submits") {
        SubmitDatasetOutcome::Created(id) => id,
        other => panic!("{other:?}"),
    }
}

/// Jobs of datasets.
pub(super) fn freezing() -> Scope {
    Scope::Kinds(vec![JobKind::FreezeDataset, JobKind::VerifyDataset])
}

async fn claim(store: &Store, owner: &str) -> Option<Claim> {
    store.claim(owner, LEASE, MAX_DEATHS, &freezing()).await.expect("answers")
}

/// The dataset of a claimed job.
pub(super) fn dataset_of(claim: &Claim) -> &DatasetRow {
    match &claim.work {
        ClaimedWork::FreezeDataset(dataset) | ClaimedWork::VerifyDataset(dataset) => dataset,
        other => panic!("{other:?}"),
    }
}

fn failure(code: &str) -> Failure {
    Failure { class: FailureClass::Permanent, code: code.into(), message: "none".into() }
}

pub(super) fn file(path: &str, content: &[u8]) -> DatasetFile {
    let digest = Digest::of(content);
    DatasetFile { path: path.into(), digest, size: content.len() as u64, media_type: "text/plain".into() }
}

pub(super) fn frozen(version: i64, paths: &[&str]) -> AttemptOutcome {
    let paths = paths.iter().map(|path| (*path).to_owned()).collect();
    AttemptOutcome::Frozen(FrozenVersion {
        version,
        digest: "d".into(),
        summary: json!({ "scenes": 1 }),
        paths,
    })
}

pub(super) async fn freezes_of_one_name_follow_each_other(place: Place) {
    let (one, other) = (place.handle(0), place.handle(1));
    let first = submitted_dataset(&one, "mugs").await;
    let second = submitted_dataset(&one, "mugs").await;
    let elsewhere = submitted_dataset(&one, "jugs").await;
    let claimed = claim(&one, "a").await.expect("there is work");
    assert_eq!((&dataset_of(&claimed).id, claimed.work.kind()), (&first, JobKind::FreezeDataset));
    assert_eq!(dataset_of(&claim(&other, "a").await.expect("there is work")).id, elsewhere);
    assert_eq!(claim(&other, "a").await, None, "the second one of the name waits");
    one.finish(&claimed.lease, frozen(1, &[])).await.expect("finishes");
    let latest = one.latest_version(&DEFAULT_TENANT, "mugs").await.expect("reads").expect("a version");
    assert_eq!((latest.id, latest.version, latest.state), (first, Some(1), DatasetState::Finished));
    let claimed = claim(&other, "a").await.expect("there is work");
    assert_eq!(dataset_of(&claimed).id, second);
    let failed = AttemptOutcome::Failed(failure("no_dataset"));
    other.finish(&claimed.lease, failed).await.expect("finishes");
    let row = one.dataset(&DEFAULT_TENANT, &second).await.expect("reads").expect("is there");
    assert_eq!((row.state, row.failure_code.as_deref()), (DatasetState::Failed, Some("no_dataset")));
    let filter = |name: Option<&str>, state| DatasetFilter {
        name: name.map(str::to_owned),
        state,
        limit: 10,
        ..DatasetFilter::default()
    };
    for (filter, count) in [
        (filter(None, None), 3),
        (filter(Some("mugs"), None), 2),
        (filter(Some("mugs"), Some(DatasetState::Finished)), 1),
        (filter(None, Some(DatasetState::Queued)), 0),
    ] {
        assert_eq!(one.datasets(&DEFAULT_TENANT, filter).await.expect("reads").len(), count);
    }
}

pub(super) async fn of_claims_at_once_each_dataset_goes_to_one_process(place: Place) {
    for _ in 0..3 {
        submitted_dataset(place.store(), "same").await;
    }
    let claims: Vec<_> = (0..8)
        .map(|index| {
            let store = place.handle(index);
            tokio::spawn(async move { store.claim("a", LEASE, MAX_DEATHS, &freezing()).await })
        })
        .collect();
    let mut claimed = 0;
    for claim in claims {
        claimed += i32::from(claim.await.expect("runs").expect("answers").is_some());
    }
    assert_eq!(claimed, 1, "one of the name at a time");
}

pub(super) async fn a_dead_freezer_is_replaced_and_fenced(place: Place) {
    let store = place.store();
    let id = submitted_dataset(store, "mugs").await;
    let dead = store.claim("a", Duration::ZERO, MAX_DEATHS, &freezing()).await.expect("answers");
    let dead = dead.expect("there is work");
    store.record_dataset_file(&dead.lease, file("old", b"old")).await.expect("records");
    let alive = claim(store, "b").await.expect("its lease has ended");
    assert_eq!((&dataset_of(&alive).id, alive.lease.epoch), (&id, dead.lease.epoch + 1));
    assert_eq!(claim(store, "b").await, None, "this lease has not ended");
    for late in [
        store.record_dataset_file(&dead.lease, file("late", b"late")).await,
        store.note_dataset_steps(&dead.lease, (9, 9)).await,
        store.finish(&dead.lease, frozen(7, &[])).await.map(drop),
    ] {
        assert!(matches!(late, Err(StoreError::LeaseLost { .. })), "{late:?}");
    }
    store.note_dataset_steps(&alive.lease, (1, 2)).await.expect("notes");
    let row = store.dataset(&DEFAULT_TENANT, &id).await.expect("reads").expect("is there");
    assert_eq!((row.state, row.steps), (DatasetState::Running, (1, 2)));
    store.record_dataset_file(&alive.lease, file("new", b"new")).await.expect("records");
    store.finish(&alive.lease, frozen(1, &["new"])).await.expect("finishes");
    let paths: Vec<String> =
        store.dataset_files(&id).await.expect("reads").into_iter().map(|file| file.path).collect();
    assert_eq!(paths, ["new"], "what the dead one recorded is no file of the version");
    // Given back, it is begun again, and that is no attempt.
    let id = submitted_dataset(store, "jugs").await;
    for _ in 0..9 {
        let released = claim(store, "a").await.expect("there is work");
        assert_eq!((&dataset_of(&released).id, released.attempt), (&id, 1));
        store.finish(&released.lease, AttemptOutcome::Released).await.expect("gives back");
    }
}

pub(super) async fn a_version_is_verified_on_request(place: Place) {
    let store = place.store();
    let id = submitted_dataset(store, "mugs").await;
    let early = store.verify_dataset(&DEFAULT_TENANT, &id).await.expect("answers");
    assert_eq!(early, VerifyOutcome::NotFrozen(DatasetState::Queued));
    let claimed = claim(store, "a").await.expect("there is work");
    store.finish(&claimed.lease, frozen(1, &[])).await.expect("finishes");
    assert_eq!(claim(store, "a").await, None);
    for _ in 0..2 {
        let outcome = store.verify_dataset(&DEFAULT_TENANT, &id).await.expect("answers");
        assert_eq!(outcome, VerifyOutcome::Accepted);
    }
    let claimed = claim(store, "a").await.expect("there is work");
    assert_eq!((&dataset_of(&claimed).id, claimed.work.kind()), (&id, JobKind::VerifyDataset));
    assert_eq!(dataset_of(&claimed).state, DatasetState::Finished, "it can be downloaded meanwhile");
    let found = AttemptOutcome::Verified(json!({ "intact": true }));
    store.finish(&claimed.lease, found).await.expect("finishes");
    assert_eq!(claim(store, "a").await, None);
    let row = store.dataset(&DEFAULT_TENANT, &id).await.expect("reads").expect("is there");
    assert_eq!(
        (row.verify_state.as_deref(), row.verification),
        (Some("finished"), Some(json!({ "intact": true })))
    );
}

pub(super) async fn a_freeze_is_cancelled_and_repeated_as_any_job(place: Place) {
    let store = place.store();
    let id = submitted_dataset(store, "mugs").await;
    let row = async || store.dataset(&DEFAULT_TENANT, &id).await.expect("reads").expect("is there");
    let job = row().await.job_id.expect("a job");
    let claimed = claim(store, "a").await.expect("there is work");
    assert_eq!(claimed.lease.job_id, job);
    store.record_dataset_file(&claimed.lease, file("one", b"one")).await.expect("records");
    let accepted = store.cancel(&DEFAULT_TENANT, &job).await.expect("answers");
    assert_eq!(accepted, CancelOutcome::Accepted(JobState::Cancelling));
    let state = store.finish(&claimed.lease, frozen(1, &["one"])).await.expect("ends");
    assert_eq!(state, JobState::Cancelled, "the version came too late");
    let cancelled = row().await;
    assert_eq!(
        (cancelled.state, cancelled.failure_code.as_deref()),
        (DatasetState::Failed, Some("cancelled"))
    );
    assert_eq!(store.dataset_files(&id).await.expect("reads"), []);

    let retry = async |job: &JobId| store.retry(&DEFAULT_TENANT, job, None).await.expect("answers");
    let RetryOutcome::Created { job_id: again } = retry(&job).await else { panic!("it had no version") };
    assert_eq!((row().await.state, row().await.job_id.as_ref()), (DatasetState::Queued, Some(&again)));
    assert_eq!(retry(&job).await, RetryOutcome::NothingToRepeat, "it has a newer job");
    assert_eq!(retry(&again).await, RetryOutcome::StillActive);
    let claimed = claim(store, "a").await.expect("there is work");
    store.finish(&claimed.lease, frozen(1, &[])).await.expect("finishes");
    assert_eq!(retry(&again).await, RetryOutcome::NothingToRepeat, "it has a version");

    // A verification that is cancelled leaves the version as it was.
    store.verify_dataset(&DEFAULT_TENANT, &id).await.expect("answers");
    let verification = row().await.job_id.expect("a job");
    store.cancel(&DEFAULT_TENANT, &verification).await.expect("answers");
    let row = row().await;
    assert_eq!((row.state, row.verify_state, row.failure_code), (DatasetState::Finished, None, None));
}

pub(super) async fn files_and_keys_belong_to_their_dataset_and_tenant(place: Place) {
    let store = place.store();
    let keyed = |body: &[u8]| NewDataset {
        idempotency_key: Some("key".into()),
        body_digest: Digest::of(body),
        ..new_dataset("mugs")
    };
    let SubmitDatasetOutcome::Created(id) = store.submit_dataset(keyed(b"body")).await.expect("submits")
    else {
        panic!("the key is new");
    };
    let again = store.submit_dataset(keyed(b"body")).await.expect("answers");
    assert_eq!(again, SubmitDatasetOutcome::Replayed(id.clone()));
    let other = store.submit_dataset(keyed(b"another")).await.expect("answers");
    assert_eq!(other, SubmitDatasetOutcome::KeyReused);

    let claimed = claim(store, "a").await.expect("there is work");
    let shard = file("shards/train-000000.tar", b"shard");
    store.blobs().put(&b"shard"[..]).await.expect("puts");
    store.blobs().put(&b"nothing refers to it"[..]).await.expect("puts");
    store.record_dataset_file(&claimed.lease, shard.clone()).await.expect("records");
    store.finish(&claimed.lease, frozen(1, &["shards/train-000000.tar"])).await.expect("finishes");
    let retention = RetentionSettings { grace_secs: 0, ..test_settings::section("store.retention") };
    tokio::time::sleep(Duration::from_millis(20)).await;
    let report = store.sweep(&retention, false).await.expect("sweeps").expect("no backup is under way");
    assert_eq!((report.removed.blobs, report.kept.blobs), (1, 1));
    assert_eq!(store.dataset_file(&id, &shard.path).await.expect("reads"), Some(shard.clone()));

    let next = submitted_dataset(store, "mugs").await;
    let claimed = claim(store, "a").await.expect("there is work");
    let earlier = store.latest_version(&DEFAULT_TENANT, "mugs").await.expect("reads").expect("a version");
    store.share_dataset_files(&claimed.lease, &earlier).await.expect("shares");
    assert_eq!(store.dataset_files(&next).await.expect("reads"), [shard]);

    let stranger: TenantId = "other".parse().expect("an id");
    assert_eq!(store.dataset(&stranger, &id).await.expect("reads"), None);
    assert_eq!(store.latest_version(&stranger, "mugs").await.expect("reads"), None);
    let all = DatasetFilter { limit: 10, ..DatasetFilter::default() };
    assert_eq!(store.datasets(&stranger, all).await.expect("reads"), []);
    assert_eq!(store.verify_dataset(&stranger, &id).await.expect("answers"), VerifyOutcome::NotFound);
}
