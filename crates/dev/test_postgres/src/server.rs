//! Start and end of the server.

use std::net::{Ipv4Addr, TcpListener, TcpStream};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use crate::error::ServerError;
use crate::programs;

/// Maximum time until a started server answers.
const START_TIMEOUT: Duration = Duration::from_secs(60);

/// Runs the server (arguments 3 and following) until the input ends, which it does with the test process; then stops it
/// and removes its directory (argument 1). Argument 2 is the log.
const KEEPER: &str = r#"
directory=$1; log=$2; shift 2
"$@" >"$log" 2>&1 </dev/null &
server=$!
cat >/dev/null
kill -INT "$server"
wait "$server"
rm -rf "$directory"
"#;

/// A server that runs.
pub(crate) struct Server {
    /// The address of its first database.
    pub(crate) url: String,
    data: PathBuf,
}

impl Server {
    /// Starts a server that lives as long as this process.
    pub(crate) fn start() -> Result<Self, ServerError> {
        let programs_in = programs::directory()?;
        let directory = tempfile::Builder::new()
            .prefix("tabletopgen-postgres-")
            .tempdir()
            .map_err(ServerError::failed("create a temporary directory"))?
            .keep();
        programs::give_away(&directory)?;
        let data = directory.join("data");
        initialize(&programs_in.join("initdb"), &data)?;
        let port = free_port()?;
        let log = directory.join("log");
        let mut keeper = programs::unprivileged(Path::new("sh"));
        keeper.args(["-c", KEEPER, "sh"]).arg(&directory).arg(&log).arg(programs_in.join("postgres"));
        keeper.arg("-D").arg(&data).args(["-h", "127.0.0.1", "-p", &port.to_string(), "-k", ""]);
        for setting in ["fsync=off", "max_connections=300", "shared_buffers=32MB"] {
            keeper.args(["-c", setting]);
        }
        // The keeper's input stays open until this process ends; it must not close when this function returns.
        let child = keeper
            .stdin(Stdio::piped())
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()
            .map_err(ServerError::failed("start the server"))?;
        std::mem::forget(child);
        wait_for(port, &log)?;
        Ok(Self { url: format!("postgres://postgres@127.0.0.1:{port}/postgres"), data })
    }

    /// Sends a signal to the server and to the processes of its connections.
    pub(crate) fn signal(&self, signal: &str) -> Result<(), ServerError> {
        let note = self.data.join("postmaster.pid");
        let text = std::fs::read_to_string(&note).map_err(ServerError::unreadable(note))?;
        let server = text.lines().next().unwrap_or_default().to_owned();
        // The server first, so that it starts no further process.
        send(signal, std::slice::from_ref(&server))?;
        let children = children_of(&server)?;
        send(signal, &children)
    }
}

fn initialize(initdb: &Path, data: &Path) -> Result<(), ServerError> {
    let mut command: Command = programs::unprivileged(initdb);
    command.args([
        "--auth=trust",
        "--username=postgres",
        "--encoding=UTF8",
        "--no-locale",
        "--no-sync",
        "-D",
    ]);
    let output = command.arg(data).output().map_err(ServerError::failed("run initdb"))?;
    if output.status.success() {
        return Ok(());
    }
    Err(ServerError::Initdb { stderr: String::from_utf8_lossy(&output.stderr).into_owned() })
}

/// A port that was free a moment ago.
fn free_port() -> Result<u16, ServerError> {
    TcpListener::bind((Ipv4Addr::LOCALHOST, 0))
        .and_then(|listener| listener.local_addr())
        .map(|address| address.port())
        .map_err(ServerError::NoPort)
}

/// Returns when the server says in its log that it takes connections.
fn wait_for(port: u16, log: &Path) -> Result<(), ServerError> {
    let began = Instant::now();
    loop {
        let text = std::fs::read_to_string(log).unwrap_or_default();
        let is_ready = text.contains("ready to accept connections");
        if is_ready && TcpStream::connect((Ipv4Addr::LOCALHOST, port)).is_ok() {
            return Ok(());
        }
        if began.elapsed() > START_TIMEOUT {
            return Err(ServerError::NotStarted { timeout: START_TIMEOUT, log: text });
        }
        std::thread::sleep(Duration::from_millis(50));
    }
}

/// Processes that a process started.
fn children_of(parent: &str) -> Result<Vec<String>, ServerError> {
    let processes = std::fs::read_dir("/proc").map_err(ServerError::unreadable("/proc"))?;
    let is_child = |id: &String| {
        let stat = std::fs::read_to_string(format!("/proc/{id}/stat")).unwrap_or_default();
        // After the name in parentheses come the state and the parent.
        stat.rsplit_once(')').and_then(|(_, rest)| rest.split_whitespace().nth(1)) == Some(parent)
    };
    let ids = processes.filter_map(|entry| entry.ok()?.file_name().into_string().ok());
    Ok(ids.filter(|name| name.bytes().all(|byte| byte.is_ascii_digit())).filter(is_child).collect())
}

fn send(signal: &str, processes: &[String]) -> Result<(), ServerError> {
    if processes.is_empty() {
        return Ok(());
    }
    let sent = Command::new("kill").arg(format!("-{signal}")).args(processes).status();
    // A connection may have ended meanwhile.
    sent.map(|_| ()).map_err(ServerError::failed("run kill"))
}
