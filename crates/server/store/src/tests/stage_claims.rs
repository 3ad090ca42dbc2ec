//! Stage keys in progress: one job computes a key, for as long as it holds its lease.

use super::*;
use crate::stage_claims::StageStart;

pub(super) async fn a_claim_lasts_as_long_as_its_jobs_lease(place: Place) {
    let store = place.handle(0);
    for _ in 0..2 {
        submitted(&store).await;
    }
    let one = store
        .claim("one", Duration::from_secs(2), 9, &Scope::all())
        .await
        .expect("answers")
        .expect("answers")
        .lease;
    let two = claimed(&store, "two").await.lease;
    assert_eq!(store.stage_started(&one, &stage("alpha")).await.expect("answers"), StageStart::Granted);
    // A worker that starts a stage again, after an error, still has it.
    assert_eq!(store.stage_started(&one, &stage("alpha")).await.expect("answers"), StageStart::Granted);
    let held = StageStart::ComputedBy(one.job_id.clone());
    assert_eq!(store.stage_started(&two, &stage("alpha")).await.expect("answers"), held);
    // Other tenants have keys of their own.
    let foreign = StageKey { tenant_id: "other".parse().expect("answers"), ..stage("alpha") };
    assert_eq!(store.stage_computed_by(&two, &foreign).await.expect("answers"), None);
    // The lease runs out: the claim stays until the job is taken from its worker, which may still write.
    tokio::time::sleep(Duration::from_millis(2100)).await;
    assert_eq!(store.stage_started(&two, &stage("alpha")).await.expect("answers"), held);
    assert_eq!(store.rescue(9).await.expect("answers"), 1);
    assert_eq!(store.stage_computed_by(&two, &stage("alpha")).await.expect("answers"), None);
    assert_eq!(store.stage_started(&two, &stage("alpha")).await.expect("answers"), StageStart::Granted);
    // The job's next worker waits in turn, until the stage is given up.
    let heir = store
        .claim("three", Duration::from_secs(60), 9, &Scope::Job(one.job_id.clone()))
        .await
        .expect("answers")
        .expect("answers")
        .lease;
    let held = StageStart::ComputedBy(two.job_id.clone());
    assert_eq!(store.stage_started(&heir, &stage("alpha")).await.expect("answers"), held);
    store.release_stage(&two, &stage("alpha")).await.expect("answers");
    assert_eq!(store.stage_started(&heir, &stage("alpha")).await.expect("answers"), StageStart::Granted);
    // The first worker wakes up and may write nothing.
    assert!(store.stage_started(&one, &stage("alpha")).await.is_err());
    assert!(store.release_stage(&one, &stage("alpha")).await.is_err());
    assert_eq!(
        store.stage_started(&two, &stage("alpha")).await.expect("answers"),
        StageStart::ComputedBy(heir.job_id)
    );
}

/// All jobs at once: one gets the key.
pub(super) async fn of_many_jobs_one_gets_the_key(place: Place) {
    let store = place.handle(0);
    let mut leases = Vec::new();
    for number in 0..8 {
        submitted(&store).await;
        leases.push(claimed(&store, &format!("worker_{number}")).await.lease);
    }
    let starts = leases.iter().map(|lease| {
        let (store, lease) = (place.handle(lease.owner.len()), lease.clone());
        tokio::spawn(async move { store.stage_started(&lease, &stage("alpha")).await.expect("answers") })
    });
    let mut granted = 0;
    for start in starts.collect::<Vec<_>>() {
        granted += usize::from(start.await.expect("answers") == StageStart::Granted);
    }
    assert_eq!(granted, 1);
}
