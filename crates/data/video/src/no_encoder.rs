//! In place of the encoder in a program that was built without the feature `h264`: it starts none.

use imaging::Image;

use crate::{Sample, VideoError};

/// A video that cannot exist.
pub enum VideoEncoder {}

impl VideoEncoder {
    /// # Errors
    ///
    /// [`VideoError::NotBuilt`] in any case.
    pub fn new(_: u32, _: u32, _: f64) -> Result<Self, VideoError> {
        Err(VideoError::NotBuilt)
    }

    /// Adds a frame.
    ///
    /// # Errors
    ///
    /// None: there is no such video.
    pub fn add(&mut self, _: &Image) -> Result<(), VideoError> {
        match *self {}
    }

    /// The encoded frames.
    pub fn into_samples(self) -> Vec<Sample> {
        match self {}
    }

    /// The bytes of the MP4 file.
    ///
    /// # Errors
    ///
    /// None: there is no such video.
    pub fn finish(self) -> Result<Vec<u8>, VideoError> {
        match self {}
    }
}
