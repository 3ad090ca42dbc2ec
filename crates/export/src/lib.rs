//! Formats: a finished scene becomes bytes. Pure: the same scene gives the same bytes on any day.
//!
//! [`write_formats`] checks the scene once ([`body`]), writes every format from the same values, reads
//! the files back with independent little readers ([`parity`]) and refuses to hand out a bundle in which
//! a format tells another mass, pose or hull than the scene. [`zip_bundle`] packs.

pub mod settings;
pub mod assets;
pub mod body;
pub mod surface;
pub mod number;
pub mod xml;
pub mod wavefront;
pub mod usd;
pub mod urdf;
pub mod mjcf;
pub mod sdf;
pub mod glb;
pub mod parity;
pub mod report;
pub mod manifest;
pub mod readme;
pub mod archive;
#[cfg(test)]
mod specimen;
#[cfg(test)]
mod planted_faults;
#[cfg(test)]
mod labels_survive;

pub use archive::zip_bundle;
pub use assets::{Assets, BodyAsset, BundleFile, Pictures};
pub use body::{Body, BodyFault};
pub use settings::{ExportSettings, UsdForm};

use rayon::prelude::*;

use self::wavefront::Wavefront;
use scene::{Certificate, Scene};

/// The JSON schema of `scene.json`, shipped with every bundle.
pub const SCENE_SCHEMA: &str = include_str!("../../../schemas/scene.schema.json");

/// Why a scene was not written.
#[derive(Debug, thiserror::Error)]
pub enum ExportError {
    #[error("the assets do not match the scene: {0}")]
    AssetsMismatch(String),
    #[error("the body {body} cannot be written: {fault}")]
    UnusableBody { body: String, fault: BodyFault },
    #[error("the name {0:?} is used twice or reserved for a file of the bundle")]
    NameTaken(String),
    #[error("{format} was written but tells another scene when it is read back: {difference}")]
    Parity { format: &'static str, difference: String },
    #[error("{format} was written but could not be read back: {reason}")]
    Unreadable { format: &'static str, reason: String },
    #[error("the archive or the USD package could not be packed")]
    Archive(#[from] zip::result::ZipError),
    #[error("a JSON file of the bundle could not be written")]
    Json(#[from] serde_json::Error),
}

impl ExportError {
    /// A word that stays the same when sentences change.
    pub fn code(&self) -> &'static str {
        match self {
            Self::UnusableBody { fault, .. } => fault.code(),
            Self::Parity { .. } | Self::Unreadable { .. } => "formats_disagree",
            _ => "export_failed",
        }
    }
}

/// Every file of the bundle, sorted by path. Fails if the assets are not the scene's, or if a format,
/// read back, differs from the scene.
pub fn write_formats(
    scene: &Scene,
    certificate: &Certificate,
    assets: &Assets,
    pictures: &Pictures,
    settings: &ExportSettings,
) -> Result<Vec<BundleFile>, ExportError> {
    let bodies = body::bodies(scene, assets)?;
    let mut files = vec![
        BundleFile::json("scene.json", &scene, "scene")?,
        BundleFile::text("scene.schema.json", SCENE_SCHEMA.to_owned(), "schema", "application/schema+json"),
    ];
    files.extend(pictures.files());
    let wavefronts: Vec<Wavefront> = bodies.par_iter().map(Wavefront::of).collect();
    // Formats are independent of one another, so they are written side by side, in a fixed order.
    let ((usd, urdf), (mjcf, (sdf, glb))) = rayon::join(
        || {
            rayon::join(
                || usd::write(scene, &bodies, pictures, settings),
                || urdf::write(&bodies, &wavefronts),
            )
        },
        || {
            rayon::join(
                || mjcf::write(scene, &bodies, &wavefronts, settings),
                || rayon::join(|| sdf::write(scene, &bodies, &wavefronts, settings), || glb::write(&bodies)),
            )
        },
    );
    files.extend(usd?.into_iter().chain(urdf).chain(mjcf).chain(sdf).chain(glb));
    let parity = parity::read_back(&bodies, &files)?;
    let report = report::Report { scene, bodies: &bodies, certificate, parity: &parity, pictures };
    files.extend([report.json()?, report.page()]);
    files.push(BundleFile::text(
        "report.schema.json",
        report::REPORT_SCHEMA.to_owned(),
        "schema",
        "application/schema+json",
    ));
    files.push(readme::write(scene, &bodies, settings.usd));
    files.sort_by(|a, b| a.path.cmp(&b.path));
    let manifest = manifest::write(scene, assets, &files, settings)?;
    files.push(manifest);
    files.sort_by(|a, b| a.path.cmp(&b.path));
    Ok(files)
}
