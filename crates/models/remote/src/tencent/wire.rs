//! Wire format: the actions `SubmitHunyuanTo3DProJob` and `QueryHunyuanTo3DProJob` of Tencent Cloud. Errors come inside
//! responses with status 200.

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use serde::Deserialize;
use serde_json::{Value, json};

use super::super::endpoint::Reading;
use super::super::failure::{Failure, FailureKind, one_line};
use super::super::settings::TencentSettings;
use super::super::vendor_job::Progress;
use http_client::HttpResponse;
use ports::ledger::MicroUsd;

/// The action that starts a job.
pub const SUBMIT: &str = "SubmitHunyuanTo3DProJob";

/// The action that queries a job.
pub const QUERY: &str = "QueryHunyuanTo3DProJob";

/// Maximum length of a job id.
const MAX_ID_CHARS: usize = 64;

/// Body of a submission. The model cannot be seeded.
pub fn submission(settings: &TencentSettings, png: &[u8]) -> Value {
    json!({
        "Model": settings.model, "ImageBase64": STANDARD.encode(png), "EnablePBR": false,
        "FaceCount": settings.face_count, "GenerateType": "Normal",
    })
}

/// Body of a status query.
pub fn query(id: &str) -> Value {
    json!({ "JobId": id })
}

#[derive(Deserialize)]
struct Envelope<T> {
    #[serde(rename = "Response")]
    response: Response<T>,
}

#[derive(Deserialize)]
#[serde(untagged)]
enum Response<T> {
    Failed {
        #[serde(rename = "Error")]
        error: Message,
    },
    Good(T),
}

#[derive(Deserialize)]
#[serde(rename_all = "PascalCase")]
struct Message {
    code: String,
    message: String,
}

#[derive(Deserialize)]
#[serde(rename_all = "PascalCase")]
struct Submitted {
    job_id: String,
}

#[derive(Deserialize)]
#[serde(rename_all = "PascalCase")]
struct JobStatus {
    status: String,
    #[serde(default)]
    error_code: String,
    #[serde(default)]
    error_message: String,
    #[serde(default, rename = "ResultFile3Ds")]
    files: Vec<File>,
}

#[derive(Deserialize)]
#[serde(rename_all = "PascalCase")]
struct File {
    #[serde(rename = "Type", default)]
    kind: String,
    #[serde(default)]
    url: String,
}

/// Reads the response to a submission. The price counts from here.
pub fn submitted(settings: &TencentSettings, reply: &HttpResponse) -> Reading<String> {
    let plain = |c: char| c.is_ascii_alphanumeric() || c == '-' || c == '_';
    let id = read::<Submitted>(reply).and_then(|Submitted { job_id }| {
        match job_id.is_empty() || job_id.len() > MAX_ID_CHARS || !job_id.chars().all(plain) {
            true => Err(bad("a job's id is no plain word".into())),
            false => Ok(job_id),
        }
    });
    let cost = match &id {
        Ok(_) => Some(MicroUsd::of_usd(settings.usd_per_mesh)),
        // A response with an error has started no job.
        Err(failure) => (failure.kind != FailureKind::BadAnswer).then_some(MicroUsd::ZERO),
    };
    Reading { cost, input_tokens: None, output_tokens: None, task: id.as_ref().ok().cloned(), result: id }
}

/// Reads the status of a job. A GLB file has priority over a ZIP archive of an OBJ file.
pub fn progress(reply: &HttpResponse) -> Result<Progress, Failure> {
    let JobStatus { status, error_code, error_message, files } = read(reply)?;
    match status.as_str() {
        "WAIT" | "RUN" => Ok(Progress::Working),
        "FAIL" => Ok(Progress::Failed(one_line(&format!("{error_code}: {error_message}")))),
        "DONE" => {
            let of_kind = |kind: &str| files.iter().find(|file| file.kind.eq_ignore_ascii_case(kind));
            let file = of_kind("GLB").or_else(|| of_kind("OBJ")).filter(|file| !file.url.is_empty());
            let file = file.ok_or_else(|| bad("it is done and names no GLB or OBJ file".into()))?;
            Ok(Progress::Ready { url: file.url.clone() })
        }
        other => Err(bad(format!("a job is {:?}", one_line(other)))),
    }
}

fn read<T: serde::de::DeserializeOwned>(reply: &HttpResponse) -> Result<T, Failure> {
    if !reply.content_type.ends_with("json") {
        return Err(bad(format!("it answered with {:?} in place of JSON", one_line(&reply.content_type))));
    }
    let envelope: Envelope<T> = serde_json::from_slice(&reply.body)
        .map_err(|error| bad(format!("its answer is of another form: {error}")))?;
    match envelope.response {
        Response::Good(answer) => Ok(answer),
        Response::Failed { error } => {
            let reason = one_line(&format!("{}: {}", error.code, error.message));
            Err(Failure::new(kind_of(&error.code), reason))
        }
    }
}

/// The kind of an error code of Tencent Cloud: common codes by their first part, then those of the service.
fn kind_of(code: &str) -> FailureKind {
    let (family, detail) = code.split_once('.').unwrap_or((code, ""));
    match (family, detail) {
        ("ResourceUnavailable", "InArrears" | "LowBalance" | "ChargeStatusException")
        | ("ResourceInsufficient", "ChargeResourceExhausted")
        | ("FailedOperation", "ResourcePackExhausted") => FailureKind::QuotaSpent,
        ("RequestLimitExceeded" | "LimitExceeded" | "ResourceInsufficient", _) => FailureKind::Busy,
        ("AuthFailure" | "UnauthorizedOperation", _) => FailureKind::Denied,
        ("InvalidAction" | "NoSuchVersion" | "NoSuchProduct" | "UnsupportedRegion", _) => {
            FailureKind::NotFound
        }
        ("ResourceNotFound", _) => FailureKind::NotFound,
        ("OperationDenied", _) => FailureKind::Refused,
        ("InvalidParameter" | "InvalidParameterValue" | "MissingParameter" | "UnknownParameter", _) => {
            FailureKind::RequestRejected
        }
        ("UnsupportedOperation" | "RequestSizeLimitExceeded", _) => FailureKind::RequestRejected,
        _ => FailureKind::ServerError,
    }
}

fn bad(reason: String) -> Failure {
    Failure::new(FailureKind::BadAnswer, reason)
}

#[cfg(test)]
mod tests {
    use super::*;
    use bytes::Bytes;

    fn settings() -> TencentSettings {
        let mut defaults = crate::chat::tests::defaults();
        let section = defaults["providers"]["tencent"].take();
        serde_json::from_value(section).expect("is the section")
    }

    fn reply(body: &str) -> HttpResponse {
        let body = Bytes::copy_from_slice(body.as_bytes());
        HttpResponse { status: 200, content_type: "application/json".into(), retry_after: None, body }
    }

    #[test]
    fn submission_has_the_documented_fields() {
        let body = submission(&settings(), b"\x89PNG");
        let names: Vec<&String> = body.as_object().expect("is an object").keys().collect();
        assert_eq!(names, ["Model", "ImageBase64", "EnablePBR", "FaceCount", "GenerateType"]);
        assert_eq!((&body["Model"], &body["ImageBase64"]), (&json!("3.0"), &json!("iVBORw==")));
    }

    // The literals have the form of the API reference's examples.
    #[test]
    fn submitted_reads_the_job_id_and_the_price() {
        let message = r#"{"Response": {"JobId": "1375367755519696896", "RequestId": "173f8c3f-d326-4e0e-b9d0-7a5c4ed0fcb0"}}"#;
        let reading = submitted(&settings(), &reply(message));
        assert_eq!(reading.result, Ok("1375367755519696896".to_owned()));
        assert_eq!(reading.task, Some("1375367755519696896".to_owned()));
        assert_eq!(reading.cost, Some(MicroUsd::of_usd(settings().usd_per_mesh)));
        for spoiled in [message.replace("1375", "../"), message.replace("JobId", "Id"), "[]".to_owned()] {
            assert!(submitted(&settings(), &reply(&spoiled)).result.is_err(), "{spoiled}");
        }
    }

    #[test]
    fn errors_come_with_status_200() {
        let message = |code: &str| {
            let body = format!(
                r#"{{"Response": {{"Error": {{"Code": "{code}", "Message": "told"}}, "RequestId": "ed93f3cb"}}}}"#
            );
            let reading = submitted(&settings(), &reply(&body));
            let failure = reading.result.expect_err("is an error");
            assert_eq!(reading.cost, Some(MicroUsd::ZERO), "{code}");
            assert_eq!(failure.reason, format!("{code}: told"));
            failure.kind
        };
        for (code, kind) in [
            ("AuthFailure.SignatureFailure", FailureKind::Denied),
            ("AuthFailure.SignatureExpire", FailureKind::Denied),
            ("RequestLimitExceeded", FailureKind::Busy),
            ("RequestLimitExceeded.JobNumExceed", FailureKind::Busy),
            ("ResourceInsufficient", FailureKind::Busy),
            ("ResourceUnavailable.InArrears", FailureKind::QuotaSpent),
            ("InvalidParameterValue.ImageSize", FailureKind::RequestRejected),
            ("OperationDenied.ImageIllegalDetected", FailureKind::Refused),
            ("InternalError", FailureKind::ServerError),
            ("FailedOperation.InnerError", FailureKind::ServerError),
            ("InvalidAction", FailureKind::NotFound),
        ] {
            assert_eq!(message(code), kind, "{code}");
        }
    }

    #[test]
    fn progress_reads_every_documented_status() {
        let status_of = |status: &str, files: &str| {
            progress(&reply(&format!(
                r#"{{"Response": {{"Status": "{status}", "ErrorCode": "", "ErrorMessage": "", "ResultFile3Ds": {files},
                    "RequestId": "8d4c"}}}}"#
            )))
        };
        assert_eq!(status_of("WAIT", "[]"), Ok(Progress::Working));
        assert_eq!(status_of("RUN", "[]"), Ok(Progress::Working));
        let obj = r#"{"Type": "OBJ", "Url": "https://a.example/b.zip?q-sign=1", "PreviewImageUrl": ""}"#;
        let glb = r#"{"Type": "GLB", "Url": "https://a.example/b.glb?q-sign=1", "PreviewImageUrl": ""}"#;
        let at = |url: &str| Ok(Progress::Ready { url: url.to_owned() });
        assert_eq!(status_of("DONE", &format!("[{obj}, {glb}]")), at("https://a.example/b.glb?q-sign=1"));
        assert_eq!(status_of("DONE", &format!("[{obj}]")), at("https://a.example/b.zip?q-sign=1"));
        assert!(status_of("DONE", "[]").is_err() && status_of("LOST", "[]").is_err());
        let failed = r#"{"Response": {"Status": "FAIL", "ErrorCode": "FailedOperation.ModelError",
            "ErrorMessage": "no thing", "RequestId": "8d4c"}}"#;
        assert_eq!(
            progress(&reply(failed)),
            Ok(Progress::Failed("FailedOperation.ModelError: no thing".into()))
        );
    }
}
