//! One HDF5 file in the layout of robomimic.
//!
//! | path | content |
//! | --- | --- |
//! | `data` | attributes `total`, `env_args` (JSON), names and ranges of the numbers |
//! | `data/demo_N` | attributes `num_samples`, `seed`, `success`, `outcome`, `task`, `record` |
//! | `…/actions` | f32 in [-1, 1]: the range of each number, scaled |
//! | `…/action_targets` | f32, the action in its units |
//! | `…/servo_commands` | f32, what the servos pull to, where it is recorded |
//! | `…/rewards`, `dones` | 1 in the last frame of a success; 1 in the last frame |
//! | `…/states` | f32, the whole state |
//! | `…/obs/GROUP`, `next_obs/GROUP` | f32, the numbers of a group of the state; the last `next_obs` repeats `obs` |
//! | `…/obs/CAMERA_image` | u8, frame x row x column x 3, RGB, row 0 at the top |
//! | `…/obs/CAMERA_depth` | f32, meters, frame x row x column x 1 |
//! | `…/obs/CAMERA_instance_ids` | u16 or u32 |
//! | `…/obs/CAMERA_intrinsics`, `CAMERA_world_from_camera` | f32, 3 x 3 and 4 x 4 |
//! | `…/obs/point_cloud`, `point_cloud_colors`, `point_cloud_ids` | f32 in meters and u8, frame x point x 3; u16 |
//! | `mask/train`, `valid`, `success` | names of episodes; each tenth is for validation |
//!
//! `next_obs` has no images: they would double the file, and behavior cloning does not read them. Images are chunks
//! of one frame with gzip, which the unit already holds. The library keeps the headers of all datasets in memory
//! until it closes the file; the frames go to the disk at once.

use std::path::{Path, PathBuf};

use rust_hdf5::types::H5Type;
use rust_hdf5::{DatatypeMessage, H5File, H5Group, Hdf5Error};
use serde_json::json;

use crate::EpisodeError;
use crate::camera_track::CameraTrack;
use crate::description::{CameraDescription, DatasetDescription, InstanceIdWidth};
use crate::pixels::ZLIB_LEVEL;
use crate::placement::Placement;
use crate::unit::EpisodeUnit;

/// Each tenth episode is for validation.
const VALIDATION_PERIOD: u64 = 10;

/// A file that is being written.
pub(crate) struct Robomimic {
    path: PathBuf,
    file: H5File,
    data: H5Group,
    mask: H5Group,
    episodes: u64,
    frames: u64,
    successes: Vec<u64>,
}

impl Robomimic {
    pub fn create(root: &Path, description: &DatasetDescription) -> Result<Self, EpisodeError> {
        check_keys(description)?;
        let path = root.join("dataset.hdf5");
        let begin = || -> Result<_, Hdf5Error> {
            let file = H5File::options().best_effort_locking().create(&path)?;
            let (data, mask) = (file.create_group("data")?, file.create_group("mask")?);
            let arguments = json!({
                "env_name": description.robot_type(),
                "env_type": 2,
                "env_kwargs": {"control_freq": description.fps()},
            });
            data.set_attr_string("env_args", &arguments.to_string())?;
            for (kind, layout) in [("state", description.state()), ("action", description.action())] {
                data.set_attr_string(&format!("{kind}_names"), &json!(layout.full_names()).to_string())?;
            }
            if let Some(layout) = description.servo_command() {
                data.set_attr_string("servo_command_names", &json!(layout.full_names()).to_string())?;
            }
            let ranges: Vec<_> =
                description.action().elements().iter().map(|element| element.range).collect();
            data.set_attr_string("action_ranges", &json!(ranges).to_string())?;
            data.set_attr_string("tasks", &json!(description.tasks()).to_string())?;
            Ok((file, data, mask))
        };
        let (file, data, mask) = begin().map_err(|source| EpisodeError::hdf5(&path, source))?;
        Ok(Self { path, file, data, mask, episodes: 0, frames: 0, successes: Vec::new() })
    }

    pub fn add(
        &mut self,
        unit: &EpisodeUnit,
        place: &Placement,
        description: &DatasetDescription,
    ) -> Result<(), EpisodeError> {
        self.write_demo(unit, place, description).map_err(|source| EpisodeError::hdf5(&self.path, source))?;
        self.episodes += 1;
        self.frames += place.frames;
        if unit.outcome().is_success() {
            self.successes.push(place.episode_index);
        }
        Ok(())
    }

    fn write_demo(
        &self,
        unit: &EpisodeUnit,
        place: &Placement,
        description: &DatasetDescription,
    ) -> Result<(), Hdf5Error> {
        let demo = self.data.create_group(&format!("demo_{}", place.episode_index))?;
        let (header, is_success) = (unit.header(), unit.outcome().is_success());
        demo.set_attr_numeric("num_samples", &(place.frames as i64))?;
        demo.set_attr_numeric("seed", &header.seed)?;
        demo.set_attr_numeric("number", &header.number)?;
        demo.set_attr_numeric("success", &u8::from(is_success))?;
        demo.set_attr_string("outcome", unit.outcome().label())?;
        demo.set_attr_string("task", &description.tasks()[header.task])?;
        demo.set_attr_string("record", &header.record.to_string())?;

        let frames = unit.frames();
        let last = |value: f32| -> Vec<f32> {
            (0..frames).map(|frame| if frame + 1 == frames { value } else { 0.0 }).collect()
        };
        let (states, actions) = (description.state(), description.action());
        whole(&demo, "actions", &[frames, actions.dimension()], &scaled_actions(unit, description))?;
        whole(&demo, "action_targets", &[frames, actions.dimension()], unit.action())?;
        if let Some(layout) = description.servo_command() {
            whole(&demo, "servo_commands", &[frames, layout.dimension()], unit.servo_command())?;
        }
        whole(&demo, "states", &[frames, states.dimension()], unit.state())?;
        whole(&demo, "rewards", &[frames], &last(f32::from(u8::from(is_success))))?;
        let dones: Vec<i64> = (0..frames).map(|frame| i64::from(frame + 1 == frames)).collect();
        whole(&demo, "dones", &[frames], &dones)?;

        let (obs, next_obs) = (demo.create_group("obs")?, demo.create_group("next_obs")?);
        for (group, range) in states.groups() {
            let rows: Vec<&[f32]> =
                unit.state().chunks_exact(states.dimension()).map(|row| &row[range.clone()]).collect();
            let next: Vec<&[f32]> = rows[1..].iter().chain(rows.last()).copied().collect();
            whole(&obs, group, &[frames, range.len()], &rows.concat())?;
            whole(&next_obs, group, &[frames, range.len()], &next.concat())?;
        }
        let cameras = description.cameras().iter().zip(unit.cameras());
        cameras.into_iter().try_for_each(|(camera, track)| write_camera(&obs, camera, track, frames))?;
        let Some(points) = description.points() else { return Ok(()) };
        let (shape, clouds) = ([frames, points as usize, 3], unit.points());
        chunked::<f32>(&obs, "point_cloud", &shape, &clouds.positions_zlib)?;
        chunked::<u8>(&obs, "point_cloud_colors", &shape, &clouds.colors_zlib)?;
        chunked::<u16>(&obs, "point_cloud_ids", &shape[..2], &clouds.ids_zlib)
    }

    /// Writes totals and masks, and closes the file.
    pub fn finish(self) -> Result<(), EpisodeError> {
        let path = self.path.clone();
        self.close().map_err(|source| EpisodeError::hdf5(&path, source))
    }

    fn close(self) -> Result<(), Hdf5Error> {
        self.data.set_attr_numeric("total", &(self.frames as i64))?;
        let is_validation = |episode: &u64| episode % VALIDATION_PERIOD == VALIDATION_PERIOD - 1;
        let all = 0..self.episodes;
        let masks: [(&str, Vec<u64>); 3] = [
            ("train", all.clone().filter(|episode| !is_validation(episode)).collect()),
            ("valid", all.filter(is_validation).collect()),
            ("success", self.successes),
        ];
        for (name, episodes) in masks.iter().filter(|(_, episodes)| !episodes.is_empty()) {
            let names: Vec<String> = episodes.iter().map(|episode| format!("demo_{episode}")).collect();
            let width = names.iter().map(String::len).max().unwrap_or(1) + 1;
            let mut bytes = vec![0; width * names.len()];
            bytes.chunks_exact_mut(width).zip(&names).for_each(|(slot, name)| {
                slot[..name.len()].copy_from_slice(name.as_bytes());
            });
            let dataset = self
                .mask
                .new_dataset::<u8>()
                .shape([names.len()])
                .datatype(DatatypeMessage::fixed_string(width as u32))
                .create(name)?;
            dataset.write_raw_bytes(&bytes)?;
        }
        // Groups hold the file open.
        drop((self.data, self.mask));
        self.file.close()
    }
}

/// Groups of the state and keys of cameras share a folder of names.
fn check_keys(description: &DatasetDescription) -> Result<(), EpisodeError> {
    for camera in description.cameras() {
        for (group, _) in description.state().groups() {
            if group.strip_prefix(camera.name.as_str()).is_some_and(|rest| rest.starts_with('_')) {
                let what =
                    format!("the group `{group}` of the state begins with the camera `{}`", camera.name);
                return Err(EpisodeError::description(what, "give the group or the camera another name"));
            }
        }
    }
    Ok(())
}

/// Actions from their ranges to [-1, 1].
fn scaled_actions(unit: &EpisodeUnit, description: &DatasetDescription) -> Vec<f32> {
    let elements = description.action().elements();
    let scale = |value: f32, range: Option<[f32; 2]>| match range {
        // In f64, so that the ends come out as exactly -1 and 1.
        Some([min, max]) => {
            let share = (f64::from(value) - f64::from(min)) / (f64::from(max) - f64::from(min));
            (2.0 * share - 1.0) as f32
        }
        None => value,
    };
    let ranges = elements.iter().map(|element| element.range).cycle();
    unit.action().iter().zip(ranges).map(|(value, range)| scale(*value, range)).collect()
}

fn write_camera(
    obs: &H5Group,
    camera: &CameraDescription,
    track: &CameraTrack,
    frames: usize,
) -> Result<(), Hdf5Error> {
    let (height, width) = (camera.height_px as usize, camera.width_px as usize);
    let key = |kind: &str| format!("{}_{kind}", camera.name);
    chunked::<u8>(obs, &key("image"), &[frames, height, width, 3], &track.rgb_zlib)?;
    if camera.depth {
        chunked::<f32>(obs, &key("depth"), &[frames, height, width, 1], &track.depth_zlib)?;
    }
    let shape = [frames, height, width];
    match camera.instance_ids {
        None => {}
        Some(InstanceIdWidth::U16) => chunked::<u16>(obs, &key("instance_ids"), &shape, &track.ids_zlib)?,
        Some(InstanceIdWidth::U32) => chunked::<u32>(obs, &key("instance_ids"), &shape, &track.ids_zlib)?,
    }
    whole(obs, &key("intrinsics"), &[frames, 3, 3], &track.intrinsics)?;
    whole(obs, &key("world_from_camera"), &[frames, 4, 4], &track.world_from_camera)
}

/// A dataset in one piece.
fn whole<T: H5Type>(group: &H5Group, name: &str, shape: &[usize], values: &[T]) -> Result<(), Hdf5Error> {
    group.new_dataset::<T>().shape(shape).create(name)?.write_raw(values)
}

/// A dataset with one chunk a frame, from the streams of the unit.
fn chunked<T: H5Type>(
    group: &H5Group,
    name: &str,
    shape: &[usize],
    streams: &[Vec<u8>],
) -> Result<(), Hdf5Error> {
    let chunk: Vec<usize> = [1].iter().chain(&shape[1..]).copied().collect();
    let dataset = group.new_dataset::<T>().shape(shape).chunk(&chunk).deflate(ZLIB_LEVEL).create(name)?;
    streams.iter().enumerate().try_for_each(|(frame, stream)| dataset.write_chunk_raw(frame, stream, 0))
}
