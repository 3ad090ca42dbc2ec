//! The body of `POST /scenes`: JSON, or multipart with the image as a file.
//!
//! [`validate`] is a function of its own, so that the command line refuses the same requests.

use std::collections::BTreeMap;

use axum::body::{Body, to_bytes};
use axum::extract::{FromRequest, Multipart, Request};
use axum::http::{HeaderMap, header};
use bytes::Bytes;
use serde::Deserialize;
use serde_json::{Value, json};
use serde_path_to_error::Segment;
use uuid::Uuid;

use super::error::{FieldError, Problem, ProblemType};
use super::image::UploadedImage;
use super::json_detail::json_detail;
use super::{Api, Settings, Validate, data_uri, image};
use scene::Violation;
use scene::request::{MAX_SEED, RequestOptions};
use scene::{Input, SceneRequest, TenantId};
use store::scenes::NewScene;
use store::{Digest, Store, StoreError};

/// The wire form of a request, not validated: the JSON body, or the `request` field of a multipart body.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct SceneBody {
    /// What stands on the table; beside an image, what is in it.
    pub text: Option<String>,
    pub image: Option<ImageSource>,
    pub seed: Option<u64>,
    pub labels: BTreeMap<String, String>,
    pub options: RequestOptions,
}

/// Where an image is, or its bytes; one of them.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ImageSource {
    /// Base64, alone or as a data URI.
    pub base64: Option<String>,
    pub url: Option<String>,
}

/// A submission that may be enqueued.
#[derive(Debug)]
pub struct Submission {
    pub request: SceneRequest,
    pub labels: BTreeMap<String, String>,
    /// To be stored before the request that names it.
    pub image: Option<UploadedImage>,
    /// The same for the same content, whatever its form; a seed drawn here does not count.
    pub body_digest: Digest,
}

impl Submission {
    /// Stores the image, if there is one, and returns the row to insert. `default_budget_usd` applies to requests
    /// without a budget.
    ///
    /// # Errors
    ///
    /// A [`StoreError`] if the image cannot be stored.
    pub async fn into_row(
        self,
        store: &Store,
        tenant_id: TenantId,
        default_budget_usd: f64,
        idempotency_key: Option<String>,
    ) -> Result<NewScene, StoreError> {
        if let Some(image) = self.image {
            store.blobs().put(image.bytes).await?;
        }
        Ok(NewScene {
            tenant_id,
            budget_micro_usd: self.request.options.budget(default_budget_usd).0,
            request: json!(self.request),
            labels: self.labels,
            idempotency: idempotency_key.map(|key| (key, self.body_digest.to_string())),
        })
    }
}

/// Reads the body of a request, loads its image, and validates both.
pub async fn receive(api: &Api, request: Request) -> Result<Submission, Problem> {
    let limit = std::time::Duration::from_secs(api.settings.body_timeout_secs);
    let (mut body, file) = tokio::time::timeout(limit, read_body(api, request)).await.map_err(|_| {
        Problem::new(
            ProblemType::RequestTimeout,
            "body_too_slow",
            format!("the body did not arrive within {} seconds", limit.as_secs()),
        )
    })??;
    let image = load_image(api, &mut body, file).await?;
    validate_apart(api, body, image).await
}

async fn read_body(api: &Api, request: Request) -> Result<(SceneBody, Option<Bytes>), Problem> {
    let kind = media_type(request.headers());
    match kind.as_str() {
        "application/json" => Ok((parse(&json_bytes(api, request.into_body()).await?)?, None)),
        "multipart/form-data" => read_multipart(request).await,
        _ => Err(Problem::new(
            ProblemType::UnsupportedMediaType,
            "body_format",
            "send application/json, or multipart/form-data with a file field `image`",
        )),
    }
}

async fn read_multipart(request: Request) -> Result<(SceneBody, Option<Bytes>), Problem> {
    let refused = |status: axum::http::StatusCode, text: String| {
        if status == axum::http::StatusCode::PAYLOAD_TOO_LARGE {
            Problem::new(ProblemType::PayloadTooLarge, "body_too_large", "send a smaller image")
        } else {
            Problem::new(ProblemType::MalformedRequest, "malformed_multipart", text)
        }
    };
    let mut parts = Multipart::from_request(request, &())
        .await
        .map_err(|error| refused(error.status(), error.body_text()))?;
    let (mut body, mut file) = (None, None);
    while let Some(part) = parts.next_field().await.map_err(|e| refused(e.status(), e.body_text()))? {
        let name = part.name().unwrap_or_default().to_owned();
        let bytes = part.bytes().await.map_err(|e| refused(e.status(), e.body_text()))?;
        let twice = match name.as_str() {
            "image" => file.replace(bytes).is_some(),
            "request" => body.replace(parse(&bytes)?).is_some(),
            _ => {
                let shown: String = name.chars().take(40).collect();
                return Err(Problem::new(
                    ProblemType::InvalidRequest,
                    "unknown_field",
                    format!("the form's fields are `image` and `request`; {shown:?} is not known"),
                ));
            }
        };
        if twice {
            return Err(Problem::new(
                ProblemType::InvalidRequest,
                "repeated_field",
                format!("the form's field {name:?} comes twice; send it once"),
            ));
        }
    }
    Ok((body.unwrap_or_default(), file))
}

/// A JSON body within the limit.
pub async fn json_bytes(api: &Api, body: Body) -> Result<Bytes, Problem> {
    to_bytes(body, api.settings.max_body_bytes).await.map_err(|error| {
        if std::error::Error::source(&error)
            .is_some_and(|source| source.is::<http_body_util::LengthLimitError>())
        {
            Problem::new(
                ProblemType::PayloadTooLarge,
                "body_too_large",
                format!("send at most {} bytes", api.settings.max_body_bytes),
            )
        } else {
            Problem::new(ProblemType::MalformedRequest, "body_incomplete", "the body ended too early")
        }
    })
}

/// The media type without parameters, in lower case.
pub fn media_type(headers: &HeaderMap) -> String {
    let text = headers.get(header::CONTENT_TYPE).and_then(|kind| kind.to_str().ok()).unwrap_or_default();
    text.split(';').next().unwrap_or_default().trim().to_ascii_lowercase()
}

/// A typed value out of JSON, or the place where it stops being one.
pub fn parse<T: for<'de> Deserialize<'de>>(bytes: &[u8]) -> Result<T, Problem> {
    let malformed = |error: serde_json::Error| {
        Problem::new(ProblemType::MalformedRequest, "malformed_json", format!("the body is no JSON: {error}"))
    };
    let value: Value = serde_json::from_slice(bytes).map_err(malformed)?;
    // Serde reads a list as a struct's fields in order; the contract does not.
    for pointer in ["", "/image", "/options", "/options/table", "/options/metric_anchor"] {
        if value.pointer(pointer).is_some_and(Value::is_array) {
            return Err(Problem::invalid(vec![FieldError::new(pointer, "must be an object, not a list")]));
        }
    }
    serde_path_to_error::deserialize(value).map_err(|error| {
        let mut pointer = String::new();
        for segment in error.path() {
            match segment {
                Segment::Seq { index } => pointer.push_str(&format!("/{index}")),
                Segment::Map { key } => {
                    pointer.push('/');
                    pointer.push_str(&key.replace('~', "~0").replace('/', "~1"));
                }
                Segment::Enum { .. } | Segment::Unknown => {}
            }
        }
        let detail: String = json_detail(&error.inner().to_string()).chars().take(300).collect();
        Problem::invalid(vec![FieldError::new(pointer, detail)])
    })
}

/// The content of the image of the request: the file of the form, or what `body.image` names, which is taken out.
async fn load_image(api: &Api, body: &mut SceneBody, file: Option<Bytes>) -> Result<Option<Bytes>, Problem> {
    match (body.image.take(), file) {
        (None, file) => Ok(file),
        (Some(_), Some(_)) => Err(Problem::invalid(vec![FieldError::new(
            "",
            "the image is there twice; send it as the form's `image` or in `request`",
        )])),
        (Some(source), None) => match image_of(api, source).await {
            Ok(bytes) => Ok(Some(bytes)),
            Err((pointer, detail)) => Err(Problem::invalid(vec![FieldError::new(pointer, detail)])),
        },
    }
}

/// [`validate`] on a thread that may block; images are decoded a few at a time.
async fn validate_apart(api: &Api, body: SceneBody, image: Option<Bytes>) -> Result<Submission, Problem> {
    let permit = match &image {
        Some(_) => api.decoders.clone().acquire_owned().await.ok(),
        None => None,
    };
    let (settings, validate_settings) = (api.settings.clone(), api.validate.clone());
    let validated = tokio::task::spawn_blocking(move || {
        let _permit = permit;
        validate(body, image, &settings, &validate_settings)
    });
    validated.await.unwrap_or_else(|_| Err(image::unreadable("its decoder gave up")))
}

/// Validates a request; the result may be enqueued. `image` is the content of an image file, wherever it came from;
/// `body.image` is not read. Decodes the image, so it blocks.
///
/// # Errors
///
/// A [`Problem`] with every violation of the body, or with the reason why the image is refused.
pub fn validate(
    body: SceneBody,
    image: Option<Bytes>,
    settings: &Settings,
    validate_settings: &Validate,
) -> Result<Submission, Problem> {
    let mut errors = Vec::new();
    let mut wrong = |pointer: &str, detail: String| errors.push(FieldError::new(pointer, detail));
    if body.seed.is_some_and(|seed| seed > MAX_SEED) {
        wrong("/seed", format!("must be at most {MAX_SEED}"));
    }
    check_labels(&body.labels, &mut wrong);
    for Violation { pointer, detail } in body.options.violations() {
        wrong(&format!("/options{pointer}"), detail);
    }
    let mut text = None;
    match &body.text {
        Some(given) => match check_text(given, settings.max_text_chars) {
            Ok(checked) => text = Some(checked),
            Err(detail) => wrong("/text", detail),
        },
        None if image.is_none() => wrong("", "give `text`, `image`, or both; there is none".into()),
        None => {}
    }
    if !errors.is_empty() {
        return Err(Problem::invalid(errors));
    }
    let image = image.map(|bytes| image::check(bytes, settings)).transpose()?;
    let input = match &image {
        Some(image) => {
            Input::Image { sha256: image.digest.to_string(), media_type: image.media_type.to_owned(), text }
        }
        None => Input::Text { text: text.unwrap_or_default() },
    };
    let content =
        json!({ "input": input, "seed": body.seed, "labels": body.labels, "options": body.options });
    let body_digest = Digest::of(content.to_string().as_bytes());
    let seed = body.seed.unwrap_or_else(draw_seed);
    let request = SceneRequest { version: SceneRequest::VERSION, input, seed, options: body.options };
    let errors = validate_settings(&request);
    if !errors.is_empty() {
        return Err(Problem::invalid(errors));
    }
    Ok(Submission { request, labels: body.labels, image, body_digest })
}

/// A random seed, for a request without one; the scene reports it.
fn draw_seed() -> u64 {
    // The version's four bits are the same in every one; the others are random.
    let random = Uuid::new_v4().as_u128();
    ((random ^ (random >> 64)) as u64) & MAX_SEED
}

fn check_text(text: &str, max_chars: usize) -> Result<String, String> {
    let text = text.trim();
    let length = text.chars().count();
    if length == 0 {
        Err("is empty; describe a table and what lies on it".into())
    } else if length > max_chars {
        Err(format!("has {length} characters; say it in at most {max_chars}"))
    } else if text.chars().any(|c| c.is_control() && !matches!(c, '\n' | '\r' | '\t')) {
        Err("contains control characters; remove them".into())
    } else {
        Ok(text.to_owned())
    }
}

/// The image's bytes, or which part of the source will not do and why.
async fn image_of(api: &Api, source: ImageSource) -> Result<Bytes, (&'static str, String)> {
    match (source.base64, source.url) {
        (Some(text), None) => data_uri::decode(&text).map_err(|detail| ("/image/base64", detail)),
        (None, Some(_)) if !api.settings.fetch_images => {
            let message = "this server fetches no images; send the bytes as `base64` or as multipart";
            Err(("/image/url", message.to_owned()))
        }
        (None, Some(url)) => {
            let fetched = (api.fetch_image)(url, api.settings.max_image_bytes);
            fetched.await.map_err(|message| ("/image/url", message))
        }
        _ => Err(("/image", "give `base64` or `url`".to_owned())),
    }
}

fn check_labels(labels: &BTreeMap<String, String>, wrong: &mut impl FnMut(&str, String)) {
    if labels.len() > 32 {
        wrong("/labels", "has more than 32 entries".into());
    }
    for (key, value) in labels.iter().take(33) {
        let key_is_fine = (1..=63).contains(&key.len())
            && key.bytes().all(|b| b.is_ascii_alphanumeric() || matches!(b, b'_' | b'-' | b'.'));
        if !key_is_fine {
            wrong("/labels", "keys have 1 to 63 letters, digits, `_`, `-` or `.`".into());
        } else if value.chars().count() > 255 || value.chars().any(char::is_control) {
            wrong(&format!("/labels/{key}"), "values have at most 255 characters, none of control".into());
        }
    }
}
