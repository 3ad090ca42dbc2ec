//! Answers of vendors' endpoints as they come over the wire: chat completions, rendered images, jobs of mesh
//! generators.
#![no_main]

use std::sync::LazyLock;

use bytes::Bytes;
use libfuzzer_sys::fuzz_target;
use tabletopgen::config::{Config, Sources, layers};
use remote::failure::Failure;
use http_client::HttpResponse;
use remote::{ark, chat, hunyuan3d, images, replicate, tencent};

static CONFIG: LazyLock<Config> =
    LazyLock::new(|| layers::load(Sources::default()).expect("the defaults are valid").config);

fuzz_target!(|body: &[u8]| {
    let providers = &CONFIG.providers;
    let mut reply = HttpResponse {
        status: 200,
        content_type: "application/json".into(),
        retry_after: None,
        body: Bytes::copy_from_slice(body),
    };
    let _ = chat::wire::read(&providers.chat, &reply);
    let _ = images::wire::read(&providers.openai_images, &reply);
    let _ = ark::wire::read(&providers.ark, &reply);
    let ids = [
        replicate::wire::submitted(&providers.replicate, &reply).task,
        hunyuan3d::wire::submitted(&providers.hunyuan3d, &reply).task,
        tencent::wire::submitted(&providers.tencent, &reply).task,
    ];
    // Ids become parts of paths.
    let plain = |c: char| c.is_ascii_alphanumeric() || c == '-' || c == '_';
    assert!(ids.iter().flatten().all(|id| !id.is_empty() && id.chars().all(plain)), "{ids:?}");
    let _ = replicate::wire::progress(&reply);
    let _ = hunyuan3d::wire::progress(&reply);
    let _ = tencent::wire::progress(&reply);
    for status in [400, 401, 404, 429, 500] {
        reply.status = status;
        let failure = Failure::of_status(&reply).expect("this is no success");
        assert!(failure.reason.len() < 2_000, "{}", failure.reason);
    }
});
