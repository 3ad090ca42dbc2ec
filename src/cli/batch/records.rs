//! `output.jsonl` and `errors.jsonl`: a line for every request that came to its end.
//!
//! A run writes both anew and puts them in place when it knows what earlier runs did; from then on it appends. A line
//! is one write, so a crash cuts off the last line at most, and the next run writes it again.

use std::fs::File;
use std::io::Write;
use std::path::{Path, PathBuf};

use crate::cli::{Exit, Failure};
use batches::OutputLine;

/// Requests with a bundle, and duplicates of them.
pub(super) const OUTPUT: &str = "output.jsonl";

/// Requests that have no bundle.
pub(super) const ERRORS: &str = "errors.jsonl";

/// The two files.
pub(super) struct Records {
    out: PathBuf,
    output: File,
    errors: File,
}

impl Records {
    /// Begins both files beside those of an earlier run.
    pub(super) fn begin(out: &Path) -> Result<Self, Failure> {
        let create = |name: &str| {
            let path = part(out, name);
            File::create(&path).map_err(|error| unwritable(&path, &error))
        };
        Ok(Self { out: out.to_owned(), output: create(OUTPUT)?, errors: create(ERRORS)? })
    }

    /// Puts both files in the place of those of an earlier run.
    pub(super) fn publish(&self) -> Result<(), Failure> {
        for name in [OUTPUT, ERRORS] {
            let path = self.out.join(name);
            std::fs::rename(part(&self.out, name), &path).map_err(|error| unwritable(&path, &error))?;
        }
        Ok(())
    }

    /// Appends a line to the file that it belongs to.
    pub(super) fn write(&mut self, line: &OutputLine) -> Result<(), Failure> {
        let (file, name) =
            if line.is_error() { (&mut self.errors, ERRORS) } else { (&mut self.output, OUTPUT) };
        file.write_all(line.text().as_bytes()).map_err(|error| unwritable(&self.out.join(name), &error))
    }
}

fn part(out: &Path, name: &str) -> PathBuf {
    out.join(format!("{name}.part"))
}

fn unwritable(path: &Path, error: &std::io::Error) -> Failure {
    Failure::new(Exit::Error, format!("cannot write {}: {error}", path.display()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use batches::{OutputError, RequestState};

    #[test]
    fn an_earlier_run_stays_until_the_new_files_are_in_place() {
        let out = tempfile::tempdir().expect("temporary directory");
        let read = |name: &str| std::fs::read_to_string(out.path().join(name)).expect(name);
        std::fs::write(out.path().join(OUTPUT), "{\"custom_id\":\"a\"}\n{\"custo").expect("writes");
        let mut records = Records::begin(out.path()).expect("begins");
        let line =
            |state| OutputLine::not_computed(Some("a".into()), state, OutputError::new("code", "message"));
        records.write(&line(RequestState::Invalid)).expect("writes");
        assert!(read(OUTPUT).ends_with("{\"custo"), "not replaced yet");
        records.publish().expect("renames");
        assert_eq!((read(OUTPUT).lines().count(), read(ERRORS).lines().count()), (0, 1));
        records.write(&line(RequestState::Succeeded)).expect("appends");
        records.write(&line(RequestState::Failed)).expect("appends");
        assert_eq!((read(OUTPUT).lines().count(), read(ERRORS).lines().count()), (1, 2));
    }
}
