//! LeRobot v3.0: many episodes in a Parquet file and in a video file.
//!
//! An episode stays whole. Memory holds rows about at most [`ROWS_A_GROUP`] episodes, and a few bytes a frame of the
//! open video files.

use std::path::PathBuf;

use crate::EpisodeError;
use crate::dataset_statistics::{NamedStatistics, image_key};
use crate::description::DatasetDescription;
use crate::format::ImageStorage;
use crate::lerobot::episode_rows::{EpisodeRow, episode_table};
use crate::lerobot::frame_table::{frame_metadata, frame_table};
use crate::lerobot::info::{DATA_FILE_MIB, Totals, VIDEO_FILE_MIB, info_v30};
use crate::lerobot::rolling_data::RollingData;
use crate::lerobot::rolling_video::RollingVideo;
use crate::lerobot::statistics_json;
use crate::lerobot::tasks::write_tasks_parquet;
use crate::part_folder::{make_folder, write_file};
use crate::placement::Placement;
use crate::unit::EpisodeUnit;

/// Episodes in a row group of `meta/episodes`.
const ROWS_A_GROUP: usize = 256;

/// The largest files of a dataset, in bytes; an episode that is larger has a file of its own.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FileLimits {
    pub data_bytes: u64,
    pub video_bytes: u64,
}

impl FileLimits {
    /// LeRobot's own: 100 MiB of rows, 200 MiB of video.
    pub const LEROBOT: Self = Self { data_bytes: DATA_FILE_MIB << 20, video_bytes: VIDEO_FILE_MIB << 20 };
}

/// A dataset of v3.0 that is being written.
pub(crate) struct LeRobotV30 {
    root: PathBuf,
    images: ImageStorage,
    limits: FileLimits,
    data: RollingData,
    videos: Vec<RollingVideo>,
    rows: Vec<EpisodeRow>,
    episodes: RollingData,
    totals: Totals,
}

impl LeRobotV30 {
    pub fn create(
        root: PathBuf,
        images: ImageStorage,
        description: &DatasetDescription,
        limits: FileLimits,
    ) -> Result<Self, EpisodeError> {
        make_folder(&root.join("meta"))?;
        write_tasks_parquet(&root.join("meta/tasks.parquet"), description.tasks())?;
        let videos = match images {
            ImageStorage::Png => Vec::new(),
            ImageStorage::Video => description
                .cameras()
                .iter()
                .map(|camera| {
                    let folder = root.join("videos").join(image_key(&camera.name));
                    RollingVideo::new(folder, limits.video_bytes, camera, description.fps())
                })
                .collect(),
        };
        Ok(Self {
            images,
            limits,
            data: RollingData::new(root.join("data"), limits.data_bytes, frame_metadata(description, images)),
            videos,
            rows: Vec::new(),
            episodes: RollingData::new(root.join("meta/episodes"), limits.data_bytes, Vec::new()),
            totals: Totals::default(),
            root,
        })
    }

    pub fn add(
        &mut self,
        unit: &EpisodeUnit,
        place: &Placement,
        description: &DatasetDescription,
        statistics: &[NamedStatistics],
    ) -> Result<(), EpisodeError> {
        let table = frame_table(unit, place, description, self.images);
        let data = self.data.file_for(table.bytes())?;
        self.data.add(&table)?;
        let tracks = self.videos.iter_mut().zip(unit.cameras());
        let videos = tracks.map(|(video, track)| video.add(&track.video)).collect::<Result<_, _>>()?;
        let (outcome, statistics) = (unit.outcome().clone(), statistics.to_vec());
        self.rows.push(EpisodeRow { place: *place, outcome, data, videos, statistics });
        self.totals.episodes += 1;
        self.totals.frames += place.frames;
        if self.rows.len() == ROWS_A_GROUP { self.flush_rows(description) } else { Ok(()) }
    }

    fn flush_rows(&mut self, description: &DatasetDescription) -> Result<(), EpisodeError> {
        if self.rows.is_empty() {
            return Ok(());
        }
        let bytes = episode_table(&self.rows, description, Default::default()).bytes();
        let number = self.episodes.file_for(bytes)?;
        self.episodes.add(&episode_table(&self.rows, description, number))?;
        self.rows.clear();
        Ok(())
    }

    /// Ends the files; `info.json` comes last.
    pub fn finish(
        mut self,
        description: &DatasetDescription,
        statistics: &[NamedStatistics],
    ) -> Result<(), EpisodeError> {
        self.flush_rows(description)?;
        self.data.finish()?;
        self.episodes.finish()?;
        self.videos.into_iter().try_for_each(RollingVideo::finish)?;
        let json = format!("{:#}\n", statistics_json(statistics));
        write_file(&self.root.join("meta/stats.json"), json.as_bytes())?;
        let limits = [self.limits.data_bytes, self.limits.video_bytes];
        let info = format!("{:#}\n", info_v30(description, self.images, self.totals, limits));
        write_file(&self.root.join("meta/info.json"), info.as_bytes())
    }
}
