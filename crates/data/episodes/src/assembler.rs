//! Episode units into datasets, in several formats at once, without encoding anything again.
//!
//! A job stores each unit when its episode is finished. The job that assembles the dataset reads them back in
//! ascending numbers; which worker made a unit, and when, leaves no trace. The assembler holds one unit at a time. It
//! writes below `FOLDER.part`; only [`DatasetAssembler::finish`] gives the folder its name. After a stop, assembling
//! starts anew.

use std::path::{Path, PathBuf};

use serde_json::json;

use crate::EpisodeError;
use crate::card::{DatasetCard, DatasetSummary, card_text};
use crate::dataset_statistics::{DatasetStatistics, NamedStatistics};
use crate::description::DatasetDescription;
use crate::format::{Encodings, Format};
use crate::json_lines::JsonLines;
use crate::lerobot::v21::LeRobotV21;
use crate::lerobot::v30::{FileLimits, LeRobotV30};
use crate::limit_shares::{enlarge, limit_shares};
use crate::parquet_and_png::ParquetAndPng;
use crate::part_folder::{PartFolder, make_folder, write_file};
use crate::placement::Placement;
use crate::preview::preview_path;
use crate::robomimic::Robomimic;
use crate::strip::strip_path;
use crate::unit::EpisodeUnit;

/// A dataset that is being written.
pub struct DatasetAssembler {
    description: DatasetDescription,
    card: DatasetCard,
    part: PartFolder,
    writers: Vec<(Format, Writer)>,
    needed: Encodings,
    statistics: DatasetStatistics,
    records: JsonLines,
    summary: DatasetSummary,
    last_number: Option<u64>,
}

enum Writer {
    LeRobotV30(Box<LeRobotV30>),
    LeRobotV21(LeRobotV21),
    Robomimic(Robomimic),
    ParquetAndPng(ParquetAndPng),
}

impl DatasetAssembler {
    /// Begins a dataset in `folder`, which must not exist, with one folder inside for each format.
    ///
    /// # Errors
    ///
    /// [`EpisodeError::Folder`] for a folder that exists; [`EpisodeError::Description`] for no format, equal formats,
    /// and robomimic without ranges of the action; [`EpisodeError::DiskFull`] and [`EpisodeError::Write`] of the
    /// disk.
    pub fn create(
        folder: &Path,
        description: DatasetDescription,
        formats: &[Format],
        card: DatasetCard,
    ) -> Result<Self, EpisodeError> {
        Self::with_limits(folder, description, formats, card, FileLimits::LEROBOT)
    }

    /// As [`DatasetAssembler::create`], with other limits for the files of LeRobot v3.0.
    ///
    /// # Errors
    ///
    /// Those of [`DatasetAssembler::create`].
    pub fn with_limits(
        folder: &Path,
        description: DatasetDescription,
        formats: &[Format],
        card: DatasetCard,
        limits: FileLimits,
    ) -> Result<Self, EpisodeError> {
        check_formats(formats, &description)?;
        let part = PartFolder::create(folder)?;
        let writers = formats
            .iter()
            .map(|format| {
                let root = part.folder(format.folder())?;
                Ok((*format, Writer::create(root, *format, &description, limits)?))
            })
            .collect::<Result<_, EpisodeError>>()?;
        Ok(Self {
            statistics: DatasetStatistics::create(&part, &description)?,
            records: JsonLines::create(part.path("records.jsonl"))?,
            needed: Encodings::of(formats),
            description,
            card,
            part,
            writers,
            summary: DatasetSummary::default(),
            last_number: None,
        })
    }

    /// Adds the next episode and returns its place.
    ///
    /// # Errors
    ///
    /// [`EpisodeError::Order`] for a unit with a number that is not above the last, of another description, or
    /// without what the formats need; nothing was written then. [`EpisodeError::DiskFull`] and
    /// [`EpisodeError::Write`] of the disk: the dataset must then be assembled anew.
    pub fn add(&mut self, unit: &EpisodeUnit) -> Result<Placement, EpisodeError> {
        self.check(unit)?;
        let place = Placement::new(unit, &self.description, self.summary.episodes, self.summary.frames);
        let statistics = self.statistics.add(unit, &place)?;
        for (_, writer) in &mut self.writers {
            writer.add(unit, &place, &self.description, &statistics)?;
        }
        self.add_strips(unit, &place)?;
        let header = unit.header();
        self.records.add(&json!({
            "episode_index": place.episode_index,
            "number": header.number,
            "seed": header.seed,
            "task": self.description.tasks()[header.task],
            "success": unit.outcome().is_success(),
            "outcome": unit.outcome().label(),
            "frames": place.frames,
            "formats": self.writers.iter().map(|(format, _)| format.folder()).collect::<Vec<_>>(),
            "digest": unit.digest(),
            "record": header.record,
        }))?;
        let summary = &mut self.summary;
        summary.episodes += 1;
        summary.frames += place.frames;
        let rate_hz = f64::from(self.description.fps());
        enlarge(
            &mut summary.action_shares,
            limit_shares(self.description.action().elements(), unit.action(), rate_hz),
        );
        if let Some(layout) = self.description.servo_command() {
            enlarge(
                &mut summary.servo_shares,
                limit_shares(layout.elements(), unit.servo_command(), rate_hz),
            );
        }
        *summary.outcomes.entry(unit.outcome().label().to_owned()).or_default() += 1;
        let (min, max) = summary.seeds.unwrap_or((header.seed, header.seed));
        summary.seeds = Some((min.min(header.seed), max.max(header.seed)));
        self.last_number = Some(header.number);
        Ok(place)
    }

    /// Writes the strips of an episode into the folder of each format, and its preview where there is video.
    fn add_strips(&self, unit: &EpisodeUnit, place: &Placement) -> Result<(), EpisodeError> {
        for (format, _) in &self.writers {
            for (camera, track) in self.description.cameras().iter().zip(unit.cameras()) {
                let path =
                    self.part.path(format.folder()).join(strip_path(place.episode_index, &camera.name));
                if let Some(folder) = path.parent() {
                    make_folder(folder)?;
                }
                write_file(&path, &track.strip_png)?;
            }
            if format.has_video() && !unit.preview_mp4().is_empty() {
                let path = self.part.path(format.folder()).join(preview_path(place.episode_index));
                write_file(&path, unit.preview_mp4())?;
            }
        }
        Ok(())
    }

    fn check(&self, unit: &EpisodeUnit) -> Result<(), EpisodeError> {
        let episode = unit.header().number;
        let refused = |what: String, correction| Err(EpisodeError::Order { episode, what, correction });
        if let Some(last) = self.last_number.filter(|last| *last >= episode) {
            return refused(format!("episode {last} was added before"), "add episodes in ascending numbers");
        }
        if unit.description != self.description.digest() {
            let what = "it was recorded for another description".to_owned();
            return refused(what, "record it again, or assemble the dataset it belongs to");
        }
        if !unit.encodings.contain(self.needed) {
            let what = "it was encoded for other formats".to_owned();
            return refused(what, "record it again for the formats of the dataset");
        }
        Ok(())
    }

    /// Ends all files, states what they hold, and gives the folder its name.
    ///
    /// # Errors
    ///
    /// [`EpisodeError::Folder`] for no episodes; [`EpisodeError::DiskFull`] and [`EpisodeError::Write`] of the disk.
    /// The folder keeps the name of a part then.
    pub fn finish(self) -> Result<DatasetSummary, EpisodeError> {
        if self.summary.episodes == 0 {
            let (folder, what) = (self.part.path(""), "no episode was added".to_owned());
            return Err(EpisodeError::Folder { folder, what, correction: "add at least one" });
        }
        let statistics = self.statistics.finish(&self.part)?;
        self.records.finish()?;
        let records = self.part.path("records.jsonl");
        let formats: Vec<Format> = self.writers.iter().map(|(format, _)| *format).collect();
        for (format, writer) in self.writers {
            writer.finish(&self.description, &statistics)?;
            let root = self.part.path(format.folder());
            let text = card_text(&self.card, &self.summary, &self.description, format, &formats);
            write_file(&root.join("README.md"), text.as_bytes())?;
            let copy = root.join("records.jsonl");
            std::fs::copy(&records, &copy).map_err(|source| EpisodeError::write(&copy, source))?;
        }
        std::fs::remove_file(&records).map_err(|source| EpisodeError::write(&records, source))?;
        self.part.complete()?;
        Ok(self.summary)
    }
}

fn check_formats(formats: &[Format], description: &DatasetDescription) -> Result<(), EpisodeError> {
    if formats.is_empty() {
        return Err(EpisodeError::description("there are no formats", "name at least one"));
    }
    for (i, format) in formats.iter().enumerate() {
        if formats[..i].iter().any(|earlier| earlier.folder() == format.folder()) {
            let what = format!("the format {} is named twice", format.folder());
            return Err(EpisodeError::description(what, "name each format once"));
        }
    }
    let without_range = description.action().elements().iter().find(|element| element.range.is_none());
    if let (true, Some(element)) = (formats.contains(&Format::Robomimic), without_range) {
        let what = format!("robomimic scales actions, and `{}` has no range", element.full_name());
        return Err(EpisodeError::description(what, "state the range of every number of the action"));
    }
    Ok(())
}

impl Writer {
    fn create(
        root: PathBuf,
        format: Format,
        description: &DatasetDescription,
        limits: FileLimits,
    ) -> Result<Self, EpisodeError> {
        make_folder(&root)?;
        match format {
            Format::LeRobotV30 { images } => LeRobotV30::create(root, images, description, limits)
                .map(|writer| Self::LeRobotV30(Box::new(writer))),
            Format::LeRobotV21 { images } => {
                LeRobotV21::create(root, images, description).map(Self::LeRobotV21)
            }
            Format::Robomimic => Robomimic::create(&root, description).map(Self::Robomimic),
            Format::ParquetAndPng { depth } => ParquetAndPng::create(root, depth).map(Self::ParquetAndPng),
        }
    }

    fn add(
        &mut self,
        unit: &EpisodeUnit,
        place: &Placement,
        description: &DatasetDescription,
        statistics: &[NamedStatistics],
    ) -> Result<(), EpisodeError> {
        match self {
            Self::LeRobotV30(writer) => writer.add(unit, place, description, statistics),
            Self::LeRobotV21(writer) => writer.add(unit, place, description, statistics),
            Self::Robomimic(writer) => writer.add(unit, place, description),
            Self::ParquetAndPng(writer) => writer.add(unit, place, description),
        }
    }

    fn finish(
        self,
        description: &DatasetDescription,
        statistics: &[NamedStatistics],
    ) -> Result<(), EpisodeError> {
        match self {
            Self::LeRobotV30(writer) => writer.finish(description, statistics),
            Self::LeRobotV21(writer) => writer.finish(description, statistics),
            Self::Robomimic(writer) => writer.finish(),
            Self::ParquetAndPng(writer) => writer.finish(description, statistics),
        }
    }
}
