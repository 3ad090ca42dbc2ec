//! Wire format: `POST {base}/images/generations` of Ark, for Seedream 4.0 and later. The literals of the tests have the
//! form of the published examples.

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use bytes::Bytes;
use serde::Deserialize;
use serde_json::{Value, json};

use super::super::endpoint::Reading;
use super::super::failure::{Failure, FailureKind, one_line};
use super::super::settings::ArkSettings;
use http_client::HttpResponse;
use ports::ledger::MicroUsd;

/// Body of a request for one image of a size, conditioned on PNG files if any. It switches off watermarks, which are
/// the default.
pub fn request(settings: &ArkSettings, size: &str, prompt: &str, images: &[Bytes]) -> Value {
    let mut body = json!({
        "model": settings.model, "prompt": prompt, "size": size, "sequential_image_generation": "disabled",
        "response_format": "b64_json", "watermark": false, "stream": false,
    });
    if !images.is_empty() {
        let urls = images.iter().map(|png| format!("data:image/png;base64,{}", STANDARD.encode(png)));
        body["image"] = json!(urls.collect::<Vec<String>>());
    }
    body
}

#[derive(Deserialize)]
struct Rendered {
    #[serde(default)]
    data: Vec<Image>,
    usage: Option<Usage>,
}

/// One image, or the reason why it is missing.
#[derive(Deserialize)]
struct Image {
    b64_json: Option<String>,
    error: Option<Message>,
}

#[derive(Deserialize)]
struct Message {
    #[serde(default)]
    code: String,
    #[serde(default)]
    message: String,
}

#[derive(Deserialize)]
struct Usage {
    generated_images: Option<u32>,
    output_tokens: Option<u64>,
}

/// Reads a successful response: the file of one image. A URL in its place is not followed.
pub fn read(settings: &ArkSettings, reply: &HttpResponse) -> Reading<Vec<u8>> {
    let bad = |reason: String| Failure::new(FailureKind::BadAnswer, reason);
    let rendered: Result<Rendered, Failure> = match reply.content_type.ends_with("json") {
        true => serde_json::from_slice(&reply.body)
            .map_err(|error| bad(format!("its answer is no list of images: {error}"))),
        false => Err(bad(format!("it answered with {:?} in place of JSON", one_line(&reply.content_type)))),
    };
    let usage = rendered.as_ref().ok().and_then(|rendered| rendered.usage.as_ref());
    let images = usage.and_then(|usage| usage.generated_images);
    Reading {
        // Images are billed individually.
        cost: images.map(|count| MicroUsd::of_usd(f64::from(count) * settings.usd_per_image)),
        input_tokens: None,
        output_tokens: usage.and_then(|usage| usage.output_tokens),
        task: None,
        result: rendered.and_then(|rendered| file(rendered.data)),
    }
}

fn file(data: Vec<Image>) -> Result<Vec<u8>, Failure> {
    let bad = |reason: String| Failure::new(FailureKind::BadAnswer, reason);
    let image = data.into_iter().next().ok_or_else(|| bad("its answer has no image".into()))?;
    if let Some(Message { code, message }) = image.error {
        let kind = match code.contains("SensitiveContent") {
            true => FailureKind::Refused,
            false => FailureKind::BadAnswer,
        };
        return Err(Failure::new(kind, one_line(&format!("{code}: {message}"))));
    }
    let text = image.b64_json.ok_or_else(|| bad("its answer has no image in base64".into()))?;
    STANDARD.decode(text).map_err(|error| bad(format!("its image is no base64: {error}")))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn settings() -> ArkSettings {
        let mut defaults = crate::chat::tests::defaults();
        let section = defaults["providers"]["ark"].take();
        serde_json::from_value(section).expect("is the section")
    }

    fn read_text(body: &str) -> Reading<Vec<u8>> {
        let body = Bytes::copy_from_slice(body.as_bytes());
        read(
            &settings(),
            &HttpResponse { status: 200, content_type: "application/json".into(), retry_after: None, body },
        )
    }

    #[test]
    fn request_disables_the_watermark_and_has_the_documented_fields() {
        let body = request(&settings(), "2K", "a table", &[]);
        assert_eq!(
            (&body["watermark"], &body["sequential_image_generation"]),
            (&json!(false), &json!("disabled"))
        );
        assert_eq!(body["size"], "2K");
        assert!(body.get("image").is_none() && body.get("seed").is_none(), "4.0 cannot be seeded");
        let body = request(&settings(), "2K", "a table", &[Bytes::from_static(b"PNG")]);
        assert_eq!(body["image"], json!(["data:image/png;base64,UE5H"]));
    }

    #[test]
    fn read_parses_and_bills_an_image() {
        let reading = read_text(
            r#"{"model": "doubao-seedream-4-0-250828", "created": 1757323224,
                "data": [{"b64_json": "UE5H", "size": "1152x864"}],
                "usage": {"generated_images": 1, "output_tokens": 3888, "total_tokens": 3888}}"#,
        );
        assert_eq!(reading.result, Ok(b"PNG".to_vec()));
        assert_eq!(reading.cost, Some(MicroUsd::of_usd(settings().usd_per_image)));
        assert_eq!(reading.output_tokens, Some(3888));
    }

    #[test]
    fn read_reports_why_an_image_is_missing() {
        let reading = read_text(
            r#"{"data": [{"error": {"code": "OutputImageSensitiveContentDetected", "message": "The request failed."}}],
                "usage": {"generated_images": 0, "output_tokens": 0, "total_tokens": 0}}"#,
        );
        assert_eq!(reading.cost, Some(MicroUsd::ZERO));
        assert_eq!(reading.result.expect_err("is refused").kind, FailureKind::Refused);
        for body in [
            r#"{"data": [{"error": {"code": "InternalServiceError", "message": ""}}]}"#,
            r#"{"data": [{"url": "https://a.example/b.jpeg"}]}"#,
            r#"{"data": [{"b64_json": "%"}]}"#,
            r#"{"data": []}"#,
            "[]",
        ] {
            assert_eq!(read_text(body).result.expect_err(body).kind, FailureKind::BadAnswer);
        }
    }
}
