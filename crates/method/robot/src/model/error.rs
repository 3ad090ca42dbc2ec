//! Errors of a robot's file.

use thiserror::Error;

/// A robot's file that was refused. The message names the file and the key, and states what is expected.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum ModelError {
    #[error("robot file {source_name}: {path}: {problem}")]
    Invalid { source_name: String, path: String, problem: String },
    #[error("robot {name:?} is not built in; built in are {}", known.join(", "))]
    UnknownRobot { name: String, known: Vec<String> },
}

/// A value that is wrong, with the key where it stands; the name of the file is added at the top.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Refusal {
    pub path: String,
    pub problem: String,
}

pub(super) fn refuse<T>(path: impl Into<String>, problem: impl Into<String>) -> Result<T, Refusal> {
    Err(Refusal { path: path.into(), problem: problem.into() })
}

impl Refusal {
    pub(super) fn in_file(self, source_name: &str) -> ModelError {
        ModelError::Invalid { source_name: source_name.to_owned(), path: self.path, problem: self.problem }
    }
}
