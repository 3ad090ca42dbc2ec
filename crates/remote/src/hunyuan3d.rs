//! The mesh generator over the server that comes with Hunyuan3D-2 and 2.1 (`api_server.py`).
//!
//! Only `/send` and `/status` are used: `/generate` keeps the whole server waiting. The server begins whatever it is sent,
//! all at once, so that jobs are limited here; a job that failed says `processing` for ever, as does one that it does not
//! know, so that only the time limit ends it; and a file may be read while it is written, so that one that cannot be used is
//! fetched again. Nothing can be called off.

pub mod wire;

use serde_json::json;

use super::endpoint::{Question, Reading};
use super::failure::Failure;
use super::mesh::{MeshVendor, VendorMeshGenerator};
use super::outbound::Reply;
use super::settings::{Hunyuan3dSettings, MeshSettings, TaskSettings};
use super::task::{Look, Progress, Protocol};
use ports::ledger::MicroUsd;
use ports::{Adapter, ProviderError};

/// Name of the adapter.
pub const NAME: &str = "hunyuan3d/server";

/// Asks a server of Hunyuan3D.
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
    fn submitted(&self, reply: &Reply) -> Reading<String> {
        wire::submitted(self, reply)
    }

    fn look(&self, id: &str) -> Look {
        Look::at(format!("/status/{id}"))
    }

    fn progress(&self, reply: &Reply) -> Result<Progress, Failure> {
        wire::progress(reply)
    }

    fn call_off(&self, _id: &str) -> Option<String> {
        None
    }
}
