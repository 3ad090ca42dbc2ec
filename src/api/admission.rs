//! Admission of requests: those with a `Host` of this server, not from the pages of another site, and not more at once
//! than the server can answer.
//!
//! A page of any site can make a browser send requests to this server, also to one on loopback, and a name that its
//! owner resolves to 127.0.0.1 makes them same-origin (DNS rebinding). Names of the operator and addresses that the
//! connection came in on cannot be rebound. `Sec-Fetch-Site` and `Origin` are set by browsers and not by pages.

use std::collections::BTreeSet;
use std::net::IpAddr;
use std::sync::Arc;

use axum::Router;
use axum::extract::{Request, State};
use axum::http::uri::{Authority, Uri};
use axum::http::{HeaderMap, Method, Version, header};
use axum::middleware::{Next, from_fn_with_state};
use axum::response::{IntoResponse, Response};

use super::Api;
use super::serve::connection::Connection;
use crate::problem::{Problem, ProblemType};

/// Probes are answered under any load: an orchestrator would restart a server that is only busy.
const PROBES: [&str; 4] = ["/healthz", "/readyz", "/metrics", "/version"];

/// Wraps the routes.
pub(super) fn around(router: Router<Api>, api: &Api) -> Router<Api> {
    router.layer(from_fn_with_state(api.clone(), admit))
}

async fn admit(State(api): State<Api>, request: Request, next: Next) -> Response {
    let local = request.extensions().get::<Arc<Connection>>().and_then(|connection| connection.local);
    let is_allowed_page = api.origins.allow(request.headers());
    if let Err((reason, problem)) = api.hosts.check(&request, local, is_allowed_page) {
        metrics::counter!("tabletopgen_requests_refused_total", "reason" => reason).increment(1);
        return problem.into_response();
    }
    // A request with a body counts when its body is there (see `submission`), an event stream for itself.
    let counts = matches!(*request.method(), Method::GET | Method::HEAD | Method::DELETE)
        && !PROBES.contains(&request.uri().path());
    if !counts {
        return next.run(request).await;
    }
    let Ok(_permit) = api.requests.clone().try_acquire_owned() else { return overloaded().into_response() };
    next.run(request).await
}

/// The refusal of a request that the server has no room for.
pub(super) fn overloaded() -> Problem {
    metrics::counter!("tabletopgen_requests_refused_total", "reason" => "overloaded").increment(1);
    Problem::new(
        ProblemType::Unavailable,
        "overloaded",
        "the server is answering as many requests as it can; send this one again after the time in Retry-After",
    )
}

/// The names that this server answers to.
#[derive(Debug)]
pub(super) struct AllowedHosts {
    /// Of the operator: hosts, `host:port`, and `.suffix` for every name below.
    named: BTreeSet<String>,
    any: bool,
    /// The host of the listen address.
    listen: String,
}

impl AllowedHosts {
    /// `listen` is the listen address, `allowed` the setting `server.allowed_hosts`, `public_url` that of the name.
    pub fn new(listen: &str, allowed: &str, public_url: &str) -> Self {
        let mut named: BTreeSet<String> = allowed.split_whitespace().map(str::to_ascii_lowercase).collect();
        let public: Option<Uri> = public_url.parse().ok();
        named.extend(public.as_ref().and_then(Uri::host).map(str::to_ascii_lowercase));
        let any = named.remove("*");
        let listen = listen.rsplit_once(':').map_or(listen, |(host, _)| host).to_ascii_lowercase();
        Self { named, any, listen }
    }

    /// Refuses a request with another host, or of a page of another site that is not allowed; with the reason as
    /// metrics have it.
    fn check(
        &self,
        request: &Request,
        local: Option<IpAddr>,
        is_allowed_page: bool,
    ) -> Result<(), (&'static str, Problem)> {
        let Some(authority) = self.authority(request).map_err(|problem| ("host", problem))? else {
            return Ok(());
        };
        if !self.allow(&authority, local) {
            let shown: String = authority.as_str().chars().take(80).collect();
            let problem = Problem::new(
                ProblemType::Misdirected,
                "host_not_allowed",
                format!(
                    "this server does not answer to {shown:?}; its operator adds names to server.allowed_hosts"
                ),
            );
            return Err(("host", problem));
        }
        if !is_allowed_page && self.is_cross_site(request.method(), request.headers(), &authority) {
            let problem = Problem::new(
                ProblemType::Forbidden,
                "cross_site_request",
                "a page of another site sent this request; send it from a program or from a page of this server, or ask the \
                 operator to name the page's origin in server.allowed_origins",
            );
            return Err(("cross_site", problem));
        }
        Ok(())
    }

    /// The host that a request names; `None` for HTTP/1.0 without one, which no browser speaks.
    fn authority(&self, request: &Request) -> Result<Option<Authority>, Problem> {
        let bad = |detail| Problem::new(ProblemType::MalformedRequest, "invalid_host", detail);
        let mut hosts = request.headers().get_all(header::HOST).into_iter();
        let host = match (hosts.next(), hosts.next()) {
            (Some(host), None) => host,
            (Some(_), Some(_)) => return Err(bad("the request has several Host headers; send one")),
            (None, _) if request.version() <= Version::HTTP_10 => return Ok(None),
            (None, _) => return Err(bad("the request has no Host header, which HTTP/1.1 requires")),
        };
        let host = host.to_str().ok().and_then(|host| host.parse::<Authority>().ok());
        let host = host.filter(|host| !host.as_str().contains('@'));
        let host = host.ok_or_else(|| bad("the Host header is no host with an optional port"))?;
        // The authority of an absolute target replaces the header (RFC 9112, 3.2.2).
        Ok(Some(request.uri().authority().cloned().unwrap_or(host)))
    }

    fn allow(&self, authority: &Authority, local: Option<IpAddr>) -> bool {
        let host = authority.host().trim_end_matches('.').to_ascii_lowercase();
        match address(&host) {
            // Browsers take it for this machine, whatever the listen address is.
            Some(address) if address.is_unspecified() => false,
            Some(address) if address.is_loopback() => true,
            Some(address) if local.is_some_and(|local| local.to_canonical() == address) => true,
            _ => {
                self.any
                    || host == "localhost"
                    || host == self.listen
                    || self.is_named(&host, authority.port_u16())
            }
        }
    }

    /// Whether the operator names the host.
    fn is_named(&self, host: &str, port: Option<u16>) -> bool {
        let with_port = port.is_some_and(|port| self.named.contains(&format!("{host}:{port}")));
        let below = host.match_indices('.').any(|(dot, _)| self.named.contains(&host[dot..]));
        self.named.contains(host) || with_port || below
    }

    /// Whether a browser says that a page of another origin sent the request. Links that lead here are followed.
    fn is_cross_site(&self, method: &Method, headers: &HeaderMap, host: &Authority) -> bool {
        let text = |name: &str| headers.get(name).map(|value| value.to_str().unwrap_or("invalid"));
        if let Some(site) = text("sec-fetch-site") {
            let is_link = text("sec-fetch-mode") == Some("navigate")
                && text("sec-fetch-dest") == Some("document")
                && matches!(*method, Method::GET | Method::HEAD);
            return !matches!(site, "same-origin" | "none") && !is_link;
        }
        let Some(origin) = text("origin") else { return false };
        let Some((scheme, rest)) = origin.split_once("://") else { return true };
        let Ok(origin) = rest.parse::<Authority>() else { return true };
        let port = |authority: &Authority| {
            authority.port_u16().or(match scheme {
                "http" => Some(80),
                "https" => Some(443),
                _ => None,
            })
        };
        let is_same = origin.host().eq_ignore_ascii_case(host.host()) && port(&origin) == port(host);
        // A proxy may have another name for this server than browsers have.
        !is_same && !self.is_named(&origin.host().to_ascii_lowercase(), origin.port_u16())
    }
}

/// An address as a host has it: IPv6 in brackets.
fn address(host: &str) -> Option<IpAddr> {
    let inner = host.strip_prefix('[').and_then(|rest| rest.strip_suffix(']')).unwrap_or(host);
    inner.parse::<IpAddr>().ok().map(|address| address.to_canonical())
}

#[cfg(test)]
mod tests {
    use axum::body::Body;

    use super::*;

    fn code(hosts: &AllowedHosts, method: Method, fields: &[(&str, &str)], local: &str) -> &'static str {
        let mut request = Request::builder().method(method).uri("/scenes");
        for (name, value) in fields {
            request = request.header(*name, *value);
        }
        let request = request.body(Body::empty()).expect("a request");
        hosts
            .check(&request, local.parse().ok(), false)
            .map_or_else(|(_, problem)| problem.own_code(), |()| "fine")
    }

    #[test]
    fn only_names_and_addresses_of_the_server_are_hosts() {
        let hosts = AllowedHosts::new(
            "0.0.0.0:8080",
            "Scenes.example.org .internal api:8080",
            "https://Public.example:444/",
        );
        for (host, expected) in [
            ("localhost", "fine"),
            ("LOCALHOST:8080", "fine"),
            ("127.0.0.1:1", "fine"),
            ("[::1]:8080", "fine"),
            ("192.0.2.7", "fine"),
            ("192.0.2.8", "host_not_allowed"),
            ("scenes.example.org.", "fine"),
            ("evil.scenes.example.org", "host_not_allowed"),
            ("a.b.internal:9", "fine"),
            ("internal", "host_not_allowed"),
            ("api:8080", "fine"),
            ("api", "host_not_allowed"),
            ("public.example", "fine"),
            ("private.example", "host_not_allowed"),
            ("rebound.example", "host_not_allowed"),
            ("0.0.0.0", "host_not_allowed"),
            ("a b", "invalid_host"),
            ("user@localhost", "invalid_host"),
            ("", "invalid_host"),
        ] {
            assert_eq!(code(&hosts, Method::GET, &[("host", host)], "192.0.2.7"), expected, "{host:?}");
        }
        assert_eq!(code(&hosts, Method::GET, &[], "192.0.2.7"), "invalid_host");
        assert_eq!(code(&hosts, Method::GET, &[("host", "localhost"), ("host", "a")], ""), "invalid_host");
        let any = AllowedHosts::new("scenes.lan:80", "*", "");
        assert_eq!(code(&any, Method::GET, &[("host", "anything")], ""), "fine");
        let listening = AllowedHosts::new("scenes.lan:80", "", "");
        assert_eq!(code(&listening, Method::GET, &[("host", "scenes.lan")], ""), "fine");
    }

    #[test]
    fn pages_of_other_sites_are_refused() {
        let hosts = AllowedHosts::new("127.0.0.1:8080", "scenes.example.org", "");
        let navigate = [("sec-fetch-mode", "navigate"), ("sec-fetch-dest", "document")];
        for (method, fields, expected) in [
            (Method::POST, vec![], "fine"),
            (Method::POST, vec![("sec-fetch-site", "same-origin")], "fine"),
            (Method::POST, vec![("sec-fetch-site", "none")], "fine"),
            (Method::POST, vec![("sec-fetch-site", "cross-site")], "cross_site_request"),
            (Method::POST, vec![("sec-fetch-site", "same-site")], "cross_site_request"),
            (Method::GET, vec![("sec-fetch-site", "cross-site")], "cross_site_request"),
            (Method::GET, [&[("sec-fetch-site", "cross-site")][..], &navigate[..]].concat(), "fine"),
            (
                Method::POST,
                [&[("sec-fetch-site", "cross-site")][..], &navigate[..]].concat(),
                "cross_site_request",
            ),
            (Method::POST, vec![("origin", "http://localhost:8080")], "fine"),
            (Method::POST, vec![("origin", "http://localhost:3000")], "cross_site_request"),
            (Method::POST, vec![("origin", "https://evil.example")], "cross_site_request"),
            (Method::POST, vec![("origin", "http://127.0.0.1:8080")], "cross_site_request"),
            (Method::DELETE, vec![("origin", "null")], "cross_site_request"),
            (Method::POST, vec![("origin", "https://scenes.example.org")], "fine"),
        ] {
            let all = [&[("host", "localhost:8080")][..], &fields[..]].concat();
            assert_eq!(code(&hosts, method.clone(), &all, ""), expected, "{method} {fields:?}");
        }
    }
}
