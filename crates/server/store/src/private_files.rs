//! Modes of data on a disk: directories 0700, files 0600, so that no other user of the machine reads or changes them.
//!
//! Modes are set explicitly, whatever the umask of the process is. What is there already with more is repaired, with a
//! line in the log: a program that refused would stop a service that another release has set up. A directory that
//! belongs to another user (the root of a mounted volume) cannot be repaired and is used as it is, with a warning. On
//! systems without such modes nothing is set.

use std::fs::{File, OpenOptions};
use std::io;
use std::path::Path;

/// Mode of directories.
#[cfg(unix)]
const DIRECTORY: u32 = 0o700;
/// Mode of files.
#[cfg(unix)]
const FILE: u32 = 0o600;

/// Creates a directory if it is missing, with those that lead to it, and takes the rights of others from one that is
/// there. Returns whether there were some to take.
fn directory(path: &Path) -> io::Result<bool> {
    create(path)?;
    closed(path)
}

/// The same for all that is in the directory, where others had rights on that: who made it made the rest, too. Else
/// only what others cannot reach is inside.
pub(crate) fn whole_directory(path: &Path) -> io::Result<()> {
    if directory(path)? { close_all_below(path) } else { Ok(()) }
}

/// Creates a directory if it is missing.
pub(crate) fn create(path: &Path) -> io::Result<()> {
    let mut builder = std::fs::DirBuilder::new();
    builder.recursive(true);
    #[cfg(unix)]
    std::os::unix::fs::DirBuilderExt::mode(&mut builder, DIRECTORY);
    builder.create(path)
}

/// Opens a file for writing, and creates an empty one if it is missing.
pub(crate) fn file(path: &Path) -> io::Result<File> {
    let mut options = OpenOptions::new();
    options.create(true).truncate(false).write(true);
    #[cfg(unix)]
    std::os::unix::fs::OpenOptionsExt::mode(&mut options, FILE);
    let file = options.open(path)?;
    closed(path)?;
    Ok(file)
}

/// Takes the rights of others from a file or a directory. Returns whether there were some to take.
#[cfg(unix)]
pub(crate) fn closed(path: &Path) -> io::Result<bool> {
    use std::os::unix::fs::PermissionsExt;

    let about = std::fs::metadata(path)?;
    let mode = about.permissions().mode() & 0o7777;
    if mode & 0o077 == 0 {
        return Ok(false);
    }
    let private = if about.is_dir() { DIRECTORY } else { FILE };
    match std::fs::set_permissions(path, std::fs::Permissions::from_mode(private)) {
        Ok(()) => {
            let (path, mode) = (path.display(), format!("{mode:o}"));
            tracing::warn!(%path, mode, "other users could read or change data; they cannot now");
            Ok(true)
        }
        Err(error) if is_of_another(&error) => {
            let (path, mode) = (path.display(), format!("{mode:o}"));
            tracing::warn!(%path, mode, "other users may read or change data, and only its owner can prevent it");
            Ok(false)
        }
        Err(error) => Err(error),
    }
}

/// Whether a mode cannot be set because a file belongs to another user or lies on a medium that is only read.
#[cfg(unix)]
fn is_of_another(error: &io::Error) -> bool {
    matches!(error.kind(), io::ErrorKind::PermissionDenied | io::ErrorKind::ReadOnlyFilesystem)
}

#[cfg(not(unix))]
pub(crate) fn closed(path: &Path) -> io::Result<bool> {
    std::fs::metadata(path).map(|_| false)
}

/// Sets the mode of a file that a library has just made, by the umask.
#[cfg(unix)]
pub(crate) fn set(path: &Path) -> io::Result<()> {
    use std::os::unix::fs::PermissionsExt;

    std::fs::set_permissions(path, std::fs::Permissions::from_mode(FILE))
}

#[cfg(not(unix))]
pub(crate) fn set(_: &Path) -> io::Result<()> {
    Ok(())
}

/// Takes the rights of others from all below a directory; symbolic links are not followed. One line tells of all.
#[cfg(unix)]
fn close_all_below(path: &Path) -> io::Result<()> {
    use std::os::unix::fs::PermissionsExt;

    let (mut waiting, mut repaired) = (vec![path.to_owned()], 0_u64);
    while let Some(folder) = waiting.pop() {
        let entries = match std::fs::read_dir(&folder) {
            Err(error) if is_of_another(&error) => continue,
            entries => entries?,
        };
        for entry in entries {
            let entry = entry?;
            // What another process has removed meanwhile needs no mode.
            let Ok(about) = entry.metadata() else { continue };
            if about.is_symlink() {
                continue;
            }
            if about.permissions().mode() & 0o077 != 0 {
                let private = if about.is_dir() { DIRECTORY } else { FILE };
                let set = std::fs::set_permissions(entry.path(), std::fs::Permissions::from_mode(private));
                repaired += u64::from(set.is_ok());
            }
            if about.is_dir() {
                waiting.push(entry.path());
            }
        }
    }
    if repaired > 0 {
        tracing::warn!(path = %path.display(), repaired, "other users could read files and directories below; they cannot now");
    }
    Ok(())
}

#[cfg(not(unix))]
fn close_all_below(_: &Path) -> io::Result<()> {
    Ok(())
}

#[cfg(all(test, unix))]
mod tests {
    use std::os::unix::fs::PermissionsExt;

    use super::*;

    fn mode(path: &Path) -> u32 {
        std::fs::metadata(path).expect("is there").permissions().mode() & 0o777
    }

    fn opened_to_all(path: &Path, mode: u32) {
        std::fs::set_permissions(path, std::fs::Permissions::from_mode(mode)).expect("is set");
    }

    #[test]
    fn new_directories_and_files_are_private() {
        let home = tempfile::tempdir().expect("temporary directory");
        let inner = home.path().join("a/b");
        assert!(!directory(&inner).expect("creates"));
        assert_eq!((mode(&home.path().join("a")), mode(&inner)), (0o700, 0o700));
        drop(file(&inner.join("lock")).expect("creates"));
        assert_eq!(mode(&inner.join("lock")), 0o600);
    }

    #[test]
    fn rights_of_others_are_taken_away_without_touching_the_content() {
        let home = tempfile::tempdir().expect("temporary directory");
        let (folder, inner) = (home.path().join("blobs"), home.path().join("blobs/sha256"));
        std::fs::create_dir_all(&inner).expect("creates");
        std::fs::write(inner.join("x"), b"content").expect("writes");
        let outside = home.path().join("outside");
        std::fs::write(&outside, b"not ours").expect("writes");
        std::os::unix::fs::symlink(&outside, inner.join("link")).expect("links");
        for (path, mode) in [(&folder, 0o755), (&inner, 0o777), (&inner.join("x"), 0o644), (&outside, 0o644)]
        {
            opened_to_all(path, mode);
        }
        whole_directory(&folder).expect("repairs");
        assert_eq!((mode(&folder), mode(&inner), mode(&inner.join("x"))), (0o700, 0o700, 0o600));
        assert_eq!(std::fs::read(inner.join("x")).expect("reads"), b"content");
        assert_eq!(mode(&outside), 0o644, "links lead elsewhere");
        assert!(!directory(&folder).expect("finds nothing to repair"));
        // The owner's own rights stay as they are.
        drop(file(&folder.join("f")).expect("creates"));
        opened_to_all(&folder.join("f"), 0o400);
        assert!(!closed(&folder.join("f")).expect("reads"));
        assert_eq!(mode(&folder.join("f")), 0o400);
    }
}
