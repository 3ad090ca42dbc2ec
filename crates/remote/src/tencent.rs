//! The mesh generator over Tencent Cloud's Hunyuan3D Pro, 3.0 and 3.1.
//!
//! Every request is a POST to the root of the service, signed ([`signature`]); the action stands in a header. A job takes
//! about three minutes, three run at the same time, and its files are kept for a day. Nothing can be called off or seeded.

pub mod signature;
pub mod wire;

use serde_json::json;

use super::endpoint::{Question, Reading};
use super::failure::Failure;
use super::mesh::{MeshVendor, VendorMeshGenerator};
use super::outbound::Reply;
use super::settings::{MeshSettings, TaskSettings, TencentSettings};
use super::task::{Look, Progress, Protocol};
use ports::ledger::MicroUsd;
use ports::{Adapter, ProviderError};

/// Name of the adapter.
pub const NAME: &str = "tencent/hunyuan3d-pro";

/// The header that names the action, which is signed.
pub(super) const ACTION_HEADER: &str = "X-TC-Action";

/// Asks Tencent Cloud for meshes.
pub type TencentMeshGenerator = VendorMeshGenerator<TencentSettings>;

impl TencentSettings {
    /// What is asked of whom; when and by whom, the endpoint adds.
    fn headers(&self, action: &str) -> Vec<(String, String)> {
        let action = (ACTION_HEADER.to_owned(), action.to_owned());
        let mut headers = vec![action, ("X-TC-Version".to_owned(), self.version.clone())];
        if !self.region.is_empty() {
            headers.push(("X-TC-Region".to_owned(), self.region.clone()));
        }
        headers
    }
}

impl MeshVendor for TencentSettings {
    fn adapter(&self) -> Adapter {
        let Self { endpoint, version, face_count, mesh, .. } = self;
        let settings = json!({ "base_url": endpoint.base_url, "version": version, "face_count": face_count, "mesh": mesh });
        Adapter { name: NAME.to_owned(), model: self.model.clone(), settings }
    }

    fn question(&self, png: &[u8], _seed: u64) -> Result<Question, ProviderError> {
        Ok(Question {
            operation: "reconstruct",
            path: "/",
            headers: self.headers(wire::SUBMIT),
            content_type: "application/json".into(),
            body: wire::submission(self, png).to_string().into(),
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

impl Protocol for TencentSettings {
    fn submitted(&self, reply: &Reply) -> Reading<String> {
        wire::submitted(self, reply)
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
