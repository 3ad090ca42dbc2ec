//! Embedded adapters of the ports: real algorithms that need no key, no network and no GPU.

pub mod analyst;
pub mod layout;
