//! `dataset`: freezes finished scenes as one version of a named dataset, verifies it, prints its statistics.

use std::path::{Path, PathBuf};

use clap::{Args, Subcommand, ValueEnum};
use serde_json::json;

use super::counting::Counting;
use super::output::{self, file};
use super::{Exit, Failure, number, terminal};
use datasets::dataset_manifest::{self, Layout};
use datasets::filter::Filter;
use datasets::freeze::{FreezeRequest, FrozenDataset, Progress, freeze};
use datasets::sharing::LeakageRules;
use datasets::splits::SplitPlan;
use datasets::statistics::{Statistics, page};
use datasets::verify::{Verification, verify};
use datasets::{DatasetError, versions};

/// Arguments of `dataset`.
#[derive(Debug, Args)]
pub struct Arguments {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Write a set of finished scenes as a version of a dataset; the same command goes on after an interruption.
    Freeze(Box<FreezeArguments>),
    /// Read every byte of a dataset again, and report each difference.
    Verify(ReadArguments),
    /// Compute the statistics of a dataset from its scenes.
    Stats(StatsArguments),
}

#[derive(Debug, Args)]
struct FreezeArguments {
    /// Name of the dataset: lower-case letters, digits, - and _
    #[arg(long, value_name = "NAME")]
    name: String,
    /// Bundles: folders, .zip archives, or folders that hold these
    #[arg(long, value_name = "DIR", num_args = 1.., required_unless_present = "output_file")]
    from: Vec<PathBuf>,
    /// output.jsonl of the batch: its bundles, with custom ids, labels and failures
    #[arg(long, value_name = "FILE")]
    output_file: Option<PathBuf>,
    /// Conditions: verdict=pass|quarantine|any, min_objects=N, max_objects=N, category=NAME, not_category=NAME,
    /// label.NAME=VALUE
    #[arg(long, value_name = "KEY=VALUE,...", default_value = "verdict=pass")]
    filter: Filter,
    /// Names and ratios of the splits, or none; a split with a ratio above 0 that would be empty is refused
    #[arg(long, value_name = "NAME=RATIO,...", default_value = "train=0.8,validation=0.1,test=0.1")]
    split: SplitPlan,
    /// Seed of the assignment to splits
    #[arg(long, value_name = "N", default_value_t = 0, allow_negative_numbers = true, value_parser = number::seed)]
    seed: u64,
    /// Parts that scenes of different splits must not share: lineage, text, image, mesh; or none
    #[arg(long, value_name = "KIND,...", default_value = "lineage,text,image,mesh")]
    disjoint: LeakageRules,
    /// Tar shards in WebDataset layout, or one archive per scene
    #[arg(long, value_enum, default_value_t = LayoutName::Shards)]
    layout: LayoutName,
    /// Largest size of a shard, MiB
    #[arg(long, value_name = "N", default_value_t = 256, allow_negative_numbers = true, value_parser = number::whole::<u64>(1..=1 << 20))]
    shard_mb: u64,
    /// Largest number of scenes in a shard [default: no bound]
    #[arg(long, value_name = "N", allow_negative_numbers = true, value_parser = number::whole::<u32>(1..=u64::from(u32::MAX)))]
    shard_scenes: Option<u32>,
    /// Number of the version [default: the next one, or the last if nothing changed]
    #[arg(long, value_name = "N", allow_negative_numbers = true, value_parser = number::whole::<u32>(1..=u64::from(u32::MAX)))]
    number: Option<u32>,
    /// Folder for NAME/vNUMBER/
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// Print one JSON document, and no progress
    #[arg(long)]
    json: bool,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum LayoutName {
    Shards,
    Scenes,
}

#[derive(Debug, Args)]
struct ReadArguments {
    /// Folder of a version, or of the dataset for its last version
    #[arg(value_name = "DIR")]
    dir: PathBuf,
    /// Print one JSON document
    #[arg(long)]
    json: bool,
}

#[derive(Debug, Args)]
struct StatsArguments {
    #[command(flatten)]
    read: ReadArguments,
    /// Also write the page with plots
    #[arg(long, value_name = "FILE")]
    html: Option<PathBuf>,
    /// Replace the file of --html
    #[arg(long, requires = "html")]
    force: bool,
}

/// Runs the subcommand.
pub fn run(arguments: Arguments) -> Result<Exit, Failure> {
    match arguments.command {
        Command::Freeze(arguments) => run_freeze(*arguments),
        Command::Verify(arguments) => run_verify(&arguments),
        Command::Stats(arguments) => run_stats(&arguments),
    }
}

fn run_freeze(arguments: FreezeArguments) -> Result<Exit, Failure> {
    let layout = match arguments.layout {
        LayoutName::Scenes => Layout::Scenes,
        LayoutName::Shards => Layout::Shards {
            max_bytes: arguments.shard_mb << 20,
            max_scenes: arguments.shard_scenes.map(|count| count as usize),
        },
    };
    output::check_parent(&arguments.out.join(&arguments.name))?;
    let request = FreezeRequest {
        name: arguments.name,
        version: arguments.number,
        last_removed: 0,
        sources: arguments.from,
        batch_output: arguments.output_file,
        filter: arguments.filter,
        plan: SplitPlan { seed: arguments.seed, ..arguments.split },
        leakage_rules: arguments.disjoint,
        layout,
        out: arguments.out,
    };
    let is_json = arguments.json;
    let (reading, packing) =
        (Counting::new("bundles read", is_json), Counting::new("scenes packed", is_json));
    let frozen = freeze(&request, &mut |progress| match progress {
        Progress::Read { done, all } => reading.see(done as u64, all as u64),
        Progress::Packed { done, all } => packing.see(done as u64, all as u64),
    });
    let frozen = frozen.map_err(failed)?;
    match is_json {
        true => terminal::print(&format!("{:#}\n", document(&frozen))),
        false => terminal::print(&account(&frozen)),
    }
    Ok(Exit::Success)
}

fn document(frozen: &FrozenDataset) -> serde_json::Value {
    let manifest = &frozen.manifest;
    json!({
        "folder": frozen.folder,
        "name": manifest.name,
        "version": manifest.version,
        "digest": manifest.digest,
        "existed": frozen.existed,
        "kept_containers": frozen.kept,
        "counts": manifest.counts,
        "selection": manifest.selection,
        "changes": manifest.changes,
    })
}

fn account(frozen: &FrozenDataset) -> String {
    let manifest = &frozen.manifest;
    let counts = &manifest.counts;
    let mut text = format!(
        "{} version {}{}: {} scenes with {} objects in {}\n",
        manifest.name,
        manifest.version,
        if frozen.existed { ", unchanged" } else { "" },
        counts.scenes,
        counts.objects,
        frozen.folder.display()
    );
    for split in &manifest.splits.plan.ratios {
        let scenes = counts.splits.get(&split.name).copied().unwrap_or(0);
        let (share, ratio) = (100.0 * scenes as f64 / counts.scenes.max(1) as f64, 100.0 * split.ratio);
        text += &format!("  {}: {scenes} scenes, {share:.1} % ({ratio:.1} % asked for)\n", split.name);
    }
    for sentence in &manifest.splits.statement {
        text += &format!("  {sentence}\n");
    }
    if counts.largest_group * 10 > counts.scenes {
        text += &format!(
            "  The largest group of scenes that share something has {} of {} scenes, so the ratios hold only \
             roughly; --disjoint chooses what counts\n",
            counts.largest_group, counts.scenes
        );
    }
    if let Some(changes) = &manifest.changes {
        text += &format!(
            "  since version {}: {} scenes added, {} removed, {} in another split\n",
            changes.since_version,
            changes.added.len(),
            changes.removed.len(),
            changes.moved.len()
        );
    }
    text + &format!("  digest {}\n", manifest.digest)
}

fn run_verify(arguments: &ReadArguments) -> Result<Exit, Failure> {
    let verification = read(arguments)?;
    let manifest = &verification.manifest;
    let faults: Vec<String> = verification.faults.iter().map(ToString::to_string).collect();
    if arguments.json {
        let document = json!({
            "name": manifest.name,
            "version": manifest.version,
            "digest": manifest.digest,
            "intact": faults.is_empty(),
            "scenes": verification.facts.len(),
            "bytes": verification.bytes,
            "faults": verification.faults.iter().map(|fault| json!({ "path": fault.path, "reason": fault.reason }))
                .collect::<Vec<_>>(),
        });
        terminal::print(&format!("{document:#}\n"));
    } else {
        for fault in &faults {
            terminal::print(&format!("{fault}\n"));
        }
        let verdict = match faults.len() {
            0 => "intact".to_owned(),
            1 => "1 fault".to_owned(),
            count => format!("{count} faults"),
        };
        terminal::print(&format!(
            "{} version {}: {verdict}; {} scenes and {} bytes read, digest {}\n",
            manifest.name,
            manifest.version,
            verification.facts.len(),
            verification.bytes,
            manifest.digest
        ));
    }
    Ok(if faults.is_empty() { Exit::Success } else { Exit::Error })
}

fn run_stats(arguments: &StatsArguments) -> Result<Exit, Failure> {
    if let Some(path) = &arguments.html {
        let version = version_folder(&arguments.read.dir)?;
        file::check(path, "--html", arguments.force, &[&version])?;
    }
    let verification = read(&arguments.read)?;
    if let Some(fault) = verification.faults.first() {
        let message = format!("the dataset is damaged ({fault}); see dataset verify");
        return Err(Failure::new(Exit::Error, message));
    }
    let statistics = verification.statistics();
    let title = format!("{} v{}", verification.manifest.name, verification.manifest.version);
    if let Some(path) = &arguments.html {
        file::write(path, page::write(&title, &statistics).as_bytes(), arguments.force)?;
    }
    match arguments.read.json {
        true => terminal::print(&statistics.json()),
        false => terminal::print(&summary(&title, &statistics)),
    }
    Ok(Exit::Success)
}

fn summary(title: &str, statistics: &Statistics) -> String {
    let mut text = format!(
        "{title}: {} scenes, {} objects of {} categories\n",
        statistics.scenes,
        statistics.objects,
        statistics.categories.len()
    );
    let quantities = [
        ("objects per scene", &statistics.objects_per_scene),
        ("covered share of the table", &statistics.covered_share),
        ("support depth", &statistics.support_depth),
        ("largest extent, m", &statistics.largest_extent_m),
        ("mass, kg", &statistics.mass_kg),
        ("table area, m2", &statistics.table_area_m2),
    ];
    text += &format!("{:28}{:>10}{:>10}{:>10}{:>10}\n", "", "min", "median", "mean", "max");
    for (name, of) in quantities {
        let values = [of.min, of.median, of.mean, of.max];
        let cells = values.map(|value| value.map_or("-".to_owned(), |value| format!("{value:.3}")));
        text += &format!("{name:28}{:>10}{:>10}{:>10}{:>10}\n", cells[0], cells[1], cells[2], cells[3]);
    }
    let frequent = statistics.categories.iter().take(10);
    let names: Vec<String> = frequent.map(|count| format!("{} {}", count.category, count.objects)).collect();
    text += &format!("frequent categories: {}\n", names.join(", "));
    if let Some(share) = statistics.yield_share {
        text += &format!("yield: {:.1} % of {} requests\n", 100.0 * share, statistics.selection.requested);
    }
    text
}

/// Reads a version: the folder itself, or the last version in it.
fn read(arguments: &ReadArguments) -> Result<Verification, Failure> {
    let folder = version_folder(&arguments.dir)?;
    let counting = Counting::new("scenes read", arguments.json);
    let verification = verify(&folder, &mut |done, all| counting.see(done as u64, all as u64));
    verification.map_err(failed)
}

fn version_folder(dir: &Path) -> Result<PathBuf, Failure> {
    if dir.join(dataset_manifest::PATH).is_file() {
        return Ok(dir.to_owned());
    }
    match versions::latest(dir).map_err(failed)? {
        Some((_, folder)) => Ok(folder),
        None => Err(Failure::usage(format!(
            "{} holds no {}; give the folder of a dataset or of one version",
            dir.display(),
            dataset_manifest::PATH
        ))),
    }
}

fn failed(error: DatasetError) -> Failure {
    let exit = match error {
        DatasetError::File { .. } | DatasetError::Packing { .. } => Exit::Error,
        _ => Exit::Usage,
    };
    Failure::new(exit, error.to_string())
}
