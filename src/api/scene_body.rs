//! The body of `POST /scenes`: JSON, or multipart with the image as a file.

use std::collections::BTreeMap;

use axum::extract::Request;
use bytes::Bytes;
use schemars::JsonSchema;
use serde::Deserialize;

use super::admission::overloaded;
use super::body::BodyReader;
use super::body_memory::Reservation;
use super::data_uri::Base64Image;
use super::extract::{JsonRequest, TenantApi};
use super::form_body::{self, Form};
pub use super::json_body::parse;
use super::json_body::{media_type, parse_apart};
use super::query::Time;
use crate::app::image;
use crate::app::submission::{SceneOrder, Submission};
use crate::app::terms::Terms;
use crate::problem::{FieldError, Problem, ProblemType};
use crate::schemas::narrowed_types;
use crate::schemas::scene_request::Labels;
use crate::schemas::values::{Deadline, NotBefore, OptionalSeed, Priority, SceneText};
use scene::request::RequestOptions;

/// The wire form of a request, not validated: the JSON body, or the `request` field of a multipart body.
#[derive(Clone, Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct SceneBody {
    /// Description of the objects on the table; beside an image, of its content, with counts, colors, materials,
    /// lengths and masses. There it provides labels and properties of the objects that are found; the image decides
    /// about the table and all places.
    #[schemars(with = "Option<SceneText>")]
    pub text: Option<String>,
    #[schemars(with = "Option<ImageChoice>")]
    pub image: Option<ImageSource>,
    #[schemars(with = "OptionalSeed")]
    pub seed: Option<u64>,
    #[schemars(with = "Labels")]
    pub labels: BTreeMap<String, String>,
    pub options: RequestOptions,
    #[schemars(with = "Priority")]
    pub priority: Option<i64>,
    #[schemars(with = "NotBefore")]
    pub not_before: Option<Time>,
    #[schemars(with = "Deadline")]
    pub deadline: Option<Time>,
}

/// URL of an image, or its bytes; one of them.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ImageSource {
    /// A complete PNG, JPEG or WebP file of one still image, at most 20 MB and 64 megapixels, at least 160 pixels a
    /// side; alone or as a data URI (`data:image/png;base64,...`), whose media type must be that of the bytes.
    #[schemars(with = "Option<String>", extend("contentEncoding" = "base64"))]
    pub base64: Option<Base64Image>,
    /// URL of such a file: https, at a public address. The file is fetched before the request is answered.
    #[schemars(url)]
    pub url: Option<String>,
}

/// The source of a scene is exactly one of `text` and `image`. Beside an image, a text names what is in it. An image as
/// a file comes in a form.
#[derive(JsonSchema)]
#[schemars(untagged)]
pub enum SceneSubmission {
    Text(TextSubmission),
    Image(ImageSubmission),
}

narrowed_types! {
    "A scene from a text." TextSubmission = SceneBody, Some("text"), &["image"];
    "A scene from an image." ImageSubmission = SceneBody, Some("image"), &[];
    "Request beside the file." FormRequest = SceneBody, None, &["image"];
    "An image in the body." ImageBytes = ImageSource, Some("base64"), &["url"];
    "An image elsewhere." ImageUrl = ImageSource, Some("url"), &["base64"];
}

/// Bytes of an image, or its URL.
#[derive(JsonSchema)]
#[schemars(inline, untagged)]
pub enum ImageChoice {
    Bytes(ImageBytes),
    Url(ImageUrl),
}

/// A scene from an image file.
#[derive(JsonSchema)]
#[schemars(deny_unknown_fields)]
pub struct SceneForm {
    /// A PNG, JPEG or WebP file that does not move; its first bytes decide, not its name.
    #[schemars(extend("format" = "binary"))]
    pub image: String,
    /// A PNG file of one 16-bit channel with the depth of each pixel of the upright image along the optical axis,
    /// millimeters; 0 = not measured. It has the ratio of the sides of the image. The settings of the request state the
    /// camera: `photograph.intrinsics_px`, or `photograph.field_of_view_rad` where the EXIF data do not.
    #[schemars(extend("format" = "binary", "type" = "string"))]
    pub depth: Option<String>,
    #[schemars(default)]
    pub request: FormRequest,
}

impl JsonRequest for SceneBody {
    type Schema = SceneSubmission;
    const EXAMPLE: &str = r#"{"text": "A breakfast table with two mugs and a bowl of apples", "seed": 7}"#;
    const IS_SMALL: bool = false;
}

impl SceneBody {
    /// The order of the body. `image` is the content of an image file, wherever it came from, and `depth` that of its
    /// depth image; [`Self::image`] is not read.
    pub fn order(self, image: Option<Bytes>, depth: Option<Bytes>) -> SceneOrder {
        let Self { text, image: _, seed, labels, options, priority, not_before, deadline } = self;
        SceneOrder {
            text,
            image,
            depth,
            terms: terms(seed, labels, options, (priority, not_before, deadline)),
        }
    }
}

/// The terms of a body, with priority, earliest start and deadline of its job.
pub(super) fn terms(
    seed: Option<u64>,
    labels: BTreeMap<String, String>,
    options: RequestOptions,
    (priority, not_before, deadline): (Option<i64>, Option<Time>, Option<Time>),
) -> Terms {
    let (not_before_ms, deadline_ms) = (not_before.map(Time::as_ms), deadline.map(Time::as_ms));
    Terms { seed, labels, options, priority: priority.unwrap_or(0), not_before_ms, deadline_ms }
}

/// Files of a form.
#[derive(Debug, Default)]
pub struct Files {
    pub image: Option<Bytes>,
    pub depth: Option<Bytes>,
}

/// Reads the body of a request, loads its image, and checks both. The reservation covers the image.
///
/// # Errors
///
/// A [`Problem`] where the body does not arrive within the limits, or will not do.
pub async fn receive(api: &TenantApi, request: Request) -> Result<(Submission, Reservation), Problem> {
    let (parts, body) = request.into_parts();
    let (body, files, memory) = match media_type(&parts.headers).as_str() {
        "application/json" => {
            let reader = BodyReader::new(api, &parts, body, api.settings.max_body_bytes);
            let (body, memory) = parse_apart(api, &api.tenant_id, reader.collect().await?).await?;
            (body, Files::default(), memory)
        }
        "multipart/form-data" => {
            let Form { request, image, depth, memory } = form_body::read(api, parts, body).await?;
            if image.is_none() {
                return Err(Problem::new(
                    ProblemType::InvalidRequest,
                    "missing_field",
                    "the form has no file `image`; send a request without one as application/json",
                ));
            }
            (request.unwrap_or_default(), Files { image, depth }, memory)
        }
        _ => {
            return Err(Problem::new(
                ProblemType::UnsupportedMediaType,
                "body_format",
                "send application/json, or multipart/form-data with a file field `image`, and `depth` if there is one",
            ));
        }
    };
    check(api, body, files, memory).await
}

/// Loads the image of a body, unless it came as a file, and checks both. The reservation covers the image.
///
/// # Errors
///
/// A [`Problem`] where the image is not to be had, or body or image will not do.
pub async fn check(
    api: &TenantApi,
    mut body: SceneBody,
    Files { image, depth }: Files,
    mut memory: Reservation,
) -> Result<(Submission, Reservation), Problem> {
    let image = load_image(api, &mut body, image, &mut memory).await?;
    let files_bytes = image.iter().chain(&depth).map(Bytes::len).sum::<usize>();
    memory.shrink_to(files_bytes + body.text.as_ref().map_or(0, String::len));
    let _permit = api.requests.clone().try_acquire_owned().map_err(|_| overloaded())?;
    Ok((check_apart(api, body, Files { image, depth }).await?, memory))
}

/// The content of the image of the request: the file of the form, or what `body.image` names, which is taken out.
async fn load_image(
    api: &TenantApi,
    body: &mut SceneBody,
    file: Option<Bytes>,
    memory: &mut Reservation,
) -> Result<Option<Bytes>, Problem> {
    match (body.image.take(), file) {
        (None, file) => Ok(file),
        (Some(_), Some(_)) => Err(Problem::invalid(vec![FieldError::new(
            "",
            "the image is there twice; send it as the form's `image` or in `request`",
        )])),
        (Some(ImageSource { base64: Some(Base64Image(bytes)), url: None }), None) => Ok(Some(bytes)),
        (Some(ImageSource { base64: None, url: Some(url) }), None) => fetch(api, url, memory).await.map(Some),
        (Some(_), None) => Err(wrong_image("/image", "give `base64` or `url`")),
    }
}

/// An image by its address; a few at a time.
async fn fetch(api: &TenantApi, url: String, memory: &mut Reservation) -> Result<Bytes, Problem> {
    if !api.settings.fetch_images {
        let detail = "this server fetches no images; send the bytes as `base64` or as multipart";
        return Err(wrong_image("/image/url", detail));
    }
    let _permit = api.fetches.clone().try_acquire_owned().map_err(|_| overloaded())?;
    memory.grow_to(memory.bytes() + api.settings.max_image_bytes)?;
    let fetched = api.fetcher.fetch(url, api.settings.max_image_bytes).await;
    fetched.map_err(|error| wrong_image("/image/url", &error.to_string()))
}

fn wrong_image(pointer: &str, detail: &str) -> Problem {
    Problem::invalid(vec![FieldError::new(pointer, detail)])
}

/// Checks an order: one with an image on a thread that may block. Images are decoded a few at a time, and of large ones
/// fewer.
async fn check_apart(api: &TenantApi, body: SceneBody, files: Files) -> Result<Submission, Problem> {
    let Files { image, depth } = files;
    let Some(bytes) = image.clone() else { return api.app.check_scene(body.order(None, depth)) };
    // The depths are decoded after the image, and into fewer bytes a pixel.
    let largest = [Some(bytes), depth.clone()];
    let blocks = move || largest.iter().flatten().map(|bytes| image::pixel_blocks(bytes)).max();
    let blocks = tokio::task::spawn_blocking(blocks).await.ok().flatten().unwrap_or(1);
    let pixels = api.pixel_blocks.clone().acquire_many_owned(blocks.min(api.max_pixel_blocks())).await.ok();
    let permits = (pixels, api.decoders.of(&api.tenant_id).await);
    let (app, order) = (api.app.clone(), body.order(image, depth));
    let checked = tokio::task::spawn_blocking(move || {
        let _permits = permits;
        app.check_scene(order)
    });
    checked.await.unwrap_or_else(|_| Err(image::unreadable("its decoder gave up")))
}
