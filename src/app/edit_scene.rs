//! The check of an order of an edit, by operations or in words, and the prediction of what it will do.

use serde_json::Value;

use super::submission::{Submission, check_text};
use super::terms::Terms;
use super::{App, edit_operations};
use crate::pipeline;
use crate::pipeline::error::StageError;
use crate::pipeline::task_scene::of_archive;
use crate::problem::{FieldError, Problem, ProblemType};
use editing::references::SceneReferents;
use language::{EnglishNouns, edit};
pub use pipeline::edit::Prediction;
use runtime::CancelFlag;
use scene::{EditOperation, Input, SceneRequest};
use store::Digest;

/// The bundle of the finished scene that another is made from.
#[derive(Clone, Debug)]
pub struct ParentBundle {
    /// Id in its `scene.json`.
    pub id: String,
    /// Of its archive.
    pub digest: Digest,
}

/// An order of an edit, by operations or by an instruction; not checked.
#[derive(Clone, Debug, Default)]
pub struct EditOrder {
    /// Operations as JSON, or [`Self::text`].
    pub operations: Option<Vec<Value>>,
    /// An instruction in words.
    pub text: Option<String>,
    pub terms: Terms,
}

impl App {
    /// Checks an edit of the parent; the result may be enqueued. An instruction in words is read with the objects of
    /// the parent's archive: what stands there needs no article. It computes, so it blocks where there is an archive.
    ///
    /// # Errors
    ///
    /// A [`Problem`] with every violation of the order.
    pub fn check_edit(
        &self,
        order: EditOrder,
        parent: &ParentBundle,
        archive: Option<&[u8]>,
    ) -> Result<Submission, Problem> {
        let EditOrder { operations, text, terms } = order;
        let mut errors = terms.errors();
        let (operations, text) = match (operations, text) {
            (Some(items), None) => (edit_operations::read(&items), None),
            (None, Some(text)) => {
                let (operations, text) = read_text(&text, self.config().server.max_text_chars, archive);
                (operations.map_err(|error| vec![error]), text)
            }
            (Some(_), Some(_)) => (Err(one_source("both are there")), None),
            (None, None) => (Err(one_source("there is neither")), None),
        };
        let operations = operations.unwrap_or_else(|wrong| {
            errors.extend(wrong);
            Vec::new()
        });
        if !errors.is_empty() {
            return Err(Problem::invalid(errors));
        }
        let (parent, bundle_sha256) = (parent.id.clone(), parent.digest.to_string());
        self.submission(terms, Input::Edit { parent, bundle_sha256, operations, text })
    }

    /// Places and collisions of an edit of the scene in an archive, without making a scene; `None` for a request that
    /// is no edit. It computes, so it blocks.
    ///
    /// # Errors
    ///
    /// A [`Problem`] where the edit is refused, or the archive cannot be read.
    pub fn predict_edit(
        &self,
        request: &SceneRequest,
        archive: &[u8],
    ) -> Result<Option<Prediction>, Problem> {
        let Input::Edit { operations, .. } = &request.input else { return Ok(None) };
        let settings = super::pipeline::own_settings(self.resolved(), request).map_err(not_predicted)?;
        // Nothing can ask it to stop: it takes as long as the placement of a few objects.
        let predicted = pipeline::edit::predict(archive, operations, &settings, &CancelFlag::default());
        predicted.map(Some).map_err(not_predicted)
    }
}

/// Reason why there is no prediction, for the client.
fn not_predicted(error: StageError) -> Problem {
    let kind = match error.code {
        "edit_refused" | "settings_invalid" => ProblemType::InvalidRequest,
        "parent_unreadable" => ProblemType::Conflict,
        _ => {
            tracing::error!(error = error.chain(), "an edit could not be predicted");
            ProblemType::Internal
        }
    };
    Problem::new(kind, error.code, error.message)
}

fn one_source(which: &str) -> Vec<FieldError> {
    vec![FieldError::new("", format!("give `operations` or `text`, one of them; {which}"))]
}

/// The operations of an instruction, and the instruction without surrounding white space.
fn read_text(
    text: &str,
    max_chars: usize,
    archive: Option<&[u8]>,
) -> (Result<Vec<EditOperation>, FieldError>, Option<String>) {
    if !text.contains(char::is_alphanumeric) {
        return (Err(FieldError::new("/text", "is empty; say what to change")), None);
    }
    match check_text(text, max_chars) {
        Ok(text) => {
            // An archive that cannot be read fails the job, which says why.
            let scene = archive.and_then(|archive| of_archive(archive).ok());
            let operations = match &scene {
                Some(scene) => edit::read(&text, &SceneReferents(scene.tasks.described())),
                None => edit::read(&text, &EnglishNouns),
            };
            (operations.map_err(|error| FieldError::new("/text", error.to_string())), Some(text))
        }
        Err(detail) => (Err(FieldError::new("/text", detail.to_string())), None),
    }
}
