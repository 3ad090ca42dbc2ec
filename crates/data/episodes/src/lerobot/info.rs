//! `meta/info.json`: the version, totals, paths and features of a dataset.

use serde_json::{Map, Value, json};

use crate::dataset_statistics::image_key;
use crate::description::DatasetDescription;
use crate::format::ImageStorage;
use crate::lerobot::FILES_A_CHUNK;
use crate::numeric_features::numeric_features;

/// Numbers of episodes and frames that were added to a dataset.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Totals {
    pub episodes: u64,
    pub frames: u64,
}

/// Limits of v3.0, in mebibytes.
pub(crate) const DATA_FILE_MIB: u64 = 100;
pub(crate) const VIDEO_FILE_MIB: u64 = 200;

/// The file of v3.0.
pub(crate) fn info_v30(
    description: &DatasetDescription,
    images: ImageStorage,
    totals: Totals,
    [data_bytes, video_bytes]: [u64; 2],
) -> Value {
    let video_path = "videos/{video_key}/chunk-{chunk_index:03d}/file-{file_index:03d}.mp4";
    json!({
        "codebase_version": "v3.0",
        "robot_type": description.robot_type(),
        "total_episodes": totals.episodes,
        "total_frames": totals.frames,
        "total_tasks": description.tasks().len(),
        "chunks_size": FILES_A_CHUNK,
        "data_files_size_in_mb": data_bytes.div_ceil(1 << 20),
        "video_files_size_in_mb": video_bytes.div_ceil(1 << 20),
        "fps": description.fps(),
        "splits": {"train": format!("0:{}", totals.episodes)},
        "data_path": "data/chunk-{chunk_index:03d}/file-{file_index:03d}.parquet",
        "video_path": if has_video(description, images) { json!(video_path) } else { Value::Null },
        "features": features(description, images),
    })
}

/// The file of v2.1.
pub(crate) fn info_v21(description: &DatasetDescription, images: ImageStorage, totals: Totals) -> Value {
    let video_path = "videos/chunk-{episode_chunk:03d}/{video_key}/episode_{episode_index:06d}.mp4";
    let videos = match images {
        ImageStorage::Video => totals.episodes * description.cameras().len() as u64,
        ImageStorage::Png => 0,
    };
    json!({
        "codebase_version": "v2.1",
        "robot_type": description.robot_type(),
        "total_episodes": totals.episodes,
        "total_frames": totals.frames,
        "total_tasks": description.tasks().len(),
        "total_videos": videos,
        "total_chunks": totals.episodes.div_ceil(FILES_A_CHUNK),
        "chunks_size": FILES_A_CHUNK,
        "fps": description.fps(),
        "splits": {"train": format!("0:{}", totals.episodes)},
        "data_path": "data/chunk-{episode_chunk:03d}/episode_{episode_index:06d}.parquet",
        "video_path": if has_video(description, images) { json!(video_path) } else { Value::Null },
        "features": features(description, images),
    })
}

fn has_video(description: &DatasetDescription, images: ImageStorage) -> bool {
    images == ImageStorage::Video && !description.cameras().is_empty()
}

fn features(description: &DatasetDescription, images: ImageStorage) -> Value {
    let mut features = Map::new();
    for feature in numeric_features(description) {
        let value = json!({"dtype": "float32", "shape": [feature.names.len()], "names": feature.names});
        features.insert(feature.key, value);
    }
    for camera in description.cameras() {
        let mut value = json!({
            "dtype": if images == ImageStorage::Video { "video" } else { "image" },
            "shape": [camera.height_px, camera.width_px, 3],
            "names": ["height", "width", "channels"],
        });
        if images == ImageStorage::Video {
            value["info"] = json!({
                "video.height": camera.height_px,
                "video.width": camera.width_px,
                "video.codec": "h264",
                "video.pix_fmt": "yuv420p",
                "video.is_depth_map": false,
                "video.fps": description.fps(),
                "video.channels": 3,
                "has_audio": false,
            });
        }
        features.insert(image_key(&camera.name), value);
    }
    for (key, dtype) in [
        ("timestamp", "float32"),
        ("frame_index", "int64"),
        ("episode_index", "int64"),
        ("index", "int64"),
        ("task_index", "int64"),
    ] {
        features.insert(key.to_owned(), json!({"dtype": dtype, "shape": [1], "names": null}));
    }
    Value::Object(features)
}
