//! Paths of the files of a dataset: these may be replaced together with it; other files belong to others.

use crate::format::Format;

/// Files in the folder of a format.
const FILES: [&str; 4] = ["README.md", "records.jsonl", "dataset.json", "dataset.hdf5"];
/// Folders in the folder of a format, and the endings of what is in them.
const FOLDERS: [&str; 5] = ["meta", "data", "videos", "strips", "episodes"];
const ENDINGS: [&str; 5] = [".parquet", ".json", ".jsonl", ".mp4", ".png"];

/// Whether a dataset may have a file with this path, relative to its folder, with `/` between names.
pub fn is_of_dataset(path: &str) -> bool {
    let Some((format, inside)) = path.split_once('/') else { return false };
    let is_format = Format::ALL.iter().any(|known| known.folder() == format);
    is_format
        && match inside.split_once('/') {
            Some((folder, name)) => {
                FOLDERS.contains(&folder) && ENDINGS.iter().any(|ending| name.ends_with(ending))
            }
            None => FILES.contains(&inside),
        }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_of_others_are_none_of_a_dataset() {
        for own in ["robomimic/dataset.hdf5", "lerobot-v3.0/meta/info.json", "parquet-png/README.md"] {
            assert!(is_of_dataset(own), "{own}");
        }
        for other in [
            "notes.txt",
            "README.md",
            "policy/README.md",
            "robomimic/policy.pth",
            "lerobot-v3.0/outputs/train/model.safetensors",
            "lerobot-v3.0/meta/notes.txt",
        ] {
            assert!(!is_of_dataset(other), "{other}");
        }
    }
}
