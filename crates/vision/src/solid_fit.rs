//! The simplest solid standing on the table whose outline is an object's silhouette.
//!
//! Five kinds compete: a turned body (upright axis), a box, a flat thing lying on the table (its outline
//! on the table plane, thin), an upright silhouette with depth, and either outline blown up. The first two are fitted by
//! climbing on the intersection over union of their projected outline with the mask; the others fit almost anything and are
//! taken only where those do not; how thick or deep they are is what best gives the silhouette. Where a box's depth and
//! height trade against each other, the edges seen inside the silhouette decide. One silhouette cannot tell the depth of what
//! it hides: depths of upright silhouettes are a guess, unless it is known where the thing stands ([`Expected`]). Cost: 5 to
//! 30 ms an object, more where outlines are blown up.

mod block;
mod expected;
mod flat;
mod inflated;
mod turned;

use glam::{DVec2, DVec3};

pub(crate) use block::InnerEdges;
pub use expected::{Expected, ExpectedBase};

use super::contour;
use super::hidden;
use super::pixels::Pixels;
use super::regions;
use super::silhouette::Silhouette;
use geometry::Camera;
pub use geometry::standing_solid::{Posture, SolidFit, SolidKind};
use imaging::{Image, Mask};

/// Reads the set pixels of a mask as large as the camera's picture; `None` where it is empty or does not
/// meet the table plane. `picture`, as large, shows edges inside the silhouette.
pub fn fit_solid(
    mask: &Mask,
    camera: &Camera,
    picture: Option<&Image>,
    expected: Option<&Expected>,
) -> Option<SolidFit> {
    let (width, height) = (mask.width_px() as usize, mask.height_px() as usize);
    if (mask.width_px(), mask.height_px()) != (camera.width_px, camera.height_px) {
        return None;
    }
    let set: Vec<usize> =
        mask.bits().iter().enumerate().filter(|(_, inside)| **inside).map(|(index, _)| index).collect();
    let edges = picture.map(|picture| InnerEdges::new(&Pixels::new(picture, u32::MAX)));
    fit(&without_holes(&set, width, height), camera, edges.as_ref(), expected, &Surroundings::default())
        .map(|(fit, _)| fit)
}

/// What is around a thing.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Surroundings<'a> {
    /// Where other things may hide it, a flag a pixel of the camera's picture.
    pub in_front: Option<&'a [bool]>,
    /// The top on which it stands, and the share of its distance from the camera at which it really is where that top is
    /// higher than the table.
    pub top: Option<(&'a [DVec2], f64)>,
}

/// As [`fit_solid`], of pixel indices, with the edges inside the silhouette and what else is known of the thing; also the
/// solid's merit: at most 1, and less the less it looks like the thing or agrees with what is known.
pub(crate) fn fit(
    indices: &[usize],
    camera: &Camera,
    edges: Option<&InnerEdges>,
    expected: Option<&Expected>,
    around: &Surroundings,
) -> Option<(SolidFit, f64)> {
    let width = camera.width_px as usize;
    let seen = Seen::new(indices, camera)?;
    let with_side = |indices: &[usize], side: usize| {
        let alone = Silhouette::new(indices, width, side);
        match around.in_front {
            Some(in_front) => alone.behind(in_front, width),
            None => alone,
        }
    };
    let silhouette = |indices: &[usize]| with_side(indices, 48);
    let fine = with_side(indices, flat::FINE_SIDE);
    let whole = silhouette(indices);
    let turned = turned_with_or_without_handle(indices, &seen, &silhouette, camera, expected);
    let block = block::fit(&seen, &whole, camera, edges, expected);
    // Outlines go on across what others take from them.
    let closed = around.in_front.map(|others| hidden::with_what_is_bitten_off(indices, others, width));
    let outlined = closed.as_deref().unwrap_or(indices);
    let flat = flat::lying(&contour::around(outlined, width, 1.2), &fine, camera, expected);
    let footed = flat::with_a_foot(outlined, width);
    let upright = flat::standing(&contour::around(&footed, width, 1.2), &seen, &fine, camera, expected);
    let merit = |(merit, fit): (f64, SolidFit)| {
        let unexpected = expected.map_or(0.0, |e| e.disagreement(fit.center, fit.size.z, camera));
        let doubts = wobble(&fit) + OFF_THE_TOP * share_off_top(&fit, around, camera);
        (merit - unexpected - doubts - inflated::unnatural(&fit), fit)
    };
    let symmetric = 0.06 * seen.mirror_symmetry;
    let candidates = [
        turned.map(|fit| (fit.overlap, fit)),
        block.map(|fit| (fit.overlap - 0.01, fit)),
        flat.clone().map(|(fit, doubt)| (fit.overlap - ANY_OUTLINE - doubt, fit)),
        upright.clone().map(|fit| (fit.overlap - ANY_UPRIGHT + symmetric, fit)),
    ];
    let plain = candidates.into_iter().flatten().map(merit).max_by(|(a, _), (b, _)| a.total_cmp(b));
    let most = plain.as_ref().map_or(f64::NEG_INFINITY, |(merit, _)| *merit);
    let mut best = plain;
    // However well these fitted, their merit would be no more.
    if most < 1.0 - INFLATED.min(INFLATED_UPRIGHT - symmetric) {
        let coarse = with_side(indices, INFLATED_SIDE);
        let lying = flat
            .and_then(|(fit, _)| inflated::lying(&fit, &coarse, camera, expected))
            .map(|(fit, doubt)| (fit.overlap - INFLATED - doubt, fit));
        let standing = upright
            .and_then(|fit| inflated::standing(&fit, &seen, &coarse, camera, expected))
            .map(|fit| (fit.overlap - INFLATED_UPRIGHT + symmetric, fit));
        for (merit, fit) in [lying, standing].into_iter().flatten().map(merit) {
            if best.as_ref().is_none_or(|(most, _)| merit > *most) {
                best = Some((merit, fit));
            }
        }
    }
    best.map(|(merit, fit)| (fit, merit))
}

/// What is taken off the merit of solids that take any outline, which says nothing for them.
const ANY_OUTLINE: f64 = 0.14;
const ANY_UPRIGHT: f64 = 0.26;
const INFLATED: f64 = 0.14;
const INFLATED_UPRIGHT: f64 = 0.2;
/// Cells along the longer side of the silhouette against which outlines are held as they are blown up.
const INFLATED_SIDE: usize = 128;
/// Least ratio of half the width of a foot to the height of the middle above it.
const LEAST_FOOT: f64 = 0.12;
/// What is taken off the merit of a solid on a point.
const ON_A_POINT: f64 = 0.15;
/// And of one all of whose foot lies beside the top.
const OFF_THE_TOP: f64 = 0.3;

/// Doubt about a solid that could hardly stand: what is seen standing has a foot.
fn wobble(fit: &SolidFit) -> f64 {
    let foot = match &fit.kind {
        SolidKind::Turned { profile } => profile.first().map_or(0.0, |p| p.x),
        SolidKind::Block => 0.5 * fit.size.x.min(fit.size.y),
        SolidKind::Upright { .. } => 0.5 * fit.size.y,
        // Blown up, it has a foot of its own.
        SolidKind::Inflated { posture: Posture::Standing, .. } => 0.3 * fit.size.y,
        SolidKind::Flat { .. } | SolidKind::Inflated { posture: Posture::Lying, .. } => return 0.0,
    };
    let ratio = foot / (0.5 * fit.size.z).max(1e-9);
    ON_A_POINT * (1.0 - ratio / LEAST_FOOT).max(0.0)
}

/// Share of a footprint's corners that lie beside the top.
fn share_off_top(fit: &SolidFit, around: &Surroundings, camera: &Camera) -> f64 {
    let Some((top, nearer)) = around.top else { return 0.0 };
    let eye = camera.world_from_camera.translation_m.truncate();
    let corners = fit.footprint();
    let off = corners.iter().filter(|p| !super::polygon::encloses(top, eye + nearer * (**p - eye))).count();
    off as f64 / corners.len().max(1) as f64
}

/// Handles and spouts spoil the outline of a turned body: what is left without thin parts may fit better.
fn turned_with_or_without_handle(
    indices: &[usize],
    seen: &Seen,
    silhouette: &impl Fn(&[usize]) -> Silhouette,
    camera: &Camera,
    expected: Option<&Expected>,
) -> Option<SolidFit> {
    let whole = turned::fit(seen, &silhouette(indices), camera, expected)?;
    if whole.overlap > 0.9 {
        return Some(whole);
    }
    let (width, height) = (camera.width_px as usize, camera.height_px as usize);
    let extent = seen.high_px - seen.low_px;
    let mut bits = vec![false; width * height];
    indices.iter().for_each(|&index| bits[index] = true);
    let core = regions::opened(&bits, width, height, (0.18 * extent.min_element()) as f32);
    let core: Vec<usize> = (0..core.len()).filter(|&index| core[index]).collect();
    let without = Seen::new(&core, camera)
        .and_then(|seen| turned::fit(&seen, &silhouette(&core), camera, expected))
        .map(|fit| SolidFit { overlap: fit.overlap * core.len() as f64 / indices.len() as f64, ..fit })
        .filter(|fit| fit.overlap > whole.overlap);
    Some(without.unwrap_or(whole))
}

/// First measures of a silhouette.
pub(crate) struct Seen {
    /// Where its lowest pixels meet the table, and the unit direction away from the camera there.
    pub contact: DVec2,
    pub away: DVec2,
    /// Column of the contact.
    pub contact_px_x: f64,
    /// Box in pixels.
    pub low_px: DVec2,
    pub high_px: DVec2,
    /// Tangent of the angle under which the contact is looked down upon.
    pub steepness: f64,
    /// Height of an upright line over the contact that ends at the top row.
    pub rise: f64,
    /// Length on the table plane at the contact per pixel, across the view.
    pub unit_per_px: f64,
    /// Overlap with its own left-right mirror image, 0..1.
    pub mirror_symmetry: f64,
}

impl Seen {
    fn new(indices: &[usize], camera: &Camera) -> Option<Self> {
        let width = camera.width_px as usize;
        let place = |index: &usize| DVec2::new((index % width) as f64 + 0.5, (index / width) as f64 + 0.5);
        let first = place(indices.first()?);
        let (low, high) = indices.iter().map(place).fold((first, first), |(l, h), p| (l.min(p), h.max(p)));
        let (low_px, high_px) = (low - 0.5, high + 0.5);
        let lowest: Vec<f64> =
            indices.iter().map(place).filter(|p| p.y > high.y - 2.5).map(|p| p.x).collect();
        let middle = lowest.iter().sum::<f64>() / lowest.len().max(1) as f64;
        let contact = camera.meet_plane(DVec2::new(middle, high_px.y), 0.0)?;
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
            contact_px_x: middle,
            low_px,
            high_px,
            unit_per_px: depth / camera.fx,
            mirror_symmetry: both / (2.0 * indices.len() as f64 - both).max(1.0),
        };
        seen.rise = seen.height_over(seen.contact, camera);
        Some(seen)
    }

    /// The point `across` to the right of the contact and `beyond` it.
    pub fn place(&self, across: f64, beyond: f64) -> DVec2 {
        self.contact + across * DVec2::new(self.away.y, -self.away.x) + beyond * self.away
    }

    /// How far across and beyond the contact a point of the table lies: what [`Self::place`] takes.
    pub fn beside_contact(&self, point: DVec2) -> DVec2 {
        let apart = point - self.contact;
        DVec2::new(apart.dot(DVec2::new(self.away.y, -self.away.x)), apart.dot(self.away))
    }

    /// Height at which an upright line through `base` ends at the silhouette's top row.
    fn height_over(&self, base: DVec2, camera: &Camera) -> f64 {
        let (mut low, mut high) = (0.0, 4.0);
        for _ in 0..40 {
            let middle = 0.5 * (low + high);
            match camera.project(base.extend(middle)) {
                Some((p, _)) if p.y > self.low_px.y => low = middle,
                _ => high = middle,
            }
        }
        low
    }
}

/// Convex outline of projected points; empty where one lies behind the camera.
fn projected_hull(camera: &Camera, points: impl Iterator<Item = DVec3>) -> Vec<DVec2> {
    let projected: Option<Vec<DVec2>> = points.map(|p| camera.project(p).map(|(pixel, _)| pixel)).collect();
    projected.map(|points| super::polygon::convex_hull(&points)).unwrap_or_default()
}

/// The set pixels without holes, as indices.
pub(crate) fn without_holes(indices: &[usize], width: usize, height: usize) -> Vec<usize> {
    let mut bits = vec![false; width * height];
    indices.iter().for_each(|&index| bits[index] = true);
    let bits = regions::filled(&bits, width, height, usize::MAX);
    (0..bits.len()).filter(|&index| bits[index]).collect()
}
