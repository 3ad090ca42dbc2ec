//! Categories of the user: the files that `catalog.paths` names, which every command reads when it starts.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use crate::config::{ConfigError, ConfigErrors, Resolved};
use catalog::{Category, CategoryError, add_categories, read_categories};
use store::Digest;

/// A file of categories that cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum FileError {
    #[error("{path}: {error}; name a TOML file or a folder of them", path = .path.display())]
    NotReadable { path: PathBuf, error: std::io::Error },
    #[error("{path}: {error}", path = .path.display())]
    NoCategories { path: PathBuf, error: CategoryError },
}

/// Adds the categories of the files to the catalog of this process.
///
/// # Errors
///
/// A [`ConfigErrors`] of `catalog.paths` for a file that cannot be read, and a category that cannot be used.
pub fn load(resolved: &Resolved) -> Result<(), ConfigErrors> {
    let key = "catalog.paths";
    let paths = resolved.config.catalog.paths.split(',').map(str::trim).filter(|path| !path.is_empty());
    let refused = |detail: String| {
        ConfigErrors(vec![ConfigError { key: key.to_owned(), origin: resolved.origin(key).clone(), detail }])
    };
    let (mut categories, mut contents, mut file_of) = (Vec::new(), Vec::new(), BTreeMap::new());
    for path in paths {
        for file in files(Path::new(path)).map_err(|error| refused(error.to_string()))? {
            let (read, text) = read(&file).map_err(|error| refused(error.to_string()))?;
            file_of.extend(read.iter().map(|category: &Category| (category.name.clone(), file.clone())));
            categories.extend(read);
            contents.extend_from_slice(Digest::of(text.as_bytes()).to_string().as_bytes());
        }
    }
    let digest = Digest::of(&contents).to_string();
    add_categories(categories, digest).map_err(|error| match &error {
        CategoryError::Faulty { name, .. } if let Some(file) = file_of.get(name) => {
            refused(format!("{}: {error}", file.display()))
        }
        _ => refused(error.to_string()),
    })
}

/// The categories of a file, and its text.
pub fn read(path: &Path) -> Result<(Vec<Category>, String), FileError> {
    let text = std::fs::read_to_string(path)
        .map_err(|error| FileError::NotReadable { path: path.to_owned(), error })?;
    let categories = read_categories(&text);
    let categories = categories.map_err(|error| FileError::NoCategories { path: path.to_owned(), error })?;
    Ok((categories, text))
}

/// The file itself, or the `*.toml` of a folder by name.
fn files(path: &Path) -> Result<Vec<PathBuf>, FileError> {
    if !path.is_dir() {
        return Ok(vec![path.to_owned()]);
    }
    let unreadable = |error| FileError::NotReadable { path: path.to_owned(), error };
    let entries = std::fs::read_dir(path).map_err(unreadable)?;
    let mut files: Vec<PathBuf> =
        entries.map(|entry| entry.map(|entry| entry.path())).collect::<Result<_, _>>().map_err(unreadable)?;
    files.retain(|file| file.extension().is_some_and(|extension| extension == "toml"));
    files.sort();
    Ok(files)
}
