//! The bundles below the given paths, in a fixed order.

use std::path::{Path, PathBuf};

use export::manifest;

use crate::error::DatasetError;

/// Folders are searched so deep for bundles.
const MAX_DEPTH: usize = 4;

/// Paths of all bundles: a file is an archive; a folder is a bundle, or is searched for bundles and `.zip` files.
///
/// # Errors
///
/// [`DatasetError::File`] if a path cannot be read, [`DatasetError::Request`] if a path leads to no bundle.
pub fn find(paths: &[PathBuf]) -> Result<Vec<PathBuf>, DatasetError> {
    let mut bundles = Vec::new();
    for path in paths {
        let before = bundles.len();
        search(path, MAX_DEPTH, &mut bundles)?;
        if bundles.len() == before {
            return Err(DatasetError::Request(format!(
                "{} holds no bundle; give a folder with manifest.json, a .zip, or a folder of these",
                path.display()
            )));
        }
    }
    bundles.sort();
    bundles.dedup();
    Ok(bundles)
}

fn search(path: &Path, depth: usize, bundles: &mut Vec<PathBuf>) -> Result<(), DatasetError> {
    let about = std::fs::metadata(path).map_err(|error| {
        let place = path.display();
        DatasetError::Request(format!(
            "cannot read {place}: {error}; give bundles, or folders that hold them"
        ))
    })?;
    if about.is_file() || path.join(manifest::PATH).is_file() {
        bundles.push(path.to_owned());
        return Ok(());
    }
    if depth == 0 {
        return Ok(());
    }
    let entries = std::fs::read_dir(path).map_err(DatasetError::file("list", path))?;
    for entry in entries {
        let child = entry.map_err(DatasetError::file("list", path))?.path();
        let is_archive = child.extension().is_some_and(|extension| extension == "zip");
        // A folder that a command left half written when it was killed.
        let is_partial = child.file_name().is_some_and(|name| name.to_string_lossy().contains(".partial-"));
        if !is_partial && (child.is_dir() || is_archive) {
            search(&child, depth - 1, bundles)?;
        }
    }
    Ok(())
}
