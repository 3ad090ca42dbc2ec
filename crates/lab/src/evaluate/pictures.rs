//! The picture benchmark: painted pictures are read, and what was read is compared with what was painted.
//!
//! The reader gets the picture and nothing else. The pictures are of the test split, which shows no category, finish or
//! backdrop that any other split shows ([`crate::synthetic::split`]); thresholds are chosen on those of the validation
//! split. What is compared is in [`score`], what a reader says in [`reading`].

pub mod perfect_maps;
pub mod reading;
pub mod score;
pub mod regions;
pub mod rectangle;
pub mod report;
pub mod sheet;

use serde::Serialize;

use self::perfect_maps::PerfectMaps;
use self::reading::TableRead;
use self::regions::PictureRegions;
use self::score::PictureScore;
use crate::synthetic::{Painting, Split, paint};
use embedded::photograph::{PhotographSettings, PictureReader, at_usual_scale};
use runtime::{Interrupt, Interrupted};
use vision::category_fit;
use vision::category_fit::Naming;
use vision::{
    CandidateRegions, NetworkReadingSettings, PictureReading, VisionError, candidate_regions,
    read_with_network,
};

/// Pictures of the set.
pub const SET_SIZE: u32 = 200;

/// Longer side of the set's pictures, pixels.
pub const SIZE_PX: u32 = 1024;

/// Reads pictures and compares.
#[derive(Clone)]
pub struct PictureBench {
    pub reader: Reader,
    /// How what was read is scaled and named.
    pub photograph: PhotographSettings,
}

/// Who reads.
#[derive(Clone)]
pub enum Reader {
    /// As `generate --image` does.
    Usual(PictureReader),
    /// As it would with a network that makes no mistakes.
    WithPerfectMaps(NetworkReadingSettings),
}

impl Reader {
    fn reading(&self, painting: &Painting, interrupt: &Interrupt) -> Result<PictureReading, VisionError> {
        let picture = &painting.picture;
        match self {
            Self::Usual(reader) => Ok((*reader.reading(picture, interrupt)?).clone()),
            Self::WithPerfectMaps(settings) => {
                read_with_network(picture, &PerfectMaps::new(painting), settings, interrupt)
            }
        }
    }

    /// The regions that things would be chosen from; `None` where no network reads.
    fn regions(
        &self,
        painting: &Painting,
        interrupt: &Interrupt,
    ) -> Option<Result<CandidateRegions, VisionError>> {
        let picture = &painting.picture;
        match self {
            Self::Usual(reader) => reader.candidate_regions(picture, interrupt),
            Self::WithPerfectMaps(settings) => {
                Some(candidate_regions(picture, &PerfectMaps::new(painting), settings, interrupt))
            }
        }
    }
}

/// What came of one picture.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PictureResult {
    pub number: u64,
    /// Stable name of why it was refused, if it was.
    pub refused: Option<String>,
    pub score: PictureScore,
}

impl PictureBench {
    /// Picture `number` of the set of a split.
    pub fn painted(split: Split, number: u64) -> Painting {
        paint(split, number, SIZE_PX)
    }

    /// Reads a painting and compares; the reading comes along for those who want to see it. Refusals are scored as
    /// readings of nothing.
    pub fn read(
        &self,
        painting: &Painting,
        interrupt: &Interrupt,
    ) -> Result<(PictureResult, Option<TableRead>), Interrupted> {
        let read = match self.reader.reading(painting, interrupt) {
            Ok(reading) => Ok(self.named(painting, &reading, interrupt)?),
            Err(VisionError::Interrupted(interrupted)) => return Err(interrupted),
            Err(error) => Err(error.code().to_owned()),
        };
        let score = score::score(&painting.truth, &painting.labels, read.as_ref().ok());
        let (read, refused) = match read {
            Ok(read) => (Some(read), None),
            Err(code) => (None, Some(code)),
        };
        Ok((PictureResult { number: painting.truth.number, refused, score }, read))
    }

    /// Regions of a painting, judged; none where no table is seen. `None` where no network reads.
    pub fn regions(
        &self,
        painting: &Painting,
        interrupt: &Interrupt,
    ) -> Result<Option<PictureRegions>, Interrupted> {
        match self.reader.regions(painting, interrupt) {
            None => Ok(None),
            Some(Ok(candidates)) => Ok(Some(regions::judged(painting, &candidates))),
            Some(Err(VisionError::Interrupted(interrupted))) => Err(interrupted),
            Some(Err(_)) => Ok(Some(PictureRegions { number: painting.truth.number, regions: Vec::new() })),
        }
    }

    /// What was read, with names: as they are given, and as they would be if the catalog had no category of each thing. Whose
    /// category is left out is the only thing that the truth decides, after everything was looked at.
    fn named(
        &self,
        painting: &Painting,
        reading: &PictureReading,
        interrupt: &Interrupt,
    ) -> Result<TableRead, Interrupted> {
        let mut read = TableRead::from(reading);
        let scaled = at_usual_scale(reading, &self.photograph);
        let settings = &self.photograph.naming;
        let evidence = category_fit::evidence(&painting.picture, &scaled, settings, interrupt)?;
        let own = score::true_names(&painting.truth, &painting.labels, &read);
        let given = category_fit::names(&evidence, settings, |_, _| true);
        let foreign =
            category_fit::names(&evidence, settings, |thing, category| own[thing] != Some(category));
        let labels =
            |naming: Naming| naming.things.into_iter().map(|named| named.map(|named| named.look.category));
        for ((thing, label), as_foreign) in read.things.iter_mut().zip(labels(given)).zip(labels(foreign)) {
            (thing.label, thing.label_as_foreign) = (label, as_foreign);
        }
        Ok(read)
    }
}

#[cfg(test)]
mod tests;
