//! Answers of the segmenter's server: boxes, words and masks as run lengths.
#![no_main]

use std::sync::LazyLock;

use bytes::Bytes;
use libfuzzer_sys::fuzz_target;
use tabletopgen::config::{Config, Sources, layers};
use http_client::HttpResponse;
use remote::sidecar;

static CONFIG: LazyLock<Config> =
    LazyLock::new(|| layers::load(Sources::default()).expect("the defaults are valid").config);

/// Height and width of the image that the seeds speak of.
const SIZE_PX: [u32; 2] = [4, 4];

fuzz_target!(|body: &[u8]| {
    let reply = HttpResponse {
        status: 200,
        content_type: "application/json".into(),
        retry_after: None,
        body: Bytes::copy_from_slice(body),
    };
    let labels = ["mug".to_owned(), "magnifying glass".to_owned()];
    let settings = &CONFIG.providers.segmenter_sidecar;
    if let Ok(found) = sidecar::wire::read(settings, &reply, SIZE_PX, &labels).result {
        for found in found {
            assert_eq!([found.mask.height_px(), found.mask.width_px()], SIZE_PX);
            assert!(found.mask.area_px() > 0 && (0.0..=1.0).contains(&found.score));
        }
    }
});
