//! One suite on files, on memory and on a real S3 server, and what only some of them can have.

#[cfg(feature = "s3")]
mod s3_server;

use std::path::PathBuf;
use std::time::{Duration, SystemTime};

use bytes::Bytes;
use futures::TryStreamExt;
use object_store::ObjectStoreExt;

use super::super::Outage;
use super::super::outage::Health;
use super::reading::MAX_VERIFY_FIRST_BYTES;
use super::sweeping::Volume;
use super::*;
#[cfg(feature = "s3")]
use s3_server::S3Server;

const HOUR: Duration = Duration::from_secs(3600);

/// Blobs in a temporary directory.
fn files() -> (tempfile::TempDir, Blobs) {
    let directory = tempfile::tempdir().expect("temporary directory");
    let blobs = Blobs::local(directory.path(), true, Health::new()).expect("opens");
    (directory, blobs)
}

/// Bytes of which no two chunks are equal.
fn bytes_of(count: usize) -> Bytes {
    (0..count).map(|i| (i ^ (i >> 8) ^ (i >> 16)) as u8).collect::<Vec<_>>().into()
}

async fn read(blobs: &Blobs, digest: &Digest, range: Option<std::ops::Range<u64>>) -> Option<Vec<u8>> {
    let chunks = blobs.stream(digest, range).await.expect("answers")?;
    Some(chunks.try_collect::<Vec<Bytes>>().await.expect("reads").concat())
}

/// Checks that hold for every place of blobs.
async fn suite(blobs: &Blobs) {
    let digest = blobs.put(&b"hello table"[..]).await.expect("puts");
    assert_eq!(digest, Digest::of(b"hello table"));
    assert_eq!(blobs.put(&b"hello table"[..]).await.expect("puts again"), digest);
    assert_eq!(blobs.get(&digest).await.expect("reads").as_deref(), Some(&b"hello table"[..]));
    assert_eq!(read(blobs, &digest, None).await.as_deref(), Some(&b"hello table"[..]));
    assert_eq!(read(blobs, &digest, Some(6..9)).await.as_deref(), Some(&b"tab"[..]));
    assert!(blobs.contains(&digest).await.expect("answers"));
    assert_eq!(blobs.size(&digest).await.expect("answers"), Some(11));

    let empty = blobs.put(Bytes::new()).await.expect("puts nothing");
    assert_eq!(blobs.get(&empty).await.expect("reads").as_deref(), Some(&b""[..]));
    assert_eq!(read(blobs, &empty, None).await.as_deref(), Some(&b""[..]));

    let other = Digest::of(b"other");
    assert_eq!(blobs.get(&other).await.expect("answers"), None);
    assert_eq!(read(blobs, &other, None).await, None);
    assert_eq!(read(blobs, &other, Some(0..2)).await, None);
    assert!(!blobs.contains(&other).await.expect("answers"));

    // More than one part of an upload, and more than what is sent from memory.
    let large = bytes_of((17 << 20) + 3);
    let digest = blobs.put(large.clone()).await.expect("puts");
    assert_eq!(blobs.size(&digest).await.expect("answers"), Some(large.len() as u64));
    let part = (9 << 20)..(9 << 20) + 1000;
    assert_eq!(
        read(blobs, &digest, Some(part.start as u64..part.end as u64)).await.expect("is there"),
        large[part]
    );
    assert_eq!(read(blobs, &digest, None).await.expect("is there"), large);
    assert_eq!(blobs.get(&digest).await.expect("reads"), Some(large));

    sweep_suite(blobs).await;
}

async fn sweep_suite(blobs: &Blobs) {
    let [kept, swept] = ["kept", "swept"].map(|text| Bytes::from(text.to_owned()));
    let kept = blobs.put(kept).await.expect("puts");
    let swept = blobs.put(swept).await.expect("puts");
    let shard = |digest: &Digest| u8::from_str_radix(&digest.as_str()[..2], 16).ok();
    let none = Volume::default();
    for digest in [&kept, &swept] {
        let (removed, _) = blobs.sweep_shard(shard(digest), HOUR, false, |_| false).await.expect("sweeps");
        assert_eq!(removed, none, "young blobs stay");
    }
    let (removed, left) = blobs
        .sweep_shard(shard(&kept), Duration::ZERO, false, |digest| *digest == kept)
        .await
        .expect("sweeps");
    assert_eq!((removed, left), (none, Volume { blobs: 1, bytes: 4 }), "what is referred to stays");
    let would = blobs.sweep_shard(shard(&swept), Duration::ZERO, true, |_| false).await.expect("counts");
    assert_eq!(would, (Volume { blobs: 1, bytes: 5 }, none));
    assert!(blobs.contains(&swept).await.expect("answers"), "a dry run removes nothing");
    let done = blobs.sweep_shard(shard(&swept), Duration::ZERO, false, |_| false).await.expect("sweeps");
    assert_eq!(done, would);
    assert!(!blobs.contains(&swept).await.expect("answers"));
    assert!(blobs.contains(&kept).await.expect("answers"));
}

/// Checks that hold for every place whose bytes others can change.
async fn damage_suite(blobs: &Blobs) {
    for size in [11, (1 << 20) + 5] {
        let bytes = bytes_of(size);
        let digest = blobs.put(bytes.clone()).await.expect("puts");
        let mut wrong = bytes.to_vec();
        wrong[size / 2] ^= 1;
        let wrong = Bytes::from(wrong);
        let damage = || async {
            let written = blobs.objects.put(&blobs.path_of(&digest), wrong.clone().into()).await;
            written.expect("damages the blob");
        };
        for range in [None, Some(0..4)] {
            damage().await;
            assert_eq!(read(blobs, &digest, range).await, None, "size {size}");
            assert!(!blobs.contains(&digest).await.expect("answers"), "it is set aside");
            assert_eq!(blobs.put(bytes.clone()).await.expect("puts"), digest);
            assert_eq!(read(blobs, &digest, None).await.as_deref(), Some(&bytes[..]), "it is repaired");
        }
        damage().await;
        assert_eq!(blobs.get(&digest).await.expect("answers"), None);
        let aside = blobs.sweep_damaged(Duration::ZERO, false).await.expect("sweeps");
        assert_eq!(aside, Volume { blobs: 1, bytes: size as u64 });
    }
}

#[tokio::test]
async fn files_pass_the_suite() {
    let (_directory, blobs) = files();
    suite(&blobs).await;
    damage_suite(&blobs).await;
}

#[tokio::test]
async fn memory_passes_the_suite() {
    suite(&Blobs::in_memory(Health::new())).await;
}

#[cfg(feature = "s3")]
#[tokio::test]
async fn s3_passes_the_suite() {
    let server = S3Server::shared();
    for (bucket, prefix) in [("suite", ""), ("suite-below", "some/folder")] {
        let blobs = server.blobs(bucket, prefix, HOUR);
        suite(&blobs).await;
        damage_suite(&blobs).await;
    }
}

#[tokio::test]
async fn a_blob_that_is_damaged_while_it_is_known_never_arrives_whole() {
    let (directory, blobs) = files();
    let bytes = bytes_of(3 << 20);
    let digest = blobs.put(bytes.clone()).await.expect("puts");
    assert_eq!(read(&blobs, &digest, None).await.as_deref(), Some(&bytes[..]));
    // A disk that loses bits changes no time.
    let hex = digest.as_str();
    let path = directory.path().join("sha256").join(&hex[..2]).join(hex);
    let modified = std::fs::metadata(&path).and_then(|meta| meta.modified()).expect("has a time");
    let file = std::fs::OpenOptions::new().write(true).open(&path).expect("opens");
    std::io::Write::write_all(&mut &file, b"x").expect("damages the first byte");
    file.set_modified(modified).expect("sets the time");
    drop(file);

    let mut chunks = blobs.stream(&digest, None).await.expect("answers").expect("is known as intact");
    let mut received = 0;
    let error = loop {
        match chunks.try_next().await {
            Ok(chunk) => received += chunk.expect("the stream ends with an error").len(),
            Err(error) => break error,
        }
    };
    assert!(matches!(error, StoreError::BlobDamaged { .. }), "{error}");
    assert!(received < bytes.len(), "{received}");
    assert_eq!(read(&blobs, &digest, None).await, None);
}

#[tokio::test]
async fn a_large_damaged_blob_ends_before_its_last_chunk() {
    let (_directory, blobs) = files();
    let bytes = bytes_of(MAX_VERIFY_FIRST_BYTES as usize + 1);
    let digest = blobs.put(bytes.clone()).await.expect("puts");
    let mut wrong = bytes.to_vec();
    wrong[0] ^= 1;
    blobs.objects.put(&blobs.path_of(&digest), wrong.into()).await.expect("damages the blob");
    let chunks = blobs.stream(&digest, None).await.expect("answers").expect("is not read before");
    let received = chunks.try_fold(0, |sum, chunk| async move { Ok(sum + chunk.len()) }).await;
    assert!(matches!(received, Err(StoreError::BlobDamaged { .. })), "{received:?}");
    // A part of it is verified before.
    blobs.put(bytes.clone()).await.expect("repairs");
    assert_eq!(read(&blobs, &digest, Some(5..9)).await.as_deref(), Some(&bytes[5..9]));
}

#[tokio::test]
async fn unfinished_puts_are_swept_when_they_are_old() {
    let (directory, blobs) = files();
    let folder = directory.path().join("sha256/ab");
    std::fs::create_dir_all(&folder).expect("creates");
    let leave = |name: &str, age: Duration| -> PathBuf {
        let path = folder.join(name);
        std::fs::write(&path, b"half").expect("writes");
        let file = std::fs::OpenOptions::new().write(true).open(&path).expect("opens");
        file.set_modified(SystemTime::now() - age).expect("sets the time");
        path
    };
    let (old, young) = (leave("abcd#17", 2 * HOUR), leave("abce#1", HOUR / 2));
    let would = blobs.sweep_shard(Some(0xab), HOUR, true, |_| true).await.expect("counts");
    assert_eq!(would.0, Volume { blobs: 1, bytes: 4 });
    assert!(old.exists());
    blobs.sweep_shard(Some(0xab), HOUR, false, |_| true).await.expect("sweeps");
    assert!(!old.exists() && young.exists());
}

#[cfg(feature = "s3")]
#[tokio::test]
async fn s3_creates_conditionally_and_refreshes_what_is_old() {
    let server = S3Server::shared();
    let planted = async |blobs: &Blobs, bytes: &'static [u8]| {
        let path = blobs.path_of(&Digest::of(b"hello table"));
        blobs.objects.put(&path, Bytes::from(bytes).into()).await.expect("plants");
    };
    let stored = async |blobs: &Blobs| {
        let path = blobs.path_of(&Digest::of(b"hello table"));
        blobs.objects.get(&path).await.expect("is there").bytes().await.expect("reads")
    };
    let young = server.blobs("conditions", "", HOUR);
    // A marker of the same size shows who wrote last.
    planted(&young, b"HELLO TABLE").await;
    young.put(&b"hello table"[..]).await.expect("puts");
    assert_eq!(stored(&young).await, &b"HELLO TABLE"[..], "an object that exists is not written again");
    let old = server.blobs("conditions", "", Duration::ZERO);
    old.put(&b"hello table"[..]).await.expect("puts");
    assert_eq!(stored(&old).await, &b"hello table"[..], "one that is old is");
    planted(&young, b"short").await;
    young.put(&b"hello table"[..]).await.expect("puts");
    assert_eq!(stored(&young).await, &b"hello table"[..], "one of another size is");
}

#[cfg(feature = "s3")]
#[tokio::test]
async fn s3_signs_addresses_of_intact_blobs() {
    let server = S3Server::shared();
    let mut blobs = server.blobs("signed", "", HOUR);
    let digest = blobs.put(&b"hello table"[..]).await.expect("puts");
    assert_eq!(blobs.presigned(&digest, "text/plain", None).await.expect("answers"), None, "not configured");
    if let Backend::S3 { presign, .. } = &mut blobs.backend {
        *presign = Some(Duration::from_secs(60));
    }
    let name = "attachment; filename=\"note.txt\"";
    let url = blobs.presigned(&digest, "text/plain", Some(name)).await.expect("answers").expect("an address");
    let path = url.strip_prefix(&server.url).expect("an address of the server");
    let (status, head, body) = server.request("GET", path, false);
    assert_eq!((status, &body[..]), (200, &b"hello table"[..]), "{head}");
    assert!(head.contains("text/plain"), "{head}");
    blobs.objects.put(&blobs.path_of(&digest), Bytes::from("HELLO TABLE").into()).await.expect("damages");
    blobs.verified.forget(&digest);
    assert_eq!(blobs.presigned(&digest, "text/plain", None).await.expect("answers"), None, "damaged");
}

#[cfg(feature = "s3")]
#[tokio::test]
async fn s3_that_does_not_answer_is_an_outage_until_it_does() {
    let server = S3Server::shared();
    // A port that was free a moment ago.
    let port = std::net::TcpListener::bind("127.0.0.1:0").and_then(|l| l.local_addr()).expect("binds").port();
    let gone = S3Server { url: format!("http://127.0.0.1:{port}") };
    let health = Health::new();
    let outage = health.outage();
    let blobs = gone.blobs_with("outage", "", HOUR, health.clone());
    let error = blobs.put(&b"hello table"[..]).await.expect_err("nobody listens");
    assert_eq!(error.outage(), Some(Outage::Other), "{}", error.chain());
    assert_eq!(*outage.borrow(), Some(Outage::Other));
    // Creates the bucket.
    server.blobs("outage", "", HOUR);
    let again = server.blobs_with("outage", "", HOUR, health);
    again.probe().await.expect("answers");
    assert_eq!(*outage.borrow(), None);
}
