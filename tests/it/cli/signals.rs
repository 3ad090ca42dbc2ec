//! Signals that tests send to the program.

use std::process::Child;
use std::time::{Duration, Instant};

/// A mask of signals ("SigCgt", "SigIgn") in the status of a process: bit 0 is signal 1.
pub fn mask(process: &str, name: &str) -> Option<u64> {
    let status = std::fs::read_to_string(format!("/proc/{process}/status")).ok()?;
    let digits = status.lines().find_map(|line| line.strip_prefix(name)?.strip_prefix(':'))?;
    u64::from_str_radix(digits.trim(), 16).ok()
}

/// The signals that stop the program, as `kill` takes them. Where the tests were started by `nohup`, SIGHUP is none:
/// the program inherits that it is ignored.
pub fn that_stop() -> Vec<&'static str> {
    const HANG_UP: u64 = 1;
    let ignored = mask("self", "SigIgn").unwrap_or(0);
    let hang_up = (ignored & HANG_UP == 0).then_some("-HUP");
    ["-INT", "-TERM"].into_iter().chain(hang_up).collect()
}

/// Waits until a process handles SIGTERM itself. Earlier, a signal ends it without a word.
pub fn wait_for_handlers(process: &Child) {
    const TERMINATE: u64 = 1 << 14;
    let until = Instant::now() + Duration::from_secs(60);
    let handled = || mask(&process.id().to_string(), "SigCgt").unwrap_or(0);
    while handled() & TERMINATE == 0 {
        assert!(Instant::now() < until, "the process never handles SIGTERM");
        std::thread::sleep(Duration::from_millis(20));
    }
}
