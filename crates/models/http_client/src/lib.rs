//! The one outbound HTTP client of the program.
//!
//! [`HttpClient`] connects only to addresses that its [`AddressPolicy`] allows ([`address`]), bounds the size of every
//! response ([`client`]), and records exchanges or replays them without a network ([`cassette`]). [`retry`] computes
//! the pause before the next attempt, [`rate_limit`] spaces calls that share a key, and [`circuit_breaker`] suspends
//! an endpoint that fails repeatedly. [`Secret`] holds a key that is never printed, and [`hmac`] signs with one.
//!
//! The crate must not depend on any crate of the workspace but `runtime`: it knows no vendor, no ledger and no port.
//!
//! ```
//! use std::time::Duration;
//!
//! use http_client::AddressPolicy;
//! use http_client::retry::full_jitter;
//!
//! let policy = AddressPolicy::new(false, "");
//! assert!(policy.check("https://api.example.org/v1").is_ok());
//! assert!(policy.check("https://169.254.169.254/").is_err());
//!
//! let (base, cap) = (Duration::from_millis(100), Duration::from_secs(1));
//! assert_eq!(full_jitter(3, base, cap, 0.5), Duration::from_millis(200));
//! ```

pub mod secret;
pub mod hmac;
pub mod message;
pub mod address;
pub mod retry;
pub mod rate_limit;
pub mod circuit_breaker;
pub mod cassette;
pub mod client;

pub use address::{AddressError, AddressPolicy};
pub use client::{HttpClient, SendError};
pub use message::{HttpRequest, HttpResponse};
pub use reqwest::{Method, Url};
pub use secret::Secret;
