//! `regenerate-episode`: an episode of a dataset made again from its record.

use std::path::{Path, PathBuf};

use clap::Args;
use serde_json::json;

use super::bundle_input::BundleInput;
use super::foreground::computed;
use super::generate::refused;
use super::options::ConfigOptions;
use super::output::{Kind, Output};
use super::{Exit, Failure, input_file, number, scene_summary, terminal};
use crate::app::activity::staged;
use crate::app::episodes::card;
use crate::app::episodes::regenerate::{RecordedEpisode, recorded_episode, regenerate, setup_of};
use crate::config::Resolved;
use demonstrations::Setup;
use episodes::{DatasetAssembler, EpisodeError, EpisodeUnit};

/// Arguments of `regenerate-episode`.
#[derive(Debug, Args)]
#[command(
    after_help = "The exit code is 6 if the episode is not the same to the byte, as with another version of the \
                        program."
)]
pub struct Arguments {
    /// The dataset: a folder with records.jsonl, or one that has it in its folders
    #[arg(long, value_name = "DIR")]
    dataset: PathBuf,
    /// Number of the episode in the dataset, from 0
    #[arg(long, value_name = "INDEX", allow_negative_numbers = true, value_parser = number::whole::<u64>(0..=u64::MAX))]
    episode: u64,
    /// The bundle in which it was recorded: its folder, or its archive
    #[arg(long, visible_alias = "scene", value_name = "DIR_OR_ZIP")]
    bundle: PathBuf,
    /// Folder for a dataset of this episode alone
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Replace the dataset that an earlier run left in the folder of --out; a folder with other files is refused
    #[arg(long, requires = "out")]
    force: bool,
    /// Print one JSON document
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    options: ConfigOptions,
}

const DATASET_ADVICE: &str = "give the folder that `episodes --out` wrote";

/// Makes the episode again and compares it with the digest in its record.
pub fn run(arguments: Arguments) -> Result<Exit, Failure> {
    let is_json = arguments.json;
    scene_summary::with_failure_document(again(&arguments), is_json)
}

fn again(arguments: &Arguments) -> Result<Exit, Failure> {
    let resolved = arguments.options.load(Vec::new())?;
    let inputs: [&Path; 2] = [&arguments.bundle, &arguments.dataset];
    let check = |out: &PathBuf| Output::check(out, Kind::Episodes, arguments.force, &inputs);
    let output = arguments.out.as_ref().map(check).transpose()?;
    let records = records_of(&arguments.dataset)?;
    let text = input_file::text(&records, "the records", DATASET_ADVICE)?;
    let episode = recorded_episode(&text, arguments.episode)
        .map_err(|error| Failure::usage(format!("{} {error}", records.display())))?;
    let archive = BundleInput::open(&arguments.bundle)?.into_archive()?;
    let (of_setup, config) = (episode.clone(), resolved.clone());
    let (setup, made) = computed(arguments.json, move |watch| {
        let setup = staged(watch, "prepare", None, || setup_of(&archive, &of_setup, &config));
        let setup = setup.map_err(|problem| refused(problem, "--dataset"))?;
        let made = staged(watch, "episode", None, || regenerate(&setup, &of_setup));
        let made = made.map_err(|error| Failure::new(Exit::Error, error.to_string()))?;
        Ok((setup, made.map_err(|error| Failure::new(Exit::TaskFailed, error.to_string()))?))
    })?;
    if let Some(output) = &output {
        write(&setup, &resolved, output, &made.unit)?;
    }
    let (digest, frames) = (made.unit.digest(), made.unit.frames());
    if arguments.json {
        let document = json!({
            "episode": episode.episode_index,
            "number": episode.number,
            "frames": frames,
            "recorded_digest": episode.digest,
            "digest": digest,
            "same": made.is_same,
        });
        terminal::print(&format!("{document:#}\n"));
    } else {
        terminal::print(&summary(&episode, frames, made.is_same));
    }
    Ok(if made.is_same { Exit::Success } else { Exit::TaskFailed })
}

fn summary(episode: &RecordedEpisode, frames: usize, is_same: bool) -> String {
    let verdict = match is_same {
        true => "the same as recorded, to the byte".to_owned(),
        false => format!(
            "not the same as recorded; it was recorded by version {}, this is {}",
            episode.record.version,
            env!("CARGO_PKG_VERSION")
        ),
    };
    format!("episode {}, {frames} frames: {verdict}\n", episode.episode_index)
}

/// Writes a dataset of one episode.
fn write(setup: &Setup, resolved: &Resolved, output: &Output, unit: &EpisodeUnit) -> Result<(), Failure> {
    const DATASET: &str = "dataset";
    let title = output.path().file_name().unwrap_or_default().to_string_lossy().into_owned();
    let card = card(title, resolved, setup);
    let partial = output.begin()?;
    let written = || -> Result<(), EpisodeError> {
        let (folder, description) = (partial.inside(DATASET), setup.description().clone());
        let mut dataset = DatasetAssembler::create(&folder, description, setup.formats(), card)?;
        dataset.add(unit)?;
        dataset.finish()?;
        Ok(())
    };
    written().map_err(|error| Failure::new(Exit::Error, error.to_string()))?;
    partial.publish_inside(DATASET)
}

/// The records of a dataset, which each of its formats has.
fn records_of(dataset: &Path) -> Result<PathBuf, Failure> {
    const NAME: &str = "records.jsonl";
    let inside = std::fs::read_dir(dataset)
        .map_err(|error| input_file::unreadable(dataset, "the dataset", &error, DATASET_ADVICE))?;
    let mut formats: Vec<PathBuf> = inside.flatten().map(|entry| entry.path().join(NAME)).collect();
    formats.sort();
    let places = std::iter::once(dataset.join(NAME)).chain(formats);
    places.into_iter().find(|path| path.is_file()).ok_or_else(|| {
        Failure::usage(format!(
            "{} is no dataset: neither it nor a folder in it has {NAME}; {DATASET_ADVICE}",
            dataset.display()
        ))
    })
}
