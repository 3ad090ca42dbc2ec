//! Backup while the store is open, restoration, and what the check finds.

use std::collections::BTreeMap;

use serde_json::json;

use super::super::scenes::{NewScene, SceneFilter};
use super::super::{BlobPlace, DEFAULT_TENANT, Intent};
use super::*;

fn settings() -> Settings {
    let settings: Settings = test_settings::section("store");
    Settings { fsync: false, blobs: BlobPlace::Files, ..settings }
}

/// A store with one scene, whose request names an image.
async fn opened(directory: &Path) -> (Store, Digest) {
    let store = Store::open(directory, &settings(), Intent::Create).await.expect("opens");
    let image = store.blobs().put("image").await.expect("puts");
    submit(&store, &image).await;
    (store, image)
}

async fn submit(store: &Store, image: &Digest) {
    let new = NewScene {
        tenant_id: DEFAULT_TENANT.clone(),
        parent_id: None,
        request: json!({ "input": { "sha256": image.as_str() } }),
        labels: BTreeMap::new(),
        budget_micro_usd: 0,
        idempotency: None,
    };
    store.submit(new).await.expect("submits");
}

fn file_of(directory: &Path, digest: &Digest) -> PathBuf {
    directory.join("blobs/sha256").join(&digest.as_str()[..2]).join(digest.as_str())
}

#[tokio::test]
async fn a_backup_of_a_store_in_use_becomes_a_store() {
    let folder = tempfile::tempdir().expect("temporary directory");
    let (data, copy, again) =
        (folder.path().join("data"), folder.path().join("copy"), folder.path().join("again"));
    let (store, image) = opened(&data).await;
    let report = backup(&data, &copy, &settings(), &mut |_, _| {}).await.expect("backs up");
    assert_eq!((report.intact.blobs, report.copied.blobs, report.lost.len()), (1, 1, 0));
    let second = store.blobs().put("second").await.expect("puts");
    submit(&store, &second).await;
    let report = backup(&data, &copy, &settings(), &mut |_, _| {}).await.expect("backs up again");
    assert_eq!((report.intact.blobs, report.copied.blobs), (2, 1), "only what is new is copied");

    assert_eq!(verify(&copy, &settings(), &mut |_, _| {}).await.expect("reads").intact.blobs, 2);
    let report = restore(&copy, &again, &settings(), &mut |_, _| {}).await.expect("restores");
    assert_eq!((report.copied.blobs, report.lost.len()), (2, 0));
    let restored = Store::open(&again, &settings(), Intent::Create).await.expect("opens");
    let all = SceneFilter { limit: 10, ..SceneFilter::default() };
    assert_eq!(restored.scenes(&DEFAULT_TENANT, all).await.expect("reads").len(), 2);
    assert_eq!(restored.blobs().get(&image).await.expect("reads").as_deref(), Some(&b"image"[..]));
    assert_eq!(restored.verify(&mut |_, _| {}).await.expect("reads").intact.blobs, 2);
    drop(restored);
    let error = restore(&copy, &again, &settings(), &mut |_, _| {}).await.expect_err("there is a database");
    assert!(matches!(error, StoreError::DataDir { .. } | StoreError::Locked { .. }), "{error}");
}

#[tokio::test]
async fn the_check_finds_missing_and_damaged_blobs() {
    let folder = tempfile::tempdir().expect("temporary directory");
    let (data, copy) = (folder.path().join("data"), folder.path().join("copy"));
    let (store, image) = opened(&data).await;
    let second = store.blobs().put("second").await.expect("puts");
    submit(&store, &second).await;
    backup(&data, &copy, &settings(), &mut |_, _| {}).await.expect("backs up");
    std::fs::write(file_of(&copy, &image), b"imagE").expect("damages");
    std::fs::remove_file(file_of(&copy, &second)).expect("removes");
    let report = verify(&copy, &settings(), &mut |_, _| {}).await.expect("reads");
    let mut expected = vec![
        LostBlob { digest: image.clone(), kind: ReferenceKind::Input, is_damaged: true },
        LostBlob { digest: second, kind: ReferenceKind::Input, is_damaged: false },
    ];
    expected.sort_by(|a, b| a.digest.cmp(&b.digest));
    assert_eq!(report.lost, expected);
    assert_eq!(report.intact.blobs, 0);

    std::fs::write(file_of(&data, &image), b"imagE").expect("damages");
    let report = store.verify(&mut |_, _| {}).await.expect("reads");
    assert_eq!((report.intact.blobs, report.lost.len()), (1, 1));
    assert!(store.blobs().contains(&image).await.expect("answers"), "the check changes nothing");
}

#[tokio::test]
async fn a_backup_and_a_sweep_exclude_each_other() {
    let folder = tempfile::tempdir().expect("temporary directory");
    let (store, _) = opened(folder.path()).await;
    let retention = settings().retention;
    let lock = store.blobs().lock_against_sweep().await.expect("locks");
    let _second = store.blobs().lock_against_sweep().await.expect("two backups do not exclude each other");
    assert_eq!(store.sweep(&retention, true).await.expect("answers"), None);
    drop((lock, _second));
    assert!(store.sweep(&retention, true).await.expect("answers").is_some());
}

#[tokio::test]
async fn a_folder_without_a_database_is_refused() {
    let folder = tempfile::tempdir().expect("temporary directory");
    let (empty, target) = (folder.path().join("empty"), folder.path().join("target"));
    for error in [
        backup(&empty, &target, &settings(), &mut |_, _| {}).await.expect_err("no database"),
        restore(&empty, &target, &settings(), &mut |_, _| {}).await.expect_err("no database"),
        verify(&empty, &settings(), &mut |_, _| {}).await.expect_err("no database"),
    ] {
        assert!(matches!(error, StoreError::NoDatabase { .. }), "{error}");
    }
    assert!(!target.join(DATABASE_FILE).exists());
}
