//! The fence of a lease, and the budget.

use super::*;
use crate::calls::{CallEnd, OUTCOME_UNKNOWN, Reservation};
use crate::queue::AttemptOutcome;
use crate::tasks::TaskEnd;

fn end() -> CallEnd {
    CallEnd {
        settled_micro_usd: Some(1),
        outcome: "answered".into(),
        received_bytes: 1,
        input_tokens: None,
        output_tokens: Some(2),
        task: None,
        answer: None,
    }
}

pub(super) async fn a_lost_lease_refuses_every_write(place: Place) {
    let (zombie, heir) = (place.handle(0), place.handle(1));
    submitted(&zombie).await;
    let lost =
        zombie.claim("zombie", Duration::ZERO, 3, &Scope::all()).await.expect("claims").expect("a job").lease;
    claimed(&heir, "heir").await;
    let key = stage("alpha");
    let refused = [
        zombie.stage_started(&lost, &key).await.err(),
        zombie.stage_finished(&lost, &key, &checkpoint(), false).await.err(),
        zombie.note(&lost, "alpha", "late".into()).await.err(),
        zombie.reserve_call(&lost, call(1)).await.err(),
        zombie.settle_call(&lost, 1, end()).await.err(),
        zombie.note_task(&lost, 1, TaskEnd::Over).await.err(),
        zombie.forget_answers(&lost, "alpha", "").await.err(),
        zombie.finish(&lost, AttemptOutcome::Stopped).await.err(),
    ];
    for error in refused {
        assert!(matches!(error, Some(StoreError::LeaseLost { .. })), "{error:?}");
    }
    assert_eq!(heir.checkpoint(&key).await.expect("reads"), None);
}

pub(super) async fn calls_at_once_stay_within_the_budget(place: Place) {
    let (scene, _) = submitted(place.store()).await;
    let lease = claimed(place.store(), "w").await.lease;
    let calls: Vec<_> = (0..20)
        .map(|index| {
            let (store, lease) = (place.handle(index), lease.clone());
            tokio::spawn(async move { store.reserve_call(&lease, call(300)).await })
        })
        .collect();
    let mut granted = Vec::new();
    for reservation in calls {
        match reservation.await.expect("runs").expect("answers") {
            Reservation::Granted(id) => granted.push(id),
            Reservation::OverBudget { committed, budget } => assert_eq!((committed, budget), (900, 1_000)),
            other => panic!("{other:?}"),
        }
    }
    assert_eq!(granted.len(), 3);
    place.store().settle_call(&lease, granted[0], end()).await.expect("settles");
    let spending = place.store().spending(&DEFAULT_TENANT, &scene).await.expect("reads");
    assert_eq!((spending.spent, spending.reserved), (1, 600));
    let rows = place.store().calls(&DEFAULT_TENANT, &scene).await.expect("reads");
    let settled = rows.iter().find(|row| row.id == granted[0]).expect("is there");
    assert_eq!((settled.output_tokens, settled.input_tokens), (Some(2), None));
    assert_eq!(settled.outcome.as_deref(), Some("answered"));
}

pub(super) async fn calls_of_a_dead_worker_have_an_unknown_outcome(place: Place) {
    let (scene, _) = submitted(place.store()).await;
    let dead =
        place.store().claim("dead", Duration::ZERO, 3, &Scope::all()).await.expect("claims").expect("a job");
    let reserved = place.store().reserve_call(&dead.lease, call(10)).await.expect("answers");
    assert!(matches!(reserved, Reservation::Granted(_)));
    let heir = claimed(&place.handle(1), "heir").await;
    let rows = place.store().calls(&DEFAULT_TENANT, &scene).await.expect("reads");
    assert_eq!(rows[0].outcome.as_deref(), Some(OUTCOME_UNKNOWN));
    assert_eq!(rows[0].settled_micro_usd, Some(10));
    let careful = NewCall { refuse_after_unknown: true, ..call(10) };
    let answer = place.store().reserve_call(&heir.lease, careful).await.expect("answers");
    assert_eq!(answer, Reservation::OutcomeUnknown);
}
