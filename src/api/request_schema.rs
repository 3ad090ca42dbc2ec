//! `/settings/schema`: a JSON schema of a request for a scene, from which a form can be made.

use axum::Json;
use axum::response::{IntoResponse, Response};
use serde_json::Value;

use super::contract;
use super::extract::TenantApi;

/// Definition of the settings that requests may change.
const SETTINGS: &str = "SceneSettings";

/// `GET /settings/schema`.
pub async fn show(api: TenantApi) -> Response {
    let (mut root, mut definitions) = contract::scene_request();
    // As the contract has them, settings are texts. A form wants their types and the values of this server.
    definitions.insert(SETTINGS.to_owned(), api.app.settings_schema());
    root["$schema"] = "https://json-schema.org/draft/2020-12/schema".into();
    root["title"] = "Request for a scene".into();
    root["$defs"] = definitions.into();
    Json(local_references(root)).into_response()
}

/// The document with its references into its own definitions.
fn local_references(mut document: Value) -> Value {
    fn walk(value: &mut Value) {
        match value {
            Value::Object(map) => {
                if let Some(Value::String(target)) = map.get_mut("$ref") {
                    *target = target.replace("#/components/schemas/", "#/$defs/");
                }
                map.values_mut().for_each(walk);
            }
            Value::Array(items) => items.iter_mut().for_each(walk),
            _ => {}
        }
    }
    walk(&mut document);
    document
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn references_lead_into_the_document() {
        let document = local_references(json!({ "a": [{ "$ref": "#/components/schemas/B" }] }));
        assert_eq!(document, json!({ "a": [{ "$ref": "#/$defs/B" }] }));
    }
}
