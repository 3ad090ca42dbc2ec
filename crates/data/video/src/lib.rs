//! Images as a video file: H.264 (4:2:0) in MP4, playable in browsers and readable by PyAV.
//!
//! The encoder runs on one thread with a constant quantizer, so that equal images give equal bytes on one machine.
//! The metadata stands before the samples, so that a player can start before the file is there.
//!
//! [`VideoEncoder::finish`] gives the file of one video. [`VideoEncoder::into_samples`] gives the encoded frames, and
//! [`Mp4File`] puts those of many videos behind each other in one file without encoding them again.

mod mp4_file;
mod parameter_sets;

use imaging::Image;
use muxide::api::{MuxerBuilder, MuxerError, VideoCodec};
use openh264::OpenH264API;
use openh264::encoder::{
    BitRate, Encoder, EncoderConfig, FrameRate, FrameType, IntraFramePeriod, QpRange, RateControlMode,
    UsageType,
};
use openh264::formats::{RgbaSliceU8, YUVBuffer};

pub use mp4_file::{Mp4Error, Mp4File, TICKS_PER_FRAME};

/// Frames between two that can be decoded alone: few, so that a reader can start anywhere.
pub const KEY_FRAME_PERIOD: u32 = 10;
/// Quantizer, 0..=51: about 40 dB on renders.
const QUANTIZER: u8 = 24;

/// One encoded frame: H.264 with start codes.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Sample {
    pub bytes: Vec<u8>,
    /// Whether the frame can be decoded alone.
    pub is_key: bool,
}

/// A video to which images are added one by one.
pub struct VideoEncoder {
    encoder: Encoder,
    width_px: u32,
    height_px: u32,
    frames_per_s: f64,
    samples: Vec<Sample>,
}

/// Reason why a video cannot be written.
#[derive(Debug, thiserror::Error)]
pub enum VideoError {
    #[error("encoding a video of {width_px} x {height_px} pixels: both must be even and from 16 to 4096")]
    Size { width_px: u32, height_px: u32 },
    #[error("encoding a video of {width_px} x {height_px} pixels: frame {frame} has another size")]
    FrameSize { width_px: u32, height_px: u32, frame: usize },
    #[error("encoding frame {frame} of a video: {source}")]
    Encoder { frame: usize, source: openh264::Error },
    #[error("writing a video: it has no frames; add one first")]
    Empty,
    #[error("writing a video: {0}")]
    File(#[from] MuxerError),
}

impl VideoEncoder {
    /// A video without frames.
    ///
    /// # Errors
    ///
    /// [`VideoError::Size`] for a size that 4:2:0 does not have, and where the encoder does not start.
    pub fn new(width_px: u32, height_px: u32, frames_per_s: f64) -> Result<Self, VideoError> {
        let fits = |side: u32| (16..=4096).contains(&side) && side.is_multiple_of(2);
        if !(fits(width_px) && fits(height_px)) {
            return Err(VideoError::Size { width_px, height_px });
        }
        let config = EncoderConfig::new()
            .usage_type(UsageType::CameraVideoRealTime)
            .rate_control_mode(RateControlMode::Off)
            .bitrate(BitRate::from_bps(8_000_000))
            .qp(QpRange::new(QUANTIZER, QUANTIZER))
            .max_frame_rate(FrameRate::from_hz(frames_per_s as f32))
            .intra_frame_period(IntraFramePeriod::from_num_frames(KEY_FRAME_PERIOD))
            .scene_change_detect(false)
            .skip_frames(false)
            .num_threads(1);
        let encoder = Encoder::with_api_config(OpenH264API::from_source(), config)
            .map_err(|source| VideoError::Encoder { frame: 0, source })?;
        Ok(Self { encoder, width_px, height_px, frames_per_s, samples: Vec::new() })
    }

    /// Adds a frame; transparency is ignored.
    ///
    /// # Errors
    ///
    /// [`VideoError::FrameSize`] for an image of another size, and where the encoder fails.
    pub fn add(&mut self, image: &Image) -> Result<(), VideoError> {
        let frame = self.samples.len();
        let (width_px, height_px) = (self.width_px, self.height_px);
        if (image.width_px(), image.height_px()) != (width_px, height_px) {
            return Err(VideoError::FrameSize { width_px, height_px, frame });
        }
        let pixels = RgbaSliceU8::new(image.as_rgba(), (width_px as usize, height_px as usize));
        let encoded = self
            .encoder
            .encode(&YUVBuffer::from_rgba8_source(pixels))
            .map_err(|source| VideoError::Encoder { frame, source })?;
        let is_key = matches!(encoded.frame_type(), FrameType::IDR | FrameType::I);
        self.samples.push(Sample { bytes: encoded.to_vec(), is_key });
        Ok(())
    }

    /// The encoded frames, in order. The first is a key frame, and so is at least one in [`KEY_FRAME_PERIOD`].
    pub fn into_samples(self) -> Vec<Sample> {
        self.samples
    }

    /// The bytes of the MP4 file.
    ///
    /// # Errors
    ///
    /// [`VideoError::Empty`] for a video without frames, and where the file cannot be composed.
    pub fn finish(self) -> Result<Vec<u8>, VideoError> {
        if self.samples.is_empty() {
            return Err(VideoError::Empty);
        }
        let mut bytes = Vec::new();
        let mut muxer = MuxerBuilder::new(&mut bytes)
            .video(VideoCodec::H264, self.width_px, self.height_px, self.frames_per_s)
            .with_fast_start(true)
            .build()?;
        for (frame, sample) in self.samples.iter().enumerate() {
            muxer.write_video(frame as f64 / self.frames_per_s, &sample.bytes, sample.is_key)?;
        }
        muxer.finish()?;
        Ok(bytes)
    }
}

#[cfg(test)]
mod tests {
    use std::io::Cursor;

    use openh264::decoder::Decoder;
    use openh264::formats::YUVSource;

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
}
