//! Rules between keys, and forms a range cannot express.

use super::Config;
use super::parts::Parts;
use crate::api;
use crate::api::authentication::Mode;
use crate::api::cross_origin::is_origin;
use ports::feature_extractor::FeatureAdapter;
use remote::settings::{AnalystProvider, TransportMode};
use store::BlobPlace;
use store::scopes::ScopeSet;

/// Every broken rule: the key to change, and why.
pub(super) fn broken(config: &Config) -> Vec<(&'static str, String)> {
    let mut found = Parts::BUILT.lacking(config);
    let mut rule = |key: &'static str, holds: bool, detail: String| {
        if !holds {
            found.push((key, detail));
        }
    };
    let Config { server, worker, log, analyst, layout, image_generator, descriptor, render, .. } = config;
    let Config { canonicalize, dro, settle, resolve, appraise, export, features, network, .. } = config;
    let (providers, store) = (&config.providers, &config.store);

    rule(
        "server.listen",
        is_address(&server.listen),
        format!("{:?} is no address with a port, such as 127.0.0.1:8080 or [::1]:0", server.listen),
    );
    rule(
        "worker.listen",
        worker.listen.is_empty() || is_address(&worker.listen),
        format!("{:?} is no address with a port, such as 127.0.0.1:9090; empty for none", worker.listen),
    );
    rule(
        "store.limits.waiting_jobs",
        config.store.limits.waiting_jobs <= config.queue.max_jobs,
        format!(
            "{} is more than queue.max_jobs = {}, so that one tenant could fill the queue",
            config.store.limits.waiting_jobs, config.queue.max_jobs
        ),
    );
    rule(
        "server.max_body_bytes",
        server.max_body_bytes / 4 * 3 >= server.max_image_bytes,
        format!(
            "{} bytes of body hold no base64 image of server.max_image_bytes = {}; a third more is needed",
            server.max_body_bytes, server.max_image_bytes
        ),
    );
    rule(
        "server.body_memory_bytes",
        server.body_memory_bytes / 2 >= server.max_body_bytes,
        format!(
            "{} bytes are less than twice server.max_body_bytes = {}; a body and what it is decoded into must fit",
            server.body_memory_bytes, server.max_body_bytes
        ),
    );
    let not_an_address =
        server.proxy_addresses.split_whitespace().find(|a| a.parse::<std::net::IpAddr>().is_err());
    rule(
        "server.proxy_addresses",
        not_an_address.is_none(),
        format!("{:?} is no address, such as 10.0.0.1", not_an_address.unwrap_or_default()),
    );
    authentication(server, &mut rule);
    rule(
        "worker.heartbeat_secs",
        worker.heartbeat_secs * 3 <= worker.lease_secs,
        format!(
            "{} is more than a third of worker.lease_secs = {}; a slow worker would lose its jobs",
            worker.heartbeat_secs, worker.lease_secs
        ),
    );
    let postgres = &store.postgres;
    rule(
        "store.postgres.idle_transaction_timeout_ms",
        postgres.idle_transaction_timeout_ms < worker.lease_secs.saturating_mul(1000),
        format!(
            "{} ms are not less than worker.lease_secs = {}; a stopped process would keep its jobs locked beyond its lease",
            postgres.idle_transaction_timeout_ms, worker.lease_secs
        ),
    );
    rule(
        "store.postgres.answer_timeout_ms",
        postgres.answer_timeout_ms > postgres.statement_timeout_ms,
        format!(
            "{} is not more than store.postgres.statement_timeout_ms = {}; connections would be closed where the server \
             ends the statement itself",
            postgres.answer_timeout_ms, postgres.statement_timeout_ms
        ),
    );
    rule(
        "store.postgres.long_timeout_secs",
        postgres.long_timeout_secs.saturating_mul(1000) >= postgres.answer_timeout_ms,
        format!(
            "{} s are less than store.postgres.answer_timeout_ms = {}",
            postgres.long_timeout_secs, postgres.answer_timeout_ms
        ),
    );
    rule(
        "store.s3.bucket",
        store.blobs != BlobPlace::S3 || !store.s3.bucket.is_empty(),
        "store.blobs = s3 wants a bucket; name one that exists".into(),
    );
    let scheme = store.s3.endpoint.split_once("://").map(|(scheme, _)| scheme);
    rule(
        "store.s3.endpoint",
        store.s3.endpoint.is_empty()
            || scheme == Some("https")
            || (scheme == Some("http") && store.s3.allow_http),
        format!("{:?} is no https address; store.s3.allow_http = true allows http", store.s3.endpoint),
    );
    rule(
        "store.s3.retry_secs",
        store.blobs != BlobPlace::S3 || store.s3.longest_secs() < worker.lease_secs,
        format!(
            "all tries of a request take up to {} s, not less than worker.lease_secs = {}; lower it or raise that",
            store.s3.longest_secs(),
            worker.lease_secs
        ),
    );
    rule(
        "store.retention.grace_secs",
        store.retention.grace_secs > worker.stage_timeout_secs,
        format!(
            "{} is not more than worker.stage_timeout_secs = {}; a sweep would remove what a stage has just put",
            store.retention.grace_secs, worker.stage_timeout_secs
        ),
    );
    rule(
        "worker.backoff_cap_ms",
        worker.backoff_cap_ms >= worker.backoff_base_ms,
        format!("{} is less than worker.backoff_base_ms = {}", worker.backoff_cap_ms, worker.backoff_base_ms),
    );
    rule(
        "log.filter",
        log.filter.parse::<tracing_subscriber::filter::EnvFilter>().is_ok(),
        format!("{:?} cannot be read as tracing directives; try `info`", log.filter),
    );
    rule(
        "features.adapter",
        features.adapter == FeatureAdapter::Descriptor || !features.weights.is_empty(),
        "dinov2 needs weights; name their folder or file in features.weights, or use descriptor".into(),
    );
    rule(
        "network.weights",
        !network.weights.is_empty(),
        "network.weights is empty: name a safetensors file or \"built-in\"".into(),
    );
    rule(
        "providers.cassette",
        providers.mode == TransportMode::Live || !providers.cassette.is_empty(),
        "record and replay want a recording; name its folder, or set providers.mode = live".into(),
    );
    let has_opinions = providers.analyst.iter().any(|provider| *provider != AnalystProvider::Embedded);
    for (key, asked) in [("appraise.ratings", appraise.ratings), ("appraise.tasks", appraise.tasks > 0)] {
        let message =
            "the embedded analyst has no opinion of scenes; put chat into providers.analyst, or ask for none";
        rule(key, !asked || has_opinions, message.into());
    }
    rule(
        "analyst.default_max_objects",
        analyst.default_max_objects >= analyst.fewest_objects,
        format!(
            "{} is less than analyst.fewest_objects = {}",
            analyst.default_max_objects, analyst.fewest_objects
        ),
    );
    rule(
        "layout.min_gap_m",
        layout.min_gap_m <= layout.gap_m,
        format!("{} is more than layout.gap_m = {}", layout.min_gap_m, layout.gap_m),
    );
    rule(
        "painter.elevation_rad",
        image_generator.elevation_rad.is_sorted(),
        "the lowest elevation comes first".into(),
    );
    rule(
        "descriptor.side_px",
        descriptor.side_px.is_multiple_of(descriptor.patches),
        format!("{} is no multiple of descriptor.patches = {}", descriptor.side_px, descriptor.patches),
    );
    rule(
        "render.shadow_map_px",
        render.shadow_map_px == 0 || render.shadow_map_px >= 128,
        format!("{} is neither 0 nor at least 128", render.shadow_map_px),
    );
    for (key, side) in [
        ("canonicalize.side_px", canonicalize.side_px),
        ("dro.coarse_px", dro.coarse_px),
        ("dro.fine_px", dro.fine_px),
    ] {
        rule(key, side.is_multiple_of(32), format!("{side} is no multiple of 32"));
    }
    rule(
        "dro.silhouette_weight",
        dro.silhouette_weight + dro.edge_weight > 0.0,
        "it and dro.edge_weight are both 0; then every yaw is as good".into(),
    );
    rule(
        "settle.contact_frequency_hz",
        settle.contact_frequency_hz <= settle.steps_per_s * settle.solver_iterations as f64 / 4.0,
        format!(
            "{} is more than a quarter of settle.steps_per_s times settle.solver_iterations; stacks would buzz",
            settle.contact_frequency_hz
        ),
    );
    rule(
        "resolve.clearances_m",
        resolve.clearances_m.is_sorted(),
        "the gaps must grow from round to round".into(),
    );
    let fault = config.photograph.intrinsics_fault();
    rule("photograph.intrinsics_px", fault.is_none(), fault.unwrap_or_default());
    rule("export.date", is_date(&export.date), format!("{:?} is no date such as 2026-01-31", export.date));
    found
}

/// Rules of section `[server.authentication]` and of the public address.
fn authentication(server: &api::Settings, rule: &mut impl FnMut(&'static str, bool, String)) {
    let url = &server.public_url;
    let host = ["https://", "http://"].iter().find_map(|scheme| url.strip_prefix(scheme));
    rule(
        "server.public_url",
        url.is_empty() || host.is_some_and(|host| !host.is_empty() && !host.starts_with('/')),
        format!("{url:?} is no address such as https://scenes.example.org"),
    );
    let stray =
        server.allowed_origins.split_whitespace().find(|origin| !is_origin(origin)).unwrap_or_default();
    rule(
        "server.allowed_origins",
        stray.is_empty(),
        format!("{stray:?} is no origin such as https://app.example.org or http://localhost:3000"),
    );
    let settings = &server.authentication;
    for (key, name) in [
        ("server.authentication.proxy_user_header", &settings.proxy_user_header),
        ("server.authentication.proxy_tenant_header", &settings.proxy_tenant_header),
        ("server.authentication.proxy_scopes_header", &settings.proxy_scopes_header),
    ] {
        let is_name = name.bytes().all(|byte| byte.is_ascii_alphanumeric() || byte == b'-');
        rule(key, is_name, format!("{name:?} is no name of a header, such as X-Auth-Request-Email"));
    }
    let has_user = !settings.proxy_user_header.is_empty();
    rule(
        "server.authentication.proxy_user_header",
        !has_user || (settings.mode == Mode::Keys && !server.proxy_addresses.is_empty()),
        "it wants server.authentication.mode = keys, and the proxy in server.proxy_addresses; without them everyone could \
         name any user, or none"
            .into(),
    );
    for (key, name) in [
        ("server.authentication.proxy_tenant_header", &settings.proxy_tenant_header),
        ("server.authentication.proxy_scopes_header", &settings.proxy_scopes_header),
    ] {
        let detail = "it says nothing without server.authentication.proxy_user_header; name that, too";
        rule(key, has_user || name.is_empty(), detail.into());
    }
    let scopes = ScopeSet::parse(&settings.proxy_usual_scopes);
    let fault = scopes.err().map(|error| error.to_string());
    rule("server.authentication.proxy_usual_scopes", fault.is_none(), fault.unwrap_or_default());
}

/// `host:port`.
fn is_address(text: &str) -> bool {
    text.rsplit_once(':').is_some_and(|(host, port)| !host.is_empty() && port.parse::<u16>().is_ok())
}

/// `YYYY-MM-DD`.
fn is_date(text: &str) -> bool {
    let digits = |range: std::ops::Range<usize>| {
        text.get(range).filter(|part| part.bytes().all(|b| b.is_ascii_digit()))?.parse::<u32>().ok()
    };
    text.len() == 10
        && text.as_bytes()[4] == b'-'
        && text.as_bytes()[7] == b'-'
        && digits(0..4).is_some()
        && digits(5..7).is_some_and(|month| (1..=12).contains(&month))
        && digits(8..10).is_some_and(|day| (1..=31).contains(&day))
}
