//! The picture set: pictures are painted, read and compared side by side, one per core.

use std::sync::Mutex;
use std::time::Instant;

use rayon::prelude::*;

use super::{Arguments, Finished, json_of};
use crate::app::evaluation;
use crate::evaluate::pictures::regions::RegionsReport;
use crate::evaluate::pictures::report::Report;
use crate::evaluate::pictures::sheet::sheet;
use crate::evaluate::pictures::{PictureBench, PictureResult, SET_SIZE};
use crate::synthetic::{Painting, Split};
use imaging::codec::encode_png;
use runtime::{Interrupt, Interrupted};
use tabletopgen::app::config::Resolved;
use tabletopgen::cli::{Exit, Failure, folder, runtime, signals, terminal};

/// Reads the pictures and compares what was read.
pub fn run(arguments: &Arguments, resolved: &Resolved) -> Result<Finished, Failure> {
    let sheets = match &arguments.artifacts {
        Some(folder) => Some(folder::prepare(folder, true)?),
        None => None,
    };
    let results = side_by_side(arguments, resolved, |bench, painting, interrupt| {
        let (result, read) = bench.read(painting, interrupt).map_err(stopped)?;
        if let Some(folder) = &sheets {
            let name = format!("{:04}.png", painting.truth.number);
            folder.write(&name, &encode_png(&sheet(painting, read.as_ref())))?;
        }
        let told = told(&result);
        Ok((result, told))
    })?;
    let report = Report::new(Split::from(arguments.split), SET_SIZE as usize, results);
    Ok(Finished { table: report.markdown(), document: json_of(&report)?, complete: true })
}

/// Judges the regions that things are chosen from.
pub fn run_regions(arguments: &Arguments, resolved: &Resolved) -> Result<Finished, Failure> {
    let pictures = side_by_side(arguments, resolved, |bench, painting, interrupt| {
        let regions = bench.regions(painting, interrupt).map_err(stopped)?.ok_or_else(|| {
            Failure::usage(
                "no network reads pictures, so there are no regions; name its weights in [network]"
                    .to_owned(),
            )
        })?;
        let told = format!("{} regions", regions.regions.len());
        Ok((regions, told))
    })?;
    let report = RegionsReport::new(Split::from(arguments.split), pictures);
    Ok(Finished { table: report.markdown(), document: json_of(&report)?, complete: true })
}

fn stopped(_: Interrupted) -> Failure {
    Failure::new(Exit::Interrupted, "interrupted; no tables were written")
}

/// Paints pictures and does something with each, one per core; the results in order. What is done says what it found on
/// one line.
fn side_by_side<T: Send>(
    arguments: &Arguments,
    resolved: &Resolved,
    work: impl Fn(&PictureBench, &Painting, &Interrupt) -> Result<(T, String), Failure> + Sync,
) -> Result<Vec<T>, Failure> {
    if arguments.scene.is_some() {
        return Err(Failure::usage(
            "--scene: pictures have no names; --scenes N takes the first N".to_owned(),
        ));
    }
    let bench = evaluation::picture_bench(resolved, arguments.perfect_maps)?;
    let split = Split::from(arguments.split);
    let count = arguments.scenes.unwrap_or(SET_SIZE);
    let interrupt = Interrupt::default();
    let runtime = runtime()?;
    let stop = runtime.block_on(async { signals::stop_on_signal("stopping; again to stop at once") })?;
    let raised = interrupt.clone();
    runtime.spawn(async move {
        stop.cancelled().await;
        raised.raise();
    });
    let pool =
        rayon::ThreadPoolBuilder::new().num_threads(resolved.config.worker.cpu_threads).build().map_err(
            |error| Failure::new(Exit::Error, format!("cannot start threads to compute with: {error}")),
        )?;
    let done = Mutex::new(0_u32);
    let one = |number: u32| -> Result<T, Failure> {
        let started = Instant::now();
        interrupt.check().map_err(stopped)?;
        let painting = PictureBench::painted(split, u64::from(number));
        let (result, told) = work(&bench, &painting, &interrupt)?;
        let mut done = done.lock().unwrap_or_else(|poisoned| poisoned.into_inner());
        *done += 1;
        let seconds = started.elapsed().as_secs_f64();
        terminal::note(&format!("pictures {done}/{count} {number} {seconds:.1} s: {told}"));
        Ok(result)
    };
    pool.install(|| (0..count).into_par_iter().map(one).collect())
}

/// A picture's scores on one line.
fn told(result: &PictureResult) -> String {
    let score = &result.score;
    match &result.refused {
        Some(code) => format!("refused as {code}, {} things", score.painted),
        None => format!(
            "{} of {} things found, {} invented, outline {:.2}",
            score.found, score.painted, score.invented, score.outline_iou
        ),
    }
}
