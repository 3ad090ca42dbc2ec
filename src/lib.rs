//! The server and the command line of tabletopgen, which turns a sentence or one image into a tabletop scene in which a
//! robot can be trained.
//!
//! The modules stand in the order a request travels. Everything below them is a crate of its own under `crates/`:
//! `scene` has the domain types, `certificate` their measurements, `ports` the five model interfaces, `store` what
//! survives a restart. Read this file, then [`pipeline`], then one stage and the function it calls.
//!
//! ```
//! use tabletopgen::config::{Sources, layers};
//!
//! let resolved = layers::load(Sources::default()).expect("the built-in defaults are valid");
//! assert!(resolved.config.server.max_image_pixels > 0);
//! ```

// What an operator starts: typed settings, use cases and the wiring, the server, the commands.
pub mod config;
pub mod app;
pub mod service;
pub mod cli;

// Refusals of requests, for every caller.
pub mod problem;
mod path_without_keys;

// What requests and answers hold of other crates, for the contract.
pub mod schemas;

// What the log and traces say about the work at hand.
pub mod spans;

// What keeps the loops of a process running.
pub mod background;

// 1. A request arrives.
pub mod api;

// 2. It becomes a job.
pub mod worker;

// 3. Stages turn it into a scene.
pub mod pipeline;

// 4. Finished scenes become a dataset.
pub mod freezer;

// 5. Robots do tasks in them, and their demonstrations become a dataset.
pub mod executor;
pub mod recorder;

// 6. Clients hear of what has ended.
pub mod webhooks;
