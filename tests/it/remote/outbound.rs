//! The one client for everything outbound: where it goes, what it carries along, how much it takes.

use std::sync::{Arc, Mutex};
use std::time::Duration;

use axum::Router;
use axum::extract::{Request, State};
use axum::http::StatusCode;
use axum::response::{IntoResponse, Redirect, Response};
use bytes::Bytes;
use http_client::{AddressError, AddressPolicy, HttpClient, HttpRequest, Secret, SendError};
use reqwest::Method;
use tokio::net::TcpListener;

/// Requests as `path authorization`, in order.
type RecordedRequests = Arc<Mutex<Vec<String>>>;

/// A server that redirects `/to/<url>` there, and answers everything else.
async fn server() -> (u16, RecordedRequests) {
    let listener = TcpListener::bind("127.0.0.1:0").await.unwrap();
    let port = listener.local_addr().unwrap().port();
    let seen = RecordedRequests::default();
    let router = Router::new().fallback(answer).with_state(seen.clone());
    tokio::spawn(async move { axum::serve(listener, router).await.unwrap() });
    (port, seen)
}

async fn answer(State(seen): State<RecordedRequests>, request: Request) -> Response {
    let path = request.uri().path().to_owned();
    let key = request.headers().get("authorization").map_or("-", |value| value.to_str().unwrap());
    seen.lock().unwrap().push(format!("{path} {key}"));
    match path.split_once("/to/") {
        Some((_, "loop")) => Redirect::temporary("/to/loop").into_response(),
        Some((_, "nowhere")) => StatusCode::FOUND.into_response(),
        Some((_, target)) => Redirect::temporary(target).into_response(),
        None if path == "/large" => vec![0_u8; 100_000].into_response(),
        None => "fine".into_response(),
    }
}

fn get(url: String) -> HttpRequest {
    HttpRequest {
        method: Method::GET,
        url,
        headers: vec![("x-kind".into(), "test".into())],
        transient_headers: Vec::new(),
        bearer: Secret::new("sk-1"),
        content_type: "application/json".into(),
        body: Bytes::new(),
    }
}

fn client(private_hosts: &str) -> HttpClient {
    HttpClient::new(AddressPolicy::new(true, private_hosts), Duration::from_secs(5)).unwrap()
}

async fn sent(client: &HttpClient, outgoing: &HttpRequest) -> Result<Bytes, SendError> {
    let sent = tokio::time::timeout(Duration::from_secs(30), client.send(outgoing, 50_000));
    sent.await.expect("nothing hangs").map(|reply| reply.body)
}

#[tokio::test]
async fn this_machine_is_not_talked_to_unless_the_operator_says_so() {
    let (port, seen) = server().await;
    let strict = client("");
    for host in ["127.0.0.1", "localhost", "[::ffff:127.0.0.1]", "0.0.0.0", "2130706433"] {
        let refused = sent(&strict, &get(format!("http://{host}:{port}/"))).await.unwrap_err();
        assert!(matches!(refused, SendError::Address(AddressError::Private { .. })), "{host}: {refused:?}");
    }
    assert!(seen.lock().unwrap().is_empty(), "nobody was talked to");
    let here = client(&format!("127.0.0.1:{port}"));
    assert_eq!(sent(&here, &get(format!("http://127.0.0.1:{port}/"))).await.unwrap(), "fine");
    // A name is another host than its address.
    assert!(sent(&here, &get(format!("http://localhost:{port}/"))).await.is_err());
    let named = client("localhost");
    assert_eq!(sent(&named, &get(format!("http://localhost:{port}/"))).await.unwrap(), "fine");
}

#[tokio::test]
async fn redirects_are_checked_like_first_addresses() {
    let (port, seen) = server().await;
    let (other, elsewhere) = server().await;
    let here = client(&format!("127.0.0.1:{port}"));
    let through = |target: String| get(format!("http://127.0.0.1:{port}/to/{target}"));
    let refused = sent(&here, &through(format!("http://127.0.0.1:{other}/"))).await.unwrap_err();
    assert!(matches!(refused, SendError::Address(AddressError::Private { .. })), "{refused:?}");
    let refused = sent(&here, &through("http://169.254.169.254/latest".into())).await.unwrap_err();
    assert!(matches!(refused, SendError::Address(AddressError::Private { .. })), "{refused:?}");
    assert!(elsewhere.lock().unwrap().is_empty());
    for endless in ["loop", "nowhere"] {
        let refused = sent(&here, &through(endless.into())).await.unwrap_err();
        assert!(matches!(refused, SendError::Redirected(_)), "{refused:?}");
    }
    seen.lock().unwrap().clear();

    let both = client("127.0.0.1");
    assert_eq!(sent(&both, &through("/file".into())).await.unwrap(), "fine");
    assert_eq!(sent(&both, &through(format!("http://127.0.0.1:{other}/file"))).await.unwrap(), "fine");
    let paths = seen.lock().unwrap().clone();
    assert_eq!(paths[..2], ["/to//file Bearer sk-1", "/file Bearer sk-1"], "the same origin");
    assert_eq!(*elsewhere.lock().unwrap(), ["/file -"], "another origin learns no key");
}

#[tokio::test]
async fn a_body_goes_where_it_was_sent_and_nowhere_else() {
    let (port, seen) = server().await;
    let mut post = get(format!("http://127.0.0.1:{port}/to//file"));
    post.method = Method::POST;
    post.body = Bytes::from_static(b"{}");
    let refused = sent(&client("127.0.0.1"), &post).await.unwrap_err();
    assert!(matches!(refused, SendError::Redirected(_)), "{refused:?}");
    assert_eq!(seen.lock().unwrap().len(), 1);
}

#[tokio::test]
async fn too_much_is_not_read_and_plain_http_needs_leave() {
    let (port, _) = server().await;
    let url = format!("http://127.0.0.1:{port}/large");
    let refused = sent(&client("127.0.0.1"), &get(url.clone())).await.unwrap_err();
    assert!(matches!(refused, SendError::TooLarge { limit: 50_000 }), "{refused:?}");
    let cut = client("127.0.0.1").send_and_cut(&get(url.clone()), 50_000).await.unwrap();
    assert_eq!((cut.status, cut.body.len()), (200, 50_000));
    let strict = HttpClient::new(AddressPolicy::new(false, "127.0.0.1"), Duration::from_secs(5)).unwrap();
    let refused = sent(&strict, &get(url)).await.unwrap_err();
    assert!(matches!(refused, SendError::Address(AddressError::NotHttps(_))), "{refused:?}");
}
