//! The contract of the interface, written from its types. `openapi.yaml` is this document; a test compares them.

use schemars::generate::{Contract, SchemaSettings};
use schemars::{JsonSchema, SchemaGenerator};
use serde_json::{Map, Value, json};

use super::artifacts;
use super::episodes::RecordingPage;
use super::episodes::download::RecordingFilePage;
use super::{batches, bundle, datasets, edits, events, jobs, lineage, probes, scene_body, scenes, variants};
use crate::app::episodes::draft::EpisodesDraft;
use crate::app::executions::order::{ExecutionDraft, ExecutionFormat};
use crate::app::tasks::SceneTasks;
use crate::problem::ProblemDocument;
use crate::schemas::batches::{BatchRecipe, BatchRequestLine, BatchResult};
use crate::schemas::executions::ExecutedTask;
use crate::schemas::not_null;
use crate::schemas::values::{BatchBudget, BatchName, Bytes};

/// The schemas of all bodies, by name.
pub fn schemas() -> Map<String, Value> {
    let mut read = generator(Contract::Deserialize);
    for add in [
        add::<scene_body::SceneSubmission>,
        add::<scene_body::SceneForm>,
        add::<edits::EditSubmission>,
        add::<variants::VariantsBody>,
        add::<BatchRecipe>,
        add::<BatchRequestLine>,
        add::<BatchName>,
        add::<BatchBudget>,
        add::<batches::RetryBody>,
        add::<datasets::request::DatasetBody>,
        add::<EpisodesDraft>,
        add::<ExecutionDraft>,
        add::<ExecutionFormat>,
        add::<bundle::BundleFormat>,
        add::<jobs::RetryBody>,
    ] {
        add(&mut read);
    }
    let mut written = generator(Contract::Serialize);
    for add in [
        add::<scenes::ScenePage>,
        add::<scenes::Validated>,
        add::<edits::ValidatedEdit>,
        add::<variants::VariantsView>,
        add::<variants::ValidatedVariants>,
        add::<lineage::Lineage>,
        add::<SceneTasks>,
        add::<ExecutedTask>,
        add::<artifacts::ArtifactList>,
        add::<batches::BatchPage>,
        add::<BatchResult>,
        add::<datasets::DatasetPage>,
        add::<datasets::DatasetFiles>,
        add::<RecordingPage>,
        add::<RecordingFilePage>,
        add::<events::content::EventPage>,
        add::<events::content::RecordingEventPage>,
        add::<jobs::JobPage>,
        add::<jobs::StageList>,
        add::<probes::Status>,
        add::<probes::Version>,
        add::<probes::OpenApi>,
        add::<Bytes>,
        add::<ProblemDocument<'_>>,
    ] {
        add(&mut written);
    }
    let mut schemas = definitions(written);
    // What is both read and answered is described as it is read, which allows more.
    schemas.extend(definitions(read));
    schemas.sort_keys();
    schemas
}

fn generator(contract: Contract) -> SchemaGenerator {
    let settings = SchemaSettings::draft2020_12().with(|settings| {
        settings.definitions_path = "/components/schemas".into();
        settings.meta_schema = None;
        settings.contract = contract;
    });
    settings.into_generator()
}

fn add<T: JsonSchema>(generator: &mut SchemaGenerator) {
    generator.subschema_for::<T>();
}

/// The schemas of a generator by the rules of the contract.
fn definitions(mut generator: SchemaGenerator) -> Map<String, Value> {
    let is_answer = generator.contract().is_serialize();
    let mut schemas = generator.take_definitions(true);
    schemas.values_mut().for_each(|schema| apply_rules(schema, is_answer));
    schemas
}

/// Formats have the names of OpenAPI, descriptions one line for each paragraph, and only simple values a default. A
/// field that an answer may leave out is never null.
fn apply_rules(schema: &mut Value, is_answer: bool) {
    match schema {
        Value::Array(items) => items.iter_mut().for_each(|item| apply_rules(item, is_answer)),
        Value::Object(map) => {
            let required: Vec<Value> =
                map.get("required").and_then(Value::as_array).cloned().unwrap_or_default();
            for (name, field) in
                map.get_mut("properties").and_then(Value::as_object_mut).into_iter().flatten()
            {
                let is_required = required.iter().any(|required| required == name);
                if is_answer && !is_required {
                    not_null(field);
                }
                if let Some(field) = field.as_object_mut()
                    && (is_required || !field.contains_key("type") || !is_simple(field.get("default")))
                {
                    field.shift_remove("default");
                }
            }
            match map.get("format").and_then(Value::as_str) {
                Some("uint64" | "uint") => {
                    map.insert("format".to_owned(), json!("int64"));
                }
                Some("uint32" | "uint16" | "uint8" | "int32" | "double" | "float") => {
                    map.shift_remove("format");
                }
                _ => {}
            }
            if let Some(Value::String(text)) = map.get_mut("description") {
                let paragraphs = text.split("\n\n").map(|paragraph| paragraph.replace('\n', " "));
                *text = paragraphs.collect::<Vec<_>>().join("\n\n");
            }
            let inner =
                map.iter_mut().filter(|(name, _)| !["default", "examples", "const"].contains(&name.as_str()));
            inner.for_each(|(_, inner)| apply_rules(inner, is_answer));
        }
        _ => {}
    }
}

fn is_simple(value: Option<&Value>) -> bool {
    matches!(value, Some(Value::Bool(_) | Value::Number(_) | Value::String(_)))
}
