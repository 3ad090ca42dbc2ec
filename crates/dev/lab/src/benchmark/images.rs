//! Image benchmark: sample images are read, and the estimate is compared with the ground truth.
//!
//! The reader gets the image only. The images belong to the test split, which shares no category, finish or
//! backdrop with any other split ([`crate::synthetic_images::split`]); thresholds are chosen on the validation
//! split. The comparison is defined in [`score`], the compared quantities in [`estimate`].

pub mod depth_sensor;
pub mod perfect_maps;
pub mod estimate;
pub mod text_beside;
pub mod score;
pub mod regions;
pub mod rectangle;
pub mod report;
pub mod comparison_image;

use std::sync::Arc;

use serde::Serialize;

use self::estimate::TableEstimate;
use self::perfect_maps::PerfectMaps;
use self::regions::ImageRegions;
use self::score::ImageScore;
use crate::synthetic_images::{ImageTruth, Split, SyntheticImage, synthesize};
use embedded::single_view_reconstruction::{
    ImageReader, ReadingNetwork, SingleViewSettings, at_usual_scale, name_objects, scale_correction,
};
use embedded::text_parser::TextParserSettings;
use geometry::Camera;
use glam::DVec2;
use imaging::DepthImage;
use runtime::{CancelFlag, Cancelled};
use scene::request::RequestOptions;
use vision::category_fit;
use vision::category_fit::CategoryAssignment;
use vision::{
    CandidateRegions, ImageReading, Intrinsics, KnownCamera, NetworkReadingSettings, VisionError,
    candidate_regions, read_with_network,
};

/// Number of images in the set.
pub const SET_SIZE: u32 = 200;

/// Longer side of the images, pixels.
pub const SIZE_PX: u32 = 1024;

/// Reads images and compares the estimates with the truth.
#[derive(Clone)]
pub struct ImageBench {
    pub reader: Reader,
    /// The networks, of which the recognizer names objects.
    pub network: Arc<ReadingNetwork>,
    /// Settings that scale and name the estimate.
    pub single_view: SingleViewSettings,
    /// The parser of texts beside the images; `None` = images without texts.
    pub text_parser: Option<TextParserSettings>,
    pub beside: BesideImage,
}

/// Knowledge that the reader gets beside each image.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum BesideImage {
    #[default]
    Nothing,
    /// The intrinsics of the camera.
    Intrinsics,
    /// The intrinsics, and the exact depths in whole millimeters.
    Depth,
    /// The intrinsics, and the depths as a sensor measures them ([`depth_sensor`]).
    SensorDepth,
}

impl BesideImage {
    fn intrinsics_px(self, truth: &ImageTruth) -> Option<[f64; 6]> {
        let Camera { fx, fy, cx, cy, width_px, height_px, .. } = truth.camera;
        let intrinsics_px = [fx, fy, cx, cy, f64::from(width_px), f64::from(height_px)];
        (self != Self::Nothing).then_some(intrinsics_px)
    }

    fn depth(self, sample: &SyntheticImage) -> Option<DepthImage> {
        match self {
            Self::Nothing | Self::Intrinsics => None,
            Self::Depth => Some(sample.depth.clone()),
            Self::SensorDepth => Some(depth_sensor::measured(&sample.depth, sample.truth.number)),
        }
    }
}

/// The reader under test.
#[derive(Clone)]
pub enum Reader {
    /// The reader of `generate --image`.
    Usual(ImageReader),
    /// The same reader with ground-truth network maps.
    PerfectMaps(NetworkReadingSettings),
}

impl Reader {
    fn reading(
        &self,
        sample: &SyntheticImage,
        beside: BesideImage,
        cancel: &CancelFlag,
    ) -> Result<ImageReading, VisionError> {
        let (image, depth) = (&sample.image, beside.depth(sample));
        match (self, beside.intrinsics_px(&sample.truth)) {
            (Self::Usual(reader), Some(intrinsics_px)) => {
                let reader = reader.with_intrinsics(intrinsics_px);
                Ok((*reader.reading(image, depth.as_ref(), cancel)?).clone())
            }
            (Self::Usual(reader), None) => Ok((*reader.reading(image, None, cancel)?).clone()),
            (Self::PerfectMaps(settings), intrinsics_px) => {
                let intrinsics = intrinsics_px.map(|[fx, fy, cx, cy, ..]| Intrinsics {
                    focal_px: DVec2::new(fx, fy),
                    center_px: Some(DVec2::new(cx, cy)),
                });
                let known = KnownCamera { intrinsics, depth: depth.as_ref() };
                read_with_network(image, &PerfectMaps::new(sample), &known, settings, cancel)
            }
        }
    }

    /// Candidate regions of the instance selection.
    fn regions(&self, sample: &SyntheticImage, cancel: &CancelFlag) -> Result<CandidateRegions, VisionError> {
        let image = &sample.image;
        match self {
            Self::Usual(reader) => reader.candidate_regions(image, cancel),
            Self::PerfectMaps(settings) => {
                candidate_regions(image, &PerfectMaps::new(sample), settings, cancel)
            }
        }
    }
}

/// Result of one image.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ImageResult {
    pub number: u64,
    /// Error code of the refusal, if the reader refused the image.
    pub refused: Option<String>,
    pub score: ImageScore,
}

impl ImageBench {
    /// Image `number` of the split.
    pub fn image(split: Split, number: u64) -> SyntheticImage {
        synthesize(split, number, SIZE_PX)
    }

    /// Reads an image and compares; also returns the estimate for display. A refusal scores as an empty estimate.
    pub fn read(
        &self,
        sample: &SyntheticImage,
        cancel: &CancelFlag,
    ) -> Result<(ImageResult, Option<TableEstimate>), Cancelled> {
        let labeled = self.reader.reading(sample, self.beside, cancel);
        let read = match labeled.and_then(|reading| self.label(sample, &reading, cancel)) {
            Ok(read) => Ok(read),
            Err(VisionError::Cancelled(cancelled)) => return Err(cancelled),
            Err(error) => Err(error.code().to_owned()),
        };
        let score = score::score(&sample.truth, &sample.labels, read.as_ref().ok());
        let (read, refused) = match read {
            Ok(read) => (Some(read), None),
            Err(code) => (None, Some(code)),
        };
        Ok((ImageResult { number: sample.truth.number, refused, score }, read))
    }

    /// Candidate regions of an image with their overlaps; none if no table is found.
    pub fn regions(&self, sample: &SyntheticImage, cancel: &CancelFlag) -> Result<ImageRegions, Cancelled> {
        match self.reader.regions(sample, cancel) {
            Ok(candidates) => Ok(regions::compare(sample, &candidates)),
            Err(VisionError::Cancelled(cancelled)) => Err(cancelled),
            Err(_) => Ok(ImageRegions { number: sample.truth.number, regions: Vec::new() }),
        }
    }

    /// The estimate with labels: the assigned ones, and those that would be assigned if the catalog lacked the
    /// category of each object. The truth only selects the category to leave out, after all evidence is computed.
    fn label(
        &self,
        sample: &SyntheticImage,
        reading: &ImageReading,
        cancel: &CancelFlag,
    ) -> Result<TableEstimate, VisionError> {
        let mut read = TableEstimate::from(reading);
        let scaled = at_usual_scale(reading, &self.single_view);
        let eye = |reading: &ImageReading| reading.camera.world_from_camera.translation_m.z;
        let settings = &self.single_view.naming;
        let guesses = self.network.guesses(&sample.image, &scaled, settings, cancel)?;
        let evidence = category_fit::evidence(&sample.image, &scaled, &guesses, settings, cancel)?;
        let own = score::true_names(&sample.truth, &sample.labels, &read);
        let given = category_fit::assign_categories(&evidence, settings, |_, _| true);
        let foreign = category_fit::assign_categories(&evidence, settings, |object, category| {
            own[object] != Some(category)
        });
        let correction = scale_correction(given.scale, false, &RequestOptions::default(), &scaled);
        read.meters_per_unit = correction * eye(&scaled) / eye(reading);
        let labels = |objects: Vec<Option<CategoryAssignment>>| {
            objects.into_iter().map(|name| name.map(|name| name.category_match.category))
        };
        for ((object, label), as_foreign) in
            read.objects.iter_mut().zip(labels(given.objects)).zip(labels(foreign.objects))
        {
            (object.label, object.label_as_foreign) = (label, as_foreign);
        }
        if let Some(hints) =
            self.text_parser.as_ref().and_then(|parser| text_beside::hints(&sample.truth, parser))
        {
            let names = name_objects(&sample.image, &scaled, &guesses, Some(&hints), settings, cancel)?;
            let with_text = names.named.iter().zip(labels(names.categories));
            for (object, (named, by_image)) in read.objects.iter_mut().zip(with_text) {
                let of_text = named.and_then(|named| catalog::category(&hints.named()[named].category));
                object.label_with_text = of_text.map(|category| category.name.as_str()).or(by_image);
                object.named_by_text = named.is_some();
            }
        }
        Ok(read)
    }
}

#[cfg(test)]
mod tests;
