//! The mesh generator over Replicate-style predictions: any hosted model that makes a GLB file from one image.
//!
//! A prediction is submitted without `Prefer: wait`: the response with the vendor's id comes at once and is recorded
//! first. Status URLs are built from the id and not taken from the response, so the key is only sent to the base URL.
//! Tables come from the embedded generator: they are catalog models, not reconstructions.

pub mod wire;

use serde_json::json;

use super::endpoint::{Question, Reading};
use super::failure::Failure;
use super::mesh::{MeshVendor, VendorMeshGenerator, data_url};
use super::settings::{MeshSettings, ReplicateSettings, TaskSettings};
use super::vendor_job::{Progress, Protocol, StatusQuery};
use http_client::HttpResponse;
use ports::ledger::MicroUsd;
use ports::{Adapter, Port, ProviderError};

/// Name of the adapter.
pub const NAME: &str = "replicate/predictions";

/// The mesh generator of a hosted model.
pub type ReplicateMeshGenerator = VendorMeshGenerator<ReplicateSettings>;

impl MeshVendor for ReplicateSettings {
    fn adapter(&self) -> Adapter {
        let Self { endpoint, image_input, seed_input, inputs, mesh, .. } = self;
        let settings = json!({
            "base_url": endpoint.base_url, "image_input": image_input, "seed_input": seed_input, "inputs": inputs,
            "mesh": mesh,
        });
        Adapter { name: NAME.to_owned(), model: self.version.clone(), settings }
    }

    fn question(&self, png: &[u8], seed: u64) -> Result<Question, ProviderError> {
        let invalid = |error: wire::InputsError| ProviderError::Misconfigured {
            port: Port::MeshGenerator,
            code: "provider_inputs_invalid",
            reason: error.to_string(),
        };
        let body = wire::prediction(self, &data_url(png), seed).map_err(invalid)?;
        Ok(Question {
            operation: "reconstruct",
            path: "/predictions",
            headers: Vec::new(),
            content_type: "application/json".into(),
            body: body.to_string().into(),
            reserved: MicroUsd::of_usd(self.usd_per_prediction),
        })
    }

    fn mesh(&self) -> &MeshSettings {
        &self.mesh
    }

    fn task(&self) -> &TaskSettings {
        &self.task
    }
}

impl Protocol for ReplicateSettings {
    fn submitted(&self, reply: &HttpResponse) -> Reading<String> {
        wire::submitted(self, reply)
    }

    fn status_query(&self, id: &str) -> StatusQuery {
        StatusQuery::get(format!("/predictions/{id}"))
    }

    fn progress(&self, reply: &HttpResponse) -> Result<Progress, Failure> {
        wire::progress(reply)
    }

    fn cancel_path(&self, id: &str) -> Option<String> {
        Some(format!("/predictions/{id}/cancel"))
    }
}
