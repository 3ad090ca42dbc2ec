//! The body of `POST /scenes`: JSON, or multipart with the image as a file.
//!
//! [`validate`] is a function of its own, so that the command line refuses the same requests.

use std::collections::BTreeMap;

use axum::extract::Request;
use bytes::Bytes;
use jiff::Timestamp;
use serde::Deserialize;
use serde_json::json;
use uuid::Uuid;

use super::admission::overloaded;
use super::body::BodyReader;
use super::body_memory::Reservation;
use super::data_uri::Base64Image;
use super::error::{FieldError, Problem, ProblemType};
use super::form_body::Form;
use super::image::UploadedImage;
use super::json_body::parse_apart;
pub use super::json_body::{json_bytes, media_type, parse};
use super::query::Time;
use super::{Api, Settings, Validate, form_body, image};
use scene::Violation;
use scene::request::{MAX_SEED, RequestOptions};
use scene::{Input, SceneRequest, TenantId};
use store::queue::{self, Schedule};
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
    /// Orders the jobs of the client; more is sooner.
    pub priority: Option<i64>,
    /// The job starts no earlier.
    pub not_before: Option<Time>,
    /// The job fails if it has not ended by then.
    pub deadline: Option<Time>,
}

/// Where an image is, or its bytes; one of them.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ImageSource {
    /// Base64, alone or as a data URI.
    pub base64: Option<Base64Image>,
    pub url: Option<String>,
}

/// Largest priority, and smallest below zero.
const MAX_PRIORITY: i64 = 100;

/// A submission that may be enqueued.
#[derive(Debug)]
pub struct Submission {
    pub request: SceneRequest,
    pub labels: BTreeMap<String, String>,
    pub priority: i64,
    /// Milliseconds since 1970.
    pub not_before_ms: Option<i64>,
    pub deadline_ms: Option<i64>,
    /// To be stored before the request that names it.
    pub image: Option<UploadedImage>,
    /// The same for the same content, whatever its form; a seed drawn here does not count.
    pub body_digest: Digest,
}

impl Submission {
    /// When the job runs.
    pub fn schedule(&self, queue: &queue::Settings) -> Schedule {
        let Self { priority, not_before_ms, deadline_ms, .. } = *self;
        Schedule { priority, not_before_ms, deadline_ms, ..Schedule::usual(queue.clone()) }
    }

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
    let (parts, body) = request.into_parts();
    let (mut body, file, mut memory) = match media_type(&parts.headers).as_str() {
        "application/json" => {
            let reader = BodyReader::new(api, &parts, body, api.settings.max_body_bytes);
            let (body, memory) = parse_apart(api, reader.collect().await?).await?;
            (body, None, memory)
        }
        "multipart/form-data" => {
            let Form { request, image, memory } = form_body::read(api, parts, body).await?;
            if image.is_none() {
                return Err(Problem::new(
                    ProblemType::InvalidRequest,
                    "missing_field",
                    "the form has no file `image`; send a request without one as application/json",
                ));
            }
            (request.unwrap_or_default(), image, memory)
        }
        _ => {
            return Err(Problem::new(
                ProblemType::UnsupportedMediaType,
                "body_format",
                "send application/json, or multipart/form-data with a file field `image`",
            ));
        }
    };
    let image = load_image(api, &mut body, file, &mut memory).await?;
    memory.shrink_to(image.as_ref().map_or(0, Bytes::len) + body.text.as_ref().map_or(0, String::len));
    let _permit = api.requests.clone().try_acquire_owned().map_err(|_| overloaded())?;
    let mut submission = validate_apart(api, body, image).await?;
    if let Some(image) = &mut submission.image {
        image.memory = memory;
    }
    Ok(submission)
}

/// The content of the image of the request: the file of the form, or what `body.image` names, which is taken out.
async fn load_image(
    api: &Api,
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
async fn fetch(api: &Api, url: String, memory: &mut Reservation) -> Result<Bytes, Problem> {
    if !api.settings.fetch_images {
        let detail = "this server fetches no images; send the bytes as `base64` or as multipart";
        return Err(wrong_image("/image/url", detail));
    }
    let _permit = api.fetches.clone().try_acquire_owned().map_err(|_| overloaded())?;
    memory.grow_to(memory.bytes() + api.settings.max_image_bytes)?;
    let fetched = (api.fetch_image)(url, api.settings.max_image_bytes).await;
    fetched.map_err(|detail| wrong_image("/image/url", &detail))
}

fn wrong_image(pointer: &str, detail: &str) -> Problem {
    Problem::invalid(vec![FieldError::new(pointer, detail)])
}

/// [`validate`] on a thread that may block. Images are decoded a few at a time, and of large ones fewer.
async fn validate_apart(api: &Api, body: SceneBody, image: Option<Bytes>) -> Result<Submission, Problem> {
    let permits = match &image {
        Some(bytes) => {
            let bytes = bytes.clone();
            let blocks = tokio::task::spawn_blocking(move || image::pixel_blocks(&bytes)).await.unwrap_or(1);
            let pixels =
                api.pixel_blocks.clone().acquire_many_owned(blocks.min(api.max_pixel_blocks())).await.ok();
            Some((pixels, api.decoders.clone().acquire_owned().await.ok()))
        }
        None => None,
    };
    let (settings, validate_settings) = (api.settings.clone(), api.validate.clone());
    let validated = tokio::task::spawn_blocking(move || {
        let _permits = permits;
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
    let schedule = check_schedule(&body, &mut wrong);
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
    let mut content =
        json!({ "input": input, "seed": body.seed, "labels": body.labels, "options": body.options });
    if schedule != (0, None, None) {
        content["schedule"] = json!(schedule);
    }
    let body_digest = Digest::of(content.to_string().as_bytes());
    let seed = body.seed.unwrap_or_else(draw_seed);
    let request = SceneRequest { version: SceneRequest::VERSION, input, seed, options: body.options };
    let errors = validate_settings(&request);
    if !errors.is_empty() {
        return Err(Problem::invalid(errors));
    }
    let (priority, not_before_ms, deadline_ms) = schedule;
    Ok(Submission { request, labels: body.labels, priority, not_before_ms, deadline_ms, image, body_digest })
}

/// Priority, and the times in milliseconds since 1970.
fn check_schedule(body: &SceneBody, wrong: &mut impl FnMut(&str, String)) -> (i64, Option<i64>, Option<i64>) {
    let priority = body.priority.unwrap_or(0);
    if priority.abs() > MAX_PRIORITY {
        wrong("/priority", format!("must be from -{MAX_PRIORITY} to {MAX_PRIORITY}"));
    }
    let (not_before_ms, deadline_ms) = (body.not_before.map(Time::as_ms), body.deadline.map(Time::as_ms));
    if deadline_ms.is_some_and(|deadline_ms| deadline_ms <= not_before_ms.unwrap_or(0)) {
        wrong("/deadline", "must be later than `not_before`".into());
    } else if deadline_ms.is_some_and(|deadline_ms| deadline_ms <= Timestamp::now().as_millisecond()) {
        wrong("/deadline", "has passed already".into());
    }
    (priority, not_before_ms, deadline_ms)
}

/// A random seed, for a request without one; the scene reports it.
fn draw_seed() -> u64 {
    // The version's four bits are the same in every one; the others are random.
    let random = Uuid::new_v4().as_u128();
    ((random ^ (random >> 64)) as u64) & MAX_SEED
}

fn check_text(text: &str, max_chars: usize) -> Result<String, String> {
    let length = text.chars().count();
    let text = text.trim();
    if text.is_empty() {
        Err("is empty; describe a table and what lies on it".into())
    } else if length > max_chars {
        Err(format!("has {length} characters; say it in at most {max_chars}"))
    } else if text.chars().any(|c| c.is_control() && !matches!(c, '\n' | '\r' | '\t')) {
        Err("contains control characters; remove them".into())
    } else {
        Ok(text.to_owned())
    }
}

/// Whether a label may have this key and this value.
pub(super) fn is_label(key: &str, value: &str) -> bool {
    is_label_key(key) && value.chars().count() <= 255 && !value.chars().any(char::is_control)
}

fn is_label_key(key: &str) -> bool {
    (1..=63).contains(&key.len())
        && key.bytes().all(|b| b.is_ascii_alphanumeric() || matches!(b, b'_' | b'-' | b'.'))
}

fn check_labels(labels: &BTreeMap<String, String>, wrong: &mut impl FnMut(&str, String)) {
    if labels.len() > 32 {
        wrong("/labels", "has more than 32 entries".into());
    }
    for (key, value) in labels.iter().take(33) {
        if !is_label_key(key) {
            wrong("/labels", "keys have 1 to 63 letters, digits, `_`, `-` or `.`".into());
        } else if !is_label(key, value) {
            wrong(&format!("/labels/{key}"), "values have at most 255 characters, none of control".into());
        }
    }
}
