//! Attempts until there are enough episodes, by several workers, and the dataset of them: for the command line. On a
//! server the module `recorder` does that, with jobs.
//!
//! Attempts are numbered; the dataset has the first so many that succeed. How many workers there were, when it was
//! stopped and went on, and which attempts beyond the last were made, leaves no trace in it.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

use serde_json::json;

use super::unit_folder::{AttemptOutcome, FolderError, UnitFolder};
use demonstrations::{Setup, attempt};
use episodes::card::{DatasetCard, DatasetSummary};
use episodes::{DatasetAssembler, EpisodeError, EpisodeUnit};

/// Progress of the recording of an order.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Tally {
    pub attempts: u64,
    pub successes: u64,
}

/// Recorded dataset. It lies with its attempts until it has its place.
pub struct Recorded {
    pub summary: DatasetSummary,
    /// Number of attempts by outcome, `success` or reason.
    pub attempts: BTreeMap<String, u64>,
    units: UnitFolder,
}

impl Recorded {
    /// The complete dataset, to be moved to its place.
    pub fn dataset(&self) -> PathBuf {
        self.units.dataset()
    }

    /// Removes the attempts of a dataset that has its place.
    ///
    /// # Errors
    ///
    /// [`RecordError::Folder`] if they cannot be removed.
    pub fn forget_attempts(self) -> Result<(), RecordError> {
        Ok(self.units.remove()?)
    }
}

/// Wanted amount.
#[derive(Clone, Copy, Debug)]
pub struct Amount {
    /// Episodes that succeed.
    pub count: u64,
    pub max_attempts: u64,
    pub keeps_failures: bool,
    pub workers: usize,
}

/// Reason why there is no dataset.
#[derive(Debug, thiserror::Error)]
pub enum RecordError {
    #[error("stopped; {kept} attempts are kept in {folder}: the same command goes on")]
    Stopped { kept: u64, folder: String },
    #[error(
        "only {successes} of {count} episodes after {attempts} attempts; most fail with {reason} (such as: {detail})"
    )]
    TooFew { successes: u64, count: u64, attempts: u64, reason: String, detail: String },
    #[error(transparent)]
    Folder(#[from] FolderError),
    #[error(transparent)]
    Episode(#[from] EpisodeError),
}

/// Records an order whose dataset is to be at `folder`. Beside that, finished attempts are kept, and in the end the
/// dataset, until it has its place.
///
/// # Errors
///
/// [`RecordError`]; finished attempts are kept.
pub fn record(
    setup: &Setup,
    folder: &Path,
    amount: Amount,
    card: DatasetCard,
    stop: &AtomicBool,
    progress: &(dyn Fn(Tally) + Sync),
) -> Result<Recorded, RecordError> {
    let order = json!({
        "dataset": setup.description().digest(),
        "identity": setup.identity(),
        "keeps_failures": amount.keeps_failures,
    });
    let units = UnitFolder::open(folder, &order.to_string())?;
    let mut done = units.outcomes()?;
    make_attempts(setup, &units, &mut done, amount, stop, progress)?;
    let Some(last) = last_needed(&done, amount.count) else {
        let successes = done.values().filter(|outcome| outcome.is_success()).count() as u64;
        if stop.load(Ordering::Relaxed) {
            let folder = units.path().display().to_string();
            return Err(RecordError::Stopped { kept: done.len() as u64, folder });
        }
        return Err(too_few(&done, successes, amount.count));
    };
    done.retain(|number, _| *number <= last);
    let mut attempts = BTreeMap::new();
    for outcome in done.values() {
        *attempts.entry(outcome.outcome.clone()).or_insert(0) += 1;
    }
    let card = DatasetCard { attempts: attempts.clone(), ..card };
    let summary = assemble(setup, &units, &done, card)?;
    Ok(Recorded { summary, attempts, units })
}

/// The number of the attempt that is the last of the dataset. `None` if there are too few successes, or if an attempt
/// before it is missing, as after a stop: that one might be a success, and belongs into the dataset then.
fn last_needed(done: &BTreeMap<u64, AttemptOutcome>, count: u64) -> Option<u64> {
    let without_gap = (0..).zip(done).take_while(|(expected, (number, _))| expected == *number);
    let successes = without_gap.filter(|(_, (_, outcome))| outcome.is_success());
    successes.map(|(number, _)| number).nth(usize::try_from(count).ok()?.checked_sub(1)?)
}

fn make_attempts(
    setup: &Setup,
    units: &UnitFolder,
    done: &mut BTreeMap<u64, AttemptOutcome>,
    amount: Amount,
    stop: &AtomicBool,
    progress: &(dyn Fn(Tally) + Sync),
) -> Result<(), RecordError> {
    let next = AtomicU64::new(0);
    let shared = Mutex::new((std::mem::take(done), None::<RecordError>));
    let lock = || shared.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
    let is_enough = |done: &BTreeMap<u64, AttemptOutcome>| {
        // Numbers are given out in order, so all below one that was begun are finished in the end.
        let successes = done.values().filter(|outcome| outcome.is_success()).count() as u64;
        successes >= amount.count
    };
    let work = || {
        loop {
            let number = next.fetch_add(1, Ordering::Relaxed);
            if number >= amount.max_attempts || stop.load(Ordering::Relaxed) {
                return;
            }
            {
                let (done, error) = &*lock();
                // An attempt below a success must be made even if there are enough.
                let is_below = done.range(number..).any(|(_, outcome)| outcome.is_success());
                if error.is_some() || (is_enough(done) && !is_below) {
                    return;
                }
                if done.contains_key(&number) {
                    continue;
                }
            }
            let made = attempt(setup, number, amount.keeps_failures)
                .map_err(RecordError::from)
                .and_then(|attempted| units.keep(number, &attempted).map_err(RecordError::from));
            let mut shared = lock();
            match made {
                Ok(outcome) => {
                    shared.0.insert(number, outcome);
                    let successes = shared.0.values().filter(|outcome| outcome.is_success()).count();
                    progress(Tally { attempts: shared.0.len() as u64, successes: successes as u64 });
                }
                Err(error) => {
                    shared.1.get_or_insert(error);
                    return;
                }
            }
        }
    };
    std::thread::scope(|scope| {
        for _ in 0..amount.workers.max(1) {
            scope.spawn(work);
        }
    });
    let (finished, error) = shared.into_inner().unwrap_or_else(std::sync::PoisonError::into_inner);
    *done = finished;
    error.map_or(Ok(()), Err)
}

fn too_few(done: &BTreeMap<u64, AttemptOutcome>, successes: u64, count: u64) -> RecordError {
    let mut reasons: BTreeMap<&str, (u64, &str)> = BTreeMap::new();
    for outcome in done.values().filter(|outcome| !outcome.is_success()) {
        reasons.entry(&outcome.outcome).or_insert((0, &outcome.detail)).0 += 1;
    }
    let frequent = reasons.into_iter().max_by_key(|(_, (times, _))| *times);
    let (reason, (_, detail)) =
        frequent.unwrap_or(("nothing", (0, "no attempt failed; allow more attempts")));
    RecordError::TooFew {
        successes,
        count,
        attempts: done.len() as u64,
        reason: reason.to_owned(),
        detail: detail.to_owned(),
    }
}

fn assemble(
    setup: &Setup,
    units: &UnitFolder,
    done: &BTreeMap<u64, AttemptOutcome>,
    card: DatasetCard,
) -> Result<DatasetSummary, RecordError> {
    let description = setup.description();
    let folder = units.free_dataset()?;
    let mut assembler = DatasetAssembler::create(&folder, description.clone(), setup.formats(), card)?;
    for (number, _) in done.iter().filter(|(_, outcome)| outcome.is_recorded) {
        let unit = EpisodeUnit::from_bytes(&units.unit(*number)?, description).inspect_err(|_| {
            // The same command makes it again.
            let _ = units.forget(*number);
        })?;
        assembler.add(&unit)?;
    }
    Ok(assembler.finish()?)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_attempt_that_a_stop_left_out_belongs_before_later_successes() {
        let outcome = |word: &str| AttemptOutcome {
            outcome: word.to_owned(),
            detail: String::new(),
            is_recorded: word == "success",
        };
        let mut done: BTreeMap<u64, AttemptOutcome> =
            [(0, outcome("slipped")), (2, outcome("success")), (3, outcome("success"))].into();
        assert_eq!(last_needed(&done, 1), None, "attempt 1 is missing");
        done.insert(1, outcome("success"));
        assert_eq!(last_needed(&done, 1), Some(1));
        assert_eq!(last_needed(&done, 3), Some(3));
        assert_eq!(last_needed(&done, 4), None);
    }
}
