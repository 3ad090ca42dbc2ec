//! All open connections: how many there may be, in all and per client, and which one gives way.

use std::collections::BTreeMap;
use std::net::IpAddr;
use std::sync::{Arc, Mutex, MutexGuard};
use std::time::{Duration, Instant};

use super::client_address::{ClientAddress, Proxies};
use super::connection::{CloseReason, Connection, TimeLimits};
use super::open_files;
use super::refusal::Refusals;
use crate::api::Settings;

/// A client that sends or takes bytes is never waited for longer than this, and keeps its slot.
const MIN_WAIT_TO_GIVE_WAY: Duration = Duration::from_millis(250);

/// Limits of the listener.
#[derive(Clone, Copy, Debug)]
pub struct Limits {
    pub total: usize,
    /// Per client; proxies are exempt.
    pub per_client: usize,
    pub time: TimeLimits,
}

impl Limits {
    /// The settings, within what the open files of the process allow.
    pub fn new(settings: &Settings) -> Self {
        let allowed = open_files::connections_within(open_files::raise());
        if allowed < settings.max_connections {
            tracing::warn!(
                wanted = settings.max_connections,
                allowed,
                "the limit of open files allows fewer connections than server.max_connections; raise it (ulimit -n)"
            );
        }
        let seconds = Duration::from_secs;
        Self {
            total: settings.max_connections.min(allowed).max(1),
            per_client: settings.max_connections_per_address.max(1),
            time: TimeLimits {
                header: seconds(settings.header_timeout_secs.max(1)),
                keep_alive: seconds(settings.keep_alive_timeout_secs.max(1)),
                rate_window: seconds(settings.rate_window_secs.max(1)),
                min_bytes_per_s: settings.min_rate_bytes_per_s,
            },
        }
    }
}

/// Reason why a connection got no slot.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Full {
    Server,
    Client,
}

impl Full {
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Server => "connections",
            Self::Client => "connections_per_address",
        }
    }
}

#[derive(Default)]
struct Open {
    by_id: BTreeMap<u64, Arc<Connection>>,
    by_client: BTreeMap<ClientAddress, usize>,
    next_id: u64,
}

/// The open connections.
pub struct Connections {
    limits: Limits,
    proxies: Proxies,
    open: Mutex<Open>,
    refusals: Refusals,
}

impl Connections {
    pub fn new(settings: &Settings) -> Self {
        Self {
            limits: Limits::new(settings),
            proxies: Proxies::new(&settings.proxy_addresses),
            open: Mutex::default(),
            refusals: Refusals::default(),
        }
    }

    pub fn limits(&self) -> &Limits {
        &self.limits
    }

    pub(super) fn refusals(&self) -> &Refusals {
        &self.refusals
    }

    /// A slot for a new connection. Where none is free, a connection that waits for its peer gives way.
    ///
    /// # Errors
    ///
    /// [`Full`] where every connection, or every connection of this client, is at work.
    pub fn admit(self: &Arc<Self>, peer: IpAddr, local: Option<IpAddr>, now: Instant) -> Result<Slot, Full> {
        let client = ClientAddress::from(peer);
        let mut open = self.lock();
        let of_client = open.by_client.get(&client).copied().unwrap_or_default();
        if of_client >= self.limits.per_client && !self.proxies.contains(peer) {
            if !open.evict(Some(client), now) {
                return Err(Full::Client);
            }
        } else if open.by_id.len() >= self.limits.total && !open.evict(None, now) {
            return Err(Full::Server);
        }
        let connection = Arc::new(Connection::new(peer, local, now));
        let id = open.next_id;
        open.next_id += 1;
        open.by_id.insert(id, connection.clone());
        *open.by_client.entry(client).or_default() += 1;
        open.report();
        Ok(Slot { id, connection, connections: self.clone() })
    }

    /// Closes the connection that has waited longest; whether there was one.
    pub fn make_room(&self, now: Instant) -> bool {
        self.lock().evict(None, now)
    }

    /// Closes every connection that exceeds a limit.
    pub fn inspect(&self, now: Instant) {
        for connection in self.lock().by_id.values() {
            if let Some(reason) = connection.overdue(&self.limits.time, now) {
                connection.close(reason);
            }
        }
    }

    fn lock(&self) -> MutexGuard<'_, Open> {
        self.open.lock().expect("no code panics while it holds this lock")
    }
}

impl Open {
    /// Closes a connection, of this client or of any, that waits for its peer. Among several, one of the client with
    /// the largest number of connections is closed, and of these the one that has waited longest.
    fn evict(&mut self, client: Option<ClientAddress>, now: Instant) -> bool {
        let rank = |connection: &Arc<Connection>| {
            let waited = connection.waited(now)?;
            let may_go = connection.is_idle() || waited >= MIN_WAIT_TO_GIVE_WAY;
            let client = ClientAddress::from(connection.peer);
            may_go.then(|| (self.by_client.get(&client).copied().unwrap_or_default(), waited))
        };
        let candidates = self
            .by_id
            .iter()
            .filter(|(_, c)| client.is_none_or(|client| client == ClientAddress::from(c.peer)));
        let ranked = candidates.filter_map(|(id, connection)| Some((rank(connection)?, *id)));
        let Some((_, id)) = ranked.max() else { return false };
        if let Some(connection) = self.remove(id) {
            connection.close(CloseReason::GaveWay);
        }
        true
    }

    fn remove(&mut self, id: u64) -> Option<Arc<Connection>> {
        let connection = self.by_id.remove(&id)?;
        let client = ClientAddress::from(connection.peer);
        if let Some(count) = self.by_client.get_mut(&client) {
            *count -= 1;
            if *count == 0 {
                self.by_client.remove(&client);
            }
        }
        self.report();
        Some(connection)
    }

    fn report(&self) {
        metrics::gauge!("tabletopgen_connections").set(self.by_id.len() as f64);
    }
}

/// The place of one connection; dropping it frees the place.
pub struct Slot {
    id: u64,
    connection: Arc<Connection>,
    connections: Arc<Connections>,
}

impl Slot {
    pub fn connection(&self) -> &Arc<Connection> {
        &self.connection
    }
}

impl Drop for Slot {
    fn drop(&mut self) {
        self.connections.lock().remove(self.id);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn connections(total: usize, per_client: usize) -> Arc<Connections> {
        let seconds = Duration::from_secs;
        let time = TimeLimits {
            header: seconds(10),
            keep_alive: seconds(60),
            rate_window: seconds(10),
            min_bytes_per_s: 1000,
        };
        Arc::new(Connections {
            limits: Limits { total, per_client, time },
            proxies: Proxies::new("10.0.0.9"),
            open: Mutex::default(),
            refusals: Refusals::default(),
        })
    }

    const ONE: IpAddr = IpAddr::V4(std::net::Ipv4Addr::new(192, 0, 2, 1));
    const OTHER: IpAddr = IpAddr::V4(std::net::Ipv4Addr::new(192, 0, 2, 2));
    const PROXY: IpAddr = IpAddr::V4(std::net::Ipv4Addr::new(10, 0, 0, 9));

    #[tokio::test]
    async fn the_connection_that_waits_longest_gives_way_and_one_at_work_does_not() {
        let (connections, start) = (connections(2, 10), Instant::now());
        let busy = connections.admit(ONE, None, start).expect("a slot");
        busy.connection().begin_request();
        let stalled = connections.admit(ONE, None, start).expect("a slot");
        assert_eq!(connections.admit(OTHER, None, start).err(), Some(Full::Server), "it has just connected");
        let later = start + Duration::from_secs(1);
        let new = connections.admit(OTHER, None, later).expect("the stalled one gives way");
        assert_eq!(stalled.connection().closed().await, CloseReason::GaveWay);
        new.connection().begin_request();
        assert_eq!(connections.admit(OTHER, None, later).err(), Some(Full::Server));
        drop(stalled);
        assert_eq!(connections.admit(OTHER, None, later).err(), Some(Full::Server), "it left before");
        drop(busy);
        assert!(connections.admit(OTHER, None, later).is_ok());
    }

    #[tokio::test]
    async fn the_client_with_many_connections_gives_way_first() {
        let (connections, start) = (connections(3, 10), Instant::now());
        let alone = connections.admit(OTHER, None, start).expect("a slot");
        let many: Vec<Slot> = (0..2).map(|_| connections.admit(ONE, None, start).expect("a slot")).collect();
        let later = start + Duration::from_secs(1);
        let _new = connections.admit(OTHER, None, later).expect("a slot");
        assert_eq!(many[1].connection().closed().await, CloseReason::GaveWay);
        assert!(alone.connection().waited(later).is_some());
        assert_eq!(connections.lock().by_client.get(&ClientAddress::from(OTHER)), Some(&2));
    }

    #[test]
    fn one_client_has_its_own_limit_and_a_proxy_has_none() {
        let (connections, start) = (connections(10, 2), Instant::now());
        let admit = |peer| connections.admit(peer, None, start);
        let _held: Vec<Slot> = (0..2).map(|_| admit(ONE).expect("a slot")).collect();
        assert_eq!(admit(ONE).err(), Some(Full::Client));
        assert!(admit(OTHER).is_ok());
        let _proxied: Vec<Slot> = (0..4).map(|_| admit(PROXY).expect("a slot")).collect();
    }

    #[tokio::test]
    async fn an_inspection_closes_what_is_overdue() {
        let (connections, start) = (connections(10, 10), Instant::now());
        let slow = connections.admit(ONE, None, start).expect("a slot");
        connections.inspect(start + Duration::from_secs(11));
        assert_eq!(slow.connection().closed().await, CloseReason::HeaderTimeout);
    }
}
