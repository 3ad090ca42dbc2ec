//! Requests for scenes that may be enqueued, and the check of an order of a scene from a text or an image.

use std::collections::BTreeMap;

use bytes::Bytes;
use serde_json::json;
use uuid::Uuid;

use super::App;
use super::image::{self, CheckedDepth, CheckedImage};
use super::terms::Terms;
use crate::problem::{FieldError, Problem, ProblemType};
use scene::request::{MAX_SEED, RequestOptions};
use scene::{Input, SceneId, SceneRequest, TenantId};
use store::queue::{self, Schedule};
use store::scenes::NewScene;
use store::{Digest, Store, StoreError};

/// An order of a scene from a text, an image or both; not checked.
#[derive(Clone, Debug, Default)]
pub struct SceneOrder {
    /// Description of the objects on the table; beside an image, of its content.
    pub text: Option<String>,
    /// Content of an image file.
    pub image: Option<Bytes>,
    /// Content of the depth image of the image.
    pub depth: Option<Bytes>,
    pub terms: Terms,
}

/// A submission that may be enqueued. [`App::submission`] makes it, for every kind of request.
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
    pub image: Option<CheckedImage>,
    /// The same of its depths.
    pub depth: Option<CheckedDepth>,
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

    /// Stores the image, its depths and the archive, if there are any, and returns the row to insert.
    /// `default_budget_usd` applies to requests without a budget.
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
        if let Some(depth) = self.depth {
            store.blobs().put(depth.bytes).await?;
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

impl App {
    /// Checks an order of a scene; the result may be enqueued. Decodes the image, so it blocks.
    ///
    /// # Errors
    ///
    /// A [`Problem`] with every violation of the order, or with the reason why the image is refused.
    pub fn check_scene(&self, order: SceneOrder) -> Result<Submission, Problem> {
        let SceneOrder { text: given, image, depth, mut terms } = order;
        let server = &self.config().server;
        let mut errors = terms.errors();
        let mut text = None;
        match &given {
            Some(given) => match check_text(given, server.max_text_chars) {
                Ok(checked) => text = Some(checked),
                Err(detail) => errors.push(FieldError::new("/text", detail.to_string())),
            },
            None if image.is_none() && depth.is_none() => {
                errors.push(FieldError::new("", "give `text`, `image`, or both; there is none"));
            }
            None => {}
        }
        if !errors.is_empty() {
            return Err(Problem::invalid(errors));
        }
        let image = image
            .map(|bytes| image::check(bytes, server.max_image_bytes, server.max_image_pixels))
            .transpose()?;
        if let Some(image) = &image {
            self.take_field_of_view(image, &mut terms.options);
        }
        let depth = depth.map(|bytes| self.check_depth(bytes, image.as_ref(), &terms.options)).transpose()?;
        let input = match &image {
            Some(image) => Input::Image {
                sha256: image.digest.to_string(),
                media_type: image.media_type.to_owned(),
                text,
                depth_sha256: depth.as_ref().map(|depth| depth.digest.to_string()),
            },
            None => Input::Text { text: text.unwrap_or_default() },
        };
        let submission = self.submission(terms, input)?;
        if let Some(image) = &image {
            self.check_intrinsics(image, &submission.request.options)?;
        }
        Ok(Submission { image, depth, ..submission })
    }

    /// Sets the field of view of the image's EXIF data where neither the request nor the server states intrinsics.
    fn take_field_of_view(&self, image: &CheckedImage, options: &mut RequestOptions) {
        let is_stated = options.set.contains_key(INTRINSICS) || self.config().photograph.states_intrinsics();
        if let Some(fov_rad) = image.field_of_view_rad.filter(|_| !is_stated) {
            options.set.entry(FIELD_OF_VIEW.to_owned()).or_insert_with(|| format!("{fov_rad:.4}"));
        }
    }

    /// Checks the depth image of a request, whose settings must state the intrinsics of its camera.
    fn check_depth(
        &self,
        bytes: Bytes,
        image: Option<&CheckedImage>,
        options: &RequestOptions,
    ) -> Result<CheckedDepth, Problem> {
        let server = &self.config().server;
        let refused = |code: &'static str, detail: &str| {
            Err(Problem::new(ProblemType::InvalidRequest, code, detail.to_owned()))
        };
        let Some(image) = image else {
            return refused(
                "depth_without_image",
                "there is a depth image without an image; send both, or neither",
            );
        };
        // Settings that will not do are reported with all others.
        let known = self.resolved.with(&options.set);
        if known.is_ok_and(|resolved| !resolved.config.photograph.has_intrinsics()) {
            return refused(
                "depth_without_intrinsics",
                "there is a depth image, but nothing states the intrinsics of its camera; set \
                 photograph.intrinsics_px to fx, fy, cx, cy, width, height, or photograph.field_of_view_rad",
            );
        }
        image::check_depth(bytes, image, server.max_image_bytes, server.max_image_pixels)
    }

    /// Checks that stated intrinsics belong to an image of the aspect of the given one.
    fn check_intrinsics(&self, image: &CheckedImage, options: &RequestOptions) -> Result<(), Problem> {
        let Ok(resolved) = self.resolved.with(&options.set) else { return Ok(()) };
        let [width, height] = image.upright_px;
        match resolved.config.photograph.aspect_fault(width, height) {
            None => Ok(()),
            Some(detail) => {
                let pointer = format!("/options/set/{INTRINSICS}");
                Err(Problem::invalid(vec![FieldError::new(pointer, detail)]))
            }
        }
    }

    /// The submission of a source on terms that must be valid. The settings of its options are checked by
    /// [`App::violations`].
    ///
    /// # Errors
    ///
    /// A [`Problem`] with every setting of the options that the configuration does not accept.
    pub(super) fn submission(&self, terms: Terms, input: Input) -> Result<Submission, Problem> {
        let Terms { seed, labels, options, priority, not_before_ms, deadline_ms } = terms;
        let schedule = (priority, not_before_ms, deadline_ms);
        let mut content = json!({ "input": input, "seed": seed, "labels": labels, "options": options });
        if schedule != (0, None, None) {
            content["schedule"] = json!(schedule);
        }
        let body_digest = Digest::of(content.to_string().as_bytes());
        let request = SceneRequest::new(input, seed.unwrap_or_else(draw_seed), options);
        let errors = self.violations(&request);
        if !errors.is_empty() {
            return Err(Problem::invalid(errors));
        }
        Ok(Submission {
            request,
            parent_id: None,
            labels,
            priority,
            not_before_ms,
            deadline_ms,
            image: None,
            depth: None,
            bundle: None,
            body_digest,
        })
    }
}

/// The setting with the field of view of the camera that took the image of a request.
const FIELD_OF_VIEW: &str = "photograph.field_of_view_rad";
/// The setting with all its intrinsics.
const INTRINSICS: &str = "photograph.intrinsics_px";

/// A random seed, for a request without one; the scene reports it.
pub(super) fn draw_seed() -> u64 {
    // The version's four bits are the same in every one; the others are random.
    let random = Uuid::new_v4().as_u128();
    ((random ^ (random >> 64)) as u64) & MAX_SEED
}

/// Reason why a text of a request will not do, as the detail of a [`FieldError`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum TextError {
    #[error("is empty; describe a table and what lies on it")]
    Empty,
    #[error("has {chars} characters; say it in at most {max_chars}")]
    TooLong { chars: usize, max_chars: usize },
    #[error("contains control characters; remove them")]
    ControlCharacters,
}

/// A text of a request without surrounding white space.
///
/// # Errors
///
/// [`TextError`] for a text without letters and digits, a long one, and one with control characters.
pub fn check_text(text: &str, max_chars: usize) -> Result<String, TextError> {
    let chars = text.chars().count();
    let text = text.trim();
    if !text.contains(char::is_alphanumeric) {
        // Marks and emoji alone ask for no more than an empty text.
        Err(TextError::Empty)
    } else if chars > max_chars {
        Err(TextError::TooLong { chars, max_chars })
    } else if text.chars().any(|c| c.is_control() && !matches!(c, '\n' | '\r' | '\t')) {
        Err(TextError::ControlCharacters)
    } else {
        Ok(text.to_owned())
    }
}

#[cfg(test)]
mod tests {
    use super::{TextError, check_text};

    #[test]
    fn a_text_without_a_letter_or_a_digit_is_empty() {
        for text in ["", " \n", "!!!", "...", "🙂"] {
            assert_eq!(check_text(text, 100), Err(TextError::Empty), "{text:?}");
        }
        assert_eq!(check_text(" 3 mugs!\n", 100), Ok("3 mugs!".to_owned()));
    }
}
