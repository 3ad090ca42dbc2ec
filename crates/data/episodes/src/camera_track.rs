//! Content of an episode unit for one camera: encoded frames, and per frame K and the pose.

use imaging::Image;
use video::{Sample, VideoEncoder, VideoError};

use crate::description::{CameraDescription, InstanceIdWidth};
use crate::format::Encodings;
use crate::frame::CameraFrame;
use crate::pixels::{gray_png, millimeters, rgb_of, rgb_png, zlib};
use crate::statistics::histogram::ImageHistogram;
use crate::strip::StripFrames;

/// The frames of one camera in one episode. A list is empty where its encoding was not asked for or not recorded.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CameraTrack {
    /// K of each frame, row by row, pixels: 9 numbers a frame.
    pub intrinsics: Vec<f32>,
    /// The pose of the camera with OpenCV axes, row by row, meters: 16 numbers a frame.
    pub world_from_camera: Vec<f32>,
    pub histogram: ImageHistogram,
    /// H.264, the first frame a key frame.
    pub video: Vec<Sample>,
    pub rgb_png: Vec<Vec<u8>>,
    /// Millimeters.
    pub depth_png: Vec<Vec<u8>>,
    /// Ids of 16 bits.
    pub ids_png: Vec<Vec<u8>>,
    /// Bytes: red, green, blue.
    pub rgb_zlib: Vec<Vec<u8>>,
    /// f32, meters.
    pub depth_zlib: Vec<Vec<u8>>,
    /// u16 or u32, as described.
    pub ids_zlib: Vec<Vec<u8>>,
    /// A few of the frames side by side, as PNG.
    pub strip_png: Vec<u8>,
}

/// Encodes the frames of one camera one by one.
pub(crate) struct CameraEncoder {
    camera: CameraDescription,
    encodings: Encodings,
    video: Option<VideoEncoder>,
    strip: StripFrames,
    track: CameraTrack,
}

impl CameraEncoder {
    pub fn new(camera: &CameraDescription, encodings: Encodings, fps: u32) -> Result<Self, VideoError> {
        let begin = || VideoEncoder::new(camera.width_px, camera.height_px, f64::from(fps));
        let video = encodings.video.then(begin).transpose()?;
        let (strip, track) = (StripFrames::default(), CameraTrack::default());
        Ok(Self { camera: camera.clone(), encodings, video, strip, track })
    }

    /// Adds a frame that was checked.
    pub fn add(&mut self, frame: &CameraFrame) -> Result<(), VideoError> {
        if let Some(video) = &mut self.video {
            video.add(frame.image)?;
        }
        self.strip.add(frame.image);
        let track = &mut self.track;
        track.intrinsics.extend(frame.intrinsics.map(|number| number as f32));
        track.world_from_camera.extend(frame.world_from_camera.map(|number| number as f32));
        track.histogram.add(frame.image);
        self.add_image(frame.image);
        let (width_px, height_px) = (self.camera.width_px, self.camera.height_px);
        let track = &mut self.track;
        if let Some(depth_m) = frame.depth_m {
            if self.encodings.depth_png {
                track.depth_png.push(gray_png(&millimeters(depth_m), width_px, height_px));
            }
            if self.encodings.depth_zlib {
                track
                    .depth_zlib
                    .push(zlib(&depth_m.iter().flat_map(|d| d.to_le_bytes()).collect::<Vec<u8>>()));
            }
        }
        if let (Some(ids), Some(width)) = (frame.instance_ids, self.camera.instance_ids) {
            let narrow = || ids.iter().map(|id| *id as u16);
            if self.encodings.ids_png && width == InstanceIdWidth::U16 {
                track.ids_png.push(gray_png(&narrow().collect::<Vec<_>>(), width_px, height_px));
            }
            if self.encodings.ids_zlib {
                let bytes: Vec<u8> = match width {
                    InstanceIdWidth::U16 => narrow().flat_map(u16::to_le_bytes).collect(),
                    InstanceIdWidth::U32 => ids.iter().flat_map(|id| id.to_le_bytes()).collect(),
                };
                track.ids_zlib.push(zlib(&bytes));
            }
        }
        Ok(())
    }

    fn add_image(&mut self, image: &Image) {
        if !(self.encodings.rgb_png || self.encodings.rgb_zlib) {
            return;
        }
        let rgb = rgb_of(image);
        if self.encodings.rgb_png {
            self.track.rgb_png.push(rgb_png(&rgb, image.width_px(), image.height_px()));
        }
        if self.encodings.rgb_zlib {
            self.track.rgb_zlib.push(zlib(&rgb));
        }
    }

    pub fn finish(self) -> CameraTrack {
        let video = self.video.map(VideoEncoder::into_samples).unwrap_or_default();
        CameraTrack { video, strip_png: self.strip.finish().unwrap_or_default(), ..self.track }
    }
}
