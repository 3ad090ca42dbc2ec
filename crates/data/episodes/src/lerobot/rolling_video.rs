//! Video files of one camera that follow each other. Episodes are appended at key frames, never divided.

use std::fs::File;
use std::io::BufWriter;
use std::path::{Path, PathBuf};

use video::{Mp4File, Sample};

use crate::EpisodeError;
use crate::description::CameraDescription;
use crate::lerobot::rolling_data::FileNumber;
use crate::part_folder::make_folder;

/// Position of an episode in the video files of a camera.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct VideoPlace {
    pub number: FileNumber,
    /// The exact quotient of a count of frames and the rate.
    pub from_s: f64,
    pub to_s: f64,
}

/// The video files of one camera.
pub(crate) struct RollingVideo {
    folder: PathBuf,
    limit_bytes: u64,
    camera: CameraDescription,
    fps: u32,
    number: FileNumber,
    file: Option<(PathBuf, Mp4File<BufWriter<File>>)>,
}

impl RollingVideo {
    pub fn new(folder: PathBuf, limit_bytes: u64, camera: &CameraDescription, fps: u32) -> Self {
        Self { folder, limit_bytes, camera: camera.clone(), fps, number: FileNumber::default(), file: None }
    }

    /// Appends an episode.
    pub fn add(&mut self, samples: &[Sample]) -> Result<VideoPlace, EpisodeError> {
        let bytes: u64 = samples.iter().map(|sample| sample.bytes.len() as u64).sum();
        let is_full = |(_, file): &mut (PathBuf, Mp4File<_>)| file.bytes() + bytes > self.limit_bytes;
        if let Some((path, file)) = self.file.take_if(is_full) {
            finish_video(&path, file)?;
            self.number = self.number.next();
        }
        let (path, file) = match &mut self.file {
            Some(open) => open,
            none => {
                let path = self.number.path(&self.folder, "mp4");
                make_folder(path.parent().unwrap_or(&self.folder))?;
                none.insert((path.clone(), begin_video(&path, &self.camera, self.fps)?))
            }
        };
        let first = file.frames();
        file.append(samples).map_err(|source| EpisodeError::mp4(path, source))?;
        let seconds = |frame: usize| frame as f64 / f64::from(self.fps);
        Ok(VideoPlace { number: self.number, from_s: seconds(first), to_s: seconds(file.frames()) })
    }

    pub fn finish(self) -> Result<(), EpisodeError> {
        self.file.map_or(Ok(()), |(path, file)| finish_video(&path, file))
    }
}

/// Writes a file with the frames of one episode.
pub(crate) fn write_video(
    path: &Path,
    camera: &CameraDescription,
    fps: u32,
    samples: &[Sample],
) -> Result<(), EpisodeError> {
    let mut file = begin_video(path, camera, fps)?;
    file.append(samples).map_err(|source| EpisodeError::mp4(path, source))?;
    finish_video(path, file)
}

fn begin_video(
    path: &Path,
    camera: &CameraDescription,
    fps: u32,
) -> Result<Mp4File<BufWriter<File>>, EpisodeError> {
    let file = File::create(path).map_err(|source| EpisodeError::write(path, source))?;
    Mp4File::new(BufWriter::new(file), camera.width_px, camera.height_px, fps)
        .map_err(|source| EpisodeError::mp4(path, source))
}

fn finish_video(path: &Path, file: Mp4File<BufWriter<File>>) -> Result<(), EpisodeError> {
    let buffered = file.finish().map_err(|source| EpisodeError::mp4(path, source))?;
    buffered.into_inner().map_err(|error| EpisodeError::write(path, error.into_error()))?;
    Ok(())
}
