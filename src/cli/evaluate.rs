//! `evaluate`: the paper's measures of finished scenes against the images that they were made from.
//!
//! A manifest lists bundles with their reference images. Each is rendered from the 160 places of the camera sweep and
//! compared with its image by LPIPS, DINOv2 and CLIP, as far as their weights are there; collisions and stability are
//! those of the certificates.

use std::collections::BTreeSet;
use std::io;
use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum};
use serde::Deserialize;

use super::bundle_input::BundleInput;
use super::bundle_meshes::bundle_meshes;
use super::counting::Counting;
use super::foreground::computed;
use super::output::file;
use super::{Exit, Failure, input_file, scene_summary, terminal};
use crate::app::activity::staged;
use certificate::Certificate;
use evaluation::{
    EvaluationTable, Metric, MetricMeans, PerceptualModels, ScenePhysics, SceneRow, SceneScores, Sweep,
    SweepRenderer, SweptScene, UsedWeights, WeightsFile, score_views,
};
use export::manifest;
use imaging::Image;
use imaging::codec::decode_oriented_image;
use runtime::CancelFlag;
use vision::lpips::LpipsNetwork;

/// Arguments of `evaluate`.
#[derive(Debug, Args)]
pub struct Arguments {
    /// Scenes to evaluate: {"scenes": [{"name": "desk", "bundle": "out/desk", "image": "desk.jpg"}]}; `image` is the
    /// one that the scene was made from, and may be absent. Paths are relative to the file
    #[arg(value_name = "FILE")]
    manifest: PathBuf,
    /// Write the table to this file, as JSON
    #[arg(long, value_name = "FILE")]
    out: PathBuf,
    /// Also write it as CSV
    #[arg(long, value_name = "FILE")]
    csv: Option<PathBuf>,
    /// Also write it as a page
    #[arg(long, value_name = "FILE")]
    html: Option<PathBuf>,
    /// Folder of the weights of LPIPS, DINOv2 and CLIP, as docs/models.md describes; a metric without weights has no
    /// number
    #[arg(long, value_name = "DIR")]
    weights: Option<PathBuf>,
    /// Network of LPIPS
    #[arg(long, value_name = "NAME", default_value = "alex")]
    lpips: LpipsName,
    /// Replace the files of --out, --csv and --html
    #[arg(long)]
    force: bool,
    /// Print the table as JSON, and no progress
    #[arg(long)]
    json: bool,
}

/// [`LpipsNetwork`] as an argument.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum LpipsName {
    /// AlexNet, the usual one for comparing images
    Alex,
    /// VGG16
    Vgg,
}

impl LpipsName {
    fn network(self) -> LpipsNetwork {
        match self {
            Self::Alex => LpipsNetwork::AlexNet,
            Self::Vgg => LpipsNetwork::Vgg16,
        }
    }
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Manifest {
    scenes: Vec<Entry>,
}

/// One scene of the manifest.
#[derive(Clone, Deserialize)]
#[serde(deny_unknown_fields)]
struct Entry {
    name: String,
    /// Folder or archive.
    bundle: PathBuf,
    /// The image that the scene was made from.
    #[serde(default)]
    image: Option<PathBuf>,
}

/// Largest reference image, pixels.
const MAX_PIXELS: u64 = 50_000_000;

/// Evaluates and writes the table. With `--json`, failures are printed as a document, too.
pub fn run(arguments: Arguments) -> Result<Exit, Failure> {
    let is_json = arguments.json;
    scene_summary::with_failure_document(evaluated(&arguments), is_json)
}

fn evaluated(arguments: &Arguments) -> Result<Exit, Failure> {
    let outputs = [
        ("--out", Some(&arguments.out)),
        ("--csv", arguments.csv.as_ref()),
        ("--html", arguments.html.as_ref()),
    ];
    for (option, path) in outputs {
        if let Some(path) = path {
            file::check(path, option, arguments.force, &[&arguments.manifest])?;
        }
    }
    let entries = entries(&arguments.manifest)?;
    let network = arguments.lpips.network();
    let (models, weights) = models(arguments.weights.as_deref(), network)?;
    let counting = Counting::new("scenes evaluated", arguments.json || terminal::is_quiet());
    let rows = computed(arguments.json, move |watch| {
        let all = entries.len() as u64;
        let row = |(done, entry): (usize, &Entry)| {
            let row = staged(watch, "evaluate", Some(&entry.name), || row(entry, &models))?;
            counting.see(done as u64 + 1, all);
            Ok(row)
        };
        entries.iter().enumerate().map(row).collect::<Result<Vec<SceneRow>, Failure>>()
    })?;
    let table = EvaluationTable::new(rows, network, weights);
    let document = serde_json::to_vec_pretty(&table)
        .map_err(|error| Failure::new(Exit::Error, format!("cannot write the table as JSON: {error}")))?;
    file::write(&arguments.out, &document, arguments.force)?;
    if let Some(path) = &arguments.csv {
        file::write(path, table.csv().as_bytes(), arguments.force)?;
    }
    if let Some(path) = &arguments.html {
        file::write(path, table.html().as_bytes(), arguments.force)?;
    }
    if arguments.json {
        terminal::print(&format!("{}\n", String::from_utf8_lossy(&document)));
    } else {
        terminal::print(&summary(&table));
    }
    Ok(Exit::Success)
}

/// The scenes of a manifest, with paths from where the command runs.
fn entries(path: &Path) -> Result<Vec<Entry>, Failure> {
    const ADVICE: &str =
        r#"give a file such as {"scenes": [{"name": "desk", "bundle": "out/desk", "image": "desk.jpg"}]}"#;
    let manifest: Manifest = input_file::json(path, "the list of scenes", ADVICE)?;
    let place = path.display();
    let mut names = BTreeSet::new();
    if let Some(twice) = manifest.scenes.iter().find(|entry| !names.insert(entry.name.as_str())) {
        return Err(Failure::usage(format!(
            "{place} has two scenes {:?}; give each a name of its own",
            twice.name
        )));
    }
    if manifest.scenes.is_empty() {
        return Err(Failure::usage(format!("{place} lists no scene; {ADVICE}")));
    }
    let folder = path.parent().unwrap_or(Path::new("."));
    let placed = |entry: &Entry| Entry {
        name: entry.name.clone(),
        bundle: folder.join(&entry.bundle),
        image: entry.image.as_ref().map(|image| folder.join(image)),
    };
    Ok(manifest.scenes.iter().map(placed).collect())
}

/// The models whose weights are in the folder, and these files.
fn models(
    folder: Option<&Path>,
    network: LpipsNetwork,
) -> Result<(PerceptualModels, Vec<UsedWeights>), Failure> {
    let mut used = Vec::new();
    let bytes_of = |file: WeightsFile| {
        let folder = folder.ok_or(io::ErrorKind::NotFound)?;
        let bytes = std::fs::read(folder.join(file.path()))?;
        let sha256 = manifest::entry_of(&bytes, "application/octet-stream").sha256;
        used.push(UsedWeights { file: file.path().to_owned(), sha256 });
        Ok(bytes)
    };
    let models =
        PerceptualModels::read(network, bytes_of).map_err(|error| Failure::usage(error.to_string()))?;
    Ok((models, used))
}

fn row(entry: &Entry, models: &PerceptualModels) -> Result<SceneRow, Failure> {
    let bundle = BundleInput::open(&entry.bundle)?;
    let certificate: Certificate = serde_json::from_slice(&bundle.file("report.json")?).map_err(|error| {
        let place = entry.bundle.display();
        Failure::usage(format!(
            "report.json of the bundle {place} is no certificate of this version: {error}"
        ))
    })?;
    let scores = entry.image.as_ref().map(|image| scores(entry, image, &bundle, models)).transpose()?;
    Ok(SceneRow { scene: entry.name.clone(), scores, physics: ScenePhysics::of(&certificate) })
}

fn scores(
    entry: &Entry,
    image: &Path,
    bundle: &BundleInput,
    models: &PerceptualModels,
) -> Result<SceneScores, Failure> {
    let reference = reference_image(image)?;
    let failed = |error: String| Failure::usage(format!("cannot evaluate the scene {}: {error}", entry.name));
    let meshes = bundle_meshes(bundle, &bundle.scene()?)?;
    let scene = SweptScene::of(&meshes).ok_or_else(|| failed("it has no table".to_owned()))?;
    let sweep = Sweep::around(&scene).map_err(|error| failed(error.to_string()))?;
    let renderer = SweepRenderer::new(&scene, sweep, Sweep::size_px(&reference));
    score_views(models, &reference, |view| renderer.image(view), &CancelFlag::default())
        .map_err(|error| failed(error.to_string()))
}

fn reference_image(path: &Path) -> Result<Image, Failure> {
    const ADVICE: &str = "give the image that the scene was made from, as PNG, JPEG or WebP";
    let bytes = std::fs::read(path)
        .map_err(|error| input_file::unreadable(path, "the reference image", &error, ADVICE))?;
    decode_oriented_image(&bytes, MAX_PIXELS).map_err(|error| {
        Failure::usage(format!("cannot read the reference image {}: {error}; {ADVICE}", path.display()))
    })
}

/// Means over scenes, a line each; for a metric without weights the missing file.
fn summary(table: &EvaluationTable) -> String {
    let mut text = String::new();
    let missing = table.missing();
    for metric in Metric::ALL {
        let title = metric.title();
        let file = missing.iter().find(|(other, _)| *other == metric).map(|(_, file)| file);
        text += &match (table.means.of(metric), file) {
            (Some(MetricMeans { scenes, best, mean }), _) => {
                format!("{title:<7} best view {best:.4}, mean of views {mean:.4}, {scenes} scenes\n")
            }
            (None, Some(file)) => format!("{title:<7} no number: {file} is not in the folder of --weights\n"),
            (None, None) => format!("{title:<7} no number: no scene has a reference image\n"),
        };
    }
    if let Some(rates) = &table.means.physics {
        let [col_o, col_s, ss, dss] =
            [rates.col_o, rates.col_s, rates.ss, rates.dss_shipped].map(|rate| 100.0 * rate);
        text += &format!(
            "Col_O {col_o:.2} %, Col_S {col_s:.1} %, SS {ss:.1} %, DSS {dss:.1} %, {} scenes\n",
            rates.scenes
        );
    }
    text
}
