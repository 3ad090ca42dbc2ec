//! Clients that send slowly, or nothing, are let go.

use std::time::{Duration, Instant};

use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::TcpStream;

use crate::harness::script::Script;
use crate::harness::server::Server;

/// Sends this and then nothing; the answer until the server closes, and how long that took.
async fn stall(server: &Server, sent: &str) -> (String, Duration) {
    let mut socket = TcpStream::connect(server.service.address).await.unwrap();
    socket.write_all(sent.as_bytes()).await.unwrap();
    let started = Instant::now();
    let mut answer = Vec::new();
    tokio::time::timeout(Duration::from_secs(15), socket.read_to_end(&mut answer))
        .await
        .expect("the server closes the connection")
        .unwrap();
    (String::from_utf8_lossy(&answer).into_owned(), started.elapsed())
}

#[tokio::test]
async fn a_header_that_does_not_end_closes_the_connection() {
    let server = Server::with(&Script::new(&[]), &[("server.header_timeout_secs", "1")]).await;
    for sent in ["GET /healthz HTTP/1.1\r\nhost: x\r\nx-slow: ", "GET /heal", ""] {
        let (answer, took) = stall(&server, sent).await;
        assert!(!answer.contains("200 OK"), "{sent:?}: {answer}");
        assert!((900..5000).contains(&took.as_millis()), "{sent:?} took {took:?}");
    }
    assert_eq!(server.get("/healthz").await.status, 200);
}

#[tokio::test]
async fn a_body_that_does_not_end_is_refused() {
    let server = Server::with(&Script::new(&[]), &[("server.body_timeout_secs", "1")]).await;
    let sent = "POST /scenes HTTP/1.1\r\nhost: x\r\ncontent-type: application/json\r\n\
                content-length: 100\r\nconnection: close\r\n\r\n{\"text\":";
    let (answer, took) = stall(&server, sent).await;
    assert!(answer.contains("408") && answer.contains("body_too_slow"), "{answer}");
    assert!(took >= Duration::from_millis(900), "{took:?}");
}

#[tokio::test]
async fn more_connections_than_slots_wait_their_turn() {
    let set = [("server.max_connections", "2"), ("server.header_timeout_secs", "1")];
    let server = Server::with(&Script::new(&[]), &set).await;
    let mut idle = Vec::new();
    for _ in 0..4 {
        idle.push(TcpStream::connect(server.service.address).await.unwrap());
    }
    // The idle ones time out two by two, and then it is this one's turn.
    let reply = tokio::time::timeout(Duration::from_secs(15), server.get("/healthz")).await;
    assert_eq!(reply.expect("is answered").status, 200);
}
