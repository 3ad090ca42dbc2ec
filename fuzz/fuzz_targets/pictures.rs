//! PNG, JPEG and WebP files: what requests bring, what painters send, textures inside of meshes.
#![no_main]

use libfuzzer_sys::fuzz_target;
use imaging::codec::{decode_photograph, decode_picture};
use remote::picture;

/// Most pixels of a picture in a request, as config/default.toml has it.
const MAX_PIXELS: u64 = 64_000_000;

fuzz_target!(|file: &[u8]| {
    let received = picture::received(file);
    // Whatever is taken from a vendor would be taken from a user.
    assert!(received.is_err() || decode_picture(file, MAX_PIXELS).is_ok());
    let _ = decode_photograph(file, MAX_PIXELS);
});
