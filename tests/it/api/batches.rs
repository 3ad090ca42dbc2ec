//! `/batches`: many requests at once, their results, and what stops them.

use std::collections::BTreeMap;
use std::time::Duration;

use hyper::Method;
use serde_json::{Value, json};

use crate::harness::script::{Act, Script};
use crate::harness::server::{Reply, Server};

const JSONL: &str = "application/jsonl";

/// A line of a batch.
fn line(custom_id: &str, text: &str, seed: u64) -> String {
    json!({ "custom_id": custom_id, "body": { "text": text, "seed": seed } }).to_string()
}

/// So many different requests, `r1`, `r2`, ...
fn lines(count: u64) -> String {
    (1..=count).map(|k| line(&format!("r{k}"), "a mug", k) + "\n").collect()
}

async fn send(server: &Server, query: &str, kind: &str, body: &str) -> Reply {
    let path = format!("/batches{query}");
    server.call(Method::POST, &path, &[("content-type", kind)], body.to_owned()).await
}

/// Submits lines; the id of the batch.
async fn submit(server: &Server, query: &str, body: &str) -> String {
    id_of(&send(server, query, JSONL, body).await)
}

fn id_of(reply: &Reply) -> String {
    assert_eq!(reply.status, 202, "{reply:?}");
    let id = reply.json()["id"].as_str().unwrap().to_owned();
    assert_eq!(reply.header("location"), format!("/batches/{id}"));
    id
}

async fn batch(server: &Server, id: &str) -> Value {
    server.get(&format!("/batches/{id}")).await.json()
}

/// Waits until a batch fulfils a condition; the batch.
async fn until(server: &Server, id: &str, what: &str, holds: impl Fn(&Value) -> bool) -> Value {
    let reached = async {
        loop {
            let batch = batch(server, id).await;
            if holds(&batch) {
                return batch;
            }
            tokio::time::sleep(Duration::from_millis(10)).await;
        }
    };
    let reached = tokio::time::timeout(Duration::from_secs(240), reached).await;
    match reached {
        Ok(batch) => batch,
        Err(_) => panic!("the batch never was {what}: {}", batch(server, id).await),
    }
}

async fn ends(server: &Server, id: &str) -> Value {
    until(server, id, "at its end", |batch| {
        ["finished", "cancelled"].contains(&batch["state"].as_str().unwrap())
    })
    .await
}

/// Counts that are not 0, without the total.
fn counts(batch: &Value) -> BTreeMap<String, u64> {
    let counts = batch["request_counts"].as_object().unwrap().iter();
    let counts = counts.map(|(name, count)| (name.clone(), count.as_u64().unwrap()));
    counts.filter(|(name, count)| name != "total" && *count > 0).collect()
}

fn expected<const N: usize>(counts: [(&str, u64); N]) -> BTreeMap<String, u64> {
    counts.into_iter().map(|(name, count)| (name.to_owned(), count)).collect()
}

/// The lines of `output` or `errors`.
async fn results(server: &Server, id: &str, which: &str) -> Vec<Value> {
    let reply = server.get(&format!("/batches/{id}/{which}")).await;
    assert_eq!((reply.status.as_u16(), reply.header("content-type")), (200, JSONL));
    let text = std::str::from_utf8(&reply.body).unwrap();
    text.lines().map(|line| serde_json::from_str(line).unwrap()).collect()
}

fn fields<'a>(results: &'a [Value], name: &str) -> Vec<&'a str> {
    results.iter().map(|line| line.pointer(name).and_then(Value::as_str).unwrap_or("")).collect()
}

#[tokio::test]
async fn every_request_becomes_a_scene_and_a_line_of_output() {
    let server = Server::start(&Script::new(&[])).await;
    let id = submit(&server, "?name=kitchens&budget_usd=7.5", &lines(5)).await;
    let batch = ends(&server, &id).await;
    assert_eq!((&batch["state"], &batch["name"]), (&json!("finished"), &json!("kitchens")));
    assert_eq!((counts(&batch), &batch["progress"]), (expected([("succeeded", 5)]), &json!(1.0)));
    assert_eq!(batch["request_counts"]["total"], 5);
    assert_eq!(batch["spending"], json!({ "budget_usd": 7.5, "spent_usd": 0.0, "reserved_usd": 0.0 }));
    assert!(batch["estimate"].is_null() && batch["finished_at"].is_string(), "{batch}");
    let output = results(&server, &id, "output").await;
    assert_eq!(fields(&output, "/custom_id"), ["r1", "r2", "r3", "r4", "r5"]);
    assert_eq!(fields(&output, "/verdict"), ["pass"; 5]);
    assert_eq!(results(&server, &id, "errors").await, Vec::<Value>::new());
    let bundle = server.get(output[0]["bundle"].as_str().unwrap()).await;
    assert_eq!((bundle.status.as_u16(), bundle.header("content-type")), (200, "application/zip"));
    let scene = server.get(&format!("/scenes/{}", output[2]["scene_id"].as_str().unwrap())).await.json();
    assert_eq!(scene["labels"], json!({ "batch": id, "custom_id": "r3" }));
    assert_eq!((&scene["seed"], &scene["request"]["input"]["text"]), (&json!(3), &json!("a mug")));

    let jobs = server.get(&format!("/jobs?batch={id}")).await.json();
    assert_eq!(jobs["jobs"].as_array().unwrap().len(), 5);
    server.submit("a bowl").await;
    let jobs = server.get(batch["links"]["jobs"].as_str().unwrap()).await.json();
    assert_eq!(jobs["jobs"].as_array().unwrap().len(), 5);
    let none = server.get("/jobs?batch=0192f3a4-5b6c-7d8e-9fa0-b1c2d3e4f5a6").await.json();
    assert_eq!(none["jobs"], json!([]));
}

#[tokio::test]
async fn a_malformed_line_is_reported_with_its_number_and_the_rest_goes_on() {
    let server = Server::start(&Script::new(&[])).await;
    let mut body: Vec<String> = (1..=520).map(|k| line(&format!("r{k}"), "a mug", k % 3)).collect();
    body[516] = "{\"custom_id\": \"r517\", \"body\": {\"text\": ".to_owned();
    body[517] = json!({ "custom_id": "r518", "body": { "text": "a mug", "seed": -1 } }).to_string();
    let id = submit(&server, "", &body.join("\n")).await;
    let batch = ends(&server, &id).await;
    assert_eq!(counts(&batch), expected([("succeeded", 3), ("duplicate", 515), ("invalid", 2)]));
    let errors = results(&server, &id, "errors").await;
    assert_eq!(fields(&errors, "/error/code"), ["malformed_json", "invalid_request"]);
    assert_eq!((&errors[0]["error"]["line"], &errors[1]["error"]["line"]), (&json!(517), &json!(518)));
    assert_eq!(errors[0]["error"]["column"], 39, "{}", errors[0]);
    assert_eq!((fields(&errors, "/custom_id"), errors[0]["custom_id"].is_null()), (vec!["", "r518"], true));
    assert_eq!(errors[1]["error"]["pointer"], "/body/seed");
    // Duplicates are found before the work, and name the request that has their scene.
    let output = results(&server, &id, "output").await;
    assert_eq!(output.len(), 518);
    let duplicate = output.iter().find(|line| line["custom_id"] == "r520").unwrap();
    assert_eq!((&duplicate["state"], &duplicate["duplicate_of"]), (&json!("duplicate"), &json!("r1")));
    assert_eq!(server.get("/scenes?page_size=200").await.json()["scenes"].as_array().unwrap().len(), 3);
}

#[tokio::test]
async fn lines_that_will_not_do_are_errors_with_pointers() {
    let server = Server::with(&Script::new(&[]), &[("server.max_text_chars", "200")]).await;
    let body = |body: Value| json!({ "custom_id": "x", "body": body }).to_string();
    let cases = [
        (line("a", "a mug", 1), "", "", ""),
        (line("a", "a bowl", 2), "duplicate_custom_id", "/custom_id", "line 1"),
        (line("../a", "a mug", 3), "invalid_request", "/custom_id", "letter"),
        (body(json!({})), "invalid_request", "/body", "`text`"),
        (body(json!({ "text": "x".repeat(201) })), "invalid_request", "/body/text", "201"),
        (
            body(json!({ "text": "a", "image": { "path": "/etc/passwd" } })),
            "invalid_request",
            "/body/image",
            "/scenes",
        ),
        (body(json!({ "text": "a", "colour": 1 })), "invalid_request", "/body/colour", "is not known here"),
        (
            body(json!({ "text": "a", "options": { "set": { "decompose.max_hulls": "0" } } })),
            "invalid_request",
            "/body/options/set/decompose.max_hulls",
            "1",
        ),
        (
            body(json!({ "text": "a", "labels": { "two words": "x" } })),
            "invalid_request",
            "/body/labels",
            "letters",
        ),
        (line("b", " a   mug", 1), "", "", ""),
    ];
    let text: Vec<&str> = cases.iter().map(|(line, ..)| line.as_str()).collect();
    let id = submit(&server, "", &text.join("\n")).await;
    let batch = ends(&server, &id).await;
    assert_eq!(counts(&batch), expected([("succeeded", 1), ("duplicate", 1), ("invalid", 8)]));
    let errors = results(&server, &id, "errors").await;
    let wrong = (1..).zip(&cases).filter(|(_, (_, code, ..))| !code.is_empty());
    for ((number, (line, code, pointer, says)), found) in wrong.zip(&errors) {
        let error = &found["error"];
        assert_eq!((&error["code"], &error["line"]), (&json!(code), &json!(number)), "{line}: {found}");
        assert_eq!(error["pointer"], *pointer, "{line}: {found}");
        assert!(error["message"].as_str().unwrap().contains(says), "{line}: {found}");
    }
}

#[tokio::test]
async fn a_recipe_expands_and_its_errors_have_pointers() {
    let server = Server::with(&Script::new(&[]), &[("batches.max_requests", "6")]).await;
    let recipe = json!({
        "templates": ["a {color} mug"], "slots": { "color": ["red", "blue"] }, "seeds": { "first": 0, "count": 2 },
        "labels": { "set": "a1" },
    });
    let send = async |recipe: &Value| send(&server, "", "application/json", &recipe.to_string()).await;
    let id = id_of(&send(&recipe).await);
    let batch = ends(&server, &id).await;
    assert_eq!(counts(&batch), expected([("succeeded", 4)]));
    let output = results(&server, &id, "output").await;
    assert_eq!(fields(&output, "/custom_id"), ["t0_red_s0", "t0_red_s1", "t0_blue_s0", "t0_blue_s1"]);
    let labelled = server.get("/scenes?label=set:a1").await.json();
    assert_eq!(labelled["scenes"].as_array().unwrap().len(), 4);

    let with = |name: &str, value: Value| {
        let mut recipe = recipe.clone();
        recipe[name] = value;
        recipe
    };
    for (recipe, pointer, says) in [
        (with("slots", json!({ "color": [] })), "/slots/color", "has no values"),
        (with("slots", json!({})), "/templates/0", "color"),
        (with("seeds", json!([1, 1])), "/seeds/1", "twice"),
        (with("seeds", json!({ "first": 0, "count": 4 })), "", "6 requests"),
        (with("options", json!([{}, { "set": { "tsa.scale": "AAA" } }])), "/options/1/set/tsa.scale", "AAA"),
        (with("options", json!({ "set": { "no.such": "1" } })), "/options/set/no.such", "no such key"),
        (with("colours", json!([])), "/colours", "is not known here"),
        (json!([]), "", "list"),
    ] {
        let reply = send(&recipe).await;
        assert_eq!(reply.problem(), (422, "invalid_body".into()), "{recipe}");
        let error = &reply.json()["errors"][0];
        assert_eq!(error["pointer"], pointer, "{recipe}: {error}");
        assert!(error["detail"].as_str().unwrap().contains(says), "{recipe}: {error}");
    }
    let listed = server.get("/batches").await.json();
    assert_eq!(listed["batches"].as_array().unwrap().len(), 1, "nothing of a refused batch stays");
}

#[tokio::test]
async fn bodies_that_are_no_batch_are_refused() {
    let server = Server::with(&Script::new(&[]), &[("batches.max_requests", "3")]).await;
    for (query, kind, body, problem) in [
        ("", "text/plain", "a mug".to_owned(), (415, "body_format")),
        ("", "application/json", "{\"templates\": [".to_owned(), (400, "malformed_json")),
        ("", JSONL, String::new(), (422, "invalid_body")),
        ("", JSONL, " \n\n".to_owned(), (422, "invalid_body")),
        ("", JSONL, lines(4), (422, "invalid_body")),
        ("?budget_usd=-1", JSONL, lines(1), (400, "invalid_parameter")),
        ("?name=", JSONL, lines(1), (400, "invalid_parameter")),
        ("?window=7", JSONL, lines(1), (400, "invalid_parameter")),
    ] {
        let reply = send(&server, query, kind, &body).await;
        assert_eq!(reply.problem(), (problem.0, problem.1.to_owned()), "{query} {kind} {body:?}");
    }
    assert_eq!(server.get("/batches").await.json()["batches"], json!([]));
    for path in ["/batches/none", "/batches/0192f3a4-5b6c-7d8e-9fa0-b1c2d3e4f5a6"] {
        assert_eq!(server.get(path).await.problem(), (404, "not_found".into()));
        for which in ["output", "errors"] {
            assert_eq!(server.get(&format!("{path}/{which}")).await.problem(), (404, "not_found".into()));
        }
        for what in ["cancel", "retry"] {
            let reply = server.call(Method::POST, &format!("{path}/{what}"), &[], "").await;
            assert_eq!(reply.problem(), (404, "not_found".into()));
        }
    }
}

#[tokio::test]
async fn results_are_there_while_a_batch_runs_and_a_cancellation_keeps_them() {
    // The first two requests are made; the others wait.
    let script = Script::new(&[]);
    let server = Server::with(&script, &[("batches.window", "2"), ("worker.concurrency", "1")]).await;
    let first = submit(&server, "", &lines(2)).await;
    ends(&server, &first).await;
    for _ in 0..10 {
        script.next("omega", Act::Wait);
    }
    let (done, waiting) = (lines(2), (3..=9).map(|k| line(&format!("w{k}"), "a bowl", k) + "\n"));
    let id = submit(&server, "", &(done + &waiting.collect::<String>())).await;
    // The same content was computed before, so the first two find their stages.
    let batch = until(&server, &id, "partly done", |batch| counts(batch).get("succeeded") == Some(&2)).await;
    assert_eq!(batch["state"], "running");
    assert!(
        batch["progress"].as_f64().is_some_and(|progress| (progress - 2.0 / 9.0).abs() < 1e-9),
        "{batch}"
    );
    let estimate = &batch["estimate"];
    assert!(estimate["time_left_s"].as_f64().unwrap() > 0.0 && estimate["finish_at"].is_string(), "{batch}");
    assert_eq!(fields(&results(&server, &id, "output").await, "/custom_id"), ["r1", "r2"]);
    let jobs = server.get(&format!("/jobs?batch={id}")).await.json();
    assert!(jobs["jobs"].as_array().unwrap().len() <= 4, "the rest is not in the queue yet");

    let cancelled = server.call(Method::POST, &format!("/batches/{id}/cancel"), &[], "").await;
    assert_eq!(cancelled.status, 202);
    let batch = ends(&server, &id).await;
    assert_eq!(
        (&batch["state"], counts(&batch)),
        (&json!("cancelled"), expected([("succeeded", 2), ("cancelled", 7)]))
    );
    let errors = results(&server, &id, "errors").await;
    assert_eq!(fields(&errors, "/error/code"), ["cancelled"; 7]);
    let again = server.call(Method::POST, &format!("/batches/{id}/cancel"), &[], "").await;
    assert_eq!(again.problem(), (409, "batch_already_ended".into()));

    script.open_gate();
    let retried = server.call(Method::POST, &format!("/batches/{id}/retry"), &[], "").await;
    assert_eq!((retried.status.as_u16(), retried.json()["state"].as_str()), (202, Some("running")));
    let batch = ends(&server, &id).await;
    assert_eq!((&batch["state"], counts(&batch)), (&json!("finished"), expected([("succeeded", 9)])));
    let states = server.get("/batches?state=finished&page_size=1").await.json();
    assert_eq!(states["batches"][0]["id"], id.as_str());
    assert!(states["next_page_token"].is_string());
}

#[tokio::test]
async fn a_retry_makes_what_failed_and_nothing_else() {
    let server = Server::start(&Script::new(&[("alpha", &[Act::Permanent, Act::Permanent])])).await;
    let id = submit(&server, "", &lines(4)).await;
    let batch = ends(&server, &id).await;
    assert_eq!(counts(&batch), expected([("failed", 2), ("succeeded", 2)]));
    let errors = results(&server, &id, "errors").await;
    assert_eq!(fields(&errors, "/error/code"), ["hopeless"; 2]);
    let failed: Vec<Value> = errors.iter().map(|line| line["scene_id"].clone()).collect();
    let retried = server.post(&format!("/batches/{id}/retry"), json!({})).await;
    assert_eq!(retried.status, 202, "{retried:?}");
    let batch = ends(&server, &id).await;
    assert_eq!(counts(&batch), expected([("succeeded", 4)]));
    let output = results(&server, &id, "output").await;
    assert_eq!(fields(&output, "/custom_id"), ["r1", "r2", "r3", "r4"]);
    assert!(failed.iter().all(|id| output.iter().any(|line| line["scene_id"] == *id)), "the scenes stay");
    assert_eq!(server.get("/scenes").await.json()["scenes"].as_array().unwrap().len(), 4);
    let again = server.post(&format!("/batches/{id}/retry"), json!({})).await;
    assert_eq!(again.problem(), (409, "nothing_to_retry".into()));
    let wrong = server.post(&format!("/batches/{id}/retry"), json!({ "budget_usd": -1 })).await;
    assert_eq!(wrong.problem(), (422, "invalid_body".into()));
}

#[tokio::test]
async fn what_the_budget_does_not_cover_fails_and_a_larger_one_makes_it() {
    // Something can cost money, so budgets count; the script spends none.
    let server = Server::with(&Script::new(&[]), &[("providers.analyst", "chat")]).await;
    let id = submit(&server, "?budget_usd=0", &lines(3)).await;
    let batch = ends(&server, &id).await;
    assert_eq!(counts(&batch), expected([("failed", 3)]));
    let errors = results(&server, &id, "errors").await;
    assert_eq!(fields(&errors, "/error/code"), ["batch_budget_spent"; 3]);
    assert_eq!(server.get("/scenes").await.json()["scenes"], json!([]), "nothing was begun");
    let retried = server.post(&format!("/batches/{id}/retry"), json!({ "budget_usd": 6 })).await;
    assert_eq!((retried.status.as_u16(), &retried.json()["spending"]["budget_usd"]), (202, &json!(6.0)));
    let batch = ends(&server, &id).await;
    assert_eq!(counts(&batch), expected([("succeeded", 3)]));
}

#[tokio::test]
async fn the_same_key_makes_one_batch() {
    let server = Server::start(&Script::new(&[])).await;
    let send = async |query: &str, body: String| {
        let headers = [("content-type", JSONL), ("idempotency-key", "k1")];
        server.call(Method::POST, &format!("/batches{query}"), &headers, body).await
    };
    let id = id_of(&send("", lines(2)).await);
    assert_eq!(id_of(&send("", lines(2)).await), id);
    assert_eq!(send("", lines(3)).await.problem(), (422, "idempotency_key_reused".into()));
    assert_eq!(send("?budget_usd=1", lines(2)).await.problem(), (422, "idempotency_key_reused".into()));
    assert_eq!(server.get("/batches").await.json()["batches"].as_array().unwrap().len(), 1);
}

#[tokio::test]
async fn a_batch_goes_on_after_a_restart() {
    let script = Script::new(&[]);
    for _ in 0..2 {
        script.next("omega", Act::Wait);
    }
    let set = [("batches.window", "2"), ("worker.drain_grace_secs", "0")];
    let server = Server::with(&script, &set).await;
    let id = submit(&server, "", &lines(8)).await;
    script.reaches("omega").await;
    let directory = server.stop().await;
    let server = Server::on(directory, &script, &set).await;
    script.open_gate();
    let batch = ends(&server, &id).await;
    assert_eq!(counts(&batch), expected([("succeeded", 8)]));
    assert_eq!(server.get("/scenes").await.json()["scenes"].as_array().unwrap().len(), 8, "none twice");
}

#[tokio::test]
async fn a_short_recipe_of_many_requests_gets_rows_as_it_is_fed() {
    const REQUESTS: u64 = 100_000;
    let limits = [("batches.window", "4"), ("queue.max_jobs", "10"), ("store.limits.waiting_jobs", "10")];
    let script = Script::new(&[]);
    for _ in 0..100 {
        script.next("omega", Act::Wait);
    }
    let server = Server::with(&script, &limits).await;
    let recipe = format!(r#"{{"templates":["a mug"],"seeds":{{"first":0,"count":{REQUESTS}}}}}"#);
    assert!(recipe.len() < 80, "{}", recipe.len());
    let id = id_of(&send(&server, "", "application/json", &recipe).await);
    let running =
        until(&server, &id, "being worked on", |batch| batch["request_counts"]["running"] != 0).await;
    let counted = running["request_counts"]["pending"].as_u64().unwrap()
        + running["request_counts"]["running"].as_u64().unwrap();
    assert_eq!((counted, &running["request_counts"]["total"]), (REQUESTS, &json!(REQUESTS)));
    let rest = server.store().recipe_to_expand(&id.parse().unwrap(), i64::MAX).await.unwrap().unwrap();
    assert!(rest.first_place <= 1001, "{} rows of a recipe of {} bytes", rest.first_place - 1, recipe.len());
    let cancelled = server.call(Method::POST, &format!("/batches/{id}/cancel"), &[], "").await;
    assert_eq!(cancelled.status, 202);
    let batch = ends(&server, &id).await;
    assert_eq!(counts(&batch), expected([("cancelled", REQUESTS)]));
    let errors = results(&server, &id, "errors").await;
    assert!(errors.len() <= 1000, "requests that never had a row are counted, not listed: {}", errors.len());
}

#[tokio::test]
async fn a_recipe_of_several_groups_is_made_whole_and_its_duplicates_are_found() {
    let limits = [("batches.window", "1000"), ("worker.concurrency", "8")];
    let server = Server::with(&Script::new(&[]), &limits).await;
    // The second template asks for what the first did, 550 requests later.
    let recipe = json!({ "templates": ["a mug", " a   mug"], "seeds": { "first": 0, "count": 550 } });
    let id = id_of(&send(&server, "", "application/json", &recipe.to_string()).await);
    assert_eq!(
        batch(&server, &id).await["request_counts"]["duplicate"],
        550,
        "known before the rows are there"
    );
    let batch = ends(&server, &id).await;
    assert_eq!(counts(&batch), expected([("succeeded", 550), ("duplicate", 550)]));
    let output = results(&server, &id, "output").await;
    let last = output.last().unwrap();
    assert_eq!((output.len(), &last["duplicate_of"]), (1100, &json!("t0_s549")));
}
