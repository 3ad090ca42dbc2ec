//! Ratings of the finished scene by a model, and its proposals of tasks for a robot: asked where the operator wants
//! them, and kept in the report. They decide nothing: the verdict follows from measurements.

use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::Inputs;
use crate::pipeline::Context;
use crate::pipeline::error::StageError;
use crate::pipeline::resolve::Loaded;
use imaging::Image;
use ports::BAD_ANSWER;
use ports::{Adapter, Judgement, MadeAfter, ProviderError, TaskObject, TaskQuestion};
use runtime::seed::child_seed;
use scene::appraisal::{Appraisal, ModelResponse};
use scene::{Input, InstanceId};

/// Section `[appraise]`.
#[derive(Clone, Debug, Serialize, Deserialize, PartialEq)]
#[serde(deny_unknown_fields)]
pub struct AppraiseSettings {
    /// Whether the analyst rates the finished scene, as the paper's evaluation does: one more call a scene.
    pub ratings: bool,
    /// Number of tasks for a robot that the analyst proposes, 0..20; 0 asks for none, and any other number costs one
    /// call.
    pub tasks: u32,
}

/// Questions of the rating, and the adapter that answers them.
#[derive(Clone, Serialize)]
pub(super) struct RatingRequest {
    settings: AppraiseSettings,
    analyst: Adapter,
}

impl RatingRequest {
    /// `None` where nothing is.
    pub(super) fn new(settings: &AppraiseSettings, analyst: Adapter) -> Option<Self> {
        let anything = settings.ratings || settings.tasks > 0;
        anything.then(|| Self { settings: settings.clone(), analyst })
    }
}

/// Asks about the scene; `scene_view` is seen from the camera of the `reference` image.
pub(super) async fn appraise(
    context: &Context,
    asked: &RatingRequest,
    inputs: &Inputs,
    loaded: &[Loaded],
    reference: Arc<Image>,
    scene_view: Arc<Image>,
) -> Result<Appraisal, StageError> {
    let (call, analyst) = (context.call(), context.services().ports.analyst.clone());
    let seed = inputs.identity.request.seed;
    let mut appraisal = Appraisal::default();
    if asked.settings.ratings {
        let after = match &inputs.identity.request.input {
            Input::Text { text } => MadeAfter::Text(text.clone()),
            Input::Image { .. } | Input::Edit { .. } | Input::Variant { .. } => MadeAfter::Image(reference),
        };
        let question = Judgement { after, scene_view, seed: child_seed(seed, "judge") };
        let said = analyst.judge(&call, question).await;
        appraisal.ratings = given(said, "ratings", &mut appraisal.missing)?;
    }
    if asked.settings.tasks > 0 {
        let question = TaskQuestion {
            objects: objects(inputs, loaded)?,
            count: asked.settings.tasks,
            seed: child_seed(seed, "tasks"),
        };
        let said = analyst.propose_tasks(&call, question).await;
        appraisal.tasks = given(said, "tasks", &mut appraisal.missing)?;
    }
    Ok(appraisal)
}

/// The model's response. A refusal, an unusable answer and a spent budget are recorded in `missing` and leave the scene
/// as it is. A transient failure is an error and is tried again, as for any other question.
fn given<T>(
    said: Result<ModelResponse<T>, ProviderError>,
    what: &str,
    missing: &mut Vec<String>,
) -> Result<Option<ModelResponse<T>>, StageError> {
    match said {
        Ok(opinion) => Ok(Some(opinion)),
        Err(
            error @ (ProviderError::Unsupported { .. }
            | ProviderError::Rejected { .. }
            | ProviderError::Refused { .. }
            | ProviderError::OverBudget { .. }
            | ProviderError::Transient { code: BAD_ANSWER, .. }),
        ) => {
            tracing::warn!(%error, what, "a finished scene goes without");
            missing.push(format!("{what}: {error}"));
            Ok(None)
        }
        Err(error) => Err(error.into()),
    }
}

/// The scene's objects in words and numbers.
fn objects(inputs: &Inputs, loaded: &[Loaded]) -> Result<Vec<TaskObject>, StageError> {
    let objects =
        inputs.composition.recognition.objects.iter().zip(&inputs.composition.bodies[1..]).zip(&loaded[1..]);
    objects
        .enumerate()
        .map(|(index, ((object, body), geometry))| {
            let supporter = inputs.composition.supports.supporter(index);
            let name = InstanceId::new(&body.resolved.name)
                .map_err(|error| StageError::permanent("invalid_name", error.to_string()))?;
            // To a millimeter and a gram: what is asked is the same wherever the last digits differ.
            let rounded = |value: f64| (1000.0 * value).round() / 1000.0;
            Ok(TaskObject {
                name,
                label: object.label.clone(),
                material: object.material.clone(),
                size_m: geometry.mesh.size_m().to_array().map(rounded),
                mass_kg: rounded(body.resolved.physical.mass.mass_kg),
                relation: supporter.relation,
                carried_by: inputs.composition.name_of(supporter).to_owned(),
            })
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use ports::Port;

    /// Statements in the report about a question that failed so.
    fn failed(error: ProviderError) -> Result<Vec<String>, StageError> {
        let mut missing = Vec::new();
        let said = given::<Vec<u8>>(Err(error), "ratings", &mut missing)?;
        assert_eq!(said, None, "nothing is made up");
        Ok(missing)
    }

    #[test]
    fn missing_rating_is_reported_with_its_reason_and_keeps_the_scene() {
        let (port, reason) = (Port::Analyst, "told".to_owned());
        for error in [
            ProviderError::Unsupported { port, adapter: "embedded/grammar".into(), reason: reason.clone() },
            ProviderError::Refused { port, code: "answer_refused", reason: reason.clone() },
            ProviderError::OverBudget { port, reason: reason.clone() },
            ProviderError::Transient { port, code: BAD_ANSWER, reason },
        ] {
            let missing = failed(error).expect("the scene stays");
            assert!(missing[0].starts_with("ratings: ") && missing[0].contains("told"), "{missing:?}");
        }
    }

    #[test]
    fn what_may_pass_is_tried_again() {
        let code = "provider_unreachable";
        let unreachable = ProviderError::Transient { port: Port::Analyst, code, reason: "told".into() };
        assert!(failed(unreachable).is_err());
        assert!(failed(ProviderError::Cancelled(runtime::Cancelled)).is_err());
    }

    #[test]
    fn no_rating_is_requested_where_none_is_configured() {
        let asked = |ratings, tasks| {
            RatingRequest::new(&AppraiseSettings { ratings, tasks }, Adapter::new("x", "1", &())).is_some()
        };
        assert!(!asked(false, 0) && asked(true, 0) && asked(false, 3));
    }
}
