//! Videos decode to what was encoded, and clips share a file.

use std::io::Cursor;

use openh264::decoder::Decoder;
use openh264::formats::YUVSource;

use imaging::Image;

use super::*;

/// A square that moves to the right, on gray.
fn frame(number: u32) -> Image {
    let mut image = Image::filled(64, 48, [120, 120, 120, 255]);
    for y in 16..32 {
        for x in 0..16 {
            image.set_pixel(x + 2 * number, y, [230, 40, 40, 255]);
        }
    }
    image
}

fn video(frames: u32) -> VideoEncoder {
    let mut video = VideoEncoder::new(64, 48, 25.0).expect("a size");
    (0..frames).for_each(|number| video.add(&frame(number)).expect("encoded"));
    video
}

#[test]
fn frames_decode_to_what_was_added() {
    let video = video(20);
    let keys: Vec<usize> = (0..20).filter(|frame| video.samples[*frame].is_key).collect();
    assert_eq!(keys, [0, 10], "key frames");
    let mut decoder = Decoder::new().expect("a decoder");
    for (number, sample) in (0..).zip(&video.samples) {
        let decoded = decoder.decode(&sample.bytes).expect("decoded").expect("a frame");
        let (width, height) = decoded.dimensions();
        let mut rgb = vec![0; 3 * width * height];
        decoded.write_rgb8(&mut rgb);
        let image = frame(number);
        let errors = image.as_rgba().chunks(4).zip(rgb.chunks(3));
        let squares: f64 = errors
            .map(|(a, b)| (0..3).map(|c| (f64::from(a[c]) - f64::from(b[c])).powi(2)).sum::<f64>())
            .sum();
        let rms = (squares / rgb.len() as f64).sqrt();
        assert!(rms < 12.0, "frame {number}: {rms}");
    }
}

#[test]
fn equal_images_give_equal_files() {
    let bytes = video(12).finish().expect("a file");
    assert_eq!(bytes, video(12).finish().expect("a file"));
    assert_eq!(&bytes[4..8], b"ftyp");
    let at = |name: &[u8]| bytes.windows(4).position(|four| four == name).expect("a box");
    assert!(at(b"moov") < at(b"mdat"), "the metadata come first");
}

#[test]
fn clips_share_a_file() {
    let write = || {
        let mut file = Mp4File::new(Cursor::new(Vec::new()), 64, 48, 25).expect("a file");
        for frames in [12, 12, 7] {
            file.append(&video(frames).into_samples()).expect("appended");
        }
        assert_eq!(file.frames(), 31);
        file.finish().expect("finished").into_inner()
    };
    let bytes = write();
    assert_eq!(bytes, write(), "equal bytes");
    let body = |name: &[u8]| {
        let at = bytes.windows(4).rposition(|four| four == name).expect("a box");
        &bytes[at + 4..]
    };
    let number = |bytes: &[u8], at: usize| {
        u32::from_be_bytes(bytes[4 * at..4 * at + 4].try_into().expect("four bytes"))
    };
    // Every clip begins with a key frame: frames 1, 13 and 25, counted from one.
    let keys = body(b"stss");
    let keys: Vec<u32> = (2..2 + number(keys, 1) as usize).map(|at| number(keys, at)).collect();
    assert_eq!(keys, [1, 11, 13, 23, 25]);
    // Runs of clips: two with 12 frames, then one with 7.
    assert_eq!((1..8).map(|at| number(body(b"stsc"), at)).collect::<Vec<_>>(), [2, 1, 12, 1, 3, 7, 1]);
    // The offset of the third clip is that of its first frame.
    let offsets = body(b"co64");
    let third = number(offsets, 7) as usize;
    let sizes = body(b"stsz");
    let size = number(sizes, 3 + 24) as usize;
    let expected = parameter_sets::length_prefixed(&video(7).into_samples()[0].bytes);
    assert_eq!(bytes[third..third + size], expected);
    // The size of the media reaches to the tables.
    let media = bytes.windows(4).position(|four| four == b"mdat").expect("a box");
    let media_bytes = u64::from_be_bytes(bytes[media + 4..media + 12].try_into().expect("eight bytes"));
    assert_eq!(&bytes[media - 4 + media_bytes as usize + 4..][..4], b"moov");
}

#[test]
fn clips_that_do_not_fit_a_file_are_refused() {
    let mut file = Mp4File::new(Cursor::new(Vec::new()), 64, 48, 25).expect("a file");
    assert!(matches!(file.append(&[]), Err(Mp4Error::EmptyClip)));
    let samples = video(3).into_samples();
    assert!(matches!(file.append(&samples[1..]), Err(Mp4Error::NoKeyFrame)));
    file.append(&samples).expect("appended");
    let mut larger = VideoEncoder::new(96, 96, 25.0).expect("a size");
    larger.add(&Image::filled(96, 96, [1, 2, 3, 255])).expect("encoded");
    let larger = larger.into_samples();
    assert!(matches!(file.append(&larger), Err(Mp4Error::OtherSettings { frame: 0 })));
    assert_eq!(file.frames(), 3, "what is refused leaves no trace");
    assert!(matches!(Mp4File::new(Cursor::new(Vec::new()), 64, 48, 0), Err(Mp4Error::Size)));
    let empty = Mp4File::new(Cursor::new(Vec::new()), 64, 48, 25).expect("a file");
    assert!(matches!(empty.finish(), Err(Mp4Error::EmptyClip)));
}

#[test]
fn sizes_that_do_not_fit_are_refused() {
    assert!(matches!(VideoEncoder::new(63, 48, 25.0), Err(VideoError::Size { .. })));
    let mut video = VideoEncoder::new(32, 32, 25.0).expect("a size");
    assert!(matches!(video.add(&frame(0)), Err(VideoError::FrameSize { .. })));
    assert!(matches!(video.finish(), Err(VideoError::Empty)));
}
