//! The certificate as files: `report.json` for programs, `report.html` for people.
//!
//! Both contain the verdict and its reasons, the account of the text, measurements with their thresholds, the result of
//! the round trip, and the provenance of the scene.

mod numbers;
mod image;
mod plan;
mod sections;
mod page;

use serde::Serialize;

use certificate::Certificate;
use scene::Scene;
use scene::edit::EditAccount;
use scene::text_account::TextAccount;

use super::{Body, BundleFile, ExportError, Images};
use crate::round_trip::RoundTripReport;

/// The JSON schema of `report.json`, shipped with every bundle.
pub const REPORT_SCHEMA: &str = include_str!("../../../../schemas/report.schema.json");

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
        #[derive(Serialize)]
        struct Document<'a> {
            format: &'static str,
            scene: &'a str,
            seed: u64,
            #[serde(skip_serializing_if = "Option::is_none")]
            text: Option<&'a TextAccount>,
            #[serde(skip_serializing_if = "Option::is_none")]
            edit: Option<&'a EditAccount>,
            #[serde(flatten)]
            certificate: &'a Certificate,
            parity: &'a RoundTripReport,
        }
        let document = Document {
            format: "tabletopgen-report/1",
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
