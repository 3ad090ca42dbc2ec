//! Counts of open event streams, in all and per client.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, MutexGuard};

use crate::api::serve::client_address::ClientAddress;
use crate::problem::{Problem, ProblemType};

/// The limits and the open streams; clones share them.
#[derive(Clone, Debug)]
pub struct StreamLimits {
    total: usize,
    per_client: usize,
    open: Arc<Mutex<OpenStreams>>,
}

#[derive(Debug, Default)]
struct OpenStreams {
    total: usize,
    by_client: BTreeMap<Option<ClientAddress>, usize>,
}

impl StreamLimits {
    pub fn new(total: usize, per_client: usize) -> Self {
        Self { total, per_client, open: Arc::default() }
    }

    /// A place for a stream of a client; `None` is a client whose address is not known.
    ///
    /// # Errors
    ///
    /// 503 where all streams are open, 429 where all of this client are.
    pub fn admit(&self, client: Option<ClientAddress>) -> Result<StreamSlot, Problem> {
        let mut open = self.lock();
        let of_client = open.by_client.get(&client).copied().unwrap_or_default();
        if of_client >= self.per_client {
            refused("event_streams_per_address");
            let detail = format!(
                "this client has {of_client} event streams, which is the limit; close some, or ask for pages of events"
            );
            return Err(Problem::new(ProblemType::TooManyRequests, "too_many_streams", detail));
        }
        if open.total >= self.total {
            refused("event_streams");
            let detail =
                "the server has as many event streams as it may have; ask for pages of events, or come back";
            return Err(Problem::new(ProblemType::Unavailable, "overloaded", detail));
        }
        open.total += 1;
        *open.by_client.entry(client).or_default() += 1;
        open.report();
        Ok(StreamSlot { client, limits: self.clone() })
    }

    fn lock(&self) -> MutexGuard<'_, OpenStreams> {
        self.open.lock().expect("no code panics while it holds this lock")
    }
}

fn refused(reason: &'static str) {
    metrics::counter!("tabletopgen_requests_refused_total", "reason" => reason).increment(1);
}

impl OpenStreams {
    fn report(&self) {
        metrics::gauge!("tabletopgen_event_streams").set(self.total as f64);
    }
}

/// The place of one stream; dropping it frees the place.
#[derive(Debug)]
pub struct StreamSlot {
    client: Option<ClientAddress>,
    limits: StreamLimits,
}

impl Drop for StreamSlot {
    fn drop(&mut self) {
        let mut open = self.limits.lock();
        open.total -= 1;
        if let Some(count) = open.by_client.get_mut(&self.client) {
            *count -= 1;
            if *count == 0 {
                open.by_client.remove(&self.client);
            }
        }
        open.report();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn streams_are_limited_in_all_and_per_client() {
        let limits = StreamLimits::new(3, 2);
        let client = |last: u8| Some(ClientAddress::from(std::net::IpAddr::from([192, 0, 2, last])));
        let code = |last| limits.admit(client(last)).err().map(|problem| problem.own_code());
        let first = limits.admit(client(1)).expect("a place");
        let _second = limits.admit(client(1)).expect("a place");
        assert_eq!(code(1), Some("too_many_streams"));
        let _third = limits.admit(client(2)).expect("a place");
        assert_eq!(code(3), Some("overloaded"));
        drop(first);
        assert_eq!(code(3), None);
        assert_eq!(limits.lock().by_client.len(), 2);
    }
}
