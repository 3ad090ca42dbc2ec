//! Bundles and artifacts: whole, by format, in part, and not again.

use std::io::Cursor;

use hyper::Method;
use zip::ZipArchive;

use crate::harness::script::{Act, Script};
use crate::harness::server::Server;

fn names(archive: &[u8]) -> Vec<String> {
    let archive = ZipArchive::new(Cursor::new(archive)).expect("is an archive");
    let mut names: Vec<String> = archive.file_names().map(|name| name.unwrap().into_owned()).collect();
    names.sort();
    names
}

#[tokio::test]
async fn a_bundle_comes_whole_in_parts_or_not_again() {
    let server = Server::start(&Script::new(&[])).await;
    let (scene, job) = server.submit("a mug").await;
    server.job_is(&job, "succeeded").await;
    let path = format!("/scenes/{scene}/bundle");
    let whole = server.get(&path).await;
    assert_eq!((whole.status.as_u16(), whole.header("content-type")), (200, "application/zip"));
    assert_eq!(names(&whole.body).len(), 3);
    assert!(whole.header("content-disposition").contains(&format!("scene-{scene}.zip")));
    let etag = whole.header("etag").to_owned();
    assert!(etag.starts_with('"') && etag.len() == 66, "{etag}");

    for known in [etag.as_str(), "*", &format!("\"other\", W/{etag}")] {
        let again = server.call(Method::GET, &path, &[("if-none-match", known)], "").await;
        assert_eq!((again.status.as_u16(), again.body.len()), (304, 0), "{known}");
        assert_eq!(again.header("etag"), etag);
    }
    let other = server.call(Method::GET, &path, &[("if-none-match", "\"other\"")], "").await;
    assert_eq!(other.status, 200);
    let bytes = server.call(Method::GET, &path, &[("accept", "application/octet-stream")], "").await;
    assert_eq!((bytes.header("content-type"), &bytes.body), ("application/octet-stream", &whole.body));

    let half = whole.body.len() / 2;
    let first = server.call(Method::GET, &path, &[("range", &format!("bytes=0-{}", half - 1))], "").await;
    let headers = [("range", format!("bytes={half}-")), ("if-range", etag.clone())];
    let headers: Vec<(&str, &str)> = headers.iter().map(|(name, value)| (*name, value.as_str())).collect();
    let second = server.call(Method::GET, &path, &headers, "").await;
    assert_eq!((first.status.as_u16(), second.status.as_u16()), (206, 206));
    assert_eq!([&first.body[..], &second.body[..]].concat(), whole.body);
    let size = whole.body.len();
    assert_eq!(second.header("content-range"), format!("bytes {half}-{}/{size}", size - 1));
    let changed = [("range", "bytes=0-1"), ("if-range", "\"another\"")];
    assert_eq!(server.call(Method::GET, &path, &changed, "").await.status, 200);
    let outside = server.call(Method::GET, &path, &[("range", "bytes=99999999-")], "").await;
    assert_eq!(outside.problem(), (416, "range_not_satisfiable".into()));
    assert_eq!(outside.header("content-range"), format!("bytes */{size}"));
}

#[tokio::test]
async fn one_format_is_cut_from_the_whole() {
    let server = Server::start(&Script::new(&[])).await;
    let (scene, job) = server.submit("a mug").await;
    server.job_is(&job, "succeeded").await;
    let path = |format: &str| format!("/scenes/{scene}/bundle?format={format}");
    let mjcf = server.get(&path("mjcf")).await;
    assert_eq!(names(&mjcf.body), ["scene-5ce9e/mjcf/scene.xml", "scene-5ce9e/scene.json"]);
    assert_eq!(server.get(&path("mjcf")).await.header("etag"), mjcf.header("etag"));
    assert_eq!(server.get(&path("sdf")).await.problem(), (404, "format_not_in_bundle".into()));
    assert_eq!(server.get(&path("obj")).await.problem(), (400, "invalid_parameter".into()));
}

#[tokio::test]
async fn artifacts_are_there_as_soon_as_their_stage_is_finished() {
    let script = Script::new(&[("omega", &[Act::Wait])]);
    let server = Server::start(&script).await;
    let (scene, job) = server.submit("a mug").await;
    script.reaches("omega").await;
    let early = server.get(&format!("/scenes/{scene}/bundle")).await;
    assert_eq!(early.problem(), (409, "scene_not_ready".into()));
    let list = server.get(&format!("/scenes/{scene}/artifacts")).await.json();
    let found: Vec<&str> =
        list["artifacts"].as_array().unwrap().iter().map(|a| a["name"].as_str().unwrap()).collect();
    assert_eq!(found, ["alpha/note.txt", "beta/mug_1/note.txt", "beta/mug_2/note.txt"]);
    let url = list["artifacts"][1]["url"].as_str().unwrap();
    let note = server.get(url).await;
    assert_eq!((&note.body[..], note.header("content-type")), (&b"beta/mug_1 was here"[..], "text/plain"));
    assert_eq!(note.header("etag").trim_matches('"'), list["artifacts"][1]["sha256"].as_str().unwrap());
    assert_eq!(note.header("x-content-type-options"), "nosniff");
    assert!(note.header("content-security-policy").contains("sandbox"));
    let part = server.call(Method::GET, url, &[("range", "bytes=-4")], "").await;
    assert_eq!((part.status.as_u16(), &part.body[..]), (206, &b"here"[..]));
    assert_eq!(server.get(&format!("/scenes/{scene}/artifacts/alpha/none.txt")).await.problem().0, 404);
    assert_eq!(server.get(&format!("/scenes/{scene}/artifacts/..%2Flock")).await.problem().0, 404);
    script.open_gate();
    server.job_is(&job, "succeeded").await;
}

#[tokio::test]
async fn a_quarantined_bundle_is_given_only_on_request() {
    let server = Server::start(&Script::quarantining()).await;
    let (scene, job) = server.submit("a mug").await;
    server.job_is(&job, "succeeded").await;
    let view = server.get(&format!("/scenes/{scene}")).await.json();
    assert_eq!((view["state"].as_str(), view["verdict"].as_str()), (Some("failed"), Some("quarantine")));
    assert_eq!(view["failure"]["code"], "quarantined");
    assert!(view["failure"]["message"].as_str().unwrap().contains("mug_1 floats"));
    let path = format!("/scenes/{scene}/bundle");
    assert_eq!(server.get(&path).await.problem(), (409, "scene_quarantined".into()));
    assert_eq!(server.get(&format!("{path}?quarantined=true")).await.status, 200);
    assert_eq!(server.get(&format!("{path}?quarantined=maybe")).await.problem().0, 400);
}

#[tokio::test]
async fn a_failed_scene_has_no_bundle() {
    let server = Server::start(&Script::new(&[("beta", &[Act::Permanent])])).await;
    let (scene, job) = server.submit("a mug").await;
    let job = server.job_is(&job, "failed").await;
    assert_eq!(job["failure"]["code"], "hopeless");
    assert_eq!(server.get(&format!("/scenes/{scene}/bundle")).await.problem(), (409, "scene_failed".into()));
}
