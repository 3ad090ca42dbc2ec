//! Remote adapters: the ports answered by models over the network.
//!
//! Every call takes the same path through an [`endpoint`]: rate limit, circuit breaker, ledger reservation, request
//! through the one client of [`http_client`], classification of the failure ([`failure`]), retry with jitter, and
//! settlement. An adapter only states the question and reads the answer.
//!
//! | port | adapters |
//! | --- | --- |
//! | analyst | [`chat`]: OpenAI-compatible chat endpoints |
//! | image generator | [`images`]: OpenAI's Images endpoints; [`ark`]: Seedream |
//! | segmenter | [`sidecar`]: a local server that runs an open-vocabulary detector |
//! | mesh generator | [`replicate`], [`hunyuan3d`] and [`tencent`], whose jobs outlive a worker ([`vendor_job`]) |
//!
//! [`fallback`] asks several providers of one port in order. Responses are untrusted: sizes are bounded, numbers have
//! ranges, and URLs that a model names are never fetched.
//!
//! The crate must not open connections itself, and must not depend on the store, on the pipeline or on `embedded`.
//!
//! ```
//! use remote::failure::{Billed, FailureKind};
//!
//! assert!(FailureKind::Busy.may_pass());
//! assert_eq!(FailureKind::TimedOut.billed(), Billed::Unknown);
//! assert_eq!(FailureKind::Denied.code(), "provider_denied");
//! ```

pub mod settings;
pub mod failure;
pub mod endpoint;
pub mod prompt;
pub mod image;
pub mod multipart;
pub mod chat;
pub mod images;
pub mod ark;
pub mod sidecar;
pub mod vendor_job;
pub mod mesh;
pub mod replicate;
pub mod hunyuan3d;
pub mod tencent;
pub mod fallback;

pub use endpoint::Endpoint;
pub use settings::{
    ChatSettings, ImagesSettings, LimitSettings, ProviderSettings, ReplicateSettings, SidecarSettings,
    TencentSettings,
};
