//! The rows of `meta/episodes`: where each episode is, and its statistics.

use crate::dataset_statistics::{NamedStatistics, image_key};
use crate::description::DatasetDescription;
use crate::episode::Outcome;
use crate::lerobot::rolling_data::FileNumber;
use crate::lerobot::rolling_video::VideoPlace;
use crate::parquet_table::{Column, Table};
use crate::placement::Placement;

/// Row of a written episode.
pub(crate) struct EpisodeRow {
    pub place: Placement,
    pub outcome: Outcome,
    pub data: FileNumber,
    /// One for each camera, or none where images are PNG.
    pub videos: Vec<VideoPlace>,
    pub statistics: Vec<NamedStatistics>,
}

/// The rows as a table that lies in the file `of_table`.
pub(crate) fn episode_table(
    rows: &[EpisodeRow],
    description: &DatasetDescription,
    of_table: FileNumber,
) -> Table {
    let mut table = Table::default();
    let whole = |value: &dyn Fn(&EpisodeRow) -> u64| {
        Column::Int64(rows.iter().map(|row| value(row) as i64).collect())
    };
    table.push("episode_index", whole(&|row| row.place.episode_index));
    let tasks = rows.iter().map(|row| description.tasks()[row.place.task_index].clone()).collect();
    table.push("tasks", Column::TextList { values: tasks, width: 1 });
    table.push("length", whole(&|row| row.place.frames));
    table.push("data/chunk_index", whole(&|row| row.data.chunk));
    table.push("data/file_index", whole(&|row| row.data.file));
    table.push("dataset_from_index", whole(&|row| row.place.first_frame));
    table.push("dataset_to_index", whole(&|row| row.place.first_frame + row.place.frames));
    if rows.iter().all(|row| !row.videos.is_empty()) {
        for (camera, described) in description.cameras().iter().enumerate() {
            let key = |name: &str| format!("videos/{}/{name}", image_key(&described.name));
            let seconds = |value: &dyn Fn(&VideoPlace) -> f64| {
                Column::Double(rows.iter().map(|row| value(&row.videos[camera])).collect())
            };
            table.push(key("chunk_index"), whole(&|row| row.videos[camera].number.chunk));
            table.push(key("file_index"), whole(&|row| row.videos[camera].number.file));
            table.push(key("from_timestamp"), seconds(&|place| place.from_s));
            table.push(key("to_timestamp"), seconds(&|place| place.to_s));
        }
    }
    table.push("meta/episodes/chunk_index", whole(&|_| of_table.chunk));
    table.push("meta/episodes/file_index", whole(&|_| of_table.file));
    table.push("success", Column::Bool(rows.iter().map(|row| row.outcome.is_success()).collect()));
    let labels = rows.iter().map(|row| row.outcome.label().to_owned()).collect();
    table.push("outcome", Column::Text(labels));
    push_statistics(&mut table, rows);
    table
}

fn push_statistics(table: &mut Table, rows: &[EpisodeRow]) {
    for (f, feature) in rows.first().map_or(&[][..], |row| &row.statistics).iter().enumerate() {
        for (s, (name, numbers)) in feature.statistics.named().into_iter().enumerate() {
            let width = numbers.len();
            let of_row = |row: &EpisodeRow| row.statistics[f].statistics.named()[s].1.to_vec();
            let values = rows.iter().flat_map(of_row).collect();
            let column = if feature.is_image {
                Column::ChannelList { values, width }
            } else {
                Column::DoubleList { values, width }
            };
            table.push(format!("stats/{}/{name}", feature.key), column);
        }
        let counts = rows.iter().map(|row| row.statistics[f].statistics.count as i64).collect();
        table.push(format!("stats/{}/count", feature.key), Column::Int64List { values: counts, width: 1 });
    }
}
