//! Counts of events in the present minute, in all and per client address.

use std::collections::BTreeMap;
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

use super::serve::client_address::ClientAddress;

const MINUTE: Duration = Duration::from_secs(60);

/// Limits of events, and the counts of a minute.
#[derive(Debug)]
pub struct MinuteCounts {
    total: u32,
    per_client: u32,
    minute: Mutex<Option<Minute>>,
}

#[derive(Debug)]
struct Minute {
    began: Instant,
    total: u32,
    by_client: BTreeMap<Option<ClientAddress>, u32>,
}

impl MinuteCounts {
    pub fn new(total: u32, per_client: u32) -> Self {
        Self { total, per_client, minute: Mutex::new(None) }
    }

    /// Counts an event of a client, unless it exceeds a limit; whether it was counted.
    pub fn admit(&self, client: Option<ClientAddress>) -> bool {
        self.admit_at(client, Instant::now())
    }

    fn admit_at(&self, client: Option<ClientAddress>, now: Instant) -> bool {
        let mut minute = self.minute.lock().unwrap_or_else(PoisonError::into_inner);
        if minute.as_ref().is_some_and(|minute| now.duration_since(minute.began) >= MINUTE) {
            *minute = None;
        }
        let minute =
            minute.get_or_insert_with(|| Minute { began: now, total: 0, by_client: BTreeMap::new() });
        if minute.total >= self.total {
            return false;
        }
        let of_client = minute.by_client.entry(client).or_default();
        if *of_client >= self.per_client {
            return false;
        }
        *of_client += 1;
        minute.total += 1;
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_minute_has_so_many_events_in_all_and_per_client() {
        let counts = MinuteCounts::new(3, 2);
        let now = Instant::now();
        let admit = |last: u8, now| {
            let client = std::net::IpAddr::from([192, 0, 2, last]);
            counts.admit_at(Some(client.into()), now)
        };
        assert!(admit(1, now) && admit(1, now));
        assert!(!admit(1, now));
        assert!(admit(2, now));
        assert!(!admit(3, now));
        let later = now + MINUTE;
        assert!(admit(1, later) && admit(3, later));
    }
}
