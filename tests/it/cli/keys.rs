//! Keys and the record of changes on the command line, beside a server that runs; and its log, which has no secret.

use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::path::Path;
use std::process::{Child, Command, Output, Stdio};
use std::time::Duration;

use serde_json::{Value, json};

fn run(home: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_tabletopgen"))
        .args(arguments)
        .current_dir(home)
        .output()
        .expect("starts")
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

fn printed(home: &Path, arguments: &[&str]) -> String {
    let done = run(home, arguments);
    assert!(done.status.success(), "{arguments:?}: {}", text(&done.stderr));
    text(&done.stdout)
}

fn json_of(home: &Path, arguments: &[&str]) -> Value {
    serde_json::from_str(&printed(home, arguments)).expect("is JSON")
}

/// The program as a server with every line of its log; killed if the test fails.
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

impl Serving {
    fn start(home: &Path) -> Self {
        let set = [
            "server.authentication.mode=keys",
            "log.filter=trace",
            "log.format=json",
            "worker.cpu_threads=1",
        ];
        let log = std::fs::File::create(home.join("log")).unwrap();
        let mut process = Command::new(env!("CARGO_BIN_EXE_tabletopgen"))
            .args(["serve", "--listen", "127.0.0.1:0"])
            .args(set.iter().flat_map(|set| ["--set", set]))
            .current_dir(home)
            .stdout(Stdio::piped())
            .stderr(log)
            .spawn()
            .expect("starts");
        let mut line = String::new();
        BufReader::new(process.stdout.as_mut().unwrap()).read_line(&mut line).unwrap();
        let address = line.trim().strip_prefix("listening on http://").expect("listens").to_owned();
        Self { process, address }
    }

    /// The answer, header and body.
    fn call(&self, method: &str, path: &str, header: &str, body: &str) -> String {
        let mut socket = TcpStream::connect(&self.address).expect("connects");
        socket.set_read_timeout(Some(Duration::from_secs(30))).unwrap();
        let (host, length) = (&self.address, body.len());
        write!(
            socket,
            "{method} {path} HTTP/1.1\r\nhost: {host}\r\nconnection: close\r\ncontent-type: application/json\r\n\
             content-length: {length}\r\n{header}\r\n{body}"
        )
        .unwrap();
        let mut answer = String::new();
        socket.read_to_string(&mut answer).unwrap();
        answer
    }
}

fn status(answer: &str) -> u16 {
    answer.split(' ').nth(1).and_then(|status| status.parse().ok()).expect("has a status")
}

#[test]
fn keys_are_made_and_revoked_beside_a_server_whose_log_has_no_secret() {
    let home = tempfile::tempdir().unwrap();
    let home = home.path();
    let refused = run(home, &["keys", "list"]);
    assert!(text(&refused.stderr).contains("migrate --create"), "{}", text(&refused.stderr));
    printed(home, &["migrate", "--create"]);
    let plain = printed(home, &["keys", "create", "--name", "arm 1"]);
    let serving = Serving::start(home);
    let all = "read,submit,delete,operate,admin";
    let made = json_of(
        home,
        &[
            "keys",
            "create",
            "--name",
            "lab",
            "--tenant",
            "lab",
            "--scopes",
            all,
            "--expires",
            "90d",
            "--json",
        ],
    );
    let (key, id) = (made["key"].as_str().unwrap(), made["id"].as_str().unwrap());
    let authorization = format!("authorization: Bearer {key}\r\n");
    let session = serving.call("GET", "/session", &authorization, "");
    assert!(session.contains(&format!("key:{id}")) && session.contains(r#""tenant":"lab""#), "{session}");
    assert_eq!(status(&serving.call("GET", "/session", &format!("authorization: Bearer {plain}"), "")), 200);

    // Secrets wherever a client can put them.
    let begun = serving.call("POST", "/session", "", &json!({ "key": key }).to_string());
    assert_eq!(status(&begun), 204, "{begun}");
    let cookie = begun.lines().find_map(|line| line.strip_prefix("set-cookie: ")).expect("has a cookie");
    let pair = cookie.split(';').next().unwrap();
    let with_cookie = format!("cookie: {pair}\r\n");
    assert_eq!(status(&serving.call("POST", "/scenes", &with_cookie, r#"{"text":"a mug","seed":7}"#)), 202);
    let (wrong, wrong_cookie) = ("tt_wrong-5d4c3b", "tt_session=wrong-7e6f5a");
    assert_eq!(status(&serving.call("GET", "/jobs", &format!("authorization: Bearer {wrong}\r\n"), "")), 401);
    assert_eq!(status(&serving.call("GET", "/jobs", &format!("cookie: {wrong_cookie}\r\n"), "")), 401);
    assert_eq!(status(&serving.call("POST", "/session", "", &json!(key).to_string())), 422);
    assert_eq!(status(&serving.call("POST", "/session", "", &json!({ key: 1 }).to_string())), 422);
    let draft = r#"{"name":"made over HTTP","scopes":["read"]}"#;
    let over_http = serving.call("POST", "/keys", &authorization, draft);
    let over_http: Value = serde_json::from_str(over_http.split("\r\n\r\n").nth(1).unwrap()).unwrap();

    let list = json_of(home, &["keys", "list", "--json"]);
    assert_eq!(list["keys"].as_array().unwrap().len(), 3);
    let of_lab = printed(home, &["keys", "list", "--tenant", "lab"]);
    assert_eq!(of_lab.lines().count(), 2, "{of_lab}");
    assert_eq!(printed(home, &["keys", "revoke", id]), format!("revoked: {id}\n"));
    for header in [&authorization, &with_cookie] {
        assert_eq!(status(&serving.call("GET", "/session", header, "")), 401, "from the next request on");
    }
    assert!(printed(home, &["keys", "list"]).contains("revoked"));
    let unknown = run(home, &["keys", "revoke", "0192f3a4-5b6c-7d8e-9fa0-b1c2d3e4f5a6"]);
    assert!(text(&unknown.stderr).contains("keys list"), "{}", text(&unknown.stderr));

    let audit = printed(home, &["audit", "--tenant", "lab", "--json"]);
    let actions: Vec<(String, String)> = audit
        .lines()
        .map(|line| serde_json::from_str::<Value>(line).expect("is JSON"))
        .filter(|entry| entry["status"].as_u64().unwrap() < 300)
        .map(|entry| {
            (entry["principal"].as_str().unwrap().to_owned(), entry["action"].as_str().unwrap().to_owned())
        })
        .collect();
    let by = |principal: &str, action: &str| (principal.to_owned(), action.to_owned());
    let (own_key, own_session) = (format!("key:{id}"), format!("session:{id}"));
    let expected = [
        by("command line", "revokeKey"),
        by(&own_key, "createKey"),
        by(&own_session, "submitScene"),
        by(&own_session, "beginSession"),
        by("command line", "createKey"),
    ];
    assert_eq!(actions, expected);
    assert_eq!(printed(home, &["audit", "--since", "2100-01-01T00:00:00Z"]), "");

    drop(serving);
    let log = std::fs::read_to_string(home.join("log")).unwrap();
    let access = format!(r#""principal":"{own_key}""#);
    let access: Vec<&str> = log.lines().filter(|line| line.contains(&access)).collect();
    assert!(
        access.iter().any(|line| line.contains(r#""tenant":"lab""#)),
        "no line of a request says who asked"
    );
    let of_cookie = pair.split('=').nth(1).unwrap();
    let secrets = [key, plain.trim(), of_cookie, wrong, "wrong-7e6f5a", over_http["key"].as_str().unwrap()];
    for secret in secrets {
        let hidden = secret.trim_start_matches("tt_");
        assert!(hidden.len() > 5, "{secret}");
        for (place, text) in [("log", &log), ("record", &audit), ("list", &list.to_string())] {
            assert!(!text.contains(hidden), "{secret} is in the {place}");
        }
    }
}

#[test]
fn a_key_in_a_path_is_in_neither_log_nor_record() {
    let home = tempfile::tempdir().unwrap();
    let home = home.path();
    printed(home, &["migrate", "--create"]);
    let made = json_of(home, &["keys", "create", "--name", "me", "--scopes", "read,admin", "--json"]);
    let key = made["key"].as_str().unwrap();
    let serving = Serving::start(home);
    let authorization = format!("authorization: Bearer {key}\r\n");
    for (method, header) in [("DELETE", authorization.as_str()), ("DELETE", ""), ("GET", &authorization)] {
        for path in [format!("/keys/{key}"), format!("/{key}"), format!("/scenes/{key}/bundle")] {
            let refused = serving.call(method, &path, header, "");
            assert!((400..500).contains(&status(&refused)), "{refused}");
            assert!(!refused.contains(key), "{refused}");
        }
    }
    let audit = printed(home, &["audit", "--json"]);
    assert!(audit.contains(r#"/keys/tt_..."#), "{audit}");
    drop(serving);
    let log = std::fs::read_to_string(home.join("log")).unwrap();
    assert!(log.contains("/keys/tt_..."), "{log}");
    assert!(!audit.contains(key) && !log.contains(key), "{audit}{log}");
}

#[test]
fn what_will_not_do_is_said() {
    let home = tempfile::tempdir().unwrap();
    printed(home.path(), &["migrate", "--create"]);
    for (arguments, says) in [
        (&["keys", "create"][..], "--name"),
        (&["keys", "create", "--name", ""], "--name"),
        (&["keys", "create", "--name", "a", "--scopes", "read,all"], "\"all\" is no scope"),
        (&["keys", "create", "--name", "a", "--scopes", ","], "--scopes"),
        (&["keys", "create", "--name", "a", "--expires", "soon"], "such as 90d"),
        (&["keys", "create", "--name", "a", "--expires", "1s"], "1m to 3650d"),
        (&["keys", "create", "--name", "a", "--tenant", "a b"], "tenant"),
        (&["audit", "--since", "yesterday"], "--since"),
    ] {
        let done = run(home.path(), arguments);
        let complaint = text(&done.stderr);
        assert_eq!(done.status.code(), Some(2), "{arguments:?}: {complaint}");
        assert!(complaint.contains(says), "{arguments:?}: {complaint}");
    }
    assert_eq!(printed(home.path(), &["keys", "list"]), "");
}
