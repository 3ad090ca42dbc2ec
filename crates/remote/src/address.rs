//! Which addresses may be talked to: those of the public internet, and the hosts the operator names.
//!
//! Checked are the addresses a name resolves to, and the connection goes to the very addresses that were checked: a
//! name that resolves differently a moment later is not asked again. Addresses written into a URL are checked as they
//! are. The registries of special-purpose addresses are IANA's (RFC 6890 and its updates).

use std::collections::BTreeSet;
use std::net::{IpAddr, Ipv4Addr, Ipv6Addr, SocketAddr};
use std::sync::Arc;

use reqwest::Url;
use reqwest::dns::{Addrs, Name, Resolve, Resolving};

/// The operator's rules.
#[derive(Clone, Debug)]
pub struct AddressRules {
    /// Plain HTTP is allowed.
    pub allow_http: bool,
    /// Hosts, or `host:port`, that may be private addresses.
    private_hosts: Arc<BTreeSet<String>>,
}

/// Why a URL or a host is not talked to.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum AddressRefused {
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

impl AddressRules {
    /// `private_hosts` are hosts or `host:port`, separated by spaces.
    pub fn new(allow_http: bool, private_hosts: &str) -> Self {
        let hosts = private_hosts.split_whitespace().map(str::to_ascii_lowercase).collect();
        Self { allow_http, private_hosts: Arc::new(hosts) }
    }

    /// The URL, if its scheme may be used, and its host too where that is written as an address.
    pub fn check(&self, url: &str) -> Result<Url, AddressRefused> {
        let parsed = Url::parse(url).map_err(|_| AddressRefused::NoUrl(shortened(url)))?;
        let host = parsed.host_str().ok_or_else(|| AddressRefused::NoUrl(shortened(url)))?.to_owned();
        if !parsed.username().is_empty() || parsed.password().is_some() {
            return Err(AddressRefused::Credentials(host));
        }
        match parsed.scheme() {
            "https" => {}
            "http" if self.allow_http => {}
            "http" => return Err(AddressRefused::NotHttps(shortened(url))),
            _ => return Err(AddressRefused::NoUrl(shortened(url))),
        }
        if let Ok(address) = host.trim_matches(['[', ']']).parse::<IpAddr>()
            && !is_public(address)
            && !self.may_be_private(&host, parsed.port_or_known_default())
        {
            return Err(AddressRefused::Private { host, address });
        }
        Ok(parsed)
    }

    /// With a port only that port is meant; a name is resolved before its port is known, so any of its entries counts.
    fn may_be_private(&self, host: &str, port: Option<u16>) -> bool {
        let host = host.to_ascii_lowercase();
        self.private_hosts.contains(&host)
            || port.is_some_and(|port| self.private_hosts.contains(&format!("{host}:{port}")))
    }

    fn names_host(&self, host: &str) -> bool {
        let host = host.to_ascii_lowercase();
        self.private_hosts
            .iter()
            .any(|entry| *entry == host || entry.rsplit_once(':').is_some_and(|(name, _)| name == host))
    }
}

/// Resolves names by the system's resolver, to addresses that may be talked to.
pub(super) struct CheckedResolver(pub AddressRules);

impl Resolve for CheckedResolver {
    fn resolve(&self, name: Name) -> Resolving {
        let rules = self.0.clone();
        Box::pin(async move {
            let host = name.as_str().to_owned();
            let found: Vec<SocketAddr> = tokio::net::lookup_host((host.as_str(), 0)).await?.collect();
            let checked = checked(&rules, &host, found)?;
            let addresses: Addrs = Box::new(checked.into_iter());
            Ok(addresses)
        })
    }
}

/// All of them, or an error if one is private: a name that mixes both is an attack or a mistake.
fn checked(
    rules: &AddressRules,
    host: &str,
    found: Vec<SocketAddr>,
) -> Result<Vec<SocketAddr>, AddressRefused> {
    if found.is_empty() {
        return Err(AddressRefused::NoAddress(host.to_owned()));
    }
    match found.iter().map(SocketAddr::ip).find(|address| !is_public(*address)) {
        Some(address) if !rules.names_host(host) => {
            Err(AddressRefused::Private { host: host.to_owned(), address })
        }
        _ => Ok(found),
    }
}

/// Whether an address belongs to the public internet, as far as the registries say.
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
        // Shared address space of carriers.
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
        // Mapped from IPv4, and translated by NAT64: what counts is what is inside.
        [0, 0, 0, 0, 0, 0xffff, high, low] | [0x64, 0xff9b, 0, 0, 0, 0, high, low] => embedded(high, low),
        [0x2002, high, low, ..] => embedded(high, low),
        // Teredo, benchmarks, ORCHID and other protocol assignments; documentation.
        [0x2001, 0..=0x01ff, ..] | [0x2001, 0x0db8, ..] | [0x3fff, 0..=0x0fff, ..] => false,
        // Global unicast; everything else is loopback, link-local, unique local, multicast or reserved.
        [first, ..] => first & 0xe000 == 0x2000,
    }
}

fn shortened(url: &str) -> String {
    // Queries may carry signatures, and what stands before an @ passwords.
    let end = url.find(['?', '#']).unwrap_or(url.len());
    let start = url[..end].rfind('@').map_or(0, |at| at + 1);
    url[start..end].chars().take(120).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn special_addresses_are_refused_and_public_ones_are_not() {
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
    fn urls_are_https_and_public_unless_the_operator_says_otherwise() {
        let strict = AddressRules::new(false, "");
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
        let lenient = AddressRules::new(true, "127.0.0.1:8123 [::1] llm.internal:80");
        assert!(lenient.check("http://127.0.0.1:8123/v1").is_ok());
        assert!(lenient.check("http://[::1]:9/v1").is_ok());
        assert!(lenient.check("http://127.0.0.1:8124/v1").is_err());
        assert!(lenient.check("http://127.0.0.2:8123/v1").is_err());
    }

    #[test]
    fn one_private_address_among_public_ones_refuses_the_name() {
        let rules = AddressRules::new(false, "llm.internal:443");
        let public: SocketAddr = "8.8.8.8:0".parse().expect("address");
        let private: SocketAddr = "10.0.0.7:0".parse().expect("address");
        assert_eq!(checked(&rules, "api.example.org", vec![public]), Ok(vec![public]));
        assert!(checked(&rules, "api.example.org", vec![public, private]).is_err());
        assert_eq!(checked(&rules, "LLM.internal", vec![private]), Ok(vec![private]));
        assert_eq!(
            checked(&rules, "nobody.example.org", vec![]),
            Err(AddressRefused::NoAddress("nobody.example.org".into()))
        );
    }

    #[test]
    fn queries_and_passwords_do_not_show() {
        let refused = AddressRules::new(false, "").check("http://example.org/file?X-Signature=abc");
        assert!(!refused.expect_err("is plain HTTP").to_string().contains("abc"));
        for url in ["https://me:abc@example.org/", "https://abc@example.org/", "https://me:abc@:/", "abc@"] {
            let refused = AddressRules::new(false, "").check(url).expect_err(url);
            assert!(!refused.to_string().contains("abc"), "{refused}");
        }
    }
}
