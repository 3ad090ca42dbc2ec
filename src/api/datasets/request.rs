//! The body of `POST /datasets`.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::Deserialize;
use serde_json::{Map, Value};

use crate::api::extract::{JsonRequest, TenantApi};
use crate::api::query::LabelFilter;
use crate::freezer::{DatasetRequest, DatasetSource};
use crate::problem::{FieldError, Problem, ProblemType};
use crate::schemas::datasets::{SharingKind, SplitRatios};
use crate::schemas::values::{Id, Label, MAX_INTEGER};
use datasets::facts::normalized;
use datasets::filter::Filter;
use datasets::freeze;
use datasets::sharing::{LeakageRules, Shareable};
use datasets::splits::{SplitPlan, SplitPlanError, assign, groups};
use scene::request::{Input, MAX_SEED};
use scene::{BatchId, SceneId};
use store::datasets::DatasetState;
use store::lifecycle::SceneState;
use store::scenes::SceneRow;

/// Largest shard that may be asked for, MiB: a shard is in memory at once while it is stored.
const MAX_SHARD_MB: u64 = 256;
/// The usual one, MiB.
const USUAL_SHARD_MB: u64 = 64;
/// Largest number of scenes that may be named one by one; their ids fit into a small body.
const MAX_SCENES: usize = 1500;
/// The usual ratios of the splits.
const USUAL_SPLITS: &str = "train=0.8,validation=0.1,test=0.1";

/// Exactly one of `batch`, `scenes` and `label` names the scenes.
#[derive(Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
#[schemars(rename = "DatasetSubmission", extend("required" = ["name"]))]
pub struct DatasetBody {
    #[schemars(length(min = 1, max = 64), regex(pattern = r"^[a-z0-9_-]+$"))]
    name: String,
    /// A batch that has ended.
    #[schemars(with = "Option<Id>")]
    batch: Option<BatchId>,
    #[schemars(with = "Option<Vec<Id>>", length(min = 1, max = 1500))]
    scenes: Option<Vec<SceneId>>,
    /// The scenes with this label, `key:value`.
    #[schemars(with = "Option<Label>")]
    label: Option<LabelFilter>,
    filter: Filter,
    /// Ratios with the sum 1, by names of lower-case letters, digits and `_`, in this order; 0.8 `train`, 0.1
    /// `validation` and 0.1 `test` when absent. A split with a ratio above 0 that would be empty is an error: of this
    /// request where the ids of `scenes` show it, else the freeze fails with `empty_split`.
    #[schemars(with = "Option<SplitRatios>")]
    splits: Option<Map<String, Value>>,
    /// Of the assignment to splits.
    #[schemars(range(min = 0, max = MAX_INTEGER))]
    seed: u64,
    /// Parts that scenes of different splits must not share; all kinds when absent, nothing when empty.
    #[schemars(with = "Option<Vec<SharingKind>>")]
    disjoint: Option<Vec<String>>,
    /// Largest shard in MiB; 64 when absent.
    #[schemars(range(min = 1, max = 256))]
    shard_mb: Option<u64>,
    #[schemars(range(min = 1, max = 1_000_000))]
    shard_scenes: Option<usize>,
}

impl JsonRequest for DatasetBody {
    type Schema = Self;
    const EXAMPLE: &str = r#"{"name": "kitchen", "label": "project:demo"}"#;
}

/// State that a list is filtered by.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(try_from = "String")]
pub(super) struct StateFilter(pub(super) DatasetState);

impl TryFrom<String> for StateFilter {
    type Error = &'static str;

    fn try_from(text: String) -> Result<Self, Self::Error> {
        DatasetState::parse(&text).map(Self).ok_or("must be queued, running, finished or failed")
    }
}

impl DatasetBody {
    /// The name and the request to store.
    ///
    /// # Errors
    ///
    /// A [`Problem`] with every value that will not do.
    pub(super) fn checked(self) -> Result<(String, DatasetRequest), Problem> {
        let mut errors = Vec::new();
        let mut wrong = |pointer: &str, detail: String| errors.push(FieldError::new(pointer, detail));
        if let Err(error) = freeze::check_name(&self.name) {
            wrong("/name", error.to_string());
        }
        let scenes = self.scenes.as_ref().map_or(1, Vec::len);
        if !(1..=MAX_SCENES).contains(&scenes) {
            wrong(
                "/scenes",
                format!("must name from 1 to {MAX_SCENES} scenes; label more, and give the label"),
            );
        }
        let given = [self.batch.is_some(), self.scenes.is_some(), self.label.is_some()];
        if given.iter().filter(|is_given| **is_given).count() != 1 {
            wrong("", "give one of `batch`, `scenes` and `label`".into());
        }
        let source = match (self.batch, self.scenes, self.label) {
            (Some(batch), _, _) => DatasetSource::Batch(batch),
            (None, scenes, None) => DatasetSource::Scenes(scenes.unwrap_or_default()),
            (None, _, Some(label)) => DatasetSource::Label { key: label.key, value: label.value },
        };
        let plan = plan(self.splits, self.seed).unwrap_or_else(|detail| {
            wrong("/splits", detail.to_string());
            SplitPlan { ratios: Vec::new(), seed: 0 }
        });
        if self.seed > MAX_SEED {
            wrong("/seed", format!("must be at most {MAX_SEED}"));
        }
        let disjoint = self.disjoint.map_or(Ok(LeakageRules::ALL), |kinds| kinds.join(",").parse());
        let disjoint = disjoint.unwrap_or_else(|error| {
            wrong("/disjoint", error.to_string());
            LeakageRules::NONE
        });
        let shard_mb = self.shard_mb.unwrap_or(USUAL_SHARD_MB);
        if !(1..=MAX_SHARD_MB).contains(&shard_mb) {
            wrong("/shard_mb", format!("must be from 1 to {MAX_SHARD_MB}"));
        }
        if self.shard_scenes == Some(0) {
            wrong("/shard_scenes", "must be at least 1".into());
        }
        if !errors.is_empty() {
            return Err(Problem::invalid(errors));
        }
        let request = DatasetRequest {
            version: DatasetRequest::VERSION,
            source,
            filter: self.filter,
            splits: plan,
            disjoint,
            shard_bytes: shard_mb << 20,
            shard_scenes: self.shard_scenes,
        };
        Ok((self.name, request))
    }
}

/// The plan in the text form that the command line has, which is checked there.
fn plan(splits: Option<Map<String, Value>>, seed: u64) -> Result<SplitPlan, SplitPlanError> {
    let text = match splits {
        None => USUAL_SPLITS.to_owned(),
        Some(splits) => {
            let parts: Vec<String> = splits.iter().map(|(name, ratio)| format!("{name}={ratio}")).collect();
            parts.join(",")
        }
    };
    let plan = text.parse::<SplitPlan>()?;
    Ok(SplitPlan { seed, ..plan })
}

/// Refuses a source that is not there, or that can still change, and scenes of which splits would be empty.
///
/// # Errors
///
/// A [`Problem`] that names it.
pub(super) async fn check_source(api: &TenantApi, request: &DatasetRequest) -> Result<(), Problem> {
    match &request.source {
        DatasetSource::Batch(id) => {
            let batch = api.store.batch(&api.tenant_id, id).await?;
            let Some(batch) = batch.filter(|batch| !batch.is_deleted) else {
                return Err(Problem::invalid(vec![FieldError::new("/batch", "there is no such batch")]));
            };
            if !batch.state.is_final() {
                let detail = "this batch has not ended; freeze it then, or cancel it";
                return Err(Problem::new(ProblemType::Conflict, "batch_not_ended", detail));
            }
        }
        DatasetSource::Scenes(ids) => {
            let (mut errors, mut found) = (Vec::new(), Vec::new());
            for (index, id) in ids.iter().enumerate() {
                let scene = api.store.scene(&api.tenant_id, id).await?;
                match scene.filter(|scene| scene.state != SceneState::Deleted) {
                    Some(scene) => found.push(shareable(&scene)),
                    None => {
                        errors.push(FieldError::new(format!("/scenes/{index}"), "there is no such scene"))
                    }
                }
            }
            if !errors.is_empty() {
                return Err(Problem::invalid(errors));
            }
            check_splits(&found, request)?;
        }
        DatasetSource::Label { .. } => {}
    }
    Ok(())
}

/// Parts that a scene shares with others, as far as its row has them: its parent and its text.
fn shareable(scene: &SceneRow) -> Shareable {
    let input = scene.request.get("input").and_then(|input| Input::deserialize(input).ok());
    let text = input.as_ref().and_then(Input::text).map(normalized).filter(|text| !text.is_empty());
    Shareable {
        id: scene.id.to_string(),
        parent: scene.parent_id.as_ref().map(ToString::to_string),
        text_sha256: text,
        image_sha256: None,
        mesh_sha256: Vec::new(),
    }
}

/// Refuses scenes that form fewer groups than there are splits. Images and meshes may join groups, so the freezer
/// decides the rest.
fn check_splits(scenes: &[Shareable], request: &DatasetRequest) -> Result<(), Problem> {
    let groups = groups(scenes, &request.disjoint);
    let wanted = request.splits.ratios.iter().filter(|split| split.ratio > 0.0).count();
    if groups.len() >= wanted {
        return Ok(());
    }
    let assigned = assign(&groups, &request.splits, &BTreeMap::new());
    request
        .splits
        .check_filled(&groups, &assigned)
        .map_err(|error| Problem::invalid(vec![FieldError::new("/splits", error.to_string())]))
}
