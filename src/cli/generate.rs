//! `generate`: one scene, here and now, by the server's code path.

use std::path::{Path, PathBuf};

use clap::{ArgGroup, Args};

pub use super::local_job::adapt;
use super::local_job::{JobConfig, JobOptions};
use super::options::TextOptions;
use super::{Exit, Failure, certificate, input_file, number, scene_summary, terminal};
use crate::app::App;
use crate::app::config::Config;
use crate::app::submission::SceneOrder;
use crate::app::terms::Terms;
use crate::problem::Problem;
use scene::clutter::Clutter;
use scene::request::RequestOptions;

/// Arguments of `generate`.
#[derive(Debug, Args)]
#[command(group(ArgGroup::new("input").required(true).multiple(true).args(["text", "image"])))]
pub struct Arguments {
    /// Description of the table and the objects on it, in words; beside an image, of its content
    #[arg(long, value_name = "TEXT", allow_hyphen_values = true)]
    text: Option<String>,
    /// An image of a table: PNG, JPEG or WebP
    #[arg(long, value_name = "FILE")]
    image: Option<PathBuf>,
    /// Depths of the image's pixels: a PNG of one 16-bit channel, millimeters, 0 = not measured
    #[arg(long, value_name = "FILE", requires = "image")]
    depth: Option<PathBuf>,
    #[command(flatten)]
    reading: TextOptions,
    /// Drop objects without a stated place onto each other: 0 spreads them over the table, 1 makes one heap
    #[arg(long, value_name = "DENSITY", allow_negative_numbers = true, value_parser = number::share)]
    clutter: Option<f64>,
    #[command(flatten)]
    job: JobOptions,
}

/// Makes the scene, writes its bundle, prints its certificate. With `--json`, failures are printed as a document, too.
pub fn run(arguments: Arguments) -> Result<Exit, Failure> {
    let is_json = arguments.job.json;
    scene_summary::with_failure_document(generate(arguments), is_json)
}

fn generate(mut arguments: Arguments) -> Result<Exit, Failure> {
    let JobConfig { resolved, own } = arguments.job.configure()?;
    let read = |path: &Option<PathBuf>, kind: &FileKind| {
        path.as_deref().map(|path| read_image(path, kind, &resolved.config)).transpose()
    };
    let (image, depth) = (read(&arguments.image, &IMAGE)?, read(&arguments.depth, &DEPTH)?);
    let options = RequestOptions {
        set: own,
        robot: arguments.job.robot.clone(),
        clutter: arguments.clutter.map(|density| Clutter { density }),
        ..arguments.reading.request_options()
    };
    let terms = Terms { seed: arguments.job.seed, options, ..Terms::default() };
    let order = SceneOrder { text: arguments.text, image, depth, terms };
    let submission = App::new(&resolved)
        .check_scene(order)
        .map_err(|problem| refused_input(problem, arguments.image.as_deref(), arguments.depth.as_deref()))?;
    let files = arguments.image.iter().chain(&arguments.depth).map(PathBuf::as_path);
    let place = arguments.job.place(&files.collect::<Vec<_>>())?;
    let made = arguments.job.run(&resolved, submission, place)?;
    match arguments.job.json {
        true => terminal::print(&format!("{:#}\n", made.outcome.document(made.total_ms))),
        false => terminal::print(&certificate::table(&made.outcome, made.total_ms)),
    }
    Ok(made.exit())
}

/// A kind of image file.
struct FileKind {
    name: &'static str,
    advice: &'static str,
}

const IMAGE: FileKind = FileKind { name: "the image", advice: "give a PNG, JPEG or WebP file" };
const DEPTH: FileKind =
    FileKind { name: "the depth image", advice: "give a PNG file with one channel of 16 bits" };

fn read_image(path: &Path, kind: &FileKind, config: &Config) -> Result<bytes::Bytes, Failure> {
    let FileKind { name, advice } = kind;
    let unreadable = |error: std::io::Error| input_file::unreadable(path, name, &error, advice);
    let about = std::fs::metadata(path).map_err(unreadable)?;
    let limit = config.server.max_image_bytes;
    if !about.is_file() {
        return Err(Failure::usage(format!("{name} {} is not a file; {advice}", path.display())));
    }
    if about.len() > limit as u64 {
        return Err(Failure::usage(format!(
            "{name} {} has {} bytes; give one of at most {limit}",
            path.display(),
            about.len()
        )));
    }
    Ok(std::fs::read(path).map_err(unreadable)?.into())
}

/// A refusal that names the file that it is about.
fn refused_input(problem: Problem, image: Option<&Path>, depth: Option<&Path>) -> Failure {
    let about = |option: &'static str, prefix: &str, path: Option<&Path>| {
        path.filter(|_| problem.code.starts_with(prefix)).map(|path| (option, path.to_owned()))
    };
    match about("--image", "image_", image).or(about("--depth", "depth_", depth)) {
        Some((option, path)) => {
            let message = format!("{option} {}: {}", path.display(), problem.detail);
            Failure { message, ..refused(problem, "--text") }
        }
        None => refused(problem, "--text"),
    }
}

/// A refusal in the words of the command line, with the document that the server would answer. `text` is the name of
/// the argument that holds the text.
pub(super) fn refused(problem: Problem, text: &str) -> Failure {
    let mut document = problem.document("");
    if let Some(members) = document.as_object_mut() {
        members.remove("request_id");
    }
    Failure { problem: Some(document), ..Failure::usage(refusal_message(problem, text)) }
}

fn refusal_message(problem: Problem, text: &str) -> String {
    if problem.errors.is_empty() {
        return problem.detail;
    }
    let lines = problem.errors.iter().map(|error| {
        let option = match error.pointer.as_str() {
            "/text" => text.to_owned(),
            "/options/max_objects" => "--max-objects".to_owned(),
            "/options/robot" => "--robot".to_owned(),
            "/options/clutter/density" => "--clutter".to_owned(),
            "" => "input".to_owned(),
            pointer => match pointer.strip_prefix("/options/set/") {
                Some(key) => format!("--set {}", key.replace("~1", "/").replace("~0", "~")),
                None => {
                    let path = pointer.trim_start_matches('/');
                    let (name, rest) = path.split_at(path.find('/').unwrap_or(path.len()));
                    format!("--{}{rest}", name.replace('_', "-"))
                }
            },
        };
        let gap = if error.detail.starts_with(|c: char| c.is_lowercase()) { " " } else { ": " };
        format!("{option}{gap}{}", error.detail)
    });
    lines.collect::<Vec<_>>().join("\n")
}
