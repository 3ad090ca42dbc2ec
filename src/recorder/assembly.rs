//! The dataset of a recording: assembled in a work folder out of the episodes in the store, and stored as archives.

use std::collections::BTreeMap;
use std::path::Path;

use bytes::Bytes;
use serde_json::{Value, json};
use tokio::sync::mpsc;

use super::packing::{Packed, pack};
use super::{Prepared, RecordError, Recorder};
use crate::problem::{Problem, ProblemType};
use episodes::card::{DatasetCard, DatasetSummary};
use episodes::{DatasetAssembler, EpisodeUnit};
use store::Lease;
use store::recordings::{ArchivePart, KeptAttempt, RecordingArchive, RecordingFile, RecordingRow};

/// Rows of files that are written at once.
const FILES_AT_ONCE: usize = 500;

/// An episode on its way to the assembler.
enum Unit {
    Next(u64, Bytes),
    /// There are no more. Without it the work was given up.
    End,
}

impl Recorder {
    /// Assembles a dataset and stores it; its summary as JSON.
    pub(super) async fn assemble(
        &self,
        lease: &Lease,
        recording: &RecordingRow,
        folder: &Path,
    ) -> Result<Value, RecordError> {
        let kept = needed(self.store.kept_attempts(&recording.id).await?, recording)?;
        let mut attempts = BTreeMap::new();
        for attempt in &kept {
            *attempts.entry(attempt.made.outcome.clone()).or_insert(0) += 1;
        }
        let prepared = self.prepared(recording).await?;
        self.store.begin_assembly(lease).await?;
        if folder.exists() {
            std::fs::remove_dir_all(folder).map_err(RecordError::file("remove", folder))?;
        }
        std::fs::create_dir_all(folder).map_err(RecordError::file("create", folder))?;
        let dataset = folder.join("dataset");
        let card = DatasetCard { attempts: attempts.clone(), ..prepared.preparation.card.clone() };
        let (units, received) = mpsc::channel(1);
        let (sent, summary) = tokio::join!(
            self.send(&kept, units),
            self.cpu.run({
                let (prepared, dataset) = (prepared.clone(), dataset.clone());
                move || written(&prepared, &dataset, card, received)
            }),
        );
        // An episode that is lost ends both; the reason is that of the sender.
        sent?;
        let summary = summary??;

        let formats = prepared.preparation.setup.formats().iter().map(|format| format.folder().to_owned());
        let formats: Vec<String> = formats.collect();
        let (packed, received) = mpsc::channel(1);
        let (packing, stored) = tokio::join!(
            self.cpu.run(move || pack(&dataset, &formats, &packed)),
            self.store_packed(lease, received),
        );
        stored?;
        packing??;
        Ok(json!({
            "attempts": attempts,
            "episodes": summary.episodes,
            "frames": summary.frames,
        }))
    }

    /// Sends episodes to the assembler.
    async fn send(&self, kept: &[KeptAttempt], units: mpsc::Sender<Unit>) -> Result<(), RecordError> {
        for attempt in kept {
            let (Some(unit), number) = (&attempt.made.unit, attempt.number) else { continue };
            let Some(bytes) = self.store.blobs().get(unit).await? else {
                return Err(RecordError::Episodeless { number });
            };
            if units.send(Unit::Next(number, bytes)).await.is_err() {
                // The assembler has failed, and says why.
                return Ok(());
            }
        }
        let _ = units.send(Unit::End).await;
        Ok(())
    }

    /// Stores what was packed: each part as a blob, and rows that say where the files are.
    async fn store_packed(
        &self,
        lease: &Lease,
        mut packed: mpsc::Receiver<Packed>,
    ) -> Result<(), RecordError> {
        let (mut files, mut place): (Vec<RecordingFile>, u64) = (Vec::new(), 0);
        let mut archive: Option<RecordingArchive> = None;
        while let Some(next) = packed.recv().await {
            match next {
                Packed::Begin { format } => {
                    archive =
                        Some(RecordingArchive { format, digest: None, size: 0, files: 0, parts: Vec::new() });
                }
                Packed::File(file) => {
                    files.push(file);
                    if files.len() == FILES_AT_ONCE {
                        self.record_files(lease, &mut place, &mut files).await?;
                    }
                }
                Packed::Part(bytes) => {
                    let Some(archive) = &mut archive else { continue };
                    let size = bytes.len() as u64;
                    let digest = self.store.blobs().put(bytes).await?;
                    archive.parts.push(ArchivePart { digest, size });
                    archive.size += size;
                    self.store.record_recording_archive(lease, archive.clone()).await?;
                }
                Packed::End { digest, files } => {
                    let Some(archive) = archive.take() else { continue };
                    let complete = RecordingArchive { digest: Some(digest), files, ..archive };
                    self.store.record_recording_archive(lease, complete).await?;
                }
            }
        }
        self.record_files(lease, &mut place, &mut files).await
    }

    async fn record_files(
        &self,
        lease: &Lease,
        place: &mut u64,
        files: &mut Vec<RecordingFile>,
    ) -> Result<(), RecordError> {
        let files = std::mem::take(files);
        let first = *place;
        *place += files.len() as u64;
        Ok(self.store.record_recording_files(lease, first, files).await?)
    }
}

/// Writes the dataset into its folder; blocks until all episodes have come.
fn written(
    prepared: &Prepared,
    dataset: &Path,
    card: DatasetCard,
    mut units: mpsc::Receiver<Unit>,
) -> Result<DatasetSummary, RecordError> {
    let setup = &prepared.preparation.setup;
    let description = setup.description();
    let mut assembler = DatasetAssembler::create(dataset, description.clone(), setup.formats(), card)?;
    loop {
        match units.blocking_recv() {
            Some(Unit::Next(number, bytes)) => {
                let unit = EpisodeUnit::from_bytes(&bytes, description)
                    .map_err(|_| RecordError::Episodeless { number })?;
                assembler.add(&unit)?;
            }
            Some(Unit::End) => return Ok(assembler.finish()?),
            None => return Err(RecordError::Stopped),
        }
    }
}

/// The attempts that belong into the dataset: those up to the last success that is wanted.
fn needed(kept: Vec<KeptAttempt>, recording: &RecordingRow) -> Result<Vec<KeptAttempt>, RecordError> {
    let mut successes = 0;
    let last = kept.iter().position(|attempt| {
        successes += u64::from(attempt.made.is_success());
        successes == recording.wanted
    });
    match last {
        Some(last) => Ok(kept.into_iter().take(last + 1).collect()),
        None => Err(too_few(&kept, successes, recording.wanted)),
    }
}

fn too_few(kept: &[KeptAttempt], successes: u64, wanted: u64) -> RecordError {
    let mut times: BTreeMap<&str, u64> = BTreeMap::new();
    let failures = || kept.iter().map(|attempt| &attempt.made).filter(|made| !made.is_success());
    for made in failures() {
        *times.entry(&made.outcome).or_default() += 1;
    }
    let reason = times.into_iter().max_by_key(|(_, times)| *times).map_or("", |(reason, _)| reason);
    let detail = failures().find(|made| made.outcome == reason).map_or("", |made| made.detail.as_str());
    let attempts = kept.len();
    let message = format!(
        "only {successes} of {wanted} episodes after {attempts} attempts; most fail with {reason} (such as: {detail}); \
         allow more with max_attempts, or choose another task"
    );
    Problem::new(ProblemType::Conflict, "too_few_successes", message).into()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pipeline::error::{StageError, StageErrorClass};
    use store::recordings::{MadeAttempt, RecordingState};

    fn recording(wanted: u64) -> RecordingRow {
        RecordingRow {
            id: "r".parse().expect("an id"),
            tenant_id: "t".parse().expect("an id"),
            scene_id: "s".parse().expect("an id"),
            state: RecordingState::Running,
            request: json!({}),
            bundle: store::Digest::of(b""),
            wanted,
            max_attempts: 9,
            identity: None,
            restarts: 0,
            begun: 4,
            made: 4,
            successes: 2,
            summary: None,
            failure_code: None,
            failure_message: None,
            created_at_ms: 0,
            started_at_ms: None,
            finished_at_ms: None,
            is_deleted: false,
        }
    }

    #[test]
    fn the_dataset_ends_with_the_last_success_that_is_wanted() {
        let kept: Vec<KeptAttempt> = (0..)
            .zip(["no_path", "success", "slipped", "slipped", "success", "slipped"])
            .map(|(number, outcome)| KeptAttempt {
                number,
                made: MadeAttempt { outcome: outcome.into(), detail: format!("of {number}"), unit: None },
            })
            .collect();
        let count = |wanted| needed(kept.clone(), &recording(wanted)).map(|kept| kept.len()).ok();
        assert_eq!((count(1), count(2), count(3)), (Some(2), Some(5), None));
        let error = StageError::from(needed(kept, &recording(3)).expect_err("too few"));
        let message = &error.message;
        assert_eq!((error.class, error.code), (StageErrorClass::Permanent, "too_few_successes"));
        assert!(message.contains("only 2 of 3") && message.contains("slipped (such as: of 2)"), "{message}");
    }
}
