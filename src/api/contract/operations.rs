//! Summaries, answers and links of the operations, which no type says.

mod access;
mod batches;
mod datasets;
mod episodes;
mod jobs;
mod scenes;
mod service;
mod webhooks;

pub use access::*;
pub use batches::*;
pub use datasets::*;
pub use episodes::*;
pub use jobs::*;
pub use scenes::*;
pub use service::*;
pub use webhooks::*;
