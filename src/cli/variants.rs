//! `variants`: several new scenes from a bundle, by operations that seeds draw, by the server's code path.

use std::path::{Path, PathBuf};

use clap::Args;
use serde_json::{Value, json};

use super::bundle_input::BundleInput;
use super::edit::lines;
use super::generate::refused;
use super::local_job::{JobConfig, JobOptions};
use super::output::{Kind, Output};
use super::scene_summary::Place;
use super::{Exit, Failure, certificate, number, scene_summary, terminal};
use crate::app::App;
use crate::app::edit_scene::ParentBundle;
use crate::app::submission::Submission;
use crate::app::terms::Terms;
use crate::app::variants::VariantsOrder;
use scene::edit::EditAccount;
use scene::request::RequestOptions;
use scene::variant::MAX_VARIANTS;
use scene::{Randomize, Scene};
use store::Digest;

/// Arguments of `variants`.
#[derive(Debug, Args)]
pub struct Arguments {
    /// The bundle of the scene: its folder, or its archive
    #[arg(long, value_name = "DIR_OR_ZIP")]
    bundle: PathBuf,
    /// Number of variants
    #[arg(long, value_name = "N", default_value_t = 10, allow_negative_numbers = true, value_parser = number::whole::<u32>(1..=u64::from(MAX_VARIANTS)))]
    count: u32,
    /// Differences between variants: layout, meshes, sizes, colors, materials, table, light, camera, mass, friction
    /// [default: all]
    #[arg(long, value_name = "AXES", value_delimiter = ',', value_parser = axis)]
    vary: Vec<Randomize>,
    #[command(flatten)]
    job: JobOptions,
}

/// A name that is no axis of variants.
#[derive(Debug, thiserror::Error)]
#[error("is none of {}", Randomize::AXES.join(", "))]
struct UnknownAxis;

fn axis(name: &str) -> Result<Randomize, UnknownAxis> {
    Randomize::only(name.trim()).ok_or(UnknownAxis)
}

/// Makes the variants one after the other, each in its folder. A variant that is there already is left as it is, so the
/// same command goes on where it stopped. With `--json`, failures are printed as a document, too.
pub fn run(arguments: Arguments) -> Result<Exit, Failure> {
    let is_json = arguments.job.json;
    scene_summary::with_failure_document(make(arguments), is_json)
}

fn make(mut arguments: Arguments) -> Result<Exit, Failure> {
    let JobConfig { resolved, own } = arguments.job.configure()?;
    let bundle = BundleInput::open(&arguments.bundle)?;
    let id = bundle.scene()?.id;
    let archive = bundle.into_archive()?;
    let parent = ParentBundle { id, digest: Digest::of(&archive) };
    let options =
        RequestOptions { set: own, robot: arguments.job.robot.clone(), ..RequestOptions::default() };
    let terms = Terms { seed: arguments.job.seed, options, ..Terms::default() };
    let randomize = arguments.vary.iter().copied().reduce(Randomize::and);
    let order = VariantsOrder { count: arguments.count, randomize, terms };
    let made =
        App::new(&resolved).check_variants(order, &parent).map_err(|problem| refused(problem, "--vary"))?;
    let out = arguments.job.out.clone().unwrap_or_else(|| PathBuf::from("out/variants"));
    if !arguments.job.json {
        terminal::note(&format!(
            "{} variants by seed {}, in {}",
            made.submissions.len(),
            made.seed,
            out.display()
        ));
    }
    let archive = bytes::Bytes::from(archive);
    let (mut documents, mut exit) = (Vec::new(), Exit::Success);
    // All folders are checked before the first variant is made.
    let planned = made.submissions.into_iter().enumerate().map(|(index, submission)| {
        let folder = out.join(format!("variant_{:04}", index + 1));
        let output = output_for(&folder, &submission, arguments.job.force, &arguments.bundle)?;
        Ok((folder, output, submission))
    });
    for (folder, output, submission) in planned.collect::<Result<Vec<_>, Failure>>()? {
        let Some(output) = output else {
            terminal::note(&format!("{} is there already", folder.display()));
            continue;
        };
        let submission = Submission { bundle: Some(archive.clone()), ..submission };
        let job = match arguments.job.run(&resolved, submission, Place::Named(output)) {
            Ok(job) => job,
            // The others may still succeed.
            Err(failure) if failure.exit == Exit::JobFailed => {
                terminal::complain(&format!("{}: {failure}", folder.display()));
                documents.push(json!({ "folder": folder, "failure": failure.to_string() }));
                exit = Exit::JobFailed;
                continue;
            }
            Err(failure) => return Err(failure),
        };
        if exit == Exit::Success {
            exit = job.exit();
        }
        if arguments.job.json {
            documents.push(job.outcome.document(job.total_ms));
        } else {
            terminal::print(&certificate::table(&job.outcome, job.total_ms));
            let account = serde_json::from_value::<EditAccount>(job.outcome.summary["edit"].clone());
            terminal::print(&account.map(|account| lines(&account)).unwrap_or_default());
        }
    }
    if arguments.job.json {
        terminal::print(&format!("{:#}\n", Value::Array(documents)));
    }
    Ok(exit)
}

/// Output of a variant; `None` if its folder holds it already.
///
/// # Errors
///
/// A [`Failure`] where the folder holds another scene and is not forced, or must not be written.
fn output_for(
    folder: &Path,
    submission: &Submission,
    is_forced: bool,
    bundle: &Path,
) -> Result<Option<Output>, Failure> {
    if let Ok(document) = std::fs::read(folder.join("scene.json")) {
        let scene: Option<Scene> = serde_json::from_slice(&document).ok();
        let asked = &submission.request;
        let is_asked = |scene: Scene| scene.request.input == asked.input && scene.request.seed == asked.seed;
        match scene.is_some_and(is_asked) {
            true => return Ok(None),
            false if is_forced => {}
            false => {
                return Err(Failure::usage(format!(
                    "{} holds another scene; choose another --out, give the --seed of the variants that are there, \
                     or add --force to replace it",
                    folder.display()
                )));
            }
        }
    }
    Output::check(folder, Kind::Bundle, is_forced, &[bundle]).map(Some)
}
