//! The picture set: pictures are painted, read and compared side by side, one per core.

use std::sync::Mutex;
use std::time::Instant;

use rayon::prelude::*;

use super::{Arguments, Finished, json_of};
use crate::app::config::Resolved;
use crate::app::evaluation;
use crate::cli::{Exit, Failure, folder, runtime, signals, terminal};
use crate::evaluate::pictures::report::Report;
use crate::evaluate::pictures::sheet::sheet;
use crate::evaluate::pictures::{PictureBench, PictureResult, SET_SIZE};
use crate::export::png::encode_png;
use crate::geometry::{Interrupt, Interrupted};
use crate::synthetic::Split;

pub fn run(arguments: &Arguments, resolved: &Resolved) -> Result<Finished, Failure> {
    if arguments.scene.is_some() {
        return Err(Failure::usage(
            "--scene: pictures have no names; --scenes N takes the first N".to_owned(),
        ));
    }
    let bench = evaluation::picture_bench(resolved, arguments.perfect_maps)?;
    let split = Split::from(arguments.split);
    let count = arguments.scenes.unwrap_or(SET_SIZE);
    let sheets = match &arguments.artifacts {
        Some(folder) => Some(folder::prepare(folder, true)?),
        None => None,
    };
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
    let one = |number: u32| -> Result<PictureResult, Failure> {
        let started = Instant::now();
        let stopped = |_: Interrupted| Failure::new(Exit::Interrupted, "interrupted; no tables were written");
        interrupt.check().map_err(stopped)?;
        let painting = PictureBench::painted(split, u64::from(number));
        let (result, read) = bench.read(&painting, &interrupt).map_err(stopped)?;
        if let Some(folder) = &sheets {
            folder.write(&format!("{number:04}.png"), &encode_png(&sheet(&painting, read.as_ref())))?;
        }
        let mut done = done.lock().unwrap_or_else(|poisoned| poisoned.into_inner());
        *done += 1;
        let seconds = started.elapsed().as_secs_f64();
        terminal::note(&format!("pictures {done}/{count} {number} {seconds:.1} s: {}", told(&result)));
        Ok(result)
    };
    let results: Vec<PictureResult> =
        pool.install(|| (0..count).into_par_iter().map(one).collect::<Result<_, Failure>>())?;
    let report = Report::new(split, SET_SIZE as usize, results);
    Ok(Finished { table: report.markdown(), document: json_of(&report)?, complete: true })
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
