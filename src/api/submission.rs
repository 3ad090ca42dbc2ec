//! The body of `POST /scenes`: JSON, or multipart with the image as a file.
//!
//! [`validate`] is a function of its own, so that the command line refuses the same requests.

use std::collections::BTreeMap;

use axum::extract::Request;
use bytes::Bytes;
use serde::Deserialize;
use serde_json::json;

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
use super::terms::Terms;
use super::{Api, Settings, Validate, form_body, image};
use scene::request::RequestOptions;
use scene::{Input, SceneId, SceneRequest, TenantId};
use store::queue::{self, Schedule};
use store::scenes::NewScene;
use store::{Digest, Store, StoreError};

/// The wire form of a request, not validated: the JSON body, or the `request` field of a multipart body.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct SceneBody {
    /// Description of the objects on the table; beside an image, of its content.
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

/// URL of an image, or its bytes; one of them.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ImageSource {
    /// Base64, alone or as a data URI.
    pub base64: Option<Base64Image>,
    pub url: Option<String>,
}

/// A submission that may be enqueued.
#[derive(Debug)]
pub struct Submission {
    pub request: SceneRequest,
    /// The scene that it is made from.
    pub parent_id: Option<SceneId>,
    pub labels: BTreeMap<String, String>,
    pub priority: i64,
    /// Milliseconds since 1970.
    pub not_before_ms: Option<i64>,
    pub deadline_ms: Option<i64>,
    /// To be stored before the request that names it.
    pub image: Option<UploadedImage>,
    /// An archive that the request names, where it is not stored yet.
    pub bundle: Option<Bytes>,
    /// The same for the same content, whatever its form; a seed drawn here does not count.
    pub body_digest: Digest,
}

impl Submission {
    /// Schedule of the job.
    pub fn schedule(&self, queue: &queue::Settings) -> Schedule {
        let Self { priority, not_before_ms, deadline_ms, .. } = *self;
        Schedule { priority, not_before_ms, deadline_ms, ..Schedule::usual(queue.clone()) }
    }

    /// The same as a scene made from `parent`, which is part of its content.
    pub fn child_of(self, parent: SceneId) -> Self {
        let body_digest = Digest::of(format!("{parent} {}", self.body_digest).as_bytes());
        Self { parent_id: Some(parent), body_digest, ..self }
    }

    /// Stores the image and the archive, if there are any, and returns the row to insert. `default_budget_usd` applies
    /// to requests without a budget.
    ///
    /// # Errors
    ///
    /// A [`StoreError`] if they cannot be stored.
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
        if let Some(bundle) = self.bundle {
            store.blobs().put(bundle).await?;
        }
        Ok(NewScene {
            tenant_id,
            parent_id: self.parent_id,
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
    let SceneBody { text: given, image: _, seed, labels, options, priority, not_before, deadline } = body;
    let terms = Terms { seed, labels, options, priority, not_before, deadline };
    let mut errors = terms.errors();
    let mut text = None;
    match &given {
        Some(given) => match check_text(given, settings.max_text_chars) {
            Ok(checked) => text = Some(checked),
            Err(detail) => errors.push(FieldError::new("/text", detail)),
        },
        None if image.is_none() => {
            errors.push(FieldError::new("", "give `text`, `image`, or both; there is none"));
        }
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
    Ok(Submission { image, ..terms.submission(input, validate_settings)? })
}

/// A text of a request without surrounding white space.
///
/// # Errors
///
/// What is wrong with it, as the detail of a [`FieldError`].
pub(super) fn check_text(text: &str, max_chars: usize) -> Result<String, String> {
    let length = text.chars().count();
    let text = text.trim();
    if !text.contains(char::is_alphanumeric) {
        // Marks and emoji alone ask for no more than an empty text.
        Err("is empty; describe a table and what lies on it".into())
    } else if length > max_chars {
        Err(format!("has {length} characters; say it in at most {max_chars}"))
    } else if text.chars().any(|c| c.is_control() && !matches!(c, '\n' | '\r' | '\t')) {
        Err("contains control characters; remove them".into())
    } else {
        Ok(text.to_owned())
    }
}

#[cfg(test)]
mod tests {
    use super::check_text;

    #[test]
    fn a_text_without_a_letter_or_a_digit_is_empty() {
        for text in ["", " \n", "!!!", "...", "🙂"] {
            assert!(check_text(text, 100).is_err_and(|why| why.starts_with("is empty")), "{text:?}");
        }
        assert_eq!(check_text(" 3 mugs!\n", 100), Ok("3 mugs!".to_owned()));
    }
}
