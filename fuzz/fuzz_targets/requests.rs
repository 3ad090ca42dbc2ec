//! Bodies of `POST /scenes`: JSON, options and settings, an image in base64.
#![no_main]

use std::sync::LazyLock;

use libfuzzer_sys::fuzz_target;
use tabletopgen::api::scene_body::{SceneBody, parse};
use tabletopgen::app::App;
use tabletopgen::config::{Sources, layers};

static APP: LazyLock<App> =
    LazyLock::new(|| App::new(&layers::load(Sources::default()).expect("the defaults are valid")));

fuzz_target!(|body: &[u8]| {
    let Ok(body) = parse::<SceneBody>(body) else { return };
    let base64 = body.image.as_ref().and_then(|image| image.base64.as_ref());
    let image = base64.map(|image| image.0.clone());
    if let Ok(submission) = APP.check_scene(body.order(image)) {
        // An accepted request is stored as JSON and read again.
        let stored = serde_json::to_vec(&submission.request).expect("a request has a JSON form");
        let read = serde_json::from_slice(&stored).expect("a request is read again");
        assert_eq!(submission.request, read);
    }
});
