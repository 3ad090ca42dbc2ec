//! Candidate regions with their features, for fitting and evaluating the objectness model.

use glam::DVec2;

use super::region_score::RegionFeatures;
use super::{NetworkReadingSettings, instances, predict_both};
use crate::VisionError;
use crate::table_network::DensePredictor;
use imaging::Image;
use runtime::CancelFlag;

/// Candidate regions of an image.
pub struct CandidateRegions {
    /// Centers of the map cells in the image, pixels; cells that show the image only.
    pub cells_px: Vec<DVec2>,
    pub regions: Vec<CandidateRegion>,
}

/// One candidate region.
pub struct CandidateRegion {
    pub features: RegionFeatures,
    /// Indices of cells, ascending.
    pub cells: Vec<usize>,
}

/// All regions among which [`read_with_network`](super::read_with_network) selects objects. They overlap; parts
/// come before wholes. They serve to fit and to evaluate [`RegionFeatures::score`].
pub fn candidate_regions(
    image: &Image,
    network: &impl DensePredictor,
    settings: &NetworkReadingSettings,
    cancel: &CancelFlag,
) -> Result<CandidateRegions, VisionError> {
    let [_, maps] = predict_both(image, network, settings, cancel)?;
    let fewest = instances::min_cells(&maps, [image.width_px(), image.height_px()], settings);
    let shown: Vec<usize> = (0..maps.count()).filter(|&cell| maps.shows_image(cell)).collect();
    let tree = instances::regions(&maps, settings, cancel)?;
    let regions = tree.candidates(CANDIDATE_SHARE * fewest).map(|(features, cells)| CandidateRegion {
        features,
        cells: cells.iter().filter_map(|cell| shown.binary_search(cell).ok()).collect(),
    });
    Ok(CandidateRegions {
        regions: regions.collect(),
        cells_px: shown.iter().map(|&cell| maps.in_image(maps.pixel_center(cell))).collect(),
    })
}

/// Minimum area of a candidate, as a share of the minimum area of an object.
const CANDIDATE_SHARE: f64 = 0.5;
