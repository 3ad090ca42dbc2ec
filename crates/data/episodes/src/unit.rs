//! One finished episode, independent of every other: what a job checkpoints, and what datasets are assembled from.
//!
//! A unit knows neither its place in a dataset nor the file it will be in. Its frames are encoded, so that an
//! assembler copies them. [`EpisodeUnit::to_bytes`] and [`EpisodeUnit::from_bytes`] are its form in a store.

use crate::EpisodeError;
use crate::camera_track::CameraTrack;
use crate::description::DatasetDescription;
use crate::episode::{EpisodeHeader, Outcome};
use crate::format::Encodings;
use crate::point_cloud::PointCloudTrack;
use crate::unit_bytes;
use crate::vector_layout::VectorLayout;

/// A finished episode. Only [`crate::EpisodeEncoder`] and [`EpisodeUnit::from_bytes`] make one.
#[derive(Clone, Debug, PartialEq)]
pub struct EpisodeUnit {
    /// Digest of the description it was recorded for.
    pub(crate) description: String,
    pub(crate) encodings: Encodings,
    pub(crate) header: EpisodeHeader,
    pub(crate) outcome: Outcome,
    pub(crate) frames: usize,
    /// Row by row: one row a frame.
    pub(crate) state: Vec<f32>,
    pub(crate) action: Vec<f32>,
    /// Empty where the description has none.
    pub(crate) servo_command: Vec<f32>,
    pub(crate) cameras: Vec<CameraTrack>,
    pub(crate) points: PointCloudTrack,
    /// Empty without video.
    pub(crate) preview_mp4: Vec<u8>,
}

impl EpisodeUnit {
    pub fn header(&self) -> &EpisodeHeader {
        &self.header
    }

    pub fn outcome(&self) -> &Outcome {
        &self.outcome
    }

    /// Number of frames; at least one.
    pub fn frames(&self) -> usize {
        self.frames
    }

    /// States, row by row: one row a frame, in the units of the description.
    pub fn state(&self) -> &[f32] {
        &self.state
    }

    /// Actions, row by row: one row a frame, in the units of the description.
    pub fn action(&self) -> &[f32] {
        &self.action
    }

    /// Servo targets, row by row; empty where the description has no such numbers.
    pub fn servo_command(&self) -> &[f32] {
        &self.servo_command
    }

    /// One for each camera of the description, in its order.
    pub fn cameras(&self) -> &[CameraTrack] {
        &self.cameras
    }

    /// The point clouds, where they are recorded and a format needs them.
    pub fn points(&self) -> &PointCloudTrack {
        &self.points
    }

    /// A short video of all cameras, small and side by side; empty where no format has video.
    pub fn preview_mp4(&self) -> &[u8] {
        &self.preview_mp4
    }

    /// The unit as bytes, with a digest. Equal episodes give equal bytes.
    pub fn to_bytes(&self) -> Vec<u8> {
        unit_bytes::write(self)
    }

    /// The digest at the end of [`EpisodeUnit::to_bytes`], in hexadecimal digits: of all that is in the unit.
    pub fn digest(&self) -> String {
        let bytes = self.to_bytes();
        let digest = &bytes[bytes.len() - unit_bytes::DIGEST_BYTES..];
        digest.iter().map(|byte| format!("{byte:02x}")).collect()
    }

    /// The unit from its bytes.
    ///
    /// # Errors
    ///
    /// [`EpisodeError::Unit`] for damaged bytes, another version of the form, and a unit of another description.
    pub fn from_bytes(bytes: &[u8], description: &DatasetDescription) -> Result<Self, EpisodeError> {
        let unit = unit_bytes::read(bytes)?;
        let of = |width: usize| width * unit.frames;
        let lists_fit = |track: &CameraTrack| {
            let lists = [
                track.video.len(),
                track.rgb_png.len(),
                track.depth_png.len(),
                track.ids_png.len(),
                track.rgb_zlib.len(),
                track.depth_zlib.len(),
                track.ids_zlib.len(),
            ];
            lists.iter().all(|length| [0, unit.frames].contains(length))
                && track.intrinsics.len() == of(9)
                && track.world_from_camera.len() == of(16)
        };
        if unit.description != description.digest() {
            return Err(EpisodeError::Unit {
                what: "it belongs to a dataset with another description".into(),
            });
        }
        let fits = unit.frames > 0
            && unit.header.task < description.tasks().len()
            && unit.state.len() == of(description.state().dimension())
            && unit.action.len() == of(description.action().dimension())
            && unit.servo_command.len() == of(description.servo_command().map_or(0, VectorLayout::dimension))
            && unit.cameras.len() == description.cameras().len()
            && unit.cameras.iter().all(lists_fit)
            && unit.points.lists().iter().all(|list| [0, unit.frames].contains(&list.len()));
        if fits { Ok(unit) } else { Err(EpisodeError::Unit { what: "its tables have other lengths".into() }) }
    }
}
