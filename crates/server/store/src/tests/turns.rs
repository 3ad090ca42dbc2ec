//! Order of claims: ranks, tenants, times, request versions, pauses, and room in the queue.

use super::*;
use crate::lifecycle::{Failure, JobState};
use crate::limits::Limit;
use crate::queue::{AttemptOutcome, Schedule};
use scene::{SceneRequest, TenantId};

/// The schedule of a request that states none.
pub(super) fn usual() -> Schedule {
    Schedule::usual(test_settings::section("queue"))
}

async fn submit(store: &Store, tenant_id: &TenantId, schedule: Schedule) -> JobId {
    let new = NewScene { tenant_id: tenant_id.clone(), ..new_scene() };
    match store.submit_scheduled(new, schedule, None).await.expect("submits") {
        SubmitOutcome::Created { job_id, .. } => job_id,
        other => panic!("{other:?}"),
    }
}

async fn claim(store: &Store, owner: &str) -> Option<Claim> {
    store.claim(owner, Duration::from_secs(60), 3, &Scope::all()).await.expect("claims")
}

fn tenants<const N: usize>() -> [TenantId; N] {
    std::array::from_fn(|index| format!("tenant_{index}").parse().expect("an id"))
}

/// Milliseconds since 1970.
fn now_ms() -> i64 {
    let since = std::time::UNIX_EPOCH.elapsed().expect("after 1970");
    i64::try_from(since.as_millis()).expect("fits")
}

fn priority(priority: i64) -> Schedule {
    Schedule { priority, ..usual() }
}

/// The jobs in the order of their claims by one worker that holds one at a time.
async fn claims_of_all(store: &Store) -> Vec<JobId> {
    let mut order = Vec::new();
    while let Some(claim) = claim(store, "worker").await {
        order.push(claim.lease.job_id.clone());
        let failure = Failure::deadline_passed();
        store.finish(&claim.lease, AttemptOutcome::Failed(failure)).await.expect("answers");
        // Tenants that were served in the same millisecond go by their names.
        tokio::time::sleep(Duration::from_millis(2)).await;
    }
    order
}

pub(super) async fn priority_goes_before_age_within_a_tenant(place: Place) {
    let store = place.handle(0);
    let mut jobs = Vec::new();
    for value in [0, -1, 1, 0, 1] {
        jobs.push(submit(&store, &DEFAULT_TENANT, priority(value)).await);
    }
    let [first, low, high, second, also_high] = jobs.try_into().expect("answers");
    assert_eq!(claims_of_all(&store).await, [high, also_high, first, second, low]);
}

pub(super) async fn tenants_take_turns_however_many_jobs_one_has_queued(place: Place) {
    let store = place.handle(0);
    let [a, b] = tenants();
    let mut of_a = Vec::new();
    for _ in 0..4 {
        // Priority counts within a tenant: it takes no turn from another one.
        of_a.push(submit(&store, &a, priority(100)).await);
    }
    let mut of_b = Vec::new();
    for _ in 0..2 {
        of_b.push(submit(&store, &b, priority(-100)).await);
    }
    let order = claims_of_all(&store).await;
    let tenants: String = order.iter().map(|job| if of_a.contains(job) { 'a' } else { 'b' }).collect();
    assert_eq!(tenants, "ababaa");
}

pub(super) async fn the_tenant_with_fewer_active_jobs_goes_first(place: Place) {
    let store = place.handle(0);
    let [a, b] = tenants();
    for _ in 0..3 {
        submit(&store, &a, priority(0)).await;
    }
    claimed(&store, "one").await;
    claimed(&store, "two").await;
    // Two jobs of the first tenant run. Both free slots are the other tenant's, though the first one has waited.
    for _ in 0..2 {
        submit(&store, &b, priority(0)).await;
    }
    for owner in ["three", "four"] {
        assert_eq!(claimed(&store, owner).await.tenant_id, b);
    }
    assert_eq!(claimed(&store, "five").await.tenant_id, a);
}

pub(super) async fn a_job_starts_at_its_time_and_fails_after_its_deadline(place: Place) {
    let store = place.handle(0);
    let now = now_ms();
    let later = Schedule { not_before_ms: Some(now + 3_600_000), ..usual() };
    let waiting = submit(&store, &DEFAULT_TENANT, later).await;
    let late = Schedule { deadline_ms: Some(now - 1000), ..usual() };
    let late = submit(&store, &DEFAULT_TENANT, late).await;
    assert_eq!(claim(&store, "worker").await, None);
    store.rescue(3).await.expect("answers");
    let row = store.job(&DEFAULT_TENANT, &late).await.expect("answers").expect("answers");
    assert_eq!((row.state, row.failure_code.as_deref()), (JobState::Failed, Some("deadline_passed")));
    let scene = store
        .scene(&DEFAULT_TENANT, &row.scene_id.expect("answers"))
        .await
        .expect("answers")
        .expect("answers");
    assert_eq!(scene.failure_code.as_deref(), Some("deadline_passed"));
    let row = store.job(&DEFAULT_TENANT, &waiting).await.expect("answers").expect("answers");
    assert_eq!(row.state, JobState::Queued);

    let soon = Schedule { not_before_ms: Some(now_ms() + 300), ..usual() };
    let soon = submit(&store, &DEFAULT_TENANT, soon).await;
    tokio::time::sleep(Duration::from_millis(400)).await;
    assert_eq!(claimed(&store, "worker").await.lease.job_id, soon);
}

pub(super) async fn a_claim_knows_the_time_until_its_deadline(place: Place) {
    let store = place.handle(0);
    let deadline_ms = Some(now_ms() + 60_000);
    submit(&store, &DEFAULT_TENANT, Schedule { deadline_ms, ..usual() }).await;
    let left = claimed(&store, "worker").await.time_left.expect("there is a deadline");
    assert!(left <= Duration::from_secs(61) && left > Duration::from_secs(30), "{left:?}");
}

pub(super) async fn a_request_of_a_newer_version_is_left_to_newer_workers(place: Place) {
    let store = place.handle(0);
    let newer =
        NewScene { request: json!({ "version": SceneRequest::VERSION + 1, "seed": 1 }), ..new_scene() };
    store.submit(newer).await.expect("answers");
    let known = submit(&store, &DEFAULT_TENANT, usual()).await;
    assert_eq!(claimed(&store, "worker").await.lease.job_id, known);
    assert_eq!(claim(&store, "worker").await, None);
}

pub(super) async fn a_pause_stops_claims_and_nothing_else(place: Place) {
    let store = place.handle(0);
    let held = submit(&store, &DEFAULT_TENANT, usual()).await;
    let lease = claimed(&store, "worker").await.lease;
    store.set_paused(true, "a test").await.expect("answers");
    submit(&store, &DEFAULT_TENANT, usual()).await;
    assert_eq!(claim(&store, "worker").await, None);
    let status = store.queue_status().await.expect("answers");
    assert_eq!(status.paused.as_ref().map(|pause| pause.reason.as_str()), Some("a test"));
    assert_eq!((status.queued, status.active, status.workers), (1, 1, 1));
    // Work that is held goes on; so does a worker for one job.
    assert!(store.renew(vec![lease.clone()], Duration::from_secs(60)).await.expect("answers")[0].1.is_some());
    store.finish(&lease, AttemptOutcome::Released).await.expect("answers");
    assert!(
        store
            .claim("worker", Duration::from_secs(60), 3, &Scope::Job(held.clone()))
            .await
            .expect("answers")
            .is_some()
    );
    store.set_paused(false, "").await.expect("answers");
    assert!(claim(&store, "worker").await.is_some());
    assert_eq!(store.queue_status().await.expect("answers").paused, None);
}

pub(super) async fn a_full_queue_refuses_new_jobs_and_keeps_the_promise_of_keys(place: Place) {
    let store = place.handle(0);
    let submit = async |tenant_id: &TenantId, key: Option<&str>| {
        let idempotency = key.map(|key| (key.to_owned(), "body".to_owned()));
        let new = NewScene { tenant_id: tenant_id.clone(), idempotency, ..new_scene() };
        let mut schedule = usual();
        schedule.queue.max_jobs = 3;
        store.submit_scheduled(new, schedule, None).await.expect("answers")
    };
    let [a, b] = tenants();
    let created = submit(&a, Some("key")).await;
    submit(&a, None).await;
    submit(&a, None).await;
    let refused = |outcome: SubmitOutcome| match outcome {
        SubmitOutcome::Refused(reached) => reached,
        other => panic!("{other:?}"),
    };
    let reached = refused(submit(&b, None).await);
    assert_eq!((reached.limit, reached.max, reached.used), (Limit::AllWaitingScenes, 3, 3));
    assert!((1..=60).contains(&reached.retry_after_secs));
    // A repeated key is answered with the scene it made, whether there is room or not.
    let SubmitOutcome::Created { job_id, .. } = created else { panic!("{created:?}") };
    match submit(&a, Some("key")).await {
        SubmitOutcome::Replayed { job_id: replayed, .. } => assert_eq!(replayed, job_id),
        other => panic!("{other:?}"),
    }
    // A claim makes room.
    claimed(&store, "worker").await;
    assert!(matches!(submit(&b, None).await, SubmitOutcome::Created { .. }));
}
