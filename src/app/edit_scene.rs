//! The check of an order of an edit, by operations or in words, and the prediction of what it will do.

use serde_json::Value;

use super::submission::{Submission, TextError, check_text};
use super::terms::Terms;
use super::{App, edit_operations};
use crate::pipeline;
use crate::pipeline::error::StageError;
use crate::problem::{FieldError, Problem, ProblemType};
pub use pipeline::edit::Prediction;
use runtime::CancelFlag;
use scene::{EditProgram, Input, SceneRequest};
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
    /// The program of the instruction, once it was read.
    pub program: Option<EditProgram>,
    pub terms: Terms,
}

impl App {
    /// The instruction that is to be read before [`Self::check_edit`]; `None` for an order by operations, and for one
    /// that is refused without reading.
    pub fn instruction_of(&self, order: &EditOrder) -> Option<String> {
        let text = order.text.as_deref().filter(|_| order.operations.is_none())?;
        let is_refused = order.program.is_some() || !order.terms.errors().is_empty();
        check_text(text, self.config().server.max_text_chars).ok().filter(|_| !is_refused)
    }

    /// Checks an edit of the parent; the result may be enqueued.
    ///
    /// # Errors
    ///
    /// A [`Problem`] with every violation of the order.
    pub fn check_edit(&self, order: EditOrder, parent: &ParentBundle) -> Result<Submission, Problem> {
        let EditOrder { operations, text, program, terms } = order;
        let mut errors = terms.errors();
        let (operations, text) = match (operations, text) {
            (Some(items), None) => (edit_operations::read(&items), None),
            (None, Some(text)) => {
                let checked = check_text(&text, self.config().server.max_text_chars);
                let text = checked.as_ref().ok().cloned();
                let not_empty = |error: TextError| match error {
                    TextError::Empty => "is empty; say what to change".to_owned(),
                    other => other.to_string(),
                };
                let checked = checked.map_err(|error| vec![FieldError::new("/text", not_empty(error))]);
                let operations =
                    checked.map(|_| program.iter().flat_map(EditProgram::meanings).cloned().collect());
                (operations, text)
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
        let words = program.iter().flat_map(|program| &program.statements);
        let words = words.map(|statement| statement.words.clone()).collect();
        let asides = program.map(|program| program.asides).unwrap_or_default();
        self.submission(terms, Input::Edit { parent, bundle_sha256, operations, text, words, asides })
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
