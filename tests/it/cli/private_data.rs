//! Data is for its own user alone: modes of a data directory and of a backup, under a umask that hides nothing.

use std::io::{BufRead, BufReader};
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use crate::harness::script::Script;
use crate::harness::server::Server;

/// Everything in a folder, the folder first.
fn all_in(folder: &Path) -> Vec<PathBuf> {
    let mut found = vec![folder.to_owned()];
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() { found.extend(all_in(&path)) } else { found.push(path) }
    }
    found
}

/// Entries that others than the user may use, each with its mode.
fn open_to_others(folder: &Path) -> Vec<String> {
    // The database removes its log when it closes, also between the listing and this.
    let mode = |path: &PathBuf| std::fs::metadata(path).map_or(0, |data| data.permissions().mode() & 0o777);
    let open = all_in(folder).into_iter().filter(|path| mode(path) & 0o077 != 0);
    open.map(|path| format!("{:o} {}", mode(&path), path.display())).collect()
}

fn open_all_to_others(folder: &Path) {
    for path in all_in(folder) {
        let mode = if path.is_dir() { 0o777 } else { 0o666 };
        std::fs::set_permissions(path, std::fs::Permissions::from_mode(mode)).unwrap();
    }
}

/// The program under a umask that takes no rights.
fn with_open_umask() -> Command {
    let mut command = Command::new("sh");
    command.args(["-c", "umask 000; exec \"$0\" \"$@\"", env!("CARGO_BIN_EXE_tabletopgen")]);
    command
}

/// Starts a server on a data directory, and stops it when it listens; its log.
fn serve_once(data: &Path) -> String {
    let mut command = with_open_umask();
    command.args(["serve", "--listen", "127.0.0.1:0", "--data-dir"]).arg(data);
    let mut process = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().expect("starts");
    let mut line = String::new();
    BufReader::new(process.stdout.as_mut().unwrap()).read_line(&mut line).unwrap();
    assert!(line.starts_with("listening"), "{line:?}");
    let open = open_to_others(data);
    assert!(Command::new("kill").arg(process.id().to_string()).status().unwrap().success());
    let ended = process.wait_with_output().unwrap();
    assert_eq!(open, Vec::<String>::new(), "while it runs");
    String::from_utf8(ended.stderr).unwrap()
}

#[tokio::test(flavor = "multi_thread")]
async fn what_is_kept_is_private_whatever_the_umask_and_however_it_was_left() {
    let server = Server::start(&Script::new(&[])).await;
    let (_, job) = server.submit("a mug").await;
    server.job_is(&job, "succeeded").await;
    let directory = server.stop().await;
    let data = directory.path();
    // Work folders of the freezer and the recorder have the umask of the process; the directory itself is private.
    assert_eq!(open_to_others(&data.join("blobs")), Vec::<String>::new());
    assert_eq!(std::fs::metadata(data).unwrap().permissions().mode() & 0o777, 0o700);

    open_all_to_others(data);
    let log = serve_once(data);
    assert!(log.contains("other users could read"), "{log}");
    let log = serve_once(data);
    assert!(!log.contains("other users"), "there was nothing left to repair: {log}");

    let new = data.join("new");
    serve_once(&new);
    assert_eq!(open_to_others(&new), Vec::<String>::new());

    if data.join("tabletopgen.sqlite").exists() {
        let place = tempfile::tempdir().unwrap();
        let copy = place.path().join("copy");
        let done = with_open_umask().arg("backup").arg(&copy).arg("--data-dir").arg(data).output().unwrap();
        assert!(done.status.success(), "{done:?}");
        assert_eq!(open_to_others(&copy), Vec::<String>::new());
        let again = place.path().join("again");
        let done =
            with_open_umask().arg("restore").arg(&copy).arg("--data-dir").arg(&again).output().unwrap();
        assert!(done.status.success(), "{done:?}");
        assert_eq!(open_to_others(&again), Vec::<String>::new());
    }
}
