//! Address policy: the public internet and the hosts that the operator names are allowed (protection against SSRF).
//!
//! The resolver checks every address of a name, and the connection uses exactly the checked addresses: DNS rebinding
//! has no effect. Addresses written into a URL are checked directly. The special-purpose ranges are those of the
//! registries of IANA (RFC 6890 and its updates).

use std::collections::BTreeSet;
use std::net::{IpAddr, Ipv4Addr, Ipv6Addr, SocketAddr};
use std::sync::Arc;

use reqwest::Url;
use reqwest::dns::{Addrs, Name, Resolve, Resolving};

/// The addresses that the operator allows.
#[derive(Clone, Debug)]
pub struct AddressPolicy {
    /// Whether plain HTTP is allowed.
    pub allow_http: bool,
    /// Whether it is allowed for `private_hosts`.
    allow_http_to_private_hosts: bool,
    /// Hosts, or `host:port`, that may be private addresses.
    private_hosts: Arc<BTreeSet<String>>,
}

/// Reason why a URL or a host is refused.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum AddressError {
    #[error("{0:?} is no URL with a host")]
    NoUrl(String),
    #[error("{0} carries a name or a password; keys belong into the environment")]
    Credentials(String),
    #[error("{0} is not https; only the operator can allow plain HTTP, with providers.allow_http")]
    NotHttps(String),
    #[error(
        "{host} is {address}, which is not an address of the public internet; only the operator can allow it, with \
         providers.private_hosts"
    )]
    Private { host: String, address: IpAddr },
    #[error("{0} has no address")]
    NoAddress(String),
}

impl AddressPolicy {
    /// A policy whose `private_hosts` (`host` or `host:port`, separated by spaces) may be private addresses.
    pub fn new(allow_http: bool, private_hosts: &str) -> Self {
        let hosts = private_hosts.split_whitespace().map(str::to_ascii_lowercase).collect();
        Self { allow_http, allow_http_to_private_hosts: false, private_hosts: Arc::new(hosts) }
    }

    /// A policy whose `hosts` may be private addresses and plain HTTP; all others have to be public and https.
    pub fn with_exceptions(hosts: &str) -> Self {
        Self { allow_http_to_private_hosts: true, ..Self::new(false, hosts) }
    }

    /// The same policy without private hosts.
    pub(super) fn public(&self) -> Self {
        Self { private_hosts: Arc::default(), ..self.clone() }
    }

    pub(super) fn has_private_hosts(&self) -> bool {
        !self.private_hosts.is_empty()
    }

    /// Parses and checks a URL: its scheme, and its host where that is an address. Names are checked when they resolve.
    ///
    /// # Errors
    ///
    /// [`AddressError`] says which rule the URL breaks; its text holds neither queries nor credentials.
    pub fn check(&self, url: &str) -> Result<Url, AddressError> {
        let parsed = Url::parse(url).map_err(|_| AddressError::NoUrl(redacted(url)))?;
        let host = parsed.host_str().ok_or_else(|| AddressError::NoUrl(redacted(url)))?.to_owned();
        if !parsed.username().is_empty() || parsed.password().is_some() {
            return Err(AddressError::Credentials(host));
        }
        match parsed.scheme() {
            "https" => {}
            "http" if self.allow_http => {}
            "http" if self.allow_http_to_private_hosts && self.names(&parsed) => {}
            "http" => return Err(AddressError::NotHttps(redacted(url))),
            _ => return Err(AddressError::NoUrl(redacted(url))),
        }
        if let Ok(address) = host.trim_matches(['[', ']']).parse::<IpAddr>()
            && !is_public(address)
            && !self.names(&parsed)
        {
            return Err(AddressError::Private { host, address });
        }
        Ok(parsed)
    }

    /// Whether `private_hosts` names the URL's host, alone or with the URL's port.
    pub(super) fn names(&self, url: &Url) -> bool {
        let Some(host) = url.host_str().map(str::to_ascii_lowercase) else { return false };
        let port = url.port_or_known_default();
        self.private_hosts.contains(&host)
            || port.is_some_and(|port| self.private_hosts.contains(&format!("{host}:{port}")))
    }

    /// Whether any entry names the host. A resolver does not know the port, so an entry with any port counts; the
    /// client resolves URLs of other ports by [`Self::public`].
    fn names_host(&self, host: &str) -> bool {
        let host = host.to_ascii_lowercase();
        self.private_hosts
            .iter()
            .any(|entry| *entry == host || entry.rsplit_once(':').is_some_and(|(name, _)| name == host))
    }
}

/// The system's resolver, restricted to allowed addresses.
pub(super) struct CheckedResolver(pub AddressPolicy);

impl Resolve for CheckedResolver {
    fn resolve(&self, name: Name) -> Resolving {
        let policy = self.0.clone();
        Box::pin(async move {
            let host = name.as_str().to_owned();
            let resolved: Vec<SocketAddr> = tokio::net::lookup_host((host.as_str(), 0)).await?.collect();
            let checked = check_resolved(&policy, &host, resolved)?;
            let addresses: Addrs = Box::new(checked.into_iter());
            Ok(addresses)
        })
    }
}

/// All resolved addresses, or an error where one of them is private: a mixed result is an attack or a mistake.
fn check_resolved(
    policy: &AddressPolicy,
    host: &str,
    addresses: Vec<SocketAddr>,
) -> Result<Vec<SocketAddr>, AddressError> {
    if addresses.is_empty() {
        return Err(AddressError::NoAddress(host.to_owned()));
    }
    match addresses.iter().map(SocketAddr::ip).find(|address| !is_public(*address)) {
        Some(address) if !policy.names_host(host) => {
            Err(AddressError::Private { host: host.to_owned(), address })
        }
        _ => Ok(addresses),
    }
}

/// Whether an address is globally reachable according to the registries of special-purpose addresses.
pub fn is_public(address: IpAddr) -> bool {
    match address {
        IpAddr::V4(address) => is_public_v4(address),
        IpAddr::V6(address) => is_public_v6(address),
    }
}

fn is_public_v4(address: Ipv4Addr) -> bool {
    let [a, b, c, _] = address.octets();
    let special = match (a, b, c) {
        (0 | 10 | 127, ..) => true,
        // Carrier-grade NAT.
        (100, 64..=127, _) => true,
        (169, 254, _) => true,
        (172, 16..=31, _) => true,
        // Protocol assignments, documentation, the 6to4 relay.
        (192, 0, 0 | 2) | (192, 88, 99) => true,
        (192, 168, _) => true,
        // Benchmarks and documentation.
        (198, 18 | 19, _) | (198, 51, 100) | (203, 0, 113) => true,
        // Multicast, reserved, broadcast.
        (224.., ..) => true,
        _ => false,
    };
    !special
}

fn is_public_v6(address: Ipv6Addr) -> bool {
    let s = address.segments();
    let embedded = |high: u16, low: u16| {
        let [a, b] = high.to_be_bytes();
        let [c, d] = low.to_be_bytes();
        is_public_v4(Ipv4Addr::new(a, b, c, d))
    };
    match s {
        // IPv4-mapped and NAT64 addresses: the embedded IPv4 address decides.
        [0, 0, 0, 0, 0, 0xffff, high, low] | [0x64, 0xff9b, 0, 0, 0, 0, high, low] => embedded(high, low),
        [0x2002, high, low, ..] => embedded(high, low),
        // Teredo, benchmarks, ORCHID and other protocol assignments; documentation.
        [0x2001, 0..=0x01ff, ..] | [0x2001, 0x0db8, ..] | [0x3fff, 0..=0x0fff, ..] => false,
        // Global unicast; everything else is loopback, link-local, unique local, multicast or reserved.
        [first, ..] => first & 0xe000 == 0x2000,
    }
}

/// The URL without query, fragment and user information, at most 120 characters.
fn redacted(url: &str) -> String {
    // Queries may hold signatures, and the part before an @ a password.
    let end = url.find(['?', '#']).unwrap_or(url.len());
    let start = url[..end].rfind('@').map_or(0, |at| at + 1);
    url[start..end].chars().take(120).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn is_public_rejects_special_purpose_addresses() {
        for text in [
            "0.0.0.0",
            "10.1.2.3",
            "100.64.0.1",
            "127.0.0.1",
            "127.9.9.9",
            "169.254.169.254",
            "172.16.0.1",
            "172.31.255.255",
            "192.0.0.1",
            "192.0.2.1",
            "192.88.99.1",
            "192.168.1.1",
            "198.18.0.1",
            "198.51.100.7",
            "203.0.113.9",
            "224.0.0.1",
            "240.0.0.1",
            "255.255.255.255",
            "::",
            "::1",
            "::127.0.0.1",
            "::ffff:127.0.0.1",
            "::ffff:169.254.169.254",
            "64:ff9b::a00:1",
            "64:ff9b:1::1",
            "100::1",
            "2001::1",
            "2001:db8::1",
            "2002:7f00:1::",
            "2002:a9fe:a9fe::1",
            "3fff::1",
            "fc00::1",
            "fd12:3456::1",
            "fe80::1",
            "fec0::1",
            "ff02::1",
        ] {
            assert!(!is_public(text.parse().expect(text)), "{text}");
        }
        for text in [
            "1.1.1.1",
            "8.8.8.8",
            "100.63.0.1",
            "100.128.0.1",
            "172.15.0.1",
            "172.32.0.1",
            "192.0.1.1",
            "223.255.0.1",
            "2606:4700::1111",
            "2a00:1450:4001:80b::200e",
            "::ffff:8.8.8.8",
            "64:ff9b::808:808",
            "2002:808:808::1",
        ] {
            assert!(is_public(text.parse().expect(text)), "{text}");
        }
    }

    #[test]
    fn check_requires_https_and_a_public_address_unless_the_policy_allows() {
        let strict = AddressPolicy::new(false, "");
        assert!(strict.check("https://api.openai.com/v1").is_ok());
        for (url, wanted) in [
            ("http://api.openai.com/v1", "NotHttps"),
            ("https://127.0.0.1/v1", "Private"),
            ("https://[::1]:8443/", "Private"),
            ("https://[::ffff:10.0.0.1]/", "Private"),
            // Other spellings of 127.0.0.1 that URLs allow.
            ("https://2130706433/", "Private"),
            ("https://0x7f.1/", "Private"),
            ("file:///etc/passwd", "NoUrl"),
            ("ftp://example.org/", "NoUrl"),
            ("nonsense", "NoUrl"),
        ] {
            let refused = format!("{:?}", strict.check(url).expect_err(url));
            assert!(refused.starts_with(wanted), "{url}: {refused}");
        }
        let lenient = AddressPolicy::new(true, "127.0.0.1:8123 [::1] llm.internal:80");
        assert!(lenient.check("http://127.0.0.1:8123/v1").is_ok());
        assert!(lenient.check("http://[::1]:9/v1").is_ok());
        assert!(lenient.check("http://127.0.0.1:8124/v1").is_err());
        assert!(lenient.check("http://127.0.0.2:8123/v1").is_err());
    }

    #[test]
    fn exceptions_hold_for_the_named_port_alone() {
        let policy = AddressPolicy::with_exceptions("Images.internal 127.0.0.1:8090");
        for (url, is_allowed) in [
            ("http://images.internal/a.png", true),
            ("http://IMAGES.internal:81/a.png", true),
            ("http://127.0.0.1:8090/a.png?b#c", true),
            ("https://example.org/a.png", true),
            ("http://127.0.0.1:8091/a.png", false),
            ("https://127.0.0.1:8091/a.png", false),
            ("http://127.0.0.1/a.png", false),
            ("http://images.internal.example.org/a.png", false),
            ("http://a@images.internal/a.png", false),
            ("http://example.org/http://images.internal/", false),
            ("images.internal", false),
        ] {
            assert_eq!(policy.check(url).is_ok(), is_allowed, "{url}");
        }
    }

    #[test]
    fn resolver_rejects_a_name_with_any_private_address() {
        let policy = AddressPolicy::new(false, "llm.internal:443");
        let public: SocketAddr = "8.8.8.8:0".parse().expect("address");
        let private: SocketAddr = "10.0.0.7:0".parse().expect("address");
        assert_eq!(check_resolved(&policy, "api.example.org", vec![public]), Ok(vec![public]));
        assert!(check_resolved(&policy, "api.example.org", vec![public, private]).is_err());
        assert_eq!(check_resolved(&policy, "LLM.internal", vec![private]), Ok(vec![private]));
        assert_eq!(
            check_resolved(&policy, "nobody.example.org", vec![]),
            Err(AddressError::NoAddress("nobody.example.org".into()))
        );
    }

    #[test]
    fn address_errors_hold_neither_queries_nor_passwords() {
        let refused = AddressPolicy::new(false, "").check("http://example.org/file?X-Signature=abc");
        assert!(!refused.expect_err("is plain HTTP").to_string().contains("abc"));
        for url in ["https://me:abc@example.org/", "https://abc@example.org/", "https://me:abc@:/", "abc@"] {
            let refused = AddressPolicy::new(false, "").check(url).expect_err(url);
            assert!(!refused.to_string().contains("abc"), "{refused}");
        }
    }
}
