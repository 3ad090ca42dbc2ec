//! Cancel, retry, delete; failures and what comes after them.

use hyper::Method;
use serde_json::json;

use crate::harness::script::{Act, Script};
use crate::harness::server::Server;

#[tokio::test]
async fn a_running_job_is_cancelled_and_tried_again_from_where_it_was() {
    let script = Script::new(&[("omega", &[Act::Wait])]);
    let server = Server::start(&script).await;
    let (scene, job) = server.submit("a mug").await;
    script.reaches("omega").await;
    let active = server.call(Method::POST, &format!("/jobs/{job}/retry"), &[], "").await;
    assert_eq!(active.problem(), (409, "job_still_active".into()));
    let cancel = server.call(Method::POST, &format!("/jobs/{job}/cancel"), &[], "").await;
    assert_eq!(cancel.status, 202);
    server.job_is(&job, "cancelled").await;
    // Asking again is fine and changes nothing.
    assert_eq!(server.call(Method::POST, &format!("/jobs/{job}/cancel"), &[], "").await.status, 202);
    let view = server.get(&format!("/scenes/{scene}")).await.json();
    assert_eq!(
        (view["state"].as_str(), view["failure"]["code"].as_str()),
        (Some("failed"), Some("cancelled"))
    );

    let retry = server.call(Method::POST, &format!("/jobs/{job}/retry"), &[], "").await;
    assert_eq!(retry.status, 202);
    let second = retry.json()["id"].as_str().unwrap().to_owned();
    assert_eq!(retry.header("location"), format!("/jobs/{second}"));
    assert_eq!(retry.json()["retry_of"], json!(job));
    server.job_is(&second, "succeeded").await;
    assert_eq!(script.runs().len(), 5, "only the stage that was stopped ran again: {:?}", script.runs());
    let view = server.get(&format!("/scenes/{scene}")).await.json();
    assert_eq!((view["state"].as_str(), &view["failure"]), (Some("ready"), &json!(null)));

    let late = server.call(Method::POST, &format!("/jobs/{second}/cancel"), &[], "").await;
    assert_eq!(late.problem(), (409, "job_already_ended".into()));
    let ready = server.call(Method::POST, &format!("/jobs/{second}/retry"), &[], "").await;
    assert_eq!(ready.problem(), (409, "scene_not_retryable".into()));
}

#[tokio::test]
async fn a_queued_job_is_cancelled_at_once() {
    let script = Script::new(&[("alpha", &[Act::Wait])]);
    let server = Server::with(&script, &[("worker.concurrency", "1")]).await;
    let (_, first) = server.submit("a mug").await;
    script.reaches("alpha").await;
    let (_, second) = server.submit("a bowl").await;
    let cancel = server.call(Method::POST, &format!("/jobs/{second}/cancel"), &[], "").await;
    assert_eq!(cancel.json()["state"], "cancelled");
    script.open_gate();
    server.job_is(&first, "succeeded").await;
    assert_eq!(server.kinds(&second).await, ["job_queued", "job_cancelled"]);
}

#[tokio::test]
async fn a_retry_from_a_stage_computes_it_and_what_follows_anew() {
    let script = Script::quarantining();
    let server = Server::start(&script).await;
    let (_, job) = server.submit("a mug").await;
    server.job_is(&job, "succeeded").await;
    let unknown = server.post(&format!("/jobs/{job}/retry"), json!({ "from_stage": "gamma" })).await;
    assert_eq!(unknown.problem(), (409, "stage_not_reached".into()));
    let misspelled = server.post(&format!("/jobs/{job}/retry"), json!({ "form_stage": "beta" })).await;
    assert_eq!(misspelled.problem(), (422, "invalid_body".into()));
    let path = format!("/jobs/{job}/retry");
    let text = server.call(Method::POST, &path, &[("content-type", "text/plain")], "beta").await;
    assert_eq!(text.problem(), (415, "body_format".into()));

    let retry = server.post(&path, json!({ "from_stage": "beta" })).await.json();
    let second = retry["id"].as_str().unwrap();
    server.job_is(second, "succeeded").await;
    let runs = script.runs();
    let again: Vec<&str> = runs[4..].iter().map(String::as_str).collect();
    assert_eq!(again.len(), 3, "{again:?}");
    assert!(!again.contains(&"alpha") && again.contains(&"beta/mug_1") && again.contains(&"omega"));
    let stages = server.get(&format!("/jobs/{second}/stages")).await.json();
    assert_eq!(
        (&stages["stages"][0]["stage"], &stages["stages"][0]["cached"]),
        (&json!("alpha"), &json!(true))
    );
}

#[tokio::test]
async fn deleting_stops_the_work_and_hides_the_scene() {
    let script = Script::new(&[("omega", &[Act::Wait])]);
    let server = Server::start(&script).await;
    let (scene, job) = server.submit("a mug").await;
    script.reaches("omega").await;
    let path = format!("/scenes/{scene}");
    assert_eq!(server.call(Method::DELETE, &path, &[], "").await.status, 204);
    server.job_is(&job, "cancelled").await;
    for path in
        [path.clone(), format!("{path}/bundle"), format!("{path}/artifacts"), format!("{path}/artifacts/a")]
    {
        assert_eq!(server.get(&path).await.problem(), (410, "scene_deleted".into()), "{path}");
    }
    assert_eq!(server.call(Method::DELETE, &path, &[], "").await.status, 204);
    let retry = server.call(Method::POST, &format!("/jobs/{job}/retry"), &[], "").await;
    assert_eq!(retry.problem(), (409, "scene_not_retryable".into()));
}

#[tokio::test]
async fn what_may_pass_is_tried_again_and_a_new_checkpoint_starts_the_count_anew() {
    let flaky = [Act::Transient, Act::Panic];
    let script = Script::new(&[("alpha", &flaky), ("omega", &flaky)]);
    let server = Server::start(&script).await;
    let (_, job) = server.submit("a mug").await;
    server.job_is(&job, "succeeded").await;
    let kinds = server.kinds(&job).await;
    assert_eq!(kinds.iter().filter(|kind| *kind == "job_retrying").count(), 4);
    assert_eq!(script.runs().iter().filter(|run| run.starts_with("beta")).count(), 2);
}

#[tokio::test]
async fn a_panic_every_time_fails_the_job_after_its_attempts() {
    let script =
        Script::new(&[("beta", &[Act::Panic, Act::Panic, Act::Panic, Act::Panic, Act::Panic, Act::Panic])]);
    let server = Server::with(&script, &[("worker.fan_out", "1")]).await;
    let (scene, job) = server.submit("a mug").await;
    let job = server.job_is(&job, "failed").await;
    assert_eq!(job["failure"]["class"], "crashed");
    assert_eq!(job["failure"]["code"], "stage_panicked");
    assert!(job["failure"]["message"].as_str().unwrap().contains("the script says so"));
    assert_eq!(job["attempt"], 3);
    let view = server.get(&format!("/scenes/{scene}")).await.json();
    assert_eq!(view["failure"]["code"], "stage_panicked");
    // The worker lives.
    let (_, next) = server.submit("a bowl").await;
    server.job_is(&next, "succeeded").await;
}

#[tokio::test]
async fn what_never_works_is_not_tried_again() {
    let script = Script::new(&[("alpha", &[Act::Permanent])]);
    let server = Server::start(&script).await;
    let (_, job) = server.submit("a mug").await;
    server.job_is(&job, "failed").await;
    assert_eq!(script.runs(), ["alpha"]);
}

#[tokio::test]
async fn two_jobs_that_want_the_same_compute_it_once() {
    let script = Script::new(&[("alpha", &[Act::Wait])]);
    let server = Server::start(&script).await;
    let (_, first) = server.submit("a mug").await;
    let (_, second) = server.submit("a mug").await;
    script.reaches("alpha").await;
    script.open_gate();
    server.job_is(&first, "succeeded").await;
    server.job_is(&second, "succeeded").await;
    assert_eq!(script.runs().len(), 4, "{:?}", script.runs());
}
