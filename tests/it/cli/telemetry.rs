//! Telemetry of one scene for operators: metrics, traces and the log, of the program itself with a remote model and a
//! collector of traces. None of them holds a secret.

use std::collections::{BTreeMap, BTreeSet};
use std::io::{BufRead, BufReader, Read, Write};
use std::net::{SocketAddr, TcpStream};
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use axum::Router;
use axum::http::{HeaderMap, StatusCode};
use axum::routing::post;
use bytes::Bytes;
use opentelemetry_proto::tonic::collector::trace::v1::ExportTraceServiceRequest;
use opentelemetry_proto::tonic::common::v1::any_value::Value as Attribute;
use opentelemetry_proto::tonic::trace::v1::Span;
use prost::Message as _;
use serde_json::{Value, json};
use tabletopgen::app::metrics::METRICS;
use tokio::net::TcpListener;

const TRACE_PARENT: &str = "00-4bf92f3577b34da6a3ce929d0e0e4736-00f067aa0ba902b7-01";

/// Every secret of the test, by where it goes in.
const SECRETS: [(&str, &str); 8] = [
    ("the key of a vendor", "sk-vendor-0f1e2d"),
    ("the key of the collector", "otlp-9a8b7c"),
    ("the authorization of a client", "client-5d4c3b"),
    ("a query of a client", "query-7e6f5a"),
    ("the signature of an image's address", "signature-1b2c3d"),
    ("a label", "label-4e5f6a"),
    ("a key that opens nothing", "tt_6b7c8d"),
    ("a cookie that opens nothing", "cookie-2c3d4e"),
];

fn secret(of: &str) -> &'static str {
    SECRETS.iter().find(|(name, _)| *name == of).expect("is listed").1
}

/// A collector of traces: what it was sent.
#[derive(Clone, Default)]
struct Collector {
    spans: Arc<Mutex<Vec<Span>>>,
    authorized: Arc<Mutex<BTreeSet<bool>>>,
}

impl Collector {
    async fn start(&self) -> SocketAddr {
        let listener = TcpListener::bind("127.0.0.1:0").await.unwrap();
        let address = listener.local_addr().unwrap();
        let collector = self.clone();
        let receive = move |headers: HeaderMap, body: Bytes| {
            let sent = ExportTraceServiceRequest::decode(body).expect("is a protobuf of OTLP");
            assert_eq!(headers["content-type"], "application/x-protobuf");
            let key = format!("Bearer {}", secret("the key of the collector"));
            let authorized =
                headers.get("authorization").is_some_and(|value| value.as_bytes() == key.as_bytes());
            collector.authorized.lock().unwrap().insert(authorized);
            let scopes = sent.resource_spans.into_iter().flat_map(|resource| resource.scope_spans);
            collector.spans.lock().unwrap().extend(scopes.flat_map(|scope| scope.spans));
            async { StatusCode::OK }
        };
        tokio::spawn(
            async move { axum::serve(listener, Router::new().route("/v1/traces", post(receive))).await },
        );
        address
    }
}

/// A vendor that refuses the key, so that the embedded adapter takes over.
async fn refusing_vendor() -> SocketAddr {
    let listener = TcpListener::bind("127.0.0.1:0").await.unwrap();
    let address = listener.local_addr().unwrap();
    let refuse = |headers: HeaderMap| async move {
        let key = format!("Bearer {}", secret("the key of a vendor"));
        assert_eq!(headers["authorization"].as_bytes(), key.as_bytes(), "the key does go to the vendor");
        (StatusCode::UNAUTHORIZED, format!("{{\"error\":{{\"message\":\"no such key: {key}\"}}}}"))
    };
    let routes = Router::new().route("/v1/chat/completions", post(refuse));
    tokio::spawn(async move { axum::serve(listener, routes).await });
    address
}

/// The program as a server; killed if the test fails.
struct Serving {
    process: Child,
    address: String,
}

impl Drop for Serving {
    fn drop(&mut self) {
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}

impl Serving {
    fn start(home: &Path, collector: SocketAddr, vendor: SocketAddr) -> Self {
        let endpoint = format!("http://{collector}/v1/traces");
        let set = [
            "log.format=json".to_owned(),
            "log.filter=debug".to_owned(),
            format!("telemetry.traces_endpoint={endpoint}"),
            "providers.analyst=[\"chat\", \"embedded\"]".to_owned(),
            "providers.allow_http=true".to_owned(),
            format!("providers.private_hosts={vendor}"),
            format!("providers.chat.base_url=http://{vendor}/v1"),
        ];
        let log = std::fs::File::create(home.join("log")).unwrap();
        let mut process = Command::new(env!("CARGO_BIN_EXE_tabletopgen"))
            .args(["serve", "--listen", "127.0.0.1:0", "--data-dir", "d"])
            .args(set.iter().flat_map(|set| ["--set", set]))
            .env("OPENAI_API_KEY", secret("the key of a vendor"))
            .env(
                "OTEL_EXPORTER_OTLP_HEADERS",
                format!("authorization=Bearer%20{}", secret("the key of the collector")),
            )
            .env("OTEL_BSP_SCHEDULE_DELAY", "200")
            .current_dir(home)
            .stdout(Stdio::piped())
            .stderr(log)
            .spawn()
            .expect("starts");
        let mut line = String::new();
        BufReader::new(process.stdout.as_mut().unwrap()).read_line(&mut line).unwrap();
        let address = line.trim().strip_prefix("listening on http://").unwrap_or_else(|| {
            panic!("{line:?}: {}", std::fs::read_to_string(home.join("log")).unwrap_or_default())
        });
        Self { address: address.to_owned(), process }
    }

    /// Status and body.
    fn call(&self, method: &str, target: &str, headers: &str, body: &str) -> (u16, String) {
        call(&self.address, &self.address, method, target, headers, body)
    }

    fn stop(mut self) {
        let sent = Command::new("kill").args(["-TERM", &self.process.id().to_string()]).status().unwrap();
        assert!(sent.success());
        assert_eq!(self.process.wait().unwrap().code(), Some(0));
    }
}

fn call(address: &str, host: &str, method: &str, target: &str, headers: &str, body: &str) -> (u16, String) {
    let mut socket = TcpStream::connect(address).expect("connects");
    socket.set_read_timeout(Some(Duration::from_secs(30))).unwrap();
    let length = body.len();
    write!(
        socket,
        "{method} {target} HTTP/1.1\r\nhost: {host}\r\nconnection: close\r\ncontent-type: application/json\r\n\
         content-length: {length}\r\n{headers}\r\n{body}"
    )
    .unwrap();
    let mut answer = String::new();
    socket.read_to_string(&mut answer).unwrap();
    let (head, body) = answer.split_once("\r\n\r\n").expect("has a header");
    let status = head.split(' ').nth(1).and_then(|status| status.parse().ok()).expect("has a status");
    (status, body.to_owned())
}

/// The text attributes of a span.
fn attributes(span: &Span) -> BTreeMap<&str, &str> {
    let text = |value: &Option<opentelemetry_proto::tonic::common::v1::AnyValue>| match value
        .as_ref()?
        .value
        .as_ref()?
    {
        Attribute::StringValue(text) => Some(text.clone()),
        _ => None,
    };
    span.attributes
        .iter()
        .filter_map(|pair| Some((pair.key.as_str(), text(&pair.value)?)))
        .map(|(key, text)| (key, &*text.leak()))
        .collect()
}

fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}

#[tokio::test(flavor = "multi_thread")]
async fn one_scene_in_metrics_traces_and_log_and_no_secret_in_any() {
    let home = tempfile::tempdir().unwrap();
    let collector = Collector::default();
    let (endpoint, vendor) = (collector.start().await, refusing_vendor().await);
    let serving = Serving::start(home.path(), endpoint, vendor);

    // A scene, with secrets wherever a client can put them.
    let authorization = format!("authorization: Bearer {}\r\n", secret("the authorization of a client"));
    let headers = format!("{authorization}x-request-id: observed-1\r\ntraceparent: {TRACE_PARENT}\r\n");
    let request = json!({ "text": "a mug", "seed": 7, "labels": { "owner": secret("a label") } });
    let (status, body) = serving.call("POST", "/scenes", &headers, &request.to_string());
    assert_eq!(status, 202, "{body}");
    let scene: Value = serde_json::from_str(&body).unwrap();
    let (scene_id, job_id) = (scene["id"].as_str().unwrap(), scene["job"]["id"].as_str().unwrap());
    let query = format!("/scenes?token={}", secret("a query of a client"));
    assert_eq!(serving.call("GET", &query, &authorization, "").0, 400);
    let address = format!(
        "https://127.0.0.1:9/a.png?X-Amz-Signature={}",
        secret("the signature of an image's address")
    );
    let request = json!({ "image": { "url": address } });
    assert_eq!(serving.call("POST", "/scenes", &authorization, &request.to_string()).0, 422);

    let key = format!("authorization: Bearer {}\r\n", secret("a key that opens nothing"));
    let cookie = format!("cookie: tt_session={}\r\n", secret("a cookie that opens nothing"));
    for header in [key, cookie] {
        assert_eq!(serving.call("GET", "/scenes", &header, "").0, 401);
    }
    let login = json!({ "key": secret("a key that opens nothing") }).to_string();
    assert_eq!(serving.call("POST", "/session", "", &login).0, 401);

    let deadline = Instant::now() + Duration::from_secs(120);
    loop {
        let (_, job) = serving.call("GET", &format!("/jobs/{job_id}"), "", "");
        let job: Value = serde_json::from_str(&job).unwrap();
        match job["state"].as_str().unwrap() {
            "succeeded" => break,
            "failed" | "cancelled" => panic!("{job}"),
            _ => assert!(Instant::now() < deadline, "{job}"),
        }
        tokio::time::sleep(Duration::from_millis(100)).await;
    }
    // Its attempt is recorded after the state.
    tokio::time::sleep(Duration::from_millis(200)).await;
    // A refusal is counted by its reason.
    assert_eq!(call(&serving.address, "evil.example", "GET", "/scenes", "", "").0, 421);
    let (status, exposition) = serving.call("GET", "/metrics", "", "");
    assert_eq!(status, 200);
    serving.stop();

    let log = |home: &Path| std::fs::read_to_string(home.join("log")).unwrap();
    metrics_are_those_of_the_table(&exposition);
    trace_leads_from_request_to_call(&collector, scene_id, job_id);
    log_has_ids(&log(home.path()), scene_id, job_id);

    let (log, spans) = (log(home.path()), format!("{:?}", collector.spans.lock().unwrap()));
    for (name, secret) in SECRETS {
        for (place, text) in [("log", &log), ("traces", &spans), ("metrics", &exposition)] {
            assert!(!text.contains(secret), "{name} is in the {place}");
        }
    }
    assert!(!log.contains("a mug"), "the text of a request is in the log");
}

/// Checks that the server exposes exactly the metrics of [`METRICS`]: names, types and labels.
fn metrics_are_those_of_the_table(exposition: &str) {
    let mut kinds = BTreeMap::new();
    let mut labels: BTreeMap<&str, BTreeSet<&str>> = BTreeMap::new();
    for line in exposition.lines() {
        if let Some(family) = line.strip_prefix("# TYPE ") {
            let (name, kind) = family.split_once(' ').expect("has a type");
            kinds.insert(name, kind);
        } else if !line.starts_with('#') && !line.is_empty() {
            let end = line.find(['{', ' ']).expect("has a value");
            let series = &line[..end];
            let family = ["_bucket", "_sum", "_count"].iter().find_map(|end| {
                series.strip_suffix(end).filter(|name| kinds.get(name) == Some(&"histogram"))
            });
            let of_family = labels.entry(family.unwrap_or(series)).or_default();
            let pairs =
                line[end..].strip_prefix('{').and_then(|rest| rest.rsplit_once("} ")).map_or("", |(p, _)| p);
            // A value may hold a comma inside braces (`/scenes/{scene_id}`), and none holds `="`.
            let names = pairs.split("=\"").filter_map(|part| part.rsplit(',').next());
            let count = pairs.matches("=\"").count();
            of_family.extend(names.take(count).filter(|name| *name != "le"));
        }
    }
    for metric in METRICS {
        assert_eq!(kinds.get(metric.name), Some(&metric.kind.as_str()), "{} in\n{exposition}", metric.name);
        let listed: BTreeSet<&str> = metric.labels.iter().copied().collect();
        assert_eq!(labels.get(metric.name), Some(&listed), "labels of {}", metric.name);
    }
    let known: BTreeSet<&str> = METRICS.iter().map(|metric| metric.name).collect();
    for name in kinds.keys() {
        assert!(known.contains(name), "{name} is exposed and not in METRICS");
    }
    for line in [
        "tabletopgen_jobs{state=\"queued\"} 0",
        "tabletopgen_scenes_submitted_total 1",
        "tabletopgen_jobs_finished_total{outcome=\"succeeded\",class=\"\"} 1",
        "tabletopgen_claims_total{outcome=\"claimed\"} 1",
        "tabletopgen_store_readable 1",
        "tabletopgen_worker_slots_used{kind=\"generate\"} 0",
        "tabletopgen_requests_refused_total{reason=\"host\"} 1",
    ] {
        assert!(exposition.lines().any(|exposed| exposed == line), "{line} in\n{exposition}");
    }
}

fn trace_leads_from_request_to_call(collector: &Collector, scene_id: &str, job_id: &str) {
    let spans = collector.spans.lock().unwrap();
    assert_eq!(*collector.authorized.lock().unwrap(), BTreeSet::from([true]));
    let named = |name: &str| spans.iter().filter(|span| span.name == name).collect::<Vec<_>>();
    let trace = job_id.replace('-', "");

    let requests = named("request");
    let submission = requests.iter().find(|span| attributes(span).get("request_id") == Some(&"observed-1"));
    let submission = submission.expect("the span of the submission arrived");
    assert_eq!(hex(&submission.trace_id), "4bf92f3577b34da6a3ce929d0e0e4736", "the client's trace goes on");
    assert_eq!(hex(&submission.parent_span_id), "00f067aa0ba902b7");
    assert_eq!(submission.kind, 2, "a server's");
    let known = attributes(submission);
    assert_eq!((known.get("job_id"), known.get("scene_id")), (Some(&job_id), Some(&scene_id)));
    assert_eq!(known.get("route"), Some(&"/scenes"));
    let links: Vec<String> = submission.links.iter().map(|link| hex(&link.trace_id)).collect();
    assert_eq!(links, std::slice::from_ref(&trace), "and leads to the job's");

    let jobs = named("job");
    let [job] = jobs[..] else { panic!("{} attempts", jobs.len()) };
    assert_eq!(hex(&job.trace_id), trace);
    assert_eq!(attributes(job).get("state"), Some(&"succeeded"));
    let stages = named("stage");
    let worked: BTreeSet<String> = stages.iter().map(|span| attributes(span)["stage"].to_owned()).collect();
    let of_some_requests = ["refine_camera", "clutter", "grasp", "rehearse"];
    for stage in tabletopgen::pipeline::STAGES.iter().filter(|stage| !of_some_requests.contains(stage)) {
        assert!(worked.contains(*stage), "{stage} is not among {worked:?}");
    }
    for stage in &stages {
        assert_eq!(
            (&stage.trace_id, &stage.parent_span_id),
            (&job.trace_id, &job.span_id),
            "a stage is the job's"
        );
    }
    let calls = named("provider_call");
    assert!(!calls.is_empty(), "no call of the vendor is among the spans");
    for call in calls {
        let stage = stages.iter().find(|stage| stage.span_id == call.parent_span_id);
        assert!(stage.is_some(), "the parent of a call is a stage: {call:?}");
        assert_eq!((call.kind, &call.trace_id), (3, &job.trace_id));
        assert!(attributes(call)["provider"].contains("chat"), "{call:?}");
        assert!(!attributes(call)["outcome"].is_empty(), "{call:?}");
    }
}

fn log_has_ids(log: &str, scene_id: &str, job_id: &str) {
    let lines: Vec<Value> = log
        .lines()
        .filter(|line| line.starts_with('{'))
        .map(|line| serde_json::from_str(line).unwrap())
        .collect();
    let access =
        |line: &&Value| line["target"] == "tabletopgen::access" && line["request_id"] == "observed-1";
    let submission = lines.iter().find(access).expect("the submission is in the access log");
    for (name, value) in [
        ("job_id", json!(job_id)),
        ("scene_id", json!(scene_id)),
        ("method", json!("POST")),
        ("route", json!("/scenes")),
        ("status", json!(202)),
    ] {
        assert_eq!(submission[name], value, "{name} of {submission}");
    }
    assert!(submission["seconds"].is_f64(), "{submission}");
    let ended = lines.iter().find(|line| line["message"] == "the job's attempt is over").expect("is logged");
    assert_eq!((&ended["job_id"], &ended["scene_id"]), (&json!(job_id), &json!(scene_id)));
}
