//! Shape fit: the best-fitting primitive on the table for a silhouette.
//!
//! Five kinds compete: a solid of revolution (upright axis), a box, a thin extrusion of the outline on the table
//! plane, an upright extrusion, and an inflation of either outline. The first two maximize the intersection over
//! union of their projection with the mask. The others fit almost any mask, so they carry a penalty; their
//! thickness or depth maximizes the overlap. Depth and height of a box trade against each other, so edges inside
//! the silhouette decide.
//!
//! One silhouette does not determine the depth of its hidden side. The depth of an upright extrusion is a guess
//! without a [`ShapePrior`]. Cost: 5 to 30 ms an object, more with inflations.

mod box_fit;
mod prior;
mod extrusion;
mod inflation;
mod revolution;

use glam::{DVec2, DVec3};

pub(crate) use box_fit::InnerEdges;
pub use prior::{BasePrior, ShapePrior};

use super::contour;
use super::morphology;
use super::occlusion;
use super::pixels::Pixels;
use super::silhouette::Silhouette;
use geometry::Camera;
pub use geometry::posed_primitive::{PosedPrimitive, Posture, PrimitiveKind};
use imaging::{Image, Mask};

/// Fits a primitive to a mask at the size of the camera's image; `None` if the mask is empty or does not meet the
/// table plane. `image`, at the same size, shows edges inside the silhouette.
pub fn fit_solid(
    mask: &Mask,
    camera: &Camera,
    image: Option<&Image>,
    expected: Option<&ShapePrior>,
) -> Option<PosedPrimitive> {
    let (width, height) = (mask.width_px() as usize, mask.height_px() as usize);
    if (mask.width_px(), mask.height_px()) != (camera.width_px, camera.height_px) {
        return None;
    }
    let set: Vec<usize> =
        mask.bits().iter().enumerate().filter(|(_, inside)| **inside).map(|(index, _)| index).collect();
    let edges = image.map(|image| InnerEdges::new(&Pixels::new(image, u32::MAX)));
    fit(&without_holes(&set, width, height), camera, edges.as_ref(), expected, &Surroundings::default())
        .map(|(fit, _)| fit)
}

/// Surroundings of an object.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Surroundings<'a> {
    /// Occluders, a flag a pixel of the camera's image.
    pub in_front: Option<&'a [bool]>,
    /// Outline of the table top, and the ratio of the real distance from the camera to that on the table plane,
    /// for an object on a support.
    pub top: Option<(&'a [DVec2], f64)>,
}

/// As [`fit_solid`] on pixel indices, with inner edges, prior and surroundings. Also returns the score: at most 1,
/// less the less the primitive matches the silhouette or the prior.
pub(crate) fn fit(
    indices: &[usize],
    camera: &Camera,
    edges: Option<&InnerEdges>,
    expected: Option<&ShapePrior>,
    around: &Surroundings,
) -> Option<(PosedPrimitive, f64)> {
    let width = camera.width_px as usize;
    let seen = SilhouetteMeasures::new(indices, camera)?;
    let with_side = |indices: &[usize], side: usize| {
        let alone = Silhouette::new(indices, width, side);
        match around.in_front {
            Some(in_front) => alone.with_occluders(in_front, width),
            None => alone,
        }
    };
    let silhouette = |indices: &[usize]| with_side(indices, 48);
    let fine = with_side(indices, extrusion::FINE_SIDE);
    let whole = silhouette(indices);
    let turned = fit_revolution_ignoring_handles(indices, &seen, &silhouette, camera, expected);
    let block = box_fit::fit(&seen, &whole, camera, edges, expected);
    // Outlines are completed behind occluders.
    let closed = around.in_front.map(|others| occlusion::complete_by_convexity(indices, others, width));
    let outlined = closed.as_deref().unwrap_or(indices);
    let flat = extrusion::lying(&contour::trace(outlined, width, 1.2), &fine, camera, expected);
    let footed = extrusion::with_level_foot(outlined, width);
    let upright = extrusion::standing(&contour::trace(&footed, width, 1.2), &seen, &fine, camera, expected);
    let merit = |(merit, fit): (f64, PosedPrimitive)| {
        let unexpected = expected.map_or(0.0, |e| e.disagreement(fit.center, fit.size.z, camera));
        let doubts = instability(&fit) + OFF_TOP_PENALTY * share_off_table_top(&fit, around, camera);
        (merit - unexpected - doubts - inflation::thickness_penalty(&fit), fit)
    };
    let symmetric = 0.06 * seen.mirror_symmetry;
    let candidates = [
        turned.map(|fit| (fit.overlap, fit)),
        block.map(|fit| (fit.overlap - 0.01, fit)),
        flat.clone().map(|(fit, doubt)| (fit.overlap - FLAT_PENALTY - doubt, fit)),
        upright.clone().map(|fit| (fit.overlap - UPRIGHT_PENALTY + symmetric, fit)),
    ];
    let plain = candidates.into_iter().flatten().map(merit).max_by(|(a, _), (b, _)| a.total_cmp(b));
    let highest = plain.as_ref().map_or(f64::NEG_INFINITY, |(merit, _)| *merit);
    let mut best = plain;
    // Even a perfect inflation could not reach a higher score.
    if highest < 1.0 - INFLATED_LYING_PENALTY.min(INFLATED_UPRIGHT_PENALTY - symmetric) {
        let coarse = with_side(indices, INFLATED_SIDE);
        let lying = flat
            .and_then(|(fit, _)| inflation::lying(&fit, &coarse, camera, expected))
            .map(|(fit, doubt)| (fit.overlap - INFLATED_LYING_PENALTY - doubt, fit));
        let standing = upright
            .and_then(|fit| inflation::standing(&fit, &seen, &coarse, camera, expected))
            .map(|fit| (fit.overlap - INFLATED_UPRIGHT_PENALTY + symmetric, fit));
        for (merit, fit) in [lying, standing].into_iter().flatten().map(merit) {
            if best.as_ref().is_none_or(|(highest, _)| merit > *highest) {
                best = Some((merit, fit));
            }
        }
    }
    best.map(|(merit, fit)| (fit, merit))
}

/// Penalties of kinds that fit any outline.
const FLAT_PENALTY: f64 = 0.14;
const UPRIGHT_PENALTY: f64 = 0.26;
const INFLATED_LYING_PENALTY: f64 = 0.14;
const INFLATED_UPRIGHT_PENALTY: f64 = 0.2;
/// Cells along the longer side of the silhouette for the fit of inflations.
const INFLATED_SIDE: usize = 128;
/// Minimum ratio of half the width of the foot to the height of the center above it.
const MIN_FOOT: f64 = 0.12;
/// Penalty of a primitive on a point.
const POINT_CONTACT_PENALTY: f64 = 0.15;
/// Penalty of a footprint beside the table top.
const OFF_TOP_PENALTY: f64 = 0.3;

/// Penalty of a primitive that could hardly stand: standing objects have a foot.
fn instability(fit: &PosedPrimitive) -> f64 {
    let foot = match &fit.kind {
        PrimitiveKind::Turned { profile } => profile.first().map_or(0.0, |p| p.x),
        PrimitiveKind::Block => 0.5 * fit.size.x.min(fit.size.y),
        PrimitiveKind::Upright { .. } => 0.5 * fit.size.y,
        // An inflation has a foot of its own.
        PrimitiveKind::Inflated { posture: Posture::Standing, .. } => 0.3 * fit.size.y,
        PrimitiveKind::Flat { .. } | PrimitiveKind::Inflated { posture: Posture::Lying, .. } => return 0.0,
    };
    let ratio = foot / (0.5 * fit.size.z).max(1e-9);
    POINT_CONTACT_PENALTY * (1.0 - ratio / MIN_FOOT).max(0.0)
}

/// Share of a footprint's corners beside the table top.
fn share_off_table_top(fit: &PosedPrimitive, around: &Surroundings, camera: &Camera) -> f64 {
    let Some((top, nearer)) = around.top else { return 0.0 };
    let eye = camera.world_from_camera.translation_m.truncate();
    let corners = fit.footprint();
    let off = corners.iter().filter(|p| !super::polygon::encloses(top, eye + nearer * (**p - eye))).count();
    off as f64 / corners.len().max(1) as f64
}

/// Handles and spouts disturb the outline of a solid of revolution; the silhouette without thin parts may fit
/// better.
fn fit_revolution_ignoring_handles(
    indices: &[usize],
    seen: &SilhouetteMeasures,
    silhouette: &impl Fn(&[usize]) -> Silhouette,
    camera: &Camera,
    expected: Option<&ShapePrior>,
) -> Option<PosedPrimitive> {
    let whole = revolution::fit(seen, &silhouette(indices), camera, expected)?;
    if whole.overlap > 0.9 {
        return Some(whole);
    }
    let (width, height) = (camera.width_px as usize, camera.height_px as usize);
    let extent = seen.high_px - seen.low_px;
    let mut bits = vec![false; width * height];
    indices.iter().for_each(|&index| bits[index] = true);
    let core = morphology::open(&bits, width, height, (0.18 * extent.min_element()) as f32);
    let core: Vec<usize> = (0..core.len()).filter(|&index| core[index]).collect();
    let without = SilhouetteMeasures::new(&core, camera)
        .and_then(|seen| revolution::fit(&seen, &silhouette(&core), camera, expected))
        .map(|fit| PosedPrimitive { overlap: fit.overlap * core.len() as f64 / indices.len() as f64, ..fit })
        .filter(|fit| fit.overlap > whole.overlap);
    Some(without.unwrap_or(whole))
}

/// Measures of a silhouette.
pub(crate) struct SilhouetteMeasures {
    /// Contact point of its lowest pixels on the table, and the unit direction away from the camera there.
    pub contact: DVec2,
    pub away: DVec2,
    /// Column of the contact.
    pub contact_px_x: f64,
    /// Bounding box, pixels.
    pub low_px: DVec2,
    pub high_px: DVec2,
    /// Tangent of the viewing angle below the horizon at the contact.
    pub steepness: f64,
    /// Height of the vertical over the contact that ends at the top row.
    pub rise: f64,
    /// Length on the table plane per pixel at the contact, across the view.
    pub unit_per_px: f64,
    /// Overlap with its left-right mirror image, 0..1.
    pub mirror_symmetry: f64,
}

impl SilhouetteMeasures {
    fn new(indices: &[usize], camera: &Camera) -> Option<Self> {
        let width = camera.width_px as usize;
        let place = |index: &usize| DVec2::new((index % width) as f64 + 0.5, (index / width) as f64 + 0.5);
        let first = place(indices.first()?);
        let (low, high) = indices.iter().map(place).fold((first, first), |(l, h), p| (l.min(p), h.max(p)));
        let (low_px, high_px) = (low - 0.5, high + 0.5);
        let lowest: Vec<f64> =
            indices.iter().map(place).filter(|p| p.y > high.y - 2.5).map(|p| p.x).collect();
        let center = lowest.iter().sum::<f64>() / lowest.len().max(1) as f64;
        let contact = camera.meet_plane(DVec2::new(center, high_px.y), 0.0)?;
        let eye = camera.world_from_camera.translation_m;
        let away = (contact - eye).truncate().normalize_or(DVec2::Y);
        let (_, depth) = camera.project(contact)?;
        let sum: DVec2 = indices.iter().map(place).sum();
        let axis = sum.x / indices.len() as f64;
        let inside: std::collections::BTreeSet<usize> = indices.iter().copied().collect();
        let mirrored = indices.iter().filter(|&index| {
            let p = place(index);
            let x = 2.0 * axis - p.x;
            x >= 0.0 && x < width as f64 && inside.contains(&(p.y as usize * width + x as usize))
        });
        let both = mirrored.count() as f64;
        let mut seen = Self {
            contact: contact.truncate(),
            away,
            steepness: eye.z / (contact - eye).truncate().length().max(1e-6),
            rise: 0.0,
            contact_px_x: center,
            low_px,
            high_px,
            unit_per_px: depth / camera.fx,
            mirror_symmetry: both / (2.0 * indices.len() as f64 - both).max(1.0),
        };
        seen.rise = seen.height_over(seen.contact, camera);
        Some(seen)
    }

    /// The point of the table `across` to the right of the contact and `beyond` it.
    pub fn place(&self, across: f64, beyond: f64) -> DVec2 {
        self.contact + across * DVec2::new(self.away.y, -self.away.x) + beyond * self.away
    }

    /// Coordinates of a point of the table relative to the contact: the arguments of [`Self::place`].
    pub fn beside_contact(&self, point: DVec2) -> DVec2 {
        let apart = point - self.contact;
        DVec2::new(apart.dot(DVec2::new(self.away.y, -self.away.x)), apart.dot(self.away))
    }

    /// Height at which the vertical through `base` ends at the top row of the silhouette.
    fn height_over(&self, base: DVec2, camera: &Camera) -> f64 {
        let (mut low, mut high) = (0.0, 4.0);
        for _ in 0..40 {
            let center = 0.5 * (low + high);
            match camera.project(base.extend(center)) {
                Some((p, _)) if p.y > self.low_px.y => low = center,
                _ => high = center,
            }
        }
        low
    }
}

/// Convex hull of projected points; empty if one lies behind the camera.
fn projected_hull(camera: &Camera, points: impl Iterator<Item = DVec3>) -> Vec<DVec2> {
    let projected: Option<Vec<DVec2>> = points.map(|p| camera.project(p).map(|(pixel, _)| pixel)).collect();
    projected.map(|points| super::polygon::convex_hull(&points)).unwrap_or_default()
}

/// The set pixels with holes filled, as indices.
pub(crate) fn without_holes(indices: &[usize], width: usize, height: usize) -> Vec<usize> {
    let mut bits = vec![false; width * height];
    indices.iter().for_each(|&index| bits[index] = true);
    let bits = morphology::fill_holes(&bits, width, height, usize::MAX);
    (0..bits.len()).filter(|&index| bits[index]).collect()
}
