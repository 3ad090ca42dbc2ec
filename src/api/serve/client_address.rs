//! The address that limits per client count by, and the proxies that speak for others.

use std::collections::BTreeSet;
use std::net::{IpAddr, Ipv6Addr};

use axum::http::HeaderMap;

/// Address by which one client is known: an IPv4 address, or the /64 network of an IPv6 address, which one host fills
/// at will.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct ClientAddress(IpAddr);

impl From<IpAddr> for ClientAddress {
    fn from(address: IpAddr) -> Self {
        match address.to_canonical() {
            IpAddr::V4(address) => Self(address.into()),
            IpAddr::V6(address) => Self(Ipv6Addr::from_bits(address.to_bits() >> 64 << 64).into()),
        }
    }
}

/// Setting `server.proxy_addresses`.
#[derive(Clone, Debug, Default)]
pub struct Proxies(BTreeSet<IpAddr>);

impl Proxies {
    /// Addresses separated by spaces. What is no address is skipped; the configuration refuses it before.
    pub fn new(addresses: &str) -> Self {
        Self(addresses.split_whitespace().filter_map(|text| text.parse().ok()).collect())
    }

    pub fn contains(&self, address: IpAddr) -> bool {
        self.0.contains(&address.to_canonical())
    }

    /// The client of a request, as limits count it.
    pub fn client(&self, peer: IpAddr, headers: &HeaderMap) -> ClientAddress {
        self.client_ip(peer, headers).into()
    }

    /// The address of the client of a request: the peer, or whom a proxy names last in `X-Forwarded-For`. Earlier
    /// entries are the client's own words.
    pub fn client_ip(&self, peer: IpAddr, headers: &HeaderMap) -> IpAddr {
        let lists = headers.get_all("x-forwarded-for").into_iter().filter_map(|list| list.to_str().ok());
        let last = lists.flat_map(|list| list.split(',')).last();
        let named = last.and_then(|text| text.trim().parse::<IpAddr>().ok());
        named.filter(|_| self.contains(peer)).unwrap_or(peer).to_canonical()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ip(text: &str) -> IpAddr {
        text.parse().expect("an address")
    }

    #[test]
    fn an_ipv6_network_and_a_mapped_address_are_one_client() {
        let client = |text| ClientAddress::from(ip(text));
        assert_eq!(client("2001:db8::1"), client("2001:db8:0:0:ffff::9"));
        assert_ne!(client("2001:db8::1"), client("2001:db8:0:1::1"));
        assert_eq!(client("::ffff:192.0.2.7"), client("192.0.2.7"));
        assert_ne!(client("192.0.2.7"), client("192.0.2.8"));
    }

    #[test]
    fn only_a_proxy_speaks_for_another_client() {
        let proxies = Proxies::new("10.0.0.1 ::1");
        let mut headers = HeaderMap::new();
        headers.append("x-forwarded-for", "1.1.1.1, 8.8.8.8".parse().expect("a value"));
        assert_eq!(proxies.client(ip("10.0.0.1"), &headers), ip("8.8.8.8").into());
        assert_eq!(proxies.client(ip("10.0.0.2"), &headers), ip("10.0.0.2").into());
        headers.insert("x-forwarded-for", "nonsense".parse().expect("a value"));
        assert_eq!(proxies.client(ip("10.0.0.1"), &headers), ip("10.0.0.1").into());
    }
}
