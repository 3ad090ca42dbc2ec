//! The HTTP interface: every route on this screen, one file per resource.
//!
//! Handlers read and write rows and blobs; they never build anything. What they accept is checked in
//! full before it is enqueued, and what they refuse is a problem document that says what to change.

pub mod error;
pub mod views;
mod query;
pub mod spending;
pub mod submission;
pub mod image;
mod data_uri;
mod json_detail;
pub mod scenes;
pub mod download;
pub mod bundle;
pub mod artifacts;
pub mod jobs;
pub mod events;
pub mod probes;
pub mod layers;
pub mod serve;

use std::sync::Arc;

use axum::Router;
use axum::http::Method;
use axum::routing::{MethodRouter, delete, get, post};
use bytes::Bytes;
use futures::future::BoxFuture;
use metrics_exporter_prometheus::PrometheusHandle;
use serde::{Deserialize, Serialize};
use tokio::sync::Semaphore;
use tokio_util::sync::CancellationToken;

use scene::SceneRequest;
use scene::text_account::TextAccount;
use store::Store;

pub use error::{FieldError, Problem};

/// Section `[server]`.
#[derive(Clone, Debug, Serialize, Deserialize, PartialEq)]
#[serde(deny_unknown_fields)]
pub struct Settings {
    /// Address and port to listen on; port 0 takes a free one.
    pub listen: String,
    /// Largest request body, bytes. An image in JSON is a third larger than its file.
    pub max_body_bytes: usize,
    /// Largest image file, bytes.
    pub max_image_bytes: usize,
    /// Largest image, pixels (width times height), checked before it is decoded.
    pub max_image_pixels: u64,
    /// The most that calls of remote models for one scene may cost, US dollars, where its request does not say.
    pub usual_budget_usd: f64,
    /// Longest text, characters.
    pub max_text_chars: usize,
    /// A connection that has not sent its whole header by then is closed, seconds.
    pub header_timeout_secs: u64,
    /// A request that has not sent its whole body by then is refused, seconds.
    pub body_timeout_secs: u64,
    /// Images that a request names by their address are fetched.
    pub fetch_images: bool,
    /// Longest time to fetch one, seconds.
    pub fetch_timeout_secs: u64,
    /// Hosts, or `host:port`, that images may be fetched from by plain HTTP and at private addresses; separated by
    /// spaces.
    pub fetch_hosts: String,
    /// Longest wait a client may ask for with `Prefer: wait=N`, seconds.
    pub max_wait_secs: u64,
    /// Connections served at the same time; more wait to be accepted.
    pub max_connections: usize,
    /// How long a shutdown waits for requests that are being answered, seconds.
    pub shutdown_grace_secs: u64,
}

/// Validates a request against the configuration (`options.set`); empty = valid. Made by `app::pipeline::validate`.
pub type Validate = Arc<dyn Fn(&SceneRequest) -> Vec<FieldError> + Send + Sync>;

/// The account of the text of a request, without making a scene; `None` for an image, and where a remote model reads
/// texts. The error is that of the field `/text`. Made by `app::pipeline::understand`.
pub type Understand = Arc<dyn Fn(&SceneRequest) -> Result<Option<TextAccount>, FieldError> + Send + Sync>;

/// Fetches an image from a client's address, at most so many bytes; an error is for the client to read. Made by
/// `app::fetching`.
pub type FetchImage = Arc<dyn Fn(String, usize) -> BoxFuture<'static, Result<Bytes, String>> + Send + Sync>;

/// What handlers share; cloning shares it.
#[derive(Clone)]
pub struct Api {
    pub store: Store,
    pub settings: Arc<Settings>,
    pub validate: Validate,
    pub understand: Understand,
    pub fetch_image: FetchImage,
    pub metrics: PrometheusHandle,
    /// Cancelled when the process is to end: not ready any more, streams end.
    pub shutdown: CancellationToken,
    /// Images are decoded a few at a time.
    decoders: Arc<Semaphore>,
}

impl Api {
    pub fn new(
        store: Store,
        settings: Settings,
        validate: Validate,
        understand: Understand,
        fetch_image: FetchImage,
        metrics: PrometheusHandle,
        shutdown: CancellationToken,
    ) -> Self {
        let decoders = Arc::new(Semaphore::new(2));
        Self {
            store,
            settings: Arc::new(settings),
            validate,
            understand,
            fetch_image,
            metrics,
            shutdown,
            decoders,
        }
    }
}

/// Every route: method, path, handler. `openapi.yaml` has the same list (a test compares them).
pub fn routes() -> Vec<(Method, &'static str, MethodRouter<Api>)> {
    vec![
        (Method::POST, "/scenes", post(scenes::submit)),
        (Method::GET, "/scenes", get(scenes::list)),
        (Method::GET, "/scenes/{scene_id}", get(scenes::show)),
        (Method::DELETE, "/scenes/{scene_id}", delete(scenes::remove)),
        (Method::GET, "/scenes/{scene_id}/bundle", get(bundle::download)),
        (Method::GET, "/scenes/{scene_id}/artifacts", get(artifacts::list)),
        (Method::GET, "/scenes/{scene_id}/artifacts/{*name}", get(artifacts::download)),
        (Method::GET, "/jobs/{job_id}", get(jobs::show)),
        (Method::GET, "/jobs/{job_id}/stages", get(jobs::stages)),
        (Method::GET, "/jobs/{job_id}/events", get(events::list)),
        (Method::POST, "/jobs/{job_id}/cancel", post(jobs::cancel)),
        (Method::POST, "/jobs/{job_id}/retry", post(jobs::retry)),
        (Method::GET, "/healthz", get(probes::healthz)),
        (Method::GET, "/readyz", get(probes::readyz)),
        (Method::GET, "/metrics", get(probes::metrics)),
        (Method::GET, "/version", get(probes::version)),
        (Method::GET, "/openapi.yaml", get(probes::openapi)),
    ]
}

/// The routes with what surrounds them: request ids, problem documents, metrics, panics caught.
pub fn router(api: Api) -> Router {
    let router = routes()
        .into_iter()
        .fold(Router::new(), |router, (_, path, handler)| router.route(path, handler))
        .fallback(error::no_such_route)
        .method_not_allowed_fallback(error::method_not_allowed);
    layers::around(router, &api).with_state(api)
}
