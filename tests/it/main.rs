//! Tests of the service and of the command line, from outside: servers on free ports, temporary data
//! directories, and builds of scenes small enough that a test takes milliseconds.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

mod contract_files;
mod harness;
mod api;
mod worker;
mod cli;
mod pipeline;
mod imaging;
mod remote;
