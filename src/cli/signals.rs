//! Ctrl-C and SIGTERM: the first asks, the second does not ask.

use tokio::signal::unix::{Signal, SignalKind, signal};
use tokio_util::sync::CancellationToken;

use super::{Exit, Failure, terminal};

/// A token that is cancelled by the first signal; the second ends the process at once. `says` is
/// printed when the first arrives.
pub fn stop_on_signal(says: &'static str) -> Result<CancellationToken, Failure> {
    let failed = |error| Failure::new(Exit::Error, format!("cannot listen for signals: {error}"));
    let mut interrupt = signal(SignalKind::interrupt()).map_err(failed)?;
    let mut terminate = signal(SignalKind::terminate()).map_err(failed)?;
    let stop = CancellationToken::new();
    let stopping = stop.clone();
    tokio::spawn(async move {
        either(&mut interrupt, &mut terminate).await;
        terminal::note(says);
        stopping.cancel();
        either(&mut interrupt, &mut terminate).await;
        terminal::note("stopped at once; finished stages are kept");
        std::process::exit(i32::from(Exit::Interrupted.code()));
    });
    Ok(stop)
}

async fn either(a: &mut Signal, b: &mut Signal) {
    tokio::select! {
        _ = a.recv() => {}
        _ = b.recv() => {}
    }
}
