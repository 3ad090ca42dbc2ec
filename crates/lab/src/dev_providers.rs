//! One server that speaks the protocols of all remote models, for people and tests that have no keys: its pictures are
//! painted, its things found and its meshes built by the embedded ports.
//!
//! A model sees nothing but what is sent to it, and so does this server: it knows a picture it painted when it sees it
//! again ([`studio`], [`likeness`]), and looks at any other. It shares no types with the adapters, is strict about
//! requests, and keeps a [`bill`], at `/bill`. One address answers for everybody:
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
//! It asks for no key, and checks no signature. It is no part of what makes scenes.

pub mod bill;
pub mod likeness;
pub mod sight;
pub mod studio;
mod refusal;
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
use studio::Studio;
use vendor_jobs::VendorJobs;

/// Largest request, bytes.
const MAX_BODY_BYTES: usize = 64 << 20;

/// What all protocols share.
pub struct DevProviders {
    pub studio: Studio,
    pub bill: Bill,
    /// Every answer takes at least this long, and so does every job.
    pub latency: Duration,
    /// How many of the next views from above come back as the picture that was sent.
    pub spoiled_top_views: AtomicUsize,
    jobs: VendorJobs,
}

impl DevProviders {
    pub fn new(studio: Studio, latency: Duration) -> Arc<Self> {
        let (bill, jobs, spoiled_top_views) = (Bill::default(), VendorJobs::default(), AtomicUsize::new(0));
        Arc::new(Self { studio, bill, latency, spoiled_top_views, jobs })
    }

    fn spoils_a_top_view(&self) -> bool {
        let fewer = |left: usize| left.checked_sub(1);
        self.spoiled_top_views.fetch_update(Ordering::Relaxed, Ordering::Relaxed, fewer).is_ok()
    }

    /// As slow as a model is.
    async fn pause(&self) {
        if !self.latency.is_zero() {
            tokio::time::sleep(self.latency).await;
        }
    }
}

/// Every route on one screen.
pub fn router(providers: Arc<DevProviders>) -> Router {
    Router::new()
        .route("/v1/chat/completions", post(chat::complete))
        .route("/v1/images/generations", post(images::generate))
        .route("/v1/images/edits", post(images::edit))
        .route("/api/v3/images/generations", post(ark::generate))
        .route("/v1/segment", post(segment::segment))
        .route("/v1/predictions", post(predictions::submit))
        .route("/v1/predictions/{id}", get(predictions::look))
        .route("/v1/predictions/{id}/cancel", post(predictions::cancel))
        .route("/files/{name}", get(predictions::download))
        .route("/send", post(hunyuan3d::send))
        .route("/status/{uid}", get(hunyuan3d::status))
        .route("/", post(tencent::act))
        .route("/bill", get(bill))
        .layer(DefaultBodyLimit::max(MAX_BODY_BYTES))
        .with_state(providers)
}

async fn bill(State(providers): State<Arc<DevProviders>>) -> axum::Json<Vec<bill::Billed>> {
    axum::Json(providers.bill.lines())
}
