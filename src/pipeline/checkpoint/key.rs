//! The key of a stage: SHA-256 over the canonical JSON of everything that can influence its result.
//!
//! Canonical means: object keys sorted, no white space, numbers as the shortest text that reads back to
//! the same value. Two structs with the same fields in another order have the same key.

use serde::Serialize;
use serde_json::{Map, Value, json};

use super::Stage;
use crate::pipeline::error::StageError;
use scene::TenantId;
use store::Digest;

/// The digest of one run of one stage.
pub(super) fn digest<I: Serialize>(
    stage: Stage,
    inputs: &I,
    instance: &str,
    backend: &str,
    tenant_id: &TenantId,
    salt: Option<&str>,
) -> Result<Digest, StageError> {
    let inputs = serde_json::to_value(inputs).map_err(|error| {
        StageError::permanent(
            "inputs_not_hashable",
            format!("the inputs of stage {} cannot be written as JSON", stage.name),
        )
        .because(error)
    })?;
    let key = json!({
        "stage": stage.name, "version": stage.version, "inputs": inputs, "instance": instance,
        "backend": backend, "tenant": tenant_id, "salt": salt,
    });
    Ok(Digest::of(canonical(key).to_string().as_bytes()))
}

/// An output as it is stored.
pub(super) fn encode<O: Serialize>(stage: Stage, output: &O) -> Result<Vec<u8>, StageError> {
    serde_json::to_vec(output).map_err(|error| {
        StageError::permanent(
            "output_not_storable",
            format!("the output of stage {} cannot be written as JSON", stage.name),
        )
        .because(error)
    })
}

/// The same value with every object's keys sorted.
fn canonical(value: Value) -> Value {
    match value {
        Value::Object(map) => {
            let mut entries: Vec<(String, Value)> = map.into_iter().collect();
            entries.sort_by(|a, b| a.0.cmp(&b.0));
            Value::Object(entries.into_iter().map(|(k, v)| (k, canonical(v))).collect::<Map<_, _>>())
        }
        Value::Array(items) => Value::Array(items.into_iter().map(canonical).collect()),
        other => other,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const STAGE: Stage = Stage { name: "paint", version: 3 };

    fn tenant(id: &str) -> TenantId {
        id.parse().expect("a valid id")
    }

    fn of(inputs: Value) -> Digest {
        digest(STAGE, &inputs, "mug_1", "cpu", &tenant("default"), None).expect("hashes")
    }

    #[test]
    fn order_of_fields_does_not_matter_and_every_part_of_the_key_does() {
        let inputs = || json!({ "a": 1, "b": { "x": [1.5, 2], "y": null } });
        let base = of(inputs());
        assert_eq!(base, of(json!({ "b": { "y": null, "x": [1.5, 2] }, "a": 1 })));
        let with = |stage, instance, backend, tenant_id, salt| {
            digest(stage, &inputs(), instance, backend, &tenant(tenant_id), salt).expect("hashes")
        };
        let others = [
            of(json!({ "a": 2, "b": { "x": [1.5, 2], "y": null } })),
            of(json!({ "a": 1, "b": { "x": [2, 1.5], "y": null } })),
            with(Stage { version: 4, ..STAGE }, "mug_1", "cpu", "default", None),
            with(Stage { name: "segment", ..STAGE }, "mug_1", "cpu", "default", None),
            with(STAGE, "mug_2", "cpu", "default", None),
            with(STAGE, "mug_1", "gpu", "default", None),
            with(STAGE, "mug_1", "cpu", "other", None),
            with(STAGE, "mug_1", "cpu", "default", Some("again")),
        ];
        for (index, other) in others.iter().enumerate() {
            assert_ne!(*other, base, "variant {index}");
        }
    }
}
