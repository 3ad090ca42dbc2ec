//! Exit codes and failures of the program, for scripts.

use std::fmt;
use std::process::ExitCode;

/// Exit codes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Exit {
    /// 0: done; a generated scene passed its certificate, two scenes are equal.
    Success,
    /// 1: something around the program failed: disk, network, permissions.
    Error,
    /// 1, as of other programs that compare: two scenes differ. Every failure of the comparison is 2.
    Different,
    /// 2: the arguments, the configuration or the input will not do; nothing was begun.
    Usage,
    /// 3: the scene was made and its bundle written, and its certificate says quarantine.
    Quarantined,
    /// 4: the scene could not be made.
    JobFailed,
    /// 5: some requests of a batch have no scene that passes; the files of the batch say why.
    BatchIncomplete,
    /// 6: a robot did not do its task; the report says why.
    TaskFailed,
    /// 130: stopped with Ctrl-C, by SIGTERM or by SIGHUP.
    Interrupted,
}

impl Exit {
    /// The number that the process ends with.
    pub const fn code(self) -> u8 {
        match self {
            Self::Success => 0,
            Self::Error | Self::Different => 1,
            Self::Usage => 2,
            Self::Quarantined => 3,
            Self::JobFailed => 4,
            Self::BatchIncomplete => 5,
            Self::TaskFailed => 6,
            Self::Interrupted => 130,
        }
    }
}

impl From<Exit> for ExitCode {
    fn from(exit: Exit) -> Self {
        Self::from(exit.code())
    }
}

/// Failure that ends the program early: the exit code, and the message for people.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub struct Failure {
    pub exit: Exit,
    pub message: String,
    /// The problem document of the API that refused the input, for programs.
    pub problem: Option<serde_json::Value>,
}

impl Failure {
    pub fn new(exit: Exit, message: impl Into<String>) -> Self {
        Self { exit, message: message.into(), problem: None }
    }

    /// Arguments that will not do.
    pub fn usage(message: impl Into<String>) -> Self {
        Self::new(Exit::Usage, message)
    }
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.message)
    }
}

impl From<crate::app::AppError> for Failure {
    fn from(error: crate::app::AppError) -> Self {
        Self::new(Exit::Error, error.chain())
    }
}

impl From<crate::app::config::ConfigErrors> for Failure {
    fn from(errors: crate::app::config::ConfigErrors) -> Self {
        Self::usage(format!("the configuration will not do:\n{errors}"))
    }
}
