//! The formats of datasets, and what an episode unit must hold for them.

use serde::{Deserialize, Serialize};

/// How LeRobot datasets store images.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ImageStorage {
    /// H.264 in MP4: small, with errors of compression. H.264 is covered by patents in some countries.
    Video,
    /// PNG in Parquet: exact, larger, free of patents.
    Png,
}

/// How the format of plain files stores depth.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DepthStorage {
    /// PNG with 16 bits a pixel, in millimeters; 0 where nothing is in sight.
    PngMillimeters,
    /// Parquet columns with one f32 a pixel, in meters; 0 where nothing is in sight.
    ParquetMeters,
}

/// A format of a dataset.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// LeRobot v3.0: many episodes a file.
    LeRobotV30 { images: ImageStorage },
    /// LeRobot v2.1 with `modality.json`: one file an episode, for openpi and GR00T.
    LeRobotV21 { images: ImageStorage },
    /// One HDF5 file in the layout of robomimic. It needs a range for every number of the action.
    Robomimic,
    /// A Parquet file and PNG files for each episode.
    ParquetAndPng { depth: DepthStorage },
}

/// What an episode unit holds of each camera.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Encodings {
    /// H.264 samples.
    pub video: bool,
    /// RGB as PNG.
    pub png: bool,
    /// RGB, depth in meters and instance ids as zlib streams of little-endian numbers.
    pub zlib: bool,
    /// Depth in millimeters, and instance ids of 16 bits, as PNG.
    pub gray_png: bool,
}

impl Format {
    /// The folder of the format in a dataset's folder.
    pub fn folder(self) -> &'static str {
        match self {
            Self::LeRobotV30 { images: ImageStorage::Video } => "lerobot-v3.0",
            Self::LeRobotV30 { images: ImageStorage::Png } => "lerobot-v3.0-images",
            Self::LeRobotV21 { images: ImageStorage::Video } => "lerobot-v2.1",
            Self::LeRobotV21 { images: ImageStorage::Png } => "lerobot-v2.1-images",
            Self::Robomimic => "robomimic",
            Self::ParquetAndPng { .. } => "parquet-png",
        }
    }
}

impl Encodings {
    /// What these formats need.
    pub fn of(formats: &[Format]) -> Self {
        let mut all = Self::default();
        for format in formats {
            match format {
                Format::LeRobotV30 { images } | Format::LeRobotV21 { images } => match images {
                    ImageStorage::Video => all.video = true,
                    ImageStorage::Png => all.png = true,
                },
                Format::Robomimic => all.zlib = true,
                // Ids of 32 bits and depth in meters come from the streams, the rest from images.
                Format::ParquetAndPng { .. } => (all.png, all.gray_png, all.zlib) = (true, true, true),
            }
        }
        all
    }

    /// Whether these hold what others need.
    pub fn contain(self, needed: Self) -> bool {
        let pairs = [
            (self.video, needed.video),
            (self.png, needed.png),
            (self.zlib, needed.zlib),
            (self.gray_png, needed.gray_png),
        ];
        pairs.iter().all(|(has, needs)| *has || !needs)
    }
}
