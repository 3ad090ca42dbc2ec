//! Freezes a set of scenes as one version of a named dataset: `OUT/NAME/vVERSION/`.
//!
//! Bundles are read twice: once for the facts that decide about selection and splits, once to be packed.
//! `dataset.json` is written last, so a folder without it is an interrupted freeze, and the same command goes on
//! there.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use serde_json::json;

use crate::candidates::{Candidate, select};
use crate::canonical;
use crate::containers::{self, Containers};
use crate::dataset_manifest::{
    self, Counts, DatasetManifest, FORMAT, FileEntry, Generator, Layout, SceneEntry, Splits,
};
use crate::error::DatasetError;
use crate::facts::SceneFacts;
use crate::files;
use crate::filter::Filter;
use crate::licences;
use crate::progress::{self, PlannedScene};
use crate::selection::Selection;
use crate::sharing::{LeakageRules, Shareable};
use crate::splits::{self, SplitPlan};
use crate::statistics::{self, Statistics};
use crate::versions;

/// Order to freeze scenes as a version of a dataset.
#[derive(Clone, Debug)]
pub struct FreezeRequest {
    /// Lower-case letters, digits, `-` and `_`.
    pub name: String,
    /// `None` for the version after the last one, or that version if nothing changed.
    pub version: Option<u32>,
    /// The highest number that a version had which is gone; 0 for none. It is not given to another.
    pub last_removed: u32,
    /// Bundles, archives, and folders of them.
    pub sources: Vec<PathBuf>,
    /// `output.jsonl` of the batch that made the scenes; its bundles are sources, too.
    pub batch_output: Option<PathBuf>,
    pub filter: Filter,
    pub plan: SplitPlan,
    pub leakage_rules: LeakageRules,
    pub layout: Layout,
    /// The folder that holds `NAME/`.
    pub out: PathBuf,
}

/// Progress of a freeze.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Progress {
    /// Bundles whose facts were read, of all.
    Read { done: usize, all: usize },
    /// Scenes that were packed, of all.
    Packed { done: usize, all: usize },
}

/// A frozen version.
#[derive(Debug)]
pub struct FrozenDataset {
    pub folder: PathBuf,
    pub manifest: DatasetManifest,
    /// Whether the version existed and is unchanged.
    pub existed: bool,
    /// Containers that an interrupted freeze had left.
    pub kept: usize,
}

/// Freezes the scenes.
///
/// # Errors
///
/// [`DatasetError`] if the request is inconsistent, a bundle is damaged, two bundles of one scene differ, no scene is
/// selected, a split that was asked for is empty, or the disk fails.
pub fn freeze(
    request: &FreezeRequest,
    notify: &mut dyn FnMut(Progress),
) -> Result<FrozenDataset, DatasetError> {
    check_name(&request.name)?;
    let (selected, selection) = select(request, notify)?;
    let home = request.out.join(&request.name);
    let latest = versions::latest(&home)?;
    let inputs_digest = inputs_digest(request, &selected, &selection)?;
    if let Some((manifest, folder)) = &latest
        && manifest.inputs_digest == inputs_digest
        && request.version.is_none_or(|version| version == manifest.version)
    {
        remove_work_folder(folder)?;
        let (folder, manifest) = (folder.clone(), manifest.clone());
        return Ok(FrozenDataset { folder, manifest, existed: true, kept: 0 });
    }
    let last = latest.as_ref().map_or(0, |(manifest, _)| manifest.version);
    let version = request.version.unwrap_or(last.max(request.last_removed) + 1);
    if version <= last {
        return Err(DatasetError::Request(format!(
            "{} has version {last}, and a version never changes; freeze version {} or leave the number out",
            request.name,
            last + 1
        )));
    }
    let before = latest.as_ref().map(|(manifest, _)| manifest);
    let entries = divide(&selected, request, &versions::earlier_splits(before, &request.plan))?;
    let folder = home.join(format!("v{version}"));
    check_own(&folder)?;
    std::fs::create_dir_all(&folder).map_err(DatasetError::file("create", &folder))?;
    let planned: Vec<PlannedScene> = entries
        .iter()
        .map(|(entry, candidate)| PlannedScene {
            id: entry.id.clone(),
            manifest_sha256: entry.manifest_sha256.clone(),
            split: entry.split.clone(),
            place: candidate.place.clone(),
        })
        .collect();
    let all = planned.len();
    let packed = &mut |done| notify(Progress::Packed { done, all });
    let containers = containers::write(&folder, &planned, request.layout, packed)?;
    remove_strays(&folder, &containers)?;
    let facts: Vec<&SceneFacts> = entries.iter().map(|(_, candidate)| &candidate.facts).collect();
    let statistics = Statistics::of(&facts, &splits_of(&entries), &selection, &request.plan);
    let title = format!("{} v{version}", request.name);
    let documents = [
        (licences::PATH, licences::text(&request.name, version, facts.iter().copied())),
        (statistics::JSON_PATH, statistics.json()),
        (statistics::PAGE_PATH, statistics::page::write(&title, &statistics)),
    ];
    let mut listed: Vec<FileEntry> = Vec::new();
    for (path, text) in &documents {
        listed.push(files::write(&folder, path, text.as_bytes())?);
    }
    if matches!(request.layout, Layout::Shards { .. }) {
        listed.extend(containers.files.iter().cloned());
    }
    listed.sort_by(|a, b| a.path.cmp(&b.path));
    let group_names = entries.iter().map(|(entry, _)| entry.group.clone());
    let mut manifest = DatasetManifest {
        format: FORMAT.to_owned(),
        name: request.name.clone(),
        version,
        generator: Generator {
            name: "tabletopgen".to_owned(),
            version: env!("CARGO_PKG_VERSION").to_owned(),
        },
        digest: String::new(),
        inputs_digest,
        counts: counts(group_names, &entries, &request.plan),
        selection,
        filter: request.filter.clone(),
        splits: Splits {
            plan: request.plan.clone(),
            method: splits::METHOD.to_owned(),
            leakage_rules: request.leakage_rules,
            statement: request.leakage_rules.statement(),
        },
        layout: request.layout,
        changes: before.map(|before| versions::changes(before, &planned)),
        files: listed,
        scenes: stored_entries(entries, &containers),
    };
    manifest.digest = manifest.computed_digest()?;
    let mut text = serde_json::to_vec_pretty(&manifest)
        .map_err(|error| DatasetError::dataset(&folder, error.to_string()))?;
    text.push(b'\n');
    files::write(&folder, dataset_manifest::PATH, &text)?;
    remove_work_folder(&folder)?;
    Ok(FrozenDataset { folder, manifest, existed: false, kept: containers.kept })
}

/// Checks the name of a dataset, which becomes that of a folder.
///
/// # Errors
///
/// [`DatasetError::Request`] with the requirement that the name does not meet.
pub fn check_name(name: &str) -> Result<(), DatasetError> {
    let is_word = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || matches!(c, '-' | '_');
    if (1..=64).contains(&name.len()) && name.chars().all(is_word) {
        return Ok(());
    }
    Err(DatasetError::Request(format!(
        "{name:?} is no name of a dataset; use 1 to 64 lower-case letters, digits, - and _"
    )))
}

/// Entries without their places in files, sorted by split and id.
fn divide<'a>(
    selected: &'a [Candidate],
    request: &FreezeRequest,
    earlier: &BTreeMap<String, String>,
) -> Result<Vec<(SceneEntry, &'a Candidate)>, DatasetError> {
    let shares: Vec<Shareable> = selected.iter().map(|candidate| Shareable::of(&candidate.facts)).collect();
    let groups = splits::groups(&shares, &request.leakage_rules);
    let assigned = splits::assign(&groups, &request.plan, earlier);
    request.plan.check_filled(&groups, &assigned)?;
    let mut of_scene: BTreeMap<&str, (String, &String)> = BTreeMap::new();
    for (group, split) in groups.iter().zip(&assigned) {
        for id in group.scenes() {
            of_scene.insert(id, (group.name(), split));
        }
    }
    let mut entries: Vec<(SceneEntry, &Candidate)> = selected
        .iter()
        .zip(shares)
        .map(|(candidate, shares)| {
            let facts = &candidate.facts;
            let (group, split) = of_scene
                .get(facts.id.as_str())
                .map_or_else(Default::default, |(group, split)| (group.clone(), (*split).clone()));
            let entry = SceneEntry {
                id: facts.id.clone(),
                custom_id: candidate.custom_id.clone(),
                split,
                earlier_split: earlier.get(&facts.id).cloned(),
                group,
                path: String::new(),
                size: 0,
                sha256: String::new(),
                manifest_sha256: facts.manifest_sha256.clone(),
                verdict: if facts.passed() { "pass" } else { "quarantine" }.to_owned(),
                objects: facts.objects.len(),
                categories: facts.categories(),
                shares,
                members: BTreeMap::new(),
            };
            (entry, candidate)
        })
        .collect();
    let rank = |split: &str| request.plan.ratios.iter().position(|other| other.name == split);
    entries.sort_by(|(a, _), (b, _)| (rank(&a.split), &a.id).cmp(&(rank(&b.split), &b.id)));
    Ok(entries)
}

/// Refuses a folder with files that no interrupted freeze left.
fn check_own(folder: &Path) -> Result<(), DatasetError> {
    let is_free = !folder.exists() || folder.read_dir().is_ok_and(|mut entries| entries.next().is_none());
    if is_free || folder.join(progress::FOLDER).is_dir() {
        return Ok(());
    }
    let reason = "it has files that no freeze left; name another folder, or another number of the version";
    Err(DatasetError::dataset(folder, reason))
}

fn splits_of(entries: &[(SceneEntry, &Candidate)]) -> Vec<String> {
    entries.iter().map(|(entry, _)| entry.split.clone()).collect()
}

fn inputs_digest(
    request: &FreezeRequest,
    selected: &[Candidate],
    selection: &Selection,
) -> Result<String, DatasetError> {
    let scenes: Vec<_> = selected
        .iter()
        .map(|Candidate { facts, custom_id, .. }| json!([facts.id, facts.manifest_sha256, custom_id]))
        .collect();
    let inputs = json!({
        "scenes": scenes,
        "plan": request.plan,
        "method": splits::METHOD,
        "leakage_rules": request.leakage_rules,
        "filter": request.filter,
        "layout": request.layout,
        "selection": selection,
    });
    canonical::digest(&inputs).map_err(|error| DatasetError::Request(error.to_string()))
}

fn counts(
    groups: impl Iterator<Item = String>,
    entries: &[(SceneEntry, &Candidate)],
    plan: &SplitPlan,
) -> Counts {
    let mut sizes: BTreeMap<String, usize> = BTreeMap::new();
    groups.for_each(|group| *sizes.entry(group).or_default() += 1);
    let mut splits: BTreeMap<String, usize> =
        plan.ratios.iter().map(|split| (split.name.clone(), 0)).collect();
    for (entry, _) in entries {
        *splits.entry(entry.split.clone()).or_default() += 1;
    }
    Counts {
        scenes: entries.len(),
        objects: entries.iter().map(|(entry, _)| entry.objects).sum(),
        groups: sizes.len(),
        largest_group: sizes.values().copied().max().unwrap_or(0),
        splits,
    }
}

fn stored_entries(entries: Vec<(SceneEntry, &Candidate)>, containers: &Containers) -> Vec<SceneEntry> {
    let stored = entries.into_iter().zip(&containers.scenes);
    let located = stored.map(|((entry, _), (stored, path))| SceneEntry {
        path: path.clone(),
        size: stored.size,
        sha256: stored.sha256.clone(),
        members: stored.members.clone(),
        ..entry
    });
    located.collect()
}

/// Removes what an interrupted freeze of another set left in the containers' folders.
fn remove_strays(folder: &Path, containers: &Containers) -> Result<(), DatasetError> {
    let known: BTreeSet<&str> = containers.files.iter().map(|file| file.path.as_str()).collect();
    for path in files::list(folder)? {
        let is_container = path.starts_with("shards/") || path.starts_with("scenes/");
        if is_container && !known.contains(path.as_str()) {
            let path = folder.join(path);
            std::fs::remove_file(&path).map_err(DatasetError::file("remove", &path))?;
        }
    }
    Ok(())
}

fn remove_work_folder(folder: &Path) -> Result<(), DatasetError> {
    let work = folder.join(progress::FOLDER);
    if work.exists() {
        std::fs::remove_dir_all(&work).map_err(DatasetError::file("remove", &work))?;
    }
    Ok(())
}
