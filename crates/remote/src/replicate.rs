//! The mesh generator over Replicate-style predictions: any model there that makes a GLB file from one picture.
//!
//! A prediction is submitted without `Prefer: wait`: the answer, with the vendor's id, comes at once, and is written down
//! before anything else can go wrong. Its URL is not taken from the answer but built from the id, so that the key only
//! ever goes to the base URL. Tables are the embedded generator's: they come as models, not from pictures.

pub mod wire;

use serde_json::json;

use super::endpoint::{Question, Reading};
use super::failure::Failure;
use super::mesh::{MeshVendor, VendorMeshGenerator, data_url};
use super::outbound::Reply;
use super::settings::{MeshSettings, ReplicateSettings, TaskSettings};
use super::task::{Look, Progress, Protocol};
use ports::ledger::MicroUsd;
use ports::{Adapter, Port, ProviderError};

/// Name of the adapter.
pub const NAME: &str = "replicate/predictions";

/// Asks a model for meshes.
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
        let invalid = |reason| ProviderError::Misconfigured {
            port: Port::MeshGenerator,
            code: "provider_inputs_invalid",
            reason,
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
    fn submitted(&self, reply: &Reply) -> Reading<String> {
        wire::submitted(self, reply)
    }

    fn look(&self, id: &str) -> Look {
        Look::at(format!("/predictions/{id}"))
    }

    fn progress(&self, reply: &Reply) -> Result<Progress, Failure> {
        wire::progress(reply)
    }

    fn call_off(&self, id: &str) -> Option<String> {
        Some(format!("/predictions/{id}/cancel"))
    }
}
