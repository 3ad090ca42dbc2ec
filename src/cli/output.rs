//! Output folder of a command: checked before the work, and in place whole or not at all after it.
//!
//! - What exists and is not empty is refused, unless it is forced.
//! - Forced, an earlier output of the same [`Kind`] is replaced as a whole. A folder with any file that is no part of
//!   one is refused all the same, so no file of another origin is lost.
//! - An input is never written to: the output is no input, holds none, and does not lie inside a bundle that is read.
//! - A new folder is written beside its place as `NAME.partial-XXXXXX` (a dataset of episodes in `NAME.units`), synced
//!   and renamed ([`partial`]). After a failure or an interruption the earlier output is what it was.
//!
//! Folders that later runs continue (batches, backups) are checked here too; they are never replaced.

pub mod file;
mod kind;
mod partial;

use std::path::{Component, Path, PathBuf};

use super::{Exit, Failure};
pub use kind::Kind;
pub use partial::Partial;

/// A folder that may be written.
#[derive(Clone, Debug)]
pub struct Output {
    /// As it was given, for messages.
    shown: PathBuf,
    /// Without symbolic links.
    path: PathBuf,
    kind: Kind,
    is_forced: bool,
    /// Folder of unfinished folders; beside the place if absent.
    partials: Option<PathBuf>,
}

impl Output {
    /// Checks that `path` may become an output, and leaves nothing there. `inputs` are the files and folders that the
    /// command reads.
    ///
    /// # Errors
    ///
    /// A [`Failure`] of kind usage for a place that must not be written, and of kind error for one that cannot be.
    pub fn check(path: &Path, kind: Kind, is_forced: bool, inputs: &[&Path]) -> Result<Self, Failure> {
        let output = Self { shown: path.to_owned(), path: resolved(path), kind, is_forced, partials: None };
        output.check_kind_of_file()?;
        check_apart(path, inputs)?;
        if let Some(refusal) = output.refusal() {
            return Err(refusal);
        }
        output.check_writable()?;
        Ok(output)
    }

    /// The same place, with unfinished folders in `folder`, which is on the same file system.
    #[must_use]
    pub fn with_partials_in(self, folder: &Path) -> Self {
        Self { partials: Some(folder.to_owned()), ..self }
    }

    /// The path without symbolic links.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The path as it was given.
    pub fn given_path(&self) -> &Path {
        &self.shown
    }

    /// Begins to write.
    ///
    /// # Errors
    ///
    /// A [`Failure`] if the folder cannot be made.
    pub fn begin(&self) -> Result<Partial, Failure> {
        Partial::begin(self.clone())
    }

    /// Option and path, for messages.
    fn name(&self) -> String {
        let option = if self.kind == Kind::Backup { "" } else { "--out " };
        format!("{option}{}", self.shown.display())
    }

    fn check_kind_of_file(&self) -> Result<(), Failure> {
        let is_link = self.shown.is_symlink() && !self.shown.exists();
        if let Some(file) =
            self.path.ancestors().skip(1).find(|above| above.exists()).filter(|above| !above.is_dir())
        {
            return Err(Failure::usage(format!("{} lies below the file {}", self.name(), file.display())));
        }
        let what = match self.path.exists() && !self.path.is_dir() {
            true => "is a file",
            false if is_link => "is a link that leads nowhere",
            false => return Ok(()),
        };
        Err(Failure::usage(format!("{} {what}; name a folder", self.name())))
    }

    /// Reason why the folder as it is now must not be written, if there is one.
    fn refusal(&self) -> Option<Failure> {
        let place = self.name();
        let foreign = match kind::foreign_files(&self.path, self.kind) {
            Ok(None) => return None,
            Ok(Some(foreign)) => foreign,
            Err(error) => {
                return Some(Failure::new(Exit::Error, format!("cannot read {place}: {error}")));
            }
        };
        let what = self.kind.name();
        let message = match foreign.is_empty() {
            true if self.kind.is_continued() || self.is_forced => return None,
            true => {
                format!("{place} holds {what} already; name another folder, or add --force to replace it")
            }
            false => format!(
                "{place} is not empty and holds files that are no part of {what} ({}); name another folder",
                foreign.join(", ")
            ),
        };
        Some(Failure::usage(message))
    }

    /// Makes a folder where the partial one will be made, and removes it.
    fn check_writable(&self) -> Result<(), Failure> {
        let existing = |path: &Path| path.ancestors().find(|folder| folder.is_dir()).map(Path::to_owned);
        let beside = self.path.parent().and_then(existing).unwrap_or_else(|| PathBuf::from("/"));
        let probe = |folder: &Path| tempfile::Builder::new().prefix(".tabletopgen-").tempdir_in(folder);
        let tried = probe(&beside).or_else(|error| match self.path.is_dir() {
            // The place of a mounted volume: its own folder can be written, the one around it cannot.
            true => probe(&self.path),
            false => Err(error),
        });
        tried.map(drop).map_err(|error| unwritable(&self.shown, &error))
    }
}

/// Checks that new folders may be made in a folder, which may be missing.
///
/// # Errors
///
/// A [`Failure`] for a file, and for a folder that cannot be written.
pub fn check_parent(folder: &Path) -> Result<(), Failure> {
    let (shown, path) = (folder.to_owned(), resolved(folder));
    let output = Output { shown, path, kind: Kind::Bundle, is_forced: false, partials: None };
    output.check_kind_of_file()?;
    let path = output.path.join("name");
    Output { path, ..output }.check_writable()
}

/// Refuses an output that is an input, holds one, or lies inside a bundle or a data directory that is read.
///
/// # Errors
///
/// A [`Failure`] of kind usage that names the input.
pub fn check_apart(out: &Path, inputs: &[&Path]) -> Result<(), Failure> {
    let path = resolved(out);
    for input in inputs {
        let given = resolved(input);
        let what = match () {
            () if given == path => "is an input of this command",
            () if given.starts_with(&path) => "holds an input of this command",
            () if path.starts_with(&given) && kind::is_read_whole(&given) => {
                "lies inside an input of this command"
            }
            () => continue,
        };
        let (out, input) = (out.display(), input.display());
        return Err(Failure::usage(format!("--out {out} {what}, {input}; name another folder")));
    }
    Ok(())
}

/// The absolute path without symbolic links, as far as it exists.
fn resolved(path: &Path) -> PathBuf {
    let absolute = std::path::absolute(path).unwrap_or_else(|_| path.to_owned());
    for folder in absolute.ancestors() {
        if let Ok(real) = folder.canonicalize() {
            let rest = absolute.strip_prefix(folder).unwrap_or(Path::new(""));
            // Of what does not exist, `..` leads one up.
            return rest.components().fold(real, |mut path, part| {
                match part {
                    Component::ParentDir => {
                        path.pop();
                    }
                    part => path.push(part),
                }
                path
            });
        }
    }
    absolute
}

fn unwritable(path: &Path, error: &std::io::Error) -> Failure {
    let advice = match error.kind() {
        std::io::ErrorKind::StorageFull | std::io::ErrorKind::QuotaExceeded => {
            "free space there, or name another folder with --out"
        }
        _ => "name another folder with --out",
    };
    // Errors of temporary folders name these.
    let inner = error.get_ref().and_then(std::error::Error::source).map(ToString::to_string);
    let reason = inner.unwrap_or_else(|| error.to_string());
    Failure::new(Exit::Error, format!("cannot write into {}: {reason}; {advice}", path.display()))
}

#[cfg(test)]
mod tests;
