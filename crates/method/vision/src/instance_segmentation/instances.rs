//! Detection of objects: selected regions of the merge tree, and their pixels in the working copy.

use glam::DVec2;

use super::NetworkReadingSettings;
use super::merge_tree::MergeTree;
use super::watershed::CellGrid;
use crate::VisionError;
use crate::morphology::connected_components;
use crate::pixels::Pixels;
use crate::table_network::maps::{Maps, PixelClass};
use runtime::{CancelFlag, Cancelled};

/// Radius of non-maximum suppression of center peaks, map cells.
const PEAK_RADIUS: usize = 2;
/// Connected parts of an object below this share of its largest part are dropped.
const MIN_PART_SHARE: f64 = 0.25;

/// Margin on each side of the table's box, as a share of its longer side: the center of the range that
/// `training/frames.py` draws from.
const MARGIN: f64 = 0.085;

/// An object as the maps show it.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct DetectedObject {
    /// Map cells of the object.
    pub cells: Vec<usize>,
    /// Map position of the center of its footprint.
    pub base: DVec2,
    /// Rows of the map of two points on the vertical through that center: at the object's height, and on the
    /// table.
    pub top_row: f64,
    pub ground_row: f64,
}

/// The merge tree of all object cells.
pub(crate) fn regions(
    maps: &Maps,
    settings: &NetworkReadingSettings,
    cancel: &CancelFlag,
) -> Result<MergeTree, Cancelled> {
    let centers = centers(maps, settings.min_center);
    let voted = |index: usize| {
        let vote = maps.voted_center(index);
        let away = |k: &usize| (centers[*k] - vote).length_squared();
        (0..centers.len()).filter(|_| is_object(maps, index)).min_by(|a, b| away(a).total_cmp(&away(b)))
    };
    let group: Vec<Option<usize>> = (0..maps.count()).map(voted).collect();
    let of_each = |value: &dyn Fn(usize) -> f64| (0..maps.count()).map(value).collect::<Vec<f64>>();
    let vote: Vec<DVec2> = (0..maps.count()).map(|index| maps.voted_center(index)).collect();
    let grid = CellGrid {
        width: maps.width(),
        group: &group,
        border: &of_each(&|index| maps.border_probability(index)),
        object: &of_each(&|index| maps.object_probability(index)),
        center: &of_each(&|index| f64::from(maps.center_score(index))),
        vote: &vote,
    };
    MergeTree::new(&grid, cancel)
}

/// Minimum number of cells of an object.
pub(crate) fn min_cells(maps: &Maps, image_px: [u32; 2], settings: &NetworkReadingSettings) -> f64 {
    let area_px: f64 = image_px.map(f64::from).iter().product();
    (settings.min_object_share * area_px / maps.pixel_px().powi(2)).max(2.0)
}

/// The selected objects, farthest first: in ascending order of their lowest row.
pub(crate) fn find(
    maps: &Maps,
    image_px: [u32; 2],
    settings: &NetworkReadingSettings,
    cancel: &CancelFlag,
) -> Result<Vec<DetectedObject>, VisionError> {
    let fewest = min_cells(maps, image_px, settings);
    let scored = regions(maps, settings, cancel)?.select_disjoint(settings.min_score, fewest);
    let mut objects: Vec<DetectedObject> = scored
        .into_iter()
        .filter_map(|region| {
            let cells = significant_parts(&region.cells, maps);
            if (cells.len() as f64) < fewest {
                return None;
            }
            let median = |value: &dyn Fn(usize) -> f64| median(cells.iter().map(|&k| value(k)).collect());
            let base = DVec2::new(median(&|k| maps.base(k).x), median(&|k| maps.base(k).y));
            let (top_row, ground_row) = (median(&|k| maps.top_row(k)), median(&|k| maps.ground_row(k)));
            Some(DetectedObject { cells, base, top_row, ground_row })
        })
        .collect();
    if objects.is_empty() {
        return Err(VisionError::NoObjects);
    }
    if objects.len() > settings.max_objects as usize {
        return Err(VisionError::TooManyObjects { count: objects.len() });
    }
    let bottom = |object: &DetectedObject| object.cells.iter().map(|index| index / maps.width()).max();
    objects.sort_by_key(|object| (bottom(object), object.cells[0]));
    Ok(objects)
}

/// Upper median; 0 of an empty list.
fn median(mut numbers: Vec<f64>) -> f64 {
    numbers.sort_by(f64::total_cmp);
    numbers.get(numbers.len() / 2).copied().unwrap_or(0.0)
}

/// Box around the largest component of table and touching objects, with a margin, pixels of the image. `None` if
/// no top is visible.
pub(crate) fn table_box(maps: &Maps) -> Option<(DVec2, DVec2)> {
    let on_top = |index: usize| maps.outline(index) > 0.0 || maps.class(index) == PixelClass::Object;
    let bits: Vec<bool> = (0..maps.count()).map(|k| maps.shows_image(k) && on_top(k)).collect();
    let outline = |part: &Vec<usize>| part.iter().filter(|&&index| maps.outline(index) > 0.0).count();
    let largest = connected_components(&bits, maps.width(), maps.height()).into_iter().max_by_key(outline)?;
    if outline(&largest) == 0 {
        return None;
    }
    let corners = largest.iter().map(|&index| maps.pixel_center(index));
    let (low, high) = corners
        .map(|p| (p - 0.5, p + 0.5))
        .reduce(|(low, high), (from, to)| (low.min(from), high.max(to)))?;
    let margin = MARGIN * (high - low).max_element();
    Some((maps.in_image(low - margin), maps.in_image(high + margin)))
}

fn is_object(maps: &Maps, index: usize) -> bool {
    maps.shows_image(index) && maps.class(index) == PixelClass::Object
}

/// Local maxima of the center heatmap.
fn centers(maps: &Maps, lowest: f64) -> Vec<DVec2> {
    let (w, h) = (maps.width(), maps.height());
    let is_max = |index: usize| {
        let (x, y) = (index % w, index / w);
        let own = maps.center_score(index);
        let around = (y.saturating_sub(PEAK_RADIUS)..(y + PEAK_RADIUS + 1).min(h)).flat_map(|v| {
            (x.saturating_sub(PEAK_RADIUS)..(x + PEAK_RADIUS + 1).min(w)).map(move |u| v * w + u)
        });
        // Of equal values the first is the peak.
        around.filter(|&other| other != index).all(|other| {
            let value = maps.center_score(other);
            value < own || (value == own && other > index)
        })
    };
    (0..maps.count())
        .filter(|&index| {
            f64::from(maps.center_score(index)) > lowest && is_object(maps, index) && is_max(index)
        })
        .map(|index| maps.pixel_center(index))
        .collect()
}

/// Connected components without small fragments.
fn significant_parts(cells: &[usize], maps: &Maps) -> Vec<usize> {
    let mut bits = vec![false; maps.count()];
    cells.iter().for_each(|&index| bits[index] = true);
    let parts = connected_components(&bits, maps.width(), maps.height());
    let largest = parts.iter().map(Vec::len).max().unwrap_or(0) as f64;
    let mut kept: Vec<usize> =
        parts.into_iter().filter(|part| part.len() as f64 >= MIN_PART_SHARE * largest).flatten().collect();
    kept.sort_unstable();
    kept
}

/// Pixels of each object in the working copy; a pixel belongs to one object at most.
pub(crate) fn pixels_of(objects: &[DetectedObject], maps: &Maps, pixels: &Pixels) -> Vec<Vec<usize>> {
    const UNASSIGNED: u16 = u16::MAX;
    let mut owners = vec![UNASSIGNED; maps.count()];
    for (owner, object) in objects.iter().enumerate() {
        object.cells.iter().for_each(|&index| owners[index] = owner as u16);
    }
    let mut own = vec![Vec::new(); objects.len()];
    for index in 0..pixels.len() {
        let (x, y) = pixels.xy(index);
        let p = maps.in_map(DVec2::new(x as f64 + 0.5, y as f64 + 0.5) / pixels.scale);
        if !maps.shows(p) {
            continue;
        }
        let around = maps.around(p);
        if around.iter().all(|(cell, _)| owners[*cell] == UNASSIGNED) || maps.object_margin(p) <= 0.0 {
            continue;
        }
        let share = |owner: u16| {
            let its = around.iter().filter(|(cell, _)| owners[*cell] == owner);
            its.map(|(_, weight)| weight).sum::<f64>()
        };
        let owner = around
            .iter()
            .map(|(cell, _)| owners[*cell])
            .filter(|owner| *owner != UNASSIGNED)
            .max_by(|a, b| share(*a).total_cmp(&share(*b)).then(b.cmp(a)));
        if let Some(owner) = owner {
            own[usize::from(owner)].push(index);
        }
    }
    own
}
