//! Tests of the laboratory's commands from outside, and of whole scenes against the mock vendors.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

#[path = "../../../../../tests/it/harness"]
#[allow(dead_code, reason = "the server's own tests use all of it")]
mod harness {
    pub mod contract;
    pub mod script;
    pub mod server;
}
mod commands;
mod evaluate;
mod images;
mod remote_scene;
