//! Mock server for the protocols of all remote models, for development and tests without keys. The embedded ports
//! generate its images, masks and meshes.
//!
//! Like a model, the server only knows the request. It recognizes its own images by their fingerprint
//! ([`image_sessions`], [`image_fingerprint`]) and analyzes any other image. It shares no types with the adapters,
//! validates requests strictly, and keeps a [`bill`], at `/bill`. One address serves all protocols:
//!
//! | protocol | base URL |
//! | --- | --- |
//! | OpenAI-compatible chat, and Images | `/v1` |
//! | Ark's Seedream | `/api/v3` |
//! | segmentation sidecar | `/` |
//! | Replicate-style predictions | `/v1` |
//! | Hunyuan3D's server | `/` |
//! | Tencent Cloud's Hunyuan3D Pro | `/` |
//!
//! It requires no key and verifies no signature. The product must not depend on it.

pub mod bill;
pub mod image_fingerprint;
pub mod recognized_image;
pub mod image_sessions;
mod error_response;
mod vendor_jobs;
mod chat;
mod images;
mod ark;
mod segment;
mod predictions;
mod hunyuan3d;
mod tencent;

use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Duration;

use axum::Router;
use axum::extract::{DefaultBodyLimit, State};
use axum::routing::{get, post};

use bill::Bill;
use image_sessions::ImageSessions;
use vendor_jobs::VendorJobs;

/// Maximum request size, bytes.
const MAX_BODY_BYTES: usize = 64 << 20;

/// State shared by all protocols.
pub struct MockVendors {
    pub sessions: ImageSessions,
    pub bill: Bill,
    /// Minimum duration of every response and every job.
    pub latency: Duration,
    /// Number of upcoming top views that return the request's own image instead.
    pub invalid_top_views: AtomicUsize,
    jobs: VendorJobs,
}

impl MockVendors {
    pub fn new(sessions: ImageSessions, latency: Duration) -> Arc<Self> {
        let (bill, jobs, invalid_top_views) = (Bill::default(), VendorJobs::default(), AtomicUsize::new(0));
        Arc::new(Self { sessions, bill, latency, invalid_top_views, jobs })
    }

    fn takes_invalid_top_view(&self) -> bool {
        let fewer = |left: usize| left.checked_sub(1);
        self.invalid_top_views.fetch_update(Ordering::Relaxed, Ordering::Relaxed, fewer).is_ok()
    }

    /// Simulates the latency of a model.
    async fn pause(&self) {
        if !self.latency.is_zero() {
            tokio::time::sleep(self.latency).await;
        }
    }
}

/// All routes.
pub fn router(providers: Arc<MockVendors>) -> Router {
    Router::new()
        .route("/v1/chat/completions", post(chat::complete))
        .route("/v1/images/generations", post(images::generate))
        .route("/v1/images/edits", post(images::edit))
        .route("/api/v3/images/generations", post(ark::generate))
        .route("/v1/segment", post(segment::segment))
        .route("/v1/predictions", post(predictions::submit))
        .route("/v1/predictions/{id}", get(predictions::status))
        .route("/v1/predictions/{id}/cancel", post(predictions::cancel))
        .route("/files/{name}", get(predictions::download))
        .route("/send", post(hunyuan3d::send))
        .route("/status/{uid}", get(hunyuan3d::status))
        .route("/", post(tencent::act))
        .route("/bill", get(bill))
        .layer(DefaultBodyLimit::max(MAX_BODY_BYTES))
        .with_state(providers)
}

async fn bill(State(providers): State<Arc<MockVendors>>) -> axum::Json<Vec<bill::Billed>> {
    axum::Json(providers.bill.lines())
}
