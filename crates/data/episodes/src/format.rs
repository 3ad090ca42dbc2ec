//! The formats of datasets, and what an episode unit must hold for them.

use serde::{Deserialize, Serialize};

/// Storage of images in LeRobot datasets.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ImageStorage {
    /// H.264 in MP4: small, with errors of compression. H.264 is covered by patents in some countries.
    Video,
    /// PNG in Parquet: exact, larger, free of patents.
    Png,
}

/// Storage of depth in the format of plain files.
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

/// Encodings of each camera's data in an episode unit. Streams are zlib streams of little-endian numbers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Encodings {
    /// H.264 samples.
    pub video: bool,
    /// RGB as PNG.
    pub rgb_png: bool,
    /// Depth in millimeters as PNG.
    pub depth_png: bool,
    /// Instance ids of 16 bits as PNG.
    pub ids_png: bool,
    /// RGB as streams.
    pub rgb_zlib: bool,
    /// Depth in meters as streams of f32.
    pub depth_zlib: bool,
    /// Instance ids as streams of u16 or u32.
    pub ids_zlib: bool,
    /// Points as streams.
    pub points_zlib: bool,
}

impl Format {
    /// Every format, depth in its usual form.
    pub const ALL: [Self; 6] = [
        Self::LeRobotV30 { images: ImageStorage::Video },
        Self::LeRobotV30 { images: ImageStorage::Png },
        Self::LeRobotV21 { images: ImageStorage::Video },
        Self::LeRobotV21 { images: ImageStorage::Png },
        Self::Robomimic,
        Self::ParquetAndPng { depth: DepthStorage::PngMillimeters },
    ];

    /// Whether its folder has video, and so may have a preview of each episode, which is H.264 too.
    pub fn has_video(self) -> bool {
        matches!(
            self,
            Self::LeRobotV30 { images: ImageStorage::Video }
                | Self::LeRobotV21 { images: ImageStorage::Video }
        )
    }

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
    /// Whether depth, instance ids and points, in this order, are among them.
    pub fn kept_measures(self) -> [bool; 3] {
        [self.depth_png || self.depth_zlib, self.ids_png || self.ids_zlib, self.points_zlib]
    }

    /// Encodings that these formats need.
    pub fn of(formats: &[Format]) -> Self {
        let mut all = Self::default();
        for format in formats {
            match format {
                Format::LeRobotV30 { images } | Format::LeRobotV21 { images } => match images {
                    ImageStorage::Video => all.video = true,
                    ImageStorage::Png => all.rgb_png = true,
                },
                Format::Robomimic => {
                    (all.rgb_zlib, all.depth_zlib, all.ids_zlib, all.points_zlib) = (true, true, true, true);
                }
                Format::ParquetAndPng { depth } => {
                    // Ids of 32 bits do not fit PNG and come from streams.
                    (all.rgb_png, all.ids_png, all.ids_zlib, all.points_zlib) = (true, true, true, true);
                    match depth {
                        DepthStorage::PngMillimeters => all.depth_png = true,
                        DepthStorage::ParquetMeters => all.depth_zlib = true,
                    }
                }
            }
        }
        all
    }

    /// Whether these hold what others need.
    pub fn contain(self, needed: Self) -> bool {
        let list = |e: Self| {
            let images = [e.video, e.rgb_png, e.depth_png, e.ids_png];
            let streams = [e.rgb_zlib, e.depth_zlib, e.ids_zlib, e.points_zlib];
            [images, streams]
        };
        let (has, needs) = (list(self), list(needed));
        has.as_flattened().iter().zip(needs.as_flattened()).all(|(has, needs)| *has || !needs)
    }
}
