//! Every operation of the contract with every credential that must not open it: the right refusal, and nothing changed.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::Duration;

use hyper::Method;
use scene::TenantId;
use serde_json::{Value, json};
use store::datasets::{NewDataset, SubmitDatasetOutcome};
use store::executions::{NewExecution, SubmitExecutionOutcome};
use store::keys::NewKey;
use store::recordings::{NewRecording, SubmitRecordingOutcome};
use store::scopes::{Scope, ScopeSet};
use store::webhooks::{CreateOutcome, NewWebhook, OrderOutcome};
use store::{DEFAULT_TENANT, Digest, Store};
use tabletopgen::api;

use crate::harness::server::{Reply, Server};

const KEYS: (&str, &str) = ("server.authentication.mode", "keys");

async fn server() -> Server {
    Server::without_worker(Arc::new(tempfile::tempdir().unwrap()), &[KEYS]).await
}

fn tenant(name: &str) -> TenantId {
    name.parse().unwrap()
}

/// Value of `Authorization` with a new key; and the key's id.
async fn key(
    server: &Server,
    tenant_id: &str,
    scopes: ScopeSet,
    lifetime_ms: Option<i64>,
) -> (String, String) {
    let new = NewKey { tenant_id: tenant(tenant_id), name: "test".into(), scopes, lifetime_ms };
    let (row, secret) = server.store().create_key(new).await.unwrap();
    (format!("Bearer {}", secret.expose()), row.id.to_string())
}

/// An operation of the contract.
struct Operation {
    method: Method,
    path: &'static str,
    id: String,
    /// `None` for those that anybody may use.
    scope: Option<Option<Scope>>,
    body: Value,
    /// Media type of the body.
    media_type: &'static str,
}

fn operations() -> Vec<Operation> {
    let document = api::contract::document();
    api::routes()
        .into_iter()
        .map(|route| {
            let method = route.method.as_str().to_lowercase();
            let operation = &document["paths"][route.path.replace("{*", "{")][method.as_str()];
            let security = operation["security"].as_array().unwrap_or_else(|| panic!("{}", route.path));
            let scope = |first: &Value| first["key"][0].as_str().map(|word| Scope::parse(word).unwrap());
            let media_type = match route.method {
                Method::PATCH => "application/merge-patch+json",
                _ => "application/json",
            };
            let json = &operation["requestBody"]["content"][media_type];
            Operation {
                method: route.method,
                path: route.path,
                id: operation["operationId"].as_str().unwrap().to_owned(),
                scope: security.first().map(scope),
                body: json["examples"]["example"]["value"].clone(),
                media_type,
            }
        })
        .collect()
}

/// One of everything that the tenant `default` can have, by the name in paths.
async fn everything(server: &Server, authorization: &str) -> BTreeMap<&'static str, String> {
    let store: &Store = server.store();
    let headers = [("content-type", "application/json"), ("authorization", authorization)];
    let scene = server.call(Method::POST, "/scenes", &headers, r#"{"text":"a mug","seed":7}"#).await.json();
    let scene_id = scene["id"].as_str().unwrap().to_owned();
    let batch = r#"{"templates":["a mug"],"seeds":{"first":0,"count":1}}"#;
    let batch = server.call(Method::POST, "/batches", &headers, batch).await.json();
    let dataset = NewDataset {
        tenant_id: DEFAULT_TENANT.clone(),
        name: "mugs".into(),
        request: json!({ "version": 1 }),
        idempotency_key: None,
        body_digest: Digest::of(b"body"),
    };
    let SubmitDatasetOutcome::Created(dataset_id) = store.submit_dataset(dataset).await.unwrap() else {
        panic!("it has no key");
    };
    let recording = NewRecording {
        tenant_id: DEFAULT_TENANT.clone(),
        scene_id: scene_id.parse().unwrap(),
        request: json!({ "version": 1, "order": { "task": "pick up the mug", "count": 1 } }),
        bundle: Digest::of(b"bundle"),
        wanted: 1,
        max_attempts: 50,
        idempotency_key: None,
        body_digest: Digest::of(b"body"),
    };
    let SubmitRecordingOutcome::Created(recording_id) = store.submit_recording(recording).await.unwrap()
    else {
        panic!("it has no key");
    };
    let execution = NewExecution {
        tenant_id: DEFAULT_TENANT.clone(),
        scene_id: scene_id.parse().unwrap(),
        request: json!({ "version": 1 }),
        bundle: Digest::of(b"bundle"),
        idempotency: None,
    };
    let SubmitExecutionOutcome::Created(execution_id) = store.submit_execution(execution).await.unwrap()
    else {
        panic!("it has no key");
    };
    let (_, key_id) = key(server, "default", ScopeSet::all(), None).await;
    let url = "https://example.org/hook".to_owned();
    let tenant_id = DEFAULT_TENANT.clone();
    let webhook = NewWebhook { tenant_id, url, description: String::new(), events: Vec::new() };
    let (CreateOutcome::Created(webhook), _) = store.create_webhook(webhook).await.unwrap() else {
        panic!("it is the first one");
    };
    let ordered = store.test_webhook(&DEFAULT_TENANT, &webhook.id).await.unwrap();
    let OrderOutcome::Ordered(delivery) = ordered else { panic!("it is enabled") };
    BTreeMap::from([
        ("{scene_id}", scene_id),
        ("{job_id}", scene["job"]["id"].as_str().unwrap().to_owned()),
        ("{batch_id}", batch["id"].as_str().unwrap().to_owned()),
        ("{dataset_id}", dataset_id.to_string()),
        ("{recording_id}", recording_id.to_string()),
        ("{execution_id}", execution_id.to_string()),
        ("{key_id}", key_id),
        ("{webhook_id}", webhook.id.to_string()),
        ("{delivery_id}", delivery.id.to_string()),
        ("{*name}", "manifest.json".to_owned()),
        ("{format}", "lerobot".to_owned()),
        ("{robot}", "panda".to_owned()),
    ])
}

fn path_of(operation: &Operation, ids: &BTreeMap<&'static str, String>) -> String {
    let part = |part: &str| ids.get(part).cloned().unwrap_or_else(|| part.to_owned());
    let path: Vec<String> = operation.path.split('/').map(part).collect();
    assert!(!path.concat().contains('{'), "{path:?}");
    path.join("/")
}

/// Tells `make bars BARS=tenants` how many requests were refused as they should be; they changed nothing.
fn tell(requests: &str, refused: usize, operations: usize) {
    eprintln!("matrix: {requests}: {refused} requests of {operations} operations, 0 changes");
}

/// All that the tenant has, as its lists say; times of the last use of keys apart.
async fn state(server: &Server, authorization: &str) -> Value {
    let mut state = json!({});
    for list in ["/scenes", "/jobs", "/batches", "/datasets", "/episodes", "/keys", "/webhooks"] {
        let reply = server.call(Method::GET, list, &[("authorization", authorization)], "").await;
        assert_eq!(reply.status, 200, "{list}");
        state[list] = reply.json();
    }
    for key in state["/keys"]["keys"].as_array_mut().unwrap() {
        key["last_used_at"] = Value::Null;
    }
    state
}

async fn call(
    server: &Server,
    operation: &Operation,
    ids: &BTreeMap<&'static str, String>,
    headers: &[(&str, &str)],
) -> Reply {
    let body = if operation.body.is_null() { String::new() } else { operation.body.to_string() };
    let headers = [&[("content-type", operation.media_type)], headers].concat();
    server.call(operation.method.clone(), &path_of(operation, ids), &headers, body).await
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn no_operation_opens_to_a_wrong_credential() {
    let server = server().await;
    let (owner, _) = key(&server, "default", ScopeSet::all(), None).await;
    let ids = everything(&server, &owner).await;
    let (expired, _) = key(&server, "default", ScopeSet::all(), Some(1)).await;
    let (revoked, revoked_id) = key(&server, "default", ScopeSet::all(), None).await;
    server.store().revoke_key(&DEFAULT_TENANT, &revoked_id.parse().unwrap()).await.unwrap();
    tokio::time::sleep(Duration::from_millis(5)).await;
    let before = state(&server, &owner).await;
    let operations = operations();
    assert!(operations.len() > 50, "{}", operations.len());

    let wrong = "Bearer tt_AAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAA";
    let no_session = "tt_session=AAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAA";
    let credentials = [
        (None, "credential_missing", "without a key"),
        (Some(("authorization", wrong)), "credential_invalid", "with a wrong key"),
        (Some(("authorization", "Bearer sk-of-somebody-else")), "credential_invalid", "with a foreign key"),
        (Some(("authorization", "Basic dXNlcjpwYXNz")), "credential_invalid", "with a password"),
        (Some(("authorization", &*expired)), "credential_expired", "with an expired key"),
        (Some(("authorization", &*revoked)), "credential_revoked", "with a revoked key"),
        (Some(("cookie", no_session)), "credential_invalid", "with a wrong cookie"),
    ];
    let closed = operations.iter().filter(|operation| operation.scope.is_some()).count();
    for (header, code, name) in credentials {
        let headers = header.as_slice();
        for operation in operations.iter().filter(|operation| operation.scope.is_some()) {
            let refused = call(&server, operation, &ids, headers).await;
            assert_eq!(refused.problem(), (401, code.into()), "{} with {headers:?}", operation.id);
            assert_eq!(refused.header("www-authenticate"), "Bearer");
        }
        assert_eq!(state(&server, &owner).await, before, "after {headers:?}");
        tell(name, closed, closed);
    }

    let mut lacked = 0;
    for scope in Scope::ALL {
        let others: ScopeSet = Scope::ALL.into_iter().filter(|other| *other != scope).collect();
        let (lacking, _) = key(&server, "other", others, None).await;
        for operation in operations.iter().filter(|operation| operation.scope == Some(Some(scope))) {
            let refused = call(&server, operation, &ids, &[("authorization", &lacking)]).await;
            assert_eq!(refused.problem(), (403, "scope_missing".into()), "{} without {scope}", operation.id);
            let detail = refused.json()["detail"].as_str().unwrap().to_owned();
            assert!(detail.contains(&format!("the scope {scope}")), "{detail}");
            lacked += 1;
        }
    }
    assert_eq!(state(&server, &owner).await, before);
    tell("without the scope", lacked, lacked);

    let foreign = [("authorization", owner.as_str()), ("sec-fetch-site", "cross-site")];
    for operation in &operations {
        let refused = call(&server, operation, &ids, &foreign).await;
        assert_eq!(refused.problem(), (403, "cross_site_request".into()), "{}", operation.id);
    }
    assert_eq!(state(&server, &owner).await, before);
    tell("of a page of another site", operations.len(), operations.len());
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn what_belongs_to_another_tenant_is_not_there() {
    let server = server().await;
    let (owner, _) = key(&server, "default", ScopeSet::all(), None).await;
    let (other, _) = key(&server, "other", ScopeSet::all(), None).await;
    let ids = everything(&server, &owner).await;
    let before = state(&server, &owner).await;
    let mut count = 0;
    for operation in operations() {
        if !operation.path.contains("_id}") {
            continue;
        }
        for accept in ["application/json", "text/event-stream"] {
            let headers = [("authorization", other.as_str()), ("accept", accept)];
            let refused = call(&server, &operation, &ids, &headers).await;
            assert_eq!(refused.problem(), (404, "not_found".into()), "{}: {refused:?}", operation.id);
        }
        count += 1;
    }
    assert!(count > 30, "{count}");
    assert_eq!(state(&server, &owner).await, before);
    tell("about what another tenant has", 2 * count, count);
    let theirs = state(&server, &other).await;
    for (list, rows) in [("/scenes", "scenes"), ("/jobs", "jobs"), ("/batches", "batches")] {
        assert_eq!(theirs[list][rows], json!([]), "{list}");
        assert_ne!(before[list][rows], json!([]), "{list}");
    }
    for (list, rows) in [("/datasets", "datasets"), ("/episodes", "recordings")] {
        let rows = if theirs[list][rows].is_null() { "episodes" } else { rows };
        assert_eq!(theirs[list][rows], json!([]), "{list}: {}", theirs[list]);
    }
    assert_eq!(theirs["/keys"]["keys"].as_array().unwrap().len(), 1);

    // The same text with the same key of two tenants makes two scenes, each its owner's.
    let submit = async |authorization: &str| {
        let headers = [
            ("content-type", "application/json"),
            ("authorization", authorization),
            ("idempotency-key", "order-1"),
        ];
        let scene = server.call(Method::POST, "/scenes", &headers, r#"{"text":"a cup"}"#).await;
        assert_eq!(scene.status, 202, "{scene:?}");
        scene.json()["id"].as_str().unwrap().to_owned()
    };
    let (mine, theirs) = (submit(&owner).await, submit(&other).await);
    assert_ne!(mine, theirs);
    for (authorization, scene, status) in
        [(&owner, &mine, 200), (&owner, &theirs, 404), (&other, &theirs, 200), (&other, &mine, 404)]
    {
        let headers = [("authorization", authorization.as_str())];
        let reply = server.call(Method::GET, &format!("/scenes/{scene}"), &headers, "").await;
        assert_eq!(reply.status, status);
    }
}

#[tokio::test]
async fn probes_and_the_contract_are_for_everyone_and_metrics_for_operators() {
    let server = server().await;
    for path in ["/healthz", "/readyz", "/version", "/openapi.yaml"] {
        for headers in [&[][..], &[("authorization", "Bearer tt_wrong")]] {
            assert_eq!(server.call(Method::GET, path, headers, "").await.status, 200, "{path} {headers:?}");
        }
    }
    assert_eq!(server.get("/metrics").await.problem(), (401, "credential_missing".into()));
    let (operator, _) = key(&server, "other", [Scope::Operate].into_iter().collect(), None).await;
    let metrics = server.call(Method::GET, "/metrics", &[("authorization", &operator)], "").await;
    assert_eq!(metrics.status, 200);
    assert!(String::from_utf8_lossy(&metrics.body).contains(r#"refused_total{reason="credential"}"#));
}

#[tokio::test]
async fn a_server_without_authentication_refuses_a_wrong_key_all_the_same() {
    let server = Server::without_worker(Arc::new(tempfile::tempdir().unwrap()), &[]).await;
    assert_eq!(server.get("/scenes").await.status, 200);
    assert_eq!(server.get("/session").await.json()["kind"], "anonymous");
    for wrong in [("authorization", "bearer tt_wrong"), ("cookie", "a=b; tt_session=wrong")] {
        let refused = server.call(Method::GET, "/scenes", &[wrong], "").await;
        assert_eq!(refused.problem(), (401, "credential_invalid".into()), "{wrong:?}");
    }
    // What is meant for a proxy in front of it is none of its business.
    for foreign in ["Basic dXNlcjpwYXNz", "Bearer eyJhbGciOiJub25lIn0.e30."] {
        let answered = server.call(Method::GET, "/scenes", &[("authorization", foreign)], "").await;
        assert_eq!(answered.status, 200, "{foreign}");
    }
    let (reader, _) = key(&server, "other", [Scope::Read].into_iter().collect(), None).await;
    let session = server.call(Method::GET, "/session", &[("authorization", &reader)], "").await.json();
    assert_eq!((&session["tenant"], &session["scopes"]), (&json!("other"), &json!(["read"])));
    let headers = [("content-type", "application/json"), ("authorization", reader.as_str())];
    let refused = server.call(Method::POST, "/scenes", &headers, r#"{"text":"a mug"}"#).await;
    assert_eq!(refused.problem(), (403, "scope_missing".into()), "a key means what it says");
}

#[tokio::test]
async fn only_a_proxy_of_the_operator_names_users() {
    let proxy = [
        KEYS,
        ("server.authentication.proxy_user_header", "x-user"),
        ("server.authentication.proxy_tenant_header", "x-tenant"),
        ("server.authentication.proxy_scopes_header", "x-groups"),
    ];
    let named = [("x-user", "ann@example.org"), ("x-tenant", "lab"), ("x-groups", "staff, read admin")];
    let directory = || Arc::new(tempfile::tempdir().unwrap());

    let stranger = [&proxy[..], &[("server.proxy_addresses", "192.0.2.1")]].concat();
    let server = Server::without_worker(directory(), &stranger).await;
    let forwarded = [&named[..], &[("x-forwarded-for", "192.0.2.1")]].concat();
    for headers in [&named[..], &forwarded] {
        let refused = server.call(Method::GET, "/session", headers, "").await;
        assert_eq!(refused.problem(), (401, "credential_missing".into()), "{headers:?}");
    }

    let trusted = [&proxy[..], &[("server.proxy_addresses", "127.0.0.1")]].concat();
    let server = Server::without_worker(directory(), &trusted).await;
    let session = server.call(Method::GET, "/session", &named, "").await.json();
    assert_eq!(session["principal"], "user:ann@example.org");
    assert_eq!((&session["tenant"], &session["scopes"]), (&json!("lab"), &json!(["read", "admin"])));
    assert_eq!(server.get("/session").await.problem(), (401, "credential_missing".into()));
    let twice = [&named[..], &[("x-user", "root")]].concat();
    let refused = server.call(Method::GET, "/session", &twice, "").await;
    assert_eq!(refused.problem(), (401, "credential_invalid".into()));
    // The token that the proxy itself was sent is no key; a key goes before the user.
    let token = [&named[..], &[("authorization", "Bearer eyJhbGciOiJub25lIn0.e30.")]].concat();
    assert_eq!(server.call(Method::GET, "/session", &token, "").await.json()["kind"], "user");
    let (reader, _) = key(&server, "other", [Scope::Read].into_iter().collect(), None).await;
    let both = [&named[..], &[("authorization", reader.as_str())]].concat();
    assert_eq!(server.call(Method::GET, "/session", &both, "").await.json()["tenant"], "other");
}
