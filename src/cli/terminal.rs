//! Writing to the terminal. A reader that went away (`| head`) is no reason to fail.

use std::io::Write;
use std::sync::atomic::{AtomicBool, Ordering};

/// Whether only results and complaints are written.
static QUIET: AtomicBool = AtomicBool::new(false);

/// Writes no notes from now on.
pub fn be_quiet() {
    QUIET.store(true, Ordering::Relaxed);
}

/// Whether notes and progress are left out.
pub fn is_quiet() -> bool {
    QUIET.load(Ordering::Relaxed)
}

/// Text to standard output, as it is.
pub fn print(text: &str) {
    let mut out = std::io::stdout().lock();
    // A failure here cannot be reported anywhere.
    let _ = out.write_all(text.as_bytes()).and_then(|()| out.flush());
}

/// A line to standard error, unless only complaints are wanted.
pub fn note(line: &str) {
    if !is_quiet() {
        let _ = writeln!(std::io::stderr().lock(), "{line}");
    }
}

/// A complaint to standard error.
pub fn complain(message: &str) {
    let _ = writeln!(std::io::stderr().lock(), "tabletopgen: {message}");
}
