//! Folders of the installed programs of PostgreSQL.

use std::path::{Path, PathBuf};
use std::process::Command;

use crate::error::ServerError;

/// User and group without rights of their own, which a server of the superuser runs as.
const UNPRIVILEGED_ID: &str = "65534";

/// The directory with `initdb` and `postgres`.
pub(crate) fn directory() -> Result<PathBuf, ServerError> {
    let named = std::env::var_os("TABLETOPGEN_POSTGRES_BIN").map(PathBuf::from);
    let path = std::env::var_os("PATH").unwrap_or_default();
    let mut installed: Vec<PathBuf> = std::fs::read_dir("/usr/lib/postgresql")
        .into_iter()
        .flatten()
        .filter_map(|version| Some(version.ok()?.path().join("bin")))
        .collect();
    installed.sort();
    named
        .into_iter()
        .chain(installed.into_iter().rev())
        .chain(std::env::split_paths(&path))
        .find(|directory| ["initdb", "postgres"].iter().all(|program| directory.join(program).is_file()))
        .ok_or(ServerError::NotInstalled)
}

/// Whether this process is the superuser, as whom no server starts.
pub(crate) fn is_superuser() -> bool {
    Command::new("id")
        .arg("-u")
        .output()
        .is_ok_and(|output| String::from_utf8_lossy(&output.stdout).trim() == "0")
}

/// A command that runs `program` as an unprivileged user.
pub(crate) fn unprivileged(program: &Path) -> Command {
    if !is_superuser() {
        return Command::new(program);
    }
    let mut command = Command::new("setpriv");
    command
        .args(["--reuid", UNPRIVILEGED_ID, "--regid", UNPRIVILEGED_ID, "--clear-groups", "--"])
        .arg(program);
    command
}

/// Gives a directory to the unprivileged user.
pub(crate) fn give_away(directory: &Path) -> Result<(), ServerError> {
    if !is_superuser() {
        return Ok(());
    }
    let id = UNPRIVILEGED_ID.parse().expect("a number");
    std::os::unix::fs::chown(directory, Some(id), Some(id))
        .map_err(|error| ServerError::NotGiven { directory: directory.to_owned(), error })
}
