//! A computation of the command line that is no job: its stages on standard error, and an end by a signal.
//!
//! Nothing is written before the computation is over, so the first signal ends the command at once.

use std::time::{SystemTime, UNIX_EPOCH};

use serde_json::json;
use tokio::sync::mpsc::{UnboundedSender, unbounded_channel};

use super::progress::Progress;
use super::{Exit, Failure, block_on, signals};
use crate::app::activity::{Activity, Watch};
use store::events::Event;

/// Computes beside the signals. `quiet` writes no progress.
///
/// # Errors
///
/// That of the computation, and exit 130 where a signal ended it.
pub fn computed<T: Send + 'static>(
    quiet: bool,
    compute: impl FnOnce(Watch) -> Result<T, Failure> + Send + 'static,
) -> Result<T, Failure> {
    block_on(async {
        let stop = signals::stop_on_signal("stopping")?;
        let mut progress = Progress::new(quiet);
        let (sender, mut activities) = unbounded_channel();
        let mut computing = tokio::task::spawn_blocking(move || compute(&tell(sender)));
        loop {
            tokio::select! {
                biased;
                () = stop.cancelled() => {
                    let message = format!("interrupted {}; nothing was written", progress.place());
                    return Err(Failure::new(Exit::Interrupted, message));
                }
                Some(activity) = activities.recv() => progress.see(&event(activity)),
                done = &mut computing => {
                    while let Ok(activity) = activities.try_recv() {
                        progress.see(&event(activity));
                    }
                    progress.finish();
                    return done.map_err(|died| {
                        Failure::new(Exit::Error, format!("the computation ended {}: {died}", progress.place()))
                    })?;
                }
            }
        }
    })
}

fn tell(sender: UnboundedSender<Activity>) -> impl Fn(Activity) {
    move |activity| {
        // Who waits is gone only when the process ends.
        let _ = sender.send(activity);
    }
}

/// The event that a job with this stage would have.
fn event(activity: Activity) -> Event {
    let (kind, data) = match activity {
        Activity::Began { stage, instance } => {
            ("stage_started", json!({ "stage": stage, "instance": instance }))
        }
        Activity::Ended { stage, instance } => {
            ("stage_finished", json!({ "stage": stage, "instance": instance, "cached": false }))
        }
        Activity::Found { stage, message } => {
            ("stage_progress", json!({ "stage": stage, "message": message }))
        }
    };
    let now = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
    let at_ms = i64::try_from(now.as_millis()).unwrap_or(i64::MAX);
    Event { seq: 0, at_ms, kind: kind.to_owned(), data }
}
