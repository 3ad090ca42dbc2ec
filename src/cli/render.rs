//! `render`: an image of the scene of a bundle, from a preview's camera and in a preview's light.
//!
//! `high` is the quality of previews, `fast` that of the images of motions, and `reference` the path tracer, which the
//! others are measured by.

use std::path::PathBuf;
use std::time::Instant;

use clap::{Args, ValueEnum};
use serde_json::{Value, json};

use super::bundle_input::BundleInput;
use super::bundle_meshes::bundle_meshes;
use super::counting::Counting;
use super::foreground::computed;
use super::options::ConfigOptions;
use super::output::file;
use super::{Exit, Failure, number, scene_summary, terminal};
use crate::app::activity::staged;
use crate::pipeline::preview::{PreviewBody, Studio, Viewpoint};
use geometry::{Pose, TexturedMesh};
use imaging::Image;
use imaging::codec::encode_png;
use render::{PathTraceSettings, PathTracer, RenderSettings};
use scene::Scene;

/// Largest number of samples: the sequence repeats none before, but hours pass.
const MAX_SAMPLES: u64 = 65_536;

/// Arguments of `render`.
#[derive(Debug, Args)]
pub struct Arguments {
    /// The bundle of the scene: its folder, or its archive
    #[arg(long, visible_alias = "scene", value_name = "DIR_OR_ZIP")]
    bundle: PathBuf,
    /// Write the image to this file, as PNG
    #[arg(long, value_name = "FILE")]
    out: PathBuf,
    /// Replace the file of --out
    #[arg(long)]
    force: bool,
    /// Light and shadows as exact as this
    #[arg(long, value_name = "NAME", default_value = "high")]
    quality: Quality,
    /// Place of the viewer, as in the images of the bundle
    #[arg(long, value_name = "NAME", default_value = "hero")]
    view: ViewName,
    /// Width of the image in pixels
    #[arg(long, value_name = "N", default_value_t = 960, allow_negative_numbers = true, value_parser = number::whole::<u32>(64..=4096))]
    width_px: u32,
    /// Paths of light in each pixel of a reference: four times as many halve the noise [default: 256]
    #[arg(long, value_name = "N", allow_negative_numbers = true, value_parser = number::whole::<u32>(1..=MAX_SAMPLES))]
    samples: Option<u32>,
    /// Print one JSON document, and no progress
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    options: ConfigOptions,
}

/// Renderer with its settings.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Quality {
    /// As in the images of motions: no shadows of the sky, a coarse one of the key light
    Fast,
    /// As in the images of bundles, by the settings of the section render
    High,
    /// By a path tracer: exact but for noise, in minutes
    Reference,
}

/// [`Viewpoint`] as an argument.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum ViewName {
    /// The objects, three quarters from the front
    Hero,
    Front,
    Left,
    Back,
    Right,
    /// Straight from above
    Top,
}

impl ViewName {
    fn viewpoint(self) -> Viewpoint {
        match self {
            Self::Hero => Viewpoint::Hero,
            Self::Front => Viewpoint::Front,
            Self::Left => Viewpoint::Left,
            Self::Back => Viewpoint::Back,
            Self::Right => Viewpoint::Right,
            Self::Top => Viewpoint::Top,
        }
    }
}

/// Samples of a reference where none are given.
const USUAL_SAMPLES: u32 = 256;

/// Subject of the image.
#[derive(Clone, Copy)]
struct Order {
    quality: Quality,
    viewpoint: Viewpoint,
    width_px: u32,
    samples: u32,
    is_quiet: bool,
}

/// A scene with its meshes, the table's first.
struct Contents {
    scene: Scene,
    meshes: Vec<(TexturedMesh, Pose)>,
}

/// Renders and writes the image. With `--json`, failures are printed as a document, too.
pub fn run(arguments: Arguments) -> Result<Exit, Failure> {
    let is_json = arguments.json;
    scene_summary::with_failure_document(rendered(&arguments), is_json)
}

fn rendered(arguments: &Arguments) -> Result<Exit, Failure> {
    let resolved = arguments.options.load(Vec::new())?;
    if arguments.samples.is_some() && arguments.quality != Quality::Reference {
        return Err(Failure::usage("--samples are those of a reference; add --quality reference"));
    }
    file::check(&arguments.out, "--out", arguments.force, &[&arguments.bundle])?;
    let bundle = BundleInput::open(&arguments.bundle)?;
    let order = Order {
        quality: arguments.quality,
        viewpoint: arguments.view.viewpoint(),
        width_px: arguments.width_px,
        samples: arguments.samples.unwrap_or(USUAL_SAMPLES),
        is_quiet: arguments.json || terminal::is_quiet(),
    };
    let high = resolved.config.render.clone();
    let (image, seconds) = computed(arguments.json, move |watch| {
        let contents = staged(watch, "read", None, || contents(&bundle))?;
        let started = Instant::now();
        let image = staged(watch, "render", None, || image(&contents, &order, &high))?;
        Ok((image, started.elapsed().as_secs_f64()))
    })?;
    file::write(&arguments.out, &encode_png(&image), arguments.force)?;
    let (width_px, height_px) = (image.width_px(), image.height_px());
    let place = arguments.out.display();
    if arguments.json {
        let mut document =
            json!({ "image": place.to_string(), "width_px": width_px, "height_px": height_px });
        document["quality"] = json!(name_of(arguments.quality));
        document["view"] = json!(name_of(arguments.view));
        document["samples"] = match arguments.quality {
            Quality::Reference => json!(order.samples),
            Quality::Fast | Quality::High => Value::Null,
        };
        document["seconds"] = json!(seconds);
        terminal::print(&format!("{document:#}\n"));
    } else {
        let quality = name_of(arguments.quality);
        terminal::print(&format!(
            "{place}: {width_px} x {height_px} pixels, {quality} quality, {seconds:.1} s\n"
        ));
    }
    Ok(Exit::Success)
}

/// The word of an argument.
fn name_of(value: impl ValueEnum) -> String {
    value.to_possible_value().map_or_else(String::new, |value| value.get_name().to_owned())
}

fn contents(bundle: &BundleInput) -> Result<Contents, Failure> {
    let scene = bundle.scene()?;
    let meshes = bundle_meshes(bundle, &scene)?;
    Ok(Contents { scene, meshes })
}

fn image(contents: &Contents, order: &Order, high: &RenderSettings) -> Result<Image, Failure> {
    let bodies: Vec<PreviewBody> = contents
        .meshes
        .iter()
        .map(|(mesh, world_from_object)| PreviewBody { mesh, world_from_object: *world_from_object })
        .collect();
    let settings = if order.quality == Quality::High { high } else { &RenderSettings::MOTION };
    let studio = Studio::with_room(&bodies, settings, contents.scene.seed).lit_by(contents.scene.light);
    if order.quality != Quality::Reference {
        // Without a device this is the CPU's work, which does not fail.
        let seen = studio.seen_from(order.viewpoint, order.width_px);
        return seen.map_err(|error| Failure::new(Exit::Error, format!("cannot render the scene: {error}")));
    }
    let (scene, view) = studio.described(order.viewpoint, order.width_px);
    let settings = PathTraceSettings {
        samples_per_pixel: order.samples,
        max_bounces: PathTraceSettings::MANY_BOUNCES,
        seed: contents.scene.seed,
    };
    let counting = Counting::new("tiles rendered", order.is_quiet);
    Ok(PathTracer::new(&scene).image(&view, &settings, |done, all| counting.see(done, all)).color)
}
