//! `backup`, `restore` and `sweep`, beside a server that runs.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::sync::Arc;

use serde_json::Value;

use crate::harness::script::Script;
use crate::harness::server::Server;

fn run(arguments: &[&str], directories: &[(&str, &Path)]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_tabletopgen"));
    command.args(arguments);
    for (option, path) in directories {
        match *option {
            "" => command.arg(path),
            option => command.arg(option).arg(path),
        };
    }
    command.output().expect("starts")
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8(bytes.to_vec()).expect("is UTF-8")
}

fn any_blob(folder: &Path) -> PathBuf {
    let shard = std::fs::read_dir(folder.join("blobs/sha256")).unwrap().next().unwrap().unwrap();
    std::fs::read_dir(shard.path()).unwrap().next().unwrap().unwrap().path()
}

#[tokio::test(flavor = "multi_thread")]
async fn a_server_is_backed_up_while_it_runs_and_restored() {
    let home = tempfile::tempdir().unwrap();
    let (copy, again) = (home.path().join("copy"), home.path().join("again"));
    let server = Server::start(&Script::new(&[])).await;
    let (scene, job) = server.submit("a mug").await;
    server.job_is(&job, "succeeded").await;
    let path = format!("/scenes/{scene}/bundle");
    let bundle = server.get(&path).await;
    let data = server.directory.path().to_owned();

    let done = run(&["backup"], &[("", &copy), ("--data-dir", &data)]);
    assert_eq!(done.status.code(), Some(0), "{done:?}");
    assert!(text(&done.stdout).contains(" new ("), "{done:?}");
    let in_use = run(&["sweep"], &[("--data-dir", &data)]);
    assert_eq!(in_use.status.code(), Some(1));
    assert!(text(&in_use.stderr).contains("in use by another process"), "{in_use:?}");

    assert_eq!(run(&["restore", "--verify"], &[("", &copy)]).status.code(), Some(0));
    let restored = run(&["restore"], &[("", &copy), ("--data-dir", &again)]);
    assert_eq!(restored.status.code(), Some(0), "{restored:?}");
    assert_eq!(run(&["restore", "--verify"], &[("--data-dir", &again)]).status.code(), Some(0));
    let twice = run(&["restore"], &[("", &copy), ("--data-dir", &again)]);
    assert_eq!(twice.status.code(), Some(1), "a directory with a database is not overwritten");
    let grace = "store.retention.grace_secs=601";
    let dry = run(&["sweep", "--dry-run", "--json", "--set", grace], &[("--data-dir", &again)]);
    let report: Value = serde_json::from_slice(&dry.stdout).expect("is JSON");
    assert_eq!((&report["is_dry_run"], &report["removed"]["blobs"]), (&true.into(), &0.into()));
    assert!(report["kept"]["blobs"].as_u64().unwrap() > 4, "{report}");

    std::fs::write(any_blob(&copy), "something else").unwrap();
    let damaged = run(&["restore", "--verify"], &[("", &copy)]);
    assert_eq!(damaged.status.code(), Some(1));
    assert!(text(&damaged.stderr).contains("does not match its digest"), "{damaged:?}");

    let restored = tempfile::tempdir_in(home.path()).unwrap();
    std::fs::remove_dir(restored.path()).unwrap();
    std::fs::rename(&again, restored.path()).unwrap();
    let server = Server::on(Arc::new(restored), &Script::new(&[]), &[]).await;
    assert_eq!(server.get(&path).await.body, bundle.body);
}
