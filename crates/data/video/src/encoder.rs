//! The encoder of H.264, and the file of one video.

use imaging::Image;
use muxide::api::{MuxerBuilder, MuxerError, VideoCodec};
use openh264::OpenH264API;
use openh264::encoder::{
    BitRate, Encoder, EncoderConfig, FrameRate, FrameType, IntraFramePeriod, QpRange, RateControlMode,
    UsageType,
};
use openh264::formats::{RgbaSliceU8, YUVBuffer};

use crate::{KEY_FRAME_PERIOD, Sample, VideoError};

/// Quantizer, 0..=51: about 40 dB on renders.
const QUANTIZER: u8 = 24;

/// A video to which images are added one by one.
pub struct VideoEncoder {
    encoder: Encoder,
    width_px: u32,
    height_px: u32,
    frames_per_s: f64,
    pub(crate) samples: Vec<Sample>,
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
            .map_err(|source| VideoError::Encoder { frame: 0, source: source.into() })?;
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
            .map_err(|source| VideoError::Encoder { frame, source: source.into() })?;
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
        self.file().map_err(|error| VideoError::File(error.into()))
    }

    fn file(&self) -> Result<Vec<u8>, MuxerError> {
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
