//! State of one connection: what it waits for, since when, and how fast its client takes bytes.
//!
//! The stream, the service and the readers of bodies report here; the reaper decides. The rate counts only while the
//! client is waited for: a response that is produced slowly is not the client's fault.

use std::net::IpAddr;
use std::sync::{Mutex, MutexGuard, OnceLock};
use std::time::{Duration, Instant};

use tokio::sync::Notify;

/// Limits of time and rate.
#[derive(Clone, Copy, Debug)]
pub struct TimeLimits {
    /// From the first byte of a request, or from the connection, to the end of the header.
    pub header: Duration,
    /// From the end of a response to the next request.
    pub keep_alive: Duration,
    /// Waiting time over which the rate is measured.
    pub rate_window: Duration,
    /// A client that takes fewer bytes per second of waiting is too slow.
    pub min_bytes_per_s: u64,
}

/// Reason why the server closes a connection.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CloseReason {
    HeaderTimeout,
    KeepAliveTimeout,
    SlowReader,
    /// Another connection needed its slot.
    GaveWay,
}

impl CloseReason {
    pub fn as_str(self) -> &'static str {
        match self {
            Self::HeaderTimeout => "header_timeout",
            Self::KeepAliveTimeout => "keep_alive_timeout",
            Self::SlowReader => "slow_reader",
            Self::GaveWay => "gave_way",
        }
    }
}

/// Input that is awaited from the client.
#[derive(Clone, Copy, Debug)]
enum Wait {
    Header,
    NextRequest,
    Body,
    /// Nothing: a request is being answered.
    None,
}

#[derive(Debug)]
struct Progress {
    wait: Wait,
    since: Instant,
    /// Since when a write has been waiting for the client.
    blocked_since: Option<Instant>,
    /// Waiting time and bytes of the present rate window.
    blocked: Duration,
    sent_bytes: u64,
}

/// A connection, shared by its task, its stream, the handlers of its requests and the reaper.
#[derive(Debug)]
pub struct Connection {
    pub peer: IpAddr,
    /// The server's own address that the client connected to.
    pub local: Option<IpAddr>,
    progress: Mutex<Progress>,
    reason: OnceLock<CloseReason>,
    close: Notify,
}

impl Connection {
    pub fn new(peer: IpAddr, local: Option<IpAddr>, now: Instant) -> Self {
        let progress = Progress {
            wait: Wait::Header,
            since: now,
            blocked_since: None,
            blocked: Duration::ZERO,
            sent_bytes: 0,
        };
        Self { peer, local, progress: progress.into(), reason: OnceLock::new(), close: Notify::new() }
    }

    /// Bytes have arrived: those of a next request start the time of its header.
    pub fn received(&self) {
        let mut progress = self.lock();
        if matches!(progress.wait, Wait::NextRequest) {
            progress.wait_for(Wait::Header);
        }
    }

    /// The header is complete.
    pub fn begin_request(&self) {
        self.lock().wait_for(Wait::None);
    }

    /// The response has been produced.
    pub fn end_request(&self) {
        self.lock().wait_for(Wait::NextRequest);
    }

    /// A handler waits for more of the body, or has it.
    pub fn await_body(&self, waits: bool) {
        self.lock().wait_for(if waits { Wait::Body } else { Wait::None });
    }

    /// A write waits until the client has taken bytes.
    pub fn block(&self) {
        let mut progress = self.lock();
        if progress.blocked_since.is_none() {
            progress.blocked_since = Some(Instant::now());
            if progress.blocked == Duration::ZERO {
                // What went into free buffers says nothing about the client.
                progress.sent_bytes = 0;
            }
        }
    }

    /// The client's side took bytes.
    pub fn sent(&self, bytes: usize) {
        let mut progress = self.lock();
        progress.sent_bytes += bytes as u64;
        if let Some(since) = progress.blocked_since.take() {
            progress.blocked += since.elapsed();
        }
    }

    /// Limit that the connection exceeds, if any.
    pub fn overdue(&self, limits: &TimeLimits, now: Instant) -> Option<CloseReason> {
        let mut progress = self.lock();
        let waited = now.saturating_duration_since(progress.since);
        match progress.wait {
            Wait::Header if waited >= limits.header => return Some(CloseReason::HeaderTimeout),
            Wait::NextRequest if waited >= limits.keep_alive && progress.blocked_since.is_none() => {
                return Some(CloseReason::KeepAliveTimeout);
            }
            _ => {}
        }
        let waiting = progress.blocked_since.map(|since| now.saturating_duration_since(since));
        let blocked = progress.blocked + waiting.unwrap_or_default();
        if blocked < limits.rate_window {
            return None;
        }
        if (progress.sent_bytes as f64) < limits.min_bytes_per_s as f64 * blocked.as_secs_f64() {
            return Some(CloseReason::SlowReader);
        }
        (progress.blocked, progress.sent_bytes) = (Duration::ZERO, 0);
        progress.blocked_since = progress.blocked_since.map(|_| now);
        None
    }

    /// Time for which the client has been waited for; `None` while the server itself is at work.
    pub fn waited(&self, now: Instant) -> Option<Duration> {
        let progress = self.lock();
        let since = match progress.wait {
            Wait::None => progress.blocked_since?,
            _ => progress.blocked_since.unwrap_or(progress.since),
        };
        Some(now.saturating_duration_since(since))
    }

    /// Whether the connection carries no request.
    pub fn is_idle(&self) -> bool {
        let progress = self.lock();
        matches!(progress.wait, Wait::NextRequest) && progress.blocked_since.is_none()
    }

    /// Asks the connection's task to close it; the first reason stays.
    pub fn close(&self, reason: CloseReason) {
        if self.reason.set(reason).is_ok() {
            self.close.notify_one();
        }
    }

    /// Returns when the connection is to be closed.
    pub async fn closed(&self) -> CloseReason {
        loop {
            if let Some(reason) = self.reason.get() {
                return *reason;
            }
            self.close.notified().await;
        }
    }

    /// Whether bytes that the client has not taken are to be discarded when the connection closes.
    pub fn discards_unsent(&self) -> bool {
        self.reason.get().is_some() && self.lock().blocked_since.is_some()
    }

    fn lock(&self) -> MutexGuard<'_, Progress> {
        self.progress.lock().expect("no code panics while it holds this lock")
    }
}

impl Progress {
    fn wait_for(&mut self, wait: Wait) {
        self.wait = wait;
        self.since = Instant::now();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LIMITS: TimeLimits = TimeLimits {
        header: Duration::from_secs(10),
        keep_alive: Duration::from_secs(60),
        rate_window: Duration::from_secs(20),
        min_bytes_per_s: 1000,
    };

    fn connection() -> (Connection, Instant) {
        let now = Instant::now();
        (Connection::new([127, 0, 0, 1].into(), None, now), now)
    }

    #[test]
    fn header_and_next_request_have_their_own_limits() {
        let (connection, start) = connection();
        let after = |secs| start + Duration::from_secs(secs);
        assert_eq!(connection.overdue(&LIMITS, after(9)), None);
        assert_eq!(connection.overdue(&LIMITS, after(10)), Some(CloseReason::HeaderTimeout));
        connection.begin_request();
        assert_eq!(connection.overdue(&LIMITS, after(3600)), None, "the server is at work");
        assert_eq!(connection.waited(after(3600)), None);
        connection.end_request();
        assert!(connection.is_idle());
        assert_eq!(connection.overdue(&LIMITS, after(50)), None);
        assert_eq!(connection.overdue(&LIMITS, after(61)), Some(CloseReason::KeepAliveTimeout));
        connection.received();
        assert_eq!(connection.overdue(&LIMITS, after(11)), Some(CloseReason::HeaderTimeout));
    }

    #[test]
    fn only_waiting_time_counts_for_the_rate() {
        let (connection, start) = connection();
        let after = |secs| start + Duration::from_secs(secs);
        connection.begin_request();
        assert_eq!(connection.overdue(&LIMITS, after(1000)), None, "nothing waits for the client");
        connection.sent(1_000_000);
        connection.block();
        assert_eq!(connection.overdue(&LIMITS, after(19)), None);
        assert_eq!(connection.overdue(&LIMITS, after(21)), Some(CloseReason::SlowReader));
        assert!(connection.waited(after(21)).is_some_and(|waited| waited >= Duration::from_secs(20)));
        connection.sent(30_000);
        connection.block();
        assert_eq!(connection.overdue(&LIMITS, after(25)), None, "30,000 bytes in 25 s are enough");
        assert_eq!(connection.overdue(&LIMITS, after(44)), None, "a new window has begun");
        assert_eq!(connection.overdue(&LIMITS, after(46)), Some(CloseReason::SlowReader));
    }

    #[tokio::test]
    async fn the_first_reason_to_close_stays() {
        let (connection, _) = connection();
        connection.close(CloseReason::SlowReader);
        connection.close(CloseReason::GaveWay);
        assert_eq!(connection.closed().await, CloseReason::SlowReader);
        assert!(!connection.discards_unsent());
        connection.block();
        assert!(connection.discards_unsent());
    }
}
