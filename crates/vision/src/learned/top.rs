//! The table top: its outline in the picture, the shape it is read as, and the camera that sees it so.

use glam::DVec2;

use super::NetworkReadingSettings;
use super::camera_fit::{Found, Said};
use super::ellipse::Ellipse;
use super::top_area::TopArea;
use crate::VisionError;
use crate::contour;
use crate::network::maps::Maps;
use crate::pixels::Pixels;
use crate::polygon::{area, convex_hull, enclosed_by, overlap};
use crate::reading::TopShape;
use crate::regions::{filled, parts};
use geometry::Camera;

/// How far corners of the outline are off, pixels of the maps.
const CORNER_SIGMA: f64 = 0.8;
/// Rounded corners of a rectangle, and bulges of a circle, leave at least this overlap; on the validation split the best
/// quadrilateral of nine of ten tops of other shapes overlaps less.
const LEAST_FIT: f64 = 0.93;
/// Share of its hull that a convex top fills at least, as wavering edges let it seem.
const LEAST_CONVEX: f64 = 0.94;
/// A top is an oval if as a circle it would be seen from an elevation so far from the network's, radians.
const MOST_DOUBT_RAD: f64 = 0.25;
/// A triangle's corners are rounded off by less than this share of its area.
const LEAST_OF_TRIANGLE: f64 = 0.72;
/// Outlines are simplified to this, pixels of the copy.
const TOLERANCE_PX: f64 = 1.0;

/// The top as read.
#[derive(Clone, Debug)]
pub(crate) struct Top {
    pub shape: TopShape,
    pub found: Found,
    /// Edge in pixels of the copy, in the order of growing angle.
    pub outline_px: Vec<DVec2>,
    /// Edge on the table, counter-clockwise, widths.
    pub outline: Vec<DVec2>,
    /// Overlap of the shape with the outline the network draws, 0..1.
    pub fit: f64,
}

/// The top as the maps of a look show it, whatever camera took the picture.
pub(crate) struct SeenTop {
    size_px: [u32; 2],
    outline_sigma_px: f64,
    hull: Vec<DVec2>,
    /// Edge of a top that is neither rectangle nor circle: the hull, where the network only wavers.
    smooth: Vec<DVec2>,
    may_be_named: bool,
    area: TopArea,
    /// The quadrilateral and the ellipse that fit best; of whole tops.
    corners: Option<[DVec2; 4]>,
    ellipse: Option<Ellipse>,
}

impl SeenTop {
    /// Reads the top off the maps of a look that shows it.
    pub(crate) fn new(
        maps: &Maps,
        pixels: &Pixels,
        settings: &NetworkReadingSettings,
    ) -> Result<Self, VisionError> {
        let inside = inside(maps, pixels);
        let too_little = || VisionError::NoTopSeen { percent: 100.0 * settings.min_table_share };
        if (inside.len() as f64) < settings.min_table_share * pixels.len() as f64 {
            return Err(too_little());
        }
        let outline_px = contour::around(&inside, pixels.width, TOLERANCE_PX);
        let hull = convex_hull(&outline_px);
        if hull.len() < 3 {
            return Err(too_little());
        }
        let is_whole = !reaches_border(&outline_px, pixels);
        let is_convex = area(&outline_px) > LEAST_CONVEX * area(&hull);
        let area = TopArea::new(maps, pixels, &inside);
        let corners = enclosed_by(&hull, 4)
            .filter(|_| is_whole)
            .and_then(|corners| <[DVec2; 4]>::try_from(corners).ok())
            .and_then(|corners| area.quadrilateral(&corners));
        let ellipse =
            Ellipse::with_moments_of(&hull).filter(|_| is_whole).and_then(|ellipse| area.ellipse(&ellipse));
        Ok(Self {
            size_px: [pixels.width as u32, pixels.height as u32],
            outline_sigma_px: CORNER_SIGMA * maps.pixel_px() * pixels.scale,
            // The network's edges waver, and most tops are convex; where the picture cuts one off, nobody knows.
            smooth: if is_convex || !is_whole { hull.clone() } else { outline_px },
            may_be_named: is_whole && is_convex,
            hull,
            area,
            corners,
            ellipse,
        })
    }

    /// The top and the camera that is said to have that elevation (radians) and focal length (longer sides of the picture);
    /// `None` where no camera sees it so.
    pub(crate) fn under(&self, elevation_rad: f64, focal: f64) -> Option<Top> {
        let [width_px, height_px] = self.size_px;
        let said = Said {
            width_px,
            height_px,
            elevation_rad: elevation_rad.clamp(0.03, 1.55),
            focal_px: focal * f64::from(width_px.max(height_px)),
            outline_sigma_px: self.outline_sigma_px,
        };
        self.regular(&said).or_else(|| self.free(&said))
    }

    /// As a rectangle or a circle, where it is one.
    fn regular(&self, said: &Said) -> Option<Top> {
        let top = |shape: TopShape, found: Found, outline: Vec<DVec2>| {
            let outline_px = projected(&found.camera, &outline)?;
            let fit = self.area.overlap(&outline_px);
            Some(Top { shape, found, outline_px, outline, fit })
        };
        let rectangle = self.corners.and_then(|corners| said.rectangle(&corners)).and_then(|found| {
            let (x, y) = (0.5, 0.5 * found.depth);
            let corners = [(-x, -y), (x, -y), (x, y), (-x, y)].map(|(x, y)| DVec2::new(x, y));
            top(TopShape::Rectangle, found, corners.to_vec())
        });
        let circle = self
            .ellipse
            .and_then(|ellipse| said.circle(&ellipse))
            .filter(|found| (found.camera.elevation_rad() - said.elevation_rad).abs() < MOST_DOUBT_RAD)
            .and_then(|found| {
                let edge = Ellipse { center: DVec2::ZERO, semi_axes: DVec2::splat(0.5), angle_rad: 0.0 };
                top(TopShape::Circle, found, edge.polygon(96))
            });
        let best = [rectangle, circle].into_iter().flatten().max_by(|a, b| a.fit.total_cmp(&b.fit))?;
        (best.fit >= LEAST_FIT).then_some(best)
    }

    /// With the outline as it is, under the camera as it is said to be.
    fn free(&self, said: &Said) -> Option<Top> {
        let (found, outline) = said.any_outline(&self.smooth)?;
        let shape = if self.may_be_named { named(&self.hull, &outline) } else { TopShape::Irregular };
        Some(Top { shape, found, outline_px: self.smooth.clone(), outline, fit: 1.0 })
    }
}

/// Pixels of the copy within the largest part of the outline, without holes.
fn inside(maps: &Maps, pixels: &Pixels) -> Vec<usize> {
    let bits: Vec<bool> = (0..pixels.len())
        .map(|index| {
            let (x, y) = pixels.place(index);
            let p = maps.in_map(DVec2::new(x as f64 + 0.5, y as f64 + 0.5) / pixels.scale);
            let logit =
                maps.around(p).iter().map(|&(place, weight)| weight * maps.outline(place)).sum::<f64>();
            maps.shows(p) && logit > 0.0
        })
        .collect();
    let bits = filled(&bits, pixels.width, pixels.height, usize::MAX);
    let mut largest =
        parts(&bits, pixels.width, pixels.height).into_iter().max_by_key(Vec::len).unwrap_or_default();
    largest.sort_unstable();
    largest
}

/// Whether a good part of the outline runs along the picture's border.
fn reaches_border(outline_px: &[DVec2], pixels: &Pixels) -> bool {
    let size = DVec2::new(pixels.width as f64, pixels.height as f64);
    let margin = 0.008 * size.max_element();
    let near = |p: DVec2| p.x < margin || p.y < margin || p.x > size.x - margin || p.y > size.y - margin;
    let sides = (0..outline_px.len()).map(|k| (outline_px[k], outline_px[(k + 1) % outline_px.len()]));
    let along: f64 = sides.filter(|(a, b)| near(*a) && near(*b)).map(|(a, b)| (b - a).length()).sum();
    along > 0.03 * size.max_element()
}

/// The name of an outline that is neither rectangle nor circle.
fn named(hull: &[DVec2], outline: &[DVec2]) -> TopShape {
    let on_table = convex_hull(outline);
    let oval = Ellipse::with_moments_of(&on_table).map_or(0.0, |e| overlap(&on_table, &e.polygon(96)));
    let triangle = enclosed_by(hull, 3).map_or(0.0, |corners| area(hull) / area(&corners).max(1e-12));
    if oval > 0.955 {
        TopShape::Oval
    } else if triangle > LEAST_OF_TRIANGLE {
        TopShape::Triangle
    } else {
        TopShape::Irregular
    }
}

/// Points of the table in the picture, in the order of growing angle; `None` where one lies behind the camera.
fn projected(camera: &Camera, outline: &[DVec2]) -> Option<Vec<DVec2>> {
    outline.iter().rev().map(|p| camera.project(p.extend(0.0)).map(|(pixel, _)| pixel)).collect()
}
