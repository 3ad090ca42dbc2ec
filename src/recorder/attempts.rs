//! One attempt of a recording.

use super::{RecordError, Recorder};
use crate::problem::{Problem, ProblemType};
use demonstrations::{Attempted, attempt};
use store::Lease;
use store::recordings::{AttemptWork, Begun, MadeAttempt};

impl Recorder {
    /// Makes an attempt, and puts the blob of its episode.
    pub(super) async fn make(&self, lease: &Lease, work: &AttemptWork) -> Result<MadeAttempt, RecordError> {
        let AttemptWork { recording, number } = work;
        let prepared = self.prepared(recording).await?;
        if recording.identity.as_ref() != Some(&prepared.identity) {
            match self.store.begin_recording(lease, &prepared.identity).await? {
                Begun::Agreed => {}
                Begun::Restarted => tracing::warn!(
                    recording_id = %recording.id,
                    "the attempts so far are of another version or type of machine; they are made again"
                ),
                Begun::Disputed => return Err(disputed().into()),
            }
        }
        let number = *number;
        let attempting = self.cpu.run(move || {
            let preparation = &prepared.preparation;
            attempt(&preparation.setup, number, preparation.keeps_failures)
        });
        let (outcome, detail, unit) = match attempting.await?? {
            Attempted::Succeeded(unit) => ("success".to_owned(), String::new(), Some(unit)),
            Attempted::Failed { reason, detail, unit } => (reason, detail, unit),
        };
        let unit = match unit {
            Some(unit) => Some(self.store.blobs().put(unit.to_bytes()).await?),
            None => None,
        };
        Ok(MadeAttempt { outcome, detail, unit })
    }
}

fn disputed() -> Problem {
    let message = "processes of different versions, or on machines of different types, work on recordings at the same \
                   time; update all of them, then order it again";
    Problem::new(ProblemType::Conflict, "versions_differ", message)
}
