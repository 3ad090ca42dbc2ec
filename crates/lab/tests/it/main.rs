//! Tests of the laboratory's commands from outside, and of whole scenes against the mock vendors.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

#[path = "../../../../tests/it/server.rs"]
#[allow(dead_code, reason = "the server's own tests use all of it")]
mod server;
#[path = "../../../../tests/it/script.rs"]
#[allow(dead_code, reason = "the server's own tests use all of it")]
mod script;
#[path = "../../../../tests/it/contract.rs"]
#[allow(dead_code, reason = "the server's own tests use all of it")]
mod contract;
mod commands;
mod evaluate;
mod images;
mod remote_scene;
