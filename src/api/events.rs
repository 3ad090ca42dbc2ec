//! `/jobs/{job_id}/events`: what happened, as a JSON page or as server-sent events.
//!
//! Events are rows numbered within their job. A stream is nothing but reading rows again whenever the
//! store says that something changed, from the number the client saw last: a reconnect, or a restart of
//! the server, loses nothing and repeats nothing.

use std::convert::Infallible;
use std::time::Duration;

use axum::Json;
use axum::extract::{Path, State};
use axum::http::{HeaderMap, HeaderValue, StatusCode, header};
use axum::response::sse::{Event as SentEvent, KeepAlive, Sse};
use axum::response::{IntoResponse, Response};
use futures::Stream;
use serde::Deserialize;
use serde_json::json;
use tokio::sync::mpsc;
use tokio_stream::wrappers::ReceiverStream;

use super::Api;
use super::error::{Problem, ProblemType};
use super::jobs::{find, parse_id};
use super::query::{PageSize, Parameters, Sequence};
use super::views::EventView;
use scene::JobId;
use store::events::Event;
use store::{DEFAULT_TENANT, StoreError};

/// Parameters of `GET /jobs/{job_id}/events`.
#[derive(Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct EventParameters {
    /// Only later events.
    after: Sequence,
    page_size: PageSize,
}

/// `GET /jobs/{job_id}/events`.
pub async fn list(
    State(api): State<Api>,
    Path(job_id): Path<String>,
    Parameters(parameters): Parameters<EventParameters>,
    headers: HeaderMap,
) -> Result<Response, Problem> {
    let (after, size) = (parameters.after.0, parameters.page_size.get());
    let job_id = parse_id(&job_id)?;
    let job = find(&api, &job_id).await?;
    if !wants_stream(&headers) {
        let events = api.store.events(&DEFAULT_TENANT, &job_id, after, size).await?;
        let next = events.last().map_or(after, |event| event.seq);
        let views: Vec<EventView> = events.into_iter().map(EventView::new).collect();
        return Ok(Json(json!({ "events": views, "next_after": next })).into_response());
    }
    let seen = match headers.get("last-event-id") {
        None => after,
        Some(id) => {
            let id = id.to_str().ok().and_then(|id| Sequence::try_from(id.to_owned()).ok());
            let Sequence(seen) = id.ok_or_else(|| {
                let detail = "Last-Event-ID must be the id of an event of this stream";
                Problem::new(ProblemType::MalformedRequest, "invalid_last_event_id", detail)
            })?;
            seen
        }
    };
    if job.state.is_final() && api.store.events(&DEFAULT_TENANT, &job_id, seen, 1).await?.is_empty() {
        // Tells an EventSource that there is nothing to come back for.
        return Ok(StatusCode::NO_CONTENT.into_response());
    }
    let keep_alive = KeepAlive::new().interval(Duration::from_secs(15)).text("still here");
    let mut response = Sse::new(stream(api, job_id, seen)).keep_alive(keep_alive).into_response();
    let headers = response.headers_mut();
    headers.insert(header::CACHE_CONTROL, HeaderValue::from_static("no-store"));
    headers.insert("x-accel-buffering", HeaderValue::from_static("no"));
    Ok(response)
}

fn wants_stream(headers: &HeaderMap) -> bool {
    let accepted = headers.get_all(header::ACCEPT).into_iter().filter_map(|value| value.to_str().ok());
    accepted.flat_map(|value| value.split(',')).any(|kind| kind.trim().starts_with("text/event-stream"))
}

/// Every event after `seen`, until the job has ended, the client has gone or the process is to end.
fn stream(api: Api, job_id: JobId, seen: i64) -> impl Stream<Item = Result<SentEvent, Infallible>> {
    let (sender, receiver) = mpsc::channel(64);
    tokio::spawn(async move {
        tokio::select! {
            () = sender.closed() => {}
            () = api.shutdown.cancelled() => {}
            result = follow(&api, &job_id, seen, &sender) => {
                if let Err(error) = result {
                    tracing::error!(%error, %job_id, "an event stream broke off; the client will come back");
                }
            }
        }
    });
    ReceiverStream::new(receiver)
}

async fn follow(
    api: &Api,
    job_id: &JobId,
    mut seen: i64,
    sender: &mpsc::Sender<Result<SentEvent, Infallible>>,
) -> Result<(), StoreError> {
    let mut changes = api.store.changes();
    loop {
        changes.mark_unchanged();
        // The state first: when it is final, the events read after it are all there will be.
        let job = api.store.job(&DEFAULT_TENANT, job_id).await?;
        let ended = job.is_none_or(|job| job.state.is_final());
        let events = api.store.events(&DEFAULT_TENANT, job_id, seen, 100).await?;
        let nothing_new = events.is_empty();
        for event in events {
            seen = event.seq;
            if sender.send(Ok(sent(event))).await.is_err() {
                return Ok(());
            }
        }
        if nothing_new {
            if ended {
                return Ok(());
            }
            // The timeout covers a change whose announcement did not reach this process.
            let _ = tokio::time::timeout(Duration::from_secs(5), changes.changed()).await;
        }
    }
}

fn sent(event: Event) -> SentEvent {
    let (id, kind) = (event.seq.to_string(), event.kind.clone());
    let data = json!(EventView::new(event)).to_string();
    SentEvent::default().id(id).event(kind).retry(Duration::from_secs(2)).data(data)
}
