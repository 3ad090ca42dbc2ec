//! The certificate as files: `report.json` for programs, `report.html` for people.
//!
//! Both contain the verdict and its reasons, the account of the text, measurements with their thresholds, the result of
//! the round trip, and the provenance of the scene.

mod numbers;
mod image;
mod plan;
mod sections;
mod page;

use schemars::JsonSchema;
use serde::Serialize;

use certificate::Certificate;
use scene::Scene;
use scene::edit::EditAccount;
use scene::json_schema::{FileSchema, file_schema};
use scene::request::MAX_SEED;
use scene::text_account::TextAccount;

use super::{Body, BundleFile, ExportError, Images};
use crate::round_trip::RoundTripReport;

/// The JSON schema of `report.json`, shipped with every bundle.
pub const REPORT_SCHEMA: &str = include_str!("../../../../schemas/report.schema.json");

/// Content of `report.json`.
#[derive(Serialize, JsonSchema)]
struct Document<'a> {
    #[schemars(extend("const" = FORMAT))]
    format: &'static str,
    /// Id of the scene.
    #[schemars(length(min = 1))]
    scene: &'a str,
    #[schemars(range(min = 0, max = MAX_SEED))]
    seed: u64,
    /// Absent for scenes of images.
    #[serde(skip_serializing_if = "Option::is_none")]
    text: Option<&'a TextAccount>,
    /// Absent for scenes that are no edit.
    #[serde(skip_serializing_if = "Option::is_none")]
    edit: Option<&'a EditAccount>,
    #[serde(flatten)]
    certificate: &'a Certificate,
    parity: &'a RoundTripReport,
}

/// The name of the format and its version.
const FORMAT: &str = "tabletopgen-report/1";

/// The schema of `report.json`, which `report.schema.json` holds.
///
/// # Errors
///
/// If a part of the schema has no JSON form.
pub fn schema() -> Result<String, serde_json::Error> {
    file_schema::<Document<'_>>(&FileSchema {
        id: "https://tabletopgen.invalid/schemas/report-1.schema.json",
        title: "Certificate of a tabletop scene",
        description: "Measurements of a scene, the limits they are compared with, and the verdict. Meters, kilograms, \
                      seconds, radians; rates are fractions. report.html shows the same to people.",
        adjust: None,
    })
}

/// Input of the report. Bodies are in the order of the certificate's, the table first.
pub struct Report<'a> {
    pub scene: &'a Scene,
    pub bodies: &'a [Body],
    pub certificate: &'a Certificate,
    pub round_trip: &'a RoundTripReport,
    pub images: &'a Images,
}

impl Report<'_> {
    /// `report.json`.
    pub fn json(&self) -> Result<BundleFile, ExportError> {
        let document = Document {
            format: FORMAT,
            scene: &self.scene.id,
            seed: self.scene.seed,
            text: self.scene.text.as_ref(),
            edit: self.scene.edit.as_ref(),
            certificate: self.certificate,
            parity: self.round_trip,
        };
        BundleFile::json("report.json", &document, "report")
    }

    /// `report.html`.
    pub fn page(&self) -> BundleFile {
        BundleFile::text("report.html", page::write(self), "report_page", "text/html")
    }
}
