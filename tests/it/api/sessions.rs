//! Sessions of browsers, keys that administrators manage, and the record of all of it.

use std::sync::Arc;
use std::time::Duration;

use hyper::Method;
use serde_json::{Value, json};
use store::DEFAULT_TENANT;
use store::keys::NewKey;
use store::scopes::ScopeSet;

use crate::harness::server::{Reply, Server};

const JSON: (&str, &str) = ("content-type", "application/json");

async fn server(set: &[(&str, &str)]) -> Server {
    let keys = ("server.authentication.mode", "keys");
    Server::without_worker(Arc::new(tempfile::tempdir().unwrap()), &[&[keys], set].concat()).await
}

/// A key and its id.
async fn key(server: &Server, tenant: &str, scopes: &str, lifetime_ms: Option<i64>) -> (String, String) {
    let scopes = ScopeSet::parse(scopes).unwrap();
    let new = NewKey { tenant_id: tenant.parse().unwrap(), name: "test".into(), scopes, lifetime_ms };
    let (row, secret) = server.store().create_key(new).await.unwrap();
    (secret.expose().to_owned(), row.id.to_string())
}

async fn log_in(server: &Server, key: &str) -> Reply {
    server.call(Method::POST, "/session", &[JSON], json!({ "key": key }).to_string()).await
}

/// The pair that a browser sends back.
fn pair_of(reply: &Reply) -> String {
    reply.header("set-cookie").split(';').next().unwrap().to_owned()
}

async fn with(server: &Server, method: Method, path: &str, key: &str, body: Value) -> Reply {
    let authorization = format!("Bearer {key}");
    let body = if body.is_null() { String::new() } else { body.to_string() };
    server.call(method, path, &[JSON, ("authorization", &authorization)], body).await
}

#[tokio::test]
async fn a_session_begins_with_a_key_and_ends_with_it() {
    let server = server(&[]).await;
    let (secret, id) = key(&server, "lab", "read submit", None).await;
    let begun = log_in(&server, &secret).await;
    assert_eq!((begun.status.as_u16(), begun.header("cache-control")), (204, "no-store"));
    let cookie = begun.header("set-cookie").to_owned();
    assert!(cookie.starts_with("tt_session="), "{cookie}");
    assert!(cookie.ends_with("; HttpOnly; SameSite=Strict; Path=/; Max-Age=43200"), "{cookie}");
    assert!(!cookie.contains(&secret), "the cookie is not the key");

    let pair = pair_of(&begun);
    let cookie = [("cookie", pair.as_str())];
    let session = server.call(Method::GET, "/session", &cookie, "").await.json();
    assert_eq!(session["principal"], format!("session:{id}"));
    assert_eq!((&session["tenant"], &session["scopes"]), (&json!("lab"), &json!(["read", "submit"])));
    assert!(session["expires_at"].is_string() && session["limits"]["max_image_bytes"] == 20_000_000);
    let submit = server.call(Method::POST, "/scenes", &[JSON, cookie[0]], r#"{"text":"a mug"}"#).await;
    assert_eq!(submit.status, 202, "{submit:?}");
    let foreign = [JSON, cookie[0], ("origin", "https://evil.example")];
    let refused = server.call(Method::POST, "/scenes", &foreign, r#"{"text":"a mug"}"#).await;
    assert_eq!(refused.problem(), (403, "cross_site_request".into()));
    let job = submit.json()["job"]["id"].as_str().unwrap().to_owned();
    let refused = server.call(Method::POST, &format!("/jobs/{job}/cancel"), &cookie, "").await;
    assert_eq!(refused.problem(), (403, "scope_missing".into()));

    let ended = server.call(Method::DELETE, "/session", &cookie, "").await;
    assert_eq!(ended.status, 204);
    assert!(
        ended.header("set-cookie").contains("tt_session=; ")
            && ended.header("set-cookie").contains("Max-Age=0")
    );
    let refused = server.call(Method::GET, "/session", &cookie, "").await;
    assert_eq!(refused.problem(), (401, "credential_invalid".into()));
    assert_eq!(server.call(Method::DELETE, "/session", &cookie, "").await.status, 204, "twice is fine");

    // A browser with an old cookie logs in again; revoking the key ends what it has then.
    let again =
        server.call(Method::POST, "/session", &[JSON, cookie[0]], json!({ "key": secret }).to_string()).await;
    let pair = pair_of(&again);
    let cookie = [("cookie", pair.as_str())];
    assert_eq!(server.call(Method::GET, "/session", &cookie, "").await.status, 200);
    let (admin, _) = key(&server, "lab", "admin", None).await;
    let revoked = with(&server, Method::DELETE, &format!("/keys/{id}"), &admin, Value::Null).await;
    assert_eq!(revoked.status, 204);
    let refused = server.call(Method::GET, "/session", &cookie, "").await;
    assert_eq!(refused.problem(), (401, "credential_invalid".into()));
    assert_eq!(log_in(&server, &secret).await.problem(), (401, "credential_revoked".into()));
}

#[tokio::test]
async fn a_session_is_no_longer_than_its_key_and_secure_by_https() {
    let server = server(&[("server.public_url", "https://scenes.example.org")]).await;
    let (brief, _) = key(&server, "lab", "read", Some(90_000)).await;
    let begun = log_in(&server, &brief).await;
    let cookie = begun.header("set-cookie").to_owned();
    assert!(cookie.starts_with("__Host-tt_session=") && cookie.ends_with("; Secure"), "{cookie}");
    let age: u64 = cookie.split("Max-Age=").nth(1).unwrap().split(';').next().unwrap().parse().unwrap();
    assert!((80..=90).contains(&age), "{cookie}");
    let pair = pair_of(&begun);
    let hosted = [("cookie", pair.as_str()), ("host", "scenes.example.org")];
    assert_eq!(server.call(Method::GET, "/session", &hosted, "").await.status, 200);

    let (ended, _) = key(&server, "lab", "read", Some(1)).await;
    tokio::time::sleep(Duration::from_millis(5)).await;
    assert_eq!(log_in(&server, &ended).await.problem(), (401, "credential_expired".into()));
}

#[tokio::test]
async fn logins_are_counted_and_repeat_nothing() {
    let server = server(&[("server.authentication.logins_per_minute", "6")]).await;
    let (secret, _) = key(&server, "lab", "read", None).await;
    let in_the_wrong_place =
        [json!(secret), json!({ "key": { &secret: 1 } }), json!({ &secret: 1 }), json!({ "key": [secret] })];
    for body in in_the_wrong_place {
        let refused = server.call(Method::POST, "/session", &[JSON], body.to_string()).await;
        assert_eq!(refused.status, 422, "{refused:?}");
        assert!(!String::from_utf8_lossy(&refused.body).contains(&secret[3..]), "{refused:?}");
    }
    for _ in 0..5 {
        assert_eq!(log_in(&server, "tt_guess").await.problem(), (401, "credential_invalid".into()));
    }
    assert_eq!(log_in(&server, &secret).await.status, 204);
    let refused = log_in(&server, &secret).await;
    assert_eq!(refused.problem(), (429, "too_many_logins".into()));
    assert!(!refused.header("retry-after").is_empty());
}

#[tokio::test]
async fn administrators_manage_the_keys_of_their_tenant_and_the_operator_those_of_all() {
    let server = server(&[]).await;
    let (operator, _) = key(&server, "default", "admin", None).await;
    let (admin, _) = key(&server, "lab", "admin", None).await;
    let draft = json!({ "name": "arm 1", "scopes": ["read"], "expires_in_s": 3600 });
    let made = with(&server, Method::POST, "/keys", &admin, draft.clone()).await;
    assert_eq!((made.status.as_u16(), made.header("cache-control")), (201, "no-store"));
    let made = made.json();
    assert_eq!((&made["tenant"], &made["scopes"]), (&json!("lab"), &json!(["read"])));
    let secret = made["key"].as_str().unwrap();
    let session = with(&server, Method::GET, "/session", secret, Value::Null).await.json();
    assert_eq!(session["principal"], format!("key:{}", made["id"].as_str().unwrap()));
    assert_eq!(session["expires_at"], made["expires_at"]);

    let list = async |key: &str, query: &str| {
        let reply = with(&server, Method::GET, &format!("/keys{query}"), key, Value::Null).await;
        assert!(!String::from_utf8_lossy(&reply.body).contains("tt_"), "a secret is in a list");
        reply
    };
    assert_eq!(list(&admin, "").await.json()["keys"].as_array().unwrap().len(), 2);
    assert_eq!(list(&operator, "").await.json()["keys"].as_array().unwrap().len(), 1);
    assert_eq!(list(&operator, "?tenant=lab").await.json()["keys"].as_array().unwrap().len(), 2);
    assert_eq!(list(&admin, "?tenant=default").await.problem(), (403, "other_tenant".into()));
    assert_eq!(list(&admin, "?tenant=a%20b").await.problem(), (400, "invalid_parameter".into()));
    let first = list(&admin, "?page_size=1").await.json();
    let token = first["next_page_token"].as_str().unwrap();
    let rest = list(&admin, &format!("?page_token={token}")).await.json();
    assert_ne!(rest["keys"][0]["id"], first["keys"][0]["id"]);

    let mut foreign = draft.clone();
    foreign["tenant"] = "default".into();
    let refused = with(&server, Method::POST, "/keys", &admin, foreign).await;
    assert_eq!(refused.problem(), (403, "other_tenant".into()));
    let mut new_tenant = draft.clone();
    new_tenant["tenant"] = "new".into();
    let made_there = with(&server, Method::POST, "/keys", &operator, new_tenant).await;
    assert_eq!(made_there.json()["tenant"], "new");
    for (wrong, pointer) in [
        (json!({ "name": "", "scopes": ["read"] }), "/name"),
        (json!({ "name": "a", "scopes": [] }), "/scopes"),
        (json!({ "name": "a", "scopes": ["all"] }), "/scopes"),
        (json!({ "name": "a", "scopes": ["read"], "expires_in_s": 1 }), "/expires_in_s"),
        (json!({ "name": "a", "scopes": ["read", "read", "read", "read", "read", "read"] }), "/scopes"),
        (json!({ "name": "a", "scopes": ["read"], "tenant": "a b" }), "/tenant"),
    ] {
        let refused = with(&server, Method::POST, "/keys", &admin, wrong.clone()).await;
        assert_eq!(refused.problem().0, 422, "{wrong}");
        assert_eq!(refused.json()["errors"][0]["pointer"], pointer, "{refused:?}");
    }
    let path = format!("/keys/{}", made["id"].as_str().unwrap());
    let (stranger, _) = key(&server, "new", "admin", None).await;
    assert_eq!(with(&server, Method::DELETE, &path, &stranger, Value::Null).await.status, 404);
    assert_eq!(with(&server, Method::DELETE, &path, &operator, Value::Null).await.status, 404);
    let operators = format!("{path}?tenant=lab");
    assert_eq!(with(&server, Method::DELETE, &operators, &operator, Value::Null).await.status, 204);
    let refused = with(&server, Method::GET, "/session", secret, Value::Null).await;
    assert_eq!(refused.problem(), (401, "credential_revoked".into()));
}

#[tokio::test]
async fn changes_and_refusals_are_recorded_with_who_and_from_where() {
    let server = server(&[("server.proxy_addresses", "127.0.0.1")]).await;
    let (secret, id) = key(&server, "lab", "read submit admin", None).await;
    let authorization = format!("Bearer {secret}");
    let from = [JSON, ("authorization", authorization.as_str()), ("x-forwarded-for", "192.0.2.9")];
    let made = server.call(Method::POST, "/scenes", &from, r#"{"text":"a mug"}"#).await;
    assert_eq!(made.status, 202);
    assert_eq!(server.call(Method::GET, "/scenes", &from, "").await.status, 200);
    assert_eq!(server.call(Method::POST, "/scenes/validate", &from, r#"{"text":"a mug"}"#).await.status, 200);
    let job = made.json()["job"]["id"].as_str().unwrap().to_owned();
    let cancel = format!("/jobs/{job}/cancel");
    assert_eq!(server.call(Method::POST, &cancel, &from, "").await.status, 403);
    log_in(&server, &secret).await;
    server.call(Method::POST, "/scenes", &[JSON, ("authorization", "Bearer tt_wrong")], "{}").await;

    let entries = with(&server, Method::GET, "/audit", &secret, Value::Null).await.json();
    let facts: Vec<(String, String, u64)> = entries["entries"]
        .as_array()
        .unwrap()
        .iter()
        .map(|entry| {
            let text = |name: &str| entry[name].as_str().unwrap().to_owned();
            assert_eq!(text("tenant"), "lab");
            let actor = format!("{} {}", text("principal"), text("address"));
            (actor, format!("{} {}", text("action"), text("subject")), entry["status"].as_u64().unwrap())
        })
        .collect();
    let (key, session) = (format!("key:{id} 192.0.2.9"), format!("session:{id} 127.0.0.1"));
    let expected = [
        (session, "beginSession /session".to_owned(), 204),
        (key.clone(), format!("cancelJob {cancel}"), 403),
        (key, "submitScene /scenes".to_owned(), 202),
    ];
    assert_eq!(facts, expected);
    let operators =
        server.store().audit(&DEFAULT_TENANT, store::audit::AuditFilter { limit: 9, ..Default::default() });
    let operators = operators.await.unwrap();
    let last = &operators[0].entry;
    assert_eq!((last.principal.as_str(), last.status), ("anonymous", 401), "{operators:?}");

    let lines = with(&server, Method::GET, "/audit/lines", &secret, Value::Null).await;
    assert_eq!(lines.header("content-type"), "application/jsonl");
    let lines = String::from_utf8(lines.body.to_vec()).unwrap();
    let lines: Vec<Value> = lines.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    assert_eq!(json!(lines), entries["entries"]);
    let later = with(&server, Method::GET, "/audit?since=2100-01-01T00:00:00Z", &secret, Value::Null).await;
    assert_eq!(later.json()["entries"], json!([]));

    // What is refused is recorded up to a bound.
    for _ in 0..80 {
        server.call(Method::GET, "/jobs", &[("x-forwarded-for", "192.0.2.10")], "").await;
    }
    let filter = store::audit::AuditFilter { limit: 200, ..Default::default() };
    let rows = server.store().audit(&DEFAULT_TENANT, filter).await.unwrap();
    assert_eq!(rows.iter().filter(|row| row.entry.address == "192.0.2.10").count(), 60);
}
