//! All that a store does, once: submissions, lists with every filter and a second page, claims, stages, calls, ends,
//! batches, datasets, recordings, keys, webhooks, removals.

use std::collections::BTreeMap;
use std::time::Duration;

use batches::{BatchState, OutputError};
use scene::{BatchId, DatasetId, JobId, MicroUsd, RecordingId, SceneId};
use serde_json::json;
use store::artifacts::{ArchiveRow, BuiltScene, FileRow};
use store::audit::{AuditEntry, AuditFilter};
use store::batches::{
    BatchFilter, BatchScenes, FeedRules, ItemContent, NewBatch, NewItem, OutputKind, RecipeRest, RestCounts,
};
use store::calls::{CallEnd, NewCall, Reservation};
use store::checkpoints::{Checkpoint, StageKey};
use store::datasets::{
    DatasetFile, DatasetFilter, DatasetState, FrozenVersion, NewDataset, SubmitDatasetOutcome,
};
use store::executions::{ExecutionAnswer, NewExecution, SubmitExecutionOutcome};
use store::jobs::JobFilter;
use store::keys::{KeyFilter, NewKey};
use store::lifecycle::{Failure, FailureClass, JobKind, JobState, SceneState};
use store::queue::{AttemptOutcome, Schedule, Scope};
use store::recordings::{
    ArchivePart, MadeAttempt, NewRecording, RecordingArchive, RecordingFile, RecordingFilter, RecordingState,
    SubmitRecordingOutcome,
};
use store::retention::RetentionSettings;
use store::scenes::{NewScene, SceneFilter, SceneKind, SubmitOutcome};
use store::scopes::ScopeSet;
use store::webhooks::{
    AttemptEnd, AttemptReport, CreateOutcome, DeliveryFilter, DeliveryState, NewWebhook, WebhookRow,
};
use store::{DEFAULT_TENANT, Digest, Lease, Store};

const LEASE: Duration = Duration::from_secs(60);

/// Runs it all.
pub async fn all(store: &Store) {
    let webhook = webhook(store).await;
    let (scene, job) = jobs(store).await;
    lists(store, &scene, &job).await;
    batches_of_requests(store).await;
    datasets(store).await;
    recordings(store, &scene).await;
    executions(store, &scene).await;
    principals(store).await;
    webhooks(store, webhook).await;
    operators(store).await;
    removals(store, &scene).await;
}

fn new_scene(parent_id: Option<SceneId>, key: Option<&str>) -> NewScene {
    NewScene {
        tenant_id: DEFAULT_TENANT.clone(),
        parent_id,
        request: json!({ "seed": 1, "version": 1 }),
        labels: BTreeMap::from([("set".to_owned(), "a".to_owned())]),
        budget_micro_usd: 1_000,
        idempotency: key.map(|key| (key.to_owned(), "body".to_owned())),
    }
}

async fn submitted(store: &Store, new: NewScene) -> (SceneId, JobId) {
    let schedule = Schedule::usual(test_settings::section("queue"));
    match store.submit_scheduled(new, schedule, None).await.unwrap() {
        SubmitOutcome::Created { scene_id, job_id, rows } => {
            store.outlook_of_new(&DEFAULT_TENANT, &rows).await.unwrap();
            (scene_id, job_id)
        }
        other => panic!("{other:?}"),
    }
}

fn file(name: &str) -> FileRow {
    FileRow {
        name: name.into(),
        digest: Digest::of(name.as_bytes()),
        media_type: "text/plain".into(),
        size: 4,
    }
}

fn built(passed: bool) -> AttemptOutcome {
    AttemptOutcome::Built(Box::new(BuiltScene {
        files: vec![file("scene.json")],
        archive: ArchiveRow { digest: Digest::of(b"zip"), size: 3 },
        passed,
        reasons: Vec::new(),
        summary: json!({}),
        metrics: json!({}),
    }))
}

fn failure() -> Failure {
    Failure { class: FailureClass::Transient, code: "t".into(), message: "m".into() }
}

/// A job from its submission to its end, with all that can happen to it; its scene is finished then.
async fn jobs(store: &Store) -> (SceneId, JobId) {
    let (scene, job) = submitted(store, new_scene(None, Some("key"))).await;
    store.submit(new_scene(None, Some("key"))).await.unwrap();
    assert!(store.has_work(&Scope::all()).await.unwrap());
    let claim = store.claim("worker", LEASE, 3, &Scope::all()).await.unwrap().unwrap();
    let lease = claim.lease;
    store.renew(vec![lease.clone()], LEASE).await.unwrap();
    let stage = stages(store, &lease).await;
    calls(store, &lease, &scene).await;
    store.note(&lease, "alpha", "half".into()).await.unwrap();
    store.stage_computed_by(&lease, &stage).await.unwrap();
    let retry =
        AttemptOutcome::Retry { failure: failure(), delay: Duration::ZERO, charged: true, max_attempts: 9 };
    store.finish(&lease, retry).await.unwrap();
    // Its process dies twice, so that it has to run alone.
    for owner in ["dead_1", "dead_2"] {
        store.claim(owner, Duration::ZERO, 9, &Scope::all()).await.unwrap().unwrap();
        tokio::time::sleep(Duration::from_millis(5)).await;
        store.rescue(9).await.unwrap();
    }
    store.claim("busy", LEASE, 9, &Scope::all()).await.unwrap();
    tokio::time::sleep(Duration::from_millis(1_050)).await;
    let claim = store.claim("heir", LEASE, 9, &Scope::Job(job.clone())).await.unwrap().unwrap();
    store.finish(&claim.lease, built(true)).await.unwrap();
    store
        .record_archive(&DEFAULT_TENANT, &scene, "usd", ArchiveRow { digest: Digest::of(b"usd"), size: 3 })
        .await
        .unwrap();
    store.rebuild(&DEFAULT_TENANT, &scene).await.unwrap();
    let claim = store.claim("heir", LEASE, 9, &Scope::all()).await.unwrap().unwrap();
    store.finish(&claim.lease, built(true)).await.unwrap();

    // A child that is cancelled and retried, one that is quarantined, one whose deadline passes.
    let (child, job_of_child) = submitted(store, new_scene(Some(scene.clone()), None)).await;
    store.cancel(&DEFAULT_TENANT, &job_of_child).await.unwrap();
    store.retry(&DEFAULT_TENANT, &job_of_child, None).await.unwrap();
    let claim = store.claim("heir", LEASE, 9, &Scope::all()).await.unwrap().unwrap();
    store.finish(&claim.lease, built(false)).await.unwrap();
    store.ancestors(&DEFAULT_TENANT, &child, 9).await.unwrap();
    let late = Schedule { deadline_ms: Some(1), ..Schedule::usual(test_settings::section("queue")) };
    store.submit_scheduled(new_scene(None, None), late, None).await.unwrap();
    store.rescue(9).await.unwrap();
    store.expire_leases_of_others("heir").await.unwrap();
    (scene, job)
}

/// A stage that is given up, computed, found again and forgotten.
async fn stages(store: &Store, lease: &Lease) -> StageKey {
    let stage = StageKey {
        tenant_id: DEFAULT_TENANT.clone(),
        stage: "alpha".into(),
        version: 1,
        instance: String::new(),
        key: Digest::of(b"alpha"),
    };
    let checkpoint =
        Checkpoint { output: Digest::of(b"output"), artifacts: vec![file("alpha/note.txt")], elapsed_ms: 1 };
    store.stage_started(lease, &stage).await.unwrap();
    store.release_stage(lease, &stage).await.unwrap();
    store.stage_started(lease, &stage).await.unwrap();
    store.stage_finished(lease, &stage, &checkpoint, false).await.unwrap();
    store.stage_finished(lease, &stage, &checkpoint, true).await.unwrap();
    store.checkpoint(&stage).await.unwrap().unwrap();
    let other = StageKey { key: Digest::of(b"other"), stage: "beta".into(), ..stage.clone() };
    store.stage_finished(lease, &other, &checkpoint, false).await.unwrap();
    store.forget_checkpoint(&other).await.unwrap();
    stage
}

async fn calls(store: &Store, lease: &Lease, scene: &SceneId) {
    let call = |refuse_after_unknown| NewCall {
        stage: "alpha".into(),
        instance: String::new(),
        port: "analyst".into(),
        provider: "p".into(),
        model: "m".into(),
        endpoint: "e".into(),
        operation: "o".into(),
        request_digest: "d".into(),
        idempotency_key: "k".into(),
        attempt: 1,
        reserved_micro_usd: 1,
        sent_bytes: 1,
        refuse_after_unknown,
    };
    let Reservation::Granted(id) = store.reserve_call(lease, call(true)).await.unwrap() else {
        panic!("the budget suffices")
    };
    let end = CallEnd {
        settled_micro_usd: Some(1),
        outcome: "answered".into(),
        received_bytes: 1,
        input_tokens: None,
        output_tokens: None,
        task: Some("task".into()),
        answer: Some(Digest::of(b"answer")),
    };
    let ended = end.clone();
    store.settle_call(lease, id, end).await.unwrap();
    store.reserve_call(lease, call(false)).await.unwrap();
    let about = NewCall { reserved_micro_usd: 0, ..call(false) };
    let reserved = store.reserve_call_about(&DEFAULT_TENANT, scene, about, 0).await.unwrap();
    let Some(Reservation::Granted(id)) = reserved else { panic!("it is free") };
    let end = CallEnd { settled_micro_usd: None, task: None, answer: None, ..ended };
    store.settle_call_about(&lease.job_id, id, end).await.unwrap();
    store.forget_answers_about(&lease.job_id, "beta").await.unwrap();
    store.task_of(&lease.job_id, "k").await.unwrap();
    store.calls(&DEFAULT_TENANT, scene).await.unwrap();
    store.spending(&DEFAULT_TENANT, scene).await.unwrap();
}

/// Every list, with each of its filters and a later page.
async fn lists(store: &Store, scene: &SceneId, job: &JobId) {
    let page = |limit| SceneFilter { limit, before_id: Some(scene.clone()), ..SceneFilter::default() };
    let label = Some(("set".to_owned(), "a".to_owned()));
    for filter in [
        SceneFilter { limit: 9, ..SceneFilter::default() },
        page(9),
        SceneFilter { state: Some(SceneState::Failed), ..page(9) },
        SceneFilter { parent: Some(scene.clone()), ..page(9) },
        SceneFilter { parent: Some(scene.clone()), state: Some(SceneState::Ready), ..page(9) },
        SceneFilter { created_after_ms: Some(0), label: label.clone(), ..page(9) },
        SceneFilter { passed: Some(true), kind: Some(SceneKind::Text), min_objects: Some(1), ..page(9) },
        SceneFilter { words: vec!["mug".to_owned()], max_objects: Some(9), ..page(9) },
        SceneFilter { category: Some("mug".to_owned()), ..page(9) },
        SceneFilter { category: Some("mug".to_owned()), label, ..page(9) },
        SceneFilter { oldest_first: true, ..page(9) },
    ] {
        store.scenes(&DEFAULT_TENANT, filter.clone()).await.unwrap();
        store.scene_counts(&DEFAULT_TENANT, filter).await.unwrap();
    }
    let page = || JobFilter { limit: 9, before_id: Some(job.clone()), ..JobFilter::default() };
    let batch: BatchId = "batch".parse().unwrap();
    let states = JobState::ALL.map(|state| JobFilter { state: Some(state), ..page() });
    let others = [
        JobFilter { limit: 9, ..JobFilter::default() },
        page(),
        JobFilter { kind: Some(JobKind::Retry), ..page() },
        JobFilter { dataset: Some("dataset".parse().unwrap()), ..page() },
        JobFilter { recording: Some("recording".parse().unwrap()), ..page() },
        JobFilter { scene: Some(scene.clone()), ..page() },
        JobFilter { scene: Some(scene.clone()), state: Some(JobState::Failed), ..page() },
        JobFilter { batch: Some(batch), created_after_ms: Some(0), ..page() },
    ];
    for filter in states.into_iter().chain(others) {
        store.jobs(&DEFAULT_TENANT, filter).await.unwrap();
    }
    let row = store.job(&DEFAULT_TENANT, job).await.unwrap().unwrap();
    let (_, waiting) = submitted(store, new_scene(None, None)).await;
    let waiting = store.job(&DEFAULT_TENANT, &waiting).await.unwrap().unwrap();
    store.outlooks(&DEFAULT_TENANT, &[&row, &waiting]).await.unwrap();
    store.latest_job(&DEFAULT_TENANT, scene).await.unwrap();
    store.stages(&DEFAULT_TENANT, job).await.unwrap();
    store.events(&DEFAULT_TENANT, job, 0, 9).await.unwrap();
    store.event_heads(&DEFAULT_TENANT, std::slice::from_ref(job)).await.unwrap();
    store.number_events().await.unwrap();
    store.last_position(&DEFAULT_TENANT).await.unwrap();
    store.tenant_events(&DEFAULT_TENANT, 1, 9).await.unwrap();
    store.scene(&DEFAULT_TENANT, scene).await.unwrap();
    store.artifacts(&DEFAULT_TENANT, scene).await.unwrap();
    store.artifact(&DEFAULT_TENANT, scene, "alpha/note.txt").await.unwrap();
    store.bundle_files(&DEFAULT_TENANT, scene).await.unwrap();
    store.archive(&DEFAULT_TENANT, scene, "all").await.unwrap();
}

async fn batches_of_requests(store: &Store) {
    let new = || NewBatch {
        tenant_id: DEFAULT_TENANT.clone(),
        name: "kitchens".into(),
        budget: Some(MicroUsd(1_000)),
        idempotency_key: Some("key".into()),
        body_digest: Digest::of(b"body"),
    };
    let item = |place, content| NewItem { place, custom_id: Some(format!("item_{place}")), content };
    let request = || ItemContent::Request {
        request: json!({ "seed": 1 }),
        labels: BTreeMap::new(),
        budget: MicroUsd(100),
    };
    let id = store.begin_batch(new()).await.unwrap();
    let invalid = ItemContent::Invalid(OutputError::new("invalid", "is invalid"));
    store.append_items(&id, vec![item(1, request()), item(2, request()), item(3, invalid)]).await.unwrap();
    let counts = RestCounts { pending: 2, ..RestCounts::default() };
    store.keep_recipe(&id, RecipeRest { recipe: "{}".into(), first_place: 4, counts }).await.unwrap();
    store.publish_batch(&id).await.unwrap();
    for place in [4, 5] {
        let rest = store.recipe_to_expand(&id, 9).await.unwrap().unwrap();
        assert!(store.expand_recipe(&id, rest, vec![item(place, request())], place == 5).await.unwrap());
    }
    let repeated = store.begin_batch(new()).await.unwrap();
    store.publish_batch(&repeated).await.unwrap();
    let discarded = store.begin_batch(NewBatch { idempotency_key: None, ..new() }).await.unwrap();
    store.discard_batch(&discarded).await.unwrap();
    store.batch_by_key(&DEFAULT_TENANT, "key").await.unwrap();
    let rules = || FeedRules { queue: test_settings::section("queue"), window: 1, counts_money: true };
    assert_eq!(store.active_batches().await.unwrap(), std::slice::from_ref(&id));
    store.feed_batch(&id, rules()).await.unwrap();
    while let Some(claim) = store.claim("heir", LEASE, 9, &Scope::all()).await.unwrap() {
        store.finish(&claim.lease, AttemptOutcome::Failed(failure())).await.unwrap();
    }
    store.feed_batch(&id, rules()).await.unwrap();
    let row = store.batch(&DEFAULT_TENANT, &id).await.unwrap().unwrap();
    store.batch_accounts(std::slice::from_ref(&row)).await.unwrap();
    store.batch_counts(&id).await.unwrap();
    for kind in [OutputKind::Output, OutputKind::Errors] {
        store.batch_output(&id, kind, 1, 9).await.unwrap();
    }
    store.cancel_batch(&DEFAULT_TENANT, &id).await.unwrap();
    store.feed_batch(&id, rules()).await.unwrap();
    store.retry_batch(&DEFAULT_TENANT, &id, None).await.unwrap();
    let page = || BatchFilter { limit: 9, before_id: Some(id.clone()), ..BatchFilter::default() };
    for filter in [BatchFilter { state: Some(BatchState::Running), ..page() }, page()] {
        store.batches(&DEFAULT_TENANT, filter).await.unwrap();
    }
}

async fn datasets(store: &Store) {
    let new = || NewDataset {
        tenant_id: DEFAULT_TENANT.clone(),
        name: "mugs".into(),
        request: json!({ "version": 1 }),
        idempotency_key: Some("key".into()),
        body_digest: Digest::of(b"body"),
    };
    let SubmitDatasetOutcome::Created(id) = store.submit_dataset(new()).await.unwrap() else {
        panic!("the key is new")
    };
    let id: DatasetId = id;
    store.submit_dataset(new()).await.unwrap();
    let scope = Scope::Kinds(vec![JobKind::FreezeDataset, JobKind::VerifyDataset]);
    let claim = async || store.claim("freezer", LEASE, 9, &scope).await.unwrap().unwrap();
    let freeze = claim().await;
    store.cancel(&DEFAULT_TENANT, &freeze.lease.job_id).await.unwrap();
    store.finish(&freeze.lease, AttemptOutcome::Stopped).await.unwrap();
    store.retry(&DEFAULT_TENANT, &freeze.lease.job_id, None).await.unwrap();
    let freeze = claim().await;
    store.note_dataset_steps(&freeze.lease, (1, 2)).await.unwrap();
    for path in ["one", "stale"] {
        let file = DatasetFile {
            path: path.into(),
            digest: Digest::of(b"one"),
            size: 3,
            media_type: "text/plain".into(),
        };
        store.record_dataset_file(&freeze.lease, file).await.unwrap();
    }
    let version =
        FrozenVersion { version: 1, digest: "d".into(), summary: json!({}), paths: vec!["one".into()] };
    store.finish(&freeze.lease, AttemptOutcome::Frozen(version)).await.unwrap();
    store.verify_dataset(&DEFAULT_TENANT, &id).await.unwrap();
    store.finish(&claim().await.lease, AttemptOutcome::Verified(json!({}))).await.unwrap();
    store.dataset(&DEFAULT_TENANT, &id).await.unwrap();
    store.latest_version(&DEFAULT_TENANT, "mugs").await.unwrap();
    store.dataset_files(&id).await.unwrap();
    store.dataset_file(&id, "one").await.unwrap();
    let page = || DatasetFilter { limit: 9, before_id: Some(id.clone()), ..DatasetFilter::default() };
    for filter in [
        page(),
        DatasetFilter { state: Some(DatasetState::Failed), ..page() },
        DatasetFilter { name: Some("mugs".into()), ..page() },
    ] {
        store.datasets(&DEFAULT_TENANT, filter).await.unwrap();
    }
}

async fn recordings(store: &Store, scene: &SceneId) {
    let new = |key: &str| NewRecording {
        tenant_id: DEFAULT_TENANT.clone(),
        scene_id: scene.clone(),
        request: json!({ "version": 1 }),
        bundle: Digest::of(b"bundle"),
        wanted: 1,
        max_attempts: 9,
        idempotency_key: Some(key.to_owned()),
        body_digest: Digest::of(b"body"),
    };
    let ordered = async |key: &str| match store.submit_recording(new(key)).await.unwrap() {
        SubmitRecordingOutcome::Created(id) => id,
        other => panic!("{other:?}"),
    };
    let id: RecordingId = ordered("key").await;
    store.submit_recording(new("key")).await.unwrap();
    let scope = Scope::Kinds(vec![JobKind::RecordAttempt, JobKind::AssembleRecording]);
    let claim = async || store.claim("recorder", LEASE, 9, &scope).await.unwrap().unwrap();
    let made = || {
        let unit = Some(Digest::of(b"unit"));
        AttemptOutcome::Attempted(MadeAttempt { outcome: "success".into(), detail: String::new(), unit })
    };
    let (first, second) = (claim().await, claim().await);
    store.begin_recording(&first.lease, "old").await.unwrap();
    store.begin_recording(&second.lease, "new").await.unwrap();
    store.finish(&second.lease, made()).await.unwrap();
    let row = store.recording(&DEFAULT_TENANT, &id).await.unwrap().unwrap();
    store.recording_progress(&row).await.unwrap();
    store.kept_attempts(&id).await.unwrap();
    store.attempt_outcomes(&id).await.unwrap();
    store.finish(&claim().await.lease, made()).await.unwrap();
    let lost =
        Failure { class: FailureClass::Transient, code: "episode_lost".into(), message: "lost".into() };
    let lost = AttemptOutcome::EpisodeLost { number: 0, failure: lost, max_losses: 3 };
    store.finish(&claim().await.lease, lost).await.unwrap();
    store.finish(&claim().await.lease, made()).await.unwrap();
    let assembly = claim().await.lease;
    store.begin_assembly(&assembly).await.unwrap();
    let archive = RecordingArchive {
        format: "robomimic".into(),
        digest: Some(Digest::of(b"part")),
        size: 4,
        files: 1,
        parts: vec![ArchivePart { digest: Digest::of(b"part"), size: 4 }],
    };
    store.record_recording_archive(&assembly, archive).await.unwrap();
    let recorded = RecordingFile { path: "robomimic/a".into(), digest: Digest::of(b"a"), start: 0, size: 1 };
    store.record_recording_files(&assembly, 0, vec![recorded]).await.unwrap();
    store.finish(&assembly, AttemptOutcome::Assembled(json!({}))).await.unwrap();
    store.recording_archives(&id).await.unwrap();
    store.recording_files(&id, Some(0), 9).await.unwrap();
    store.recording_file(&id, "robomimic/a").await.unwrap();
    store.recording_events(&DEFAULT_TENANT, &id, 0, 9).await.unwrap();
    store.recording_event_heads(&DEFAULT_TENANT, std::slice::from_ref(&id)).await.unwrap();
    let cancelled = ordered("other").await;
    store.cancel_recording(&DEFAULT_TENANT, &cancelled).await.unwrap();
    let failed = ordered("third").await;
    let failure = Failure { class: FailureClass::Permanent, code: "code".into(), message: "message".into() };
    store.finish(&claim().await.lease, AttemptOutcome::Failed(failure)).await.unwrap();
    assert_eq!(
        store.recording(&DEFAULT_TENANT, &failed).await.unwrap().unwrap().state,
        RecordingState::Failed
    );
    let page = || RecordingFilter { limit: 9, before_id: Some(id.clone()), ..RecordingFilter::default() };
    for filter in [
        page(),
        RecordingFilter { state: Some(RecordingState::Failed), ..page() },
        RecordingFilter { scene_id: Some(scene.clone()), ..page() },
    ] {
        store.recordings(&DEFAULT_TENANT, filter).await.unwrap();
    }
}

async fn executions(store: &Store, scene: &SceneId) {
    let new = || NewExecution {
        tenant_id: DEFAULT_TENANT.clone(),
        scene_id: scene.clone(),
        request: json!({ "version": 1 }),
        bundle: Digest::of(b"bundle"),
        idempotency: Some(("key".into(), Digest::of(b"body"))),
    };
    let SubmitExecutionOutcome::Created(id) = store.submit_execution(new()).await.unwrap() else {
        panic!("the key is new")
    };
    store.submit_execution(new()).await.unwrap();
    store.submit_execution(NewExecution { idempotency: None, ..new() }).await.unwrap();
    let claim = store.claim("executor", LEASE, 9, &Scope::Job(id.clone())).await.unwrap().unwrap();
    let media_type = "application/json".to_owned();
    let answer = ExecutionAnswer { digest: Digest::of(b"answer"), media_type, size: 6 };
    store.finish(&claim.lease, AttemptOutcome::Executed(answer.clone())).await.unwrap();
    let row = store.execution(&DEFAULT_TENANT, &id).await.unwrap().unwrap();
    assert_eq!(row.answer, Some(answer));
}

/// Statements of operators, probes and monitors.
/// Keys, sessions and the record of changes.
async fn principals(store: &Store) {
    let scopes = ScopeSet::all();
    let new = NewKey { tenant_id: DEFAULT_TENANT.clone(), name: "key".into(), scopes, lifetime_ms: None };
    let (key, secret) = store.create_key(new).await.unwrap();
    store.has_keys().await.unwrap();
    store.key_grant(&secret.digest()).await.unwrap();
    let session = Digest::of(b"session");
    store.begin_session(&secret.digest(), &session, 1000).await.unwrap();
    store.session_grant(&session).await.unwrap();
    store.end_session(&session).await.unwrap();
    for before_id in [None, Some(key.id.clone())] {
        store.keys(&DEFAULT_TENANT, KeyFilter { before_id, limit: 9 }).await.unwrap();
    }
    store.revoke_key(&DEFAULT_TENANT, &key.id).await.unwrap();
    let entry = AuditEntry {
        tenant_id: DEFAULT_TENANT.clone(),
        principal: "key".into(),
        address: String::new(),
        action: "revokeKey".into(),
        subject: "/keys".into(),
        status: 204,
    };
    store.record(entry).await.unwrap();
    for (since_ms, before_id) in [(None, None), (Some(1), None), (None, Some(key.id.to_string()))] {
        store.audit(&DEFAULT_TENANT, AuditFilter { since_ms, before_id, limit: 9 }).await.unwrap();
    }
}

fn new_webhook() -> NewWebhook {
    let url = "https://example.org/hook".to_owned();
    NewWebhook { tenant_id: DEFAULT_TENANT.clone(), url, description: String::new(), events: Vec::new() }
}

/// A webhook that gets all events.
async fn webhook(store: &Store) -> WebhookRow {
    match store.create_webhook(new_webhook()).await.unwrap().0 {
        CreateOutcome::Created(webhook) => webhook,
        CreateOutcome::TooMany => panic!("it is the first one"),
    }
}

/// Deliveries of what has happened, and changes of their webhook.
async fn webhooks(store: &Store, webhook: WebhookRow) {
    let id = webhook.id.clone();
    for end in [AttemptEnd::Delivered, AttemptEnd::Failed { max_failures: 9 }] {
        let due = store.claim_deliveries(LEASE, 9).await.unwrap().pop().unwrap();
        let report = AttemptReport { status: Some(204), error: None, duration: LEASE, end };
        assert!(store.end_attempt(&due, report).await.unwrap());
        store.replay_delivery(&DEFAULT_TENANT, &id, &due.id).await.unwrap();
    }
    let uuid = "01981f3a-0000-7000-8000-000000000000".to_owned();
    for before_uuid in [None, Some(uuid)] {
        for state in [None, Some(DeliveryState::Waiting)] {
            let filter = DeliveryFilter { state, before_uuid: before_uuid.clone(), limit: 9 };
            store.deliveries(&DEFAULT_TENANT, &id, filter).await.unwrap();
        }
    }
    store.test_webhook(&DEFAULT_TENANT, &id).await.unwrap();
    store.renew_webhook_secret(&DEFAULT_TENANT, &id).await.unwrap();
    assert_eq!(store.webhooks(&DEFAULT_TENANT).await.unwrap().len(), 1);
    let webhook = store.webhook(&DEFAULT_TENANT, &id).await.unwrap().unwrap();
    store.change_webhook(&DEFAULT_TENANT, webhook, new_webhook(), false).await.unwrap();
    store.delete_webhook(&DEFAULT_TENANT, &id).await.unwrap();
}

async fn operators(store: &Store) {
    store.set_paused(true, "test").await.unwrap();
    store.queue_status().await.unwrap();
    store.set_paused(false, "").await.unwrap();
    store.queue_status().await.unwrap();
    store.queue_depth().await.unwrap();
    store.is_healthy().await.unwrap();
    store.usage_of(&DEFAULT_TENANT).await.unwrap();
    store.full_quota(&DEFAULT_TENANT).await;
    store.takes_turn(LEASE).await.unwrap();
    store.verify(&mut |_, _| {}).await.unwrap();
}

/// Deletions, and sweeps that remove all that may go.
async fn removals(store: &Store, scene: &SceneId) {
    while let Some(claim) = store.claim("heir", LEASE, 9, &Scope::all()).await.unwrap() {
        let failure =
            Failure { class: FailureClass::Permanent, code: "code".into(), message: "message".into() };
        store.finish(&claim.lease, AttemptOutcome::Failed(failure)).await.unwrap();
    }
    let scenes =
        store.scenes(&DEFAULT_TENANT, SceneFilter { limit: 99, ..SceneFilter::default() }).await.unwrap();
    let labels = BTreeMap::from([("set".to_owned(), "b".to_owned())]);
    store.replace_labels(&DEFAULT_TENANT, scenes[0].0.clone(), labels).await.unwrap();
    for (row, _) in scenes {
        store.delete_scene(&DEFAULT_TENANT, &row.id).await.unwrap();
    }
    store.highest_version(&DEFAULT_TENANT, "mugs").await.unwrap();
    let datasets = DatasetFilter { limit: 99, ..DatasetFilter::default() };
    for row in store.datasets(&DEFAULT_TENANT, datasets).await.unwrap() {
        store.delete_dataset(&DEFAULT_TENANT, &row.id).await.unwrap();
    }
    let recordings = RecordingFilter { limit: 99, ..RecordingFilter::default() };
    for row in store.recordings(&DEFAULT_TENANT, recordings).await.unwrap() {
        store.delete_recording(&DEFAULT_TENANT, &row.id).await.unwrap();
    }
    let rules = FeedRules { queue: test_settings::section("queue"), window: 9, counts_money: true };
    for row in
        store.batches(&DEFAULT_TENANT, BatchFilter { limit: 99, ..BatchFilter::default() }).await.unwrap()
    {
        store.delete_batch(&DEFAULT_TENANT, &row.id, BatchScenes::Delete).await.unwrap();
        while store.feed_batch(&row.id, rules.clone()).await.unwrap().has_more {}
    }
    let retention = RetentionSettings {
        sweep_interval_secs: 0,
        grace_secs: 0,
        intermediate_hours: 1,
        quarantined_hours: 1,
        deleted_hours: 0,
        ended_batch_hours: 1,
        failed_recording_hours: 1,
        failed_dataset_hours: 1,
        dataset_job_hours: 1,
        delivery_hours: 1,
    };
    for is_dry_run in [true, false, false] {
        store.sweep(&retention, is_dry_run).await.unwrap().unwrap();
    }
    assert!(store.scene(&DEFAULT_TENANT, scene).await.unwrap().is_some(), "its key keeps its rows");
}
