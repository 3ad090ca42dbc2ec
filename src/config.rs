//! The configuration: a typed mirror of `config/default.toml`.
//!
//! Four layers, later ones win: the built-in defaults, a TOML file, environment variables
//! `TABLETOPGEN__SECTION__KEY`, and `section.key=value` arguments. Only keys of `default.toml` exist; a
//! value must have its default's type and lie in the range written beside the default. Every complaint
//! names the key, where it came from, and what would do. No setting has a default anywhere else.
//!
//! Adding a section takes two steps: the section in `default.toml`, the field in [`Config`].

pub mod error;
pub mod keys;
pub mod open_settings;
pub mod value;
pub mod layers;
mod nearest;
mod parts;
mod rules;

use serde::{Deserialize, Serialize};

use crate::pipeline::certify::{AppraiseSettings, FidelitySettings, HealthSettings};
use crate::pipeline::preview::PreviewSettings;
use crate::pipeline::resolve::NoSpaceSettings;
use crate::{api, webhooks, worker};
use embedded::image_generator::ImageGeneratorSettings;
use embedded::layout::LayoutSettings;
use embedded::mesh_generator::MeshSettings;
use embedded::single_view_reconstruction::PhotographSettings;
use embedded::text_parser;
use export::ExportSettings;
use geometry::decompose::DecomposeSettings;
use gpu::ComputeSettings;
use manipulation::execution::ExecutionSettings;
use manipulation::grasp::GraspSettings;
use physics::metrics::CertifySettings;
use physics::resolve::ResolveSettings;
use physics::settle::SettleSettings;
use ports::feature_extractor::FeatureSettings;
use pose_estimation::top_view_layout::TopViewSettings;
use pose_estimation::upright::UprightSettings;
use pose_estimation::yaw::YawSettings;
use remote::ProviderSettings;
use remote::settings::{AnalystProvider, ImageGeneratorProvider, MeshProvider, SegmenterProvider};
use render::RenderSettings;
use vision::NetworkReadingSettings;
use vision::category_fit::CategoryFitSettings;
use vision::descriptor::DescriptorSettings;

pub use error::{ConfigError, ConfigErrors};
pub use layers::{Origin, Resolved, Sources};

/// Every setting; sections in the order of `default.toml`.
#[derive(Clone, Debug, Serialize, Deserialize, PartialEq)]
#[serde(deny_unknown_fields)]
pub struct Config {
    pub server: api::Settings,
    pub store: store::Settings,
    pub worker: worker::Settings,
    pub queue: store::queue::Settings,
    pub batches: store::batches::Settings,
    pub webhooks: webhooks::Settings,
    pub compute: ComputeSettings,
    pub log: LogSettings,
    pub telemetry: TelemetrySettings,
    pub features: FeatureSettings,
    pub network: NetworkSettings,
    pub catalog: CatalogSettings,
    pub providers: ProviderSettings,
    pub analyst: text_parser::TextParserSettings,
    pub layout: LayoutSettings,
    pub image_generator: ImageGeneratorSettings,
    pub mesh_generator: MeshSettings,
    pub photograph: PhotographSettings,
    pub category_fit: CategoryFitSettings,
    pub descriptor: DescriptorSettings,
    pub render: RenderSettings,
    pub canonicalize: UprightSettings,
    pub decompose: DecomposeSettings,
    pub dro: YawSettings,
    pub tsa: TopViewSettings,
    pub settle: SettleSettings,
    pub resolve: ResolveSettings,
    pub no_room: NoSpaceSettings,
    pub certify: CertifySettings,
    pub fidelity: FidelitySettings,
    pub health: HealthSettings,
    pub appraise: AppraiseSettings,
    pub grasps: GraspSettings,
    pub execution: ExecutionSettings,
    pub preview: PreviewSettings,
    pub export: ExportSettings,
}

/// Section `[network]`.
#[derive(Clone, Debug, Serialize, Deserialize, PartialEq)]
pub struct NetworkSettings {
    /// `built-in`, or the safetensors file of a network that reads images; read at start. Empty is an error.
    pub weights: String,
    #[serde(flatten)]
    pub reading: NetworkReadingSettings,
}

/// Section `[catalog]`.
#[derive(Clone, Debug, Serialize, Deserialize, PartialEq)]
#[serde(deny_unknown_fields)]
pub struct CatalogSettings {
    /// Files with categories of the user and folders of them, separated by commas; read at start.
    pub paths: String,
}

/// Section `[log]`.
#[derive(Clone, Debug, Serialize, Deserialize, PartialEq)]
#[serde(deny_unknown_fields)]
pub struct LogSettings {
    /// Lines for people, or JSON for machines.
    pub format: LogFormat,
    /// `tracing` directives: which lines are written. More detail costs time and disk.
    pub filter: String,
    /// A line per answered request.
    pub access: bool,
}

/// Section `[telemetry]`.
#[derive(Clone, Debug, Serialize, Deserialize, PartialEq)]
#[serde(deny_unknown_fields)]
pub struct TelemetrySettings {
    /// URL to which spans are sent by OTLP (HTTP, protobuf); empty sends none.
    pub traces_endpoint: String,
    /// Share of traces that are kept (0..=1), decided by the id of the trace.
    pub sample_ratio: f64,
    /// Spans that wait to be sent; more are dropped.
    pub max_queue_spans: usize,
    /// Longest time of one send, seconds.
    pub timeout_secs: u64,
}

/// Form of the log's lines.
#[derive(Clone, Copy, Debug, Serialize, Deserialize, PartialEq, Eq)]
#[serde(rename_all = "snake_case")]
pub enum LogFormat {
    /// For people.
    Text,
    /// One JSON object a line.
    Json,
}

impl Config {
    /// Whether scenes call models that may cost money.
    pub fn calls_remote_models(&self) -> bool {
        let providers = &self.providers;
        providers.analyst.iter().any(|provider| *provider != AnalystProvider::Embedded)
            || providers.image_generator.iter().any(|provider| *provider != ImageGeneratorProvider::Embedded)
            || providers.segmenter.iter().any(|provider| *provider != SegmenterProvider::Embedded)
            || providers.mesh_generator.iter().any(|provider| *provider != MeshProvider::Embedded)
    }
}

/// Whether a request may set a key (`section.name`) to this value. The keys are those with `; request` in
/// `default.toml`: what shapes a scene at little cost. Settings whose cost grows without bound, thresholds of the
/// certificate, files of this machine and services that cost money are the operator's.
pub fn is_open_to_requests(key: &str, text: &str) -> bool {
    keys::keys().get(key).is_some_and(|key| value::parse_for_request(key, text).is_ok())
}

#[cfg(test)]
mod tests;
