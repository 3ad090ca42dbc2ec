//! Lists of words that other crates know, each a schema of its own.

use std::borrow::Cow;

pub use certificate::Verdict;
use demonstrations::camera::USUAL;
use episodes::format::Format;
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use store::lifecycle;

/// A list of words by the function that gives them.
macro_rules! words {
    ($($doc:literal $name:ident = $words:expr;)*) => {
        $(
            #[doc = $doc]
            pub struct $name;

            impl JsonSchema for $name {
                fn schema_name() -> Cow<'static, str> {
                    stringify!($name).into()
                }

                fn json_schema(_: &mut SchemaGenerator) -> Schema {
                    let words: Vec<String> = $words.into_iter().map(|word| word.to_string()).collect();
                    json_schema!({ "description": $doc, "type": "string", "enum": words })
                }
            }
        )*
    };
}

words! {
    "Whether a scene can be used." SceneState = lifecycle::SceneState::ALL.map(lifecycle::SceneState::as_str);
    "Activity of the machine with a job." JobState = lifecycle::JobState::ALL.map(lifecycle::JobState::as_str);
    "The operation: `generate` and `retry` build a scene, `freeze_dataset` makes a version of a dataset and \
     `verify_dataset` reads one, `record_attempt` makes one attempt of a recording and `assemble_recording` writes its \
     dataset, `execute_task` has a simulated robot do a task."
        JobKind = lifecycle::JobKind::ALL.map(lifecycle::JobKind::as_str);
    "Whether and when a failure is worth another try."
        FailureClass = lifecycle::FailureClass::ALL.map(lifecycle::FailureClass::as_str);
    "State of a freeze." DatasetState = store::datasets::DatasetState::ALL.map(store::datasets::DatasetState::as_str);
    "State of a recording of episodes; only `queued` and `running` are not final."
        RecordingState = store::recordings::RecordingState::ALL.map(store::recordings::RecordingState::as_str);
    "A finished `attempt`, or a change of what is being done. `attempt_lost`: its episode is lost or damaged, and it is \
     made again. `restarted`: all attempts so far were dropped, as a process of another version or machine goes on. \
     `assembling`: no attempt is missing, and the dataset is written; it comes again after a lost attempt."
        RecordingEventKind = store::recordings::RecordingEventKind::ALL.map(store::recordings::RecordingEventKind::as_str);
    "State of a delivery to a webhook."
        DeliveryState = store::webhooks::DeliveryState::ALL.map(store::webhooks::DeliveryState::as_str);
    "State of a batch; `finished` and `cancelled` are final unless it is retried."
        BatchState = batches::BatchState::ALL.map(batches::BatchState::as_str);
    "State of a request of a batch." RequestState = batches::RequestState::ALL.map(batches::RequestState::as_str);
    "Format of a dataset of episodes." EpisodeFormat = Format::ALL.map(|format| format.folder());
    "From the robot's left, from opposite to it, or on its hand." UsualCamera = USUAL;
    "Use of a key: `read` sees and downloads, `submit` orders work, `delete` removes, `operate` cancels, repeats and \
     verifies, `admin` manages keys and webhooks." Scope = store::scopes::Scope::ALL;
}

/// State of a stage.
#[derive(JsonSchema)]
#[schemars(rename_all = "snake_case")]
pub enum StageState {
    Running,
    Finished,
}

/// Purpose of a call of a remote model.
#[derive(JsonSchema)]
#[schemars(rename_all = "snake_case")]
pub enum Port {
    Analyst,
    ImageGenerator,
    Segmenter,
    MeshGenerator,
    FeatureExtractor,
}
