//! `diff`: what differs between the scenes of two bundles.

mod appearance;
mod compare;
mod lines;
mod pixels;

use std::collections::BTreeMap;
use std::path::PathBuf;

use clap::Args;
use serde_json::json;

use super::bundle_input::BundleInput;
use super::output::file;
use super::{Exit, Failure, terminal};
use compare::{Appearance, SceneContents, compare};
use imaging::Image;
use imaging::codec::{decode_png, encode_png};
use mesh_io::gltf::read_mesh_glb;

/// Arguments of `diff`.
#[derive(Debug, Args)]
#[command(after_help = "The exit code is 0 for equal scenes, 1 for different ones, and 2 for a failure.")]
pub struct Arguments {
    /// The first bundle: its folder, or its archive
    #[arg(value_name = "A")]
    before: PathBuf,
    /// The second bundle
    #[arg(value_name = "B")]
    after: PathBuf,
    /// Print one JSON document instead of lines
    #[arg(long)]
    json: bool,
    /// Write both top views and the difference of their pixels as one PNG
    #[arg(long, value_name = "FILE")]
    image: Option<PathBuf>,
    /// Replace the file of --image
    #[arg(long, requires = "image")]
    force: bool,
}

/// Prints the differences. Any failure has the exit code 2, since 1 says that the scenes differ.
pub fn run(arguments: Arguments) -> Result<Exit, Failure> {
    diff(&arguments).map_err(|failure| Failure { exit: Exit::Usage, ..failure })
}

fn diff(arguments: &Arguments) -> Result<Exit, Failure> {
    if let Some(path) = &arguments.image {
        file::check(path, "--image", arguments.force, &[&arguments.before, &arguments.after])?;
    }
    let (before, after) = (BundleInput::open(&arguments.before)?, BundleInput::open(&arguments.after)?);
    let [old, new] = [contents(&before, &after)?, contents(&after, &before)?];
    let difference = compare(&old, &new);
    if let Some(path) = &arguments.image {
        let image = pixels::comparison(&top_view(&before)?, &top_view(&after)?);
        file::write(path, &encode_png(&image), arguments.force)?;
    }
    if arguments.json {
        let mut document = json!({ "equal": difference.is_empty(), "a": old.scene.id, "b": new.scene.id });
        document["difference"] = json!(difference);
        terminal::print(&format!("{document:#}\n"));
    } else {
        terminal::print(&lines::lines(&difference));
    }
    Ok(if difference.is_empty() { Exit::Success } else { Exit::Different })
}

/// The scene of a bundle. A mesh that `other` has under the same name is not read: it shows the same.
fn contents(bundle: &BundleInput, other: &BundleInput) -> Result<SceneContents, Failure> {
    let scene = bundle.scene()?;
    let objects = scene.instances.iter().map(|object| (object.name.to_string(), object.mesh.as_str()));
    let mut appearances = BTreeMap::new();
    for (name, mesh) in objects.chain([(scene.table.name.clone(), scene.table.mesh.as_str())]) {
        if bundle.entry(mesh).is_some() && bundle.entry(mesh) == other.entry(mesh) {
            continue;
        }
        let read = read_mesh_glb(&bundle.file(mesh)?);
        let read = read.map_err(|error| Failure::usage(format!("cannot read the mesh {mesh}: {error}")))?;
        appearances.insert(name, Appearance::of(&read));
    }
    Ok(SceneContents { scene, appearances })
}

fn top_view(bundle: &BundleInput) -> Result<Image, Failure> {
    let name = "preview/top.png";
    decode_png(&bundle.file(name)?)
        .map_err(|error| Failure::usage(format!("cannot read the image {name}: {error}")))
}
