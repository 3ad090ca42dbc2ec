//! The listener: HTTP/1.1 within limits of time, rate and number, and a shutdown that lets answers finish.
//!
//! [`connections`] counts connections, in all and per client address. A reaper closes those that exceed a time limit
//! or transfer too slowly ([`connection`]). Where every slot is taken, the connection that has waited longest for its
//! peer gives way; where none waits, the new one is answered with 503 ([`refusal`]).

pub mod client_address;
pub mod connection;
pub mod connections;
pub mod open_files;
mod refusal;
mod watched_stream;

use std::convert::Infallible;
use std::pin::Pin;
use std::sync::Arc;
use std::task::{Context, Poll};
use std::time::{Duration, Instant};

use axum::Router;
use axum::body::{Body, HttpBody};
use axum::http::{Request, Response};
use bytes::Bytes;
use futures::future::BoxFuture;
use hyper::body::{Frame, Incoming, SizeHint};
use hyper::server::conn::http1;
use hyper::service::Service;
use hyper_util::rt::TokioIo;
use hyper_util::server::graceful::GracefulShutdown;
use hyper_util::service::TowerToHyperService;
use tokio::net::{TcpListener, TcpStream};
use tokio_util::sync::CancellationToken;

use super::Settings;
use connection::Connection;
use connections::{Connections, Slot};
use watched_stream::WatchedStream;

/// Pause between two inspections of all connections; limits hold to within this.
const INSPECTION_PERIOD: Duration = Duration::from_millis(200);

/// Bytes that the kernel holds unsent per connection. More would hide from the server that a client does not read.
const MAX_UNSENT_BYTES: u32 = 64 << 10;

/// Bytes of a header, or of a body between two reads, that a connection buffers.
const MAX_BUFFER_BYTES: usize = 32 << 10;

/// Serves until `shutdown`, then waits for the requests that are being answered.
pub async fn serve(listener: TcpListener, router: Router, settings: &Settings, shutdown: CancellationToken) {
    let connections = Arc::new(Connections::new(settings));
    tracing::info!(
        connections = connections.limits().total,
        open_files = open_files::raise(),
        "limits of the listener"
    );
    let mut builder = http1::Builder::new();
    // The reaper has the timers, so that the wait for the next request has a limit of its own.
    builder.header_read_timeout(None::<Duration>).max_buf_size(MAX_BUFFER_BYTES);
    let graceful = GracefulShutdown::new();
    let reaper = tokio::spawn(reap(connections.clone()));
    loop {
        let accepted = tokio::select! {
            () = shutdown.cancelled() => break,
            accepted = accept(&listener, &connections) => accepted,
        };
        let Some((stream, slot)) = accepted else { continue };
        let connection = slot.connection().clone();
        let service = ConnectionService { router: router.clone(), connection: connection.clone() };
        let stream = TokioIo::new(WatchedStream::new(stream, connection.clone()));
        let served = graceful.watch(builder.serve_connection(stream, service));
        tokio::spawn(async move {
            let _slot = slot;
            tokio::select! {
                ended = served => {
                    if let Err(error) = ended {
                        tracing::debug!(%error, "a connection ended early");
                    }
                }
                reason = connection.closed() => {
                    let reason = reason.as_str();
                    tracing::debug!(reason, "a connection was closed");
                    metrics::counter!("tabletopgen_connections_closed_total", "reason" => reason).increment(1);
                }
            }
        });
    }
    drop(listener);
    let grace = Duration::from_secs(settings.shutdown_grace_secs);
    if tokio::time::timeout(grace, graceful.shutdown()).await.is_err() {
        tracing::warn!("some requests were still being answered at shutdown");
    }
    reaper.abort();
}

/// The next connection and its slot; `None` when there is no slot, or accepting failed this time.
async fn accept(listener: &TcpListener, connections: &Arc<Connections>) -> Option<(TcpStream, Slot)> {
    let (stream, peer) = match listener.accept().await {
        Ok(accepted) => accepted,
        Err(error) => {
            // Mostly out of file descriptors: a connection without work gives one back.
            tracing::warn!(%error, "cannot accept a connection");
            connections.make_room(Instant::now());
            tokio::time::sleep(Duration::from_millis(100)).await;
            return None;
        }
    };
    // Small answers should not wait for more.
    let _ = stream.set_nodelay(true);
    #[cfg(target_os = "linux")]
    let _ = socket2::SockRef::from(&stream).set_tcp_notsent_lowat(MAX_UNSENT_BYTES);
    let local = stream.local_addr().ok().map(|address| address.ip());
    match connections.admit(peer.ip(), local, Instant::now()) {
        Ok(slot) => Some((stream, slot)),
        Err(full) => {
            connections.refusals().send(stream, full);
            None
        }
    }
}

/// Closes connections that exceed a limit.
async fn reap(connections: Arc<Connections>) {
    let mut ticks = tokio::time::interval(INSPECTION_PERIOD);
    ticks.set_missed_tick_behavior(tokio::time::MissedTickBehavior::Delay);
    loop {
        ticks.tick().await;
        connections.inspect(Instant::now());
    }
}

/// The routes for the requests of one connection, which learns when it serves one.
struct ConnectionService {
    router: Router,
    connection: Arc<Connection>,
}

impl Service<Request<Incoming>> for ConnectionService {
    type Response = Response<TrackedBody>;
    type Error = Infallible;
    type Future = BoxFuture<'static, Result<Self::Response, Infallible>>;

    fn call(&self, mut request: Request<Incoming>) -> Self::Future {
        self.connection.begin_request();
        let end = RequestEnd(self.connection.clone());
        request.extensions_mut().insert(self.connection.clone());
        let response = TowerToHyperService::new(self.router.clone()).call(request);
        Box::pin(async move { Ok(response.await?.map(|body| TrackedBody { body, _end: end })) })
    }
}

/// Dropped when the response has been produced, or its connection is gone.
struct RequestEnd(Arc<Connection>);

impl Drop for RequestEnd {
    fn drop(&mut self) {
        self.0.end_request();
    }
}

/// The body of a response.
struct TrackedBody {
    body: Body,
    _end: RequestEnd,
}

impl HttpBody for TrackedBody {
    type Data = Bytes;
    type Error = axum::Error;

    fn poll_frame(
        mut self: Pin<&mut Self>,
        context: &mut Context<'_>,
    ) -> Poll<Option<Result<Frame<Bytes>, axum::Error>>> {
        Pin::new(&mut self.body).poll_frame(context)
    }

    fn is_end_stream(&self) -> bool {
        self.body.is_end_stream()
    }

    fn size_hint(&self) -> SizeHint {
        self.body.size_hint()
    }
}
