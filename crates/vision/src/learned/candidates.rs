//! The regions among which things are chosen, for who fits what is believed of them and judges it.

use glam::DVec2;

use super::belief::Measures;
use super::{NetworkReadingSettings, instances, looks};
use crate::VisionError;
use crate::network::Looks;
use imaging::Image;
use runtime::Interrupt;

/// Regions of a picture that may be things, each with what its belief rests on.
pub struct CandidateRegions {
    /// Where the maps' places lie in the picture, pixels; those that show it.
    pub places_px: Vec<DVec2>,
    pub regions: Vec<CandidateRegion>,
}

/// One of them.
pub struct CandidateRegion {
    pub measures: Measures,
    /// Indices of places, ascending.
    pub places: Vec<usize>,
}

/// All regions of a picture among which [`read_with_network`] chooses things; overlapping, parts before wholes. For the
/// fit of [`Measures::belief`] and its judgment.
pub fn candidate_regions(
    picture: &Image,
    network: &impl Looks,
    settings: &NetworkReadingSettings,
    interrupt: &Interrupt,
) -> Result<CandidateRegions, VisionError> {
    let [_, maps] = looks(picture, network, settings, interrupt)?;
    let fewest = instances::fewest_places(&maps, [picture.width_px(), picture.height_px()], settings);
    let shown: Vec<usize> = (0..maps.count()).filter(|&place| maps.shows_picture(place)).collect();
    let tree = instances::regions(&maps, settings, interrupt)?;
    let regions = tree.candidates(FEWER * fewest).map(|(measures, places)| CandidateRegion {
        measures,
        places: places.iter().filter_map(|place| shown.binary_search(place).ok()).collect(),
    });
    Ok(CandidateRegions {
        regions: regions.collect(),
        places_px: shown.iter().map(|&place| maps.in_picture(maps.middle(place))).collect(),
    })
}

/// Share of the fewest places of a thing from which on regions are candidates.
const FEWER: f64 = 0.5;
