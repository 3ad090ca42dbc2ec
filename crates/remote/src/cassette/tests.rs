//! What is kept, what is found again, and what is not used.

use std::io::Write;
use std::time::Duration;

use bytes::Bytes;
use reqwest::Method;

use super::*;
use crate::Secret;

fn asked(body: &'static str) -> Outgoing {
    Outgoing {
        method: Method::POST,
        url: "https://a.example/v1/chat?sig=first".into(),
        headers: vec![("Prefer".into(), "wait".into())],
        passing_headers: vec![("Idempotency-Key".into(), "i-1".into())],
        bearer: Secret::new("sk-123"),
        content_type: "application/json".into(),
        body: Bytes::from_static(body.as_bytes()),
    }
}

fn reply(status: u16, body: impl Into<Bytes>) -> Reply {
    let retry_after = (status == 429).then_some(Duration::from_secs(3));
    Reply { status, content_type: "application/json".into(), retry_after, body: body.into() }
}

async fn recorded(folder: &Path, exchanges: &[(Outgoing, Reply)]) {
    let cassette = Cassette::recorded(folder).expect("a folder");
    for (outgoing, reply) in exchanges {
        cassette.keep(outgoing, reply).await.expect("is written");
    }
}

#[tokio::test]
async fn answers_come_back_in_their_order_and_the_last_one_stays() {
    let folder = tempfile::tempdir().expect("a folder");
    let binary = Bytes::from_static(b"glTF\xff\xfe");
    let exchanges =
        [(asked("1"), reply(429, "busy")), (asked("2"), reply(200, "two")), (asked("1"), reply(200, binary))];
    recorded(folder.path(), &exchanges).await;
    let cassette = Cassette::played(folder.path()).expect("plays");
    let found = |body| cassette.find(&asked(body));
    assert_eq!(found("1"), Some(exchanges[0].1.clone()));
    assert_eq!(found("1"), Some(exchanges[2].1.clone()));
    assert_eq!(found("1"), Some(exchanges[2].1.clone()));
    assert_eq!(found("2"), Some(exchanges[1].1.clone()));
    assert_eq!(found("3"), None);
    // Recording goes on behind what is there.
    recorded(folder.path(), &[(asked("2"), reply(200, "again"))]).await;
    let cassette = Cassette::played(folder.path()).expect("plays");
    assert_eq!(cassette.find(&asked("2")).expect("the first").body, "two");
    assert_eq!(cassette.find(&asked("2")).expect("the second").body, "again");
}

#[tokio::test]
async fn what_proves_who_asks_is_neither_kept_nor_part_of_the_question() {
    let folder = tempfile::tempdir().expect("a folder");
    let told = r#"{"error": "no such key: sk-123", "url": "https://b.example/f?X-Amz-Signature=f00&n=1"}"#;
    recorded(folder.path(), &[(asked("1"), reply(200, told))]).await;
    for entry in std::fs::read_dir(folder.path()).expect("a folder") {
        let text = std::fs::read_to_string(entry.expect("a file").path()).expect("is text");
        for secret in ["sk-123", "f00", "first", "i-1"] {
            assert!(!text.contains(secret), "{secret} in {text}");
        }
        assert!(text.contains("n=1") && text.contains("https://a.example/v1/chat"));
    }
    let cassette = Cassette::played(folder.path()).expect("plays");
    let other = Outgoing {
        url: "https://a.example/v1/chat?sig=second".into(),
        bearer: None,
        passing_headers: Vec::new(),
        ..asked("1")
    };
    assert!(cassette.find(&other).is_some());
    for different in [
        Outgoing { method: Method::GET, ..asked("1") },
        Outgoing { url: "https://a.example/v1/images".into(), ..asked("1") },
        Outgoing { headers: Vec::new(), ..asked("1") },
        Outgoing { content_type: "text/plain".into(), ..asked("1") },
    ] {
        assert_eq!(cassette.find(&different), None, "{different:?}");
    }
}

#[tokio::test]
async fn an_archive_of_a_folder_plays_like_the_folder() {
    let folder = tempfile::tempdir().expect("a folder");
    recorded(folder.path(), &[(asked("1"), reply(200, "one"))]).await;
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
    let cassette = Cassette::played(&archive).expect("plays");
    assert_eq!(cassette.find(&asked("1")), Some(reply(200, "one")));
}

#[tokio::test]
async fn what_is_no_recording_says_so() {
    let folder = tempfile::tempdir().expect("a folder");
    let told = |place: &Path| Cassette::played(place).err().expect("is none").to_string();
    assert!(told(folder.path()).contains("no exchange"), "{}", told(folder.path()));
    assert!(told(&folder.path().join("nowhere.zip")).contains("nowhere.zip"));
    recorded(folder.path(), &[(asked("1"), reply(200, "one"))]).await;
    let name = name_of(&digest_of(&asked("1")), 0);
    std::fs::write(folder.path().join(&name), "{\"request\": {}}").expect("is written");
    assert!(told(folder.path()).contains(&name));
}
