//! Writing to the terminal. A reader that went away (`| head`) is no reason to fail.

use std::io::Write;

/// Text to standard output, as it is.
pub fn print(text: &str) {
    let mut out = std::io::stdout().lock();
    // A failure here cannot be reported anywhere.
    let _ = out.write_all(text.as_bytes()).and_then(|()| out.flush());
}

/// A line to standard error.
pub fn note(line: &str) {
    let _ = writeln!(std::io::stderr().lock(), "{line}");
}

/// A complaint to standard error.
pub fn complain(message: &str) {
    note(&format!("tabletopgen: {message}"));
}
