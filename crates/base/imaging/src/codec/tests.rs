//! One rule for all formats: complete still images are decoded, all else is refused.

use super::*;

#[test]
fn png_round_trip_preserves_opaque_and_transparent_images() {
    for alpha in [255, 128] {
        let mut image = Image::filled(7, 5, [10, 20, 30, alpha]);
        image.set_pixel(3, 2, [255, 0, 7, 255]);
        let bytes = encode_png(&image);
        assert_eq!(bytes, encode_png(&image));
        assert_eq!(decode_png(&bytes).expect("our own file"), image);
        assert!(matches!(decode_image(&bytes, 34), Err(CodecError::TooLarge { .. })));
    }
}

/// A JPEG of `image` whose EXIF block has that orientation.
fn jpeg(image: &Image, orientation: u8) -> Vec<u8> {
    let rgb: Vec<u8> = image.as_rgba().chunks_exact(4).flat_map(|p| [p[0], p[1], p[2]]).collect();
    let mut bytes = Vec::new();
    image::codecs::jpeg::JpegEncoder::new_with_quality(&mut bytes, 100)
        .encode(&rgb, image.width_px(), image.height_px(), ExtendedColorType::Rgb8)
        .expect("encodes");
    // Exif 2.32, 4.5: one big-endian directory with the tag 0x0112 of type SHORT.
    let mut exif = b"Exif\0\0MM\0\x2a\0\0\0\x08\0\x01\x01\x12\0\x03\0\0\0\x01\0".to_vec();
    exif.extend([orientation, 0, 0, 0, 0, 0, 0]);
    let mut marked = bytes[..2].to_vec();
    marked.extend([0xff, 0xe1, 0, exif.len() as u8 + 2]);
    marked.extend(exif);
    marked.extend(&bytes[2..]);
    marked
}

#[test]
fn decode_oriented_image_applies_the_exif_orientation() {
    let mut image = Image::filled(32, 16, [250, 250, 250, 255]);
    (0..16).for_each(|y| (0..8).for_each(|x| image.set_pixel(x, y, [5, 5, 5, 255])));
    let upright = decode_oriented_image(&jpeg(&image, 1), 1_000).expect("intact");
    assert_eq!((upright.width_px(), upright.height_px()), (32, 16));
    assert!(upright.pixel(2, 8)[0] < 60 && upright.pixel(28, 8)[0] > 200);
    // 6: the first row is the right side, the first column the top.
    let turned = decode_oriented_image(&jpeg(&image, 6), 1_000).expect("intact");
    assert_eq!(decode_image(&jpeg(&image, 6), 1_000).expect("intact").width_px(), 32);
    assert_eq!((turned.width_px(), turned.height_px()), (16, 32));
    assert!(turned.pixel(8, 2)[0] < 60 && turned.pixel(8, 28)[0] > 200);
}

#[test]
fn decoders_reject_foreign_and_oversized_files() {
    let bytes = encode_png(&Image::filled(9, 9, [1, 2, 3, 255]));
    assert!(matches!(decode_png(b"GIF89a"), Err(CodecError::UnknownFormat)));
    // A header alone decides: no pixel of 20,000 x 20,000 is ever asked for.
    let mut bomb = bytes;
    bomb[16..24].copy_from_slice(&[0, 0, 0x4e, 0x20, 0, 0, 0x4e, 0x20]);
    let checksum = crc32(&bomb[12..29]);
    bomb[29..33].copy_from_slice(&checksum.to_be_bytes());
    let refused = decode_oriented_image(&bomb, 100_000_000);
    assert!(matches!(refused, Err(CodecError::TooLarge { width_px: 20_000, .. })), "{refused:?}");
}

/// Checksum of a PNG chunk (PNG 1.2, appendix D).
fn crc32(bytes: &[u8]) -> u32 {
    !bytes.iter().fold(!0, |sum: u32, byte| {
        (0..8).fold(sum ^ u32::from(*byte), |sum, _| (sum >> 1) ^ (0xedb8_8320 & (sum & 1).wrapping_neg()))
    })
}

/// A progressive JPEG of 16 x 16 pixels, as libjpeg writes it.
const PROGRESSIVE_JPEG: &str = "\
    ffd8ffe000104a46494600010100000100010000ffdb0043001b12141714111b1716171e1c1b2028422b28252528513a3d3042605565645f\
    555d5b6a7899816a7190735b5d85b586909ea3abadab6780bcc9baa6c799a8aba4ffdb0043011c1e1e2823284e2b2b4ea46e5d6ea4a4a4a4\
    a4a4a4a4a4a4a4a4a4a4a4a4a4a4a4a4a4a4a4a4a4a4a4a4a4a4a4a4a4a4a4a4a4a4a4a4a4a4a4a4a4a4a4a4a4a4ffc20011080010001003\
    012200021101031101ffc4001500010100000000000000000000000000000304ffc40014010100000000000000000000000000000000ffda\
    000c0301000210031000000195958fffc400161000030000000000000000000000000000000102ffda00080101000105025229148a4fffc4\
    001511010100000000000000000000000000000300ffda0008010301013f0124bfffc4001611000300000000000000000000000000000001\
    02ffda0008010201013f01767fffc40014100100000000000000000000000000000020ffda0008010100063f021fffc40014100100000000\
    000000000000000000000020ffda0008010100013f21001fffda000c03010002000300000010bbffc4001411010000000000000000000000\
    0000000000ffda0008010301013f101fffc40014110100000000000000000000000000000000ffda0008010201013f105fffc40015100101\
    00000000000000000000000000000061ffda0008010100013f109a69a6ffd9";
/// Lossless and lossy WebP files of the same image, as libwebp writes them.
const LOSSLESS_WEBP: &str = "\
    524946462e000000574542505650384c220000002f0fc00300b93244f43f7611d1ff0091b64d25dcbfe1c1d38118c09800aa0ed47f00";
const LOSSY_WEBP: &str = "\
    524946464a00000057454250565038203e0000001002009d012a1000100002c04c25b002747f00181c005a56d800fef6e291ac798db118452759cb\
    5ff7264f59dc7a1d60401be2ffa62bf3fed9a5e5ae8000";

fn bytes_of(hex: &str) -> Vec<u8> {
    (0..hex.len() / 2)
        .map(|k| u8::from_str_radix(&hex[2 * k..2 * k + 2], 16).expect("a digit pair"))
        .collect()
}

/// A gradient of 16 x 16 pixels.
fn gradient() -> Image {
    let mut image = Image::filled(16, 16, [0, 0, 128, 255]);
    (0..256).for_each(|k| image.set_pixel(k % 16, k / 16, [k as u8 % 16 * 16, k as u8 / 16 * 16, 128, 255]));
    image
}

/// One file of each kind that is accepted, with the name of its kind.
fn still_files() -> Vec<(&'static str, Vec<u8>)> {
    vec![
        ("PNG", encode_png(&gradient())),
        ("baseline JPEG", jpeg(&gradient(), 1)),
        ("progressive JPEG", bytes_of(PROGRESSIVE_JPEG)),
        ("lossless WebP", bytes_of(LOSSLESS_WEBP)),
        ("lossy WebP", bytes_of(LOSSY_WEBP)),
    ]
}

#[test]
fn truncated_files_of_every_format_are_refused_at_every_length() {
    for (kind, file) in still_files() {
        let image = decode_image(&file, 1_000).unwrap_or_else(|error| panic!("{kind}: {error:?}"));
        assert_eq!((image.width_px(), image.height_px()), (16, 16), "{kind}");
        assert!(image.pixel(15, 0)[0] > 160 && image.pixel(0, 0)[0] < 80, "{kind}");
        // The pad byte at the end of a WebP file holds nothing.
        let last = file.len() - usize::from(kind.ends_with("WebP"));
        for length in 0..last {
            let cut = &file[..length];
            assert!(decode_image(cut, 1_000).is_err(), "{kind}: {length} of {} bytes", file.len());
            assert!(verify_image(cut, 1 << 20).is_err(), "{kind}: {length} of {} bytes", file.len());
        }
    }
}

#[test]
fn a_jpeg_whose_coded_data_stop_early_is_refused_despite_its_end_marker() {
    let mut noise = Image::filled(64, 64, [0, 0, 0, 255]);
    noise.as_rgba_mut().iter_mut().enumerate().for_each(|(k, byte)| *byte = (k * k % 251) as u8);
    let whole = jpeg(&noise, 1);
    assert!(decode_image(&whole, 10_000).is_ok());
    for share in [0.4, 0.6, 0.8, 0.95, 0.999] {
        let mut cut = whole[..(whole.len() as f64 * share) as usize].to_vec();
        cut.extend([0xff, 0xd9]);
        assert!(
            matches!(decode_image(&cut, 10_000), Err(CodecError::Truncated | CodecError::Broken(_))),
            "{share}"
        );
    }
}

#[test]
fn a_progressive_jpeg_whose_last_scan_stops_early_is_refused() {
    // 0xffda 0008 ...: the last scan holds 0x9a69a6; without it the file is a coarser image, with a part it is damaged.
    let whole = bytes_of(PROGRESSIVE_JPEG);
    let cut = [&whole[..whole.len() - 4], &[0xff, 0xd9]].concat();
    assert!(decode_image(&cut, 1_000).is_err());
}

/// A chunk of a PNG file.
fn chunk(kind: &[u8; 4], data: &[u8]) -> Vec<u8> {
    let checked = [kind.as_slice(), data].concat();
    [(data.len() as u32).to_be_bytes().as_slice(), &checked, &crc32(&checked).to_be_bytes()].concat()
}

/// The file with more bytes after its first `at`.
fn with_inserted(file: &[u8], at: usize, more: &[u8]) -> Vec<u8> {
    [&file[..at], more, &file[at..]].concat()
}

#[test]
fn animations_of_every_format_are_refused() {
    const HEADER_END: usize = 33;
    let frames = [2_u32.to_be_bytes(), 0_u32.to_be_bytes()].concat();
    let animated_png = with_inserted(&encode_png(&gradient()), HEADER_END, &chunk(b"acTL", &frames));
    let header = |kind: &[u8; 4], flags: u8| {
        [b"RIFF\x16\0\0\0WEBP".as_slice(), kind, &[10, 0, 0, 0, flags, 0, 0, 0, 15, 0, 0, 15, 0, 0]].concat()
    };
    let frame = with_inserted(&header(b"VP8X", 0), 30, b"ANMF\0\0\0\0");
    for (name, file) in [
        ("acTL", animated_png),
        ("flag", header(b"VP8X", 0b10)),
        ("flag and alpha", header(b"VP8X", 0b1_0010)),
        ("frame", [&frame[..4], &[30, 0, 0, 0], &frame[8..]].concat()),
    ] {
        for refused in [read_header(&file).map(drop), decode_image(&file, 1_000).map(drop)] {
            assert!(matches!(refused, Err(CodecError::Animated)), "{name}: {refused:?}");
        }
    }
    for still in [header(b"VP8X", 0b1_0000), header(b"VP8 ", 0b10)] {
        assert!(!matches!(read_header(&still), Err(CodecError::Animated)));
    }
}

#[test]
fn descriptions_and_bytes_after_the_end_change_no_pixel() {
    let png = encode_png(&gradient());
    let text = chunk(b"tEXt", b"Comment\0chunks like this are dropped");
    let broken_profile = chunk(b"iCCP", b"name\0\0no deflate stream");
    let described = with_inserted(&png, 33, &[text, broken_profile, b"".to_vec()].concat());
    assert_eq!(decode_image(&described, 1_000).expect("intact"), gradient());
    assert_eq!(decode_image(&[png.as_slice(), b"more"].concat(), 1_000).expect("intact"), gradient());

    let jpeg = jpeg(&gradient(), 1);
    let expected = decode_image(&jpeg, 1_000).expect("intact");
    let comment = [b"\xff\xfe\0\x07\xff\xd9\xff\xda!".as_slice(), b"\xff\xe2\0\x06ICC_"].concat();
    for file in [with_inserted(&jpeg, 2, &comment), [jpeg.as_slice(), b"\xff\xd8 a second one"].concat()] {
        assert_eq!(decode_image(&file, 1_000).expect("intact"), expected);
    }
}

#[test]
fn thumbnails_are_smaller_images_over_white_and_never_larger_ones() {
    let mut image = Image::filled(64, 32, [200, 40, 40, 255]);
    (0..32).for_each(|y| (32..64).for_each(|x| image.set_pixel(x, y, [0, 0, 0, 0])));
    let small = decode_image(&encode_thumbnail(&image, 16), 10_000).expect("our own file");
    assert_eq!((small.width_px(), small.height_px()), (16, 8));
    let (left, right) = (small.pixel(3, 4), small.pixel(12, 4));
    assert!(left[0] > 180 && left[1] < 70, "{left:?}");
    assert!(right.iter().all(|channel| *channel > 240), "{right:?}");
    let same = decode_image(&encode_thumbnail(&image, 1_000), 10_000).expect("our own file");
    assert_eq!((same.width_px(), same.height_px()), (64, 32));
    let none =
        decode_image(&encode_thumbnail(&Image::filled(0, 5, [0; 4]), 16), 10_000).expect("our own file");
    assert_eq!((none.width_px(), none.height_px()), (1, 1));
}
