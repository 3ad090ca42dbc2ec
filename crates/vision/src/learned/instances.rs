//! The things of a picture: places of the maps that vote for the same middles and between which no borders run, as they
//! are believed to be one; then their pixels.

use glam::DVec2;

use super::NetworkReadingSettings;
use super::merge_tree::MergeTree;
use super::partition::Places;
use crate::VisionError;
use crate::network::maps::{Kind, Maps};
use crate::pixels::Pixels;
use crate::regions::parts;
use runtime::{Interrupt, Interrupted};

/// How far apart middles lie, map pixels.
const APART: usize = 2;
/// Parts of a thing below this share of its largest are somebody else's.
const LEAST_PART: f64 = 0.25;

/// What is added to each side of the box that shows the top, a share of its longer side: the middle of the margins
/// that `training/frames.py` draws.
const MARGIN: f64 = 0.085;

/// A thing as the maps show it.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Thing {
    /// Map pixels that show it.
    pub places: Vec<usize>,
    /// Map position of the middle of its footprint.
    pub base: DVec2,
    /// Rows of the map in which the points lie that are above it at the thing's height, and below it on the table.
    pub top_row: f64,
    pub ground_row: f64,
}

/// All that places that may be things could be parts of.
pub(crate) fn regions(
    maps: &Maps,
    settings: &NetworkReadingSettings,
    interrupt: &Interrupt,
) -> Result<MergeTree, Interrupted> {
    let middles = middles(maps, settings.least_middle);
    let voted = |index: usize| {
        let vote = maps.votes_for(index);
        let away = |k: &usize| (middles[*k] - vote).length_squared();
        (0..middles.len()).filter(|_| is_object(maps, index)).min_by(|a, b| away(a).total_cmp(&away(b)))
    };
    let group: Vec<Option<usize>> = (0..maps.count()).map(voted).collect();
    let of_each = |value: &dyn Fn(usize) -> f64| (0..maps.count()).map(value).collect::<Vec<f64>>();
    let vote: Vec<DVec2> = (0..maps.count()).map(|index| maps.votes_for(index)).collect();
    let places = Places {
        width: maps.width(),
        group: &group,
        border: &of_each(&|index| maps.border_probability(index)),
        object: &of_each(&|index| maps.object_probability(index)),
        center: &of_each(&|index| f64::from(maps.center(index))),
        vote: &vote,
    };
    MergeTree::new(&places, interrupt)
}

/// Places that the least thing has.
pub(crate) fn fewest_places(maps: &Maps, picture_px: [u32; 2], settings: &NetworkReadingSettings) -> f64 {
    let area_px: f64 = picture_px.map(f64::from).iter().product();
    (settings.min_object_share * area_px / maps.pixel_px().powi(2)).max(2.0)
}

/// The things that are believed, farthest (highest lowest place) first.
pub(crate) fn find(
    maps: &Maps,
    picture_px: [u32; 2],
    settings: &NetworkReadingSettings,
    interrupt: &Interrupt,
) -> Result<Vec<Thing>, VisionError> {
    let fewest = fewest_places(maps, picture_px, settings);
    let believed = regions(maps, settings, interrupt)?.most_believed(settings.least_belief, fewest);
    let mut things: Vec<Thing> = believed
        .into_iter()
        .filter_map(|region| {
            let places = main_parts(&region.places, maps);
            if (places.len() as f64) < fewest {
                return None;
            }
            let median = |value: &dyn Fn(usize) -> f64| median(places.iter().map(|&k| value(k)).collect());
            let base = DVec2::new(median(&|k| maps.base(k).x), median(&|k| maps.base(k).y));
            let (top_row, ground_row) = (median(&|k| maps.top_row(k)), median(&|k| maps.ground_row(k)));
            Some(Thing { places, base, top_row, ground_row })
        })
        .collect();
    if things.is_empty() {
        return Err(VisionError::NoObjects);
    }
    if things.len() > settings.max_objects as usize {
        return Err(VisionError::TooManyObjects { count: things.len() });
    }
    let bottom = |thing: &Thing| thing.places.iter().map(|index| index / maps.width()).max();
    things.sort_by_key(|thing| (bottom(thing), thing.places[0]));
    Ok(things)
}

/// The upper one of two middle numbers; 0 of none.
fn median(mut numbers: Vec<f64>) -> f64 {
    numbers.sort_by(f64::total_cmp);
    numbers.get(numbers.len() / 2).copied().unwrap_or(0.0)
}

/// The box around the largest part of the top's outline and the objects that touch it, pixels of the picture, with a margin;
/// `None` where no top is seen.
pub(crate) fn shown_box(maps: &Maps) -> Option<(DVec2, DVec2)> {
    let on_top = |index: usize| maps.outline(index) > 0.0 || maps.kind(index) == Kind::Object;
    let bits: Vec<bool> = (0..maps.count()).map(|k| maps.shows_picture(k) && on_top(k)).collect();
    let outline = |part: &Vec<usize>| part.iter().filter(|&&index| maps.outline(index) > 0.0).count();
    let largest = parts(&bits, maps.width(), maps.height()).into_iter().max_by_key(outline)?;
    if outline(&largest) == 0 {
        return None;
    }
    let corners = largest.iter().map(|&index| maps.middle(index));
    let (low, high) = corners
        .map(|p| (p - 0.5, p + 0.5))
        .reduce(|(low, high), (from, to)| (low.min(from), high.max(to)))?;
    let margin = MARGIN * (high - low).max_element();
    Some((maps.in_picture(low - margin), maps.in_picture(high + margin)))
}

fn is_object(maps: &Maps, index: usize) -> bool {
    maps.shows_picture(index) && maps.kind(index) == Kind::Object
}

/// Places that are more of a middle than all around them.
fn middles(maps: &Maps, least: f64) -> Vec<DVec2> {
    let (w, h) = (maps.width(), maps.height());
    let is_most = |index: usize| {
        let (x, y) = (index % w, index / w);
        let own = maps.center(index);
        let around = (y.saturating_sub(APART)..(y + APART + 1).min(h))
            .flat_map(|v| (x.saturating_sub(APART)..(x + APART + 1).min(w)).map(move |u| v * w + u));
        // Of equals the first.
        around.filter(|&other| other != index).all(|other| {
            let value = maps.center(other);
            value < own || (value == own && other > index)
        })
    };
    (0..maps.count())
        .filter(|&index| f64::from(maps.center(index)) > least && is_object(maps, index) && is_most(index))
        .map(|index| maps.middle(index))
        .collect()
}

/// What hangs together, without specks.
fn main_parts(places: &[usize], maps: &Maps) -> Vec<usize> {
    let mut bits = vec![false; maps.count()];
    places.iter().for_each(|&index| bits[index] = true);
    let parts = parts(&bits, maps.width(), maps.height());
    let largest = parts.iter().map(Vec::len).max().unwrap_or(0) as f64;
    let mut kept: Vec<usize> =
        parts.into_iter().filter(|part| part.len() as f64 >= LEAST_PART * largest).flatten().collect();
    kept.sort_unstable();
    kept
}

/// Pixels of each thing in the copy, each pixel one thing's at most.
pub(crate) fn pixels_of(things: &[Thing], maps: &Maps, pixels: &Pixels) -> Vec<Vec<usize>> {
    const NOBODY: u16 = u16::MAX;
    let mut owners = vec![NOBODY; maps.count()];
    for (owner, thing) in things.iter().enumerate() {
        thing.places.iter().for_each(|&index| owners[index] = owner as u16);
    }
    let mut own = vec![Vec::new(); things.len()];
    for index in 0..pixels.len() {
        let (x, y) = pixels.place(index);
        let p = maps.in_map(DVec2::new(x as f64 + 0.5, y as f64 + 0.5) / pixels.scale);
        if !maps.shows(p) {
            continue;
        }
        let around = maps.around(p);
        if around.iter().all(|(place, _)| owners[*place] == NOBODY) || maps.object_margin(p) <= 0.0 {
            continue;
        }
        let share = |owner: u16| {
            let its = around.iter().filter(|(place, _)| owners[*place] == owner);
            its.map(|(_, weight)| weight).sum::<f64>()
        };
        let owner = around
            .iter()
            .map(|(place, _)| owners[*place])
            .filter(|owner| *owner != NOBODY)
            .max_by(|a, b| share(*a).total_cmp(&share(*b)).then(b.cmp(a)));
        if let Some(owner) = owner {
            own[usize::from(owner)].push(index);
        }
    }
    own
}
