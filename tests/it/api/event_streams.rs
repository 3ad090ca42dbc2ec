//! Event streams are limited in number and age, and nothing is lost when one ends.

use std::time::Duration;

use hyper::Method;
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::TcpStream;

use crate::harness::script::{Act, Script};
use crate::harness::server::Server;

/// An event stream of a job, after its header.
async fn stream(server: &Server, job: &str, last: Option<i64>) -> (String, TcpStream) {
    let mut socket = TcpStream::connect(server.service.address).await.unwrap();
    let last = last.map_or(String::new(), |id| format!("last-event-id: {id}\r\n"));
    let request = format!(
        "GET /jobs/{job}/events HTTP/1.1\r\nhost: localhost\r\naccept: text/event-stream\r\n{last}\r\n"
    );
    socket.write_all(request.as_bytes()).await.unwrap();
    let mut start = vec![0; 4096];
    let length = socket.read(&mut start).await.unwrap();
    (String::from_utf8_lossy(&start[..length]).into_owned(), socket)
}

async fn rest(mut socket: TcpStream) -> String {
    let mut rest = Vec::new();
    tokio::time::timeout(Duration::from_secs(20), socket.read_to_end(&mut rest))
        .await
        .expect("the stream ends")
        .unwrap();
    String::from_utf8_lossy(&rest).into_owned()
}

/// Ids of the events of a text of a stream.
fn ids(text: &str) -> Vec<i64> {
    text.lines().filter_map(|line| line.strip_prefix("id: ")?.trim().parse().ok()).collect()
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn an_old_stream_says_goodbye_and_goes_on_after_a_reconnect() {
    let script = Script::new(&[("omega", &[Act::Wait])]);
    let server = Server::with(&script, &[("server.max_event_stream_secs", "2")]).await;
    let (_, job) = server.submit("a mug").await;
    script.reaches("omega").await;
    let (start, socket) = stream(&server, &job, None).await;
    let first = start + &rest(socket).await;
    let seen = ids(&first);
    assert_eq!(seen, (1..=seen.len() as i64).collect::<Vec<_>>());
    let last = seen.last().copied().unwrap();
    assert!(first.contains(&format!("reconnect with Last-Event-ID: {last}")), "{first}");
    script.open_gate();
    let (start, socket) = stream(&server, &job, Some(last)).await;
    let second = start + &rest(socket).await;
    assert_eq!(ids(&second).first(), Some(&(last + 1)), "{second}");
    assert!(second.contains("event: job_succeeded") && !second.contains("reconnect"), "{second}");
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn streams_of_one_address_are_limited_and_requests_are_still_answered() {
    let script = Script::new(&[("alpha", &[Act::Wait])]);
    let set = [("server.max_event_streams", "10"), ("server.max_event_streams_per_address", "5")];
    let server = Server::with(&script, &set).await;
    let (scene, job) = server.submit("a mug").await;
    let mut open = Vec::new();
    for _ in 0..5 {
        let (start, socket) = stream(&server, &job, None).await;
        assert!(start.starts_with("HTTP/1.1 200"), "{start}");
        open.push(socket);
    }
    let headers = [("accept", "text/event-stream")];
    let path = format!("/jobs/{job}/events");
    let refused = server.call(Method::GET, &path, &headers, "").await;
    assert_eq!(refused.problem(), (429, "too_many_streams".into()), "{refused:?}");
    assert!(!refused.header("retry-after").is_empty());
    assert_eq!(server.get(&path).await.status, 200, "pages are no streams");
    assert_eq!(server.get(&format!("/scenes/{scene}")).await.status, 200);
    open.pop();
    tokio::time::sleep(Duration::from_millis(300)).await;
    let (start, _socket) = stream(&server, &job, None).await;
    assert!(start.starts_with("HTTP/1.1 200"), "{start}");
    script.open_gate();
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn every_one_of_many_streams_gets_every_event() {
    let script = Script::new(&[("alpha", &[Act::Wait])]);
    let server = Server::start(&script).await;
    let (_, job) = server.submit("a mug").await;
    let mut open = Vec::new();
    for _ in 0..40 {
        open.push(stream(&server, &job, None).await);
    }
    script.open_gate();
    server.job_is(&job, "succeeded").await;
    let count = server.kinds(&job).await.len() as i64;
    for (start, socket) in open {
        assert_eq!(ids(&(start + &rest(socket).await)), (1..=count).collect::<Vec<_>>());
    }
}
