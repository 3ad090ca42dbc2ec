//! The mesh generator over the server that comes with Hunyuan3D-2 and 2.1 (`api_server.py`).
//!
//! Only `/send` and `/status` are used: `/generate` keeps the whole server waiting. The server begins whatever it is sent,
//! all at once, so that jobs are limited here; a job that failed says `processing` for ever, as does one that it does not
//! know, so that only the time limit ends it; and a file may be read while it is written, so that one that cannot be used is
//! fetched again. Nothing can be called off.

pub mod wire;

use std::sync::Arc;

use serde_json::json;

use super::Endpoint;
use super::endpoint::{Question, Reading};
use super::failure::Failure;
use super::mesh::{self, ReadMesh};
use super::outbound::Reply;
use super::settings::Hunyuan3dSettings;
use super::task::{JobSlots, LongQuestion, Look, Progress, Protocol};
use crate::provider::ledger::MicroUsd;
use crate::provider::{
    Adapter, Answer, Call, MeshGenerator, ProviderError, RawMesh, RawTable, ReconstructionRequest,
};
use crate::scene::RecognizedTable;

/// Name of the adapter.
pub const NAME: &str = "hunyuan3d/server";

/// Asks a server of Hunyuan3D.
pub struct Hunyuan3dMeshGenerator {
    pub settings: Hunyuan3dSettings,
    pub endpoint: Arc<Endpoint>,
    pub slots: JobSlots,
    pub read_mesh: ReadMesh,
}

impl Hunyuan3dMeshGenerator {
    async fn mesh(&self, call: &Call, request: ReconstructionRequest) -> Result<RawMesh, ProviderError> {
        let Hunyuan3dSettings { mesh: settings, task, .. } = &self.settings;
        let hidden = request.completion.completed_share;
        let png = mesh::sent(call, request.completion, settings.picture_px).await?;
        let question = Question {
            operation: "reconstruct",
            path: "/send",
            headers: Vec::new(),
            content_type: "application/json".into(),
            body: wire::request(&self.settings, &png, request.seed).to_string().into(),
            reserved: MicroUsd::of_usd(self.settings.usd_per_mesh),
        };
        let long = LongQuestion {
            endpoint: &self.endpoint,
            slots: &self.slots,
            protocol: self,
            settings: task,
            question: &question,
        };
        mesh::made(call, &long, self.read_mesh.clone(), settings, hidden).await
    }
}

impl MeshGenerator for Hunyuan3dMeshGenerator {
    fn adapter(&self) -> Adapter {
        let Hunyuan3dSettings {
            base_url,
            octree_resolution,
            inference_steps,
            guidance_scale,
            texture,
            mesh,
            ..
        } = &self.settings;
        let settings = json!({
            "base_url": base_url, "octree_resolution": octree_resolution, "inference_steps": inference_steps,
            "guidance_scale": guidance_scale, "texture": texture, "mesh": mesh,
        });
        Adapter { name: NAME.to_owned(), model: self.settings.model.clone(), settings }
    }

    fn reconstruct<'a>(&'a self, call: &'a Call, request: ReconstructionRequest) -> Answer<'a, RawMesh> {
        Box::pin(self.mesh(call, request))
    }

    fn table<'a>(&'a self, _call: &'a Call, _table: RecognizedTable) -> Answer<'a, RawTable> {
        Box::pin(async { Err(mesh::makes_no_tables(NAME)) })
    }
}

impl Protocol for Hunyuan3dMeshGenerator {
    fn submitted(&self, reply: &Reply) -> Reading<String> {
        wire::submitted(&self.settings, reply)
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
