//! Progress of a recording, and the time that the rest takes at the pace of its last attempts.

use schemars::JsonSchema;
use serde::Serialize;
use sqlx::{AnyConnection, Row};

use super::attempts::SUCCESS;
use super::{RecordingRow, RecordingState};
use crate::boxed;
use crate::{Store, StoreError};

/// Attempts that the pace is read from.
const PACE_ATTEMPTS: i64 = 64;

/// Progress of a recording.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct RecordingProgress {
    /// Attempts that have an outcome.
    #[schemars(range(min = 0, max = 1_000_000))]
    pub attempts: u64,
    #[schemars(range(min = 1, max = 1_000_000))]
    pub max_attempts: u64,
    /// Also those beyond what is wanted, which are no part of the dataset.
    #[schemars(range(min = 0, max = 1_000_000))]
    pub successes: u64,
    #[schemars(range(min = 1, max = 100_000))]
    pub wanted: u64,
    /// Of the attempts so far.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub success_rate: Option<f64>,
    /// By the pace of the last attempts, without assembling; null before the first success and after the end.
    #[schemars(range(min = 0.0, max = 3_200_000_000.0))]
    pub seconds_left: Option<f64>,
}

/// Present pace of attempts.
#[derive(Clone, Copy, Debug, PartialEq)]
struct AttemptPace {
    successes: u64,
    /// Time that they took together, milliseconds.
    duration_ms: i64,
}

impl Store {
    /// Progress of a recording. It reads a bounded number of attempts. The caller checks the tenant.
    #[boxed]
    pub async fn recording_progress(
        &self,
        recording: &RecordingRow,
    ) -> Result<RecordingProgress, StoreError> {
        let read = async { progress(&mut *self.readers.acquire().await?, recording).await };
        self.readers.within_limit(read).await
    }
}

/// Progress of a recording.
pub(super) async fn progress(
    connection: &mut AnyConnection,
    recording: &RecordingRow,
) -> Result<RecordingProgress, StoreError> {
    let pace = match recording.state {
        RecordingState::Running => pace(connection, recording).await?,
        _ => None,
    };
    let (made, successes) = (recording.made, recording.successes);
    Ok(RecordingProgress {
        attempts: made,
        max_attempts: recording.max_attempts,
        successes,
        wanted: recording.wanted,
        success_rate: (made > 0).then(|| successes as f64 / made as f64),
        seconds_left: pace.map(|pace| pace.seconds_of(recording.wanted.saturating_sub(successes))),
    })
}

impl AttemptPace {
    /// The time that so many successes take.
    fn seconds_of(self, successes: u64) -> f64 {
        1e-3 * self.duration_ms as f64 * successes as f64 / self.successes as f64
    }
}

/// The pace of the attempts that were made last, or of all while there are few; `None` before the first success.
async fn pace(
    connection: &mut AnyConnection,
    recording: &RecordingRow,
) -> Result<Option<AttemptPace>, StoreError> {
    let rows = sqlx::query(
        "SELECT outcome, made_at FROM recording_attempts
         WHERE recording_id = $1 AND outcome IS NOT NULL ORDER BY number DESC LIMIT $2",
    )
    .bind(recording.id.as_str())
    .bind(PACE_ATTEMPTS)
    .fetch_all(connection)
    .await?;
    let mut made = Vec::with_capacity(rows.len());
    for row in &rows {
        let made_at: i64 = row.try_get("made_at")?;
        made.push((made_at, row.try_get::<String, _>("outcome")? == SUCCESS));
    }
    made.sort_unstable();
    let last_ms = made.last().map(|(made_at, _)| *made_at);
    let first_ms = if made.len() < PACE_ATTEMPTS as usize {
        recording.started_at_ms
    } else {
        // The first one took its time before it was made.
        Some(made.remove(0).0)
    };
    let successes = made.iter().filter(|(_, succeeded)| *succeeded).count() as u64;
    let duration_ms = last_ms.zip(first_ms).map_or(0, |(last, first)| last - first);
    Ok((successes > 0 && duration_ms > 0).then_some(AttemptPace { successes, duration_ms }))
}
