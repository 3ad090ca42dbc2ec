//! Settings of authentication: which credentials clients need, and what proxies may say of them.

use serde::{Deserialize, Serialize};

/// Section `[server.authentication]`.
#[derive(Clone, Debug, Serialize, Deserialize, PartialEq)]
#[serde(deny_unknown_fields)]
pub struct Settings {
    /// Whether clients need a credential.
    pub mode: Mode,
    /// Longest time of a session of a browser, seconds.
    pub session_secs: u64,
    /// Logins of one client address in a minute; more are refused.
    pub logins_per_minute: u32,
    /// Header in which a proxy names the user; empty where no proxy authenticates.
    pub proxy_user_header: String,
    /// Header in which a proxy names the tenant; empty = all users are of the tenant `default`.
    pub proxy_tenant_header: String,
    /// Header in which a proxy names scopes among other words; empty = all users have the usual ones.
    pub proxy_scopes_header: String,
    /// Scopes of users without that header.
    pub proxy_usual_scopes: String,
}

/// Credentials that clients need.
#[derive(Clone, Copy, Debug, Serialize, Deserialize, PartialEq, Eq)]
#[serde(rename_all = "snake_case")]
pub enum Mode {
    /// None: every client is the tenant `default`, with all scopes.
    None,
    /// A key, a session, or the word of a proxy.
    Keys,
}
