//! Files that a command reads: a complaint names the file, what it should be, and what to give.

use std::io;
use std::path::Path;

use serde::de::DeserializeOwned;

use super::Failure;

/// The text of a file. `what` is what it should be, such as `the task`; `advice` says what to give.
///
/// # Errors
///
/// A [`Failure`] of kind usage.
pub fn text(path: &Path, what: &str, advice: &str) -> Result<String, Failure> {
    std::fs::read_to_string(path).map_err(|error| unreadable(path, what, &error, advice))
}

/// The value that a JSON file holds.
///
/// # Errors
///
/// A [`Failure`] of kind usage.
pub fn json<T: DeserializeOwned>(path: &Path, what: &str, advice: &str) -> Result<T, Failure> {
    let text = text(path, what, advice)?;
    serde_json::from_str(&text).map_err(|error| {
        let place = path.display();
        Failure::usage(match error.is_syntax() || error.is_eof() {
            true => format!("{place} cannot be read as {what}, it is no JSON: {error}; {advice}"),
            false => format!("{place} cannot be read as {what}: {error}; {advice}"),
        })
    })
}

/// Failure of reading a file.
pub fn unreadable(path: &Path, what: &str, error: &io::Error, advice: &str) -> Failure {
    let place = path.display();
    let reason = match error.kind() {
        io::ErrorKind::NotFound => "there is no such file".to_owned(),
        io::ErrorKind::NotADirectory => "it is no folder".to_owned(),
        io::ErrorKind::IsADirectory => "it is a folder".to_owned(),
        io::ErrorKind::InvalidData => "it is no text in UTF-8".to_owned(),
        io::ErrorKind::PermissionDenied => "this user may not read it".to_owned(),
        _ => error.to_string(),
    };
    Failure::usage(format!("cannot read {what} {place}: {reason}; {advice}"))
}
