//! PNG, JPEG and WebP files: what requests bring, what image generators send, textures inside of meshes.
#![no_main]

use libfuzzer_sys::fuzz_target;
use imaging::codec::{decode_oriented_image, decode_image};
use remote::image;

/// Most pixels of an image in a request, as config/default.toml has it.
const MAX_PIXELS: u64 = 64_000_000;

fuzz_target!(|file: &[u8]| {
    let received = image::received(file);
    // Whatever is taken from a vendor would be taken from a user.
    assert!(received.is_err() || decode_image(file, MAX_PIXELS).is_ok());
    let _ = decode_oriented_image(file, MAX_PIXELS);
});
