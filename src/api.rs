//! The HTTP interface: every route on this screen, one file per resource.
//!
//! Handlers read and write rows and blobs; workers build what is kept. What they accept is checked in
//! full before it is enqueued, and what they refuse is a problem document that says what to change.

pub mod contract;
mod access;
pub mod authentication;
mod principal;
mod proxy_identity;
mod cookie;
mod gate;
mod audit_trail;
mod minute_counts;
pub mod session;
pub mod keys;
pub mod audit;
pub mod webhooks;
mod error;
pub mod views;
mod query;
mod extract;
pub mod spending;
pub mod scene_body;
mod body;
mod body_memory;
mod form_body;
mod json_body;
mod json_outline;
mod merge_patch;
mod preconditions;
mod data_uri;
pub mod scenes;
mod accepted;
mod idempotency;
mod limits;
mod turns;
mod enqueue;
mod parent;
mod instructions;
pub mod edits;
pub mod variants;
pub mod lineage;
pub mod tasks;
pub mod executions;
pub mod batches;
pub mod datasets;
pub mod episodes;
pub mod download;
mod pieces;
pub mod bundle;
pub mod files;
pub mod preview;
mod rebuild;
pub mod artifacts;
pub mod jobs;
pub mod events;
pub mod probes;
pub mod index;
pub mod queue;
pub mod catalog;
pub mod request_schema;
pub mod studio;
mod deletion;
mod admission;
pub mod cross_origin;
pub mod layers;
pub mod serve;

use std::sync::Arc;
use std::time::Duration;

use axum::Router;
use axum::routing::get;
use metrics_exporter_prometheus::PrometheusHandle;
use serde::{Deserialize, Serialize};
use tokio::sync::Semaphore;
use tokio_util::sync::CancellationToken;

use crate::app::fetching::ImageFetcher;
use crate::app::{App, image};
use runtime::CpuPool;
use store::Store;
use store::scopes::Scope;

use admission::AllowedHosts;
use audit_trail::AuditTrail;
use body_memory::BodyMemory;
use contract::operations;
use contract::route::{self, Route};
use cookie::SessionCookie;
use cross_origin::AllowedOrigins;
use events::hub::EventHub;
use events::stream_limits::StreamLimits;
use minute_counts::MinuteCounts;
use proxy_identity::ProxyHeaders;
use serve::client_address::Proxies;
use serve::connections::Limits;
use turns::Turns;

/// Section `[server]`.
#[derive(Clone, Debug, Serialize, Deserialize, PartialEq)]
#[serde(deny_unknown_fields)]
pub struct Settings {
    /// Address and port to listen on; port 0 takes a free one.
    pub listen: String,
    /// Address by which clients reach the server, such as that of a proxy; empty = that of `listen`.
    pub public_url: String,
    /// Whether addresses beyond loopback are listened on although clients are not authenticated.
    pub allow_unauthenticated: bool,
    /// Further names that clients reach the server by, separated by spaces; `*` for any.
    pub allowed_hosts: String,
    /// Origins whose pages may use this server, separated by spaces.
    pub allowed_origins: String,
    /// Addresses of reverse proxies, separated by spaces.
    pub proxy_addresses: String,
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
    /// Memory that the bodies of all requests may take together, bytes.
    pub body_memory_bytes: usize,
    /// A connection that has not sent its whole header by then is closed, seconds.
    pub header_timeout_secs: u64,
    /// A connection that has not begun its next request by then is closed, seconds.
    pub keep_alive_timeout_secs: u64,
    /// Waiting time over which the rate of a client is measured, seconds.
    pub rate_window_secs: u64,
    /// A client that sends or takes fewer bytes per second of waiting is refused or closed.
    pub min_rate_bytes_per_s: u64,
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
    /// Connections served at the same time, at most what the limit of open files allows.
    pub max_connections: usize,
    /// The same of one client address.
    pub max_connections_per_address: usize,
    /// Requests answered at the same time; more are refused.
    pub max_requests: usize,
    /// Event streams open at the same time, at most half of the connections.
    pub max_event_streams: usize,
    /// The same of one client address.
    pub max_event_streams_per_address: usize,
    /// An event stream ends after this long, seconds.
    pub max_event_stream_secs: u64,
    /// Time that a shutdown keeps the listener open while `/readyz` answers 503, seconds.
    pub close_delay_secs: u64,
    /// Time that a shutdown then waits for requests that are being answered, seconds.
    pub shutdown_grace_secs: u64,
    pub authentication: authentication::Settings,
}

/// State that handlers share; cloning shares it.
#[derive(Clone)]
pub struct Api {
    pub store: Store,
    pub settings: Arc<Settings>,
    pub app: App,
    /// The pool that all work of the process computes on.
    pub cpu: CpuPool,
    pub fetcher: Arc<ImageFetcher>,
    pub metrics: PrometheusHandle,
    /// Cancelled when the process is to end: not ready any more.
    pub draining: CancellationToken,
    /// Cancelled when the listener closes: streams end.
    pub shutdown: CancellationToken,
    /// Submissions are written a few at a time, in turns of their tenants.
    submissions: Turns,
    /// Large bodies are parsed, and images decoded, a few at a time, in turns of their tenants.
    decoders: Turns,
    /// Pixels that are being decoded, in blocks: of the largest image there is one at a time.
    pixel_blocks: Arc<Semaphore>,
    /// Tasks are rehearsed one request at a time.
    rehearsals: Arc<Semaphore>,
    /// Archives are read for a file of theirs, a few at a time.
    archive_reads: Arc<Semaphore>,
    /// Images are fetched a few at a time.
    fetches: Arc<Semaphore>,
    /// Requests of batches are checked and stored for a few batches at a time, in turns of their tenants.
    receptions: Turns,
    /// Requests that are being answered.
    requests: Arc<Semaphore>,
    body_memory: BodyMemory,
    hosts: Arc<AllowedHosts>,
    origins: Arc<AllowedOrigins>,
    proxies: Arc<Proxies>,
    proxy_headers: Arc<ProxyHeaders>,
    session_cookie: SessionCookie,
    logins: Arc<MinuteCounts>,
    audit_trail: AuditTrail,
    streams: StreamLimits,
    /// Event streams read rows a few at a time: [`CONCURRENT_STREAM_READS`].
    stream_reads: Arc<Semaphore>,
    hub: EventHub,
}

impl Api {
    /// `shutdown` is cancelled when the listener closes.
    pub fn new(
        store: Store,
        app: App,
        cpu: CpuPool,
        settings: Settings,
        metrics: PrometheusHandle,
        shutdown: CancellationToken,
    ) -> Self {
        let semaphore = |permits: usize| Arc::new(Semaphore::new(permits.clamp(1, Semaphore::MAX_PERMITS)));
        let cores = std::thread::available_parallelism().map_or(1, usize::from);
        let max_streams = settings.max_event_streams.min(Limits::new(&settings).total.div_ceil(2));
        Self {
            submissions: Turns::new(SUBMISSIONS_PER_CORE * cores),
            decoders: Turns::new(2),
            pixel_blocks: semaphore(max_pixel_blocks(&settings) as usize),
            rehearsals: semaphore(1),
            archive_reads: semaphore(4),
            fetches: semaphore(4),
            receptions: Turns::new(2),
            requests: semaphore(settings.max_requests),
            body_memory: BodyMemory::new(settings.body_memory_bytes),
            hosts: Arc::new(AllowedHosts::new(
                &settings.listen,
                &settings.allowed_hosts,
                &settings.public_url,
            )),
            origins: Arc::new(AllowedOrigins::new(&settings.allowed_origins)),
            proxy_headers: Arc::new(ProxyHeaders::new(&settings.authentication)),
            session_cookie: SessionCookie::new(&settings.public_url),
            logins: Arc::new(MinuteCounts::new(u32::MAX, settings.authentication.logins_per_minute)),
            audit_trail: AuditTrail::new(store.clone()),
            proxies: Arc::new(Proxies::new(&settings.proxy_addresses)),
            streams: StreamLimits::new(max_streams, settings.max_event_streams_per_address),
            stream_reads: semaphore(CONCURRENT_STREAM_READS),
            hub: EventHub::new(store.clone(), shutdown.clone()),
            store,
            fetcher: Arc::new(ImageFetcher::new(
                Duration::from_secs(settings.fetch_timeout_secs),
                &settings.fetch_hosts,
            )),
            settings: Arc::new(settings),
            app,
            cpu,
            metrics,
            draining: shutdown.child_token(),
            shutdown,
        }
    }

    fn max_pixel_blocks(&self) -> u32 {
        max_pixel_blocks(&self.settings)
    }
}

/// Submissions that are written at the same time. More would only compete for the processor, and one that has to
/// wait for the database leaves it to the others.
const SUBMISSIONS_PER_CORE: usize = 2;

/// Event streams that read rows at the same time. Other requests keep the remaining connections to the database.
const CONCURRENT_STREAM_READS: usize = 2;

/// Blocks of the largest image that is accepted.
fn max_pixel_blocks(settings: &Settings) -> u32 {
    u32::try_from(settings.max_image_pixels.div_ceil(image::PIXELS_PER_BLOCK)).unwrap_or(u32::MAX).max(1)
}

/// Every route: method, path, handler, the text of the contract, and who may use it. GET needs the scope `read`, POST
/// `submit`, DELETE and PATCH `delete`, unless a route says otherwise.
pub fn routes() -> Vec<Route> {
    [scene_routes(), collection_routes(), job_routes()].into_iter().flatten().collect()
}

/// Scenes, and what is made from one.
fn scene_routes() -> Vec<Route> {
    vec![
        route::post("/scenes", scenes::submit, operations::submit_scene),
        route::post("/scenes/validate", scenes::validate, operations::validate_scene).needs(Scope::Read),
        route::get("/scenes", scenes::list, operations::list_scenes),
        route::get("/scenes/facets", scenes::facets, operations::count_scenes),
        route::get("/scenes/{scene_id}", scenes::show, operations::get_scene),
        route::patch("/scenes/{scene_id}", scenes::change, operations::change_scene),
        route::delete("/scenes/{scene_id}", scenes::remove, operations::delete_scene),
        route::get("/scenes/{scene_id}/bundle", bundle::download, operations::get_bundle),
        route::get("/scenes/{scene_id}/files", files::list, operations::list_files),
        route::get("/scenes/{scene_id}/files/{*name}", files::download, operations::get_file),
        route::get("/scenes/{scene_id}/preview", preview::show, operations::get_preview),
        route::post("/scenes/{scene_id}/edits", edits::submit, operations::edit_scene),
        route::post("/scenes/{scene_id}/edits/validate", edits::validate, operations::validate_edit)
            .needs(Scope::Read),
        route::post("/scenes/{scene_id}/variants", variants::submit, operations::make_variants),
        route::post(
            "/scenes/{scene_id}/variants/validate",
            variants::validate,
            operations::validate_variants,
        )
        .needs(Scope::Read),
        route::get("/scenes/{scene_id}/lineage", lineage::show, operations::get_lineage),
        route::get("/scenes/{scene_id}/tasks", tasks::list, operations::list_tasks),
        route::post("/scenes/{scene_id}/executions", executions::submit, operations::execute_task),
        route::post("/scenes/{scene_id}/episodes", episodes::submit, operations::submit_episodes),
        route::get("/scenes/{scene_id}/artifacts", artifacts::list, operations::list_artifacts),
        route::get("/scenes/{scene_id}/artifacts/{*name}", artifacts::download, operations::get_artifact),
    ]
}

/// Batches, datasets and recordings of episodes.
fn collection_routes() -> Vec<Route> {
    vec![
        route::post("/batches", batches::submit, operations::submit_batch),
        route::get("/batches", batches::list, operations::list_batches),
        route::get("/batches/{batch_id}", batches::show, operations::get_batch),
        route::delete("/batches/{batch_id}", batches::remove, operations::delete_batch),
        route::get("/batches/{batch_id}/output", batches::output, operations::get_batch_output),
        route::get("/batches/{batch_id}/errors", batches::errors, operations::get_batch_errors),
        route::post("/batches/{batch_id}/cancel", batches::cancel, operations::cancel_batch)
            .needs(Scope::Operate),
        route::post("/batches/{batch_id}/retry", batches::retry, operations::retry_batch)
            .needs(Scope::Operate),
        route::post("/datasets", datasets::submit, operations::submit_dataset),
        route::get("/datasets", datasets::list, operations::list_datasets),
        route::get("/datasets/{dataset_id}", datasets::show, operations::get_dataset),
        route::delete("/datasets/{dataset_id}", datasets::remove, operations::delete_dataset),
        route::post("/datasets/{dataset_id}/verify", datasets::verify, operations::verify_dataset)
            .needs(Scope::Operate),
        route::get("/datasets/{dataset_id}/archive", datasets::archive, operations::get_dataset_archive),
        route::get("/datasets/{dataset_id}/files", datasets::files, operations::list_dataset_files),
        route::get("/datasets/{dataset_id}/files/{*name}", datasets::download, operations::get_dataset_file),
        route::get("/episodes", episodes::list, operations::list_episodes),
        route::get("/episodes/{recording_id}", episodes::show, operations::get_episodes),
        route::delete("/episodes/{recording_id}", episodes::remove, operations::delete_episodes),
        route::get("/episodes/{recording_id}/events", events::of_recording, operations::list_episode_events),
        route::post("/episodes/{recording_id}/cancel", episodes::cancel, operations::cancel_episodes)
            .needs(Scope::Operate),
        route::get("/episodes/{recording_id}/files", episodes::files, operations::list_episode_files),
        route::get(
            "/episodes/{recording_id}/files/{*name}",
            episodes::download,
            operations::get_episode_file,
        ),
        route::get(
            "/episodes/{recording_id}/archives/{format}",
            episodes::archive,
            operations::get_episode_archive,
        ),
    ]
}

/// Jobs, access, and the server itself.
fn job_routes() -> Vec<Route> {
    vec![
        route::get("/executions/{execution_id}", executions::show, operations::get_execution),
        route::get("/jobs", jobs::list, operations::list_jobs),
        route::get("/jobs/{job_id}", jobs::show, operations::get_job),
        route::get("/jobs/{job_id}/stages", jobs::stages, operations::list_stages),
        route::get("/jobs/{job_id}/events", events::of_job, operations::list_events),
        route::get("/events", events::of_tenant, operations::list_all_events),
        route::post("/jobs/{job_id}/cancel", jobs::cancel, operations::cancel_job).needs(Scope::Operate),
        route::post("/jobs/{job_id}/retry", jobs::retry, operations::retry_job).needs(Scope::Operate),
        route::post("/session", session::begin, operations::begin_session).public(),
        route::get("/session", session::show, operations::get_session).for_all_known(),
        route::delete("/session", session::end, operations::end_session).public(),
        route::post("/keys", keys::create, operations::create_key).needs(Scope::Admin),
        route::get("/keys", keys::list, operations::list_keys).needs(Scope::Admin),
        route::delete("/keys/{key_id}", keys::revoke, operations::revoke_key).needs(Scope::Admin),
        route::get("/audit", audit::list, operations::list_audit).needs(Scope::Admin),
        route::get("/audit/lines", audit::lines, operations::export_audit).needs(Scope::Admin),
        route::post("/webhooks", webhooks::create, operations::create_webhook).needs(Scope::Admin),
        route::get("/webhooks", webhooks::list, operations::list_webhooks).needs(Scope::Admin),
        route::get("/webhooks/{webhook_id}", webhooks::show, operations::get_webhook).needs(Scope::Admin),
        route::patch("/webhooks/{webhook_id}", webhooks::change, operations::change_webhook)
            .needs(Scope::Admin),
        route::delete("/webhooks/{webhook_id}", webhooks::remove, operations::delete_webhook)
            .needs(Scope::Admin),
        route::post(
            "/webhooks/{webhook_id}/secret",
            webhooks::renew_secret,
            operations::renew_webhook_secret,
        )
        .needs(Scope::Admin),
        route::post("/webhooks/{webhook_id}/test", webhooks::test, operations::test_webhook)
            .needs(Scope::Admin),
        route::get("/webhooks/{webhook_id}/deliveries", webhooks::deliveries, operations::list_deliveries)
            .needs(Scope::Admin),
        route::post(
            "/webhooks/{webhook_id}/deliveries/{delivery_id}/replay",
            webhooks::replay,
            operations::replay_delivery,
        )
        .needs(Scope::Admin),
        route::get("/", index::show, operations::index).public(),
        route::get("/studio/{*name}", studio::show, operations::studio).public(),
        route::get("/queue", queue::show, operations::get_queue).needs(Scope::Operate),
        route::get("/catalog", catalog::show, operations::get_catalog),
        route::get("/robots", catalog::list_robots, operations::list_robots),
        route::get("/robots/{robot}/model", catalog::robot_model, operations::get_robot_model),
        route::get("/settings/schema", request_schema::show, operations::get_request_schema),
        route::get("/healthz", probes::healthz, operations::healthz).public(),
        route::get("/readyz", probes::readyz, operations::readyz).public(),
        route::get("/metrics", probes::metrics, operations::metrics).needs(Scope::Operate),
        route::get("/version", probes::version, operations::version).public(),
        route::get("/openapi.yaml", probes::openapi, operations::openapi).public(),
    ]
}

/// The routes behind their gates, with what surrounds them: request ids, problem documents, metrics, panics caught.
pub fn router(api: Api) -> Router {
    let router = routes()
        .into_iter()
        .fold(Router::new(), |router, route| router.route(route.path, gate::around(route, &api)));
    // The same page by shorter addresses, which the contract need not have.
    let router = router.route("/studio", get(studio::enter)).route("/studio/", get(studio::start));
    surrounded(router, api)
}

/// The routes of a process without the interface: probes, metrics and the version, for all who reach its address.
pub fn probe_router(api: Api) -> Router {
    let is_probe = |route: &Route| matches!(route.path, "/healthz" | "/readyz" | "/metrics" | "/version");
    let router = routes()
        .into_iter()
        .filter(is_probe)
        .fold(Router::new(), |router, route| router.route(route.path, route.handler));
    surrounded(router, api)
}

fn surrounded(router: Router<Api>, api: Api) -> Router {
    let router = router.fallback(error::no_such_route).method_not_allowed_fallback(error::method_not_allowed);
    let router = layers::around(admission::around(idempotency::around(router, &api), &api), &api);
    // Outermost, so that pages can read what is refused, too.
    let router = match api.origins.layer() {
        Some(layer) => router.layer(layer),
        None => router,
    };
    router.with_state(api)
}
