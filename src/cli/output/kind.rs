//! Files that commands leave in folders, as distinct from the files of others.

use std::collections::BTreeSet;
use std::io;
use std::path::Path;

use serde::Deserialize;

use episodes::is_of_dataset;

/// The database of a data directory.
pub(super) const DATABASE_FILE: &str = "tabletopgen.sqlite";

/// Maximum number of files of others that a message names.
const NAMED: usize = 3;

/// Kind of a folder's content.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// The bundle of a scene.
    Bundle,
    /// The output of `execute`.
    Execution,
    /// The output of `tasks`.
    Tasks,
    /// A dataset of `episodes`.
    Episodes,
    /// The folder of `batch`, which the next run continues.
    Batch,
    /// A backup, to which the next one adds what is new.
    Backup,
    /// Artifacts that an evaluation keeps of a scene or of its images.
    Artifacts,
}

impl Kind {
    /// With its article, for messages.
    pub fn name(self) -> &'static str {
        match self {
            Self::Bundle => "a bundle",
            Self::Execution => "an execution",
            Self::Tasks => "a list of tasks",
            Self::Episodes => "a dataset of episodes",
            Self::Batch => "a batch",
            Self::Backup => "a backup",
            Self::Artifacts => "artifacts of an evaluation",
        }
    }

    /// Whether a later run goes on in the folder instead of replacing it.
    pub fn is_continued(self) -> bool {
        matches!(self, Self::Batch | Self::Backup)
    }
}

/// Files in a folder that are no part of an output of this kind, the first few; `None` for a folder that is empty or
/// missing.
pub(super) fn foreign_files(folder: &Path, kind: Kind) -> io::Result<Option<Vec<String>>> {
    let entries = match std::fs::read_dir(folder) {
        Ok(entries) => entries,
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(None),
        Err(error) => return Err(error),
    };
    let names = entries.map(|entry| Ok(entry?.file_name().to_string_lossy().into_owned()));
    let mut names = names.collect::<io::Result<Vec<String>>>()?;
    // A volume has the one from the beginning, a run that was killed leaves the other.
    names.retain(|name| name != "lost+found" && !name.starts_with(".partial-"));
    names.sort();
    if names.is_empty() {
        return Ok(None);
    }
    let Some(is_own) = membership(folder, kind, &names) else {
        names.truncate(NAMED);
        return Ok(Some(names));
    };
    if kind.is_continued() {
        return Ok(Some(Vec::new()));
    }
    let mut foreign = Vec::new();
    collect(folder, "", &*is_own, &mut foreign)?;
    Ok(Some(foreign))
}

/// Whether everything below this input is read, so that a new file inside would change it.
pub(super) fn is_read_whole(input: &Path) -> bool {
    ["manifest.json", "dataset.json", DATABASE_FILE].iter().any(|name| input.join(name).is_file())
}

/// Whether a relative path belongs to the output in a folder.
type Membership = Box<dyn Fn(&str) -> bool>;

/// Test for the files that belong to the output in a folder; `None` if there is no output of this kind.
fn membership(folder: &Path, kind: Kind, names: &[String]) -> Option<Membership> {
    let has = |name: &str| names.iter().any(|other| other == name);
    match kind {
        Kind::Bundle => {
            let listed = listed_files(folder)?;
            Some(Box::new(move |path| {
                path == "manifest.json" || path.starts_with("artifacts/") || listed.contains(path)
            }))
        }
        Kind::Execution => {
            let bytes = std::fs::read(folder.join("execution.json")).ok()?;
            let document: serde_json::Value = serde_json::from_slice(&bytes).ok()?;
            document.get("execution")?.as_object()?;
            Some(Box::new(|path| {
                let files =
                    ["execution.json", "task.json", "trajectory.json", "trajectory.parquet", "video.mp4"];
                files.contains(&path) || ["mjcf/", "urdf/", "usd/"].iter().any(|of| path.starts_with(of))
            }))
        }
        Kind::Tasks => has("domain.bddl").then(|| Box::new(is_task_file) as Membership),
        Kind::Episodes => {
            let has_records = |name: &String| folder.join(name).join("records.jsonl").is_file();
            names.iter().any(has_records).then(|| Box::new(is_of_dataset) as Membership)
        }
        Kind::Batch => {
            let is_begun = has(".tabletopgen") || has("output.jsonl.part");
            let is_batch = is_begun || begins_with_a_record(&folder.join("output.jsonl"));
            is_batch.then(|| Box::new(|_: &str| true) as Membership)
        }
        Kind::Backup => {
            let copies = ["blobs".to_owned(), format!("{}.partial", DATABASE_FILE)];
            let is_begun = names.iter().all(|name| copies.contains(name));
            (has(DATABASE_FILE) || is_begun).then(|| Box::new(|_: &str| true) as Membership)
        }
        Kind::Artifacts => {
            let is_own = |path: &str| path.starts_with("artifacts/") || path.ends_with(".png");
            let is_kept = has("artifacts") || names.iter().all(|name| is_own(name));
            is_kept.then(|| Box::new(is_own) as Membership)
        }
    }
}

/// `domain.bddl`, `task_0001.json`, `task_0001.bddl` and so on.
fn is_task_file(path: &str) -> bool {
    let number = path.strip_prefix("task_").and_then(|rest| rest.split_once('.'));
    path == "domain.bddl"
        || number.is_some_and(|(digits, ending)| {
            digits.len() >= 4
                && digits.bytes().all(|b| b.is_ascii_digit())
                && matches!(ending, "json" | "bddl")
        })
}

/// Whether a file begins with a line of a batch's output. An empty one does, too.
fn begins_with_a_record(path: &Path) -> bool {
    let Ok(text) = std::fs::read_to_string(path) else { return false };
    let Some(line) = text.lines().next() else { return true };
    let record: Option<serde_json::Value> = serde_json::from_str(line).ok();
    record.is_some_and(|record| record.get("custom_id").is_some() && record.get("state").is_some())
}

/// Collects the first files below a folder that do not belong to it. What a link leads to is not entered.
fn collect(
    folder: &Path,
    below: &str,
    is_own: &dyn Fn(&str) -> bool,
    foreign: &mut Vec<String>,
) -> io::Result<()> {
    for entry in std::fs::read_dir(folder)? {
        let entry = entry?;
        let path = format!("{below}{}", entry.file_name().to_string_lossy());
        if entry.file_type()?.is_dir() {
            collect(&entry.path(), &format!("{path}/"), is_own, foreign)?;
        } else if !is_own(&path) {
            foreign.push(path);
        }
        if foreign.len() >= NAMED {
            return Ok(());
        }
    }
    Ok(())
}

/// The files that the manifest of a bundle lists; `None` where there is no bundle.
fn listed_files(folder: &Path) -> Option<BTreeSet<String>> {
    #[derive(Deserialize)]
    struct Manifest {
        format: String,
        files: Vec<File>,
    }
    #[derive(Deserialize)]
    struct File {
        path: String,
    }
    let bytes = std::fs::read(folder.join("manifest.json")).ok()?;
    let manifest: Manifest = serde_json::from_slice(&bytes).ok()?;
    let is_bundle = manifest.format.starts_with("tabletopgen-manifest/");
    is_bundle.then(|| manifest.files.into_iter().map(|file| file.path).collect())
}
