//! The image generator writes down the poses it rendered, for evaluation. No stage may profit from them.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::Command;

use serde_json::Value;
use store::Digest;

const TRUTH: &str = "artifacts/reference/truth.json";

fn generate(data_dir: &Path, out: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
    let made = Command::new(env!("CARGO_BIN_EXE_tabletopgen"))
        .args(["generate", "--text", "a round table with a mug and a book", "--seed", "5", "--artifacts"])
        .arg("--data-dir")
        .arg(data_dir)
        .arg("--out")
        .arg(out)
        .output()
        .unwrap();
    assert!(made.status.success(), "{}", String::from_utf8_lossy(&made.stderr));
    let mut files = BTreeMap::new();
    let mut folders = vec![out.to_owned()];
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.push(path);
            } else {
                files.insert(path.strip_prefix(out).unwrap().to_owned(), std::fs::read(&path).unwrap());
            }
        }
    }
    files
}

#[tokio::test]
async fn a_scrambled_truth_changes_no_other_file() {
    let (data, first, second) =
        (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    let mut before = generate(data.path(), first.path());
    let truth = before.remove(Path::new(TRUTH)).unwrap();
    assert!(String::from_utf8_lossy(&truth).contains("yaw_rad"));
    let track: Value = serde_json::from_slice(&before[Path::new("artifacts/certify/track.json")]).unwrap();
    assert_eq!((&track["rate_hz"], &track["duration_s"]), (&30.0.into(), &5.0.into()));
    for simulation in ["from_shipped", "from_aligned"] {
        let bodies = track[simulation].as_object().expect("bodies");
        assert_eq!(bodies.keys().collect::<Vec<_>>(), ["book_1", "mug_1", "table"], "{simulation}");
        assert!(bodies.values().all(|poses| poses.as_array().is_some_and(|poses| poses.len() < 152)));
    }

    // Everything after the reference image is forgotten, and the truth is a lie.
    let url = format!("sqlite://{}", data.path().join("tabletopgen.sqlite").display());
    let pool = sqlx::SqlitePool::connect(&url).await.unwrap();
    let forgotten = sqlx::query("DELETE FROM checkpoints WHERE stage != 'reference'");
    assert!(forgotten.execute(&pool).await.unwrap().rows_affected() >= 11);
    let lie = String::from_utf8(truth.clone()).unwrap().replace(['1', '2', '3'], "7");
    let (message, lied) = (Digest::of(&truth).to_string(), Digest::of(lie.as_bytes()).to_string());
    let folder = data.path().join("blobs/sha256").join(&lied[..2]);
    std::fs::create_dir_all(&folder).unwrap();
    std::fs::write(folder.join(&lied), &lie).unwrap();
    let exchanged = sqlx::query("UPDATE checkpoints SET artifacts = replace(artifacts, ?, ?)");
    exchanged.bind(message).bind(lied).execute(&pool).await.unwrap();
    pool.close().await;

    let mut after = generate(data.path(), second.path());
    assert_eq!(after.remove(Path::new(TRUTH)), Some(lie.into_bytes()));
    let differing: Vec<_> =
        before.keys().chain(after.keys()).filter(|path| before.get(*path) != after.get(*path)).collect();
    assert!(differing.is_empty(), "{differing:?}");
}
