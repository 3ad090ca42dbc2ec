//! Remote adapters: models that answer over the network, slowly, for money, and sometimes not at all.
//!
//! Every call goes the same way: [`endpoint`] waits for its turn ([`turns`]), asks the breaker ([`breaker`]), writes
//! the call into the job's ledger, sends it through the one client ([`outbound`]) that refuses addresses of private
//! networks ([`address`]) and can record what is said and play it again ([`cassette`]), reads how it ended
//! ([`failure`]), and tries again where that can help ([`patience`]). An adapter only says what to ask and how to read
//! the answer. Adapters: [`chat`], the analyst over any OpenAI-compatible chat endpoint; [`images`] and [`ark`], the painter over
//! OpenAI's Images endpoints and Ark's Seedream; [`sidecar`], the segmenter over a small server that runs a detector; [`replicate`],
//! [`hunyuan3d`] and [`tencent`], the mesh generator over Replicate-style predictions, over a server of one's own and over
//! Tencent Cloud, whose jobs outlive a worker ([`task`]).
//!
//! What comes back is hostile until proven: sizes are capped, numbers have ranges, addresses a model names are never
//! fetched.

pub mod settings;
pub mod secret;
pub mod address;
pub mod cassette;
pub mod outbound;
pub mod failure;
pub mod patience;
pub mod breaker;
pub mod turns;
pub mod endpoint;
pub mod prompt;
pub mod picture;
pub mod multipart;
pub mod chat;
pub mod images;
pub mod ark;
pub mod sidecar;
pub mod task;
pub mod mesh;
pub mod replicate;
pub mod hunyuan3d;
pub mod tencent;
pub mod preference;

pub use endpoint::Endpoint;
pub use outbound::Outbound;
pub use secret::Secret;
pub use settings::{
    ChatSettings, ImagesSettings, LimitSettings, ProviderSettings, ReplicateSettings, SidecarSettings,
    TencentSettings,
};
