//! Tests of the service and of the command line, from outside: servers on free ports, temporary data
//! directories, and builds of scenes small enough that a test takes milliseconds.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

mod script;
mod server;
mod contract;
mod submissions;
mod listing;
mod downloads;
mod events;
mod lifecycle;
mod restarts;
mod leases;
mod outages;
mod slow_clients;
mod commands;
mod truth;
mod features;
mod bench;
mod wire_faults;
mod chat_server;
mod chat_answers;
mod chat;
mod chat_opinions;
mod chat_faults;
mod chat_scene;
mod images_server;
mod images;
mod ark_server;
mod ark;
mod sidecar_server;
mod sidecar;
mod predictions_server;
mod predictions;
mod hunyuan3d_server;
mod hunyuan3d;
mod tencent_server;
mod tencent;
mod hostile_files;
mod rejected_images;
mod cassettes;
mod outbound;
mod ledger;
