//! The image set: images are synthesized, read and compared in parallel, one per core.

use std::sync::Mutex;
use std::time::Instant;

use rayon::prelude::*;

use super::{Arguments, Finished, json_of};
use crate::app::evaluation;
use crate::benchmark::images::comparison_image::comparison_image;
use crate::benchmark::images::regions::RegionsReport;
use crate::benchmark::images::report::Report;
use crate::benchmark::images::text_beside::TextSummary;
use crate::benchmark::images::{ImageBench, ImageResult, SET_SIZE};
use crate::synthetic_images::{Split, SyntheticImage};
use imaging::codec::encode_png;
use runtime::{CancelFlag, Cancelled};
use tabletopgen::app::config::Resolved;
use tabletopgen::cli::output::{Kind, Output};
use tabletopgen::cli::{Exit, Failure, runtime, signals, terminal};

/// Reads the images and compares the estimates.
pub fn run(arguments: &Arguments, resolved: &Resolved) -> Result<Finished, Failure> {
    let sheets = match &arguments.artifacts {
        Some(folder) => Some(Output::check(folder, Kind::Artifacts, true, &[])?.begin()?),
        None => None,
    };
    let results = for_each_image(arguments, resolved, |bench, sample, cancel| {
        let (result, read) = bench.read(sample, cancel).map_err(stopped)?;
        if let Some(folder) = &sheets {
            let name = format!("{:04}.png", sample.truth.number);
            folder.write(&name, &encode_png(&comparison_image(sample, read.as_ref())))?;
        }
        let message = message(&result);
        Ok((result, message))
    })?;
    if let Some(folder) = sheets {
        folder.publish()?;
    }
    let mut report = Report::new(Split::from(arguments.split), SET_SIZE as usize, results);
    report.with_text = arguments.with_text.then(|| TextSummary::new(&report.images));
    Ok(Finished { table: report.markdown(), document: json_of(&report)?, complete: true })
}

/// Evaluates the candidate regions of the instance selection.
pub fn run_regions(arguments: &Arguments, resolved: &Resolved) -> Result<Finished, Failure> {
    let images = for_each_image(arguments, resolved, |bench, sample, cancel| {
        let regions = bench.regions(sample, cancel).map_err(stopped)?;
        let message = format!("{} regions", regions.regions.len());
        Ok((regions, message))
    })?;
    let report = RegionsReport::new(Split::from(arguments.split), images);
    Ok(Finished { table: report.markdown(), document: json_of(&report)?, complete: true })
}

fn stopped(_: Cancelled) -> Failure {
    Failure::new(Exit::Interrupted, "interrupted; no tables were written")
}

/// Synthesizes images and runs `work` on each, one per core; results are in order. `work` also returns a one-line
/// summary.
fn for_each_image<T: Send>(
    arguments: &Arguments,
    resolved: &Resolved,
    work: impl Fn(&ImageBench, &SyntheticImage, &CancelFlag) -> Result<(T, String), Failure> + Sync,
) -> Result<Vec<T>, Failure> {
    if arguments.scene.is_some() {
        return Err(Failure::usage("--scene: images have no names; --scenes N takes the first N".to_owned()));
    }
    let Arguments { perfect_maps, with_text, .. } = *arguments;
    let bench = evaluation::image_bench(resolved, perfect_maps, with_text, arguments.beside())?;
    let split = Split::from(arguments.split);
    let count = arguments.scenes.unwrap_or(SET_SIZE);
    let cancel = CancelFlag::default();
    let runtime = runtime()?;
    let stop = runtime.block_on(async { signals::stop_on_signal("stopping; again to stop at once") })?;
    let raised = cancel.clone();
    runtime.spawn(async move {
        stop.cancelled().await;
        raised.cancel();
    });
    let pool =
        rayon::ThreadPoolBuilder::new().num_threads(resolved.config.worker.cpu_threads).build().map_err(
            |error| Failure::new(Exit::Error, format!("cannot start threads to compute with: {error}")),
        )?;
    let done = Mutex::new(0_u32);
    let one = |number: u32| -> Result<T, Failure> {
        let started = Instant::now();
        cancel.check().map_err(stopped)?;
        let sample = ImageBench::image(split, u64::from(number));
        let (result, message) = work(&bench, &sample, &cancel)?;
        let mut done = done.lock().unwrap_or_else(|poisoned| poisoned.into_inner());
        *done += 1;
        let seconds = started.elapsed().as_secs_f64();
        terminal::note(&format!("images {done}/{count} {number} {seconds:.1} s: {message}"));
        Ok(result)
    };
    pool.install(|| (0..count).into_par_iter().map(one).collect())
}

/// Scores of an image in one line.
fn message(result: &ImageResult) -> String {
    let score = &result.score;
    match &result.refused {
        Some(code) => format!("refused as {code}, {} objects", score.expected),
        None => format!(
            "{} of {} objects detected, {} false positives, outline {:.2}",
            score.detected, score.expected, score.false_positives, score.outline_iou
        ),
    }
}
