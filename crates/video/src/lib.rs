//! Images as a video file: H.264 (4:2:0) in MP4, playable in browsers and readable by PyAV.
//!
//! The encoder runs on one thread with a constant quantizer, so that equal images give equal bytes on one machine. The
//! metadata stands before the samples, so that a player can start before the file is there.

use imaging::Image;
use muxide::api::{MuxerBuilder, MuxerError, VideoCodec};
use openh264::OpenH264API;
use openh264::encoder::{
    BitRate, Encoder, EncoderConfig, FrameRate, FrameType, IntraFramePeriod, QpRange, RateControlMode,
    UsageType,
};
use openh264::formats::{RgbaSliceU8, YUVBuffer};

/// Frames between two that can be decoded alone: few, so that a reader can start anywhere.
const KEY_FRAME_PERIOD: u32 = 10;
/// Quantizer, 0..=51: about 40 dB on renders.
const QUANTIZER: u8 = 24;

/// A video to which images are added one by one.
pub struct VideoEncoder {
    encoder: Encoder,
    width_px: u32,
    height_px: u32,
    frames_per_s: f64,
    /// Encoded frames, and whether each can be decoded alone.
    samples: Vec<(Vec<u8>, bool)>,
}

/// Why a video cannot be written.
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
        self.samples.push((encoded.to_vec(), is_key));
        Ok(())
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
        for (frame, (sample, is_key)) in self.samples.iter().enumerate() {
            muxer.write_video(frame as f64 / self.frames_per_s, sample, *is_key)?;
        }
        muxer.finish()?;
        Ok(bytes)
    }
}

#[cfg(test)]
mod tests {
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
        assert!(video.samples[0].1 && !video.samples[1].1 && video.samples[10].1, "key frames");
        let mut decoder = Decoder::new().expect("a decoder");
        for (number, (sample, _)) in (0..).zip(&video.samples) {
            let decoded = decoder.decode(sample).expect("decoded").expect("a frame");
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
    fn sizes_that_do_not_fit_are_refused() {
        assert!(matches!(VideoEncoder::new(63, 48, 25.0), Err(VideoError::Size { .. })));
        let mut video = VideoEncoder::new(32, 32, 25.0).expect("a size");
        assert!(matches!(video.add(&frame(0)), Err(VideoError::FrameSize { .. })));
        assert!(matches!(video.finish(), Err(VideoError::Empty)));
    }
}
