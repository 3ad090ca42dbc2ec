//! `/studio/`: the page of the server. The program holds its files, which `make studio` makes and `build.rs` lists.
//!
//! Addresses of the page itself are not files: each is answered with the shell, which holds no data and is for
//! everyone. The shell asks the interface for what it shows, as the principal who is logged in. A file below `assets/`
//! has a digest in its name and never changes; one that is not there is 404 and never the shell, which a browser would
//! take for a script.

use std::sync::OnceLock;

use axum::http::header::{self, HeaderName};
use axum::http::{HeaderMap, HeaderValue, StatusCode};
use axum::response::{IntoResponse, Redirect, Response};

use axum::extract::State;

use super::Api;
use super::download::has_tag;
use super::extract::PathName;
use crate::problem::Problem;
use store::Digest;

// The files of the page by path, `FILES`; none where the program was built without it.
include!(concat!(env!("OUT_DIR"), "/studio_files.rs"));

/// The shell.
const SHELL: &str = "index.html";

/// In its place in a program without the page.
static NOT_BUILT: File = File {
    path: SHELL,
    plain: Some(Form::new(
        b"<!doctype html><html lang=\"en\"><title>tabletopgen</title><h1>This program was built without its page</h1>\
          <p>Run <code>make studio</code> (Node 20.19 or later), then build it again. The interface works without: \
          <a href=\"/openapi.yaml\">openapi.yaml</a> describes it.</p></html>\n",
    )),
    gzip: None,
    brotli: None,
};

/// Policy of the page: it runs its own scripts, and shows images and media of its own or that it made itself.
const PAGE_POLICY: &str = "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' blob: data:; \
    connect-src 'self' blob:; media-src 'self' blob:; worker-src 'self'; frame-src 'self'; font-src 'self'; \
    manifest-src 'self'; form-action 'self'; base-uri 'none'; frame-ancestors 'none'; \
    require-trusted-types-for 'script'; trusted-types studio";

/// Policy of the worker with the physics engine. The engine's glue makes functions from text, which the page may not; a
/// worker that is fetched has the policy of the answer that it came with.
const PHYSICS_POLICY: &str =
    "default-src 'none'; script-src 'self' 'unsafe-eval' 'wasm-unsafe-eval'; connect-src 'self'";

/// Start of the names of scripts of that worker.
const PHYSICS_WORKER: &str = "physics-worker";

/// A file of the page, in the forms that are held.
struct File {
    /// Below the folder of the page.
    path: &'static str,
    plain: Option<Form>,
    gzip: Option<Form>,
    brotli: Option<Form>,
}

/// Bytes of a file in one content coding.
struct Form {
    bytes: &'static [u8],
    tag: OnceLock<String>,
}

impl Form {
    const fn new(bytes: &'static [u8]) -> Self {
        Self { bytes, tag: OnceLock::new() }
    }

    /// SHA-256 of the bytes, quoted.
    fn tag(&self) -> &str {
        self.tag.get_or_init(|| format!("\"{}\"", Digest::of(self.bytes)))
    }
}

/// Whether the program has the page.
pub fn is_built() -> bool {
    !FILES.is_empty()
}

/// `GET /studio`.
pub async fn enter() -> Response {
    Redirect::permanent("/studio/").into_response()
}

/// `GET /studio/`.
pub async fn start(State(api): State<Api>, headers: HeaderMap) -> Result<Response, Problem> {
    show(State(api), PathName(String::new()), headers).await
}

/// `GET /studio/{*name}`.
pub async fn show(
    State(api): State<Api>,
    PathName(path): PathName,
    headers: HeaderMap,
) -> Result<Response, Problem> {
    let file = find(&FILES, &path).ok_or_else(|| Problem::not_found("file of the page", &path))?;
    let mut response = respond(file, &headers);
    if api.settings.public_url.starts_with("https:") {
        let year = HeaderValue::from_static("max-age=31536000");
        response.headers_mut().insert(header::STRICT_TRANSPORT_SECURITY, year);
    }
    Ok(response)
}

/// The file of a path, or the shell for an address of the page.
fn find(files: &'static [File], path: &str) -> Option<&'static File> {
    let named = |wanted: &str| files.iter().find(|file| file.path == wanted);
    let is_file = path != SHELL && (path.starts_with("assets/") || path.contains('.'));
    named(path).or_else(|| if is_file { None } else { Some(named(SHELL).unwrap_or(&NOT_BUILT)) })
}

fn respond(file: &'static File, headers: &HeaderMap) -> Response {
    let Some((coding, form)) = file.form(headers) else {
        return Problem::not_found("file of the page", file.path).into_response();
    };
    let name = file.path.rsplit('/').next().unwrap_or_default();
    let policy = if name.starts_with(PHYSICS_WORKER) { PHYSICS_POLICY } else { PAGE_POLICY };
    let lifetime = match file.path.starts_with("assets/") {
        true => "public, max-age=31536000, immutable",
        false => "no-cache",
    };
    let mut fields = HeaderMap::new();
    for (name, value) in [
        (header::CACHE_CONTROL, lifetime),
        (header::VARY, "accept-encoding"),
        (header::CONTENT_SECURITY_POLICY, policy),
        (header::REFERRER_POLICY, "no-referrer"),
        (HeaderName::from_static("cross-origin-opener-policy"), "same-origin"),
        (HeaderName::from_static("cross-origin-resource-policy"), "same-origin"),
        (HeaderName::from_static("permissions-policy"), "camera=(), microphone=(), geolocation=()"),
    ] {
        fields.insert(name, HeaderValue::from_static(value));
    }
    let tag = form.tag();
    if let Ok(tag) = HeaderValue::from_str(tag) {
        fields.insert(header::ETAG, tag);
    }
    if has_tag(headers, header::IF_NONE_MATCH, tag) {
        return (StatusCode::NOT_MODIFIED, fields).into_response();
    }
    fields.insert(header::CONTENT_TYPE, HeaderValue::from_static(media_type(file.path)));
    if !coding.is_empty() {
        fields.insert(header::CONTENT_ENCODING, HeaderValue::from_static(coding));
    }
    (fields, form.bytes).into_response()
}

impl File {
    /// The smallest form that the client takes, with its coding. A file that is held compressed alone is sent so to
    /// clients that do not ask for it, too.
    fn form(&'static self, headers: &HeaderMap) -> Option<(&'static str, &'static Form)> {
        let with = |coding: &'static str, form: &'static Option<Form>| Some((coding, form.as_ref()?));
        let wanted = |coding: &str| takes(headers, coding);
        let (brotli, gzip) = (with("br", &self.brotli), with("gzip", &self.gzip));
        let accepted = brotli.filter(|_| wanted("br")).or(gzip.filter(|_| wanted("gzip")));
        accepted.or(with("", &self.plain)).or(gzip).or(brotli)
    }
}

/// Whether a client takes a content coding.
fn takes(headers: &HeaderMap, coding: &str) -> bool {
    let lists = headers.get_all(header::ACCEPT_ENCODING).into_iter().filter_map(|value| value.to_str().ok());
    lists.flat_map(|list| list.split(',')).any(|item| {
        let (name, weight) = item.split_once(';').unwrap_or((item, ""));
        let weight = weight.trim().strip_prefix("q=").and_then(|weight| weight.parse::<f32>().ok());
        name.trim().eq_ignore_ascii_case(coding) && weight.is_none_or(|weight| weight > 0.0)
    })
}

/// The media type by the ending of a name.
fn media_type(path: &str) -> &'static str {
    match path.rsplit('.').next().unwrap_or_default() {
        "html" => "text/html; charset=utf-8",
        "js" | "mjs" => "text/javascript; charset=utf-8",
        "css" => "text/css; charset=utf-8",
        "wasm" => "application/wasm",
        "json" | "map" => "application/json",
        "webmanifest" => "application/manifest+json",
        "svg" => "image/svg+xml",
        "png" => "image/png",
        "webp" => "image/webp",
        "jpg" | "jpeg" => "image/jpeg",
        "ico" => "image/x-icon",
        "woff2" => "font/woff2",
        "txt" => "text/plain; charset=utf-8",
        _ => "application/octet-stream",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    static SOME: [File; 5] = [
        File {
            path: "assets/app-1a.js",
            plain: Some(Form::new(b"plain")),
            gzip: Some(Form::new(b"gzip")),
            brotli: Some(Form::new(b"br")),
        },
        File {
            path: "assets/physics-worker-2b.js",
            plain: Some(Form::new(b"work")),
            gzip: None,
            brotli: None,
        },
        File { path: "assets/engine-3c.wasm", plain: None, gzip: Some(Form::new(b"gzip")), brotli: None },
        File { path: "index.html", plain: Some(Form::new(b"shell")), gzip: None, brotli: None },
        File { path: "icon.svg", plain: Some(Form::new(b"<svg/>")), gzip: None, brotli: None },
    ];

    fn accepting(codings: &'static str) -> HeaderMap {
        HeaderMap::from_iter([(header::ACCEPT_ENCODING, HeaderValue::from_static(codings))])
    }

    #[test]
    fn addresses_of_the_page_are_the_shell_and_missing_files_are_not() {
        for (path, expected) in [
            ("", Some("index.html")),
            ("scenes/0192f3a4-5b6c-7d8e-9fa0-b1c2d3e4f5a6", Some("index.html")),
            ("index.html", Some("index.html")),
            ("icon.svg", Some("icon.svg")),
            ("assets/app-1a.js", Some("assets/app-1a.js")),
            ("assets/app-old.js", None),
            ("assets/app", None),
            ("favicon.ico", None),
            ("../Cargo.toml", None),
        ] {
            assert_eq!(find(&SOME, path).map(|file| file.path), expected, "{path:?}");
        }
        assert_eq!(find(&[], "scenes").map(|file| file.path), Some(SHELL));
    }

    #[test]
    fn the_smallest_form_that_a_client_takes_is_sent() {
        for (accepted, path, coding) in [
            ("gzip, deflate, br, zstd", "assets/app-1a.js", "br"),
            ("gzip, deflate", "assets/app-1a.js", "gzip"),
            ("br;q=0, GZIP;q=0.5", "assets/app-1a.js", "gzip"),
            ("identity", "assets/app-1a.js", ""),
            ("br", "assets/physics-worker-2b.js", ""),
            ("identity", "assets/engine-3c.wasm", "gzip"),
        ] {
            let file = find(&SOME, path).expect("a file");
            let response = respond(file, &accepting(accepted));
            let sent = response
                .headers()
                .get(header::CONTENT_ENCODING)
                .map_or("", |value| value.to_str().expect("ASCII"));
            assert_eq!(sent, coding, "{accepted:?} {path}");
            assert_eq!(response.headers()[header::VARY], "accept-encoding");
        }
    }

    #[test]
    fn each_form_has_its_tag_and_assets_never_change() {
        let app = find(&SOME, "assets/app-1a.js").expect("a file");
        let first = respond(app, &accepting("br"));
        let tag = first.headers()[header::ETAG].clone();
        assert_ne!(respond(app, &accepting("gzip")).headers()[header::ETAG], tag);
        assert_eq!(first.headers()[header::CACHE_CONTROL], "public, max-age=31536000, immutable");
        let mut again = accepting("br");
        again.insert(header::IF_NONE_MATCH, tag);
        assert_eq!(respond(app, &again).status(), StatusCode::NOT_MODIFIED);
        let shell = respond(find(&SOME, "").expect("a file"), &HeaderMap::new());
        assert_eq!(shell.headers()[header::CACHE_CONTROL], "no-cache");
        assert_eq!(shell.headers()[header::CONTENT_TYPE], "text/html; charset=utf-8");
    }

    #[test]
    fn only_the_worker_with_the_engine_may_make_functions_from_text() {
        for (path, may) in [("assets/physics-worker-2b.js", true), ("assets/app-1a.js", false), ("", false)] {
            let response = respond(find(&SOME, path).expect("a file"), &HeaderMap::new());
            let policy = response.headers()[header::CONTENT_SECURITY_POLICY].to_str().expect("ASCII");
            assert_eq!(policy.contains("'unsafe-eval'"), may, "{path:?}");
        }
    }
}
