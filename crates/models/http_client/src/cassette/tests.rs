//! Tests of recording, replay, redaction and malformed cassettes.

use std::io::Write;
use std::time::Duration;

use bytes::Bytes;
use reqwest::Method;

use super::*;
use crate::Secret;

fn request(body: &'static str) -> HttpRequest {
    HttpRequest {
        method: Method::POST,
        url: "https://a.example/v1/chat?sig=first".into(),
        headers: vec![("Prefer".into(), "wait".into())],
        transient_headers: vec![("Idempotency-Key".into(), "i-1".into())],
        bearer: Secret::new("sk-123"),
        content_type: "application/json".into(),
        body: Bytes::from_static(body.as_bytes()),
    }
}

fn response(status: u16, body: impl Into<Bytes>) -> HttpResponse {
    let retry_after = (status == 429).then_some(Duration::from_secs(3));
    HttpResponse { status, content_type: "application/json".into(), retry_after, body: body.into() }
}

async fn record(folder: &Path, exchanges: &[(HttpRequest, HttpResponse)]) {
    let cassette = Cassette::record_into(folder).expect("a folder");
    for (request, response) in exchanges {
        cassette.record(request, response).await.expect("is written");
    }
}

#[tokio::test]
async fn replay_repeats_responses_in_order_and_then_the_last() {
    let folder = tempfile::tempdir().expect("a folder");
    let binary = Bytes::from_static(b"glTF\xff\xfe");
    let exchanges = [
        (request("1"), response(429, "busy")),
        (request("2"), response(200, "two")),
        (request("1"), response(200, binary)),
    ];
    record(folder.path(), &exchanges).await;
    let cassette = Cassette::replay(folder.path()).expect("plays");
    let found = |body| cassette.next_response(&request(body));
    assert_eq!(found("1"), Some(exchanges[0].1.clone()));
    assert_eq!(found("1"), Some(exchanges[2].1.clone()));
    assert_eq!(found("1"), Some(exchanges[2].1.clone()));
    assert_eq!(found("2"), Some(exchanges[1].1.clone()));
    assert_eq!(found("3"), None);
    // New exchanges follow those that the folder holds.
    record(folder.path(), &[(request("2"), response(200, "again"))]).await;
    let cassette = Cassette::replay(folder.path()).expect("plays");
    assert_eq!(cassette.next_response(&request("2")).expect("the first").body, "two");
    assert_eq!(cassette.next_response(&request("2")).expect("the second").body, "again");
}

#[tokio::test]
async fn credentials_are_neither_recorded_nor_part_of_the_digest() {
    let folder = tempfile::tempdir().expect("a folder");
    let message = r#"{"error": "no such key: sk-123", "url": "https://b.example/f?X-Amz-Signature=f00&n=1"}"#;
    record(folder.path(), &[(request("1"), response(200, message))]).await;
    for entry in std::fs::read_dir(folder.path()).expect("a folder") {
        let text = std::fs::read_to_string(entry.expect("a file").path()).expect("is text");
        for secret in ["sk-123", "f00", "first", "i-1"] {
            assert!(!text.contains(secret), "{secret} in {text}");
        }
        assert!(text.contains("n=1") && text.contains("https://a.example/v1/chat"));
    }
    let cassette = Cassette::replay(folder.path()).expect("plays");
    let other = HttpRequest {
        url: "https://a.example/v1/chat?sig=second".into(),
        bearer: None,
        transient_headers: Vec::new(),
        ..request("1")
    };
    assert!(cassette.next_response(&other).is_some());
    for different in [
        HttpRequest { method: Method::GET, ..request("1") },
        HttpRequest { url: "https://a.example/v1/images".into(), ..request("1") },
        HttpRequest { headers: Vec::new(), ..request("1") },
        HttpRequest { content_type: "text/plain".into(), ..request("1") },
    ] {
        assert_eq!(cassette.next_response(&different), None, "{different:?}");
    }
}

#[tokio::test]
async fn zip_archive_replays_like_its_folder() {
    let folder = tempfile::tempdir().expect("a folder");
    record(folder.path(), &[(request("1"), response(200, "one"))]).await;
    let archive = folder.path().join("kept.zip");
    let mut zip = zip::ZipWriter::new(std::fs::File::create(&archive).expect("a file"));
    for entry in std::fs::read_dir(folder.path()).expect("a folder").map(|entry| entry.expect("a file")) {
        if entry.path() != archive {
            let name = format!("scene/{}", entry.file_name().into_string().expect("plain"));
            zip.start_file(name, zip::write::SimpleFileOptions::default()).expect("begins");
            zip.write_all(&std::fs::read(entry.path()).expect("is read")).expect("is written");
        }
    }
    zip.finish().expect("ends");
    let cassette = Cassette::replay(&archive).expect("plays");
    assert_eq!(cassette.next_response(&request("1")), Some(response(200, "one")));
}

#[tokio::test]
async fn replay_rejects_folders_without_valid_exchanges() {
    let folder = tempfile::tempdir().expect("a folder");
    let message = |place: &Path| Cassette::replay(place).err().expect("is none").to_string();
    assert!(message(folder.path()).contains("no exchange"), "{}", message(folder.path()));
    assert!(message(&folder.path().join("nowhere.zip")).contains("nowhere.zip"));
    record(folder.path(), &[(request("1"), response(200, "one"))]).await;
    let name = file_name(&request_digest(&request("1")), 0);
    std::fs::write(folder.path().join(&name), "{\"request\": {}}").expect("is written");
    assert!(message(folder.path()).contains(&name));
}
