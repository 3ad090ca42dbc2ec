//! The frames of an episode as a table: equal columns in v3.0 and v2.1.

use serde_json::{Map, json};

use crate::dataset_statistics::image_key;
use crate::description::DatasetDescription;
use crate::format::ImageStorage;
use crate::numeric_features::{numeric_features, numeric_rows};
use crate::parquet_table::{Column, Table};
use crate::placement::Placement;
use crate::unit::EpisodeUnit;

/// Keys and values in the metadata of a file of frames: the columns that are images, for the library `datasets`.
pub(crate) fn frame_metadata(
    description: &DatasetDescription,
    images: ImageStorage,
) -> Vec<(&'static str, String)> {
    match images {
        ImageStorage::Video => Vec::new(),
        ImageStorage::Png => {
            let image = |name: &str| (image_key(name), json!({"_type": "Image"}));
            let features: Map<_, _> =
                description.cameras().iter().map(|camera| image(&camera.name)).collect();
            vec![("huggingface", json!({"info": {"features": features}}).to_string())]
        }
    }
}

/// One row a frame. Images are columns only where they are stored as PNG.
pub(crate) fn frame_table(
    unit: &EpisodeUnit,
    place: &Placement,
    description: &DatasetDescription,
    images: ImageStorage,
) -> Table {
    let mut table = Table::default();
    for (feature, rows) in numeric_features(description).into_iter().zip(numeric_rows(unit)) {
        let width = feature.names.len();
        table.push(feature.key, Column::FloatList { values: rows.to_vec(), width });
    }
    if images == ImageStorage::Png {
        for (camera, track) in description.cameras().iter().zip(unit.cameras()) {
            let name = |frame: u64| format!("frame-{frame:06}.png");
            let names = (0..place.frames).map(name).collect();
            table.push(image_key(&camera.name), Column::Files { files: track.rgb_png.clone(), names });
        }
    }
    let repeated = |value: u64| Column::Int64(vec![value as i64; unit.frames()]);
    let counted = |first: u64| Column::Int64((first..first + place.frames).map(|i| i as i64).collect());
    table.push("timestamp", Column::Float(place.times_s()));
    table.push("frame_index", counted(0));
    table.push("episode_index", repeated(place.episode_index));
    table.push("index", counted(place.first_frame));
    table.push("task_index", repeated(place.task_index as u64));
    table
}
