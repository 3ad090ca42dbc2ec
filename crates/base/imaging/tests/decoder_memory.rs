//! Peak memory of the decoder on files that expand, measured by the kernel. A process of its own: other tests would
//! count, too.

use imaging::Image;
use imaging::codec::{decode_image, encode_png, verify_image};

const HEADER_END: usize = 33;

/// Peak resident memory of this process since its last reset, bytes.
fn peak_bytes() -> u64 {
    let status = std::fs::read_to_string("/proc/self/status").expect("Linux");
    let line = status.lines().find(|line| line.starts_with("VmHWM:")).expect("a peak");
    line.split_whitespace().nth(1).and_then(|kib| kib.parse::<u64>().ok()).expect("kibibytes") * 1024
}

/// A zlib stream (RFC 1950, 1951) of `zeros` zero bytes, 158 times smaller: one literal, then fixed codes for the
/// longest match at distance 1.
fn zlib_of_zeros(zeros: usize) -> Vec<u8> {
    let mut bits: Vec<bool> = vec![true, true, false];
    let mut push = |code: u32, length: u32| bits.extend((0..length).rev().map(|k| code >> k & 1 == 1));
    push(0b0011_0000, 8);
    for _ in 0..zeros / 258 {
        push(0b1100_0101, 8);
        push(0, 5);
    }
    push(0, 7);
    let bytes = bits.chunks(8).map(|byte| byte.iter().enumerate().map(|(k, bit)| u8::from(*bit) << k).sum());
    [0x78, 0x01].into_iter().chain(bytes).chain([0; 4]).collect()
}

fn chunk(kind: &[u8; 4], data: &[u8]) -> Vec<u8> {
    let checked = [kind.as_slice(), data].concat();
    let crc = !checked.iter().fold(!0, |sum: u32, byte| {
        (0..8).fold(sum ^ u32::from(*byte), |sum, _| (sum >> 1) ^ (0xedb8_8320 & (sum & 1).wrapping_neg()))
    });
    [(data.len() as u32).to_be_bytes().as_slice(), &checked, &crc.to_be_bytes()].concat()
}

#[test]
fn a_png_with_a_huge_profile_and_huge_texts_is_decoded_in_a_few_megabytes() {
    let image = Image::filled(200, 160, [90, 120, 30, 255]);
    let zeros = zlib_of_zeros(320 << 20);
    let profile = chunk(b"iCCP", &[b"profile\0\0".as_slice(), &zeros].concat());
    let text = chunk(b"zTXt", &[b"Raw profile type iptc\0\0".as_slice(), &zeros].concat());
    let plain = encode_png(&image);
    let file = [&plain[..HEADER_END], &profile, &text, &plain[HEADER_END..]].concat();
    assert!(file.len() < 5 << 20, "{} bytes", file.len());
    drop((zeros, profile, text));

    // Writing 5 resets the peak (proc(5)); where that is not allowed, the peak of the generator remains.
    let _ = std::fs::write("/proc/self/clear_refs", "5");
    let before = peak_bytes();
    verify_image(&file, 768 << 20).expect("intact");
    assert_eq!(decode_image(&file, 64_000_000).expect("intact"), image);
    let grown = peak_bytes() - before;
    assert!(grown < 32 << 20, "the peak grew by {grown} bytes");
}
