//! Clients that may ask: hosts of this server, no pages of other sites, and no client beyond this machine unless the
//! operator allows it.

use hyper::Method;
use tabletopgen::app::{App, AppError};
use tabletopgen::service;
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::TcpStream;

use crate::harness::script::Script;
use crate::harness::server::{Server, settings};

/// The answer to exactly these bytes.
async fn raw(server: &Server, request: &str) -> String {
    let mut socket = TcpStream::connect(server.service.address).await.unwrap();
    socket.write_all(request.as_bytes()).await.unwrap();
    let mut answer = Vec::new();
    socket.read_to_end(&mut answer).await.unwrap();
    String::from_utf8_lossy(&answer).into_owned()
}

#[tokio::test]
async fn a_request_names_a_host_of_this_server() {
    let set = [("server.allowed_hosts", "scenes.example.org")];
    let server = Server::with(&Script::new(&[]), &set).await;
    for (line, status) in [
        ("host: localhost", 200),
        ("host: 127.0.0.1:1", 200),
        ("host: scenes.example.org", 200),
        ("host: rebound.example", 421),
        ("x: y", 400),
        ("host: localhost\r\nhost: localhost", 400),
        ("host: a b", 400),
    ] {
        let answer =
            raw(&server, &format!("GET /healthz HTTP/1.1\r\n{line}\r\nconnection: close\r\n\r\n")).await;
        assert!(answer.starts_with(&format!("HTTP/1.1 {status}")), "{line:?}: {answer}");
        assert!(status == 200 || answer.contains("application/problem+json"), "{answer}");
    }
    let absolute =
        "GET http://rebound.example/healthz HTTP/1.1\r\nhost: localhost\r\nconnection: close\r\n\r\n";
    assert!(raw(&server, absolute).await.starts_with("HTTP/1.1 421"));
    let old = raw(&server, "GET /healthz HTTP/1.0\r\n\r\n").await;
    assert!(old.starts_with("HTTP/1.0 200"), "{old}");
}

#[tokio::test]
async fn pages_of_allowed_origins_submit_and_read() {
    const ALLOWED: &str = "https://app.example.org";
    let set = [("server.allowed_origins", "http://localhost:3000 https://app.example.org")];
    let server = Server::with(&Script::new(&[]), &set).await;
    let preflight = |origin: &str| {
        format!(
            "OPTIONS /scenes HTTP/1.1\r\nhost: localhost\r\norigin: {origin}\r\naccess-control-request-method: POST\r\n\
             access-control-request-headers: authorization,content-type\r\nconnection: close\r\n\r\n"
        )
    };
    let granted = raw(&server, &preflight(ALLOWED)).await;
    assert!(granted.starts_with("HTTP/1.1 200"), "{granted}");
    assert!(granted.contains(&format!("access-control-allow-origin: {ALLOWED}\r\n")), "{granted}");
    assert!(!granted.contains("access-control-allow-credentials"), "{granted}");
    let denied = raw(&server, &preflight("https://evil.example")).await;
    assert!(!denied.contains("access-control-allow-origin"), "{denied}");
    let page = [("content-type", "application/json"), ("origin", ALLOWED), ("sec-fetch-site", "cross-site")];
    // A page must be able to read refusals, too.
    for (body, status) in [(r#"{"text":"a mug"}"#, 202), ("{}", 422)] {
        let answer = server.call(Method::POST, "/scenes", &page, body).await;
        assert_eq!(answer.status, status, "{body}");
        assert_eq!(answer.header("access-control-allow-origin"), ALLOWED);
    }
    let twice = [("origin", ALLOWED), ("origin", "https://evil.example")];
    for fields in [&[("origin", "https://evil.example")][..], &twice] {
        let refused = server.call(Method::GET, "/scenes", fields, "").await;
        assert_eq!(refused.problem(), (403, "cross_site_request".into()), "{fields:?}");
    }
}

#[tokio::test]
async fn pages_of_other_sites_change_nothing() {
    let server = Server::start(&Script::new(&[])).await;
    let body = r#"{"text":"a mug"}"#;
    for foreign in [("sec-fetch-site", "cross-site"), ("origin", "https://evil.example"), ("origin", "null")]
    {
        let headers = [("content-type", "application/json"), foreign];
        let refused = server.call(Method::POST, "/scenes", &headers, body).await;
        assert_eq!(refused.problem(), (403, "cross_site_request".into()), "{foreign:?}");
    }
    assert_eq!(server.get("/scenes").await.json()["scenes"], serde_json::json!([]));
    let own = format!("http://{}", server.service.address);
    for own in [("sec-fetch-site", "same-origin"), ("origin", own.as_str())] {
        let headers = [("content-type", "application/json"), own];
        assert_eq!(server.call(Method::POST, "/scenes", &headers, body).await.status, 202, "{own:?}");
    }
}

#[tokio::test]
async fn an_address_beyond_loopback_needs_leave() {
    let directory = tempfile::tempdir().unwrap();
    let script = Script::new(&[]);
    for listen in ["0.0.0.0:0", "[::]:0"] {
        let refused = service::start(
            &App::new(&settings(&[("server.listen", listen)])),
            directory.path(),
            script.build(),
        )
        .await;
        let error = refused.err().expect("is refused");
        assert!(matches!(error, AppError::OpenToOthers { .. }), "{error}");
        let message = error.chain();
        assert!(message.contains(listen) && message.contains("--allow-unauthenticated"), "{message}");
        assert!(message.contains("keys create"), "{message}");
    }
    let keys = [("server.listen", "0.0.0.0:0"), ("server.authentication.mode", "keys")];
    let server = Server::with(&script, &keys).await;
    drop(server);
    let set = [("server.listen", "0.0.0.0:0"), ("server.allow_unauthenticated", "true")];
    let server = Server::with(&script, &set).await;
    let port = server.service.address.port();
    let mut socket = TcpStream::connect(("127.0.0.1", port)).await.unwrap();
    let request = "GET /healthz HTTP/1.1\r\nhost: localhost\r\nconnection: close\r\n\r\n";
    socket.write_all(request.as_bytes()).await.unwrap();
    let mut answer = String::new();
    socket.read_to_string(&mut answer).await.unwrap();
    assert!(answer.starts_with("HTTP/1.1 200"), "{answer}");
}
