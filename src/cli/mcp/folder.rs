//! The folder of results, whose items tools know by name.

use std::path::{Path, PathBuf};

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use rmcp::ErrorData;
use rmcp::model::ContentBlock;
use serde_json::json;

/// Longest name.
const MAX_NAME: usize = 100;

/// The folder below which everything lies.
#[derive(Clone, Debug)]
pub struct Folder(PathBuf);

impl Folder {
    /// Opens it, and makes it if it is missing.
    ///
    /// # Errors
    ///
    /// If it cannot be made.
    pub fn open(folder: &Path) -> std::io::Result<Self> {
        std::fs::create_dir_all(folder)?;
        Ok(Self(folder.canonicalize()?))
    }

    /// Path of an item that is there.
    ///
    /// # Errors
    ///
    /// An [`ErrorData`] for a name that is none, or of nothing.
    pub fn item(&self, name: &str) -> Result<String, ErrorData> {
        let path = self.path(name)?;
        if !path.exists() {
            let message = format!("there is no {name}; `list` lists what is there");
            return Err(ErrorData::invalid_params(message, None));
        }
        Ok(path.display().to_string())
    }

    /// Path of an item that is to be made.
    ///
    /// # Errors
    ///
    /// An [`ErrorData`] for a name that is none, or is taken.
    pub fn new_item(&self, name: &str) -> Result<String, ErrorData> {
        let path = self.path(name)?;
        if path.exists() {
            return Err(ErrorData::invalid_params(
                format!("{name} is there already; give another name"),
                None,
            ));
        }
        Ok(path.display().to_string())
    }

    /// Objects and table of a scene, JSON.
    ///
    /// # Errors
    ///
    /// An [`ErrorData`] if it is no scene.
    pub fn document(&self, scene: &str) -> Result<String, ErrorData> {
        std::fs::read_to_string(self.path(scene)?.join("scene.json"))
            .map_err(|error| ErrorData::invalid_params(format!("{scene} is no scene: {error}"), None))
    }

    /// The image of a scene, if it has one.
    pub fn preview(&self, scene: &str) -> Option<ContentBlock> {
        let png = std::fs::read(self.path(scene).ok()?.join("preview/hero.png")).ok()?;
        Some(ContentBlock::image(STANDARD.encode(png), "image/png"))
    }

    /// Names of what is there, JSON: scenes, also those within the folders of variants, and other results.
    ///
    /// # Errors
    ///
    /// An [`ErrorData`] if the folder cannot be read.
    pub fn list(&self) -> Result<String, ErrorData> {
        let failed = |error: std::io::Error| {
            ErrorData::internal_error(format!("reading {}: {error}", self.0.display()), None)
        };
        let (mut scenes, mut others) = (Vec::new(), Vec::new());
        for name in names(&self.0).map_err(failed)? {
            if is_scene(&self.0.join(&name)) {
                scenes.push(name);
                continue;
            }
            let within = names(&self.0.join(&name)).map_err(failed)?;
            scenes.extend(
                within
                    .iter()
                    .filter(|of| is_scene(&self.0.join(&name).join(of)))
                    .map(|of| format!("{name}/{of}")),
            );
            others.push(name);
        }
        Ok(format!("{:#}", json!({ "scenes": scenes, "other_folders": others })))
    }

    /// A name, or two with a slash between them, becomes a path below the folder.
    fn path(&self, name: &str) -> Result<PathBuf, ErrorData> {
        let is_name = |part: &str| {
            let is_known = |c: char| c.is_ascii_alphanumeric() || matches!(c, '_' | '-' | '.');
            (1..=MAX_NAME).contains(&part.len()) && part.chars().all(is_known) && !part.starts_with('.')
        };
        let parts: Vec<&str> = name.split('/').collect();
        let path: PathBuf = parts.iter().collect();
        if parts.len() > 2 || !parts.iter().all(|part| is_name(part)) {
            let message = format!("{name:?} is no name; use letters, digits, _ and -");
            return Err(ErrorData::invalid_params(message, None));
        }
        Ok(self.0.join(path))
    }
}

fn is_scene(path: &Path) -> bool {
    path.join("scene.json").is_file()
}

/// Names of the folders in a folder, sorted.
fn names(folder: &Path) -> std::io::Result<Vec<String>> {
    let entries: Vec<std::fs::DirEntry> = std::fs::read_dir(folder)?.collect::<Result<_, _>>()?;
    let folders = entries.into_iter().filter(|entry| entry.path().is_dir());
    let mut names: Vec<String> = folders.filter_map(|entry| entry.file_name().into_string().ok()).collect();
    names.sort();
    Ok(names)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_name_leads_out_of_the_folder() {
        let folder = tempfile::tempdir().expect("a folder");
        let folder = Folder::open(&folder.path().join("out")).expect("opens");
        for name in
            ["", ".", "..", "../x", "a/../b", "/etc", "a//b", "a/b/c", "a\\b", ".hidden", "a b", "-\0", "ä"]
        {
            assert!(folder.new_item(name).is_err(), "{name:?}");
        }
        for name in ["tea", "tea_2", "a/variant-0", "v1.2"] {
            assert!(folder.new_item(name).is_ok(), "{name:?}");
            assert!(folder.item(name).is_err(), "{name:?}");
        }
    }
}
