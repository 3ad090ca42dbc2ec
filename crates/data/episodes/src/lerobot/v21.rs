//! LeRobot v2.1: a Parquet file and a video file for each episode, and JSON lines about them. GR00T and openpi read
//! it.

use std::path::PathBuf;

use serde_json::json;

use crate::EpisodeError;
use crate::dataset_statistics::{NamedStatistics, image_key};
use crate::description::DatasetDescription;
use crate::format::ImageStorage;
use crate::json_lines::JsonLines;
use crate::lerobot::frame_table::{frame_metadata, frame_table};
use crate::lerobot::info::{Totals, info_v21};
use crate::lerobot::modality::modality;
use crate::lerobot::rolling_video::write_video;
use crate::lerobot::tasks::tasks_jsonl;
use crate::lerobot::{FILES_A_CHUNK, statistics_json};
use crate::parquet_table::write_table;
use crate::part_folder::{make_folder, write_file};
use crate::placement::Placement;
use crate::unit::EpisodeUnit;

/// A dataset of v2.1 that is being written.
pub(crate) struct LeRobotV21 {
    root: PathBuf,
    images: ImageStorage,
    episodes: JsonLines,
    statistics: JsonLines,
    totals: Totals,
}

impl LeRobotV21 {
    pub fn create(
        root: PathBuf,
        images: ImageStorage,
        description: &DatasetDescription,
    ) -> Result<Self, EpisodeError> {
        let meta = root.join("meta");
        make_folder(&meta)?;
        write_file(&meta.join("tasks.jsonl"), tasks_jsonl(description.tasks()).as_bytes())?;
        write_file(&meta.join("modality.json"), format!("{:#}\n", modality(description)).as_bytes())?;
        Ok(Self {
            images,
            episodes: JsonLines::create(meta.join("episodes.jsonl"))?,
            statistics: JsonLines::create(meta.join("episodes_stats.jsonl"))?,
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
        let (chunk, index) = (place.episode_index / FILES_A_CHUNK, place.episode_index);
        let folder = self.root.join(format!("data/chunk-{chunk:03}"));
        make_folder(&folder)?;
        let table = frame_table(unit, place, description, self.images);
        write_table(
            &folder.join(format!("episode_{index:06}.parquet")),
            &table,
            &frame_metadata(description, self.images),
        )?;
        if self.images == ImageStorage::Video {
            for (camera, track) in description.cameras().iter().zip(unit.cameras()) {
                let folder = self.root.join(format!("videos/chunk-{chunk:03}")).join(image_key(&camera.name));
                make_folder(&folder)?;
                let path = folder.join(format!("episode_{index:06}.mp4"));
                write_video(&path, camera, place.fps, &track.video)?;
            }
        }
        self.episodes.add(&json!({
            "episode_index": index,
            "tasks": [description.tasks()[place.task_index]],
            "length": place.frames,
        }))?;
        self.statistics.add(&json!({"episode_index": index, "stats": statistics_json(statistics)}))?;
        self.totals.episodes += 1;
        self.totals.frames += place.frames;
        Ok(())
    }

    /// Ends the files; `info.json` comes last.
    pub fn finish(
        self,
        description: &DatasetDescription,
        statistics: &[NamedStatistics],
    ) -> Result<(), EpisodeError> {
        self.episodes.finish()?;
        self.statistics.finish()?;
        let json = format!("{:#}\n", statistics_json(statistics));
        write_file(&self.root.join("meta/stats.json"), json.as_bytes())?;
        let info = format!("{:#}\n", info_v21(description, self.images, self.totals));
        write_file(&self.root.join("meta/info.json"), info.as_bytes())
    }
}
