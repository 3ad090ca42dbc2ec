//! Images as a video file: H.264 (4:2:0) in MP4, playable in browsers and readable by PyAV.
//!
//! The encoder runs on one thread with a constant quantizer, so that equal images give equal bytes on one machine.
//! The metadata stands before the samples, so that a player can start before the file is there.
//!
//! [`VideoEncoder::finish`] gives the file of one video. [`VideoEncoder::into_samples`] gives the encoded frames, and
//! [`Mp4File`] puts those of many videos behind each other in one file without encoding them again.
//!
//! Without the feature `h264` no video can be encoded; samples that another program encoded still become files.

#[cfg(feature = "h264")]
mod encoder;
mod mp4_file;
#[cfg(not(feature = "h264"))]
mod no_encoder;
mod parameter_sets;
#[cfg(all(test, feature = "h264"))]
mod tests;

use std::error::Error;

#[cfg(feature = "h264")]
pub use encoder::VideoEncoder;
pub use mp4_file::{Mp4Error, Mp4File, TICKS_PER_FRAME};
#[cfg(not(feature = "h264"))]
pub use no_encoder::VideoEncoder;

/// Whether this program can encode videos.
pub const CAN_ENCODE: bool = cfg!(feature = "h264");

/// Frames between two that can be decoded alone: few, so that a reader can start anywhere.
pub const KEY_FRAME_PERIOD: u32 = 10;

/// One encoded frame: H.264 with start codes.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Sample {
    pub bytes: Vec<u8>,
    /// Whether the frame can be decoded alone.
    pub is_key: bool,
}

/// Reason why a video cannot be written.
#[derive(Debug, thiserror::Error)]
pub enum VideoError {
    #[error("encoding a video of {width_px} x {height_px} pixels: both must be even and from 16 to 4096")]
    Size { width_px: u32, height_px: u32 },
    #[error("encoding a video of {width_px} x {height_px} pixels: frame {frame} has another size")]
    FrameSize { width_px: u32, height_px: u32, frame: usize },
    #[error("encoding frame {frame} of a video: {source}")]
    Encoder { frame: usize, source: Box<dyn Error + Send + Sync> },
    #[error("encoding a video: this program was built without H.264 video; build with `--features video`")]
    NotBuilt,
    #[error("writing a video: it has no frames; add one first")]
    Empty,
    #[error("writing a video: {0}")]
    File(Box<dyn Error + Send + Sync>),
}
