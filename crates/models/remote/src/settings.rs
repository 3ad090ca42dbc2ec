//! Section `[providers]`: the adapters of each port, their endpoints and limits.

use serde::{Deserialize, Serialize};

use ports::ledger::OnUnknown;

/// Section `[providers]`.
#[derive(Clone, Debug, Serialize, Deserialize, PartialEq)]
#[serde(deny_unknown_fields)]
pub struct ProviderSettings {
    /// Adapters of the analyst port in order of preference: where one cannot answer, the next is asked.
    pub analyst: Vec<AnalystProvider>,
    /// Adapters of the image generator port, likewise.
    pub image_generator: Vec<ImageGeneratorProvider>,
    /// Adapters of the segmenter port, likewise.
    pub segmenter: Vec<SegmenterProvider>,
    /// Adapters of the mesh generator port, likewise.
    pub mesh_generator: Vec<MeshProvider>,
    /// Transport of calls: the network, the network with a recording, or a replayed recording.
    pub mode: TransportMode,
    /// The cassette: a folder, or for replay also a ZIP archive of one; empty where there is none.
    pub cassette: String,
    /// Whether plain HTTP is allowed. Keys and images are then sent unencrypted.
    pub allow_http: bool,
    /// Hosts, or `host:port`, that may be private addresses; separated by spaces.
    pub private_hosts: String,
    /// The policy for a call whose answer was lost.
    pub on_unknown: OnUnknown,
    /// Longest time to open a connection, seconds (1..=600).
    pub connect_timeout_secs: u64,
    pub chat: ChatSettings,
    pub second_chat: ChatSettings,
    pub openai_images: ImagesSettings,
    pub ark: ArkSettings,
    pub segmenter_sidecar: SidecarSettings,
    pub replicate: ReplicateSettings,
    pub hunyuan3d: Hunyuan3dSettings,
    pub tencent: TencentSettings,
}

/// The transport of calls.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum TransportMode {
    /// The network.
    Live,
    /// The network; every response is recorded.
    Record,
    /// A recording; nothing is sent.
    Replay,
}

/// Adapters of the analyst port.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum AnalystProvider {
    /// Grammar, catalog and geometry.
    Embedded,
    /// The endpoint of `[providers.chat]`.
    Chat,
    /// The endpoint of `[providers.second_chat]`.
    SecondChat,
}

/// Adapters of the image generator port.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ImageGeneratorProvider {
    /// The embedded renderer and amodal completion.
    Embedded,
    /// The endpoints of `[providers.openai_images]`.
    OpenaiImages,
    /// The endpoint of `[providers.ark]`.
    Ark,
}

/// Adapters of the segmenter port.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum SegmenterProvider {
    /// The ground truth of rendered images, else the embedded vision.
    Embedded,
    /// The server of `[providers.segmenter_sidecar]`.
    Sidecar,
}

/// Adapters of the mesh generator port.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum MeshProvider {
    /// Catalog meshes and solids fitted to one view.
    Embedded,
    /// The model of `[providers.replicate]`.
    Replicate,
    /// The server of `[providers.hunyuan3d]`.
    Hunyuan3d,
    /// The service of `[providers.tencent]`.
    Tencent,
}

/// An endpoint: address, key and limits.
#[derive(Clone, Debug, Serialize, Deserialize, PartialEq)]
pub struct EndpointSettings {
    /// The URL to which paths are appended.
    pub base_url: String,
    /// Environment variable with the key; with `_FILE` appended, the variable with the path of a file that holds it.
    /// Without either, no key is sent.
    pub key_variable: String,
    #[serde(flatten)]
    pub limits: LimitSettings,
}

/// An OpenAI-compatible chat endpoint: sections `[providers.chat]` and `[providers.second_chat]`.
#[derive(Clone, Debug, Serialize, Deserialize, PartialEq)]
pub struct ChatSettings {
    /// The base URL of `/chat/completions`.
    #[serde(flatten)]
    pub endpoint: EndpointSettings,
    /// The model's name at that endpoint.
    pub model: String,
    /// The response format that the server supports.
    pub schema: SchemaSupport,
    /// Name of the field that limits the answer's length.
    pub token_limit_field: TokenLimitField,
    /// Maximum length of an answer, tokens (256..=200000). Lower: answers about many objects are truncated; higher:
    /// larger reservations.
    pub max_output_tokens: u32,
    /// Sampling temperature (-1..=2); below 0 none is sent, and the model's default applies.
    pub temperature: f64,
    /// Whether the request's seed is sent.
    pub send_seed: bool,
    /// The level of detail at which the model reads images.
    pub detail: ImageDetail,
    /// Longer side of sent images, pixels (256..=2048). Higher: smaller objects are visible, at a higher price.
    pub image_px: u32,
    /// Maximum tokens of an image of that size (1..=100000), for the reservation.
    pub image_tokens: u32,
    /// Header of the idempotency key, where the server supports one; empty = none is sent.
    pub idempotency_header: String,
    /// Price of a million input tokens, US dollars.
    pub input_usd_per_million: f64,
    /// Price of a million output tokens, US dollars.
    pub output_usd_per_million: f64,
}

/// OpenAI's Images endpoints: section `[providers.openai_images]`.
#[derive(Clone, Debug, Serialize, Deserialize, PartialEq)]
pub struct ImagesSettings {
    /// The base URL of `/images/generations` and `/images/edits`.
    #[serde(flatten)]
    pub endpoint: EndpointSettings,
    /// The model's name at that endpoint; it must accept several images and support transparent backgrounds.
    pub model: String,
    /// Size of reference images.
    pub reference_size: ReferenceSize,
    /// Rendering quality; high costs most.
    pub quality: ImageQuality,
    /// Fidelity of inpainted objects to the sent images; high costs more.
    pub input_fidelity: InputFidelity,
    /// Repeated requests after an unusable image (0..=5).
    pub redraws: u32,
    /// Minimum agreement of an inpainted outline with the visible mask, intersection over union (0..=1).
    pub min_agreement: f64,
    /// Maximum tokens of a sent image (1..=100000), for the reservation.
    pub image_tokens: u32,
    /// Maximum tokens of a generated image (1..=100000), for the reservation.
    pub drawn_tokens: u32,
    /// Price of a million tokens of sent text, US dollars.
    pub text_usd_per_million: f64,
    /// Price of a million tokens of sent images, US dollars.
    pub image_usd_per_million: f64,
    /// Price of a million tokens of generated images, US dollars.
    pub drawn_usd_per_million: f64,
}

/// Ark's Seedream: section `[providers.ark]`.
#[derive(Clone, Debug, Serialize, Deserialize, PartialEq)]
pub struct ArkSettings {
    /// The base URL of `/images/generations`.
    #[serde(flatten)]
    pub endpoint: EndpointSettings,
    /// The model's name at that endpoint: Seedream 4.0 or later.
    pub model: String,
    /// Size of images: `1K`, `2K`, `4K`, or pixels.
    pub size: String,
    /// Size of inpainted objects, square, pixels.
    pub object_size: String,
    /// Minimum agreement of an inpainted outline with the visible mask, intersection over union (0..=1).
    pub min_agreement: f64,
    /// Repeated requests after an unusable image (0..=5).
    pub redraws: u32,
    /// Price of an image, US dollars.
    pub usd_per_image: f64,
}

/// A segmentation sidecar: section `[providers.segmenter_sidecar]`.
#[derive(Clone, Debug, Serialize, Deserialize, PartialEq)]
pub struct SidecarSettings {
    /// The base URL of `/v1/segment`.
    #[serde(flatten)]
    pub endpoint: EndpointSettings,
    /// The name of the model, as results and keys state it. Another model at the same address needs another name.
    pub model: String,
    /// Minimum score of a box (0..=1). Higher: lower recall, fewer false positives.
    pub box_threshold: f64,
    /// Minimum score of a token of a box (0..=1).
    pub text_threshold: f64,
    /// Price of a call, US dollars.
    pub usd_per_call: f64,
}

/// Replicate-style predictions: section `[providers.replicate]`.
#[derive(Clone, Debug, Serialize, Deserialize, PartialEq)]
pub struct ReplicateSettings {
    /// The base URL of `/predictions`.
    #[serde(flatten)]
    pub endpoint: EndpointSettings,
    /// The model's version, as the vendor names it.
    pub version: String,
    /// The model's input for the image.
    pub image_input: String,
    /// The model's input for the seed; empty = it has none.
    pub seed_input: String,
    /// The model's other inputs, a JSON object.
    pub inputs: String,
    /// Price of a prediction, US dollars.
    pub usd_per_prediction: f64,
    #[serde(flatten)]
    pub mesh: MeshSettings,
    #[serde(flatten)]
    pub task: TaskSettings,
}

/// A server of Hunyuan3D-2 or 2.1: section `[providers.hunyuan3d]`.
#[derive(Clone, Debug, Serialize, Deserialize, PartialEq)]
pub struct Hunyuan3dSettings {
    /// The base URL of `/send` and `/status`.
    #[serde(flatten)]
    pub endpoint: EndpointSettings,
    /// The name of the model, as results and keys state it.
    pub model: String,
    /// Cells along an edge of the octree of the shape (64..=1024). Higher: finer and slower.
    pub octree_resolution: u32,
    /// Diffusion steps of the shape (1..=200).
    pub inference_steps: u32,
    /// Guidance scale: how closely the shape follows the image (0..=50).
    pub guidance_scale: f64,
    /// Whether the server textures its meshes; it must be started with texturing.
    pub texture: bool,
    /// Price of a mesh, US dollars.
    pub usd_per_mesh: f64,
    #[serde(flatten)]
    pub mesh: MeshSettings,
    #[serde(flatten)]
    pub task: TaskSettings,
}

/// Tencent Cloud's Hunyuan3D Pro: section `[providers.tencent]`.
#[derive(Clone, Debug, Serialize, Deserialize, PartialEq)]
pub struct TencentSettings {
    /// The first label of its host is the service name in signatures.
    #[serde(flatten)]
    pub endpoint: EndpointSettings,
    /// Version of the API, a date.
    pub version: String,
    /// Requested region; empty = none.
    pub region: String,
    /// The model's version: 3.0 or 3.1.
    pub model: String,
    /// Environment variable with the secret id, as `key_variable`.
    pub id_variable: String,
    /// Requested number of faces (40000..=1500000).
    pub face_count: u32,
    /// Price of a mesh, US dollars.
    pub usd_per_mesh: f64,
    #[serde(flatten)]
    pub mesh: MeshSettings,
    #[serde(flatten)]
    pub task: TaskSettings,
}

/// Input image and accepted mesh of a mesh generator.
#[derive(Clone, Debug, Serialize, Deserialize, PartialEq)]
pub struct MeshSettings {
    /// Side of the square input image, pixels (128..=2048).
    pub image_px: u32,
    /// Maximum triangles (1000..=1000000); a finer mesh is decimated and keeps its texture.
    pub max_triangles: usize,
    /// SPDX identifier of the licence of the model's meshes.
    pub licence: String,
    /// Note on the licence for users of the scene, such as excluded territories; may be empty.
    pub licence_note: String,
}

/// Limits of a vendor's jobs.
#[derive(Clone, Debug, Serialize, Deserialize, PartialEq)]
pub struct TaskSettings {
    /// Interval of status queries, milliseconds (10..=600000).
    pub poll_interval_ms: u64,
    /// Deadline of a vendor's job, seconds (1..=86400).
    pub task_timeout_secs: u64,
    /// Concurrent jobs at the vendor (1..=1024).
    pub vendor_jobs: usize,
}

/// Size of a generated image, pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum ReferenceSize {
    #[serde(rename = "1024x1024")]
    Square,
    #[serde(rename = "1536x1024")]
    Wide,
}

impl ReferenceSize {
    /// The value in request forms.
    pub fn word(self) -> &'static str {
        match self {
            Self::Square => "1024x1024",
            Self::Wide => "1536x1024",
        }
    }
}

/// Rendering quality.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ImageQuality {
    Low,
    Medium,
    High,
}

impl ImageQuality {
    /// The value in request forms.
    pub fn word(self) -> &'static str {
        match self {
            Self::Low => "low",
            Self::Medium => "medium",
            Self::High => "high",
        }
    }
}

/// Fidelity of a generated image to the sent images.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum InputFidelity {
    /// The parameter is omitted, as some models require.
    Unsaid,
    Low,
    High,
}

/// Limits of one endpoint.
#[derive(Clone, Debug, Serialize, Deserialize, PartialEq)]
pub struct LimitSettings {
    /// Deadline of one attempt, seconds (1..=3600).
    pub attempt_timeout_secs: u64,
    /// Deadline of all attempts of one call with their pauses, seconds (1..=86400).
    pub total_timeout_secs: u64,
    /// Maximum attempts of one call (1..=10).
    pub max_tries: u32,
    /// Twice the average first pause, milliseconds; pauses double with every attempt.
    pub pause_base_ms: u64,
    /// Longest pause, milliseconds; where a server requests more, the job returns to its queue.
    pub pause_cap_ms: u64,
    /// Maximum size of a response, bytes.
    pub max_answer_bytes: usize,
    /// Concurrent calls with the same key (1..=1024).
    pub concurrency: usize,
    /// Calls with the same key that start within a minute (1..=1000000), evenly spaced.
    pub calls_per_minute: u32,
    /// Consecutive failures that open the circuit breaker (1..=1000).
    pub breaker_failures: u32,
    /// Cooldown before a probe call, seconds (1..=86400).
    pub breaker_rest_secs: u64,
}

/// The response format that a server supports.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum SchemaSupport {
    /// Answers follow a JSON schema (`json_schema`, strict).
    Strict,
    /// Answers are JSON (`json_object`); the prompt holds the schema.
    JsonObject,
}

/// The request field that limits the length of an answer.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum TokenLimitField {
    MaxCompletionTokens,
    MaxTokens,
}

/// The level of detail at which a model reads images.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ImageDetail {
    Auto,
    Low,
    High,
}
