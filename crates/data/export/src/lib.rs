//! Writes a finished scene as USD, URDF, MJCF, SDF, GLB, reports and a manifest. Equal scenes give equal bytes.
//!
//! [`write_formats`] validates the bodies once ([`body`]) and writes every format from the same values. It then reads
//! the files with independent readers ([`round_trip`]) and fails if a format holds another mass, pose or hull than the
//! scene. [`zip_bundle`] packs the files.
//!
//! The crate must not depend on the pipeline, the store, providers or simulators, and it reads no clock and no file.
//!
//! ```
//! use export::{BundleFile, zip_bundle};
//!
//! let notes = BundleFile::text("notes.txt", "hello".to_owned(), "notes", "text/plain");
//! let scene = BundleFile::json("scene.json", &serde_json::json!({ "id": "0a1b" }), "scene")?;
//! let archive = zip_bundle(&[scene, notes])?;
//! assert!(archive.starts_with(b"PK"));
//! # Ok::<(), export::ExportError>(())
//! ```

pub mod settings;
pub mod assets;
pub mod body;
pub mod surface;
pub mod number;
pub mod wavefront;
pub mod usd;
mod sun;
pub mod urdf;
mod ros_package;
pub mod mjcf;
pub mod sdf;
pub mod glb;
pub mod round_trip;
pub mod report;
pub mod manifest;
pub mod readme;
pub mod archive;
#[cfg(test)]
mod tests;

pub use archive::zip_bundle;
pub use assets::{Assets, BodyAsset, BundleFile, Images};
pub use body::{Body, BodyFault};
pub use settings::{ExportSettings, UrdfPaths, UsdForm};

use rayon::prelude::*;

use self::round_trip::{Difference, ReadError};
use self::wavefront::Wavefront;
use certificate::Certificate;
use scene::Scene;
use scene::json_schema::{FileSchema, file_schema};

/// The JSON schema of `scene.json`, shipped with every bundle.
pub const SCENE_SCHEMA: &str = include_str!("../../../../schemas/scene.schema.json");

/// The schema of `scene.json`, which `scene.schema.json` holds.
///
/// # Errors
///
/// If a part of the schema has no JSON form.
pub fn scene_schema() -> Result<String, serde_json::Error> {
    file_schema::<Scene>(&FileSchema {
        id: "https://tabletopgen.invalid/schemas/scene-1.schema.json",
        title: "Tabletop scene",
        description: "The one value every format of a bundle is written from. Right-handed, z up, meters, kilograms, \
                      seconds, radians; the world's origin is the center of the table top. Poses map the object's \
                      frame to the world.",
        adjust: None,
    })
}

/// The reason why a scene was not written.
#[derive(Debug, thiserror::Error)]
pub enum ExportError {
    #[error("the assets do not match the scene: {0}")]
    AssetsMismatch(String),
    #[error("the body {body} cannot be written: {fault}")]
    UnusableBody { body: String, fault: BodyFault },
    #[error("the name {0:?} is used twice or reserved for a file of the bundle")]
    NameTaken(String),
    #[error("{format} was written but tells another scene when it is read back: {difference}")]
    RoundTripMismatch { format: &'static str, difference: Box<Difference> },
    #[error("{format} was written but could not be read back: {reason}")]
    Unreadable { format: &'static str, reason: Box<ReadError> },
    #[error("the archive or the USD package could not be packed")]
    Archive(#[from] zip::result::ZipError),
    #[error("a JSON file of the bundle could not be written")]
    Json(#[from] serde_json::Error),
}

impl ExportError {
    pub(crate) fn unreadable(format: &'static str, reason: ReadError) -> Self {
        Self::Unreadable { format, reason: Box::new(reason) }
    }

    pub(crate) fn mismatch(format: &'static str, difference: Difference) -> Self {
        Self::RoundTripMismatch { format, difference: Box::new(difference) }
    }

    /// Stable error code for programs.
    pub fn code(&self) -> &'static str {
        match self {
            Self::UnusableBody { fault, .. } => fault.code(),
            Self::RoundTripMismatch { .. } | Self::Unreadable { .. } => "formats_disagree",
            _ => "export_failed",
        }
    }
}

/// Writes every file of the bundle, sorted by path; `more` are files that the caller wrote.
///
/// # Errors
///
/// [`ExportError::AssetsMismatch`] if the assets do not belong to the scene, [`ExportError::UnusableBody`] or
/// [`ExportError::NameTaken`] if a body cannot be written, [`ExportError::RoundTripMismatch`] or
/// [`ExportError::Unreadable`] if a written format differs from the scene when it is read.
pub fn write_formats(
    scene: &Scene,
    certificate: &Certificate,
    assets: &Assets,
    images: &Images,
    more: Vec<BundleFile>,
    settings: &ExportSettings,
) -> Result<Vec<BundleFile>, ExportError> {
    let bodies = body::bodies(scene, assets)?;
    let mut files = vec![
        BundleFile::json("scene.json", &scene, "scene")?,
        BundleFile::text("scene.schema.json", SCENE_SCHEMA.to_owned(), "schema", "application/schema+json"),
    ];
    files.extend(images.files());
    files.extend(more);
    let wavefronts: Vec<Wavefront> = bodies.par_iter().map(Wavefront::of).collect();
    // The formats are independent, so they are written in parallel; their order in the bundle is fixed.
    let ((usd, urdf), (mjcf, (sdf, glb))) = rayon::join(
        || {
            rayon::join(
                || usd::write(scene, &bodies, images, settings),
                || urdf::write(scene, &bodies, &wavefronts, settings),
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
    let round_trip = round_trip::read_back(&bodies, &files)?;
    let report = report::Report { scene, bodies: &bodies, certificate, round_trip: &round_trip, images };
    files.extend([report.json()?, report.page()]);
    files.push(BundleFile::text(
        "report.schema.json",
        report::REPORT_SCHEMA.to_owned(),
        "schema",
        "application/schema+json",
    ));
    files.push(readme::write(scene, &bodies, settings));
    files.sort_by(|a, b| a.path.cmp(&b.path));
    let manifest = manifest::write(scene, assets, &files, settings)?;
    files.push(manifest);
    files.sort_by(|a, b| a.path.cmp(&b.path));
    Ok(files)
}
