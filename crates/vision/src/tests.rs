//! Pictures painted from the catalog, read back.

pub mod painted;
#[cfg(test)]
mod read;
