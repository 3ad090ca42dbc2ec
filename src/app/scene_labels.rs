//! Change of the labels of a scene by a JSON merge patch (RFC 7396): labels that it names get a value or go, the others
//! stay.

use std::collections::BTreeMap;

use serde::{Deserialize, Deserializer};

use crate::problem::{FieldError, Problem, ProblemType};
use scene::labels::violations;
use scene::{SceneId, TenantId, Violation};
use store::Store;
use store::lifecycle::SceneState;
use store::scenes::{LabelsOutcome, SceneRow};

/// The part of a merge patch that is about labels.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub enum LabelsPatch {
    /// Nothing is said of labels.
    #[default]
    Keep,
    /// `null` in place of the labels.
    RemoveAll,
    /// A value for each label that is set, none for each that is removed.
    Change(BTreeMap<String, Option<String>>),
}

impl<'de> Deserialize<'de> for LabelsPatch {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        Ok(Option::deserialize(deserializer)?.map_or(Self::RemoveAll, Self::Change))
    }
}

impl LabelsPatch {
    /// The labels after the patch.
    pub fn applied_to(&self, labels: &BTreeMap<String, String>) -> BTreeMap<String, String> {
        match self {
            Self::Keep => labels.clone(),
            Self::RemoveAll => BTreeMap::new(),
            Self::Change(changes) => {
                let mut labels = labels.clone();
                for (key, value) in changes {
                    match value {
                        Some(value) => labels.insert(key.clone(), value.clone()),
                        None => labels.remove(key),
                    };
                }
                labels
            }
        }
    }
}

/// Changes the labels of a scene if `is_expected` holds of it; the scene after that. Changes at the same time follow
/// each other, and none undoes another one.
///
/// # Errors
///
/// A [`Problem`]: 404 and 410 without a scene, 412 for one that is not as expected, 422 for labels that no scene may
/// have.
pub async fn change_labels(
    store: &Store,
    tenant_id: &TenantId,
    scene_id: &SceneId,
    patch: &LabelsPatch,
    is_expected: impl Fn(&SceneRow) -> bool,
) -> Result<SceneRow, Problem> {
    loop {
        let scene = present(store, tenant_id, scene_id).await?;
        let labels = patch.applied_to(&scene.labels);
        let errors: Vec<FieldError> = violations(&labels).into_iter().map(field_error).collect();
        if !errors.is_empty() {
            return Err(Problem::invalid(errors));
        }
        // A precondition is about a request that would be accepted without it (RFC 9110, section 13.2.1).
        if !is_expected(&scene) {
            return Err(Problem::no_longer_matches("scene", "scene_changed"));
        }
        if labels == scene.labels {
            return Ok(scene);
        }
        // Where the scene differs, another change was faster; each turn of this loop stands for one that was.
        match store.replace_labels(tenant_id, scene, labels).await? {
            LabelsOutcome::Replaced(scene) => return Ok(*scene),
            LabelsOutcome::Differs => {}
        }
    }
}

fn field_error(Violation { pointer, detail }: Violation) -> FieldError {
    FieldError::new(format!("/labels{pointer}"), detail)
}

/// A scene that is there.
///
/// # Errors
///
/// A [`Problem`]: 404 where there is none, 410 for one that was deleted.
pub async fn present(store: &Store, tenant_id: &TenantId, scene_id: &SceneId) -> Result<SceneRow, Problem> {
    match store.scene(tenant_id, scene_id).await? {
        Some(scene) if scene.state == SceneState::Deleted => {
            Err(Problem::new(ProblemType::Gone, "scene_deleted", "this scene was deleted; submit it again"))
        }
        Some(scene) => Ok(scene),
        None => Err(Problem::not_found("scene", scene_id.as_str())),
    }
}

#[cfg(test)]
mod tests {
    use serde_json::{Value, json};

    use super::*;

    /// The function of RFC 7396, section 2, as it is printed there.
    fn merge_patch(target: Value, patch: &Value) -> Value {
        let Value::Object(patch) = patch else { return patch.clone() };
        let mut target = if target.is_object() { target } else { json!({}) };
        for (name, value) in patch {
            if value.is_null() {
                target.as_object_mut().expect("an object").remove(name);
            } else {
                let present = target.get(name).cloned().unwrap_or_default();
                target[name] = merge_patch(present, value);
            }
        }
        target
    }

    #[test]
    fn patches_are_applied_as_the_standard_says() {
        let labels = BTreeMap::from([("a".to_owned(), "1".to_owned()), ("b".to_owned(), "2".to_owned())]);
        for patch in [
            json!({}),
            json!({ "labels": null }),
            json!({ "labels": {} }),
            json!({ "labels": { "a": "3" } }),
            json!({ "labels": { "a": null, "c": "", "d": null } }),
            json!({ "labels": { "a": "1", "b": "2" } }),
        ] {
            let expected = merge_patch(json!({ "labels": labels }), &patch);
            let expected = expected.get("labels").cloned().unwrap_or_else(|| json!({}));
            let read = match patch.get("labels") {
                Some(labels) => LabelsPatch::deserialize(labels).expect("labels"),
                None => LabelsPatch::default(),
            };
            assert_eq!(json!(read.applied_to(&labels)), expected, "{patch}");
        }
        assert!(LabelsPatch::deserialize(&json!({ "a": 1 })).is_err());
        assert!(LabelsPatch::deserialize(&json!("a")).is_err());
    }
}
