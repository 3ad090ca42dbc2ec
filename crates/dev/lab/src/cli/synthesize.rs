//! `synthesize`: writes sample images of one split with their ground truth, one folder per image.
//!
//! `OUT/<split>/<number>/` gets `image.jpg`, `labels.png` (8-bit gray: 0 backdrop, 1 table without its top, 2 bare
//! top, 3 and up the objects in truth order), with `--depth` `depth.png` (16-bit gray, millimeters, 0 backdrop) and,
//! last, `truth.json`. An image whose truth exists in the requested
//! size is complete and is kept, so an interrupted run resumes.

use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Instant;

use clap::Args;
use rayon::prelude::*;

use super::split::SplitName;
use crate::synthetic_images::{ImageTruth, Split, SyntheticImage, synthesize, synthesize_close_up};
use tabletopgen::cli::{Exit, Failure, terminal};

/// Images per progress line.
const REPORTED_EVERY: u64 = 100;

/// Arguments of `synthesize`.
#[derive(Debug, Args)]
pub struct Arguments {
    /// The split; splits share no object category, no finish of a top and no backdrop
    #[arg(long, value_enum)]
    split: SplitName,
    /// Number of images
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..))]
    count: u64,
    /// Number of the first image
    #[arg(long, value_name = "K", default_value_t = 0)]
    first: u64,
    /// Longer side of the images
    #[arg(long, value_name = "PIXELS", default_value_t = 512, value_parser = clap::value_parser!(u32).range(64..=4096))]
    size_px: u32,
    /// Close-ups of one object each, which go through all categories; OUT gets a folder "close_ups" for them
    #[arg(long)]
    close_ups: bool,
    /// Also write the exact depths of each image, as `generate --depth` takes them
    #[arg(long)]
    depth: bool,
    /// Output folder; complete images in it are kept
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// Threads [default: one per core]; the images do not depend on it
    #[arg(long, value_name = "N", default_value_t = 0, hide_default_value = true)]
    threads: usize,
}

/// Makes the image of a split and a number, its longer side that many pixels.
type Synthesize = fn(Split, u64, u32) -> SyntheticImage;

/// Synthesizes the missing images.
pub fn run(arguments: Arguments) -> Result<Exit, Failure> {
    let split = Split::from(arguments.split);
    let (folder, make): (_, Synthesize) = if arguments.close_ups {
        (arguments.out.join("close_ups").join(split.name()), synthesize_close_up)
    } else {
        (arguments.out.join(split.name()), synthesize)
    };
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(arguments.threads)
        .build()
        .map_err(|error| Failure::new(Exit::Error, format!("cannot start threads: {error}")))?;
    let started = Instant::now();
    let (rendered, kept) = (AtomicU64::new(0), AtomicU64::new(0));
    let last = arguments.first.saturating_add(arguments.count);
    pool.install(|| {
        (arguments.first..last).into_par_iter().try_for_each(|number| -> Result<(), Failure> {
            let place = folder.join(format!("{number:06}"));
            if is_whole(&place, number, arguments.size_px, arguments.depth) {
                kept.fetch_add(1, Ordering::Relaxed);
                return Ok(());
            }
            write(&place, &make(split, number, arguments.size_px), arguments.depth)?;
            let done = rendered.fetch_add(1, Ordering::Relaxed) + 1;
            if done.is_multiple_of(REPORTED_EVERY) {
                let each = started.elapsed().as_secs_f64() / done as f64;
                terminal::note(&format!("{done} synthesized, {:.0} ms each", 1e3 * each));
            }
            Ok(())
        })
    })?;
    terminal::note(&format!(
        "{} synthesized, {} kept; {:.0} s; in {}",
        rendered.into_inner(),
        kept.into_inner(),
        started.elapsed().as_secs_f64(),
        folder.display()
    ));
    Ok(Exit::Success)
}

/// Whether the image exists in that size, and its depths if they are wanted.
fn is_whole(place: &Path, number: u64, size_px: u32, with_depth: bool) -> bool {
    if with_depth && !place.join("depth.png").is_file() {
        return false;
    }
    let truth = std::fs::read(place.join("truth.json")).ok();
    let truth = truth.and_then(|bytes| serde_json::from_slice::<ImageTruth>(&bytes).ok());
    truth.is_some_and(|truth| truth.number == number && truth.width_px.max(truth.height_px) == size_px)
}

/// Writes the truth last and atomically: if it exists, all files do.
fn write(place: &Path, sample: &SyntheticImage, with_depth: bool) -> Result<(), Failure> {
    let truth = serde_json::to_vec(&sample.truth)
        .map_err(|error| Failure::new(Exit::Error, format!("the truth has no JSON form: {error}; a bug")))?;
    let depth = || match with_depth {
        true => std::fs::write(place.join("depth.png"), sample.depth.encode_png()),
        false => Ok(()),
    };
    let written = std::fs::create_dir_all(place)
        .and_then(|()| std::fs::write(place.join("image.jpg"), &sample.jpeg))
        .and_then(|()| std::fs::write(place.join("labels.png"), sample.labels.png()))
        .and_then(|()| depth())
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
    fn complete_images_are_kept_and_broken_ones_rewritten() {
        let home = tempfile::tempdir().expect("a folder");
        let place = home.path().join("000005");
        assert!(!is_whole(&place, 5, 96, false));
        let sample = synthesize(Split::Validation, 5, 96);
        write(&place, &sample, false).expect("written");
        assert!(is_whole(&place, 5, 96, false) && !is_whole(&place, 5, 96, true));
        assert!(!is_whole(&place, 5, 128, false) && !is_whole(&place, 6, 96, false));
        write(&place, &sample, true).expect("written");
        let depth = std::fs::read(place.join("depth.png")).expect("depths");
        let depth = imaging::DepthImage::decode_png(&depth, 96 * 96).expect("a depth image");
        assert!(is_whole(&place, 5, 96, true) && depth == sample.depth);
        let image = std::fs::read(place.join("image.jpg")).expect("a picture");
        std::fs::write(place.join("truth.json"), b"{\"split\":").expect("written");
        assert!(!is_whole(&place, 5, 96, false));
        write(&place, &synthesize(Split::Validation, 5, 96), false).expect("written");
        assert_eq!(std::fs::read(place.join("image.jpg")).expect("a picture"), image);
    }
}
