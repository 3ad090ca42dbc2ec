//! The mesh generator over Tencent Cloud's Hunyuan3D Pro, 3.0 and 3.1.
//!
//! Every request is a POST to the root of the service, signed ([`signature`]); the action stands in a header. A job takes
//! about three minutes, three run at the same time, and its files are kept for a day. Nothing can be called off or seeded.

pub mod signature;
pub mod wire;

use std::sync::Arc;

use serde_json::{Value, json};

use super::Endpoint;
use super::endpoint::{Question, Reading};
use super::failure::Failure;
use super::mesh::{self, ReadMesh};
use super::outbound::Reply;
use super::settings::TencentSettings;
use super::task::{JobSlots, LongQuestion, Look, Progress, Protocol};
use crate::provider::ledger::MicroUsd;
use crate::provider::{
    Adapter, Answer, Call, MeshGenerator, ProviderError, RawMesh, RawTable, ReconstructionRequest,
};
use crate::scene::RecognizedTable;

/// Name of the adapter.
pub const NAME: &str = "tencent/hunyuan3d-pro";

/// Asks Tencent Cloud for meshes.
pub struct TencentMeshGenerator {
    pub settings: TencentSettings,
    pub endpoint: Arc<Endpoint>,
    pub slots: JobSlots,
    pub read_mesh: ReadMesh,
}

impl TencentMeshGenerator {
    async fn mesh(&self, call: &Call, request: ReconstructionRequest) -> Result<RawMesh, ProviderError> {
        let TencentSettings { mesh: settings, task, .. } = &self.settings;
        let hidden = request.completion.completed_share;
        let png = mesh::sent(call, request.completion, settings.picture_px).await?;
        let question = Question {
            operation: "reconstruct",
            path: "/",
            headers: self.headers(wire::SUBMIT),
            content_type: "application/json".into(),
            body: wire::submission(&self.settings, &png).to_string().into(),
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

    /// What is asked of whom; when and by whom, the endpoint adds.
    fn headers(&self, action: &str) -> Vec<(String, String)> {
        let TencentSettings { version, region, .. } = &self.settings;
        let mut headers =
            vec![(ACTION_HEADER.to_owned(), action.to_owned()), ("X-TC-Version".to_owned(), version.clone())];
        if !region.is_empty() {
            headers.push(("X-TC-Region".to_owned(), region.clone()));
        }
        headers
    }
}

/// The header that names the action, which is signed.
pub(super) const ACTION_HEADER: &str = "X-TC-Action";

impl MeshGenerator for TencentMeshGenerator {
    fn adapter(&self) -> Adapter {
        let TencentSettings { base_url, version, face_count, mesh, .. } = &self.settings;
        let settings: Value =
            json!({ "base_url": base_url, "version": version, "face_count": face_count, "mesh": mesh });
        Adapter { name: NAME.to_owned(), model: self.settings.model.clone(), settings }
    }

    fn reconstruct<'a>(&'a self, call: &'a Call, request: ReconstructionRequest) -> Answer<'a, RawMesh> {
        Box::pin(self.mesh(call, request))
    }

    fn table<'a>(&'a self, _call: &'a Call, _table: RecognizedTable) -> Answer<'a, RawTable> {
        Box::pin(async { Err(mesh::makes_no_tables(NAME)) })
    }
}

impl Protocol for TencentMeshGenerator {
    fn submitted(&self, reply: &Reply) -> Reading<String> {
        wire::submitted(&self.settings, reply)
    }

    fn look(&self, id: &str) -> Look {
        Look::asking("/", self.headers(wire::QUERY), &wire::query(id))
    }

    fn progress(&self, reply: &Reply) -> Result<Progress, Failure> {
        wire::progress(reply)
    }

    fn call_off(&self, _id: &str) -> Option<String> {
        None
    }
}
