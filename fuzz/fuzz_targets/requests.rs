//! Bodies of `POST /scenes`: JSON, options and settings, an image in base64.
#![no_main]

use std::sync::LazyLock;

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use libfuzzer_sys::fuzz_target;
use tabletopgen::api::Validate;
use tabletopgen::api::submission::{SceneBody, parse, validate};
use tabletopgen::app::pipeline;
use tabletopgen::config::{Resolved, Sources, layers};

static RESOLVED: LazyLock<Resolved> =
    LazyLock::new(|| layers::load(Sources::default()).expect("the defaults are valid"));
static VALIDATE: LazyLock<Validate> = LazyLock::new(|| pipeline::validate(&RESOLVED));

fuzz_target!(|body: &[u8]| {
    let Ok(body) = parse::<SceneBody>(body) else { return };
    let base64 = body.image.as_ref().and_then(|image| image.base64.as_ref());
    let image = base64.and_then(|text| STANDARD.decode(text.trim()).ok());
    if let Ok(submission) = validate(body, image.map(Into::into), &RESOLVED.config.server, &VALIDATE) {
        // An accepted request is stored as JSON and read again.
        let stored = serde_json::to_vec(&submission.request).expect("a request has a JSON form");
        let read = serde_json::from_slice(&stored).expect("a request is read again");
        assert_eq!(submission.request, read);
    }
});
