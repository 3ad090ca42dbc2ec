//! Reasons why there is no server, or why its processes get no signal.

use std::io;
use std::path::PathBuf;
use std::time::Duration;

/// Reason why there is no server, or why its processes get no signal.
#[derive(Debug, thiserror::Error)]
pub(crate) enum ServerError {
    #[error(
        "neither initdb nor postgres is on the path or in /usr/lib/postgresql; install PostgreSQL, or name a server \
         in TABLETOPGEN_TEST_POSTGRES_URL"
    )]
    NotInstalled,
    #[error("cannot {attempt}: {error}")]
    Failed { attempt: &'static str, error: io::Error },
    #[error("cannot give {} to an unprivileged user: {error}", .directory.display())]
    NotGiven { directory: PathBuf, error: io::Error },
    #[error("no free port: {0}")]
    NoPort(io::Error),
    #[error("initdb failed: {stderr}")]
    Initdb { stderr: String },
    #[error("the server did not start within {timeout:?}: {log}")]
    NotStarted { timeout: Duration, log: String },
    #[error("{}: {error}", .path.display())]
    Unreadable { path: PathBuf, error: io::Error },
}

impl ServerError {
    pub(crate) fn failed(attempt: &'static str) -> impl FnOnce(io::Error) -> Self {
        move |error| Self::Failed { attempt, error }
    }

    pub(crate) fn unreadable(path: impl Into<PathBuf>) -> impl FnOnce(io::Error) -> Self {
        move |error| Self::Unreadable { path: path.into(), error }
    }
}
