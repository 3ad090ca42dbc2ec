//! The published examples of the Images endpoints, and malformed responses.

use super::*;
use crate::settings::{ImageQuality, ReferenceSize};

fn settings() -> ImagesSettings {
    let mut defaults = crate::chat::tests::defaults();
    let section = defaults["providers"]["openai_images"].take();
    ImagesSettings {
        model: "gpt-image-1".into(),
        text_usd_per_million: 5.0,
        image_usd_per_million: 10.0,
        drawn_usd_per_million: 40.0,
        ..serde_json::from_value(section).expect("is the section")
    }
}

fn reply(body: &str) -> HttpResponse {
    let body = Bytes::copy_from_slice(body.as_bytes());
    HttpResponse { status: 200, content_type: "application/json".into(), retry_after: None, body }
}

#[test]
fn generation_request_has_the_published_form() {
    let settings =
        ImagesSettings { reference_size: ReferenceSize::Square, quality: ImageQuality::High, ..settings() };
    let body = generation(&settings, "A cute baby sea otter");
    // The published example, with what this program adds to it.
    let published =
        r#"{"model": "gpt-image-1", "prompt": "A cute baby sea otter", "n": 1, "size": "1024x1024"}"#;
    let published: Value = serde_json::from_str(published).expect("is JSON");
    for (name, value) in published.as_object().expect("is an object") {
        assert_eq!(body[name], *value, "{name}");
    }
    let added: Vec<&String> =
        body.as_object().expect("is an object").keys().filter(|name| published.get(name).is_none()).collect();
    assert_eq!(added, ["quality", "background", "output_format"]);
    assert_eq!(body["quality"], "high");
}

#[test]
fn edit_request_has_the_published_form() {
    let images = [Bytes::from_static(b"first"), Bytes::from_static(b"second")];
    let settings = ImagesSettings { input_fidelity: InputFidelity::High, ..settings() };
    let (content_type, body) =
        edit(&settings, Canvas::Object, "Create a lovely gift basket", &images).encoded();
    let boundary = content_type.strip_prefix("multipart/form-data; boundary=").expect("is a form");
    let text = String::from_utf8(body.to_vec()).expect("is text here");
    let heads: Vec<&str> = text
        .split(&format!("--{boundary}\r\nContent-Disposition: form-data; "))
        .skip(1)
        .map(|part| part.split("\r\n").next().expect("has a line"))
        .collect();
    // `-F "model=gpt-image-1" -F "image[]=@body-lotion.png" -F "image[]=@bath-bomb.png" -F 'prompt=..'`
    assert_eq!(
        heads,
        [
            r#"name="model""#,
            r#"name="image[]"; filename="0.png""#,
            r#"name="image[]"; filename="1.png""#,
            r#"name="prompt""#,
            r#"name="n""#,
            r#"name="size""#,
            r#"name="quality""#,
            r#"name="background""#,
            r#"name="output_format""#,
            r#"name="input_fidelity""#,
        ]
    );
    assert!(text.contains("Content-Type: image/png\r\n\r\nsecond\r\n"));
    assert!(text.contains("name=\"background\"\r\n\r\ntransparent\r\n"));
}

#[test]
fn read_parses_and_prices_the_published_response() {
    let published = r#"{
      "created": 1713833628,
      "data": [{"b64_json": "aGVsbG8="}],
      "usage": {
        "total_tokens": 100, "input_tokens": 50, "output_tokens": 50,
        "input_tokens_details": {"text_tokens": 10, "image_tokens": 40}
      }
    }"#;
    let reading = read(&settings(), &reply(published));
    assert_eq!(reading.result, Ok(b"hello".to_vec()));
    // 10 tokens at 5 dollars a million, 40 at 10, 50 at 40.
    assert_eq!(reading.cost, Some(MicroUsd(50 + 400 + 2000)));
    assert_eq!((reading.input_tokens, reading.output_tokens), (Some(50), Some(50)));
    let whole = r#"{"data": [{"b64_json": ""}], "usage": {"input_tokens": 50, "output_tokens": 50}}"#;
    assert_eq!(read(&settings(), &reply(whole)).cost, Some(MicroUsd(500 + 2000)));
    assert_eq!(read(&settings(), &reply(r#"{"data": [{"b64_json": ""}]}"#)).cost, None);
}

#[test]
fn read_rejects_responses_without_an_image() {
    for body in [
        "{}",
        r#"{"data": []}"#,
        r#"{"data": [{"url": "http://169.254.169.254/latest"}]}"#,
        r#"{"data": [{"b64_json": "not base64!"}]}"#,
        r#"{"data": [{"b64_json": null}]}"#,
        r#"{"data": null}"#,
        "<html>",
        "",
    ] {
        let failure = read(&settings(), &reply(body)).result.expect_err(body);
        assert_eq!(failure.kind, FailureKind::BadAnswer, "{body}");
    }
    let page = HttpResponse { content_type: "text/html".into(), ..reply("{}") };
    assert_eq!(read(&settings(), &page).result.map_err(|failure| failure.kind), Err(FailureKind::BadAnswer));
}

#[test]
fn max_cost_bounds_the_billed_cost() {
    let settings = settings();
    let set_aside = max_cost(&settings, "Redraw the mug.", 2);
    // "Redraw the mug." is 5 tokens; two sent images and one generated image of the documented largest sizes.
    assert!(set_aside >= cost(&settings, 5.0, 2.0 * 6563.0, 6240.0), "{set_aside}");
}
