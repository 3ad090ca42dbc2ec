//! `/jobs/{job_id}/events`, `/episodes/{recording_id}/events` and `/events`: what happened, as a JSON page or as
//! server-sent events.
//!
//! Events are rows numbered within their [`subject`]. A stream is nothing but reading rows again whenever the subject
//! has moved ([`hub`]), from the number the client saw last: a reconnect, or a restart of the server, loses nothing and
//! repeats nothing. A stream therefore ends after a while, so that no client holds a place for ever
//! ([`stream_limits`]).

pub mod content;
pub mod hub;
pub mod stream_limits;
pub mod subject;

use std::collections::VecDeque;
use std::convert::Infallible;
use std::sync::Arc;
use std::time::Duration;

use axum::http::{HeaderMap, HeaderValue, StatusCode, header};
use axum::response::sse::{Event as SentEvent, KeepAlive, Sse};
use axum::response::{IntoResponse, Response};
use axum::{Extension, Json};
use futures::Stream;
use schemars::JsonSchema;
use serde::Deserialize;
use serde_json::{Value, json};
use tokio::time::Instant;

use super::extract::{PathId, TenantApi};
use super::query::{PageSize, Parameters, Sequence};
use super::serve::connection::Connection;
use crate::problem::{Problem, ProblemType};
use hub::Progress;
use scene::{JobId, RecordingId};
use store::StoreError;
use stream_limits::StreamSlot;
use subject::{Subject, TellableEvent};

/// After a broken stream, a client comes back after this long.
const RECONNECT: Duration = Duration::from_secs(2);

/// Parameters of `GET /jobs/{job_id}/events` and `GET /episodes/{recording_id}/events`.
#[derive(Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct EventParameters {
    /// Only events with a larger `seq`.
    after: Sequence,
    page_size: PageSize,
}

/// Parameters of `GET /events`.
#[derive(Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct TenantEventParameters {
    /// Only events with a larger `seq`. Without it, a page begins with the oldest event and a stream with the next one.
    after: Option<Sequence>,
    page_size: PageSize,
}

/// `GET /jobs/{job_id}/events`.
pub async fn of_job(
    api: TenantApi,
    PathId(job_id): PathId<JobId>,
    Parameters(parameters): Parameters<EventParameters>,
    connection: Option<Extension<Arc<Connection>>>,
    headers: HeaderMap,
) -> Result<Response, Problem> {
    answer(api, Subject::Job(job_id), parameters, connection, headers).await
}

/// `GET /episodes/{recording_id}/events`.
pub async fn of_recording(
    api: TenantApi,
    PathId(recording_id): PathId<RecordingId>,
    Parameters(parameters): Parameters<EventParameters>,
    connection: Option<Extension<Arc<Connection>>>,
    headers: HeaderMap,
) -> Result<Response, Problem> {
    let subject = Subject::Recording(recording_id);
    answer(api, subject, parameters, connection, headers).await
}

/// `GET /events`.
pub async fn of_tenant(
    api: TenantApi,
    Parameters(parameters): Parameters<TenantEventParameters>,
    connection: Option<Extension<Arc<Connection>>>,
    headers: HeaderMap,
) -> Result<Response, Problem> {
    let TenantEventParameters { after, page_size } = parameters;
    let is_stream = wants_stream(&headers);
    let is_from_now_on = is_stream && after.is_none() && !headers.contains_key("last-event-id");
    // A page has what was committed before it was asked for; a stream sees to that by itself.
    let last = if is_from_now_on || !is_stream { Subject::Tenant.last_seq(&api).await? } else { 0 };
    let after = after.unwrap_or(Sequence(if is_from_now_on { last } else { 0 }));
    answer(api, Subject::Tenant, EventParameters { after, page_size }, connection, headers).await
}

/// A page of events, or a stream of those to come.
async fn answer(
    api: TenantApi,
    subject: Subject,
    parameters: EventParameters,
    connection: Option<Extension<Arc<Connection>>>,
    headers: HeaderMap,
) -> Result<Response, Problem> {
    let (after, size) = (parameters.after.0, parameters.page_size.get());
    let is_stream = wants_stream(&headers);
    // Of many streams that open at once, a few read their first rows at a time.
    let turn = if is_stream { api.stream_reads.clone().acquire_owned().await.ok() } else { None };
    let has_ended = subject.has_ended(&api).await?;
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
    if !is_stream {
        let events = subject.events(&api, after, size).await?;
        let next = events.last().map_or(after, |event| event.seq);
        let views: Vec<Value> = events.into_iter().map(|event| event.view).collect();
        return Ok(Json(json!({ "events": views, "next_after": next })).into_response());
    }
    if has_ended && subject.events(&api, seen, 1).await?.is_empty() {
        // Tells an EventSource that there is nothing to come back for.
        return Ok(StatusCode::NO_CONTENT.into_response());
    }
    drop(turn);
    let client = connection.map(|Extension(connection)| api.proxies.client(connection.peer, &headers));
    let slot = api.streams.admit(client)?;
    let keep_alive = KeepAlive::new().interval(Duration::from_secs(15)).text("still here");
    let events = EventStream::new(api, subject, seen, slot).into_stream();
    let mut response = Sse::new(events).keep_alive(keep_alive).into_response();
    let headers = response.headers_mut();
    headers.insert(header::CACHE_CONTROL, HeaderValue::from_static("no-store"));
    headers.insert("x-accel-buffering", HeaderValue::from_static("no"));
    // The client of a stream that has ended holds no connection.
    headers.insert(header::CONNECTION, HeaderValue::from_static("close"));
    Ok(response)
}

fn wants_stream(headers: &HeaderMap) -> bool {
    let accepted = headers.get_all(header::ACCEPT).into_iter().filter_map(|value| value.to_str().ok());
    accepted.flat_map(|value| value.split(',')).any(|kind| kind.trim().starts_with("text/event-stream"))
}

/// Every event after the one seen last, until the subject has ended, the client has gone, the stream is too old or the
/// process is to end.
struct EventStream {
    api: TenantApi,
    subject: Subject,
    seen: i64,
    progress: Progress,
    /// Read, and not yet sent.
    events: VecDeque<TellableEvent>,
    ends: Instant,
    /// The client knows a number to come back with.
    has_number: bool,
    has_ended: bool,
    _slot: StreamSlot,
}

impl EventStream {
    fn new(api: TenantApi, subject: Subject, seen: i64, slot: StreamSlot) -> Self {
        let progress = api.hub.follow(&api.tenant_id, &subject);
        let ends = Instant::now() + Duration::from_secs(api.settings.max_event_stream_secs);
        let events = VecDeque::new();
        // A stream of a tenant begins anywhere, and may break before its first event.
        let has_number = subject != Subject::Tenant;
        Self { api, subject, seen, progress, events, ends, has_number, has_ended: false, _slot: slot }
    }

    fn into_stream(self) -> impl Stream<Item = Result<SentEvent, Infallible>> {
        futures::stream::unfold(self, |mut stream| async move {
            match stream.next().await {
                Ok(event) => event.map(|event| (Ok(event), stream)),
                Err(error) => {
                    let subject = &stream.subject;
                    tracing::error!(%error, %subject, "an event stream broke off; the client will come back");
                    None
                }
            }
        })
    }

    async fn next(&mut self) -> Result<Option<SentEvent>, StoreError> {
        if !std::mem::replace(&mut self.has_number, true) {
            let start = SentEvent::default().id(self.seen.to_string()).retry(RECONNECT);
            return Ok(Some(start.comment("what follows is new")));
        }
        loop {
            if let Some(event) = self.events.pop_front() {
                self.seen = event.seq;
                return Ok(Some(sent(event)));
            }
            if self.has_ended {
                return Ok(None);
            }
            let progress = *self.progress.borrow_and_update();
            if progress.is_some_and(|progress| progress.last_seq > self.seen) {
                let _turn = self.api.stream_reads.acquire().await;
                self.events = self.subject.events(&self.api, self.seen, 100).await?.into();
                if !self.events.is_empty() {
                    continue;
                }
            }
            if progress.is_some_and(|progress| progress.is_final) {
                return Ok(None);
            }
            tokio::select! {
                changed = self.progress.changed() => self.has_ended = changed.is_err(),
                () = tokio::time::sleep_until(self.ends) => {
                    let secs = self.api.settings.max_event_stream_secs;
                    return Ok(Some(self.end(&format!("a stream ends after {secs} s"))));
                }
                () = self.api.shutdown.cancelled() => return Ok(Some(self.end("the server is shutting down"))),
            }
        }
    }

    /// The last message of a stream whose subject goes on.
    fn end(&mut self, why: &str) -> SentEvent {
        self.has_ended = true;
        let advice = format!("{why}; reconnect with Last-Event-ID: {}", self.seen);
        SentEvent::default().comment(advice).retry(RECONNECT)
    }
}

fn sent(event: TellableEvent) -> SentEvent {
    let TellableEvent { seq, kind, view } = event;
    SentEvent::default().id(seq.to_string()).event(kind).retry(RECONNECT).data(view.to_string())
}
