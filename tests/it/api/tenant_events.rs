//! Events of all jobs of a tenant: pages, and one stream for everything.

use serde_json::Value;

use crate::harness::event_stream::EventStream;
use crate::harness::script::{Act, Script};
use crate::harness::server::Server;

/// Every event after a number, by pages.
async fn pages(server: &Server, mut after: i64) -> Vec<Value> {
    let mut all = Vec::new();
    loop {
        let page = server.get(&format!("/events?after={after}&page_size=5")).await.json();
        let events = page["events"].as_array().unwrap().clone();
        if events.is_empty() {
            return all;
        }
        after = page["next_after"].as_i64().unwrap();
        all.extend(events);
    }
}

#[tokio::test]
async fn pages_have_every_event_of_every_job_once_in_order() {
    let server = Server::start(&Script::new(&[])).await;
    let mut jobs = Vec::new();
    for text in ["a mug", "a bowl"] {
        let (scene, job) = server.submit(text).await;
        server.job_is(&job, "succeeded").await;
        jobs.push((scene, job));
    }
    let all = pages(&server, 0).await;
    let numbers: Vec<i64> = all.iter().map(|event| event["seq"].as_i64().unwrap()).collect();
    assert!(numbers.is_sorted_by(|one, next| one < next), "{numbers:?}");
    let mut count = 0;
    for (scene, job) in &jobs {
        let own: Vec<&Value> = all.iter().filter(|event| event["job_id"] == job.as_str()).collect();
        assert!(
            own.iter().all(|event| event["scene_id"] == scene.as_str() && event["job_kind"] == "generate")
        );
        let page = server.get(&format!("/jobs/{job}/events?page_size=200")).await.json();
        let stored = page["events"].as_array().unwrap();
        for (event, stored) in own.iter().zip(stored) {
            assert_eq!(
                (&event["number"], &event["kind"], &event["data"]),
                (&stored["seq"], &stored["kind"], &stored["data"])
            );
        }
        assert_eq!(own.len(), stored.len());
        count += own.len();
    }
    assert_eq!(all.len(), count);
    let finished = all.iter().find(|event| event["kind"] == "stage_finished").expect("a stage was finished");
    assert_eq!(finished["data"]["artifacts"], serde_json::json!(["alpha/note.txt"]));
    assert_eq!(server.get("/events?after=-1").await.problem().0, 400);
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_stream_tells_of_all_jobs_from_now_on_and_goes_on_where_it_broke_off() {
    let script = Script::new(&[("omega", &[Act::Wait])]);
    let server = Server::start(&script).await;
    let (_, before) = server.submit("a mug").await;
    script.reaches("omega").await;
    let known = pages(&server, 0).await;
    let stream = EventStream::open(server.service.address, "/events", None);
    script.open_gate();
    let (_, job) = server.submit("a bowl").await;
    let (seen, stream) = stream.read(4).await;
    drop(stream);
    for job in [&before, &job] {
        server.job_is(job, "succeeded").await;
    }
    let last_known = known.last().unwrap()["seq"].as_i64().unwrap();
    let expected = pages(&server, last_known).await;
    let rest = EventStream::open(server.service.address, "/events?after=0", Some(seen.last().unwrap().seq));
    let (rest, _) = rest.read(expected.len() - seen.len()).await;
    let received = [seen, rest].concat();
    assert_eq!(received.iter().map(|event| event.data.clone()).collect::<Vec<_>>(), expected);
    assert!(
        received.iter().any(|event| event.data["job_id"] == before.as_str() && event.kind == "job_succeeded")
    );
    assert!(received.iter().any(|event| event.data["job_id"] == job.as_str() && event.kind == "job_queued"));
}
