//! The certificate as files: `report.json` for programs, `report.html` for people.
//!
//! Both tell the same: verdict and reasons, what was measured beside what it is compared with, what reading
//! the formats back showed, and what the scene was made with.

mod html;
mod numbers;
mod picture;
mod plan;
mod sections;
mod page;

use serde::Serialize;

use scene::{Certificate, Scene};

use super::parity::ParityReport;
use super::{Body, BundleFile, ExportError, Pictures};

/// The JSON schema of `report.json`, shipped with every bundle.
pub const REPORT_SCHEMA: &str = include_str!("../../../schemas/report.schema.json");

/// Everything that is told about a scene. Bodies are in the order of the certificate's, the table first.
pub struct Report<'a> {
    pub scene: &'a Scene,
    pub bodies: &'a [Body],
    pub certificate: &'a Certificate,
    pub parity: &'a ParityReport,
    pub pictures: &'a Pictures,
}

impl Report<'_> {
    /// `report.json`.
    pub fn json(&self) -> Result<BundleFile, ExportError> {
        #[derive(Serialize)]
        struct Document<'a> {
            format: &'static str,
            scene: &'a str,
            seed: u64,
            #[serde(flatten)]
            certificate: &'a Certificate,
            parity: &'a ParityReport,
        }
        let document = Document {
            format: "tabletopgen-report/1",
            scene: &self.scene.id,
            seed: self.scene.seed,
            certificate: self.certificate,
            parity: self.parity,
        };
        BundleFile::json("report.json", &document, "report")
    }

    /// `report.html`.
    pub fn page(&self) -> BundleFile {
        BundleFile::text("report.html", page::write(self), "report_page", "text/html")
    }
}
