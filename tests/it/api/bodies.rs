//! Bodies: hostile JSON costs neither memory nor time, and all bodies in flight share one budget.

use std::time::Duration;

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use hyper::Method;
use serde_json::json;
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::TcpStream;

use crate::harness::script::Script;
use crate::harness::server::Server;

const JSON: [(&str, &str); 1] = [("content-type", "application/json")];

/// Peak of the resident memory of this process, which is the server's too.
fn resident_bytes() -> u64 {
    let status = std::fs::read_to_string("/proc/self/status").expect("is Linux");
    let line = status.lines().find(|line| line.starts_with("VmHWM")).expect("has a peak");
    line.split_whitespace().nth(1).and_then(|kilobytes| kilobytes.parse::<u64>().ok()).expect("a number")
        << 10
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn nested_and_endless_json_is_refused_without_being_built() {
    let server = Server::start(&Script::new(&[])).await;
    let size = 24 << 20;
    let pairs = |text: &str| text.repeat(size / text.len());
    let before = resident_bytes();
    for (body, code) in [
        (format!("{}{}", "[".repeat(size / 2), "]".repeat(size / 2)), "malformed_json"),
        (format!("[{}[]]", pairs("[],")), "malformed_json"),
        (format!("{{\"labels\": {{{}\"z\": 1}}}}", pairs("\"a\":{},")), "malformed_json"),
        (format!("{{\"options\": {{\"set\": [{}1]}}}}", pairs("1,")), "malformed_json"),
    ] {
        let reply = server.call(Method::POST, "/scenes", &JSON, body).await;
        assert_eq!(reply.problem(), (400, code.to_owned()), "{reply:?}");
    }
    // As values such a body took more than a hundred times its size. Other tests of this process may grow beside it.
    let grown = resident_bytes().saturating_sub(before);
    assert!(grown < 1 << 30, "{grown} bytes");
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn requests_are_answered_while_a_large_body_is_parsed() {
    let server = Server::start(&Script::new(&[])).await;
    let text = format!("{{\"image\": {{\"base64\": \"{}\"}}}}", "\\u0041".repeat(4 << 20));
    let parsed = server.call(Method::POST, "/scenes", &JSON, text);
    let probes = async {
        for _ in 0..20 {
            assert_eq!(server.get("/healthz").await.status, 200);
        }
    };
    let (reply, ()) = tokio::join!(parsed, probes);
    assert_eq!(reply.status, 415, "{reply:?}");
}

#[tokio::test]
async fn repeated_and_deep_fields_are_named() {
    let server = Server::start(&Script::new(&[])).await;
    let repeated = server.call(Method::POST, "/scenes", &JSON, r#"{"text": "a", "text": "b"}"#).await;
    assert_eq!(repeated.problem(), (422, "invalid_body".into()), "{repeated:?}");
    let not_base64 = server.post("/scenes", json!({ "image": { "base64": "%%%" } })).await;
    assert_eq!(not_base64.json()["errors"][0]["pointer"], "/image/base64");
    // Encoders may escape slashes, and wrap lines.
    let image = STANDARD.encode(b"\xff\xff\xff no image at all");
    let escaped = format!(r#"{{"image": {{"base64": "{}\r\n"}}}}"#, image.replace('/', "\\/"));
    let reply = server.call(Method::POST, "/scenes", &JSON, escaped).await;
    assert_eq!(reply.problem(), (415, "image_format".into()), "{reply:?}");
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn stalled_uploads_hold_their_bytes_alone_and_large_ones_are_shed() {
    let set = [
        ("server.max_body_bytes", "200000"),
        ("server.max_image_bytes", "100000"),
        ("server.body_memory_bytes", "470000"),
        ("server.rate_window_secs", "60"),
    ];
    let server = Server::with(&Script::new(&[]), &set).await;
    let head = "POST /scenes HTTP/1.1\r\nhost: localhost\r\ncontent-type: application/json\r\n\
                content-length: 190000\r\n\r\n{\"text\": \"";
    let mut stalled = Vec::new();
    for _ in 0..50 {
        let mut socket = TcpStream::connect(server.service.address).await.unwrap();
        socket.write_all(head.as_bytes()).await.unwrap();
        stalled.push(socket);
    }
    let large = || {
        let body = json!({ "text": "x".repeat(80_000) }).to_string();
        server.call(Method::POST, "/scenes", &JSON, body)
    };
    tokio::time::sleep(Duration::from_millis(300)).await;
    assert_eq!(large().await.problem(), (422, "invalid_body".into()), "promised bytes take no memory");
    // Now two of them send, and 80,000 bytes more have no room.
    for socket in &mut stalled[..2] {
        socket.write_all(&vec![b'x'; 100_000]).await.unwrap();
    }
    tokio::time::sleep(Duration::from_millis(500)).await;
    let shed = large().await;
    assert_eq!(shed.problem(), (503, "overloaded".into()), "{shed:?}");
    assert!(!shed.header("retry-after").is_empty());
    assert_eq!(server.post("/scenes/validate", json!({ "text": "a mug" })).await.status, 200);
    drop(stalled);
    tokio::time::sleep(Duration::from_millis(500)).await;
    assert_eq!(large().await.problem(), (422, "invalid_body".into()), "memory is given back");
}

#[tokio::test]
async fn a_client_that_reads_after_it_has_sent_learns_why_it_is_refused() {
    let server = Server::with(
        &Script::new(&[]),
        &[("server.max_body_bytes", "100000"), ("server.max_image_bytes", "1024")],
    )
    .await;
    let mut socket = TcpStream::connect(server.service.address).await.unwrap();
    let body = vec![b' '; 3_000_000];
    let head = format!(
        "POST /scenes HTTP/1.1\r\nhost: localhost\r\ncontent-type: application/json\r\nconnection: close\r\n\
         content-length: {}\r\n\r\n",
        body.len()
    );
    socket.write_all(head.as_bytes()).await.unwrap();
    socket.write_all(&body).await.expect("everything can be sent");
    let mut answer = String::new();
    socket.read_to_string(&mut answer).await.expect("the answer comes");
    assert!(answer.starts_with("HTTP/1.1 413") && answer.contains("body_too_large"), "{answer}");
}
