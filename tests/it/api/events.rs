//! Events: pages and streams, with nothing lost or repeated across reconnects and restarts.

use hyper::Method;
use serde_json::Value;

use crate::harness::event_stream::{EventStream, SentEvent};
use crate::harness::script::{Act, Script};
use crate::harness::server::Server;

fn stream(server: &Server, job: &str, last_event_id: Option<i64>) -> EventStream {
    EventStream::open(server.service.address, &format!("/jobs/{job}/events"), last_event_id)
}

fn numbers(events: &[SentEvent]) -> Vec<i64> {
    events.iter().map(|event| event.seq).collect()
}

#[tokio::test]
async fn pages_tell_the_whole_story_in_order() {
    let server = Server::start(&Script::new(&[])).await;
    let (_, job) = server.submit("a mug").await;
    server.job_is(&job, "succeeded").await;
    let kinds = server.kinds(&job).await;
    assert_eq!((kinds[0].as_str(), kinds[1].as_str()), ("job_queued", "job_started"));
    assert_eq!(kinds.last().unwrap(), "job_succeeded");
    assert_eq!(kinds.iter().filter(|kind| *kind == "stage_finished").count(), 4);
    let (mut seen, mut after) = (Vec::new(), 0);
    loop {
        let page = server.get(&format!("/jobs/{job}/events?after={after}&page_size=3")).await.json();
        let events = page["events"].as_array().unwrap().clone();
        if events.is_empty() {
            break;
        }
        seen.extend(events.iter().map(|event| event["seq"].as_i64().unwrap()));
        after = page["next_after"].as_i64().unwrap();
    }
    assert_eq!(seen, (1..=kinds.len() as i64).collect::<Vec<_>>());
    assert_eq!(server.get(&format!("/jobs/{job}/events?after=-1")).await.problem().0, 400);
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_stream_follows_the_job_and_ends_with_it() {
    let script = Script::new(&[("omega", &[Act::Wait])]);
    let server = Server::start(&script).await;
    let (_, job) = server.submit("a mug").await;
    let open = stream(&server, &job, None);
    script.reaches("omega").await;
    script.open_gate();
    let seen = open.until(usize::MAX).await;
    assert_eq!(numbers(&seen), (1..=seen.len() as i64).collect::<Vec<_>>());
    assert_eq!(seen.last().unwrap().kind, "job_succeeded");

    let rest = stream(&server, &job, Some(3)).until(usize::MAX).await;
    assert_eq!(rest, seen[3..]);
    let headers = [("accept", "text/event-stream"), ("last-event-id", &seen.len().to_string())];
    let nothing = server.call(Method::GET, &format!("/jobs/{job}/events"), &headers, "").await;
    assert_eq!((nothing.status.as_u16(), nothing.body.len()), (204, 0));
    let headers = [("accept", "text/event-stream"), ("last-event-id", "x")];
    let bad = server.call(Method::GET, &format!("/jobs/{job}/events"), &headers, "").await;
    assert_eq!(bad.problem(), (400, "invalid_last_event_id".into()));
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_stream_goes_on_after_a_restart_where_it_broke_off() {
    let script = Script::new(&[("beta", &[Act::Wait, Act::Wait])]);
    // The stage is interrupted: a worker that lets it end may end the job, too, before it sees that it is to stop.
    let server = Server::with(&script, &[("worker.drain_grace_secs", "0")]).await;
    let (_, job) = server.submit("a mug").await;
    script.reaches("beta/mug_1").await;
    let before = stream(&server, &job, None).until(4).await;
    let open = stream(&server, &job, None);
    let directory = server.stop().await;
    let ended = open.until(usize::MAX).await;
    assert!(ended.iter().all(|event| event.kind != "job_succeeded"), "the drain came before the end");

    let server = Server::on(directory, &Script::new(&[]), &[]).await;
    let last = before.last().unwrap().seq;
    let after = stream(&server, &job, Some(last)).until(usize::MAX).await;
    let all = [before, after].concat();
    assert_eq!(numbers(&all), (1..=all.len() as i64).collect::<Vec<_>>());
    assert_eq!(all.last().unwrap().kind, "job_succeeded");
    let page = server.get(&format!("/jobs/{job}/events?page_size=200")).await.json();
    let stored: Vec<Value> = page["events"].as_array().unwrap().clone();
    assert_eq!(stored.len(), all.len());
}
