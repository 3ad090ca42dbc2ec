//! Table top: its outline in the image, its shape class, and the camera.

use glam::DVec2;

use super::NetworkReadingSettings;
use super::camera_fit::{CameraPrior, ExpectedCamera, TableCamera};
use super::ellipse::Ellipse;
use super::table_region::TopRegion;
use crate::VisionError;
use crate::contour;
use crate::morphology::{connected_components, fill_holes};
use crate::pixels::Pixels;
use crate::polygon::{area, convex_hull, enclosing_polygon, overlap};
use crate::reading::TopShape;
use crate::table_network::maps::Maps;
use geometry::Camera;

/// Standard deviation of the outline's corners, map cells.
const CORNER_SIGMA: f64 = 0.8;
/// Minimum overlap of a rectangle with rounded corners, and of a bulged circle. On validation images the best
/// quadrilateral of nine of ten other tops overlaps less.
const MIN_FIT: f64 = 0.93;
/// Minimum share of its hull that a convex top fills, given noisy edges.
const MIN_CONVEX: f64 = 0.94;
/// A round outline is an oval if a circle would need an elevation this far from the prediction, radians.
const MAX_ELEVATION_CHANGE_RAD: f64 = 0.25;
/// Minimum share of its enclosing triangle that a triangular top fills; its corners are rounded.
const MIN_TRIANGLE_SHARE: f64 = 0.72;
/// Tolerance of the outline's simplification, pixels of the copy.
const TOLERANCE_PX: f64 = 1.0;

/// The estimated table top.
#[derive(Clone, Debug)]
pub(crate) struct TableTop {
    pub shape: TopShape,
    pub found: TableCamera,
    /// Edge in pixels of the copy, in the order of growing angle.
    pub outline_px: Vec<DVec2>,
    /// Edge on the table, counter-clockwise, widths.
    pub outline: Vec<DVec2>,
    /// Overlap of the shape with the predicted outline, 0..1.
    pub fit: f64,
}

/// The top in the maps of a crop, independent of the camera.
pub(crate) struct TopObservation {
    size_px: [u32; 2],
    outline_sigma_px: f64,
    hull: Vec<DVec2>,
    /// Edge of an irregular top: the hull if the deviations are noise.
    smooth: Vec<DVec2>,
    may_be_named: bool,
    area: TopRegion,
    /// Best-fitting quadrilateral and ellipse; tops inside the image only.
    corners: Option<[DVec2; 4]>,
    ellipse: Option<Ellipse>,
}

impl TopObservation {
    /// Extracts the top from the maps of the crop around the table, less the pixels `beyond` it.
    /// `shows_plane` are the pixels that show the plane of the top, or do not, where a depth image measured that.
    pub(crate) fn new(
        maps: &Maps,
        pixels: &Pixels,
        beyond: &[bool],
        shows_plane: &[Option<bool>],
        settings: &NetworkReadingSettings,
    ) -> Result<Self, VisionError> {
        let inside = inside(maps, pixels, beyond, shows_plane);
        let too_little = || VisionError::NoTableTop { percent: 100.0 * settings.min_table_share };
        if (inside.len() as f64) < settings.min_table_share * pixels.len() as f64 {
            return Err(too_little());
        }
        let outline_px = contour::trace(&inside, pixels.width, TOLERANCE_PX);
        let hull = convex_hull(&outline_px);
        if hull.len() < 3 {
            return Err(too_little());
        }
        let is_whole = !reaches_border(&outline_px, pixels);
        let is_convex = area(&outline_px) > MIN_CONVEX * area(&hull);
        let area = TopRegion::new(maps, pixels, &inside, shows_plane);
        let corners = enclosing_polygon(&hull, 4)
            .filter(|_| is_whole)
            .and_then(|corners| <[DVec2; 4]>::try_from(corners).ok())
            .and_then(|corners| area.quadrilateral(&corners));
        let ellipse =
            Ellipse::with_moments_of(&hull).filter(|_| is_whole).and_then(|ellipse| area.ellipse(&ellipse));
        Ok(Self {
            size_px: [pixels.width as u32, pixels.height as u32],
            outline_sigma_px: CORNER_SIGMA * maps.pixel_px() * pixels.scale,
            // Predicted edges are noisy, and most tops are convex. A cropped top has an unknown outline beyond the
            // border.
            smooth: if is_convex || !is_whole { hull.clone() } else { outline_px },
            may_be_named: is_whole && is_convex,
            hull,
            area,
            corners,
            ellipse,
        })
    }

    /// The top under an expected camera; `None` if no camera is consistent with it.
    pub(crate) fn with_camera(&self, expected: &ExpectedCamera) -> Option<TableTop> {
        let prior = CameraPrior::new(expected, self.size_px, self.outline_sigma_px);
        self.regular(&prior).or_else(|| self.free(&prior))
    }

    /// The top as a rectangle or a circle, if it is one.
    fn regular(&self, prior: &CameraPrior) -> Option<TableTop> {
        let top = |shape: TopShape, found: TableCamera, outline: Vec<DVec2>| {
            let outline_px = projected(&found.camera, &outline)?;
            let fit = self.area.overlap(&outline_px);
            Some(TableTop { shape, found, outline_px, outline, fit })
        };
        let rectangle = self.corners.and_then(|corners| prior.rectangle(&corners)).and_then(|found| {
            let (x, y) = (0.5, 0.5 * found.depth);
            let corners = [(-x, -y), (x, -y), (x, y), (-x, y)].map(|(x, y)| DVec2::new(x, y));
            top(TopShape::Rectangle, found, corners.to_vec())
        });
        let circle = self
            .ellipse
            .and_then(|ellipse| prior.circle(&ellipse))
            .filter(|found| {
                (found.camera.elevation_rad() - prior.elevation_rad).abs() < MAX_ELEVATION_CHANGE_RAD
            })
            .and_then(|found| {
                let edge = Ellipse { center: DVec2::ZERO, semi_axes: DVec2::splat(0.5), angle_rad: 0.0 };
                top(TopShape::Circle, found, edge.polygon(96))
            });
        let best = [rectangle, circle].into_iter().flatten().max_by(|a, b| a.fit.total_cmp(&b.fit))?;
        (best.fit >= MIN_FIT).then_some(best)
    }

    /// The top with its outline as is, under the prior camera.
    fn free(&self, prior: &CameraPrior) -> Option<TableTop> {
        let (found, outline) = prior.any_outline(&self.smooth)?;
        let shape = if self.may_be_named { named(&self.hull, &outline) } else { TopShape::Irregular };
        Some(TableTop { shape, found, outline_px: self.smooth.clone(), outline, fit: 1.0 })
    }
}

/// Pixels of the copy inside the largest component of the outline less those `beyond` the top, holes filled. The
/// outline is that of the network where the depth does not tell.
fn inside(maps: &Maps, pixels: &Pixels, beyond: &[bool], shows_plane: &[Option<bool>]) -> Vec<usize> {
    let bits: Vec<bool> = (0..pixels.len())
        .map(|index| {
            let (x, y) = pixels.xy(index);
            let p = maps.in_map(DVec2::new(x as f64 + 0.5, y as f64 + 0.5) / pixels.scale);
            let logit = maps.around(p).iter().map(|&(cell, weight)| weight * maps.outline(cell)).sum::<f64>();
            maps.shows(p) && shows_plane[index].unwrap_or(logit > 0.0 && !beyond[index])
        })
        .collect();
    let bits = fill_holes(&bits, pixels.width, pixels.height, usize::MAX);
    let mut largest = connected_components(&bits, pixels.width, pixels.height)
        .into_iter()
        .max_by_key(Vec::len)
        .unwrap_or_default();
    largest.sort_unstable();
    largest
}

/// Whether a good part of the outline runs along the image border.
fn reaches_border(outline_px: &[DVec2], pixels: &Pixels) -> bool {
    let size = DVec2::new(pixels.width as f64, pixels.height as f64);
    let margin = 0.008 * size.max_element();
    let near = |p: DVec2| p.x < margin || p.y < margin || p.x > size.x - margin || p.y > size.y - margin;
    let sides = (0..outline_px.len()).map(|k| (outline_px[k], outline_px[(k + 1) % outline_px.len()]));
    let along: f64 = sides.filter(|(a, b)| near(*a) && near(*b)).map(|(a, b)| (b - a).length()).sum();
    along > 0.03 * size.max_element()
}

/// Shape class of an outline that is neither rectangle nor circle.
fn named(hull: &[DVec2], outline: &[DVec2]) -> TopShape {
    let on_table = convex_hull(outline);
    let oval = Ellipse::with_moments_of(&on_table).map_or(0.0, |e| overlap(&on_table, &e.polygon(96)));
    let triangle = enclosing_polygon(hull, 3).map_or(0.0, |corners| area(hull) / area(&corners).max(1e-12));
    if oval > 0.955 {
        TopShape::Oval
    } else if triangle > MIN_TRIANGLE_SHARE {
        TopShape::Triangle
    } else {
        TopShape::Irregular
    }
}

/// Projects points of the table, in the order of growing angle; `None` if one lies behind the camera.
fn projected(camera: &Camera, outline: &[DVec2]) -> Option<Vec<DVec2>> {
    outline.iter().rev().map(|p| camera.project(p.extend(0.0)).map(|(pixel, _)| pixel)).collect()
}
