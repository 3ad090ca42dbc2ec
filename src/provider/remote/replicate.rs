//! The mesh generator over Replicate-style predictions: any model there that makes a GLB file from one picture.
//!
//! A prediction is submitted without `Prefer: wait`: the answer, with the vendor's id, comes at once, and is written down
//! before anything else can go wrong. Its URL is not taken from the answer but built from the id, so that the key only
//! ever goes to the base URL. Tables are the embedded generator's: they come as models, not from pictures.

pub mod wire;

use std::sync::Arc;

use serde_json::json;

use super::Endpoint;
use super::endpoint::{Question, Reading};
use super::failure::Failure;
use super::mesh::{self, ReadMesh};
use super::outbound::Reply;
use super::settings::ReplicateSettings;
use super::task::{JobSlots, LongQuestion, Look, Progress, Protocol};
use crate::provider::ledger::MicroUsd;
use crate::provider::{
    Adapter, Answer, Call, MeshGenerator, Port, ProviderError, RawMesh, RawTable, ReconstructionRequest,
};
use crate::scene::RecognizedTable;

/// Name of the adapter.
pub const NAME: &str = "replicate/predictions";

/// Asks a model for meshes.
pub struct ReplicateMeshGenerator {
    pub settings: ReplicateSettings,
    pub endpoint: Arc<Endpoint>,
    pub slots: JobSlots,
    pub read_mesh: ReadMesh,
}

impl ReplicateMeshGenerator {
    async fn mesh(&self, call: &Call, request: ReconstructionRequest) -> Result<RawMesh, ProviderError> {
        let ReplicateSettings { mesh: settings, .. } = &self.settings;
        let hidden = request.completion.completed_share;
        let png = mesh::sent(call, request.completion, settings.picture_px).await?;
        let body =
            wire::prediction(&self.settings, &mesh::data_url(&png), request.seed).map_err(|reason| {
                ProviderError::Misconfigured {
                    port: Port::MeshGenerator,
                    code: "provider_inputs_invalid",
                    reason,
                }
            })?;
        let question = Question {
            operation: "reconstruct",
            path: "/predictions",
            headers: Vec::new(),
            content_type: "application/json".into(),
            body: body.to_string().into(),
            reserved: MicroUsd::of_usd(self.settings.usd_per_prediction),
        };
        let long = LongQuestion {
            endpoint: &self.endpoint,
            slots: &self.slots,
            protocol: self,
            settings: &self.settings.task,
            question: &question,
        };
        mesh::made(call, &long, self.read_mesh.clone(), settings, hidden).await
    }
}

impl MeshGenerator for ReplicateMeshGenerator {
    fn adapter(&self) -> Adapter {
        let ReplicateSettings { base_url, image_input, seed_input, inputs, mesh, .. } = &self.settings;
        let settings = json!({
            "base_url": base_url, "image_input": image_input, "seed_input": seed_input, "inputs": inputs,
            "mesh": mesh,
        });
        Adapter { name: NAME.to_owned(), model: self.settings.version.clone(), settings }
    }

    fn reconstruct<'a>(&'a self, call: &'a Call, request: ReconstructionRequest) -> Answer<'a, RawMesh> {
        Box::pin(self.mesh(call, request))
    }

    fn table<'a>(&'a self, _call: &'a Call, _table: RecognizedTable) -> Answer<'a, RawTable> {
        Box::pin(async { Err(mesh::makes_no_tables(NAME)) })
    }
}

impl Protocol for ReplicateMeshGenerator {
    fn submitted(&self, reply: &Reply) -> Reading<String> {
        wire::submitted(&self.settings, reply)
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
