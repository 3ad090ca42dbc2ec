//! Bodies of `POST /scenes`: JSON, options and settings, an image in base64.
#![no_main]

use std::sync::LazyLock;

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use libfuzzer_sys::fuzz_target;
use tabletopgen::api::Validate;
use tabletopgen::api::submission::{Draft, SceneBody, accept, parse};
use tabletopgen::app::pipeline;
use tabletopgen::config::{Resolved, Sources, layers};

static RESOLVED: LazyLock<Resolved> =
    LazyLock::new(|| layers::load(Sources::default()).expect("the defaults are valid"));
static VALIDATE: LazyLock<Validate> = LazyLock::new(|| pipeline::validate(&RESOLVED));

fuzz_target!(|body: &[u8]| {
    let Ok(body) = parse::<SceneBody>(body) else { return };
    let image = body.image.and_then(|image| STANDARD.decode(image.base64?.trim()).ok());
    let SceneBody { text, seed, labels, options, .. } = body;
    let draft = Draft { text, image: image.map(Into::into), seed, labels, options };
    if let Ok(submission) = accept(draft, &RESOLVED.config.server, &VALIDATE) {
        // What is taken is kept as JSON, and read from it again.
        let kept = serde_json::to_vec(&submission.request).expect("a request has a JSON form");
        let read = serde_json::from_slice(&kept).expect("a request is read again");
        assert_eq!(submission.request, read);
    }
});
