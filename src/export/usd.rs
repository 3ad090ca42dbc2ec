//! `usd/`: a stage that references one SimReady-shaped prop per body.
//!
//! `usd/scene.usda` references `usd/assets/<name>/simready_usd/<name>.usda`, with textures in
//! `textures/` and the thumbnail in `.thumbs/256x256/` beside it. Every layer is z up, in meters and
//! kilograms. The text is written here: the format is small, and text opens everywhere.

mod layer;
mod prop;
mod look;
mod stage;

use rayon::prelude::*;

use crate::scene::Scene;

use super::png::encode_png;
use super::{Body, BundleFile, ExportSettings, Pictures};

/// Path of a body's asset below `usd/`.
fn asset_path(name: &str) -> String {
    format!("assets/{name}/simready_usd/{name}.usda")
}

/// The stage, the props, their textures and thumbnails.
pub fn write(
    scene: &Scene,
    bodies: &[Body],
    pictures: &Pictures,
    settings: &ExportSettings,
) -> Vec<BundleFile> {
    let props: Vec<Vec<BundleFile>> =
        bodies.par_iter().map(|body| prop_files(scene, body, pictures, settings)).collect();
    let stage = stage::write_stage(scene, bodies, settings);
    let mut files = vec![BundleFile::text("usd/scene.usda", stage, "usd_stage", "model/vnd.usda")];
    files.extend(props.into_iter().flatten());
    files
}

fn prop_files(scene: &Scene, body: &Body, pictures: &Pictures, settings: &ExportSettings) -> Vec<BundleFile> {
    let folder = format!("usd/assets/{}/simready_usd", body.name);
    let text = prop::write_prop(scene, body, settings);
    let mut files =
        vec![BundleFile::text(format!("usd/{}", asset_path(&body.name)), text, "usd_prop", "model/vnd.usda")];
    for material in &body.visual.materials {
        if let Some(texture) = &material.base_color_texture {
            let path = format!("{folder}/{}", look::texture_path(&body.name, material));
            files.push(BundleFile::png(path, encode_png(texture), "usd_texture"));
        }
    }
    if let Some(thumbnail) = pictures.thumbnails.get(&body.name) {
        let path = format!("{folder}/.thumbs/256x256/{}.usda.png", body.name);
        files.push(BundleFile::png(path, thumbnail.clone(), "usd_thumbnail"));
    }
    files
}
