//! Plain files: one folder an episode, with a Parquet table of frames and PNG images. No reader is needed but those
//! of Parquet and PNG.
//!
//! ```text
//! dataset.json                                    description, units, conventions, statistics; written last
//! episodes/episode_000000/frames.parquet          one row a frame, columns as in LeRobot
//! episodes/episode_000000/front/rgb_000000.png    RGB, 8 bits
//! episodes/episode_000000/front/depth_mm_000000.png        16 bits; or the column `depth_m.front`
//! episodes/episode_000000/front/instance_ids_000000.png    16 bits; or the column `instance_ids.front` of 32 bits
//! columns `point_cloud`, `point_cloud_colors`, `point_cloud_ids`     x, y, z in meters; red, green, blue; instance
//! ```

use std::path::{Path, PathBuf};

use serde_json::json;

use crate::EpisodeError;
use crate::camera_track::CameraTrack;
use crate::dataset_statistics::NamedStatistics;
use crate::description::{CameraDescription, DatasetDescription, InstanceIdWidth};
use crate::format::{DepthStorage, ImageStorage};
use crate::lerobot::frame_table::frame_table;
use crate::lerobot::statistics_json;
use crate::parquet_table::{Column, Table, write_table};
use crate::part_folder::{make_folder, write_file};
use crate::pixels::unzlib;
use crate::placement::Placement;
use crate::unit::EpisodeUnit;
use crate::vector_layout::VectorLayout;

/// A dataset of plain files that is being written.
pub(crate) struct ParquetAndPng {
    root: PathBuf,
    depth: DepthStorage,
    episodes: u64,
    frames: u64,
}

impl ParquetAndPng {
    pub fn create(root: PathBuf, depth: DepthStorage) -> Result<Self, EpisodeError> {
        make_folder(&root.join("episodes"))?;
        Ok(Self { root, depth, episodes: 0, frames: 0 })
    }

    pub fn add(
        &mut self,
        unit: &EpisodeUnit,
        place: &Placement,
        description: &DatasetDescription,
    ) -> Result<(), EpisodeError> {
        let folder = self.root.join(format!("episodes/episode_{:06}", place.episode_index));
        make_folder(&folder)?;
        // Without columns of images, as beside a video.
        let mut table = frame_table(unit, place, description, ImageStorage::Video);
        for (camera, track) in description.cameras().iter().zip(unit.cameras()) {
            self.add_camera(&folder, camera, track, unit, &mut table)?;
        }
        if let Some(points) = description.points() {
            add_points(points as usize, unit, &mut table)?;
        }
        write_table(&folder.join("frames.parquet"), &table, &[])?;
        self.episodes += 1;
        self.frames += place.frames;
        Ok(())
    }

    fn add_camera(
        &self,
        folder: &Path,
        camera: &CameraDescription,
        track: &CameraTrack,
        unit: &EpisodeUnit,
        table: &mut Table,
    ) -> Result<(), EpisodeError> {
        let images = folder.join(&camera.name);
        make_folder(&images)?;
        let write_all = |kind: &str, files: &[Vec<u8>]| {
            let path = |frame: usize| images.join(format!("{kind}_{frame:06}.png"));
            files.iter().enumerate().try_for_each(|(frame, file)| write_file(&path(frame), file))
        };
        write_all("rgb", &track.rgb_png)?;
        let width = (camera.width_px * camera.height_px) as usize;
        if camera.depth {
            match self.depth {
                DepthStorage::PngMillimeters => write_all("depth_mm", &track.depth_png)?,
                DepthStorage::ParquetMeters => {
                    let values = numbers(unit, &track.depth_zlib, width, f32::from_le_bytes)?;
                    table.push(format!("depth_m.{}", camera.name), Column::FloatList { values, width });
                }
            }
        }
        match camera.instance_ids {
            None => Ok(()),
            Some(InstanceIdWidth::U16) => write_all("instance_ids", &track.ids_png),
            Some(InstanceIdWidth::U32) => {
                let values = numbers(unit, &track.ids_zlib, width, u32::from_le_bytes)?;
                table.push(format!("instance_ids.{}", camera.name), Column::UnsignedList { values, width });
                Ok(())
            }
        }
    }

    /// Writes the description of the dataset, without which it is not complete.
    pub fn finish(
        self,
        description: &DatasetDescription,
        statistics: &[NamedStatistics],
    ) -> Result<(), EpisodeError> {
        let depth = match self.depth {
            DepthStorage::PngMillimeters => "depth_mm_*.png, 16 bits, millimeters",
            DepthStorage::ParquetMeters => "column depth_m.CAMERA, float, meters, row by row from the top",
        };
        let dataset = json!({
            "format": "tabletopgen episodes, Parquet and PNG, version 1",
            "total_episodes": self.episodes,
            "total_frames": self.frames,
            "description": description,
            "state_names": description.state().full_names(),
            "action_names": description.action().full_names(),
            "servo_command_names": description.servo_command().map(VectorLayout::full_names),
            "conventions": {
                "order": "state[t] is measured before action[t] is sent; action[t] is the commanded target",
                "servo_command": "what the servos pull to for action[t]; it leads the motion",
                "images": "RGB, row 0 is the top",
                "depth": format!("{depth}; along the optical axis; 0 where nothing is in sight"),
                "point_cloud": "x, y, z of each point in the world, meters; red, green, blue of each in \
                    point_cloud_colors, its instance in point_cloud_ids",
                "intrinsics": "K row by row, pixels",
                "world_from_camera": "row by row, meters; camera axes: x right, y down, z forward",
                "quaternions": "w, x, y, z; without jumps of sign along an episode and between state and action",
                "rotation_6d": "the first two columns of the rotation's matrix, one after the other",
            },
            "statistics": statistics_json(statistics),
        });
        write_file(&self.root.join("dataset.json"), format!("{dataset:#}\n").as_bytes())
    }
}

/// Adds the columns of point clouds.
fn add_points(points: usize, unit: &EpisodeUnit, table: &mut Table) -> Result<(), EpisodeError> {
    let clouds = unit.points();
    let positions = numbers(unit, &clouds.positions_zlib, 3 * points, f32::from_le_bytes)?;
    table.push("point_cloud", Column::FloatList { values: positions, width: 3 * points });
    let colors = numbers(unit, &clouds.colors_zlib, 3 * points, |[byte]| u32::from(byte))?;
    table.push("point_cloud_colors", Column::UnsignedList { values: colors, width: 3 * points });
    let ids = numbers(unit, &clouds.ids_zlib, points, |two| u32::from(u16::from_le_bytes(two)))?;
    table.push("point_cloud_ids", Column::UnsignedList { values: ids, width: points });
    Ok(())
}

/// The numbers of all frames: `width` a frame.
fn numbers<T, const BYTES: usize>(
    unit: &EpisodeUnit,
    streams: &[Vec<u8>],
    width: usize,
    number: impl Fn([u8; BYTES]) -> T,
) -> Result<Vec<T>, EpisodeError> {
    let mut values = Vec::with_capacity(streams.len() * width);
    for (frame, stream) in streams.iter().enumerate() {
        let bytes = unzlib(stream, BYTES * width).filter(|bytes| bytes.len() == BYTES * width);
        let Some(bytes) = bytes else {
            let what = format!("frame {frame} of episode {} has a damaged stream", unit.header().number);
            return Err(EpisodeError::Unit { what });
        };
        values.extend(bytes.as_chunks::<BYTES>().0.iter().map(|bytes| number(*bytes)));
    }
    Ok(values)
}
