//! The scenes that a freeze reads, and those that its filter accepts.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use crate::batch_output::{self, BatchRecord};
use crate::bundle::Bundle;
use crate::error::DatasetError;
use crate::facts::SceneFacts;
use crate::freeze::{FreezeRequest, Progress};
use crate::selection::Selection;
use crate::sources;

/// A scene that was read.
pub struct Candidate {
    pub facts: SceneFacts,
    /// Folder or archive of its bundle.
    pub place: PathBuf,
    pub custom_id: Option<String>,
}

/// The records of a batch by their bundles, and by the scenes that they name. The command line's records name scenes of
/// its store, whose ids are not those of the bundles.
#[derive(Default)]
struct RecordIndex<'a> {
    of_place: BTreeMap<PathBuf, &'a BatchRecord>,
    of_scene: BTreeMap<&'a str, &'a BatchRecord>,
}

impl<'a> RecordIndex<'a> {
    fn new(path: &Path, records: &'a [BatchRecord]) -> Self {
        let folder = path.parent().unwrap_or(Path::new(""));
        let by_place =
            |record: &'a BatchRecord| Some((canonical(&folder.join(record.bundle.as_ref()?)), record));
        let by_scene = |record: &'a BatchRecord| Some((record.scene_id.as_deref()?, record));
        Self {
            of_place: records.iter().filter_map(by_place).collect(),
            of_scene: records.iter().filter_map(by_scene).collect(),
        }
    }

    /// The record of the scene in a bundle.
    fn of(&self, place: &Path, id: &str) -> Option<&'a BatchRecord> {
        self.of_place.get(&canonical(place)).or_else(|| self.of_scene.get(id)).copied()
    }
}

fn canonical(place: &Path) -> PathBuf {
    place.canonicalize().unwrap_or_else(|_| place.to_owned())
}

/// Reads all bundles and returns those that the filter accepts, sorted by id.
///
/// # Errors
///
/// [`DatasetError`] if a bundle is damaged, two bundles of one scene differ, or no scene is selected.
pub fn select(
    request: &FreezeRequest,
    notify: &mut dyn FnMut(Progress),
) -> Result<(Vec<Candidate>, Selection), DatasetError> {
    let records = request.batch_output.as_deref().map(batch_output::read).transpose()?;
    let mut places = sources::find(&request.sources)?;
    if let (Some(path), Some(records)) = (&request.batch_output, &records) {
        places.extend(sources::find(&batch_output::bundles(path, records))?);
    }
    // A bundle may be given in several ways.
    let mut seen = BTreeSet::new();
    places.retain(|place| seen.insert(canonical(place)));
    let batch = request.batch_output.as_deref().zip(records.as_deref());
    let batch = batch.map(|(path, records)| RecordIndex::new(path, records)).unwrap_or_default();
    let mut found: BTreeSet<&str> = BTreeSet::new();
    let mut of_scene: BTreeMap<String, &BatchRecord> = BTreeMap::new();
    let mut selection = Selection::default();
    let mut candidates: BTreeMap<String, Candidate> = BTreeMap::new();
    for (index, place) in places.iter().enumerate() {
        let facts = SceneFacts::read(&mut Bundle::open(place)?)?;
        notify(Progress::Read { done: index + 1, all: places.len() });
        let record = batch.of(place, &facts.id);
        found.extend(record.map(|record| record.custom_id.as_str()));
        if let Some(other) = candidates.get(&facts.id) {
            if other.facts.manifest_sha256 != facts.manifest_sha256 {
                return Err(DatasetError::Request(format!(
                    "{} and {} are different bundles of the scene {}; leave one of them out",
                    other.place.display(),
                    place.display(),
                    facts.id
                )));
            }
            selection.copies += 1;
            continue;
        }
        of_scene.extend(record.map(|record| (facts.id.clone(), record)));
        let custom_id = record.map(|record| record.custom_id.clone());
        candidates.insert(facts.id.clone(), Candidate { facts, place: place.clone(), custom_id });
    }
    selection.read = candidates.len();
    selection.requested = records.as_ref().map_or(candidates.len(), Vec::len);
    for record in records.iter().flatten() {
        if !found.contains(record.custom_id.as_str()) {
            let state = record.state.clone().unwrap_or_else(|| "unknown".to_owned());
            *selection.without_bundle.entry(state).or_default() += 1;
        }
    }
    let mut selected = Vec::new();
    for (id, candidate) in candidates {
        selection.passed += usize::from(candidate.facts.passed());
        for code in &candidate.facts.reason_codes {
            *selection.quarantine_reasons.entry(code.clone()).or_default() += 1;
        }
        match request.filter.refusal(&candidate.facts, of_scene.get(&id).copied()) {
            Some(condition) => *selection.left_out.entry(condition.to_owned()).or_default() += 1,
            None => selected.push(candidate),
        }
    }
    if selected.is_empty() {
        return Err(DatasetError::Request(format!(
            "none of {} scenes is selected; left out by condition: {:?}",
            selection.read, selection.left_out
        )));
    }
    Ok((selected, selection))
}
