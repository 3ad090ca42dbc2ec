//! Servers, scripted stages and the API contract that the tests share.

pub mod script;
pub mod server;
pub mod contract;
pub mod instructions;
pub mod databases;
pub mod tiny_bundle;
pub mod event_stream;
