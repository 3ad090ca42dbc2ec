//! Ctrl-C, SIGTERM and SIGHUP: the first asks, the second does not ask.
//!
//! SIGHUP says that the terminal is gone. A process that was started to outlive it (`nohup`) ignores it.

use tokio::signal::unix::{Signal, SignalKind, signal};
use tokio_util::sync::CancellationToken;

use super::{Exit, Failure, terminal};

/// The signals that end a command.
struct Signals {
    interrupt: Signal,
    terminate: Signal,
    /// `None` where the process ignores it.
    hang_up: Option<Signal>,
}

/// A token that is cancelled by the first signal; the second ends the process at once. `says` is
/// printed when the first arrives.
pub fn stop_on_signal(says: &'static str) -> Result<CancellationToken, Failure> {
    let mut signals = Signals::listen()
        .map_err(|error| Failure::new(Exit::Error, format!("cannot listen for signals: {error}")))?;
    let stop = CancellationToken::new();
    let stopping = stop.clone();
    tokio::spawn(async move {
        signals.next().await;
        terminal::note(says);
        stopping.cancel();
        signals.next().await;
        terminal::note("stopped at once; finished stages are kept");
        std::process::exit(i32::from(Exit::Interrupted.code()));
    });
    Ok(stop)
}

impl Signals {
    fn listen() -> std::io::Result<Self> {
        let hang_up = if ignores_hang_up() { None } else { Some(signal(SignalKind::hangup())?) };
        Ok(Self {
            interrupt: signal(SignalKind::interrupt())?,
            terminate: signal(SignalKind::terminate())?,
            hang_up,
        })
    }

    async fn next(&mut self) {
        let hung_up = async {
            match &mut self.hang_up {
                Some(hang_up) => hang_up.recv().await,
                None => std::future::pending().await,
            }
        };
        tokio::select! {
            _ = self.interrupt.recv() => {}
            _ = self.terminate.recv() => {}
            _ = hung_up => {}
        }
    }
}

/// Whether the process was started with SIGHUP ignored. Only Linux says so.
fn ignores_hang_up() -> bool {
    std::fs::read_to_string("/proc/self/status").is_ok_and(|status| is_hang_up_ignored(&status))
}

/// Whether the mask of ignored signals in a `/proc/PID/status` has the first one, SIGHUP.
fn is_hang_up_ignored(status: &str) -> bool {
    let mask = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    mask.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok()).is_some_and(|mask| mask & 1 == 1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hang_up_is_the_lowest_bit_of_the_ignored_signals() {
        for (status, expected) in [
            ("Name:\tsh\nSigIgn:\t0000000000000001\nSigCgt:\t0000000000000000\n", true),
            ("SigIgn:\t0000000000001001\n", true),
            ("SigIgn:\t0000000000001000\nSigCgt:\t0000000000000001\n", false),
            ("Name:\tsh\n", false),
        ] {
            assert_eq!(is_hang_up_ignored(status), expected, "{status:?}");
        }
    }
}
