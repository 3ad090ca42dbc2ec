//! The binary, from outside: usage errors, configuration, serving and stopping.

use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::path::Path;
use std::process::{Child, Command, Output, Stdio};
use std::time::Duration;

use serde_json::Value;

use super::signals;

pub(super) fn tabletopgen(directory: &Path, arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_tabletopgen"));
    command.args(arguments).current_dir(directory).env_remove("TABLETOPGEN__WORKER__FAN_OUT");
    command
}

pub(super) fn run(directory: &Path, arguments: &[&str]) -> Output {
    tabletopgen(directory, arguments).output().expect("starts")
}

pub(super) fn text(bytes: &[u8]) -> String {
    String::from_utf8(bytes.to_vec()).expect("is UTF-8")
}

#[test]
fn version_and_help() {
    let home = tempfile::tempdir().unwrap();
    let version = run(home.path(), &["--version"]);
    assert_eq!(text(&version.stdout), format!("tabletopgen {}\n", env!("CARGO_PKG_VERSION")));
    assert_eq!(version.status.code(), Some(0));
    let help = text(&run(home.path(), &["--help"]).stdout);
    for command in
        ["generate", "edit", "diff", "batch", "parse", "serve", "worker", "queue", "migrate", "check-config"]
    {
        assert!(help.contains(command), "{help}");
    }
    assert!(text(&run(home.path(), &["generate", "--help"]).stdout).contains("--artifacts"));
}

#[test]
fn what_will_not_do_is_said_before_the_work() {
    let home = tempfile::tempdir().unwrap();
    let path = |name: &str| home.path().join(name).display().to_string();
    std::fs::write(path("no_picture.png"), "not a picture").unwrap();
    std::fs::write(path("file"), "").unwrap();
    std::fs::create_dir(path("full")).unwrap();
    std::fs::write(path("full/thesis.tex"), "years of work").unwrap();
    let no_image = path("no_picture.png");
    for (arguments, code, says) in [
        (vec![], 2, "Usage"),
        (vec!["generate"], 2, "--text"),
        (vec!["generate", "--text", "a", "--image", "b"], 2, "cannot read the image b"),
        (vec!["generate", "--text", "  "], 2, "--text is empty"),
        (
            vec!["generate", "--image", "missing.png"],
            2,
            "cannot read the image missing.png: there is no such file",
        ),
        (vec!["generate", "--image", "full"], 2, "is not a file"),
        (vec!["generate", "--image", &no_image], 2, "no PNG, JPEG or WebP"),
        (vec!["generate", "--text", "a mug", "--seed", "-1"], 2, "--seed"),
        (vec!["generate", "--text", "a mug", "--seed", "9007199254740992"], 2, "9007199254740991"),
        (vec!["generate", "--text", "a mug", "--max-objects", "0"], 2, "give a whole number from 1 to 64"),
        (
            vec!["generate", "--text", "a mug", "--robot", "hal"],
            2,
            "--robot must be one of panda, piper, not \"hal\"",
        ),
        (vec!["generate", "--text", "a mug", "--threads", "9999"], 2, "worker.cpu_threads (--threads): 9999"),
        (vec!["generate", "--text", "a mug", "--set", "dro.keeep=2"], 2, "nearest is dro.keep"),
        (
            vec!["generate", "--text", "a mug", "--set", "dro.keep=0"],
            2,
            "dro.keep (--set): 0 is outside its range",
        ),
        (vec!["generate", "--text", "a mug", "--set", "dro.keep=x"], 2, "not a whole number"),
        (vec!["generate", "--text", "a mug", "--set", "dro.keep"], 2, "key=value"),
        (vec!["generate", "--text", "a mug", "--config", "none.toml"], 2, "none.toml: cannot be read"),
        (vec!["generate", "--text", "a mug", "--out", "file"], 2, "is a file"),
        (vec!["generate", "--text", "a mug", "--out", "full"], 2, "no part of a bundle (thesis.tex)"),
        (
            vec!["generate", "--text", "a mug", "--out", "/proc/none/out"],
            1,
            "cannot write into /proc/none/out",
        ),
        (vec!["generate", "--text", "a mug", "--data-dir", "/proc/none"], 1, "/proc/none"),
        (vec!["generate", "--text", "a mug", "--on-unknown", "guess"], 2, "stand-in"),
        (vec!["parse"], 2, "<TEXT>"),
        (vec!["parse", "  "], 2, "TEXT is empty"),
        (vec!["parse", "a mug", "--max-objects", "many"], 2, "give a whole number from 1 to 64"),
        (vec!["parse", "a mug and a qwrtz", "--on-unknown", "fail"], 2, "qwrtz"),
        (vec!["parse", "a mug", "--set", "providers.analyst=chat"], 2, "remote model"),
        (vec!["serve", "--role", "api"], 2, "the database is a SQLite file"),
        (vec!["serve", "--role", "worker", "--listen", "127.0.0.1:0"], 2, "or use --role all"),
        (vec!["serve", "--role", "both"], 2, "possible values: all, api, worker"),
        (vec!["worker", "--slots", "2"], 2, "set store.database to a PostgreSQL address"),
        (vec!["worker", "--slots", "65"], 2, "worker.concurrency (--slots): 65 is outside its range"),
        (vec!["worker", "--slots", "0"], 2, "give a whole number, 1 or more"),
        (vec!["serve", "--listen", "nowhere"], 2, "server.listen (--listen)"),
        (vec!["serve", "--listen", "203.0.113.1:1"], 1, "give --allow-unauthenticated"),
        (
            vec!["serve", "--listen", "203.0.113.1:1", "--allow-unauthenticated"],
            1,
            "cannot listen on 203.0.113.1:1",
        ),
        (vec!["serve", "--listen", "127.0.0.1:0", "--data-dir", "file"], 1, "cannot use data directory"),
        (vec!["check-config", "--set", "worker.lease_secs=1"], 2, "worker.lease_secs (--set): 1"),
        (vec!["dance"], 2, "unrecognized subcommand"),
    ] {
        let done = run(home.path(), &arguments);
        let complaint = text(&done.stderr);
        assert_eq!(done.status.code(), Some(code), "{arguments:?}: {complaint}");
        assert!(complaint.contains(says), "{arguments:?}: {complaint}");
        assert!(!complaint.contains("panicked") && !complaint.contains("RUST_BACKTRACE"), "{complaint}");
        assert!(done.stdout.is_empty(), "{arguments:?}: {}", text(&done.stdout));
        assert!(!home.path().join("out").exists(), "{arguments:?} left a folder");
    }
}

#[test]
fn the_configuration_is_shown_with_its_origins() {
    let home = tempfile::tempdir().unwrap();
    std::fs::write(home.path().join("site.toml"), "[worker]\nlease_secs = 60\n").unwrap();
    let arguments = ["check-config", "--config", "site.toml", "--set", "dro.keep=4"];
    let shown =
        tabletopgen(home.path(), &arguments).env("TABLETOPGEN__WORKER__FAN_OUT", "2").output().unwrap();
    let shown = text(&shown.stdout);
    for line in [
        "lease_secs = 60  # file site.toml",
        "fan_out = 2  # environment TABLETOPGEN__WORKER__FAN_OUT",
        "keep = 4  # --set",
        "poll_ms = 1000\n",
    ] {
        assert!(shown.contains(line), "{line} is missing in\n{shown}");
    }
    std::fs::write(home.path().join("shown.toml"), &shown).unwrap();
    let again = text(&run(home.path(), &["check-config", "--config", "shown.toml"]).stdout);
    let values =
        |text: &str| text.lines().map(|l| l.split("  #").next().unwrap().to_owned()).collect::<Vec<_>>();
    assert_eq!(values(&again), values(&shown), "what is shown reads back");

    let json = run(home.path(), &["check-config", "--json"]);
    let json: Value = serde_json::from_slice(&json.stdout).expect("is JSON");
    let key = &json["worker.lease_secs"];
    assert_eq!(
        (&key["value"], &key["origin"], &key["unit"]),
        (&30.into(), &"default".into(), &"seconds".into())
    );
    assert_eq!(key["range"], serde_json::json!({ "low": 5.0, "high": 3600.0 }));

    let unknown =
        tabletopgen(home.path(), &["check-config"]).env("TABLETOPGEN__WORKER__FANOUT", "2").output();
    let unknown = unknown.unwrap();
    assert_eq!(unknown.status.code(), Some(2));
    assert!(text(&unknown.stderr).contains("worker.fan_out"), "{}", text(&unknown.stderr));
}

#[test]
fn migrate_creates_a_data_directory_with_the_option_create() {
    let home = tempfile::tempdir().unwrap();
    for arguments in [&["migrate", "--create", "--data-dir", "d"][..], &["migrate", "--data-dir", "d"]] {
        let done = run(home.path(), arguments);
        assert_eq!((done.status.code(), text(&done.stdout).as_str()), (Some(0), "d is up to date\n"));
    }
    assert!(home.path().join("d/tabletopgen.sqlite").exists());
}

/// Commands on existing data, with a data directory that is mistyped.
#[test]
fn a_mistyped_data_directory_is_an_error_and_is_not_created() {
    let home = tempfile::tempdir().unwrap();
    for command in [
        &["sweep"][..],
        &["sweep", "--dry-run"],
        &["migrate"],
        &["queue", "status"],
        &["queue", "pause"],
        &["queue", "resume"],
        &["backup", "copy"],
        &["restore", "--verify"],
        &["restore", "--verify", "copy"],
        &["restore", "copy"],
    ] {
        let done = run(home.path(), &[command, &["--data-dir", "daat"]].concat());
        let says = text(&done.stderr);
        assert_eq!(done.status.code(), Some(1), "{command:?}: {says}");
        assert!(says.contains("no database of tabletopgen in"), "{command:?}: {says}");
        let place = if command.contains(&"copy") && command[0] == "restore" { "copy" } else { "daat" };
        assert!(says.contains(place) && says.contains("tabletopgen.sqlite"), "{command:?}: {says}");
        let left: Vec<_> = std::fs::read_dir(home.path()).unwrap().collect();
        assert!(left.is_empty(), "{command:?} leaves {left:?}");
    }
}

/// A server process; killed when the test ends without stopping it.
struct Serving {
    process: Child,
    address: String,
}

impl Drop for Serving {
    fn drop(&mut self) {
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}

fn serve(directory: &Path, more: &[&str]) -> Serving {
    let mut arguments = vec!["serve", "--listen", "127.0.0.1:0", "--data-dir", "d"];
    arguments.extend(more);
    let mut command = tabletopgen(directory, &arguments);
    let log = std::fs::File::create(directory.join("log")).unwrap();
    let mut process = command.stdout(Stdio::piped()).stderr(log).spawn().expect("starts");
    let mut line = String::new();
    BufReader::new(process.stdout.as_mut().unwrap()).read_line(&mut line).unwrap();
    let address =
        line.trim().strip_prefix("listening on http://").unwrap_or_else(|| panic!("{line:?}")).to_owned();
    Serving { process, address }
}

impl Serving {
    fn get(&self, path: &str) -> String {
        let mut socket = TcpStream::connect(&self.address).expect("connects");
        socket.set_read_timeout(Some(Duration::from_secs(10))).unwrap();
        write!(socket, "GET {path} HTTP/1.1\r\nhost: {}\r\nconnection: close\r\n\r\n", self.address).unwrap();
        let mut answer = String::new();
        socket.read_to_string(&mut answer).unwrap();
        answer
    }

    fn signal(&mut self, name: &str) -> Option<i32> {
        let sent = Command::new("kill").args([name, &self.process.id().to_string()]).status().unwrap();
        assert!(sent.success());
        self.process.wait().unwrap().code()
    }
}

#[test]
fn a_server_says_where_it_is_answers_and_stops_when_asked() {
    let home = tempfile::tempdir().unwrap();
    for signal in signals::that_stop() {
        let mut serving = serve(home.path(), &["--set", "log.format=json"]);
        assert!(serving.get("/readyz").contains("\"ready\""));
        assert!(serving.get("/version").contains(env!("CARGO_PKG_VERSION")));
        let second = run(home.path(), &["serve", "--listen", "127.0.0.1:0", "--data-dir", "d"]);
        assert_eq!(second.status.code(), Some(1));
        assert!(text(&second.stderr).contains("in use by another process"), "{}", text(&second.stderr));
        assert_eq!(serving.signal(signal), Some(0), "{signal}");
        let log = std::fs::read_to_string(home.path().join("log")).unwrap();
        let lines: Vec<&str> = log.lines().filter(|line| line.starts_with('{')).collect();
        assert!(lines.iter().all(|line| serde_json::from_str::<Value>(line).is_ok()), "{log}");
        assert!(log.contains("stopped in good order"), "{log}");
    }
}

#[test]
fn an_outage_is_said_once() {
    let home = tempfile::tempdir().unwrap();
    let quick = [
        "store.busy_timeout_ms=1",
        "worker.poll_ms=10",
        "worker.backoff_base_ms=1",
        "worker.backoff_cap_ms=20",
    ];
    let set: Vec<&str> = quick.iter().flat_map(|pair| ["--set", pair]).collect();
    let mut serving = serve(home.path(), &set);
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build().unwrap();
    runtime.block_on(async {
        use sqlx::Connection;
        let options =
            sqlx::sqlite::SqliteConnectOptions::new().filename(home.path().join("d/tabletopgen.sqlite"));
        let mut holder = sqlx::SqliteConnection::connect_with(&options).await.unwrap();
        sqlx::query("BEGIN IMMEDIATE").execute(&mut holder).await.unwrap();
        tokio::time::sleep(Duration::from_millis(1000)).await;
        sqlx::query("ROLLBACK").execute(&mut holder).await.unwrap();
        tokio::time::sleep(Duration::from_millis(300)).await;
    });
    assert!(serving.get("/readyz").contains("200 OK"));
    assert_eq!(serving.signal("-TERM"), Some(0));
    let log = std::fs::read_to_string(home.path().join("log")).unwrap();
    assert_eq!(log.matches("storage takes no writes").count(), 1, "{log}");
    assert_eq!(log.matches("ERROR").count(), 1, "{log}");
    assert_eq!(log.matches("storage takes writes again").count(), 1, "{log}");
}
