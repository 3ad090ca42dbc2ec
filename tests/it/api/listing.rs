//! Lists and what is asked for by name: pages, filters, probes, strangers.

use std::time::Duration;

use hyper::Method;
use serde_json::{Value, json};

use crate::harness::script::{Act, Script};
use crate::harness::server::Server;

fn ids(page: &Value) -> Vec<String> {
    page["scenes"].as_array().unwrap().iter().map(|scene| scene["id"].as_str().unwrap().to_owned()).collect()
}

#[tokio::test]
async fn pages_hold_every_scene_once_newest_first() {
    let server = Server::start(&Script::new(&[])).await;
    let mut made = Vec::new();
    for index in 0..5 {
        let labels = json!({ "parity": if index % 2 == 0 { "even" } else { "odd" } });
        let reply = server.post("/scenes", json!({ "text": "a mug", "labels": labels })).await;
        made.push(reply.json()["id"].as_str().unwrap().to_owned());
    }
    made.reverse();
    let (mut seen, mut path, mut pages) = (Vec::new(), "/scenes?page_size=2".to_owned(), 0);
    loop {
        let page = server.get(&path).await.json();
        seen.extend(ids(&page));
        pages += 1;
        match page["next_page_token"].as_str() {
            Some(token) => path = format!("/scenes?page_size=2&page_token={token}"),
            None => break,
        }
    }
    assert_eq!((seen, pages), (made.clone(), 3));

    let odd = server.get("/scenes?label=parity:odd").await.json();
    assert_eq!(ids(&odd), [made[1].clone(), made[3].clone()]);
    assert_eq!(ids(&server.get("/scenes?label=parity:none").await.json()), Vec::<String>::new());
    assert_eq!(
        ids(&server.get("/scenes?created_after=2999-01-01T00:00:00Z").await.json()),
        Vec::<String>::new()
    );
    assert_eq!(ids(&server.get("/scenes?created_after=2020-01-01T00:00:00Z").await.json()), made);

    let deleted = server.call(Method::DELETE, &format!("/scenes/{}", made[0]), &[], "").await;
    assert_eq!(deleted.status, 204);
    assert_eq!(ids(&server.get("/scenes").await.json()), made[1..]);
    assert_eq!(ids(&server.get("/scenes?state=deleted").await.json()), made[..1]);
}

#[tokio::test]
async fn scenes_are_filtered_by_what_they_are_and_counted() {
    let server = Server::start(&Script::new(&[("beta", &[Act::Permanent])])).await;
    let mut scenes = Vec::new();
    for (text, set) in [("A red mug", "a"), ("Two blue bowls", "a"), ("A red bowl beside a vase", "b")] {
        let body = json!({ "text": text, "labels": { "set": set } });
        let scene = server.post("/scenes", body).await.json();
        server.job_ends(scene["job"]["id"].as_str().unwrap(), Duration::from_secs(20)).await;
        scenes.push(scene["id"].as_str().unwrap().to_owned());
    }
    // The first one has failed; of the others the script says that they have two objects.
    for (query, expected) in [
        ("sort=oldest", vec![0, 1, 2]),
        ("sort=newest&kind=text", vec![2, 1, 0]),
        ("q=RED", vec![2, 0]),
        ("q=red+bowl", vec![2]),
        ("verdict=pass", vec![2, 1]),
        ("verdict=quarantine", vec![]),
        ("kind=image", vec![]),
        ("min_objects=2&max_objects=2", vec![2, 1]),
        ("min_objects=3", vec![]),
        ("category=bowl", vec![2, 1]),
        ("category=bowl&label=set:b&q=vase&state=ready", vec![2]),
    ] {
        let found = ids(&server.get(&format!("/scenes?{query}")).await.json());
        assert_eq!(found, expected.iter().map(|index| scenes[*index].clone()).collect::<Vec<_>>(), "{query}");
        let filter = query.replace("sort=oldest", "").replace("sort=newest&", "");
        let facets = server.get(&format!("/scenes/facets?{filter}")).await.json();
        assert_eq!(facets["total"], expected.len(), "{query}");
    }
    let facets = server.get("/scenes/facets").await.json();
    assert_eq!(
        facets,
        json!({
            "total": 3,
            "state": { "ready": 2, "failed": 1 },
            "verdict": { "pass": 2 },
            "kind": { "text": 3 },
            "category": { "bowl": 2, "mug": 2 },
            "label": { "set=a": 2, "set=b": 1 },
        })
    );
    let first = server.get("/scenes?sort=oldest&page_size=2").await.json();
    let token = first["next_page_token"].as_str().unwrap();
    let second = server.get(&format!("/scenes?sort=oldest&page_size=2&page_token={token}")).await.json();
    assert_eq!([ids(&first), ids(&second)].concat(), scenes);
}

/// Ids of a page of jobs.
fn job_ids(page: &Value) -> Vec<String> {
    page["jobs"].as_array().unwrap().iter().map(|job| job["id"].as_str().unwrap().to_owned()).collect()
}

#[tokio::test]
async fn jobs_are_listed_by_page_state_kind_scene_and_time() {
    let server = Server::start(&Script::new(&[("beta", &[Act::Permanent])])).await;
    let mut jobs = Vec::new();
    for text in ["a mug", "a bowl", "a vase"] {
        jobs.push(server.submit(text).await.1);
    }
    for job in &jobs {
        server.job_ends(job, Duration::from_secs(20)).await;
    }
    // One of them failed, whichever came to the stage first; its scene gets another job.
    let failed = job_ids(&server.get("/jobs?state=failed").await.json());
    assert_eq!(failed.len(), 1);
    let path = format!("/jobs/{}/retry", failed[0]);
    let retry = server.call(Method::POST, &path, &[], "").await.json()["id"].as_str().unwrap().to_owned();
    let scene = server.job_is(&retry, "succeeded").await["scene_id"].as_str().unwrap().to_owned();
    jobs.push(retry.clone());
    jobs.reverse();

    let (mut seen, mut path, mut pages) = (Vec::new(), "/jobs?page_size=3".to_owned(), 0);
    loop {
        let page = server.get(&path).await.json();
        seen.extend(job_ids(&page));
        pages += 1;
        match page["next_page_token"].as_str() {
            Some(token) => path = format!("/jobs?page_size=3&page_token={token}"),
            None => break,
        }
    }
    assert_eq!((seen, pages), (jobs.clone(), 2));
    let listed = async |query: &str| job_ids(&server.get(&format!("/jobs?{query}")).await.json());
    assert_eq!(listed("state=succeeded").await.len(), 3);
    assert_eq!(listed("kind=retry").await, std::slice::from_ref(&retry));
    assert_eq!(listed("kind=generate&state=failed").await, failed);
    assert_eq!(listed(&format!("scene={scene}")).await, [retry, failed[0].clone()]);
    assert_eq!(listed("created_after=2999-01-01T00:00:00Z").await, Vec::<String>::new());
    assert_eq!(listed("created_after=2020-01-01T00:00:00Z").await, jobs);
}

#[tokio::test]
async fn queued_jobs_have_a_place_and_once_durations_are_known_an_estimate() {
    let before = Server::start(&Script::new(&[])).await;
    let (_, first) = before.submit("a mug").await;
    let ended = before.job_is(&first, "succeeded").await;
    assert!(ended.get("queue_position").is_none() && ended.get("estimated_finish_at").is_none(), "{ended}");
    let script = Script::new(&[("alpha", &[Act::Wait])]);
    let server = Server::on(before.stop().await, &script, &[("worker.concurrency", "1")]).await;
    let mut jobs = Vec::new();
    for text in ["a bowl", "a vase", "a jug"] {
        jobs.push(server.submit(text).await.1);
    }
    let running = server.job_is(&jobs[0], "running").await;
    assert!(running.get("queue_position").is_none(), "{running}");
    let places = [Value::Null, json!(1), json!(2)];
    let mut ends = Vec::new();
    for (job, place) in jobs.iter().zip(places) {
        let job = server.get(&format!("/jobs/{job}")).await.json();
        assert_eq!(job.get("queue_position").cloned().unwrap_or_default(), place, "{job}");
        ends.push(job["estimated_finish_at"].as_str().expect("one job has ended").to_owned());
    }
    // The times have one form, so that they compare as texts do.
    assert!(ends[1] <= ends[2], "{ends:?}");
    let page = server.get("/jobs?state=queued").await.json();
    let listed: Vec<&Value> =
        page["jobs"].as_array().unwrap().iter().map(|job| &job["queue_position"]).collect();
    assert_eq!(listed, [&json!(2), &json!(1)]);
    script.open_gate();
    for job in &jobs {
        server.job_is(job, "succeeded").await;
    }
}

#[tokio::test]
async fn parameters_that_mean_nothing_are_refused() {
    let server = Server::start(&Script::new(&[])).await;
    for path in [
        "/scenes?page_size=0",
        "/scenes?page_size=201",
        "/scenes?page_size=x",
        "/scenes?page_token=abc",
        "/scenes?state=broken",
        "/scenes?label=nocolon",
        "/scenes?created_after=yesterday",
        "/scenes?colour=red",
        "/scenes?state=ready&state=failed",
        "/scenes?parent=none",
        "/scenes?verdict=ready",
        "/scenes?kind=video",
        "/scenes?q=",
        "/scenes?category=",
        "/scenes?min_objects=few",
        "/scenes?sort=best",
        "/scenes/facets?page_size=5",
        "/scenes/facets?sort=newest",
        "/jobs?page_size=0",
        "/jobs?page_token=abc",
        "/jobs?state=ready",
        "/jobs?kind=edit",
        "/jobs?scene=none",
        "/jobs?created_after=yesterday",
        "/jobs?colour=red",
    ] {
        assert_eq!(server.get(path).await.problem(), (400, "invalid_parameter".into()), "{path}");
    }
}

#[tokio::test]
async fn what_is_not_there_is_said_to_be_not_there() {
    let server = Server::start(&Script::new(&[])).await;
    for path in [
        "/scenes/none",
        "/scenes/none/bundle",
        "/scenes/none/artifacts",
        "/scenes/none/artifacts/a/b.json",
        "/jobs/none",
        "/jobs/none/stages",
        "/jobs/none/events",
        "/nowhere",
        "/scenes/none/",
    ] {
        assert_eq!(server.get(path).await.problem().0, 404, "{path}");
    }
    for path in ["/jobs/none/cancel", "/jobs/none/retry"] {
        assert_eq!(server.call(Method::POST, path, &[], "").await.problem().0, 404, "{path}");
    }
    assert_eq!(server.call(Method::DELETE, "/scenes/none", &[], "").await.problem().0, 404);
    let wrong = server.call(Method::PUT, "/scenes", &[], "").await;
    assert_eq!(wrong.problem(), (405, "method_not_allowed".into()));
    assert!(!wrong.header("allow").is_empty());
}

#[tokio::test]
async fn probes_metrics_version_and_the_document() {
    let script = Script::new(&[("alpha", &[Act::Wait])]);
    let server = Server::start(&script).await;
    let (_, job) = server.submit("a mug").await;
    assert_eq!(server.get("/healthz").await.json(), json!({ "status": "ok" }));
    assert_eq!(server.get("/readyz").await.json(), json!({ "status": "ready" }));
    let version = server.get("/version").await.json();
    assert_eq!(
        (&version["name"], &version["version"]),
        (&json!("tabletopgen"), &json!(env!("CARGO_PKG_VERSION")))
    );
    // Whether the page was built before the program.
    assert!(version["studio"].is_boolean(), "{version}");
    let document = server.get("/openapi.yaml").await;
    assert!(document.body.starts_with(b"openapi: 3.1"));
    script.open_gate();
    server.job_is(&job, "succeeded").await;
    let metrics = String::from_utf8(server.get("/metrics").await.body.to_vec()).unwrap();
    for name in ["tabletopgen_jobs{state=\"queued\"}", "tabletopgen_http_requests_total"] {
        assert!(metrics.contains(name), "{name} is missing in {metrics}");
    }
    let id = server.call(Method::GET, "/healthz", &[("x-request-id", "mine-1")], "").await;
    assert_eq!(id.header("x-request-id"), "mine-1");
    let id = server.call(Method::GET, "/healthz", &[("x-request-id", "not mine; drop table")], "").await;
    assert_ne!(id.header("x-request-id"), "not mine; drop table");
}
