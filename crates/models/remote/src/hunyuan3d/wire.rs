//! Wire format: `POST {base}/send` and `GET {base}/status/{uid}` of Hunyuan3D's `api_server.py`, 2 and 2.1.

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use serde::Deserialize;
use serde_json::{Value, json};

use super::super::endpoint::Reading;
use super::super::failure::{Failure, FailureKind, one_line};
use super::super::settings::Hunyuan3dSettings;
use super::super::vendor_job::Progress;
use http_client::HttpResponse;
use ports::ledger::MicroUsd;

/// Maximum length of a job id.
const MAX_UID_CHARS: usize = 64;

/// Body of a request. The server accepts seeds of 31 bits and limits faces only where it textures.
pub fn request(settings: &Hunyuan3dSettings, png: &[u8], seed: u64) -> Value {
    json!({
        "image": STANDARD.encode(png), "seed": seed & 0x7fff_ffff, "octree_resolution": settings.octree_resolution,
        "num_inference_steps": settings.inference_steps, "guidance_scale": settings.guidance_scale,
        "texture": settings.texture, "face_count": settings.mesh.max_triangles, "type": "glb",
    })
}

#[derive(Deserialize)]
struct Submitted {
    uid: String,
}

#[derive(Deserialize)]
struct Status {
    status: String,
    model_base64: Option<String>,
    message: Option<String>,
}

/// Reads the response to a submission.
pub fn submitted(settings: &Hunyuan3dSettings, reply: &HttpResponse) -> Reading<String> {
    let plain = |c: char| c.is_ascii_alphanumeric() || c == '-';
    let uid = json_of::<Submitted>(reply).and_then(|Submitted { uid }| {
        // The id becomes part of a path.
        match uid.is_empty() || uid.len() > MAX_UID_CHARS || !uid.chars().all(plain) {
            true => Err(bad("a job's uid is no plain word".into())),
            false => Ok(uid),
        }
    });
    Reading {
        cost: uid.as_ref().ok().map(|_| MicroUsd::of_usd(settings.usd_per_mesh)),
        input_tokens: None,
        output_tokens: None,
        task: uid.as_ref().ok().cloned(),
        result: uid,
    }
}

/// Reads the status of a job.
pub fn progress(reply: &HttpResponse) -> Result<Progress, Failure> {
    let Status { status, model_base64, message } = json_of(reply)?;
    match (status.as_str(), model_base64) {
        ("processing" | "texturing", _) => Ok(Progress::Working),
        ("completed", Some(text)) => STANDARD
            .decode(text)
            .map(|file| Progress::File(file.into()))
            .map_err(|error| bad(format!("its mesh is no base64: {error}"))),
        ("completed", None) => Err(bad("it is done and sends no mesh".into())),
        ("error", _) => Ok(Progress::Failed(one_line(&message.unwrap_or_default()))),
        (other, _) => Err(bad(format!("a job is {:?}", one_line(other)))),
    }
}

fn json_of<T: serde::de::DeserializeOwned>(reply: &HttpResponse) -> Result<T, Failure> {
    if !reply.content_type.ends_with("json") {
        return Err(bad(format!("it answered with {:?} in place of JSON", one_line(&reply.content_type))));
    }
    serde_json::from_slice(&reply.body)
        .map_err(|error| bad(format!("its answer is of another form: {error}")))
}

fn bad(reason: String) -> Failure {
    Failure::new(FailureKind::BadAnswer, reason)
}

#[cfg(test)]
mod tests {
    use super::*;
    use bytes::Bytes;

    fn settings() -> Hunyuan3dSettings {
        let mut defaults = crate::chat::tests::defaults();
        let section = defaults["providers"]["hunyuan3d"].take();
        serde_json::from_value(section).expect("is the section")
    }

    fn reply(body: &str) -> HttpResponse {
        let body = Bytes::copy_from_slice(body.as_bytes());
        HttpResponse { status: 200, content_type: "application/json".into(), retry_after: None, body }
    }

    #[test]
    fn request_has_the_fields_of_the_server() {
        let body = request(&settings(), b"\x89PNG", 1 << 33 | 5);
        let names: Vec<&String> = body.as_object().expect("is an object").keys().collect();
        let read = [
            "image",
            "seed",
            "octree_resolution",
            "num_inference_steps",
            "guidance_scale",
            "texture",
            "face_count",
            "type",
        ];
        assert_eq!(names, read);
        assert_eq!((&body["image"], &body["seed"]), (&json!("iVBORw=="), &json!(5)));
    }

    #[test]
    fn responses_of_the_server_source_are_read() {
        let reading = submitted(&settings(), &reply(r#"{"uid":"0f1d5a52-5f5c-4c1e-9d0e-0a6f5b1f9b11"}"#));
        assert_eq!(reading.task.as_deref(), Some("0f1d5a52-5f5c-4c1e-9d0e-0a6f5b1f9b11"));
        assert_eq!(progress(&reply(r#"{"status":"processing"}"#)), Ok(Progress::Working));
        let done = r#"{"status":"completed","model_base64":"Z2xURg=="}"#;
        assert_eq!(progress(&reply(done)), Ok(Progress::File(Bytes::from_static(b"glTF"))));
        // 2.1 says more.
        assert_eq!(progress(&reply(r#"{"status":"texturing"}"#)), Ok(Progress::Working));
        let failed = r#"{"status":"error","message":"CUDA out of memory"}"#;
        assert_eq!(progress(&reply(failed)), Ok(Progress::Failed("CUDA out of memory".into())));
    }

    #[test]
    fn other_responses_are_rejected() {
        for body in [
            "",
            "{}",
            "[]",
            r#"{"status":"completed"}"#,
            r#"{"status":"completed","model_base64":"no!"}"#,
            r#"{"status":"done"}"#,
            r#"{"uid":"../../etc/passwd"}"#,
            r#"{"uid":""}"#,
        ] {
            assert!(progress(&reply(body)).is_err(), "{body}");
            let reading = submitted(&settings(), &reply(body));
            assert!(reading.result.is_err() && reading.task.is_none() && reading.cost.is_none(), "{body}");
        }
    }
}
