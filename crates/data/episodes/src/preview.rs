//! A short video of an episode: the images of all cameras side by side, small, for people who choose a dataset.

use image::RgbImage;
use image::imageops::replace;
use imaging::Image;
use video::{VideoEncoder, VideoError};

use crate::description::DatasetDescription;
use crate::strip::{CHUNK, small_size_px, thumbnail_of};

/// Path of an episode's video in the folder of a format.
pub(crate) fn preview_path(episode_index: u64) -> String {
    format!("strips/chunk-{:03}/episode_{episode_index:06}.mp4", episode_index / CHUNK)
}

/// The video of one episode while it is recorded.
pub(crate) struct PreviewEncoder {
    video: VideoEncoder,
    width_px: u32,
    height_px: u32,
}

impl PreviewEncoder {
    /// A video without frames; `None` for a dataset without cameras.
    pub fn new(description: &DatasetDescription) -> Result<Option<Self>, VideoError> {
        let sizes =
            description.cameras().iter().map(|camera| small_size_px(camera.width_px, camera.height_px));
        let (width_px, height_px) = sizes.fold((0, 0), |(width, height), (w, h)| (width + w, height.max(h)));
        if width_px == 0 {
            return Ok(None);
        }
        // H.264 has even sides.
        let (width_px, height_px) = (width_px.next_multiple_of(2), height_px.next_multiple_of(2));
        let video = VideoEncoder::new(width_px, height_px, f64::from(description.fps()))?;
        Ok(Some(Self { video, width_px, height_px }))
    }

    /// Adds the images of the cameras at the next frame, in the order of the description.
    pub fn add<'a>(&mut self, images: impl IntoIterator<Item = &'a Image>) -> Result<(), VideoError> {
        let mut joined = RgbImage::new(self.width_px, self.height_px);
        let mut left_px = 0;
        for image in images {
            let small = thumbnail_of(image);
            replace(&mut joined, &small, i64::from(left_px), 0);
            left_px += small.width();
        }
        let rgba = joined.pixels().flat_map(|pixel| [pixel[0], pixel[1], pixel[2], u8::MAX]).collect();
        let joined = Image::from_rgba(self.width_px, self.height_px, rgba);
        self.video.add(&joined.expect("as many bytes as pixels need"))
    }

    /// The file.
    pub fn finish(self) -> Result<Vec<u8>, VideoError> {
        self.video.finish()
    }
}
