//! Webhooks through the interface, and what receivers of all kinds get: signed messages, every one of them, and nothing
//! from inside.

use std::collections::VecDeque;
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use axum::Router;
use axum::body::Body;
use axum::extract::{Request, State};
use axum::http::HeaderMap;
use axum::response::Response;
use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use bytes::Bytes;
use futures::stream;
use http_client::hmac::hmac_sha256;
use hyper::Method;
use serde_json::{Value, json};
use tokio::net::TcpListener;

use crate::harness::script::Script;
use crate::harness::server::{Reply, Server};

/// Answer of a receiver to one request; the usual one is 204.
#[derive(Clone, Debug)]
enum Answer {
    Status(u16),
    /// None, for longer than anybody waits.
    Silence,
    Redirect(String),
    /// 200, and more bytes than anybody reads.
    Endless,
}

/// A receiver, and what it got.
#[derive(Clone, Default)]
struct Receiver {
    answers: Arc<Mutex<VecDeque<Answer>>>,
    /// Headers and body of each request.
    got: Arc<Mutex<Vec<(HeaderMap, Bytes)>>>,
    address: String,
}

impl Receiver {
    async fn start(answers: &[Answer]) -> Self {
        let listener = TcpListener::bind("127.0.0.1:0").await.unwrap();
        let address = listener.local_addr().unwrap().to_string();
        let answers = Arc::new(Mutex::new(answers.iter().cloned().collect()));
        let receiver = Self { answers, address, ..Self::default() };
        let router = Router::new().fallback(answer).with_state(receiver.clone());
        tokio::spawn(async move { axum::serve(listener, router).await.unwrap() });
        receiver
    }

    fn url(&self) -> String {
        format!("http://{}/hook?a=b", self.address)
    }

    fn got(&self) -> Vec<(HeaderMap, Bytes)> {
        self.got.lock().unwrap().clone()
    }
}

async fn answer(State(receiver): State<Receiver>, request: Request) -> Response {
    let (parts, body) = request.into_parts();
    let body = axum::body::to_bytes(body, 1 << 20).await.unwrap();
    receiver.got.lock().unwrap().push((parts.headers, body));
    let next = receiver.answers.lock().unwrap().pop_front().unwrap_or(Answer::Status(204));
    match next {
        Answer::Status(status) => Response::builder().status(status).body(Body::empty()).unwrap(),
        Answer::Silence => std::future::pending().await,
        Answer::Redirect(url) => {
            Response::builder().status(307).header("location", url).body(Body::empty()).unwrap()
        }
        Answer::Endless => {
            let piece = || Ok::<_, std::io::Error>(Bytes::from(vec![b'x'; 1 << 16]));
            Response::new(Body::from_stream(stream::repeat_with(piece)))
        }
    }
}

/// A server that sends quickly to these receivers.
async fn server(script: &Arc<Script>, receivers: &[&Receiver], set: &[(&str, &str)]) -> Server {
    let hosts: Vec<&str> = receivers.iter().map(|receiver| receiver.address.as_str()).collect();
    let hosts = hosts.join(" ");
    let quick = [
        ("webhooks.hosts", hosts.as_str()),
        ("webhooks.timeout_secs", "1"),
        ("webhooks.retry_secs", "0.02, 0.02, 0.02, 0.02, 0.02, 0.02"),
    ];
    Server::with(script, &[&quick[..], set].concat()).await
}

async fn created(server: &Server, body: Value) -> Value {
    let reply = server.post("/webhooks", body).await;
    assert_eq!(reply.status, 201, "{reply:?}");
    reply.json()
}

fn path(webhook: &Value) -> String {
    format!("/webhooks/{}", webhook["id"].as_str().unwrap())
}

async fn patch(server: &Server, path: &str, headers: &[(&str, &str)], body: Value) -> Reply {
    let headers = [&[("content-type", "application/merge-patch+json")], headers].concat();
    server.call(Method::PATCH, path, &headers, body.to_string()).await
}

/// Deliveries of a webhook, newest first, once so many are in a state.
async fn deliveries(server: &Server, webhook: &Value, state: &str, count: usize) -> Vec<Value> {
    let path = format!("{}/deliveries?state={state}", path(webhook));
    let reached = async {
        loop {
            let page = server.get(&path).await.json();
            let rows = page["deliveries"].as_array().unwrap().clone();
            if rows.len() >= count {
                return rows;
            }
            tokio::time::sleep(Duration::from_millis(20)).await;
        }
    };
    let reached = tokio::time::timeout(Duration::from_secs(20), reached).await;
    match reached {
        Ok(rows) => rows,
        Err(_) => panic!(
            "not {count} are {state}: {}",
            server.get(&format!("{}/deliveries", self::path(webhook))).await.json()
        ),
    }
}

/// Whether one of the signatures of a message is that of a secret.
fn is_signed(secret: &Value, (headers, body): &(HeaderMap, Bytes)) -> bool {
    let header = |name: &str| headers[name].to_str().unwrap();
    let key = STANDARD.decode(secret.as_str().unwrap().strip_prefix("whsec_").unwrap()).unwrap();
    let text = std::str::from_utf8(body).unwrap();
    let signed = format!("{}.{}.{text}", header("webhook-id"), header("webhook-timestamp"));
    let expected = format!("v1,{}", STANDARD.encode(hmac_sha256(&key, signed.as_bytes())));
    let age = jiff::Timestamp::now().as_second() - header("webhook-timestamp").parse::<i64>().unwrap();
    (0..60).contains(&age) && header("webhook-signature").split(' ').any(|one| one == expected)
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn every_event_arrives_when_a_faulty_receiver_recovers_and_nothing_inside_is_reached() {
    let inside = Receiver::start(&[]).await;
    let faulty = Receiver::start(&[
        Answer::Status(500),
        Answer::Silence,
        Answer::Redirect(inside.url()),
        Answer::Redirect("https://169.254.169.254/".into()),
        Answer::Status(429),
        Answer::Endless,
    ])
    .await;
    let good = Receiver::start(&[]).await;
    let script = Script::new(&[]);
    let server = server(&script, &[&faulty, &good], &[]).await;
    let webhook = created(&server, json!({ "url": faulty.url() })).await;
    let beside = created(&server, json!({ "url": good.url(), "events": ["scene.succeeded"] })).await;
    let (scene, job) = server.submit("a mug").await;
    server.job_is(&job, "succeeded").await;
    // The one that hangs holds up no other.
    let began = Instant::now();
    deliveries(&server, &beside, "delivered", 1).await;
    assert!(began.elapsed() < Duration::from_secs(10));
    let delivered = deliveries(&server, &webhook, "delivered", 1).await.remove(0);
    assert_eq!((&delivered["attempts"], &delivered["last_attempt"]["status"]), (&json!(6), &json!(200)));
    assert_eq!(delivered["last_attempt"]["error"], Value::Null);
    assert_eq!(delivered["next_attempt_at"], Value::Null);
    let got = faulty.got();
    assert_eq!(got.len(), 6);
    for message in &got {
        assert!(is_signed(&webhook["secret"], message) && !is_signed(&beside["secret"], message));
        assert_eq!((&message.0["webhook-id"], &message.1), (&got[0].0["webhook-id"], &got[0].1));
        assert_eq!(message.0["content-type"], "application/json");
    }
    assert_eq!(got[0].0["webhook-id"], delivered["id"].as_str().unwrap());
    let message: Value = serde_json::from_slice(&got[0].1).unwrap();
    assert_eq!(message, delivered["message"]);
    assert_eq!(message["type"], "scene.succeeded");
    let data = json!({
        "id": scene, "state": "succeeded", "failure_code": null, "job_id": job, "path": format!("/scenes/{scene}"),
    });
    assert_eq!(message["data"], data);
    assert_eq!(good.got().len(), 1);
    assert_ne!(good.got()[0].0["webhook-id"], got[0].0["webhook-id"]);

    for _ in 0..3 {
        server.submit("a cup").await;
    }
    deliveries(&server, &webhook, "delivered", 4).await;
    assert_eq!(faulty.got().len(), 9, "each of the others arrives once");
    assert_eq!(inside.got().len(), 0);
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn addresses_inside_are_refused_when_they_are_stated_and_when_they_turn_out_so() {
    let inside = Receiver::start(&[]).await;
    let port = inside.address.rsplit(':').next().unwrap();
    let script = Script::new(&[]);
    let server = server(&script, &[], &[("webhooks.retry_secs", "0.02")]).await;
    for url in [
        inside.url(),
        format!("https://{}/", inside.address),
        format!("https://[::ffff:127.0.0.1]:{port}/"),
        "https://169.254.169.254/latest".to_owned(),
        "http://example.org/".to_owned(),
        "https://me:secret@example.org/".to_owned(),
        "ftp://example.org/".to_owned(),
        String::new(),
        format!("https://example.org/{}", "a".repeat(2000)),
    ] {
        let refused = server.post("/webhooks", json!({ "url": url })).await;
        assert_eq!(refused.problem(), (422, "invalid_body".into()), "{url}");
        assert_eq!(refused.json()["errors"][0]["pointer"], "/url", "{url}");
        assert!(!refused.json().to_string().contains("me:secret"), "{refused:?}");
    }
    // A name says what it is when it is resolved.
    let webhook = created(&server, json!({ "url": format!("https://localhost:{port}/") })).await;
    assert_eq!(patch(&server, &path(&webhook), &[], json!({ "url": inside.url() })).await.status, 422);
    assert_eq!(server.post(&format!("{}/test", path(&webhook)), json!({})).await.status, 202);
    let failed = deliveries(&server, &webhook, "failed", 1).await.remove(0);
    assert_eq!((&failed["attempts"], &failed["last_attempt"]["status"]), (&json!(2), &Value::Null));
    let error = failed["last_attempt"]["error"].as_str().unwrap();
    assert!(error.contains("private address") && !error.contains("127.0.0.1"), "{error}");
    assert_eq!(inside.got().len(), 0);
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_receiver_that_never_accepts_gets_a_bounded_number_of_attempts() {
    let receiver = Receiver::start(&vec![Answer::Status(500); 99]).await;
    let script = Script::new(&[]);
    let set = [("webhooks.retry_secs", "0.02, 0.02"), ("webhooks.max_failures", "2")];
    let server = server(&script, &[&receiver], &set).await;
    let webhook = created(&server, json!({ "url": receiver.url() })).await;
    for _ in 0..2 {
        let (_, job) = server.submit("a mug").await;
        server.job_is(&job, "succeeded").await;
    }
    deliveries(&server, &webhook, "failed", 2).await;
    assert_eq!(receiver.got().len(), 6);
    let disabled = server.get(&path(&webhook)).await.json();
    let reason = disabled["disabled_reason"].as_str().unwrap();
    assert!(disabled["state"] == "disabled" && reason.contains("answered 500"), "{disabled}");
    let refused = server.post(&format!("{}/test", path(&webhook)), json!({})).await;
    assert_eq!(refused.problem(), (409, "webhook_disabled".into()));
    server.submit("a mug").await;
    tokio::time::sleep(Duration::from_millis(200)).await;
    assert_eq!(receiver.got().len(), 6, "a disabled webhook gets nothing");
    let metrics = server.get("/metrics").await;
    let metrics = String::from_utf8_lossy(&metrics.body).into_owned();
    assert!(metrics.contains(r#"tabletopgen_webhook_attempts_total{outcome="failed"}"#), "{metrics}");
    assert!(metrics.contains("tabletopgen_webhook_deliveries_waiting 0"), "{metrics}");

    // Enabled again; 410 disables it at once.
    *receiver.answers.lock().unwrap() = VecDeque::from([Answer::Status(410)]);
    assert_eq!(patch(&server, &path(&webhook), &[], json!({ "state": "enabled" })).await.status, 200);
    assert_eq!(server.post(&format!("{}/test", path(&webhook)), json!({})).await.status, 202);
    deliveries(&server, &webhook, "failed", 3).await;
    let gone = server.get(&path(&webhook)).await.json();
    assert!(gone["disabled_reason"].as_str().unwrap().contains("410"), "{gone}");
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn messages_outlive_the_process_and_are_replayed_on_request() {
    let receiver = Receiver::start(&[Answer::Silence]).await;
    let script = Script::new(&[]);
    let slow = [("webhooks.timeout_secs", "300")];
    let first = server(&script, &[&receiver], &slow).await;
    let webhook = created(&first, json!({ "url": receiver.url() })).await;
    let (_, job) = first.submit("a mug").await;
    first.job_is(&job, "succeeded").await;
    while receiver.got().is_empty() {
        tokio::time::sleep(Duration::from_millis(10)).await;
    }
    let directory = first.stop().await;
    // The process died during an attempt; another one waits until it may be sure of that.
    let store = crate::harness::server::opened(directory.path()).await;
    let none = store.claim_deliveries(Duration::from_secs(1), 9).await.unwrap();
    assert!(none.is_empty());
    drop(store);
    crate::harness::server::wait_until_unlocked(directory.path()).await;
    expire_leases(directory.path()).await;
    let set = [("webhooks.hosts", receiver.address.as_str())];
    let second = Server::on(directory, &script, &set).await;
    let delivered = deliveries(&second, &webhook, "delivered", 1).await.remove(0);
    assert_eq!(delivered["attempts"], 2);
    let replay = format!("{}/deliveries/{}/replay", path(&webhook), delivered["id"].as_str().unwrap());
    let again = second.post(&replay, json!({})).await;
    assert_eq!((again.status.as_u16(), &again.json()["state"]), (202, &json!("waiting")));
    while receiver.got().len() < 3 {
        tokio::time::sleep(Duration::from_millis(10)).await;
    }
    let ids: Vec<_> = receiver.got().into_iter().map(|(headers, _)| headers["webhook-id"].clone()).collect();
    assert!(ids.iter().all(|id| id == delivered["id"].as_str().unwrap()), "{ids:?}");
    let unknown = format!("{}/deliveries/msg_0/replay", path(&webhook));
    assert_eq!(second.post(&unknown, json!({})).await.problem(), (404, "not_found".into()));
}

/// Time passes for the leases of webhooks.
async fn expire_leases(directory: &std::path::Path) {
    let statement = "UPDATE webhooks SET leased_until = 0";
    let resolved = crate::harness::server::settings_in(directory, &[]).await;
    match &resolved.config.store.database {
        store::DatabaseAddress::Sqlite => {
            use sqlx::Connection as _;
            let file = format!("sqlite://{}?mode=rw", directory.join("tabletopgen.sqlite").display());
            let mut connection = sqlx::SqliteConnection::connect(&file).await.unwrap();
            sqlx::query(statement).execute(&mut connection).await.unwrap();
            connection.close().await.unwrap();
        }
        store::DatabaseAddress::Postgres(url) => {
            use sqlx::Connection as _;
            let mut connection = sqlx::PgConnection::connect(url).await.unwrap();
            sqlx::query(statement).execute(&mut connection).await.unwrap();
        }
    }
}

#[tokio::test]
async fn more_events_than_there_are_are_refused_before_a_precondition() {
    let receiver = Receiver::start(&[]).await;
    let server = server(&Script::new(&[]), &[&receiver], &[]).await;
    let path = path(&created(&server, json!({ "url": receiver.url() })).await);
    let change = json!({ "events": vec!["batch.ended"; 20] });
    let refused = patch(&server, &path, &[("if-match", "\"other\"")], change.clone()).await;
    assert_eq!(refused.problem(), (422, "invalid_body".into()));
    assert_eq!(refused.json()["errors"][0]["pointer"], "/events");
    let many = json!({ "url": receiver.url(), "events": change["events"] });
    assert_eq!(server.post("/webhooks", many).await.status, 422);
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_webhook_is_made_changed_and_deleted() {
    let receiver = Receiver::start(&[]).await;
    let script = Script::new(&[]);
    let server = server(&script, &[&receiver], &[]).await;
    let body = json!({ "url": receiver.url(), "description": "our robots", "events": ["batch.ended"] });
    let made = server.post("/webhooks", body).await;
    assert_eq!(made.header("cache-control"), "private, no-store");
    let webhook = made.json();
    let path = path(&webhook);
    assert!(webhook["secret"].as_str().unwrap().starts_with("whsec_"));
    let read = server.get(&path).await;
    assert_eq!((read.header("etag"), &read.json()["secret"]), (made.header("etag"), &Value::Null));
    assert_eq!(server.get("/webhooks").await.json()["webhooks"], json!([read.json()]));

    let tag = read.header("etag");
    let changed =
        patch(&server, &path, &[("if-match", tag)], json!({ "events": null, "description": "x" })).await;
    assert_eq!(changed.status, 200, "{changed:?}");
    assert_eq!((&changed.json()["events"], &changed.json()["description"]), (&json!([]), &json!("x")));
    let late = patch(&server, &path, &[("if-match", tag)], json!({ "state": "disabled" })).await;
    assert_eq!(late.problem(), (412, "webhook_changed".into()));
    assert_eq!(
        patch(&server, &path, &[], json!({})).await.json(),
        changed.json(),
        "nothing changes, nor its time"
    );
    for (body, pointer) in [
        (json!({ "events": ["scene.lost"] }), "/events/0"),
        (json!({ "state": "off" }), "/state"),
        (json!({ "state": null }), "/state"),
        (json!({ "url": null }), "/url"),
        (json!({ "secret": "whsec_mine" }), "/secret"),
        (json!({ "description": "a\u{7}" }), "/description"),
    ] {
        let refused = patch(&server, &path, &[], body.clone()).await;
        assert_eq!(refused.problem(), (422, "invalid_body".into()), "{body}");
        assert_eq!(refused.json()["errors"][0]["pointer"], pointer, "{body}: {}", refused.json());
    }

    let renewed = server.post(&format!("{path}/secret"), json!({})).await.json();
    assert_ne!(renewed["secret"], webhook["secret"]);
    let ordered = server.post(&format!("{path}/test"), json!({})).await;
    assert_eq!((ordered.status.as_u16(), &ordered.json()["event"]), (202, &json!("webhook.test")));
    deliveries(&server, &webhook, "delivered", 1).await;
    let message = receiver.got().remove(0);
    assert!(is_signed(&renewed["secret"], &message) && is_signed(&webhook["secret"], &message));
    for list in ["/webhooks", &path, &format!("{path}/deliveries"), "/audit"] {
        let text = server.get(list).await.json().to_string();
        assert!(!text.contains("whsec_"), "{list}: {text}");
    }

    for _ in 1..20 {
        created(&server, json!({ "url": receiver.url() })).await;
    }
    let refused = server.post("/webhooks", json!({ "url": receiver.url() })).await;
    assert_eq!(refused.problem(), (409, "too_many_webhooks".into()));
    assert_eq!(server.call(Method::DELETE, &path, &[], "").await.status, 204);
    for (method, path) in [
        (Method::GET, path.clone()),
        (Method::DELETE, path.clone()),
        (Method::GET, format!("{path}/deliveries")),
        (Method::POST, format!("{path}/secret")),
        (Method::POST, format!("{path}/test")),
    ] {
        assert_eq!(server.call(method, &path, &[], "").await.problem(), (404, "not_found".into()), "{path}");
    }
    created(&server, json!({ "url": receiver.url() })).await;
}
