//! Datasets of synthetic episodes are written, read back by other code, and compared.

#[path = "../../examples/synthetic/scene.rs"]
mod scene;
mod reading;

mod assembling;
mod descriptions;
mod files;
mod pitfalls;
mod statistics;
