//! Users whom a proxy has authenticated, such as one that speaks OpenID Connect: their names, tenants and scopes in
//! headers. They count from the peers of `server.proxy_addresses` alone; from others they are not even read.

use std::net::IpAddr;

use axum::http::{HeaderMap, HeaderName};

use super::authentication::Settings;
use super::serve::client_address::Proxies;
use scene::TenantId;
use store::DEFAULT_TENANT;
use store::scopes::ScopeSet;

/// Longest name of a user, bytes.
const MAX_NAME_BYTES: usize = 200;

/// Headers in which proxies name users.
#[derive(Clone, Debug)]
pub struct ProxyHeaders {
    user: Option<HeaderName>,
    tenant: Option<HeaderName>,
    scopes: Option<HeaderName>,
    usual_scopes: ScopeSet,
}

/// A user whom a proxy names.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ProxyUser {
    pub name: String,
    pub tenant_id: TenantId,
    pub scopes: ScopeSet,
}

/// Headers of a proxy from which no user can be read.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("the proxy in front of this server sent no single valid {0}; its operator has to correct that")]
pub struct InvalidHeader(HeaderName);

impl ProxyHeaders {
    /// The headers of the settings. What is no name or no scope is skipped; the configuration refuses it before.
    pub fn new(settings: &Settings) -> Self {
        let name = |text: &str| text.parse().ok();
        Self {
            user: name(&settings.proxy_user_header),
            tenant: name(&settings.proxy_tenant_header),
            scopes: name(&settings.proxy_scopes_header),
            usual_scopes: ScopeSet::among(&settings.proxy_usual_scopes),
        }
    }

    /// The user of a request; `None` where the peer is no proxy, or the proxy names no user.
    ///
    /// # Errors
    ///
    /// [`InvalidHeader`] where a proxy names several users, an invalid one, or no tenant where it has to.
    pub fn user(
        &self,
        proxies: &Proxies,
        peer: Option<IpAddr>,
        headers: &HeaderMap,
    ) -> Result<Option<ProxyUser>, InvalidHeader> {
        let Some(header) = self.user.as_ref().filter(|_| peer.is_some_and(|peer| proxies.contains(peer)))
        else {
            return Ok(None);
        };
        if !headers.contains_key(header) {
            return Ok(None);
        }
        let name = one(headers, header)?;
        if name.is_empty() || name.len() > MAX_NAME_BYTES {
            return Err(InvalidHeader(header.clone()));
        }
        let tenant_id = match &self.tenant {
            None => DEFAULT_TENANT.clone(),
            Some(header) => one(headers, header)?.parse().map_err(|_| InvalidHeader(header.clone()))?,
        };
        let scopes = match self.scopes.as_ref().filter(|header| headers.contains_key(*header)) {
            None => self.usual_scopes.clone(),
            Some(header) => ScopeSet::among(one(headers, header)?),
        };
        Ok(Some(ProxyUser { name: name.to_owned(), tenant_id, scopes }))
    }
}

/// The only value of a header. Several would mean that the client's own words are among them.
fn one<'a>(headers: &'a HeaderMap, name: &HeaderName) -> Result<&'a str, InvalidHeader> {
    let mut values = headers.get_all(name).into_iter();
    let value = values.next().filter(|_| values.next().is_none()).and_then(|value| value.to_str().ok());
    value.map(str::trim).ok_or_else(|| InvalidHeader(name.clone()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::api::authentication::Mode;

    fn headers(pairs: &[(&'static str, &str)]) -> HeaderMap {
        let mut headers = HeaderMap::new();
        for (name, value) in pairs {
            headers.append(*name, value.parse().expect("a value"));
        }
        headers
    }

    #[test]
    fn a_proxy_names_a_user_with_tenant_and_scopes() {
        let mut settings = Settings {
            mode: Mode::Keys,
            session_secs: 60,
            logins_per_minute: 1,
            proxy_user_header: "X-User".into(),
            proxy_tenant_header: String::new(),
            proxy_scopes_header: "x-groups".into(),
            proxy_usual_scopes: "read submit".into(),
        };
        let proxies = Proxies::new("10.0.0.1");
        let user = |settings: &Settings, peer: &str, pairs: &[(&'static str, &str)]| {
            let peer = peer.parse().ok();
            ProxyHeaders::new(settings).user(&proxies, peer, &headers(pairs))
        };
        let of = |name: &str, tenant: &str, scopes: &str| {
            let (tenant_id, scopes) = (tenant.parse().expect("an id"), ScopeSet::among(scopes));
            Ok(Some(ProxyUser { name: name.into(), tenant_id, scopes }))
        };
        let ann = ("x-user", "ann@example.org");
        assert_eq!(user(&settings, "10.0.0.1", &[ann]), of(ann.1, "default", "read submit"));
        let groups = [ann, ("x-groups", "staff,delete admin")];
        assert_eq!(user(&settings, "10.0.0.1", &groups), of(ann.1, "default", "delete admin"));
        assert_eq!(user(&settings, "10.0.0.1", &[ann, ("x-groups", "staff")]), of(ann.1, "default", ""));
        for stranger in ["10.0.0.2", "127.0.0.1", ""] {
            assert_eq!(user(&settings, stranger, &groups), Ok(None), "{stranger:?}");
        }
        assert_eq!(user(&settings, "10.0.0.1", &[("x-groups", "admin")]), Ok(None));
        for wrong in [&[ann, ("x-user", "root")][..], &[("x-user", "")], &[("x-user", &"a".repeat(201))]] {
            assert!(user(&settings, "10.0.0.1", wrong).is_err(), "{wrong:?}");
        }
        settings.proxy_tenant_header = "x-tenant".into();
        assert_eq!(user(&settings, "10.0.0.1", &[ann, ("x-tenant", "lab")]), of(ann.1, "lab", "read submit"));
        for wrong in [&[ann][..], &[ann, ("x-tenant", "a b")], &[ann, ("x-tenant", "a"), ("x-tenant", "b")]] {
            assert!(user(&settings, "10.0.0.1", wrong).is_err(), "{wrong:?}");
        }
        settings.proxy_user_header = String::new();
        assert_eq!(user(&settings, "10.0.0.1", &[ann]), Ok(None));
    }
}
