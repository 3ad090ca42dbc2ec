//! Clients that send or take bytes slowly, or not at all, are let go, and delay no other client.

use std::time::{Duration, Instant};

use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::{TcpSocket, TcpStream};

use crate::harness::script::{Act, Script};
use crate::harness::server::Server;

async fn connect(server: &Server) -> TcpStream {
    TcpStream::connect(server.service.address).await.unwrap()
}

/// Everything until the server closes, and how long that took.
async fn until_closed(mut socket: TcpStream) -> (String, Duration) {
    let started = Instant::now();
    let mut answer = Vec::new();
    // A reset is an end as well.
    let _ = tokio::time::timeout(Duration::from_secs(15), socket.read_to_end(&mut answer))
        .await
        .expect("the server closes the connection");
    (String::from_utf8_lossy(&answer).into_owned(), started.elapsed())
}

/// Sends this and then nothing; the answer until the server closes, and how long that took.
pub async fn stall(server: &Server, sent: &str) -> (String, Duration) {
    let mut socket = connect(server).await;
    socket.write_all(sent.as_bytes()).await.unwrap();
    until_closed(socket).await
}

/// Asks for more than socket buffers hold, and reads nothing.
async fn non_reader(server: &Server) -> TcpStream {
    let socket = TcpSocket::new_v4().unwrap();
    socket.set_recv_buffer_size(4096).unwrap();
    let mut socket = socket.connect(server.service.address).await.unwrap();
    let requests = "GET /openapi.yaml HTTP/1.1\r\nhost: localhost\r\n\r\n".repeat(REQUESTS);
    socket.write_all(requests.as_bytes()).await.unwrap();
    socket
}

/// Requests of a client that does not read; their answers have megabytes.
const REQUESTS: usize = 200;

#[tokio::test]
async fn a_header_that_does_not_end_closes_the_connection() {
    let server = Server::with(&Script::new(&[]), &[("server.header_timeout_secs", "1")]).await;
    for sent in ["GET /healthz HTTP/1.1\r\nhost: localhost\r\nx-slow: ", "GET /heal", ""] {
        let (answer, took) = stall(&server, sent).await;
        assert!(!answer.contains("200 OK"), "{sent:?}: {answer}");
        assert!((900..8000).contains(&took.as_millis()), "{sent:?} took {took:?}");
    }
    assert_eq!(server.get("/healthz").await.status, 200);
}

#[tokio::test]
async fn the_wait_for_the_next_request_has_a_limit_of_its_own() {
    let request = "GET /healthz HTTP/1.1\r\nhost: localhost\r\n\r\n";
    let set = [("server.header_timeout_secs", "60"), ("server.keep_alive_timeout_secs", "1")];
    let server = Server::with(&Script::new(&[]), &set).await;
    let (answer, took) = stall(&server, request).await;
    assert!(answer.contains("200 OK"), "{answer}");
    assert!((900..8000).contains(&took.as_millis()), "{took:?}");
    server.stop().await;

    let set = [("server.header_timeout_secs", "1"), ("server.keep_alive_timeout_secs", "60")];
    let server = Server::with(&Script::new(&[]), &set).await;
    let mut socket = connect(&server).await;
    for _ in 0..2 {
        socket.write_all(request.as_bytes()).await.unwrap();
        let mut answer = [0; 4096];
        let length = socket.read(&mut answer).await.unwrap();
        assert!(String::from_utf8_lossy(&answer[..length]).contains("200 OK"));
        tokio::time::sleep(Duration::from_millis(1600)).await;
    }
    socket.write_all(b"GET /heal").await.unwrap();
    let (answer, _) = until_closed(socket).await;
    assert_eq!(answer, "", "the header of a later request has the header's limit");
}

#[tokio::test]
async fn a_body_that_does_not_end_is_refused() {
    let server = Server::with(&Script::new(&[]), &[("server.body_timeout_secs", "1")]).await;
    let sent = "POST /scenes HTTP/1.1\r\nhost: localhost\r\ncontent-type: application/json\r\n\
                content-length: 100\r\nconnection: close\r\n\r\n{\"text\":";
    let (answer, took) = stall(&server, sent).await;
    assert!(answer.contains("408") && answer.contains("body_too_slow"), "{answer}");
    assert!(took >= Duration::from_millis(900), "{took:?}");
    let retry = sent.replace("/scenes", "/jobs/j/retry");
    let (answer, _) = stall(&server, &retry).await;
    assert!(answer.contains("408") && answer.contains("body_too_slow"), "{answer}");
}

#[tokio::test]
async fn a_body_that_trickles_is_refused_before_its_time_is_over() {
    let set = [
        ("server.body_timeout_secs", "60"),
        ("server.rate_window_secs", "1"),
        ("server.min_rate_bytes_per_s", "1000"),
    ];
    let server = Server::with(&Script::new(&[]), &set).await;
    let mut socket = connect(&server).await;
    let head = "POST /scenes HTTP/1.1\r\nhost: localhost\r\ncontent-type: application/json\r\n\
                content-length: 100000\r\nconnection: close\r\n\r\n";
    socket.write_all(head.as_bytes()).await.unwrap();
    let started = Instant::now();
    let mut answer = vec![0; 4096];
    let length = loop {
        assert!(started.elapsed() < Duration::from_secs(20), "it is refused");
        let _ = socket.write_all(b" ").await;
        if let Ok(read) = tokio::time::timeout(Duration::from_millis(50), socket.read(&mut answer)).await {
            break read.unwrap();
        }
    };
    let answer = String::from_utf8_lossy(&answer[..length]).into_owned();
    assert!(answer.contains("408") && answer.contains("body_too_slow"), "{answer}");
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_client_that_does_not_read_is_closed() {
    let set = [("server.rate_window_secs", "1"), ("server.min_rate_bytes_per_s", "1000")];
    let server = Server::with(&Script::new(&[]), &set).await;
    let whole = server.get("/openapi.yaml").await.body.len() * REQUESTS;
    let idle = non_reader(&server).await;
    tokio::time::sleep(Duration::from_secs(3)).await;
    let (answer, _) = until_closed(idle).await;
    assert!(answer.len() < whole / 2, "{} of {whole} bytes came", answer.len());
    let metrics = server.get("/metrics").await;
    let metrics = String::from_utf8_lossy(&metrics.body).into_owned();
    assert!(metrics.contains("tabletopgen_connections_closed_total{reason=\"slow_reader\"}"), "{metrics}");
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn connections_that_wait_for_their_clients_give_way_to_honest_ones() {
    let set = [("server.max_connections", "4"), ("server.rate_window_secs", "60")];
    let server = Server::with(&Script::new(&[]), &set).await;
    let mut stalled = Vec::new();
    for kind in ["non-reader", "half header", "half body", "silent"] {
        let mut socket = match kind {
            "non-reader" => non_reader(&server).await,
            _ => connect(&server).await,
        };
        let sent = match kind {
            "half header" => "GET /healthz HTTP/1.1\r\nhost: ",
            "half body" => {
                "POST /scenes HTTP/1.1\r\nhost: localhost\r\ncontent-type: application/json\r\n\
                 content-length: 1000\r\n\r\n{"
            }
            _ => "",
        };
        socket.write_all(sent.as_bytes()).await.unwrap();
        stalled.push(socket);
    }
    tokio::time::sleep(Duration::from_millis(700)).await;
    for _ in 0..8 {
        let mut socket = connect(&server).await;
        let request = "GET /healthz HTTP/1.1\r\nhost: localhost\r\nconnection: close\r\n\r\n";
        socket.write_all(request.as_bytes()).await.unwrap();
        let (answer, _) = until_closed(socket).await;
        assert!(answer.starts_with("HTTP/1.1 200"), "{answer}");
    }
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn where_every_connection_is_at_work_a_new_one_learns_when_to_come_back() {
    let script = Script::new(&[("alpha", &[Act::Wait])]);
    let server = Server::with(&script, &[("server.max_connections", "1")]).await;
    let (_, job) = server.submit("a mug").await;
    let mut at_work = connect(&server).await;
    let request =
        format!("GET /jobs/{job}/events HTTP/1.1\r\nhost: localhost\r\naccept: text/event-stream\r\n\r\n");
    at_work.write_all(request.as_bytes()).await.unwrap();
    let mut answer = [0; 4096];
    let length = at_work.read(&mut answer).await.unwrap();
    assert!(answer[..length].starts_with(b"HTTP/1.1 200"), "{}", String::from_utf8_lossy(&answer[..length]));

    let (answer, _) = stall(&server, "GET /healthz HTTP/1.1\r\nhost: localhost\r\n\r\n").await;
    assert!(answer.starts_with("HTTP/1.1 503"), "{answer}");
    for part in ["retry-after: 1", "application/problem+json", "\"code\":\"overloaded\""] {
        assert!(answer.contains(part), "{answer}");
    }
    drop(at_work);
    tokio::time::sleep(Duration::from_millis(500)).await;
    assert_eq!(server.get("/healthz").await.status, 200);
    script.open_gate();
}

#[tokio::test]
async fn one_address_has_its_own_limit() {
    let set = [("server.max_connections", "100"), ("server.max_connections_per_address", "3")];
    let server = Server::with(&Script::new(&[]), &set).await;
    let mut held = Vec::new();
    for _ in 0..3 {
        held.push(connect(&server).await);
    }
    // They have just connected, so none of them gives way yet.
    let (answer, _) = stall(&server, "GET /healthz HTTP/1.1\r\nhost: localhost\r\n\r\n").await;
    assert!(answer.starts_with("HTTP/1.1 503") && answer.contains("too_many_connections"), "{answer}");
    let socket = TcpSocket::new_v4().unwrap();
    socket.bind("127.0.0.2:0".parse().unwrap()).unwrap();
    let mut other = socket.connect(server.service.address).await.unwrap();
    let request = "GET /healthz HTTP/1.1\r\nhost: localhost\r\nconnection: close\r\n\r\n";
    other.write_all(request.as_bytes()).await.unwrap();
    assert!(until_closed(other).await.0.starts_with("HTTP/1.1 200"));
}
