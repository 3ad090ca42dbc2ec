//! Pictures painted from the catalog, read back.

pub(crate) mod painted;
mod read;
