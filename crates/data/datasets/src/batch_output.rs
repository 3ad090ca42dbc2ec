//! `output.jsonl` of a batch: one record per item, with its state, its scene and its labels.

use std::collections::BTreeMap;
use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};

use serde::Deserialize;
use serde_json::Value;

use crate::error::DatasetError;

/// One item of a batch.
#[derive(Clone, Debug, PartialEq, Deserialize)]
pub struct BatchRecord {
    pub custom_id: String,
    #[serde(default)]
    pub scene_id: Option<String>,
    #[serde(default)]
    pub state: Option<String>,
    /// Path of the bundle, relative to the file.
    #[serde(default)]
    pub bundle: Option<PathBuf>,
    /// All other members.
    #[serde(flatten)]
    pub others: BTreeMap<String, Value>,
}

impl BatchRecord {
    /// A label as text: a member of `labels`, or of the record itself.
    pub fn label(&self, name: &str) -> Option<String> {
        let text = |value: &Value| match value {
            Value::String(text) => text.clone(),
            other => other.to_string(),
        };
        match name {
            "custom_id" => return Some(self.custom_id.clone()),
            "scene_id" => return self.scene_id.clone(),
            "state" => return self.state.clone(),
            _ => {}
        }
        let label = self.others.get("labels").and_then(|labels| labels.get(name));
        label.or_else(|| self.others.get(name)).map(text)
    }
}

/// The records of a file. Of several records with one `custom_id` the last counts: it is the retry.
///
/// # Errors
///
/// [`DatasetError::BatchOutput`] with the number of the malformed line.
pub fn read(path: &Path) -> Result<Vec<BatchRecord>, DatasetError> {
    let unreadable = |error: std::io::Error| {
        let place = path.display();
        DatasetError::Request(format!("cannot read {place}: {error}; give the output.jsonl of a batch"))
    };
    let file = std::fs::File::open(path).map_err(unreadable)?;
    let mut records: BTreeMap<String, BatchRecord> = BTreeMap::new();
    for (number, line) in (1..).zip(BufReader::new(file).lines()) {
        let line = line.map_err(unreadable)?;
        if line.trim().is_empty() {
            continue;
        }
        let record: BatchRecord = serde_json::from_str(&line).map_err(|error| {
            let reason = format!("{error}; expected an object with custom_id, scene_id, state and bundle");
            DatasetError::BatchOutput { path: path.to_owned(), line: number, reason }
        })?;
        records.insert(record.custom_id.clone(), record);
    }
    Ok(records.into_values().collect())
}

/// Paths of the bundles that the records name and that exist.
pub fn bundles(path: &Path, records: &[BatchRecord]) -> Vec<PathBuf> {
    let folder = path.parent().unwrap_or(Path::new(""));
    let named = records.iter().filter_map(|record| record.bundle.as_ref());
    named.map(|bundle| folder.join(bundle)).filter(|bundle| bundle.exists()).collect()
}
