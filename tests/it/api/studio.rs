//! The page of the server, and the start of its interface.

use hyper::Method;

use crate::harness::script::Script;
use crate::harness::server::Server;

#[tokio::test]
async fn browsers_are_led_to_the_page_and_programs_to_the_interface() {
    let server = Server::start(&Script::new(&[])).await;
    let accept = [("accept", "text/html,application/xhtml+xml,*/*;q=0.8")];
    let browser = server.call(Method::GET, "/", &accept, "").await;
    assert_eq!((browser.status.as_u16(), browser.header("location")), (303, "/studio/"));
    let index = server.get("/").await;
    assert_eq!(index.header("vary"), "accept");
    let index = index.json();
    assert_eq!(
        (&index["name"], &index["version"]),
        (&"tabletopgen".into(), &env!("CARGO_PKG_VERSION").into())
    );
    for (name, path) in index["links"].as_object().unwrap() {
        let answer = server.get(path.as_str().unwrap()).await;
        assert_eq!(answer.status, 200, "{name}");
    }
}

#[tokio::test]
async fn the_page_is_for_everyone_and_may_do_little() {
    let keys = [("server.authentication.mode", "keys"), ("server.public_url", "https://scenes.example.org")];
    let server = Server::with(&Script::new(&[]), &keys).await;
    for path in ["/studio/", "/studio/index.html", "/studio/scenes/0192f3a4-5b6c-7d8e-9fa0-b1c2d3e4f5a6"] {
        let page = server.get(path).await;
        assert_eq!(
            (page.status.as_u16(), page.header("content-type")),
            (200, "text/html; charset=utf-8"),
            "{path}"
        );
        let policy = page.header("content-security-policy");
        assert!(policy.starts_with("default-src 'none'; script-src 'self';"), "{policy}");
        assert!(policy.ends_with("require-trusted-types-for 'script'; trusted-types studio"), "{policy}");
        for (name, value) in [
            ("cache-control", "no-cache"),
            ("vary", "accept-encoding"),
            ("x-content-type-options", "nosniff"),
            ("referrer-policy", "no-referrer"),
            ("cross-origin-opener-policy", "same-origin"),
            ("cross-origin-resource-policy", "same-origin"),
            ("strict-transport-security", "max-age=31536000"),
        ] {
            assert_eq!(page.header(name), value, "{path} {name}");
        }
        let known = [("if-none-match", page.header("etag"))];
        assert_eq!(server.call(Method::GET, path, &known, "").await.status, 304, "{path}");
    }
    for path in ["/studio/assets/missing-1a2b3c4d.js", "/studio/missing.png"] {
        assert_eq!(server.get(path).await.problem(), (404, "not_found".into()), "{path}");
    }
    let framed =
        [("sec-fetch-site", "cross-site"), ("sec-fetch-mode", "navigate"), ("sec-fetch-dest", "iframe")];
    assert_eq!(server.call(Method::GET, "/studio/", &framed, "").await.problem().1, "cross_site_request");
    assert_eq!(server.get("/scenes").await.problem().1, "credential_missing");
}
