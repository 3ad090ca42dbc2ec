//! The files of a bundle, one by one, and the small image of a scene.

use hyper::Method;
use serde_json::Value;

use crate::harness::script::{Act, Script};
use crate::harness::server::{Server, settings};
use crate::harness::tiny_bundle;

/// A server whose scenes are tiny bundles, and the id of one with this text.
async fn with_scene(text: &str) -> (Server, String) {
    let server = Server::building(tiny_bundle::build(), &settings(&[])).await;
    let (scene, job) = server.submit(text).await;
    server.job_is(&job, "succeeded").await;
    (server, scene)
}

#[tokio::test]
async fn files_of_a_bundle_are_listed_and_read_whole_and_in_part() {
    let (server, scene) = with_scene("a mug").await;
    let list = server.get(&format!("/scenes/{scene}/files")).await.json();
    let files = list["files"].as_array().unwrap();
    let names: Vec<&str> = files.iter().map(|file| file["name"].as_str().unwrap()).collect();
    assert!(
        names.is_sorted() && names.contains(&"scene.json") && names.contains(&"glb/mug_1.glb"),
        "{names:?}"
    );
    for file in files {
        let link = file["link"].as_str().unwrap();
        let whole = server.get(link).await;
        assert_eq!(whole.status, 200, "{link}");
        assert_eq!(whole.body.len() as u64, file["size_bytes"].as_u64().unwrap(), "{link}");
        assert_eq!(whole.header("content-type"), file["media_type"].as_str().unwrap(), "{link}");
        let tag = format!("\"{}\"", file["sha256"].as_str().unwrap());
        assert_eq!(whole.header("etag"), tag, "{link}");
        assert_eq!(
            whole.header("content-security-policy").contains("frame-ancestors"),
            link.ends_with("/report.html")
        );
        let again = server.call(Method::GET, link, &[("if-none-match", &tag)], "").await;
        assert_eq!((again.status.as_u16(), again.body.len()), (304, 0), "{link}");
    }
    let scene_json = format!("/scenes/{scene}/files/scene.json");
    let whole: Value = server.get(&scene_json).await.json();
    assert_eq!(whole["instances"][0]["name"], "mug_1");
    let part = server.call(Method::GET, &scene_json, &[("range", "bytes=-1")], "").await;
    assert_eq!((part.status.as_u16(), &part.body[..]), (206, &b"}"[..]));
    let encoded = server.get(&format!("/scenes/{scene}/files/glb%2Fmug_1.glb")).await;
    assert!(encoded.body.starts_with(b"a mug of"));
    for name in ["none.json", "..%2Fscene.json", "mug_1.glb"] {
        let path = format!("/scenes/{scene}/files/{name}");
        assert_eq!(server.get(&path).await.problem(), (404, "not_found".into()), "{name}");
    }
}

#[tokio::test]
async fn a_report_may_be_framed_by_the_page_and_runs_nothing() {
    let (server, scene) = with_scene("a mug").await;
    let report = server.get(&format!("/scenes/{scene}/files/report.html")).await;
    assert_eq!(
        report.header("content-security-policy"),
        "sandbox; default-src 'none'; img-src data:; style-src 'unsafe-inline'; frame-ancestors 'self'"
    );
    assert_eq!(report.header("content-type"), "text/html");
    let other = server.get(&format!("/scenes/{scene}/files/report.json")).await;
    assert_eq!(other.header("content-security-policy"), "sandbox; default-src 'none'");
}

#[tokio::test]
async fn files_of_a_quarantined_scene_are_given_only_on_request() {
    let (server, scene) = with_scene("a mug for quarantine").await;
    let path = format!("/scenes/{scene}/files");
    assert_eq!(server.get(&path).await.problem(), (409, "scene_quarantined".into()));
    assert_eq!(server.get(&format!("{path}/scene.json")).await.problem(), (409, "scene_quarantined".into()));
    let list = server.get(&format!("{path}?quarantined=true")).await.json();
    for file in list["files"].as_array().unwrap() {
        assert_eq!(server.get(file["link"].as_str().unwrap()).await.status, 200);
    }
}

#[tokio::test]
async fn a_preview_is_a_small_image_of_the_width_that_is_asked_for() {
    let (server, scene) = with_scene("a rendered mug").await;
    let path = format!("/scenes/{scene}/preview");
    let mut tags = Vec::new();
    for (query, size) in [("", (320, 240)), ("?width=160", (160, 120)), ("?width=640", (640, 480))] {
        let preview = server.get(&format!("{path}{query}")).await;
        assert_eq!((preview.status.as_u16(), preview.header("content-type")), (200, "image/jpeg"), "{query}");
        let image = image::load_from_memory(&preview.body).expect("is an image").to_rgb8();
        assert_eq!(image.dimensions(), size, "{query}");
        // The left half of the render is red, the right one blue.
        let (width, height) = size;
        let (left, right) =
            (image.get_pixel(width / 4, height / 2), image.get_pixel(3 * width / 4, height / 2));
        assert!(left[0] > 200 && left[2] < 60 && right[0] < 60 && right[2] > 200, "{left:?} {right:?}");
        assert!(preview.header("cache-control").starts_with("private, max-age="));
        let tag = preview.header("etag").to_owned();
        let again = server.call(Method::GET, &format!("{path}{query}"), &[("if-none-match", &tag)], "").await;
        assert_eq!(again.status, 304, "{query}");
        tags.push(tag);
    }
    tags.dedup();
    assert_eq!(tags.len(), 3);
    assert_eq!(server.get(&format!("{path}?width=321")).await.problem(), (400, "invalid_parameter".into()));
}

#[tokio::test]
async fn a_scene_without_a_render_has_no_preview() {
    let script = Script::new(&[("omega", &[Act::Wait])]);
    let server = Server::start(&script).await;
    let (scene, job) = server.submit("a mug").await;
    script.reaches("omega").await;
    let path = format!("/scenes/{scene}/preview");
    assert_eq!(server.get(&path).await.problem(), (404, "not_found".into()));
    script.open_gate();
    server.job_is(&job, "succeeded").await;
    assert_eq!(server.get(&path).await.problem(), (404, "not_found".into()));
}
