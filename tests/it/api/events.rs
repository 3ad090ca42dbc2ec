//! Events: pages and streams, with nothing lost or repeated across reconnects and restarts.

use std::io::{BufRead, BufReader, Write};
use std::net::{SocketAddr, TcpStream};
use std::time::Duration;

use hyper::Method;
use serde_json::Value;

use crate::harness::script::{Act, Script};
use crate::harness::server::Server;

/// A stream of server-sent events, read by hand.
struct Stream {
    reader: BufReader<TcpStream>,
}

impl Stream {
    fn open(address: SocketAddr, job: &str, last_event_id: Option<i64>) -> Self {
        let mut socket = TcpStream::connect(address).expect("connects");
        socket.set_read_timeout(Some(Duration::from_secs(20))).unwrap();
        let last = last_event_id.map_or(String::new(), |id| format!("last-event-id: {id}\r\n"));
        let request = format!(
            "GET /jobs/{job}/events HTTP/1.1\r\nhost: localhost\r\naccept: text/event-stream\r\n{last}\r\n"
        );
        socket.write_all(request.as_bytes()).expect("writes");
        let mut reader = BufReader::new(socket);
        let mut line = String::new();
        reader.read_line(&mut line).expect("reads");
        assert!(line.contains(" 200 "), "{line}");
        while line.trim() != "" {
            line.clear();
            reader.read_line(&mut line).expect("reads");
        }
        Self { reader }
    }

    /// Number and kind of the next event; `None` when the stream has ended.
    fn next(&mut self) -> Option<(i64, String)> {
        let (mut id, mut kind) = (None, None);
        loop {
            let mut line = String::new();
            if self.reader.read_line(&mut line).expect("reads") == 0 {
                return None;
            }
            if let Some(value) = line.strip_prefix("id: ") {
                id = value.trim().parse().ok();
            } else if let Some(value) = line.strip_prefix("event: ") {
                kind = Some(value.trim().to_owned());
            } else if line.trim().is_empty() && id.is_some() {
                return id.zip(kind);
            }
        }
    }

    async fn until(mut self, count: usize) -> Vec<(i64, String)> {
        let read = tokio::task::spawn_blocking(move || {
            let mut seen = Vec::new();
            while seen.len() < count {
                match self.next() {
                    Some(event) => seen.push(event),
                    None => break,
                }
            }
            seen
        });
        read.await.unwrap()
    }
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
    let stream = Stream::open(server.service.address, &job, None);
    script.reaches("omega").await;
    script.open_gate();
    let seen = stream.until(usize::MAX).await;
    let numbers: Vec<i64> = seen.iter().map(|(id, _)| *id).collect();
    assert_eq!(numbers, (1..=seen.len() as i64).collect::<Vec<_>>());
    assert_eq!(seen.last().unwrap().1, "job_succeeded");

    let rest = Stream::open(server.service.address, &job, Some(3)).until(usize::MAX).await;
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
    let server = Server::start(&script).await;
    let (_, job) = server.submit("a mug").await;
    script.reaches("beta/mug_1").await;
    let before = Stream::open(server.service.address, &job, None).until(4).await;
    let open = Stream::open(server.service.address, &job, None);
    script.open_gate();
    let directory = server.stop().await;
    let ended = open.until(usize::MAX).await;
    assert!(ended.iter().all(|(_, kind)| kind != "job_succeeded"), "the drain came before the end");

    let server = Server::on(directory, &Script::new(&[]), &[]).await;
    let last = before.last().unwrap().0;
    let after = Stream::open(server.service.address, &job, Some(last)).until(usize::MAX).await;
    let numbers: Vec<i64> = before.iter().chain(&after).map(|(id, _)| *id).collect();
    assert_eq!(numbers, (1..=numbers.len() as i64).collect::<Vec<_>>());
    assert_eq!(after.last().unwrap().1, "job_succeeded");
    let page = server.get(&format!("/jobs/{job}/events?page_size=200")).await.json();
    let stored: Vec<Value> = page["events"].as_array().unwrap().clone();
    assert_eq!(stored.len(), numbers.len());
}
