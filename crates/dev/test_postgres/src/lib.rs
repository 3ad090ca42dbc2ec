//! A private PostgreSQL server for the tests of one process.
//!
//! The first call of [`database`] starts a server from installed programs, on a free port of the loopback interface, as
//! an unprivileged user, in a temporary directory; it stops and is removed when the test process ends, however it ends.
//! `TABLETOPGEN_TEST_POSTGRES_URL` names a running server instead, `TABLETOPGEN_POSTGRES_BIN` the directory of other
//! programs than those on the path and in `/usr/lib/postgresql`.
//!
//! The crate must not be a dependency of anything but tests.
//!
//! ```no_run
//! # async fn example() {
//! let url = test_postgres::database().await;
//! assert!(url.starts_with("postgres://"));
//! # }
//! ```

mod error;
mod programs;
mod server;

use std::sync::OnceLock;

use sqlx::{AssertSqlSafe, Connection, PgConnection};
use uuid::Uuid;

use server::Server;

/// The address of a new, empty database.
///
/// # Panics
///
/// Panics with the reason if there is no server and none can be started.
pub async fn database() -> String {
    static SERVER: OnceLock<String> = OnceLock::new();
    let url = SERVER.get_or_init(|| match std::env::var("TABLETOPGEN_TEST_POSTGRES_URL") {
        Ok(url) => url,
        Err(_) => started().url,
    });
    let name = format!("test_{}", Uuid::new_v4().simple());
    let mut connection = PgConnection::connect(url).await.expect("the test server answers");
    sqlx::raw_sql(AssertSqlSafe(format!("CREATE DATABASE {name}")))
        .execute(&mut connection)
        .await
        .expect("the user of the test server may create databases");
    connection.close().await.expect("the connection closes");
    with_database(url, &name)
}

fn started() -> Server {
    Server::start().unwrap_or_else(|reason| panic!("no PostgreSQL for this test: {reason}"))
}

/// A server that no other test uses, so that it can be frozen.
pub struct OwnServer {
    /// The address of its database.
    pub url: String,
    server: Server,
}

/// A frozen server; dropping it lets the server go on.
pub struct Frozen<'a>(&'a OwnServer);

impl OwnServer {
    /// Starts the server from installed programs; it lives as long as this process.
    ///
    /// # Panics
    ///
    /// Panics with the reason if none can be started.
    pub async fn start() -> Self {
        let server = started();
        Self { url: server.url.clone(), server }
    }

    /// Stops every process of the server (`SIGSTOP`): connections stay open, and nothing answers.
    ///
    /// # Panics
    ///
    /// Panics if the processes are not found.
    pub fn freeze(&self) -> Frozen<'_> {
        self.server.signal("STOP").expect("the server's processes are found");
        Frozen(self)
    }
}

impl Drop for Frozen<'_> {
    fn drop(&mut self) {
        // A server that stays frozen would outlive the test.
        let _ = self.0.server.signal("CONT");
    }
}

/// The address of another database of the same server.
fn with_database(url: &str, name: &str) -> String {
    let (address, options) = match url.split_once('?') {
        Some((address, options)) => (address, format!("?{options}")),
        None => (url, String::new()),
    };
    let (scheme, rest) = address.split_once("://").unwrap_or(("postgres", address));
    let authority = rest.split('/').next().unwrap_or_default();
    format!("{scheme}://{authority}/{name}{options}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn address_of_another_database_keeps_server_and_options() {
        for (url, expected) in [
            ("postgres://u@h:1/old", "postgres://u@h:1/new"),
            ("postgres://u@h:1", "postgres://u@h:1/new"),
            ("postgresql://u@h/old?sslmode=disable", "postgresql://u@h/new?sslmode=disable"),
        ] {
            assert_eq!(with_database(url, "new"), expected);
        }
    }
}
