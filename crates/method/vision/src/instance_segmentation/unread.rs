//! Regions of objects on the table that belong to no found object: those of the class of objects before the bare top
//! that no mask covers, and masks that no primitive fits.
//!
//! A likeness that compares found objects alone is best where little is found; these pixels count as missed.

use glam::DVec2;

use super::NetworkReadingSettings;
use super::bare_top::BareTop;
use crate::morphology::{connected_components, dilate, open};
use crate::pixels::Pixels;
use crate::table_network::maps::Maps;
use imaging::Mask;

/// Cells around masks that are their blurred rims, and half the least thickness of a region.
const RIM: f64 = 2.0;
const HALF_THICKNESS: f64 = 1.0;

/// The pixels of the working copy. `known` are the masks of everything that was found, `without_solid` those of objects
/// that are not reconstructed.
pub(super) fn pixels<'a>(
    bare_top: &BareTop,
    known: impl Iterator<Item = &'a Mask>,
    without_solid: impl Iterator<Item = &'a Mask>,
    maps: &Maps,
    pixels: &Pixels,
    settings: &NetworkReadingSettings,
) -> Vec<bool> {
    let (width, height) = (pixels.width, pixels.height);
    let cell_px = maps.pixel_px() * pixels.scale;
    let taken = dilate(&united(known, pixels.len()), width, height, (RIM * cell_px) as f32);
    let shows_object = |index: usize| {
        let (x, y) = pixels.xy(index);
        let p = maps.in_map(DVec2::new(x as f64 + 0.5, y as f64 + 0.5) / pixels.scale);
        !taken[index] && maps.shows(p) && maps.object_margin(p) > 0.0 && bare_top.depth(p) > 0.0
    };
    let shown: Vec<bool> = (0..pixels.len()).map(shows_object).collect();
    let shown = open(&shown, width, height, (HALF_THICKNESS * cell_px) as f32);
    let fewest = settings.min_object_share * pixels.len() as f64;
    let mut unread = united(without_solid, pixels.len());
    let regions = connected_components(&shown, width, height);
    let large = regions.iter().filter(|region| region.len() as f64 >= fewest);
    large.flatten().for_each(|&index| unread[index] = true);
    unread
}

fn united<'a>(masks: impl Iterator<Item = &'a Mask>, count: usize) -> Vec<bool> {
    let mut bits = vec![false; count];
    for mask in masks {
        bits.iter_mut().zip(mask.bits()).for_each(|(bit, own)| *bit |= own);
    }
    bits
}
