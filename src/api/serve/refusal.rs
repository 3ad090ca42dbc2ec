//! The answer to a connection that got no slot: 503 with `Retry-After`, without reading its request.

use std::sync::Arc;
use std::time::Duration;

use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::TcpStream;
use tokio::sync::Semaphore;
use uuid::Uuid;

use super::connections::Full;
use crate::problem::{Problem, ProblemType};

/// Refusals that are being sent; beyond, connections are closed without an answer.
const MAX_AT_ONCE: usize = 64;

/// Longest time to send one. The client's request is read and discarded, or closing would destroy the answer.
const MAX_DURATION: Duration = Duration::from_secs(1);

/// Sends refusals, a bounded number at a time.
pub struct Refusals(Arc<Semaphore>);

impl Default for Refusals {
    fn default() -> Self {
        Self(Arc::new(Semaphore::new(MAX_AT_ONCE)))
    }
}

impl Refusals {
    /// Answers and closes a connection, in a task of its own.
    pub fn send(&self, stream: TcpStream, full: Full) {
        metrics::counter!("tabletopgen_requests_refused_total", "reason" => full.as_str()).increment(1);
        let Ok(permit) = self.0.clone().try_acquire_owned() else { return };
        tokio::spawn(async move {
            let _permit = permit;
            let _ = tokio::time::timeout(MAX_DURATION, answer(stream, full)).await;
        });
    }
}

async fn answer(mut stream: TcpStream, full: Full) -> std::io::Result<()> {
    stream.write_all(message(full).as_bytes()).await?;
    stream.shutdown().await?;
    let mut discarded = [0; 4096];
    while stream.read(&mut discarded).await? > 0 {}
    Ok(())
}

fn message(full: Full) -> String {
    let (code, detail) = match full {
        Full::Server => ("overloaded", "every connection of the server is in use; try again in a second"),
        Full::Client => (
            "too_many_connections",
            "this client has as many connections as it may have; close some, or reuse one for several requests",
        ),
    };
    let id = Uuid::now_v7().to_string();
    let body = Problem::new(ProblemType::Unavailable, code, detail).document(&id).to_string();
    format!(
        "HTTP/1.1 503 Service Unavailable\r\nretry-after: 1\r\ncontent-type: application/problem+json\r\n\
         x-request-id: {id}\r\ncontent-length: {}\r\nconnection: close\r\n\r\n{body}",
        body.len()
    )
}
