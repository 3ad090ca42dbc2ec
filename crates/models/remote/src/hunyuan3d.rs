//! The mesh generator over the server of Hunyuan3D-2 and 2.1 (`api_server.py`).
//!
//! Only `/send` and `/status` are used: `/generate` blocks the whole server. The server starts every job at once, so
//! the adapter limits concurrent jobs. A failed or unknown job reports `processing` forever, so only the deadline
//! ends it. A file may be read while it is written, so an unusable file is downloaded again. Jobs cannot be
//! cancelled.

pub mod wire;

use serde_json::json;

use super::endpoint::{Question, Reading};
use super::failure::Failure;
use super::mesh::{MeshVendor, VendorMeshGenerator};
use super::settings::{Hunyuan3dSettings, MeshSettings, TaskSettings};
use super::vendor_job::{Progress, Protocol, StatusQuery};
use http_client::HttpResponse;
use ports::ledger::MicroUsd;
use ports::{Adapter, ProviderError};

/// Name of the adapter.
pub const NAME: &str = "hunyuan3d/server";

/// The mesh generator of a Hunyuan3D server.
pub type Hunyuan3dMeshGenerator = VendorMeshGenerator<Hunyuan3dSettings>;

impl MeshVendor for Hunyuan3dSettings {
    fn adapter(&self) -> Adapter {
        let Self { endpoint, octree_resolution, inference_steps, guidance_scale, texture, mesh, .. } = self;
        let settings = json!({
            "base_url": endpoint.base_url, "octree_resolution": octree_resolution, "inference_steps": inference_steps,
            "guidance_scale": guidance_scale, "texture": texture, "mesh": mesh,
        });
        Adapter { name: NAME.to_owned(), model: self.model.clone(), settings }
    }

    fn question(&self, png: &[u8], seed: u64) -> Result<Question, ProviderError> {
        Ok(Question {
            operation: "reconstruct",
            path: "/send",
            headers: Vec::new(),
            content_type: "application/json".into(),
            body: wire::request(self, png, seed).to_string().into(),
            reserved: MicroUsd::of_usd(self.usd_per_mesh),
        })
    }

    fn mesh(&self) -> &MeshSettings {
        &self.mesh
    }

    fn task(&self) -> &TaskSettings {
        &self.task
    }
}

impl Protocol for Hunyuan3dSettings {
    fn submitted(&self, reply: &HttpResponse) -> Reading<String> {
        wire::submitted(self, reply)
    }

    fn status_query(&self, id: &str) -> StatusQuery {
        StatusQuery::get(format!("/status/{id}"))
    }

    fn progress(&self, reply: &HttpResponse) -> Result<Progress, Failure> {
        wire::progress(reply)
    }

    fn cancel_path(&self, _id: &str) -> Option<String> {
        None
    }
}
