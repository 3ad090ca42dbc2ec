//! The books: no budget is overrun, however many ask at once; a cost of unknown outcome counts as spent; clients see
//! all entries.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::Duration;

use bytes::Bytes;
use futures::future::join_all;
use ports::ledger::{Intent, Ledger, MicroUsd, OnUnknown, Settlement};
use ports::{Call, Port, ProviderError, SceneAnalyst};
use remote::chat::ChatAnalyst;
use runtime::CancelFlag;
use runtime::CpuPool;
use scene::request::RequestOptions;
use serde_json::json;
use store::calls::{CallEnd, NewCall, Reservation, Spending};
use store::queue::{AttemptOutcome, Claim, Scope};
use store::scenes::NewScene;
use store::tasks::{TaskEnd, TaskRow};
use store::{DEFAULT_TENANT, Lease, Store, StoreError};
use tabletopgen::pipeline::ledger::JobLedger;

use crate::harness::script::{Act, Script};
use crate::harness::server::{Server, opened, wait_until_unlocked};
use crate::remote::chat::{endpoint, quick};
use crate::remote::chat_answers::breakfast;
use crate::remote::chat_server::{ChatServer, Fault, KEY};

const HOUR: Duration = Duration::from_secs(3600);

async fn claimed(budget_micro_usd: i64) -> (Arc<tempfile::TempDir>, Store, Claim) {
    let directory = Arc::new(tempfile::tempdir().unwrap());
    let store = opened(directory.path()).await;
    let new = NewScene {
        tenant_id: DEFAULT_TENANT.clone(),
        parent_id: None,
        request: json!({ "version": 1, "input": { "kind": "text", "text": "a" }, "seed": 1, "options": {} }),
        labels: BTreeMap::new(),
        budget_micro_usd,
        idempotency: None,
    };
    store.submit(new).await.unwrap();
    let claim = claim(&store, "worker", HOUR).await;
    (directory, store, claim)
}

async fn claim(store: &Store, owner: &str, lease: Duration) -> Claim {
    store.claim(owner, lease, 5, &Scope::all()).await.unwrap().expect("there is a job")
}

fn call(key: &str, reserved_micro_usd: i64) -> NewCall {
    NewCall {
        stage: "reference".into(),
        instance: String::new(),
        port: "analyst".into(),
        provider: "openai/chat".into(),
        model: "gpt-4.1".into(),
        endpoint: "https://api.openai.com/v1/chat/completions".into(),
        operation: "describe".into(),
        request_digest: "d".into(),
        idempotency_key: key.into(),
        attempt: 1,
        reserved_micro_usd,
        sent_bytes: 10,
        refuse_after_unknown: false,
    }
}

fn end(settled_micro_usd: Option<i64>, outcome: &str) -> CallEnd {
    CallEnd {
        settled_micro_usd,
        outcome: outcome.into(),
        received_bytes: 20,
        input_tokens: Some(3),
        output_tokens: Some(4),
        task: None,
        answer: None,
    }
}

fn granted(reserved: Reservation) -> i64 {
    match reserved {
        Reservation::Granted(id) => id,
        other => panic!("{other:?}"),
    }
}

#[tokio::test(flavor = "multi_thread", worker_threads = 4)]
async fn fifty_at_once_do_not_overrun_a_budget() {
    // Room for seven calls and most of an eighth.
    let (_directory, store, claim) = claimed(7_900).await;
    for round in 0..5 {
        let asked = (0..50).map(|number| {
            let (store, lease) = (store.clone(), claim.lease.clone());
            let key = format!("{round}-{number}");
            tokio::spawn(async move { store.reserve_call(&lease, call(&key, 1_000)).await.unwrap() })
        });
        let answers: Vec<Reservation> =
            join_all(asked).await.into_iter().map(|answer| answer.unwrap()).collect();
        let ids: Vec<i64> = answers
            .iter()
            .filter_map(|answer| match answer {
                Reservation::Granted(id) => Some(*id),
                Reservation::OverBudget { committed, budget } => {
                    assert!(*budget == 7_900 && *committed <= 7_900);
                    None
                }
                other => panic!("{other:?}"),
            })
            .collect();
        assert_eq!(ids.len(), 7);
        let spending =
            store.spending(&DEFAULT_TENANT, &claim.scene().expect("a scene").scene_id).await.unwrap();
        assert_eq!(spending, Spending { budget: 7_900, spent: 0, reserved: 7_000 });
        // All of them at once too; they cost nothing in the end, and there is room again.
        let settled = ids.into_iter().map(|id| store.settle_call(&claim.lease, id, end(Some(0), "answered")));
        assert!(join_all(settled).await.iter().all(Result::is_ok));
    }
}

#[tokio::test(flavor = "multi_thread", worker_threads = 4)]
async fn fifty_questions_at_once_are_billed_no_more_than_the_budget() {
    let server = ChatServer::start(breakfast()).await;
    let mut chat = quick(&server);
    chat.endpoint.limits.concurrency = 50;
    chat.endpoint.limits.attempt_timeout_secs = 20;
    let budget = 500_000;
    let (_directory, store, claim) = claimed(budget).await;
    let ledger = JobLedger::new(store.clone(), claim.lease.clone(), "reference", None);
    let mut outside = Call::without_budget(CpuPool::new(1).unwrap(), CancelFlag::default());
    outside.ledger = Arc::new(ledger);
    let analyst =
        Arc::new(ChatAnalyst { endpoint: Arc::new(endpoint(&chat, KEY, OnUnknown::Fail)), settings: chat });
    let asked = (0..50).map(|number| {
        let (analyst, call) = (analyst.clone(), outside.clone());
        tokio::spawn(async move {
            let text = format!("an apple on a plate, number {number}");
            analyst.describe(&call, text, 7, RequestOptions::default()).await
        })
    });
    let mut refused = 0;
    for answer in join_all(asked).await {
        match answer.unwrap() {
            Ok(_) => {}
            Err(ProviderError::OverBudget { .. }) => refused += 1,
            Err(other) => panic!("{other}"),
        }
    }
    let spending = store.spending(&DEFAULT_TENANT, &claim.scene().expect("a scene").scene_id).await.unwrap();
    assert_eq!(spending.reserved, 0);
    assert_eq!(spending.spent, 6_000 * server.bill().len() as i64);
    assert!(spending.spent <= budget && refused > 0, "{spending:?}, {refused} refused");
}

#[tokio::test]
async fn what_a_dead_worker_had_under_way_is_unknown_and_spent() {
    let (_directory, store, zombie) = claimed(10_000).await;
    store.expire_leases_of_others("heir").await.unwrap();
    let id = granted(store.reserve_call(&zombie.lease, call("k", 4_000)).await.unwrap());
    let heir = claim(&store, "heir", HOUR).await;
    let rows = store.calls(&DEFAULT_TENANT, &heir.scene().expect("a scene").scene_id).await.unwrap();
    assert_eq!(rows[0].outcome.as_deref(), Some("outcome_unknown"));
    assert_eq!(rows[0].settled_micro_usd, Some(4_000));
    // The dead may have only slept; what it says now changes nothing.
    let lost = store.settle_call(&zombie.lease, id, end(Some(1), "answered")).await;
    assert!(matches!(lost, Err(StoreError::LeaseLost { .. })));
    let lost = store.reserve_call(&zombie.lease, call("k", 1)).await;
    assert!(matches!(lost, Err(StoreError::LeaseLost { .. })));

    // Whether it is sent again is the operator's choice; either way it counts.
    let fail = NewCall { refuse_after_unknown: true, ..call("k", 4_000) };
    assert_eq!(store.reserve_call(&heir.lease, fail).await.unwrap(), Reservation::OutcomeUnknown);
    granted(
        store
            .reserve_call(&heir.lease, NewCall { refuse_after_unknown: true, ..call("other", 1) })
            .await
            .unwrap(),
    );
    granted(store.reserve_call(&heir.lease, call("k", 4_000)).await.unwrap());
    let over = store.reserve_call(&heir.lease, call("k", 4_000)).await.unwrap();
    assert_eq!(over, Reservation::OverBudget { committed: 8_001, budget: 10_000 });
}

#[tokio::test]
async fn a_vendors_job_outlives_the_worker_that_submitted_it() {
    let (_directory, store, zombie) = claimed(10_000).await;
    let job = zombie.lease.job_id.clone();
    let id = granted(store.reserve_call(&zombie.lease, call("k", 4_000)).await.unwrap());
    assert_eq!(store.task_of(&job, "k").await.unwrap(), None);
    let submitted = CallEnd { task: Some("gm3qorzdhg".into()), ..end(Some(4_000), "answered") };
    store.settle_call(&zombie.lease, id, submitted).await.unwrap();
    store.expire_leases_of_others("heir").await.unwrap();
    let heir = claim(&store, "heir", HOUR).await;
    let row = TaskRow { call_id: id, task: "gm3qorzdhg".into(), file: None };
    assert_eq!(store.task_of(&job, "k").await.unwrap(), Some(row.clone()));
    assert_eq!(store.task_of(&job, "l").await.unwrap(), None, "another question");
    let lost = store.note_task(&zombie.lease, id, TaskEnd::Over).await;
    assert!(matches!(lost, Err(StoreError::LeaseLost { .. })));

    // Through the ledger that stages see: the file is kept, and nothing is asked of the vendor any more.
    let ledger = JobLedger::new(store.clone(), heir.lease.clone(), "reconstruct", None);
    ledger.fetched(id, "glTF".into()).await.unwrap();
    let digest = store.task_of(&job, "k").await.unwrap().unwrap().file.unwrap();
    assert_eq!(store.blobs().get(&digest).await.unwrap().unwrap(), "glTF");
    ledger.over(id).await.unwrap();
    assert_eq!(store.task_of(&job, "k").await.unwrap(), None);
    assert!(!ledger.is_cancelled().await);
    store.cancel(&DEFAULT_TENANT, &job).await.unwrap();
    assert!(ledger.is_cancelled().await);
    let spending = store.spending(&DEFAULT_TENANT, &heir.scene().expect("a scene").scene_id).await.unwrap();
    assert_eq!(spending, Spending { budget: 10_000, spent: 4_000, reserved: 0 });
}

#[tokio::test]
async fn what_a_dead_worker_was_answered_is_not_paid_for_again() {
    let server = ChatServer::start(breakfast()).await;
    let (_directory, store, zombie) = claimed(10_000_000).await;
    let analyst = {
        let chat = quick(&server);
        ChatAnalyst { endpoint: Arc::new(endpoint(&chat, KEY, OnUnknown::Fail)), settings: chat }
    };
    // Each call is a run of the stage with books of its own.
    let describe = async |lease: &Lease| {
        let ledger = JobLedger::new(store.clone(), lease.clone(), "reference", None);
        let mut outside = Call::without_budget(CpuPool::new(1).unwrap(), CancelFlag::default());
        outside.ledger = Arc::new(ledger);
        let text = "an apple on a plate".to_owned();
        analyst.describe(&outside, text, 7, RequestOptions::default()).await.unwrap()
    };
    server.script([Fault::Spoiled("/objects/0/width_m", json!(9))]);
    let described = describe(&zombie.lease).await;
    assert_eq!(server.bill().len(), 2, "the second is the corrected one");
    store.expire_leases_of_others("heir").await.unwrap();
    let heir = claim(&store, "heir", HOUR).await;
    assert_eq!(describe(&heir.lease).await, described);
    assert_eq!(
        (
            server.bill().len(),
            store.calls(&DEFAULT_TENANT, &heir.scene().expect("a scene").scene_id).await.unwrap().len()
        ),
        (2, 2)
    );
    // Answers that will not do are asked for anew, in this stage alone.
    store.forget_answers(&heir.lease, "recognize", "").await.unwrap();
    describe(&heir.lease).await;
    assert_eq!(server.bill().len(), 2);
    store.forget_answers(&heir.lease, "reference", "").await.unwrap();
    describe(&heir.lease).await;
    assert_eq!(server.bill().len(), 3);
    let spending = store.spending(&DEFAULT_TENANT, &heir.scene().expect("a scene").scene_id).await.unwrap();
    assert_eq!(spending.spent, 6_000 * 3);
}

#[tokio::test]
async fn a_question_that_is_asked_twice_has_two_answers() {
    let (_directory, store, claim) = claimed(10_000).await;
    let ledger = || JobLedger::new(store.clone(), claim.lease.clone(), "reference", None);
    let intent = || Intent {
        port: Port::ImageGenerator,
        provider: "openai/images".into(),
        model: "m".into(),
        endpoint: "https://api.openai.com/v1/images/generations".into(),
        operation: "paint",
        request_digest: "d".into(),
        attempt: 1,
        reserved: MicroUsd(10),
        sent_bytes: 1,
        on_unknown: OnUnknown::Fail,
    };
    let answered = |answer: &'static str| Settlement {
        cost: None,
        received_bytes: 1,
        input_tokens: None,
        output_tokens: None,
        outcome: "answered",
        task: None,
        answer: Some(answer.into()),
    };
    let first = ledger();
    for answer in ["too small", "good"] {
        assert_eq!(first.answer("d".into()).await.unwrap(), None, "what this run had is not had again");
        let entry = first.reserve(intent()).await.unwrap();
        first.settle(entry, answered(answer)).await.unwrap();
    }
    let again = ledger();
    for expected in [Some("too small"), Some("good"), None, None] {
        assert_eq!(again.answer("d".into()).await.unwrap(), expected.map(Bytes::from));
    }
    assert_eq!(again.answer("another".into()).await.unwrap(), None);
}

#[tokio::test]
async fn every_way_out_of_a_worker_closes_the_books() {
    let failure = || store::lifecycle::Failure {
        class: store::lifecycle::FailureClass::Transient,
        code: "t".into(),
        message: "m".into(),
    };
    let retry =
        AttemptOutcome::Retry { failure: failure(), delay: Duration::ZERO, charged: true, max_attempts: 5 };
    for outcome in [retry, AttemptOutcome::Failed(failure()), AttemptOutcome::Released] {
        let (_directory, store, claim) = claimed(10_000).await;
        granted(store.reserve_call(&claim.lease, call("k", 4_000)).await.unwrap());
        store.finish(&claim.lease, outcome).await.unwrap();
        let spending =
            store.spending(&DEFAULT_TENANT, &claim.scene().expect("a scene").scene_id).await.unwrap();
        assert_eq!(spending, Spending { budget: 10_000, spent: 4_000, reserved: 0 });
    }
}

#[tokio::test]
async fn what_costs_nothing_is_granted_and_a_dearer_bill_than_expected_is_written_as_it_is() {
    let (_directory, store, claim) = claimed(1_000).await;
    let id = granted(store.reserve_call(&claim.lease, call("k", 1_000)).await.unwrap());
    store.settle_call(&claim.lease, id, end(Some(1_500), "answered")).await.unwrap();
    granted(store.reserve_call(&claim.lease, call("free", 0)).await.unwrap());
    let over = store.reserve_call(&claim.lease, call("k", 1)).await.unwrap();
    assert_eq!(over, Reservation::OverBudget { committed: 1_500, budget: 1_000 });
}

#[tokio::test]
async fn clients_see_what_a_scene_has_cost() {
    let (directory, store, claim) = claimed(2_000_000).await;
    let id = granted(store.reserve_call(&claim.lease, call("k", 40_000)).await.unwrap());
    store.settle_call(&claim.lease, id, end(Some(6_000), "answered")).await.unwrap();
    granted(store.reserve_call(&claim.lease, call("l", 50_000)).await.unwrap());
    drop(store);
    wait_until_unlocked(directory.path()).await;
    let script = Script::new(&[("alpha", &[Act::Wait])]);
    let server = Server::on(directory, &script, &[]).await;
    let scene = server.get(&format!("/scenes/{}", claim.scene().expect("a scene").scene_id)).await.json();
    let spending = &scene["spending"];
    assert_eq!((&spending["budget_usd"], &spending["calls"][0]["settled_usd"]), (&json!(2.0), &json!(0.006)));
    assert_eq!(spending["calls"][0]["outcome"], "answered");
    assert_eq!(spending["calls"][0]["input_tokens"], 3);
    // The new process took the job over, or is about to.
    let second = &spending["calls"][1];
    assert!(second["outcome"].is_null() || second["outcome"] == "outcome_unknown", "{second}");
    script.open_gate();
    server.stop().await;
}

#[tokio::test]
async fn a_request_names_its_budget() {
    let server = Server::start(&Script::new(&[])).await;
    let submit = |budget: serde_json::Value| json!({ "text": "a desk", "options": { "budget_usd": budget } });
    let scene = server.post("/scenes", submit(json!(0.25))).await.json();
    let shown = server.get(&format!("/scenes/{}", scene["id"].as_str().unwrap())).await.json();
    assert_eq!(shown["spending"]["budget_usd"], 0.25);
    let scene = server.post("/scenes", json!({ "text": "a desk" })).await.json();
    let shown = server.get(&format!("/scenes/{}", scene["id"].as_str().unwrap())).await.json();
    assert_eq!(shown["spending"]["budget_usd"], 5.0, "the server's usual one");
    assert_eq!(shown["spending"]["calls"], json!([]));
    for bad in [json!(-1), json!(10_001), json!("5"), json!(1e300)] {
        let reply = server.post("/scenes", submit(bad)).await;
        assert_eq!(reply.status, 422, "{reply:?}");
        assert_eq!(reply.json()["errors"][0]["pointer"], "/options/budget_usd");
    }
    server.stop().await;
}
