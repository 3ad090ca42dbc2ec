//! `usd/`: a stage that references one SimReady-shaped prop per body.
//!
//! The stage references `assets/<name>/simready_usd/<name>.usd[ac]`. Beside that file lie textures in `textures/`, the
//! thumbnail in `.thumbs/256x256/` and the layers of single simulators in `runnables/physics/`. Every layer is z up, in
//! meters and kilograms. A layer is built once as a value ([`layer`]) and written as text or in the crate format. A
//! package (`.usdz`) holds the same files without the thumbnails.

mod value;
mod layer;
mod prim_names;
mod prop;
mod material;
mod nonvisual_material;
mod simulator_schemas;
mod stage;
mod text_file;
mod crate_file;
mod package;
#[cfg(test)]
pub(super) mod random_layer;

use rayon::prelude::*;

use imaging::GreenAxis;
use scene::Scene;

use super::settings::UsdForm;
use super::{Body, BundleFile, ExportError, ExportSettings, Images};
use layer::Layer;
use simulator_schemas::Simulator;

/// Path of the stage in the bundle.
pub fn stage_path(form: UsdForm) -> &'static str {
    match form {
        UsdForm::Usda | UsdForm::Usdc => "usd/scene.usda",
        UsdForm::Usdz => "usd/scene.usdz",
    }
}

/// Path of the prop of the body `name` in the bundle; inside a package in USD's notation `package[path]`.
pub fn prop_path(form: UsdForm, name: &str) -> String {
    let below = path_below_stage(form, name);
    match form {
        UsdForm::Usda | UsdForm::Usdc => format!("usd/{below}"),
        UsdForm::Usdz => format!("usd/scene.usdz[{below}]"),
    }
}

fn path_below_stage(form: UsdForm, name: &str) -> String {
    let ending = match form {
        UsdForm::Usda => "usda",
        UsdForm::Usdc | UsdForm::Usdz => "usdc",
    };
    format!("assets/{name}/simready_usd/{name}.{ending}")
}

/// The stage, the props, their textures and thumbnails.
pub fn write(
    scene: &Scene,
    bodies: &[Body],
    images: &Images,
    settings: &ExportSettings,
) -> Result<Vec<BundleFile>, ExportError> {
    let stage =
        stage::stage(scene, bodies, settings, |name| format!("./{}", path_below_stage(settings.usd, name)));
    let props: Vec<Vec<BundleFile>> =
        bodies.par_iter().map(|body| prop_files(scene, body, images, settings)).collect();
    let props = props.into_iter().flatten();
    if settings.usd != UsdForm::Usdz {
        let stage = text_layer(stage_path(settings.usd).to_owned(), &stage, "usd_stage");
        return Ok(std::iter::once(stage).chain(props).collect());
    }
    let mut packed = vec![("scene.usdc".to_owned(), crate_file::write(&stage))];
    let is_wanted = |file: &BundleFile| file.role != THUMBNAIL;
    packed.extend(props.filter(is_wanted).map(|file| (file.path.replacen("usd/", "", 1), file.bytes)));
    let package = package::write(&packed)?;
    Ok(vec![BundleFile::new(stage_path(settings.usd), package, "usd_stage", "model/vnd.usdz+zip")])
}

const THUMBNAIL: &str = "usd_thumbnail";

/// The layer of a body with its simulator layers, textures and thumbnail.
fn prop_files(scene: &Scene, body: &Body, images: &Images, settings: &ExportSettings) -> Vec<BundleFile> {
    let path = format!("usd/{}", path_below_stage(settings.usd, &body.name));
    let (folder, file_name) = path.rsplit_once('/').expect("a prop lies in a folder");
    let layer = prop::prop(scene, body, settings);
    let mut files = vec![match settings.usd {
        UsdForm::Usda => text_layer(path.clone(), &layer, "usd_prop"),
        // No media type is registered for it.
        UsdForm::Usdc | UsdForm::Usdz => {
            BundleFile::new(path.clone(), crate_file::write(&layer), "usd_prop", "application/octet-stream")
        }
    }];
    for simulator in Simulator::ALL {
        let path = format!("{folder}/{}", simulator.path());
        files.push(text_layer(path, &simulator_schemas::layer(body, simulator), "usd_runtime"));
    }
    for material in &body.visual.materials {
        if let Some(texture) = &material.base_color_texture {
            let path = format!("{folder}/{}", material::texture_path(&body.name, material));
            files.push(BundleFile::png(path, texture.png().to_vec(), "usd_texture"));
        }
        if let Some(normals) = material.normal_map(GreenAxis::Up) {
            let path = format!("{folder}/{}", material::normals_path(&body.name, material));
            files.push(BundleFile::png(path, normals.png().to_vec(), "usd_texture"));
        }
    }
    if let Some(thumbnail) = images.thumbnails.get(&body.name) {
        let path = format!("{folder}/.thumbs/256x256/{file_name}.png");
        files.push(BundleFile::png(path, thumbnail.clone(), THUMBNAIL));
    }
    files
}

fn text_layer(path: String, layer: &Layer, role: &str) -> BundleFile {
    BundleFile::text(path, text_file::write(layer), role, "model/vnd.usda")
}
