//! Adapters of remote models against protocol servers.

mod bench;
mod wire_faults;
pub mod chat_server;
pub mod chat_answers;
mod chat;
mod chat_opinions;
mod chat_faults;
mod chat_scene;
mod instructions;
pub mod images_server;
mod images;
pub mod ark_server;
mod ark;
pub mod sidecar_server;
mod sidecar;
pub mod predictions_server;
mod predictions;
pub mod hunyuan3d_server;
mod hunyuan3d;
pub mod tencent_server;
mod tencent;
mod cassettes;
mod outbound;
mod ledger;
