//! Wire format: `POST {base}/predictions`, `GET {base}/predictions/{id}`.
//!
//! The literals of the tests are the published examples of Replicate's HTTP API.

use serde::Deserialize;
use serde_json::{Map, Value, json};

use super::super::endpoint::Reading;
use super::super::failure::{Failure, FailureKind, one_line};
use super::super::settings::ReplicateSettings;
use super::super::vendor_job::Progress;
use http_client::HttpResponse;
use ports::ledger::MicroUsd;

/// Maximum length of a prediction id.
const MAX_ID_CHARS: usize = 64;

/// Maximum values of an output that are searched for a file.
const MAX_VALUES: usize = 64;

/// Inputs of the settings that are no JSON object.
#[derive(Debug, thiserror::Error)]
#[error("the inputs are no JSON object: {0}")]
pub struct InputsError(#[from] serde_json::Error);

/// Body of a request; an error where the settings' inputs are no JSON object.
pub fn prediction(settings: &ReplicateSettings, image: &str, seed: u64) -> Result<Value, InputsError> {
    let mut input: Map<String, Value> = serde_json::from_str(&settings.inputs)?;
    input.insert(settings.image_input.clone(), json!(image));
    if !settings.seed_input.is_empty() {
        // Models take 31 bits.
        input.insert(settings.seed_input.clone(), json!(seed & 0x7fff_ffff));
    }
    Ok(json!({ "version": settings.version, "input": input }))
}

#[derive(Deserialize)]
struct Prediction {
    id: String,
    status: String,
    #[serde(default)]
    output: Value,
    #[serde(default)]
    error: Value,
}

/// Reads the response to a submission. The price counts from here: vendors bill started predictions.
pub fn submitted(settings: &ReplicateSettings, reply: &HttpResponse) -> Reading<String> {
    let read = read(reply);
    let id = read.as_ref().ok().map(|prediction| prediction.id.clone());
    Reading {
        cost: id.as_ref().map(|_| MicroUsd::of_usd(settings.usd_per_prediction)),
        input_tokens: None,
        output_tokens: None,
        task: id,
        result: read.map(|prediction| prediction.id),
    }
}

/// Reads the status of a prediction.
pub fn progress(reply: &HttpResponse) -> Result<Progress, Failure> {
    let Prediction { status, output, error, .. } = read(reply)?;
    match status.as_str() {
        "starting" | "processing" | "queued" => Ok(Progress::Working),
        "succeeded" => file_of(&output)
            .map(|url| Progress::Ready { url })
            .ok_or_else(|| bad("its output names no GLB file".into())),
        "failed" | "canceled" | "aborted" => {
            let why = error.as_str().map_or_else(|| error.to_string(), str::to_owned);
            Ok(Progress::Failed(format!("{status}: {}", one_line(&why))))
        }
        other => Err(bad(format!("a prediction is {:?}", one_line(other)))),
    }
}

fn read(reply: &HttpResponse) -> Result<Prediction, Failure> {
    if !reply.content_type.ends_with("json") {
        let kind = one_line(&reply.content_type);
        return Err(bad(format!("it answered with {kind:?} in place of JSON")));
    }
    let prediction: Prediction = serde_json::from_slice(&reply.body)
        .map_err(|error| bad(format!("its answer is no prediction: {error}")))?;
    // The id becomes part of a path.
    let plain = |c: char| c.is_ascii_alphanumeric() || c == '-' || c == '_';
    match prediction.id.is_empty() || prediction.id.len() > MAX_ID_CHARS || !prediction.id.chars().all(plain)
    {
        true => Err(bad("a prediction's id is no plain word".into())),
        false => Ok(prediction),
    }
}

/// The URL of a GLB file: the output itself, or a value of its list or object. Of several, the first whose path ends in
/// `.glb`.
fn file_of(output: &Value) -> Option<String> {
    let mut open = vec![output];
    let mut visited = 0;
    while let Some(value) = open.pop() {
        visited += 1;
        if visited > MAX_VALUES {
            return None;
        }
        match value {
            Value::String(url) => {
                let path = url.split(['?', '#']).next().unwrap_or_default();
                if path.to_ascii_lowercase().ends_with(".glb") {
                    return Some(url.clone());
                }
            }
            Value::Array(values) => open.extend(values.iter().rev().take(MAX_VALUES)),
            Value::Object(values) => open.extend(values.values().rev().take(MAX_VALUES)),
            _ => {}
        }
    }
    None
}

fn bad(reason: String) -> Failure {
    Failure::new(FailureKind::BadAnswer, reason)
}

#[cfg(test)]
mod tests {
    use super::*;
    use bytes::Bytes;

    fn settings() -> ReplicateSettings {
        let mut defaults = crate::chat::tests::defaults();
        let section = defaults["providers"]["replicate"].take();
        serde_json::from_value(section).expect("is the section")
    }

    fn reply(body: &str) -> HttpResponse {
        let body = Bytes::copy_from_slice(body.as_bytes());
        HttpResponse { status: 201, content_type: "application/json".into(), retry_after: None, body }
    }

    const STARTING: &str = r#"{
      "id": "gm3qorzdhgbfurvjtvhg6dckhu",
      "model": "replicate/hello-world",
      "version": "5c7d5dc6dd8bf75c1acaa8565735e7986bc5b66206b55cca93cb72c9bf15ccaa",
      "input": { "text": "Alice" },
      "logs": "",
      "error": null,
      "status": "starting",
      "created_at": "2023-09-08T16:19:34.765994657Z",
      "urls": {
        "cancel": "https://api.replicate.com/v1/predictions/gm3qorzdhgbfurvjtvhg6dckhu/cancel",
        "get": "https://api.replicate.com/v1/predictions/gm3qorzdhgbfurvjtvhg6dckhu"
      }
    }"#;

    fn with(status: &str, output: &str) -> String {
        let changed = STARTING.replace("\"starting\"", &format!("\"{status}\""));
        changed.replace("\"logs\": \"\"", &format!("\"output\": {output}"))
    }

    #[test]
    fn prediction_request_has_the_published_form() {
        let settings = ReplicateSettings {
            version: "5c7d5dc6dd8bf75c1acaa8565735e7986bc5b66206b55cca93cb72c9bf15ccaa".into(),
            image_input: "image".into(),
            seed_input: "seed".into(),
            inputs: r#"{"steps": 50}"#.into(),
            ..settings()
        };
        let body = prediction(&settings, "data:image/png;base64,AA==", 1 << 40 | 7).expect("is an object");
        let published = r#"{"version": "5c7d5dc6dd8bf75c1acaa8565735e7986bc5b66206b55cca93cb72c9bf15ccaa",
            "input": {"steps": 50, "image": "data:image/png;base64,AA==", "seed": 7}}"#;
        assert_eq!(body, serde_json::from_str::<Value>(published).expect("is JSON"));
        let unseeded = ReplicateSettings { seed_input: String::new(), ..settings.clone() };
        assert!(prediction(&unseeded, "", 7).expect("is an object")["input"].get("seed").is_none());
        let broken = ReplicateSettings { inputs: "[1]".into(), ..settings };
        let error = prediction(&broken, "", 7).expect_err("is a list").to_string();
        assert!(error.contains("no JSON object"), "{error}");
    }

    #[test]
    fn published_responses_are_read() {
        let reading = submitted(&settings(), &reply(STARTING));
        assert_eq!(reading.task.as_deref(), Some("gm3qorzdhgbfurvjtvhg6dckhu"));
        assert_eq!(reading.result.as_deref(), Ok("gm3qorzdhgbfurvjtvhg6dckhu"));
        assert_eq!(reading.cost, Some(MicroUsd::of_usd(settings().usd_per_prediction)));
        assert_eq!(progress(&reply(STARTING)), Ok(Progress::Working));
        let url = "https://replicate.delivery/xezq/a/mesh.glb";
        for output in [
            format!("\"{url}\""),
            format!("[\"https://replicate.delivery/xezq/a/preview.png\", \"{url}\"]"),
            format!("{{\"video\": null, \"mesh\": \"{url}\", \"other\": \"https://a/b.glb\"}}"),
        ] {
            assert_eq!(
                progress(&reply(&with("succeeded", &output))),
                Ok(Progress::Ready { url: url.into() }),
                "{output}"
            );
        }
        let failed = with("failed", "null").replace("\"error\": null", "\"error\": \"CUDA out of memory\"");
        assert_eq!(progress(&reply(&failed)), Ok(Progress::Failed("failed: CUDA out of memory".into())));
    }

    #[test]
    fn malformed_predictions_are_rejected() {
        let deep = format!("{}1{}", "[".repeat(100), "]".repeat(100));
        for body in [
            "",
            "[]",
            "{}",
            &with("finished", "null"),
            &with("succeeded", "null"),
            &with("succeeded", "\"https://replicate.delivery/a.png\""),
            &with("succeeded", &deep),
            &STARTING.replacen("gm3qorzdhgbfurvjtvhg6dckhu", "../../account", 1),
            &STARTING.replacen("gm3qorzdhgbfurvjtvhg6dckhu", "", 1),
        ] {
            let failure = progress(&reply(body)).expect_err(body);
            assert_eq!(failure.kind, FailureKind::BadAnswer, "{body}");
            if !body.contains("succeeded") && !body.contains("finished") {
                let reading = submitted(&settings(), &reply(body));
                assert!(
                    reading.result.is_err() && reading.task.is_none() && reading.cost.is_none(),
                    "{body}"
                );
            }
        }
    }
}
