//! Every fault of the script, over the chat analyst: each ends in its class, nothing hangs, and the books
//! never say less than the server's bill.

use std::time::Duration;

use ports::ProviderError;
use ports::ledger::OnUnknown;

use crate::remote::bench::class;
use crate::remote::chat::{Bench, endpoint};
use crate::remote::chat_server::Fault;

/// Price of a good answer of the server, millionths of a dollar.
const PRICE: i64 = 6000;

const ANSWERED: &str = "answered";
const UNKNOWN: &str = "outcome_unknown";

/// A question of one turn.
#[derive(Clone, Copy, Debug)]
enum Operation {
    Describe,
    Upright,
    Judge,
    ProposeTasks,
}

impl Operation {
    async fn result(self, bench: &Bench) -> Result<(), ProviderError> {
        match self {
            Self::Describe => bench.describe().await.map(drop),
            Self::Upright => bench.upright().await.map(drop),
            Self::Judge => bench.judge().await.map(drop),
            Self::ProposeTasks => bench.tasks().await.map(drop),
        }
    }
}

/// Result of a description: `ok` or a class, and the recorded outcomes.
async fn ended(bench: &Bench, faults: &[Fault]) -> (String, Vec<&'static str>) {
    asked(Operation::Describe, bench, faults).await
}

/// Result of a question: `ok` or a class, and the recorded outcomes.
async fn asked(operation: Operation, bench: &Bench, faults: &[Fault]) -> (String, Vec<&'static str>) {
    bench.server.script(faults.iter().cloned());
    let result = operation.result(bench).await;
    let outcomes: Vec<&'static str> =
        bench.book.outcomes().into_iter().map(|outcome| outcome.expect("everything is settled")).collect();
    let billed = bench.server.bill().len() as i64 * PRICE;
    assert!(bench.book.spent() >= billed, "{faults:?}: {} < {billed}", bench.book.spent());
    (result.map_or_else(|error| class(&error), |_| "ok".into()), outcomes)
}

#[tokio::test]
async fn each_fault_ends_in_its_class() {
    use Fault::*;
    let cases: Vec<(Vec<Fault>, &str, Vec<&str>)> = vec![
        (vec![], "ok", vec![ANSWERED]),
        (vec![Latency(Duration::from_millis(200))], "ok", vec![ANSWERED]),
        (vec![Busy(0)], "ok", vec!["provider_busy", ANSWERED]),
        // Longer than anybody waits here: the job goes back to its queue.
        (vec![Busy(3600)], "rate_limited 3600", vec!["provider_busy"]),
        (vec![Busy(0), Busy(0), Busy(0)], "rate_limited 0", vec!["provider_busy"; 3]),
        (vec![NoCredit], "misconfigured provider_quota_spent", vec!["provider_quota_spent"]),
        (vec![Status(500)], "ok", vec!["provider_server_error", ANSWERED]),
        (vec![Status(503), Status(502)], "ok", vec!["provider_server_error", UNKNOWN, ANSWERED]),
        (
            vec![Status(500), Status(500), Status(500)],
            "transient provider_server_error",
            vec!["provider_server_error"; 3],
        ),
        // A proxy in front of the model did not wait for it.
        (vec![Status(504)], "ok", vec![UNKNOWN, ANSWERED]),
        (vec![Status(400)], "rejected provider_rejected_request", vec!["provider_rejected_request"]),
        (vec![Status(403)], "misconfigured provider_denied", vec!["provider_denied"]),
        (vec![Status(404)], "misconfigured provider_not_found", vec!["provider_not_found"]),
        (vec![ResetMidBody], "ok", vec![UNKNOWN, ANSWERED]),
        (vec![ResetBeforeHeader], "ok", vec![UNKNOWN, ANSWERED]),
        (
            vec![ResetMidBody, ResetMidBody, ResetMidBody],
            "transient provider_connection_lost",
            vec![UNKNOWN; 3],
        ),
        (vec![Page], "ok", vec!["provider_bad_answer", ANSWERED]),
        (vec![NoJson], "ok", vec!["provider_bad_answer", ANSWERED]),
        (vec![Page, Page, Page], "transient provider_bad_answer", vec!["provider_bad_answer"; 3]),
        (vec![Fenced], "ok", vec![ANSWERED]),
        (vec![Sentence], "ok", vec![ANSWERED]),
        (vec![OtherForm], "ok", vec![ANSWERED; 2]),
        (vec![OtherForm, OtherForm], "transient provider_bad_answer", vec![ANSWERED; 2]),
        (vec![Refusal], "refused answer_refused", vec!["answer_refused"]),
        (vec![OtherForm, Refusal], "refused answer_refused", vec![ANSWERED, "answer_refused"]),
        (vec![Truncated], "rejected answer_truncated", vec!["answer_truncated"]),
        (vec![Filtered], "refused answer_filtered", vec!["answer_filtered"]),
        (vec![Endless], "transient provider_answer_too_large", vec!["provider_answer_too_large"]),
        (
            vec![Redirect("http://169.254.169.254/latest/meta-data")],
            "misconfigured provider_redirected",
            vec!["provider_redirected"],
        ),
        (
            vec![Redirect("/v1/chat/completions")],
            "misconfigured provider_redirected",
            vec!["provider_redirected"],
        ),
    ];
    use Operation::*;
    for operation in [Describe, Upright, Judge, ProposeTasks] {
        for (faults, expected, outcomes) in &cases {
            let bench = Bench::new().await;
            let (result, written) = asked(operation, &bench, faults).await;
            assert_eq!((result.as_str(), &written), (*expected, outcomes), "{operation:?}: {faults:?}");
            assert_eq!(bench.server.left(), 0, "{operation:?}: {faults:?}");
        }
    }
}

#[tokio::test]
async fn silence_ends_with_the_deadline() {
    let bench = Bench::new().await;
    let (result, written) = ended(&bench, &[Fault::Silence]).await;
    assert_eq!((result.as_str(), written), ("ok", vec![UNKNOWN, ANSWERED]));
    let bench = Bench::with(|chat| chat.endpoint.limits.max_tries = 1, OnUnknown::Resend).await;
    let (result, written) = ended(&bench, &[Fault::Silence]).await;
    assert_eq!((result.as_str(), written), ("transient provider_timeout", vec![UNKNOWN]));
    // The total counts too: there is no time for a second try.
    let bench = Bench::with(|chat| chat.endpoint.limits.total_timeout_secs = 1, OnUnknown::Resend).await;
    let (result, written) = ended(&bench, &[Fault::Silence, Fault::Silence]).await;
    assert_eq!((result.as_str(), written), ("transient provider_timeout", vec![UNKNOWN]));
}

#[tokio::test]
async fn a_lost_answer_is_left_to_a_person_where_the_operator_wants_that() {
    for fault in [Fault::ResetMidBody, Fault::ResetBeforeHeader, Fault::Silence] {
        let bench = Bench::with(|_| {}, OnUnknown::Fail).await;
        let (result, written) = ended(&bench, std::slice::from_ref(&fault)).await;
        assert_eq!((result.as_str(), written), ("rejected outcome_unknown", vec![UNKNOWN]), "{fault:?}");
        assert_eq!(bench.server.bill().len(), 1, "nothing is sent twice");
    }
}

#[tokio::test]
async fn every_recognition_turn_survives_a_fault() {
    for turn in 0..3 {
        let bench = Bench::new().await;
        let mut faults = vec![Fault::Latency(Duration::ZERO); turn];
        faults.push(Fault::Status(503));
        bench.server.script(faults);
        bench.recognize().await.unwrap();
        assert_eq!(bench.server.bill().len(), 3);
        let bench = Bench::new().await;
        let mut faults = vec![Fault::Latency(Duration::ZERO); turn];
        faults.push(Fault::Refusal);
        bench.server.script(faults);
        let error = bench.recognize().await.unwrap_err();
        assert_eq!(class(&error), "refused answer_refused", "turn {turn}");
    }
}

#[tokio::test]
async fn a_server_that_fails_again_and_again_is_left_alone() {
    let fragile = |chat: &mut remote::ChatSettings| {
        chat.endpoint.limits.breaker_failures = 2;
        chat.endpoint.limits.max_tries = 1;
    };
    let bench = Bench::with(fragile, OnUnknown::Resend).await;
    bench.server.script([Fault::Status(500), Fault::Status(500)]);
    for _ in 0..2 {
        assert_eq!(class(&bench.describe().await.unwrap_err()), "transient provider_server_error");
    }
    for _ in 0..3 {
        assert_eq!(class(&bench.describe().await.unwrap_err()), "transient provider_circuit_open");
    }
    assert_eq!(bench.server.requests().len(), 2, "a server that rests hears nothing");
    assert_eq!(bench.book.outcomes().len(), 2, "and nothing is set aside for it");
}

#[tokio::test]
async fn cancelled_job_stops_waiting_and_pays_for_calls_under_way() {
    let bench = Bench::with(|chat| chat.endpoint.limits.attempt_timeout_secs = 3600, OnUnknown::Resend).await;
    bench.server.script([Fault::Silence]);
    let cancel = bench.call.cancel.clone();
    let asked = bench.describe();
    let cancelled = async {
        while bench.server.requests().is_empty() {
            tokio::time::sleep(Duration::from_millis(5)).await;
        }
        cancel.cancel();
    };
    let (result, ()) = tokio::join!(asked, cancelled);
    assert!(matches!(result, Err(ProviderError::Cancelled(_))));
    assert_eq!(bench.book.outcomes(), [Some(UNKNOWN)]);
    assert!(bench.book.spent() > PRICE);
}

#[tokio::test]
async fn wrong_key_is_refused_and_never_shown() {
    let mut bench = Bench::new().await;
    let key = "sk-wrong-987654321";
    bench.analyst.endpoint = endpoint(&bench.analyst.settings, key, OnUnknown::Resend).into();
    let error = bench.describe().await.unwrap_err();
    assert_eq!(class(&error), "misconfigured provider_denied");
    assert!(error.to_string().contains("Incorrect API key provided: [redacted]"), "{error}");
    assert!(!error.to_string().contains(key));
    let rows = bench.book.rows.lock().unwrap();
    assert!(!format!("{rows:?}").contains(key));
}

#[tokio::test]
async fn unreachable_server_costs_nothing() {
    let mut bench = Bench::new().await;
    // A port that was free a moment ago.
    let listener = std::net::TcpListener::bind("127.0.0.1:0").unwrap();
    let address = listener.local_addr().unwrap();
    drop(listener);
    bench.analyst.settings.endpoint.base_url = format!("http://{address}/v1");
    bench.analyst.endpoint = endpoint(&bench.analyst.settings, "sk", OnUnknown::Fail).into();
    let error = bench.describe().await.unwrap_err();
    assert_eq!(class(&error), "transient provider_unreachable");
    assert_eq!(bench.book.outcomes(), [Some("provider_unreachable"); 3]);
    assert_eq!(bench.book.spent(), 0);
}
