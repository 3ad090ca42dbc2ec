//! Limits of tenants hold for submissions of every kind that come at once, and for no other tenant.

use super::batches::{batch_of, item, new_batch, rules};
use super::turns::usual;
use super::*;
use crate::batches::{BatchRetryOutcome, NewBatch, PublishOutcome, RecipeRest, RestCounts};
use crate::calls::{CallEnd, Reservation};
use crate::datasets::{NewDataset, SubmitDatasetOutcome, VerifyOutcome};
use crate::executions::{NewExecution, SubmitExecutionOutcome};
use crate::jobs::RetryOutcome;
use crate::limits::{Limit, LimitChange, LimitReached};
use crate::queue::AttemptOutcome;
use crate::recordings::{NewRecording, SubmitRecordingOutcome};
use scene::BatchId;

/// Gives a tenant limits of its own.
async fn limit(store: &Store, tenant_id: &TenantId, limits: &[(Limit, i64)]) {
    let tenant_id = tenant_id.clone();
    let changes: Vec<LimitChange> =
        limits.iter().map(|(limit, value)| LimitChange { limit: *limit, value: Some(*value) }).collect();
    let set = store.writer.write("limit a tenant", move |connection| {
        Box::pin(async move { crate::limits::set(connection, &tenant_id, &changes).await })
    });
    set.await.expect("sets");
}

fn tenant(name: &str) -> TenantId {
    name.parse().expect("an id")
}

/// One kind of work that clients ask for.
#[derive(Clone, Copy, Debug)]
enum Kind {
    Scene,
    Dataset,
    Recording,
    Execution,
}

const KINDS: [Kind; 4] = [Kind::Scene, Kind::Dataset, Kind::Recording, Kind::Execution];

/// Submits work; the limit that refused it.
async fn submit(store: &Store, tenant_id: &TenantId, kind: Kind, number: usize) -> Option<LimitReached> {
    let (tenant_id, scene_id) = (tenant_id.clone(), "scene".parse().expect("an id"));
    let (request, bundle) = (json!({ "version": 1 }), Digest::of(b"bundle"));
    let body_digest = Digest::of(b"body");
    match kind {
        Kind::Scene => {
            let new = NewScene { tenant_id, ..new_scene() };
            match store.submit_scheduled(new, usual(), None).await.expect("answers") {
                SubmitOutcome::Created { .. } => None,
                SubmitOutcome::Refused(reached) => Some(reached),
                other => panic!("{other:?}"),
            }
        }
        Kind::Dataset => {
            let name = format!("set_{number}");
            let new = NewDataset { tenant_id, name, request, idempotency_key: None, body_digest };
            match store.submit_dataset(new).await.expect("answers") {
                SubmitDatasetOutcome::Created(_) => None,
                SubmitDatasetOutcome::Refused(reached) => Some(reached),
                other => panic!("{other:?}"),
            }
        }
        Kind::Recording => {
            let (wanted, max_attempts) = (20, 90);
            let new = NewRecording {
                tenant_id,
                scene_id,
                request,
                bundle,
                wanted,
                max_attempts,
                idempotency_key: None,
                body_digest,
            };
            match store.submit_recording(new).await.expect("answers") {
                SubmitRecordingOutcome::Created(_) => None,
                SubmitRecordingOutcome::Refused(reached) => Some(reached),
                other => panic!("{other:?}"),
            }
        }
        Kind::Execution => {
            let new = NewExecution { tenant_id, scene_id, request, bundle, idempotency: None };
            match store.submit_execution(new).await.expect("answers") {
                SubmitExecutionOutcome::Created(_) => None,
                SubmitExecutionOutcome::Refused(reached) => Some(reached),
                other => panic!("{other:?}"),
            }
        }
    }
}

/// Submits so much work of every kind at once, through both handles; what refused it.
async fn submit_at_once(place: &Place, tenant_id: &TenantId, count: usize) -> Vec<Option<LimitReached>> {
    let submissions: Vec<_> = (0..count)
        .map(|index| {
            let (store, tenant_id) = (place.handle(index), tenant_id.clone());
            tokio::spawn(async move { submit(&store, &tenant_id, KINDS[index / 2 % 4], index).await })
        })
        .collect();
    let mut refusals = Vec::new();
    for submission in submissions {
        refusals.push(submission.await.expect("runs"));
    }
    refusals
}

fn accepted(refusals: &[Option<LimitReached>]) -> usize {
    refusals.iter().filter(|refusal| refusal.is_none()).count()
}

pub(super) async fn work_at_once_stays_within_the_limit_of_what_waits(place: Place) {
    let store = place.store();
    for max in [1, 2, 7, 13] {
        let own = tenant(&format!("waits_{max}"));
        limit(store, &own, &[(Limit::WaitingJobs, max)]).await;
        let refusals = submit_at_once(&place, &own, 24).await;
        assert_eq!(accepted(&refusals) as i64, max);
        for reached in refusals.into_iter().flatten() {
            assert_eq!((reached.limit, reached.max, reached.used), (Limit::WaitingJobs, max, max));
            assert!((1..=60).contains(&reached.retry_after_secs), "{reached:?}");
        }
    }
    assert_eq!(submit(store, &tenant("free"), Kind::Scene, 0).await, None, "others have room");
}

pub(super) async fn a_refusal_counts_for_a_moment_or_until_there_is_room(place: Place) {
    let store = place.store();
    let own = tenant("impatient");
    limit(store, &own, &[(Limit::WaitingJobs, 1)]).await;
    let keyed = |key: &str| NewScene {
        tenant_id: own.clone(),
        idempotency: Some((key.to_owned(), "digest".to_owned())),
        ..new_scene()
    };
    let first = store.submit_scheduled(keyed("first"), usual(), None).await.expect("submits");
    let SubmitOutcome::Created { job_id, .. } = first else { panic!("{first:?}") };
    let refused = submit(store, &own, Kind::Scene, 0).await.expect("one waits");
    // Others, and a key that was used before, are answered by the database.
    assert_eq!(submit(store, &tenant("patient"), Kind::Scene, 0).await, None);
    let again = store.submit_scheduled(keyed("first"), usual(), None).await.expect("answers");
    assert!(matches!(again, SubmitOutcome::Replayed { .. }), "{again:?}");
    // What is refused a moment later meets no transaction, so it is refused also while the limit is higher.
    limit(store, &own, &[(Limit::WaitingJobs, 2)]).await;
    assert_eq!(submit(store, &own, Kind::Scene, 0).await, Some(refused));
    tokio::time::sleep(Duration::from_millis(300)).await;
    assert_eq!(submit(store, &own, Kind::Scene, 0).await, None);
    assert!(submit(store, &own, Kind::Scene, 0).await.is_some());
    // A cancellation and a claim make room at once.
    store.cancel(&own, &job_id).await.expect("cancels");
    assert_eq!(submit(store, &own, Kind::Scene, 0).await, None);
    assert!(submit(store, &own, Kind::Scene, 0).await.is_some());
    while claimed(store, "worker").await.tenant_id != own {}
    assert_eq!(submit(store, &own, Kind::Scene, 0).await, None);
}

pub(super) async fn work_at_once_stays_within_the_submissions_of_a_minute(place: Place) {
    let store = place.store();
    for max in [1, 5, 11] {
        let own = tenant(&format!("paced_{max}"));
        limit(store, &own, &[(Limit::SubmissionsPerMinute, max)]).await;
        let refusals = submit_at_once(&place, &own, 24).await;
        // The bucket fills while the test runs, the faster the larger it is.
        let accepted = accepted(&refusals) as i64;
        assert!((max..=max + 2).contains(&accepted), "{accepted} of {max}");
        for reached in refusals.into_iter().flatten() {
            assert_eq!((reached.limit, reached.max), (Limit::SubmissionsPerMinute, max));
            assert!((1..=60).contains(&reached.retry_after_secs), "{reached:?}");
        }
    }
    assert_eq!(submit(store, &tenant("free"), Kind::Scene, 0).await, None, "others may go on");
}

pub(super) async fn no_claims_at_once_exceed_the_jobs_that_a_tenant_may_run(place: Place) {
    let store = place.store();
    let (own, free) = (tenant("a"), tenant("b"));
    limit(store, &own, &[(Limit::RunningJobs, 3)]).await;
    for index in 0..8 {
        assert_eq!(submit(store, &own, KINDS[index % 4], index).await, None);
    }
    assert_eq!(submit(store, &free, Kind::Scene, 0).await, None);
    let mut claims = Vec::new();
    // A claim that meets another one of the tenant leaves it to that: nothing is found, and there is more later.
    for round in 0..4 {
        let claiming: Vec<_> = (0..8)
            .map(|index| {
                let (store, owner) = (place.handle(index), format!("worker_{round}_{index}"));
                tokio::spawn(
                    async move { store.claim(&owner, Duration::from_secs(60), 3, &Scope::all()).await },
                )
            })
            .collect();
        for claim in claiming {
            claims.extend(claim.await.expect("runs").expect("claims"));
        }
    }
    let count = |tenant_id: &TenantId| claims.iter().filter(|claim| claim.tenant_id == *tenant_id).count();
    assert_eq!((count(&own), count(&free)), (3, 1));
    // An end makes room for one more.
    let ended = claims.iter().find(|claim| claim.tenant_id == own).expect("there is one");
    store.finish(&ended.lease, AttemptOutcome::Released).await.expect("finishes");
    assert_eq!(claimed(store, "next").await.tenant_id, own);
    let one_more = store.claim("more", Duration::from_secs(60), 3, &Scope::all()).await.expect("claims");
    assert!(one_more.is_none());
}

pub(super) async fn tenants_take_turns_over_work_of_all_kinds(place: Place) {
    let store = place.store();
    let (many, few) = (tenant("a"), tenant("b"));
    for index in 0..8 {
        assert_eq!(submit(store, &many, KINDS[index % 4], index).await, None);
    }
    for (index, kind) in [Kind::Recording, Kind::Dataset, Kind::Execution].into_iter().enumerate() {
        assert_eq!(submit(store, &few, kind, index).await, None);
    }
    // Of one worker that holds all: each has as many as the other while both have work that waits.
    let mut turns = String::new();
    for index in 0..6 {
        let claim = claimed(store, &format!("worker_{index}")).await;
        turns.push_str(claim.tenant_id.as_str());
        tokio::time::sleep(Duration::from_millis(2)).await;
    }
    assert_eq!(turns, "ababab");
}

pub(super) async fn spending_of_a_month_stays_within_its_limit_and_outlives_the_calls(place: Place) {
    let store = place.store();
    let own = tenant("spends");
    limit(store, &own, &[(Limit::UsdPerMonth, 1_000)]).await;
    // Two scenes of 1,000 each, whose calls come at once through both handles.
    let mut leases = Vec::new();
    for _ in 0..2 {
        let new = NewScene { tenant_id: own.clone(), ..new_scene() };
        store.submit_scheduled(new, usual(), None).await.expect("submits");
        leases.push(claimed(store, "worker").await.lease);
    }
    let calls: Vec<_> = (0..20)
        .map(|index| {
            let (store, lease) = (place.handle(index), leases[index / 2 % 2].clone());
            tokio::spawn(async move { (lease.clone(), store.reserve_call(&lease, call(90)).await) })
        })
        .collect();
    let mut granted = Vec::new();
    for reserved in calls {
        match reserved.await.expect("runs") {
            (lease, Ok(Reservation::Granted(id))) => granted.push((lease, id)),
            (_, Ok(Reservation::OverMonth { committed, limit })) => {
                assert_eq!((committed, limit), (990, 1_000))
            }
            (_, other) => panic!("{other:?}"),
        }
    }
    assert_eq!(granted.len(), 11, "990 of 1,000 millionths");
    assert_eq!(submit(store, &own, Kind::Scene, 0).await, None, "something is left");
    assert!(matches!(store.reserve_call(&leases[0], call(0)).await, Ok(Reservation::Granted(_))));
    // A call costs more than was reserved: the vendor says so.
    let (lease, id) = granted.pop().expect("there are calls");
    let end = CallEnd {
        settled_micro_usd: Some(100),
        outcome: "answered".into(),
        received_bytes: 1,
        input_tokens: None,
        output_tokens: None,
        task: None,
        answer: None,
    };
    store.settle_call(&lease, id, end).await.expect("settles");
    for (index, kind) in KINDS.into_iter().enumerate() {
        let reached = submit(store, &own, kind, index).await.expect("the month is spent");
        assert_eq!((reached.limit, reached.max, reached.used), (Limit::UsdPerMonth, 1_000, 1_000));
        assert!((1..=31 * 86_400).contains(&reached.retry_after_secs), "{reached:?}");
    }
    let batch = NewBatch { tenant_id: own.clone(), ..new_batch() };
    let batch = store.begin_batch(batch).await.expect("begins");
    let refused = store.publish_batch(&batch).await.expect("answers");
    assert!(matches!(refused, PublishOutcome::Refused(LimitReached { limit: Limit::UsdPerMonth, .. })));
    // The rows of the calls go with their scene, and the sum stays.
    let removed = store.writer.write("remove calls", |connection| {
        Box::pin(async move {
            sqlx::query("DELETE FROM calls").execute(connection).await?;
            Ok(())
        })
    });
    removed.await.expect("removes");
    assert!(submit(store, &own, Kind::Execution, 0).await.is_some());
    assert_eq!(submit(store, &tenant("free"), Kind::Scene, 0).await, None, "others may spend");
}

pub(super) async fn retries_and_verifications_count_as_submissions(place: Place) {
    let store = place.store();
    let own: &TenantId = &DEFAULT_TENANT;
    let (_, job) = submitted(store).await;
    let claim = claimed(store, "worker").await;
    let failure = Failure { class: FailureClass::Permanent, code: "code".into(), message: "m".into() };
    store.finish(&claim.lease, AttemptOutcome::Failed(failure)).await.expect("finishes");
    let new = NewDataset {
        tenant_id: own.clone(),
        name: "set".into(),
        request: json!({ "version": 1 }),
        idempotency_key: None,
        body_digest: Digest::of(b"body"),
    };
    let SubmitDatasetOutcome::Created(dataset) = store.submit_dataset(new).await.expect("submits") else {
        panic!("there is no key")
    };
    let freeze = claimed(store, "worker").await;
    let version = crate::datasets::FrozenVersion {
        version: 1,
        digest: "d".into(),
        summary: json!({}),
        paths: Vec::new(),
    };
    store.finish(&freeze.lease, AttemptOutcome::Frozen(version)).await.expect("finishes");
    limit(store, own, &[(Limit::WaitingJobs, 1)]).await;
    // What this process has counted before is forgotten.
    tokio::time::sleep(Duration::from_millis(300)).await;
    assert_eq!(submit(store, own, Kind::Execution, 0).await, None);
    let retried = store.retry(own, &job, None).await.expect("answers");
    assert!(matches!(retried, RetryOutcome::Refused(LimitReached { limit: Limit::WaitingJobs, .. })));
    let verified = store.verify_dataset(own, &dataset).await.expect("answers");
    assert!(matches!(verified, VerifyOutcome::Refused(_)), "{verified:?}");
    claimed(store, "worker").await;
    assert!(matches!(store.retry(own, &job, None).await, Ok(RetryOutcome::Created { .. })));
    claimed(store, "worker").await;
    assert_eq!(store.verify_dataset(own, &dataset).await.expect("answers"), VerifyOutcome::Accepted);
}

/// A batch of so many items, and so many more that have no rows.
async fn received(store: &Store, tenant_id: &TenantId, items: u64, rest: u64) -> BatchId {
    let id =
        store.begin_batch(NewBatch { tenant_id: tenant_id.clone(), ..new_batch() }).await.expect("begins");
    store.append_items(&id, (1..=items).map(item).collect()).await.expect("stores");
    if rest > 0 {
        let counts = RestCounts { pending: rest, ..RestCounts::default() };
        let rest = RecipeRest { recipe: "{}".into(), first_place: items + 1, counts };
        store.keep_recipe(&id, rest).await.expect("stores");
    }
    id
}

pub(super) async fn batches_at_once_stay_within_the_requests_of_their_tenant(place: Place) {
    let store = place.store();
    let own = tenant("batches");
    limit(store, &own, &[(Limit::BatchRequests, 50)]).await;
    let mut ids = Vec::new();
    for _ in 0..8 {
        // 12 requests each, of which 4 have rows.
        ids.push(received(store, &own, 4, 8).await);
    }
    let publishing: Vec<_> = ids
        .into_iter()
        .enumerate()
        .map(|(index, id)| {
            let store = place.handle(index);
            tokio::spawn(async move { (id.clone(), store.publish_batch(&id).await.expect("answers")) })
        })
        .collect();
    let mut published = Vec::new();
    for outcome in publishing {
        match outcome.await.expect("runs") {
            (id, PublishOutcome::Published) => published.push(id),
            (id, PublishOutcome::Refused(reached)) => {
                assert_eq!((reached.limit, reached.max), (Limit::BatchRequests, 50));
                assert!(reached.used > 38, "{reached:?}");
                assert_eq!(store.batch(&own, &id).await.expect("reads"), None, "nothing of it stays");
            }
            (_, other) => panic!("{other:?}"),
        }
    }
    assert_eq!(published.len(), 4, "48 of 50 requests");
    // A cancelled batch makes room, and takes it again when it is retried.
    store.cancel_batch(&own, &published[0]).await.expect("cancels");
    store.feed_batch(&published[0], rules(5)).await.expect("feeds");
    let next = received(store, &own, 4, 8).await;
    assert_eq!(store.publish_batch(&next).await.expect("answers"), PublishOutcome::Published);
    let retried = store.retry_batch(&own, &published[0], None).await.expect("answers");
    assert!(matches!(retried, BatchRetryOutcome::Refused(LimitReached { used: 48, .. })), "{retried:?}");
}

pub(super) async fn feeding_waits_for_the_limits_of_its_tenant(place: Place) {
    let store = place.store();
    let id = batch_of(store, 20).await;
    limit(store, &DEFAULT_TENANT, &[(Limit::SubmissionsPerMinute, 6)]).await;
    let mut fed = 0;
    for _ in 0..4 {
        fed += store.feed_batch(&id, rules(100)).await.expect("feeds").submitted;
    }
    assert!((6..=7).contains(&fed), "{fed} in a moment");
    let usd = [(Limit::SubmissionsPerMinute, 0), (Limit::UsdPerMonth, 1)];
    limit(store, &DEFAULT_TENANT, &usd).await;
    let spent = store.writer.write("spend", |connection| {
        Box::pin(async move {
            let month = crate::limits::Month::now(connection).await?;
            sqlx::query(
                "INSERT INTO tenant_spending (tenant_id, month, micro_usd) VALUES ('default', $1, 1)",
            )
            .bind(month.name)
            .execute(connection)
            .await?;
            Ok(())
        })
    });
    spent.await.expect("spends");
    assert_eq!(store.feed_batch(&id, rules(100)).await.expect("feeds").submitted, 0);
    limit(store, &DEFAULT_TENANT, &[(Limit::UsdPerMonth, 2)]).await;
    assert_eq!(store.feed_batch(&id, rules(100)).await.expect("feeds").submitted, 20 - fed);
}

pub(super) async fn an_operator_sees_and_changes_the_limits_of_a_tenant(place: Place) {
    let store = place.store();
    let own = tenant("seen");
    assert_eq!(submit(store, &own, Kind::Scene, 0).await, None);
    limit(store, &own, &[(Limit::WaitingJobs, 9), (Limit::Bytes, 0)]).await;
    let (tenant_id, settings) = (own.clone(), *store.admission.settings());
    let read = store.writer.write("read limits", move |connection| {
        Box::pin(async move { crate::limits::of_tenant(connection, &settings, &tenant_id).await })
    });
    let limits = read.await.expect("reads");
    assert_eq!((limits.waiting_jobs, limits.bytes, limits.batch_requests), (9, 0, 200_000));
}

#[tokio::test]
async fn limits_are_shown_with_what_is_used_beside_a_running_process() {
    let directory = tempfile::tempdir().expect("temporary directory");
    let url = test_postgres::database().await;
    for database in [DatabaseAddress::Sqlite, DatabaseAddress::Postgres(url)] {
        let settings = settings(database);
        let store = Store::open(directory.path(), &settings, Intent::Create).await.expect("opens");
        let own = tenant("shown");
        assert_eq!(submit(&store, &own, Kind::Scene, 0).await, None);
        assert_eq!(submit(&store, &own, Kind::Recording, 0).await, None);
        claimed(&store, "worker").await;
        let mut operator = crate::Operator::open(directory.path(), &settings).await.expect("opens");
        let changes = [
            LimitChange { limit: Limit::RunningJobs, value: Some(1) },
            LimitChange { limit: Limit::UsdPerMonth, value: Some(2_000_000) },
        ];
        operator.set_limits(&own, &changes).await.expect("sets");
        assert_eq!(operator.tenants().await.expect("reads"), std::slice::from_ref(&own));
        let accounts = operator.account_of(&own).await.expect("reads");
        let facts: Vec<(Limit, i64, bool, i64)> = accounts
            .iter()
            .map(|account| (account.limit, account.max, account.is_exception, account.used))
            .collect();
        let expected = [
            (Limit::Bytes, 0, false, 0),
            (Limit::WaitingJobs, 10_000, false, 1),
            (Limit::RunningJobs, 1, true, 1),
            (Limit::SubmissionsPerMinute, 0, false, 0),
            (Limit::UsdPerMonth, 2_000_000, true, 0),
            (Limit::BatchRequests, 200_000, false, 0),
        ];
        assert_eq!(facts, expected);
        let back = LimitChange { limit: Limit::RunningJobs, value: None };
        operator.set_limits(&own, &[back]).await.expect("sets");
        assert!(!operator.account_of(&own).await.expect("reads")[2].is_exception);
        drop((store, operator));
    }
}
