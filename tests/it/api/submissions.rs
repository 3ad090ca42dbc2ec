//! `POST /scenes`: what is accepted, once; and what is refused, with advice, leaving nothing behind.

use std::collections::BTreeSet;
use std::io::Cursor;

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use hyper::Method;
use serde_json::{Value, json};

use crate::harness::script::Script;
use crate::harness::server::Server;

/// An image file of this size.
fn png(width: u32, height: u32) -> Vec<u8> {
    let mut bytes = Cursor::new(Vec::new());
    let image = image::RgbImage::from_fn(width, height, |x, y| image::Rgb([x as u8, y as u8, 90]));
    image.write_to(&mut bytes, image::ImageFormat::Png).expect("encodes");
    bytes.into_inner()
}

/// A small PNG file whose header claims another size.
fn claiming(width: u32, height: u32) -> Vec<u8> {
    let mut bytes = png(64, 64);
    bytes[16..20].copy_from_slice(&width.to_be_bytes());
    bytes[20..24].copy_from_slice(&height.to_be_bytes());
    // CRC-32 of the chunk (PNG 1.2, appendix D).
    let checksum = !bytes[12..29].iter().fold(!0, |sum: u32, byte| {
        (0..8).fold(sum ^ u32::from(*byte), |sum, _| (sum >> 1) ^ (0xedb8_8320 & (sum & 1).wrapping_neg()))
    });
    bytes[29..33].copy_from_slice(&checksum.to_be_bytes());
    bytes
}

/// A multipart body of named fields, and its content type.
fn form(fields: &[(&str, &[u8])]) -> (String, Vec<u8>) {
    let mut body = Vec::new();
    for (name, value) in fields {
        let head =
            format!("--cut\r\ncontent-disposition: form-data; name=\"{name}\"; filename=\"f\"\r\n\r\n");
        body.extend([head.as_bytes(), value, b"\r\n"].concat());
    }
    body.extend(b"--cut--\r\n");
    ("multipart/form-data; boundary=cut".into(), body)
}

#[tokio::test]
async fn a_text_becomes_a_scene() {
    let server = Server::start(&Script::new(&[])).await;
    let body = json!({
        "text": "  two mugs on a round table ", "labels": { "set": "a1" },
        "options": { "table": { "shape": "round" }, "set": { "decompose.max_hulls": "24" } },
    });
    let reply = server.post("/scenes", body).await;
    assert_eq!(reply.status, 202);
    let scene = reply.json();
    let id = scene["id"].as_str().unwrap();
    assert_eq!(reply.header("location"), format!("/scenes/{id}"));
    assert_eq!(scene["request"]["input"]["text"], "two mugs on a round table");
    assert_eq!(scene["request"]["options"]["set"]["decompose.max_hulls"], "24");
    assert!(scene["seed"].as_u64().is_some_and(|seed| seed < 1 << 53), "a seed is drawn and told");
    let job = scene["job"]["id"].as_str().unwrap();
    server.job_is(job, "succeeded").await;
    let scene = server.get(&format!("/scenes/{id}")).await.json();
    assert_eq!((&scene["state"], &scene["verdict"]), (&json!("ready"), &json!("pass")));
    assert_eq!(scene["stages"].as_array().unwrap().len(), 4);
    assert_eq!(scene["labels"], json!({ "set": "a1" }));
}

#[tokio::test]
async fn image_is_accepted_as_file_or_base64() {
    let server = Server::start(&Script::new(&[])).await;
    let image = png(240, 180);
    let (kind, body) = form(&[("image", &image), ("request", br#"{"seed": 3}"#)]);
    let by_file = server.call(Method::POST, "/scenes", &[("content-type", &kind)], body).await;
    assert_eq!(by_file.status, 202, "{by_file:?}");
    let body = json!({ "image": { "base64": STANDARD.encode(&image) }, "seed": 3 });
    let by_base64 = server.post("/scenes", body).await;
    let (one, other) = (by_file.json(), by_base64.json());
    assert_eq!(one["request"], other["request"]);
    let uri = format!("data:image/png;base64,{}", STANDARD.encode(&image));
    let by_uri = server.post("/scenes", json!({ "image": { "base64": uri }, "seed": 3 })).await;
    assert_eq!(by_uri.json()["request"], one["request"], "{by_uri:?}");
    let uri = format!("data:image/jpeg;base64,{}", STANDARD.encode(&image));
    let contradicting = server.post("/scenes", json!({ "image": { "base64": uri } })).await;
    assert_eq!(contradicting.problem(), (422, "invalid_body".into()));
    assert_eq!(contradicting.json()["errors"][0]["pointer"], "/image/base64");
    assert_eq!(one["request"]["input"]["media_type"], "image/png");
    let digest = one["request"]["input"]["sha256"].as_str().unwrap();
    let digest = store::Digest::parse(digest).expect("is a digest");
    assert_eq!(server.store().blobs().get(&digest).await.unwrap().as_deref(), Some(&image[..]));
}

#[tokio::test]
async fn text_beside_an_image_is_part_of_the_input() {
    let server = Server::start(&Script::new(&[])).await;
    let image = png(240, 180);
    let (kind, body) =
        form(&[("image", &image), ("request", br#"{"seed": 3, "text": " a mango and a plate "}"#)]);
    let by_file = server.call(Method::POST, "/scenes", &[("content-type", &kind)], body).await;
    assert_eq!(by_file.status, 202, "{by_file:?}");
    let both =
        json!({ "text": "a mango and a plate", "image": { "base64": STANDARD.encode(&image) }, "seed": 3 });
    let by_base64 = server.post("/scenes", both.clone()).await;
    let input = by_base64.json()["request"]["input"].clone();
    assert_eq!(by_file.json()["request"]["input"], input);
    assert_eq!((&input["kind"], &input["text"]), (&json!("image"), &json!("a mango and a plate")));
    let checked = server.post("/scenes/validate", both).await.json();
    assert_eq!(checked["request"]["input"], input);
    // Without a text, the stored input has no such field.
    let alone = server.post("/scenes", json!({ "image": { "base64": STANDARD.encode(&image) } })).await;
    assert!(alone.json()["request"]["input"].get("text").is_none(), "{alone:?}");
}

#[tokio::test]
async fn depths_are_part_of_the_input() {
    let server = Server::start(&Script::new(&[])).await;
    let image = png(240, 180);
    let depth = |width_px: u32, height_px: u32| {
        let depths_mm = vec![900; (width_px * height_px) as usize];
        imaging::DepthImage::new(width_px, height_px, depths_mm).expect("a depth a pixel").encode_png()
    };
    let camera = |numbers: &str| {
        json!({ "seed": 3, "options": { "set": { "photograph.intrinsics_px": numbers } } }).to_string()
    };
    let known = camera("200, 200, 120, 90, 240, 180");
    let send = |fields: Vec<(&'static str, Vec<u8>)>| {
        let fields: Vec<(&str, &[u8])> = fields.iter().map(|(name, value)| (*name, &value[..])).collect();
        let (kind, body) = form(&fields);
        let server = &server;
        async move { server.call(Method::POST, "/scenes", &[("content-type", &kind)], body).await }
    };
    let with = |depth: Vec<u8>, request: &str| {
        vec![("image", image.clone()), ("depth", depth), ("request", request.as_bytes().to_vec())]
    };
    let alone = send(vec![("image", image.clone()), ("request", known.as_bytes().to_vec())]).await.json();
    let both = send(with(depth(120, 90), &known)).await;
    assert_eq!(both.status, 202, "{both:?}");
    let (input, version) =
        (both.json()["request"]["input"].clone(), both.json()["request"]["version"].clone());
    assert_eq!(input["sha256"], alone["request"]["input"]["sha256"]);
    assert_eq!(input["depth_sha256"].as_str().map(str::len), Some(64), "{input}");
    assert_eq!((version, alone["request"]["version"].clone()), (json!(5), json!(1)));
    assert!(alone["request"]["input"].get("depth_sha256").is_none(), "{alone}");
    let unknown = camera("0, 0, 0, 0, 0, 0");
    let wide = camera("200, 200, 120, 60, 240, 120");
    let outside = camera("200, 200, 300, 90, 240, 180");
    for (fields, expected) in [
        (vec![("depth", depth(120, 90))], "missing_field"),
        (with(depth(120, 90), "{}"), "depth_without_intrinsics"),
        (with(depth(120, 90), &unknown), "depth_without_intrinsics"),
        (with(depth(120, 90), &wide), "invalid_body"),
        (with(depth(120, 90), &outside), "invalid_body"),
        (with(depth(120, 60), &known), "depth_dimensions"),
        (with(image.clone(), &known), "depth_unreadable"),
        (with(vec![7; 300], &known), "depth_unreadable"),
        (with(depth(120, 90)[..60].to_vec(), &known), "depth_unreadable"),
    ] {
        assert_eq!(send(fields).await.problem(), (422, expected.into()));
    }
}

#[tokio::test]
async fn the_same_key_makes_one_scene() {
    let server = Server::start(&Script::new(&[])).await;
    let send = |body: Value, key: &'static str| {
        let headers = [("content-type", "application/json"), ("idempotency-key", key)];
        let server = &server;
        async move { server.call(Method::POST, "/scenes", &headers, body.to_string()).await }
    };
    let first = send(json!({ "text": "a mug" }), "k1").await.json();
    // The same content, although the text of the body differs; the drawn seed is the first one's.
    let again = send(json!({ "labels": {}, "text": "a mug " }), "k1").await;
    assert_eq!(again.status, 202);
    assert_eq!((&again.json()["id"], &again.json()["seed"]), (&first["id"], &first["seed"]));
    let other_body = send(json!({ "text": "a bowl" }), "k1").await;
    assert_eq!(other_body.problem(), (422, "idempotency_key_reused".into()));
    let other_key = send(json!({ "text": "a mug" }), "k2").await.json();
    assert_ne!(other_key["id"], first["id"]);
}

#[tokio::test]
async fn a_key_of_a_wrong_form_is_refused_by_every_route() {
    let server = Server::start(&Script::new(&[])).await;
    let (scene, job) = server.submit("a mug").await;
    let wrong: [&[(&str, &str)]; 4] = [
        &[("idempotency-key", "two words")],
        &[("idempotency-key", "")],
        &[("idempotency-key", "a"), ("idempotency-key", "a")],
        &[("idempotency-key", "a"), ("idempotency-key", "b")],
    ];
    for (method, path) in [
        (Method::POST, "/scenes".to_owned()),
        (Method::POST, "/scenes/validate".to_owned()),
        (Method::POST, format!("/scenes/{scene}/edits")),
        (Method::POST, format!("/scenes/{scene}/variants")),
        (Method::POST, format!("/scenes/{scene}/executions")),
        (Method::POST, format!("/scenes/{scene}/episodes")),
        (Method::POST, "/batches".to_owned()),
        (Method::POST, "/datasets".to_owned()),
        (Method::POST, format!("/jobs/{job}/cancel")),
        (Method::DELETE, format!("/scenes/{scene}")),
        (Method::GET, "/scenes".to_owned()),
    ] {
        for keys in wrong {
            let headers = [&[("content-type", "application/json")][..], keys].concat();
            let reply = server.call(method.clone(), &path, &headers, "{}").await;
            assert_eq!(reply.problem(), (400, "invalid_idempotency_key".into()), "{method} {path} {keys:?}");
        }
    }
    assert_eq!(server.get(&format!("/scenes/{scene}")).await.status, 200, "nothing was done");
}

#[tokio::test]
async fn encoded_bodies_are_refused_in_every_form() {
    let server = Server::start(&Script::new(&[])).await;
    let json = json!({ "text": "a mug" }).to_string();
    let line = json!({ "custom_id": "a", "body": { "text": "a mug" } }).to_string();
    let form =
        "--x\r\ncontent-disposition: form-data; name=\"request\"\r\n\r\n{\"text\": \"a mug\"}\r\n--x--\r\n";
    for (path, kind, body) in [
        ("/scenes", "application/json", json.as_str()),
        ("/scenes", "multipart/form-data; boundary=x", form),
        ("/scenes/validate", "application/json", &json),
        ("/batches", "application/jsonl", &line),
        ("/datasets", "application/json", "{}"),
    ] {
        for coding in ["gzip", "br", "identity, gzip", "x-unknown"] {
            let headers = [("content-type", kind), ("content-encoding", coding)];
            let reply = server.call(Method::POST, path, &headers, body.to_owned()).await;
            assert_eq!(reply.problem(), (415, "content_encoding".into()), "{path} {kind} {coding}");
            assert_eq!(reply.header("accept-encoding"), "identity");
        }
    }
    for coding in ["identity", "Identity", ""] {
        let headers = [("content-type", "application/json"), ("content-encoding", coding)];
        assert_eq!(
            server.call(Method::POST, "/scenes", &headers, json.clone()).await.status,
            202,
            "{coding}"
        );
    }
}

#[tokio::test]
async fn fifty_at_once_with_one_key_make_one_scene() {
    let server = Server::start(&Script::new(&[])).await;
    let headers = [("content-type", "application/json"), ("idempotency-key", "all-together")];
    let body = json!({ "text": "a dozen eggs" }).to_string();
    let calls = (0..50).map(|_| server.call(Method::POST, "/scenes", &headers, body.clone()));
    let replies = futures::future::join_all(calls).await;
    assert!(replies.iter().all(|reply| reply.status == 202));
    let ids: BTreeSet<String> = replies.iter().map(|r| r.json()["id"].to_string()).collect();
    assert_eq!(ids.len(), 1);
    let jobs: i64 = server.store().job_counts().await.unwrap().iter().map(|(_, count)| count).sum();
    assert_eq!(jobs, 1);
}

#[tokio::test]
async fn bad_json_is_refused_with_advice_and_nothing_is_enqueued() {
    let server = Server::with(&Script::new(&[]), &[("server.max_text_chars", "200")]).await;
    let long = "x".repeat(201);
    let small = STANDARD.encode(png(16, 16));
    let whole = png(240, 180);
    let cut = STANDARD.encode(&whole[..whole.len() / 2]);
    let huge = STANDARD.encode(claiming(20_000, 20_000));
    let many: Value =
        (0..33).map(|i| (format!("k{i}"), json!("v"))).collect::<serde_json::Map<_, _>>().into();
    for (body, status, code, pointer) in [
        (json!({}), 422, "invalid_body", ""),
        (json!(["a mug"]), 422, "invalid_body", ""),
        (json!("a mug"), 422, "invalid_body", ""),
        (json!({ "text": "a", "options": [] }), 422, "invalid_body", "/options"),
        (
            json!({ "text": " ", "image": { "base64": STANDARD.encode(&whole) } }),
            422,
            "invalid_body",
            "/text",
        ),
        (json!({ "text": "  \n " }), 422, "invalid_body", "/text"),
        (json!({ "text": long }), 422, "invalid_body", "/text"),
        (json!({ "text": "a\u{0}b" }), 422, "invalid_body", "/text"),
        (json!({ "text": 5 }), 422, "invalid_body", "/text"),
        (json!({ "txet": "a mug" }), 422, "invalid_body", "/txet"),
        (json!({ "text": "a", "seed": -1 }), 422, "invalid_body", "/seed"),
        (json!({ "text": "a", "seed": 1u64 << 53 }), 422, "invalid_body", "/seed"),
        (json!({ "text": "a", "seed": 1.5 }), 422, "invalid_body", "/seed"),
        (json!({ "text": "a", "labels": { "two words": "x" } }), 422, "invalid_body", "/labels"),
        (json!({ "text": "a", "labels": { "k": "a\nb" } }), 422, "invalid_body", "/labels/k"),
        (json!({ "text": "a", "labels": many }), 422, "invalid_body", "/labels"),
        (
            json!({ "text": "a", "options": { "max_objects": 0 } }),
            422,
            "invalid_body",
            "/options/max_objects",
        ),
        (
            json!({ "text": "a", "options": { "max_objects": 65 } }),
            422,
            "invalid_body",
            "/options/max_objects",
        ),
        (json!({ "text": "a", "options": { "max_object": 5 } }), 422, "invalid_body", "/options/max_object"),
        (json!({ "text": "a", "options": { "robot": "hal" } }), 422, "invalid_body", "/options/robot"),
        (json!({ "text": "a", "options": { "robot": "" } }), 422, "invalid_body", "/options/robot"),
        (
            json!({ "text": "a", "options": { "table": { "shape": "hexagonal" } } }),
            422,
            "invalid_body",
            "/options/table/shape",
        ),
        (
            json!({ "text": "a", "options": { "table": { "size_m": [9.0, 1.0, 0.7] } } }),
            422,
            "invalid_body",
            "/options/table/size_m/0",
        ),
        (
            json!({ "text": "a", "options": { "metric_anchor": { "object": "mug", "width_m": 0.0 } } }),
            422,
            "invalid_body",
            "/options/metric_anchor/width_m",
        ),
        (
            json!({ "text": "a", "options": { "set": { "decompose.max_hulls": "0" } } }),
            422,
            "invalid_body",
            "/options/set/decompose.max_hulls",
        ),
        (
            json!({ "text": "a", "options": { "set": { "decompose.max_huls": "24" } } }),
            422,
            "invalid_body",
            "/options/set/decompose.max_huls",
        ),
        (
            json!({ "text": "a", "options": { "set": { "server.listen": "0.0.0.0:1" } } }),
            422,
            "invalid_body",
            "/options/set/server.listen",
        ),
        (json!({ "image": { "url": "http://169.254.169.254/" } }), 422, "invalid_body", "/image/url"),
        (json!({ "image": { "url": "https://169.254.169.254/" } }), 422, "invalid_body", "/image/url"),
        (json!({ "image": { "url": "https://[::1]/a.png" } }), 422, "invalid_body", "/image/url"),
        (json!({ "image": { "url": "file:///etc/passwd" } }), 422, "invalid_body", "/image/url"),
        (json!({ "image": { "url": "" } }), 422, "invalid_body", "/image/url"),
        (json!({ "image": { "url": "https://a.example/", "base64": "" } }), 422, "invalid_body", "/image"),
        (json!({ "image": { "base64": "%%%" } }), 422, "invalid_body", "/image/base64"),
        (json!({ "image": {} }), 422, "invalid_body", "/image"),
        (json!({ "image": { "base64": STANDARD.encode("GIF89a") } }), 415, "image_format", "-"),
        (
            json!({ "image": { "base64": STANDARD.encode("<svg xmlns='http://www.w3.org/2000/svg'/>") } }),
            415,
            "image_format",
            "-",
        ),
        (json!({ "image": { "base64": STANDARD.encode("a table with a mug") } }), 415, "image_format", "-"),
        (json!({ "image": { "base64": huge } }), 422, "image_dimensions", "-"),
        (json!({ "image": { "base64": small } }), 422, "image_dimensions", "-"),
        (json!({ "image": { "base64": cut } }), 422, "image_unreadable", "-"),
    ] {
        let shown: String = body.to_string().chars().take(80).collect();
        let reply = server.post("/scenes", body).await;
        assert_eq!(reply.problem(), (status, code.to_owned()), "{shown}: {reply:?}");
        let problem = reply.json();
        assert!(problem["detail"].as_str().is_some_and(|detail| detail.len() > 10), "{shown}");
        if pointer != "-" {
            let pointers: Vec<&str> = problem["errors"]
                .as_array()
                .unwrap()
                .iter()
                .map(|error| error["pointer"].as_str().unwrap())
                .collect();
            assert_eq!(pointers, [pointer], "{shown}: {problem}");
        }
    }
    let suggestion = json!({ "text": "a", "options": { "set": { "decompose.max_huls": "24" } } });
    let detail = server.post("/scenes", suggestion).await.json()["errors"][0]["detail"].to_string();
    assert!(detail.contains("decompose.max_hulls"), "{detail}");
    let negative = server.post("/scenes", json!({ "text": "a", "seed": -1 })).await.json();
    assert_eq!(negative["errors"][0]["detail"], "must be a whole number of at least 0, not -1");
    nothing_enqueued(&server).await;
}

#[tokio::test]
async fn bad_bodies_are_refused_and_nothing_is_enqueued() {
    let set = [("server.max_body_bytes", "4096"), ("server.max_image_bytes", "3000")];
    let server = Server::with(&Script::new(&[]), &set).await;
    let image = png(40, 40);
    let (multipart, two_images) = form(&[("image", &image), ("image", &image)]);
    let send = |kind: &'static str, body: Vec<u8>, path: &'static str| {
        let server = &server;
        async move {
            let headers = [("content-type", kind)];
            let headers = if kind.is_empty() { &headers[..0] } else { &headers[..] };
            server.call(Method::POST, path, headers, body).await.problem()
        }
    };
    let form_kind = "multipart/form-data; boundary=cut";
    assert_eq!(multipart, form_kind);
    for (kind, body, expected) in [
        ("application/json", b"{\"text\": \"a".to_vec(), (400, "malformed_json")),
        ("application/json", Vec::new(), (400, "malformed_json")),
        ("application/json", vec![0xff, 0xfe, b'{'], (400, "malformed_json")),
        ("application/json", vec![b'['; 3000], (400, "malformed_json")),
        ("application/json", vec![b' '; 5000], (413, "body_too_large")),
        ("text/plain", b"a mug".to_vec(), (415, "body_format")),
        ("", b"{}".to_vec(), (415, "body_format")),
        ("multipart/form-data", b"x".to_vec(), (400, "malformed_multipart")),
        (form_kind, b"--cut\r\nnonsense".to_vec(), (400, "malformed_multipart")),
        (form_kind, two_images, (422, "repeated_field")),
        (form_kind, form(&[("file", &image)]).1, (422, "unknown_field")),
        (form_kind, form(&[("image", &vec![7; 5000])]).1, (413, "body_too_large")),
        (form_kind, form(&[("image", &vec![7; 3500])]).1, (413, "image_too_large")),
        (form_kind, form(&[("image", b"no picture")]).1, (415, "image_format")),
        (form_kind, form(&[("request", b"{}")]).1, (422, "missing_field")),
        (form_kind, form(&[("image", &image), ("request", br#"{"text":" "}"#)]).1, (422, "invalid_body")),
        (form_kind, form(&[("image", &image), ("request", b"{")]).1, (400, "malformed_json")),
    ] {
        let shown = String::from_utf8_lossy(&body).chars().take(60).collect::<String>();
        let (status, code) = send(kind, body, "/scenes").await;
        assert_eq!((status, code.as_str()), expected, "{kind:?} {shown:?}");
    }
    // One who means to validate by a parameter, as in earlier versions, makes no scene.
    let text = br#"{"text":"a mug"}"#.to_vec();
    let by_parameter = send("application/json", text, "/scenes?validate_only=true").await;
    assert_eq!((by_parameter.0, by_parameter.1.as_str()), (400, "invalid_parameter"));
    nothing_enqueued(&server).await;
}

#[tokio::test]
async fn validating_enqueues_nothing() {
    let server = Server::start(&Script::new(&[])).await;
    let reply = server.post("/scenes/validate", json!({ "text": "a mug", "seed": 1 })).await;
    assert_eq!((reply.status.as_u16(), &reply.json()["valid"]), (200, &json!(true)));
    nothing_enqueued(&server).await;
}

#[tokio::test]
async fn who_prefers_to_wait_gets_the_finished_scene() {
    let script = Script::new(&[]);
    let server = Server::start(&script).await;
    let headers = [("content-type", "application/json"), ("prefer", "respond-async, wait=20")];
    let reply = server.call(Method::POST, "/scenes", &headers, r#"{"text":"a mug"}"#).await;
    assert_eq!((reply.status.as_u16(), reply.header("preference-applied")), (200, "wait=20"));
    assert_eq!(reply.json()["state"], "ready");

    let script = Script::new(&[("alpha", &[crate::harness::script::Act::Wait])]);
    let server = Server::start(&script).await;
    let headers = [("content-type", "application/json"), ("prefer", "wait=0")];
    let reply = server.call(Method::POST, "/scenes", &headers, r#"{"text":"a mug"}"#).await;
    assert_eq!((reply.status.as_u16(), &reply.json()["state"]), (202, &json!("pending")));
    script.open_gate();
}

async fn nothing_enqueued(server: &Server) {
    assert_eq!(server.get("/scenes").await.json()["scenes"], json!([]));
    let jobs: i64 = server.store().job_counts().await.unwrap().iter().map(|(_, count)| count).sum();
    assert_eq!(jobs, 0);
}

#[tokio::test]
async fn images_are_fetched_only_from_allowed_hosts() {
    let image = png(240, 180);
    let served = image.clone();
    let router = axum::Router::new()
        .route("/table.png", axum::routing::get(move || async move { served }))
        .route("/large.png", axum::routing::get(|| async { vec![0_u8; 100_000] }))
        .route(
            "/away.png",
            axum::routing::get(|| async { axum::response::Redirect::temporary("http://localhost/") }),
        );
    let other = tokio::net::TcpListener::bind("127.0.0.1:0").await.unwrap();
    let elsewhere = format!("http://localhost:{}/table.png", other.local_addr().unwrap().port());
    let router = router.route(
        "/elsewhere.png",
        axum::routing::get(move || async move { axum::response::Redirect::temporary(&elsewhere) }),
    );
    let same = router.clone();
    tokio::spawn(async move { axum::serve(other, same).await.unwrap() });
    let listener = tokio::net::TcpListener::bind("127.0.0.1:0").await.unwrap();
    let here = listener.local_addr().unwrap().to_string();
    tokio::spawn(async move { axum::serve(listener, router).await.unwrap() });
    let named = [("server.fetch_hosts", here.as_str()), ("server.max_image_bytes", "50000")];
    let server = Server::with(&Script::new(&[]), &named).await;
    let submit = |path: &str| json!({ "image": { "url": format!("http://{here}/{path}") }, "seed": 3 });
    let fetched = server.post("/scenes", submit("table.png")).await;
    assert_eq!(fetched.status, 202, "{fetched:?}");
    let sent =
        server.post("/scenes", json!({ "image": { "base64": STANDARD.encode(&image) }, "seed": 3 })).await;
    assert_eq!(fetched.json()["request"]["input"], sent.json()["request"]["input"]);
    for (path, message) in
        [("nothing.png", "status 404"), ("large.png", "50000 bytes"), ("away.png", "localhost")]
    {
        let refused = server.post("/scenes", submit(path)).await;
        assert_eq!(refused.status, 422, "{refused:?}");
        let error = refused.json()["errors"][0].clone();
        assert_eq!(error["pointer"], "/image/url");
        assert!(error["detail"].as_str().unwrap().contains(message), "{error}");
    }
    server.stop().await;
    // A name with a port is no leave for its other ports, after a redirect neither.
    let named_host = format!("localhost:{}", here.rsplit(':').next().unwrap());
    let server = Server::with(&Script::new(&[]), &[("server.fetch_hosts", named_host.as_str())]).await;
    let body = |path: &str| json!({ "image": { "url": format!("http://{named_host}/{path}") }, "seed": 3 });
    assert_eq!(server.post("/scenes", body("table.png")).await.status, 202);
    let refused = server.post("/scenes", body("elsewhere.png")).await;
    assert_eq!(refused.problem(), (422, "invalid_body".into()), "{refused:?}");
    server.stop().await;
    let server = Server::with(&Script::new(&[]), &[("server.fetch_images", "false")]).await;
    let refused = server.post("/scenes", submit("table.png")).await;
    assert!(refused.json()["errors"][0]["detail"].as_str().unwrap().contains("fetches no images"));
    server.stop().await;
}
