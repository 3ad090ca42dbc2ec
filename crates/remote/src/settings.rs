//! Section `[providers]`: who answers which port, and on what terms the network is used.

use serde::{Deserialize, Serialize};

use ports::ledger::OnUnknown;

/// Section `[providers]`.
#[derive(Clone, Debug, Serialize, Deserialize, PartialEq)]
#[serde(deny_unknown_fields)]
pub struct ProviderSettings {
    /// Who answers the analyst's port: the first, and where that cannot, the next.
    pub analyst: Vec<AnalystProvider>,
    /// Who answers the painter's port, likewise.
    pub painter: Vec<PainterProvider>,
    /// Who answers the segmenter's port, likewise.
    pub segmenter: Vec<SegmenterProvider>,
    /// Who answers the mesh generator's port, likewise.
    pub mesh_generator: Vec<MeshProvider>,
    /// Whether the network is spoken to, recorded, or replaced by a recording.
    pub mode: LineMode,
    /// The recording: a folder, or, to be played, also a ZIP archive of one; empty where there is none.
    pub cassette: String,
    /// Plain HTTP may be used. Keys and pictures are then readable on the way.
    pub allow_http: bool,
    /// Hosts, or `host:port`, that may be private addresses; separated by spaces.
    pub private_hosts: String,
    /// What to do about a call whose answer was lost.
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

/// What calls are made through.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum LineMode {
    /// The network.
    Live,
    /// The network; answers are kept.
    Record,
    /// A recording; nothing is sent.
    Replay,
}

/// Who can answer the analyst's port.
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

/// Who can answer the painter's port.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum PainterProvider {
    /// Our renderer, and geometry.
    Embedded,
    /// The endpoints of `[providers.openai_images]`.
    OpenaiImages,
    /// The endpoint of `[providers.ark]`.
    Ark,
}

/// Who can answer the segmenter's port.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum SegmenterProvider {
    /// What the painter knows, or looking.
    Embedded,
    /// The server of `[providers.segmenter_sidecar]`.
    Sidecar,
}

/// Who can answer the mesh generator's port.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum MeshProvider {
    /// The catalog, and solids fitted to one view.
    Embedded,
    /// The model of `[providers.replicate]`.
    Replicate,
    /// The server of `[providers.hunyuan3d]`.
    Hunyuan3d,
    /// The service of `[providers.tencent]`.
    Tencent,
}

/// Where a vendor is asked, with which key, and how patiently.
#[derive(Clone, Debug, Serialize, Deserialize, PartialEq)]
pub struct EndpointSettings {
    /// What paths are appended to.
    pub base_url: String,
    /// Environment variable with the key, or, with `_FILE` appended, with the path of a file that holds it. Neither: no
    /// key is sent.
    pub key_variable: String,
    #[serde(flatten)]
    pub limits: LimitSettings,
}

/// An OpenAI-compatible chat endpoint: sections `[providers.chat]` and `[providers.second_chat]`.
#[derive(Clone, Debug, Serialize, Deserialize, PartialEq)]
pub struct ChatSettings {
    /// Its base URL is what `/chat/completions` is appended to.
    #[serde(flatten)]
    pub endpoint: EndpointSettings,
    /// The model's name at that endpoint.
    pub model: String,
    /// What the server can promise about the form of answers.
    pub schema: SchemaSupport,
    /// Name of the field that limits the answer's length.
    pub token_limit_field: TokenLimitField,
    /// Longest answer, tokens (256..=200000). Less truncates tables with many things; more is reserved of the budget.
    pub max_output_tokens: u32,
    /// How freely the model chooses its words (-1..=2); below 0 nothing is sent, and the model's own applies.
    pub temperature: f64,
    /// Whether the request's seed is sent.
    pub send_seed: bool,
    /// How closely the model is asked to look at pictures.
    pub detail: PictureDetail,
    /// Longer side of the picture that is sent, pixels (256..=2048). More shows smaller things and costs more.
    pub picture_px: u32,
    /// The most tokens that a picture of that size counts as (1..=100000); what is reserved of the budget.
    pub picture_tokens: u32,
    /// Header that carries an idempotency key, where the server knows one; empty = none is sent.
    pub idempotency_header: String,
    /// Price of a million input tokens, US dollars.
    pub input_usd_per_million: f64,
    /// Price of a million output tokens, US dollars.
    pub output_usd_per_million: f64,
}

/// OpenAI's Images endpoints: section `[providers.openai_images]`.
#[derive(Clone, Debug, Serialize, Deserialize, PartialEq)]
pub struct ImagesSettings {
    /// Its base URL is what `/images/generations` and `/images/edits` are appended to.
    #[serde(flatten)]
    pub endpoint: EndpointSettings,
    /// The model's name at that endpoint; it has to take several pictures and to know transparent backgrounds.
    pub model: String,
    /// Size of reference pictures.
    pub reference_size: ReferenceSize,
    /// How much work goes into a picture; high costs most.
    pub quality: PictureQuality,
    /// How closely redrawn things follow what is sent; high costs more.
    pub input_fidelity: InputFidelity,
    /// Drawings asked for again where one cannot be used (0..=5).
    pub redraws: u32,
    /// Least agreement of a redrawn thing's outline with what is visible of it, intersection over union (0..=1).
    pub least_agreement: f64,
    /// The most tokens that a sent picture counts as (1..=100000); what is reserved of the budget.
    pub picture_tokens: u32,
    /// The most tokens that a drawn picture counts as (1..=100000).
    pub drawn_tokens: u32,
    /// Price of a million tokens of text that is sent, US dollars.
    pub text_usd_per_million: f64,
    /// Price of a million tokens of pictures that are sent, US dollars.
    pub picture_usd_per_million: f64,
    /// Price of a million tokens of pictures that are drawn, US dollars.
    pub drawn_usd_per_million: f64,
}

/// Ark's Seedream: section `[providers.ark]`.
#[derive(Clone, Debug, Serialize, Deserialize, PartialEq)]
pub struct ArkSettings {
    /// Its base URL is what `/images/generations` is appended to.
    #[serde(flatten)]
    pub endpoint: EndpointSettings,
    /// The model's name at that endpoint: Seedream 4.0 or later.
    pub model: String,
    /// Size of pictures: `1K`, `2K`, `4K`, or pixels.
    pub size: String,
    /// Size of redrawn things, square, pixels.
    pub thing_size: String,
    /// Least agreement of a redrawn thing's outline with what is visible of it, intersection over union (0..=1).
    pub least_agreement: f64,
    /// Pictures asked for again where one cannot be used (0..=5).
    pub redraws: u32,
    /// Price of a picture, US dollars.
    pub usd_per_picture: f64,
}

/// A segmentation sidecar: section `[providers.segmenter_sidecar]`.
#[derive(Clone, Debug, Serialize, Deserialize, PartialEq)]
pub struct SidecarSettings {
    /// Its base URL is what `/v1/segment` is appended to.
    #[serde(flatten)]
    pub endpoint: EndpointSettings,
    /// What it runs, as results and keys name it: another model behind the same address wants another name here.
    pub model: String,
    /// Least score of a box (0..=1). More finds less, and less that is not there.
    pub box_threshold: f64,
    /// Least score of a word of a box (0..=1).
    pub text_threshold: f64,
    /// Price of a call, US dollars.
    pub usd_per_call: f64,
}

/// Replicate-style predictions: section `[providers.replicate]`.
#[derive(Clone, Debug, Serialize, Deserialize, PartialEq)]
pub struct ReplicateSettings {
    /// Its base URL is what `/predictions` is appended to.
    #[serde(flatten)]
    pub endpoint: EndpointSettings,
    /// The model's version, as the vendor names it.
    pub version: String,
    /// The model's input that takes the picture.
    pub image_input: String,
    /// The model's input that takes the seed; empty = it has none.
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
    /// Its base URL is what `/send` and `/status` are appended to.
    #[serde(flatten)]
    pub endpoint: EndpointSettings,
    /// What it runs, as results and keys name it.
    pub model: String,
    /// Cells along an edge of the octree the shape is read from (64..=1024). More is finer and takes longer.
    pub octree_resolution: u32,
    /// Steps of the shape's diffusion (1..=200).
    pub inference_steps: u32,
    /// How closely the shape follows the picture (0..=50).
    pub guidance_scale: f64,
    /// Whether the server paints its meshes; it has to be started so.
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
    /// The first label of its address is signed with as the service's name.
    #[serde(flatten)]
    pub endpoint: EndpointSettings,
    /// Version of the API, a date.
    pub version: String,
    /// Region that is asked for; empty = none.
    pub region: String,
    /// The model's version: 3.0 or 3.1.
    pub model: String,
    /// Environment variable with the secret id, likewise.
    pub id_variable: String,
    /// Faces of the meshes that are asked for (40000..=1500000).
    pub face_count: u32,
    /// Price of a mesh, US dollars.
    pub usd_per_mesh: f64,
    #[serde(flatten)]
    pub mesh: MeshSettings,
    #[serde(flatten)]
    pub task: TaskSettings,
}

/// What is sent to a mesh generator, and what is taken from it.
#[derive(Clone, Debug, Serialize, Deserialize, PartialEq)]
pub struct MeshSettings {
    /// Side of the square picture that is sent, pixels (128..=2048).
    pub picture_px: u32,
    /// Most triangles that are kept (1000..=1000000); a finer mesh is reduced, its texture kept.
    pub most_triangles: usize,
    /// SPDX identifier of the licence that the model's meshes come under.
    pub licence: String,
    /// What a reader of the scene has to know about it, such as territories where it does not hold; may be empty.
    pub licence_note: String,
}

/// Terms of a vendor's jobs.
#[derive(Clone, Debug, Serialize, Deserialize, PartialEq)]
pub struct TaskSettings {
    /// Time between two looks at a vendor's job, milliseconds (10..=600000).
    pub look_every_ms: u64,
    /// Longest time of a vendor's job, seconds (1..=86400).
    pub task_timeout_secs: u64,
    /// Vendor's jobs at the same time (1..=1024).
    pub vendor_jobs: usize,
}

/// Size of a painted picture, pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum ReferenceSize {
    #[serde(rename = "1024x1024")]
    Square,
    #[serde(rename = "1536x1024")]
    Wide,
}

impl ReferenceSize {
    /// As it is spelled in forms.
    pub fn word(self) -> &'static str {
        match self {
            Self::Square => "1024x1024",
            Self::Wide => "1536x1024",
        }
    }
}

/// How much work goes into a picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum PictureQuality {
    Low,
    Medium,
    High,
}

impl PictureQuality {
    /// As it is spelled in forms.
    pub fn word(self) -> &'static str {
        match self {
            Self::Low => "low",
            Self::Medium => "medium",
            Self::High => "high",
        }
    }
}

/// How closely a drawing follows the pictures that are sent.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum InputFidelity {
    /// Nothing is sent, which some models insist on.
    Unsaid,
    Low,
    High,
}

/// Terms of one endpoint.
#[derive(Clone, Debug, Serialize, Deserialize, PartialEq)]
pub struct LimitSettings {
    /// Longest time of one try, seconds (1..=3600).
    pub attempt_timeout_secs: u64,
    /// Longest time of all tries of one call with the pauses between them, seconds (1..=86400).
    pub total_timeout_secs: u64,
    /// Tries of one call (1..=10).
    pub max_tries: u32,
    /// The first pause is half of this on average, milliseconds; it doubles with every try.
    pub pause_base_ms: u64,
    /// Longest pause, milliseconds; where a server asks for more, the job goes back to its queue.
    pub pause_cap_ms: u64,
    /// Largest answer, bytes.
    pub max_answer_bytes: usize,
    /// Calls with the same key at the same time (1..=1024).
    pub concurrency: usize,
    /// Calls with the same key begun in a minute (1..=1000000), evenly spaced.
    pub calls_per_minute: u32,
    /// Failures in a row after which the endpoint is left alone (1..=1000).
    pub breaker_failures: u32,
    /// For how long it is left alone before one call tries again, seconds (1..=86400).
    pub breaker_rest_secs: u64,
}

/// What a server can promise about the form of answers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum SchemaSupport {
    /// Answers follow a JSON schema (`json_schema`, strict).
    Strict,
    /// Answers are JSON (`json_object`); the schema stands in the prompt.
    JsonObject,
}

/// Name of the field that limits an answer's length.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum TokenLimitField {
    MaxCompletionTokens,
    MaxTokens,
}

/// How closely a model is asked to look at pictures.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum PictureDetail {
    Auto,
    Low,
    High,
}
