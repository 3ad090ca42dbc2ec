//! `/`: the page for people, and the start of the interface for programs.

use axum::Json;
use axum::http::{HeaderMap, HeaderValue, StatusCode, header};
use axum::response::{IntoResponse, Response};
use schemars::JsonSchema;
use serde::Serialize;

use crate::schemas::values::Link;

/// Name and version of the program, and paths of its interface.
#[derive(Serialize, JsonSchema)]
pub(super) struct Index {
    name: &'static str,
    version: &'static str,
    links: IndexLinks,
}

/// Paths that a client begins with.
#[derive(Serialize, JsonSchema)]
pub(super) struct IndexLinks {
    #[schemars(with = "Link")]
    contract: &'static str,
    /// The page for people.
    #[schemars(with = "Link")]
    page: &'static str,
    #[schemars(with = "Link")]
    scenes: &'static str,
    #[schemars(with = "Link")]
    jobs: &'static str,
    #[schemars(with = "Link")]
    batches: &'static str,
    #[schemars(with = "Link")]
    datasets: &'static str,
    #[schemars(with = "Link")]
    episodes: &'static str,
    #[schemars(with = "Link")]
    events: &'static str,
    #[schemars(with = "Link")]
    session: &'static str,
    #[schemars(with = "Link")]
    version: &'static str,
}

const INDEX: Index = Index {
    name: env!("CARGO_PKG_NAME"),
    version: env!("CARGO_PKG_VERSION"),
    links: IndexLinks {
        contract: "/openapi.yaml",
        page: "/studio/",
        scenes: "/scenes",
        jobs: "/jobs",
        batches: "/batches",
        datasets: "/datasets",
        episodes: "/episodes",
        events: "/events",
        session: "/session",
        version: "/version",
    },
};

/// `GET /`.
pub async fn show(headers: HeaderMap) -> Response {
    let accepted = headers.get_all(header::ACCEPT).into_iter().filter_map(|value| value.to_str().ok());
    let is_browser =
        accepted.flat_map(|value| value.split(',')).any(|kind| kind.trim().starts_with("text/html"));
    let vary = (header::VARY, HeaderValue::from_static("accept"));
    match is_browser {
        true => {
            (StatusCode::SEE_OTHER, [vary, (header::LOCATION, HeaderValue::from_static(INDEX.links.page))])
                .into_response()
        }
        false => ([vary], Json(INDEX)).into_response(),
    }
}
