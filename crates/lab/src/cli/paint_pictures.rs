//! `paint-pictures`: paints pictures of one split with the truth about them, one folder a picture.
//!
//! `OUT/<split>/<number>/` gets `picture.jpg`, `labels.png` (8-bit gray: 0 backdrop, 1 the table but for its top, 2 bare
//! top, 3 and up the objects in the order of the truth) and, last, `truth.json`. A picture whose truth is there in the
//! size asked for is whole and is not painted again, so an interrupted run goes on where it was.

use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Instant;

use clap::Args;
use rayon::prelude::*;

use super::split::SplitName;
use crate::synthetic::{PictureTruth, Split, paint};
use tabletopgen::cli::{Exit, Failure, terminal};

/// Pictures between two lines of progress.
const REPORTED_EVERY: u64 = 100;

/// Arguments of `paint-pictures`.
#[derive(Debug, Args)]
pub struct Arguments {
    /// Which pictures: the three share no category of thing, no finish of a top and no backdrop
    #[arg(long, value_enum)]
    split: SplitName,
    /// How many
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..))]
    count: u64,
    /// Number of the first
    #[arg(long, value_name = "K", default_value_t = 0)]
    first: u64,
    /// Longer side of each
    #[arg(long, value_name = "PIXELS", default_value_t = 512, value_parser = clap::value_parser!(u32).range(64..=4096))]
    size_px: u32,
    /// Folder they are written to; what is whole there is kept
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// Threads that paint [default: one per core]; the pictures do not depend on it
    #[arg(long, value_name = "N", default_value_t = 0, hide_default_value = true)]
    threads: usize,
}

/// Paints what is not there yet.
pub fn run(arguments: Arguments) -> Result<Exit, Failure> {
    let split = Split::from(arguments.split);
    let folder = arguments.out.join(split.name());
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(arguments.threads)
        .build()
        .map_err(|error| Failure::new(Exit::Error, format!("cannot start threads to paint with: {error}")))?;
    let started = Instant::now();
    let (painted, kept) = (AtomicU64::new(0), AtomicU64::new(0));
    let last = arguments.first.saturating_add(arguments.count);
    pool.install(|| {
        (arguments.first..last).into_par_iter().try_for_each(|number| -> Result<(), Failure> {
            let place = folder.join(format!("{number:06}"));
            if is_whole(&place, number, arguments.size_px) {
                kept.fetch_add(1, Ordering::Relaxed);
                return Ok(());
            }
            write(&place, split, number, arguments.size_px)?;
            let done = painted.fetch_add(1, Ordering::Relaxed) + 1;
            if done.is_multiple_of(REPORTED_EVERY) {
                let each = started.elapsed().as_secs_f64() / done as f64;
                terminal::note(&format!("{done} painted, {:.0} ms each", 1e3 * each));
            }
            Ok(())
        })
    })?;
    terminal::note(&format!(
        "{} painted, {} were there; {:.0} s; in {}",
        painted.into_inner(),
        kept.into_inner(),
        started.elapsed().as_secs_f64(),
        folder.display()
    ));
    Ok(Exit::Success)
}

/// Whether the picture lies there, in that size.
fn is_whole(place: &Path, number: u64, size_px: u32) -> bool {
    let truth = std::fs::read(place.join("truth.json")).ok();
    let truth = truth.and_then(|bytes| serde_json::from_slice::<PictureTruth>(&bytes).ok());
    truth.is_some_and(|truth| truth.number == number && truth.width_px.max(truth.height_px) == size_px)
}

/// The truth comes last, and whole: where it is, everything is.
fn write(place: &Path, split: Split, number: u64, size_px: u32) -> Result<(), Failure> {
    let painting = paint(split, number, size_px);
    let truth = serde_json::to_vec(&painting.truth)
        .map_err(|error| Failure::new(Exit::Error, format!("the truth has no JSON form: {error}; a bug")))?;
    let written = std::fs::create_dir_all(place)
        .and_then(|()| std::fs::write(place.join("picture.jpg"), &painting.jpeg))
        .and_then(|()| std::fs::write(place.join("labels.png"), painting.labels.png()))
        .and_then(|()| std::fs::write(place.join("truth.json.part"), truth))
        .and_then(|()| std::fs::rename(place.join("truth.json.part"), place.join("truth.json")));
    written.map_err(|error| {
        Failure::new(
            Exit::Error,
            format!("cannot write {}: {error}; choose another place with --out", place.display()),
        )
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_whole_is_kept_and_what_is_broken_is_painted_again() {
        let home = tempfile::tempdir().expect("a folder");
        let place = home.path().join("000005");
        assert!(!is_whole(&place, 5, 96));
        write(&place, Split::Validation, 5, 96).expect("written");
        assert!(is_whole(&place, 5, 96) && !is_whole(&place, 5, 128) && !is_whole(&place, 6, 96));
        let picture = std::fs::read(place.join("picture.jpg")).expect("a picture");
        std::fs::write(place.join("truth.json"), b"{\"split\":").expect("written");
        assert!(!is_whole(&place, 5, 96));
        write(&place, Split::Validation, 5, 96).expect("written");
        assert_eq!(std::fs::read(place.join("picture.jpg")).expect("a picture"), picture);
    }
}
