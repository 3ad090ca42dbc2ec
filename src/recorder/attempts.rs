//! One attempt of a recording, made and kept.

use std::sync::Arc;

use tokio::sync::OwnedSemaphorePermit;
use tokio_util::sync::CancellationToken;

use super::{RecordError, Recorder, apart, guarded};
use crate::worker::verdict::Verdict;
use demonstrations::{Attempted, attempt};
use store::recordings::{AttemptLease, Begun, MadeAttempt, RecordingClaim, RecordingRow};

impl Recorder {
    /// Makes an attempt, and writes down what came of it.
    pub(super) async fn attempt(
        &self,
        claim: &RecordingClaim,
        lease: &AttemptLease,
        slot: Arc<OwnedSemaphorePermit>,
        shutdown: &CancellationToken,
    ) {
        let making = {
            let (recorder, recording, lease) = (self.clone(), claim.recording.clone(), lease.clone());
            let slot = slot.clone();
            guarded(async move { recorder.make(&recording, &lease, &slot).await })
        };
        let made = tokio::select! {
            made = making => made,
            () = self.hold_attempt(lease) => Err(RecordError::GivenUp),
            () = shutdown.cancelled() => Err(RecordError::GivenUp),
        };
        self.conclude_attempt(claim, lease, made).await;
    }

    /// Writes down what came of an attempt.
    pub(super) async fn conclude_attempt(
        &self,
        claim: &RecordingClaim,
        lease: &AttemptLease,
        made: Result<(), RecordError>,
    ) {
        let Err(error) = made else { return };
        let ended = match error.verdict() {
            Verdict::Refused { code, message } => {
                tracing::info!(recording_id = %lease.id, code, message, "episodes cannot be recorded");
                self.store.fail_recording(lease, code, &message).await
            }
            Verdict::Again { code, charged } => {
                let setback = self.setback(claim, &error, code, charged);
                self.store.set_attempt_back(lease, setback).await.map(drop)
            }
            Verdict::GivenUp => self.store.release_attempt(lease).await,
        };
        if let Err(error) = ended {
            tracing::debug!(error = error.chain(), "an attempt was not given back; its lease will run out");
        }
    }

    async fn make(
        &self,
        recording: &RecordingRow,
        lease: &AttemptLease,
        slot: &Arc<OwnedSemaphorePermit>,
    ) -> Result<(), RecordError> {
        let prepared = self.prepared(recording, slot).await?;
        if recording.identity.as_ref() != Some(&prepared.identity) {
            match self.store.begin_recording(lease, &prepared.identity).await? {
                Begun::Agreed => {}
                Begun::Restarted => {
                    tracing::warn!(
                        recording_id = %lease.id,
                        "the attempts so far are of another version or type of machine; recording begins anew"
                    );
                    return Err(RecordError::GivenUp);
                }
                Begun::Failed => return Err(RecordError::GivenUp),
            }
        }
        let number = lease.number;
        let attempted = apart(slot, move || {
            let preparation = &prepared.preparation;
            Ok(attempt(&preparation.setup, number, preparation.keeps_failures)?)
        });
        let (outcome, detail, unit) = match attempted.await? {
            Attempted::Succeeded(unit) => ("success".to_owned(), String::new(), Some(unit)),
            Attempted::Failed { reason, detail, unit } => (reason, detail, unit),
        };
        let unit = match unit {
            Some(unit) => Some(self.store.blobs().put(unit.to_bytes()).await?),
            None => None,
        };
        self.store.keep_attempt(lease, MadeAttempt { outcome, detail, unit }).await?;
        Ok(())
    }

    /// Renews the lease; returns when it is lost.
    async fn hold_attempt(&self, lease: &AttemptLease) {
        loop {
            tokio::time::sleep(self.lease() / 4).await;
            match self.store.renew_attempt(lease, self.lease()).await {
                Ok(true) => {}
                Ok(false) => return,
                // The next renewal may succeed before the lease has run out.
                Err(error) => {
                    tracing::debug!(error = error.chain(), "the lease of an attempt was not renewed")
                }
            }
        }
    }
}
