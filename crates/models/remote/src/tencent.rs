//! The mesh generator over Tencent Cloud's Hunyuan3D Pro, 3.0 and 3.1.
//!
//! Every request is a signed POST to the root of the service ([`signature`]); a header holds the action. A job takes
//! about three minutes, three jobs run concurrently, and files are kept for a day. The service supports neither
//! cancellation nor seeds.

pub mod signature;
pub mod wire;

use serde_json::json;

use super::endpoint::{Question, Reading};
use super::failure::Failure;
use super::mesh::{MeshVendor, VendorMeshGenerator};
use super::settings::{MeshSettings, TaskSettings, TencentSettings};
use super::vendor_job::{Progress, Protocol, StatusQuery};
use http_client::HttpResponse;
use ports::ledger::MicroUsd;
use ports::{Adapter, ProviderError};

/// Name of the adapter.
pub const NAME: &str = "tencent/hunyuan3d-pro";

/// The header of the action, which is signed.
pub(super) const ACTION_HEADER: &str = "X-TC-Action";

/// The mesh generator of Tencent Cloud.
pub type TencentMeshGenerator = VendorMeshGenerator<TencentSettings>;

impl TencentSettings {
    /// The headers of an action; the endpoint adds the time and the signature.
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
    fn submitted(&self, reply: &HttpResponse) -> Reading<String> {
        wire::submitted(self, reply)
    }

    fn status_query(&self, id: &str) -> StatusQuery {
        StatusQuery::post("/", self.headers(wire::QUERY), &wire::query(id))
    }

    fn progress(&self, reply: &HttpResponse) -> Result<Progress, Failure> {
        wire::progress(reply)
    }

    fn cancel_path(&self, _id: &str) -> Option<String> {
        None
    }
}
