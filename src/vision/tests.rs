//! Pictures painted from the catalog, read back.

mod painted;
mod read;
