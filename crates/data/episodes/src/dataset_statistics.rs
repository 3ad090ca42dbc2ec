//! Statistics of a dataset while episodes are added: spools for numbers, counts for images.

use crate::EpisodeError;
use crate::description::DatasetDescription;
use crate::numeric_features::{numeric_features, numeric_rows};
use crate::part_folder::PartFolder;
use crate::placement::Placement;
use crate::statistics::histogram::ImageHistogram;
use crate::statistics::spool::Spool;
use crate::statistics::{FeatureStatistics, of_consecutive};
use crate::unit::EpisodeUnit;

/// The key of a camera's images in LeRobot's formats.
pub(crate) fn image_key(camera: &str) -> String {
    format!("observation.images.{camera}")
}

/// The statistics of one feature.
#[derive(Clone, Debug)]
pub(crate) struct NamedStatistics {
    pub key: String,
    pub is_image: bool,
    pub statistics: FeatureStatistics,
}

impl NamedStatistics {
    fn number(key: impl Into<String>, statistics: FeatureStatistics) -> Self {
        Self { key: key.into(), is_image: false, statistics }
    }

    fn image(camera: &str, histogram: &ImageHistogram) -> Self {
        Self { key: image_key(camera), is_image: true, statistics: histogram.statistics() }
    }
}

/// Statistics that grow by episodes. They lie in the folder `spool` until the dataset is complete.
pub(crate) struct DatasetStatistics {
    spools: Vec<(String, Spool)>,
    cameras: Vec<(String, ImageHistogram)>,
    frames: u64,
}

/// Features of LeRobot that follow from where a frame is.
const PLACES: [&str; 4] = ["timestamp", "frame_index", "episode_index", "task_index"];

impl DatasetStatistics {
    pub fn create(part: &PartFolder, description: &DatasetDescription) -> Result<Self, EpisodeError> {
        let folder = part.folder("spool")?;
        let keys =
            numeric_features(description).into_iter().map(|feature| (feature.key, feature.names.len()));
        let places = PLACES.iter().map(|key| ((*key).to_owned(), 1));
        let spools = keys
            .chain(places)
            .map(|(key, width)| {
                let spool = Spool::create(folder.join(&key), width)?;
                Ok((key, spool))
            })
            .collect::<Result<_, EpisodeError>>()?;
        let histogram = |name: &str| (name.to_owned(), ImageHistogram::default());
        let cameras = description.cameras().iter().map(|camera| histogram(&camera.name)).collect();
        Ok(Self { spools, cameras, frames: 0 })
    }

    /// Adds an episode and returns its own statistics.
    pub fn add(
        &mut self,
        unit: &EpisodeUnit,
        place: &Placement,
    ) -> Result<Vec<NamedStatistics>, EpisodeError> {
        let repeated = |value: u64| vec![value as f32; unit.frames()];
        let places = [
            place.times_s(),
            (0..place.frames).map(|frame| frame as f32).collect(),
            repeated(place.episode_index),
            repeated(place.task_index as u64),
        ];
        let rows = numeric_rows(unit).into_iter().chain(places.iter().map(Vec::as_slice));
        let mut statistics = Vec::new();
        for ((key, spool), rows) in self.spools.iter_mut().zip(rows) {
            statistics.push(NamedStatistics::number(key.as_str(), spool.add(rows)?));
        }
        statistics.push(NamedStatistics::number("index", of_consecutive(place.first_frame, place.frames)));
        for ((name, histogram), track) in self.cameras.iter_mut().zip(unit.cameras()) {
            histogram.merge(&track.histogram);
            statistics.push(NamedStatistics::image(name, &track.histogram));
        }
        self.frames += place.frames;
        Ok(statistics)
    }

    /// The statistics of all episodes, of which there is at least one.
    pub fn finish(self, part: &PartFolder) -> Result<Vec<NamedStatistics>, EpisodeError> {
        let mut statistics = Vec::new();
        for (key, spool) in self.spools {
            statistics.push(NamedStatistics::number(key, spool.finish()?));
        }
        statistics.push(NamedStatistics::number("index", of_consecutive(0, self.frames)));
        statistics
            .extend(self.cameras.iter().map(|(name, histogram)| NamedStatistics::image(name, histogram)));
        let folder = part.path("spool");
        std::fs::remove_dir(&folder).map_err(|source| EpisodeError::write(&folder, source))?;
        Ok(statistics)
    }
}
