//! A single file that a command writes: in place whole or not at all, and never over another file unless forced.

use std::io::Write;
use std::path::Path;

use super::check_apart;
use crate::cli::{Exit, Failure};

/// Checks that a file may be written at `path`. `option` is the argument that names it.
///
/// # Errors
///
/// A [`Failure`] of kind usage for a folder, for a file that is not empty unless it is forced, and for an input.
pub fn check(path: &Path, option: &str, is_forced: bool, inputs: &[&Path]) -> Result<(), Failure> {
    check_apart(path, inputs).map_err(|failure| {
        let message = failure.message.replacen("--out", option, 1).replace("another folder", "another file");
        Failure { message, ..failure }
    })?;
    let place = path.display();
    match std::fs::metadata(path) {
        Ok(about) if about.is_dir() => {
            Err(Failure::usage(format!("{option} {place} is a folder; name a file, such as {place}/file")))
        }
        Ok(about) if about.is_file() && about.len() > 0 && !is_forced => Err(Failure::usage(format!(
            "{option} {place} exists; name another file, or add --force to replace it"
        ))),
        _ => Ok(()),
    }
}

/// Writes the file beside its place, syncs it and renames it. Devices and pipes are written to.
///
/// # Errors
///
/// A [`Failure`] if it cannot be written, or if a file came there since [`check`].
pub fn write(path: &Path, bytes: &[u8], is_forced: bool) -> Result<(), Failure> {
    let about = std::fs::metadata(path).ok();
    let written = match &about {
        Some(about) if !about.is_file() => std::fs::write(path, bytes),
        _ => replace(path, bytes, is_forced || about.as_ref().is_some_and(|about| about.len() == 0)),
    };
    written.map_err(|error| {
        Failure::new(Exit::Error, format!("cannot write {}: {error}; name another file", path.display()))
    })
}

fn replace(path: &Path, bytes: &[u8], may_replace: bool) -> std::io::Result<()> {
    // What a link leads to is replaced, not the link.
    let path = &path.canonicalize().unwrap_or_else(|_| path.to_owned());
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let mut builder = tempfile::Builder::new();
    builder.prefix(".partial-");
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    let mut file = builder.tempfile_in(folder)?;
    file.write_all(bytes)?;
    file.as_file().sync_all()?;
    let persisted = if may_replace { file.persist(path) } else { file.persist_noclobber(path) };
    persisted.map(drop).map_err(|error| error.error)
}
