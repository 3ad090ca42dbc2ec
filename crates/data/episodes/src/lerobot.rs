//! LeRobot's formats. Features, tables of frames and metadata are equal in both versions; what differs is how
//! episodes are divided into files.

pub mod frame_table;
pub mod info;
pub mod modality;
pub mod tasks;
pub mod v21;
pub mod v30;
mod episode_rows;
mod rolling_data;
pub(crate) mod rolling_video;

/// Files of a chunk, that is of a folder.
pub const FILES_A_CHUNK: u64 = 1000;

/// The statistics of all features as JSON.
pub(crate) fn statistics_json(
    statistics: &[crate::dataset_statistics::NamedStatistics],
) -> serde_json::Value {
    let entry = |feature: &crate::dataset_statistics::NamedStatistics| {
        (feature.key.clone(), feature.statistics.to_json(feature.is_image))
    };
    statistics.iter().map(entry).collect::<serde_json::Map<_, _>>().into()
}
