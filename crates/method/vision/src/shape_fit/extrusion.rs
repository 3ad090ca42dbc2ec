//! Extrusion fit: outlines lying on the table, or upright as seen.

use glam::{DVec2, DVec3};

use super::{PosedPrimitive, PrimitiveKind, ShapePrior, SilhouetteMeasures};
use crate::polygon::convex_hull;
use crate::silhouette::Silhouette;
use geometry::{Camera, Outline};

/// Cells along the longer side of the silhouette for prisms: walls of thin ones are narrow.
pub(super) const FINE_SIDE: usize = 192;
/// Candidate thicknesses of a lying extrusion, as shares of the expected height.
const THICKNESSES: [f64; 4] = [1.0, 0.6, 0.35, 0.2];
/// Candidate depths of an upright extrusion, as shares of the expected reach.
const DEPTHS: [f64; 3] = [1.0, 0.6, 0.35];
/// Default thickness of a lying extrusion, as a share of its narrower side.
const FLAT_THICKNESS: f64 = 0.15;
/// Default depth of an upright extrusion, as a share of its width.
const UPRIGHT_DEPTH: f64 = 0.45;
/// Height of a foot, as a share of the whole.
const FOOT: f64 = 0.05;
/// Minimum depth of an upright extrusion, as a share of its height; less is unstable.
const MIN_DEPTH: f64 = 0.14;

/// The silhouette as a thin extrusion on the table, and its stretch penalty.
pub(super) fn lying(
    outline_px: &[DVec2],
    silhouette: &Silhouette,
    camera: &Camera,
    expected: Option<&ShapePrior>,
) -> Option<(PosedPrimitive, f64)> {
    let fits = match expected {
        // The side walls of a thick slab exceed the silhouette; predicted heights of thin objects are unreliable.
        Some(expected) => THICKNESSES
            .iter()
            .filter_map(|share| slab(outline_px, silhouette, camera, share * expected.height))
            .collect::<Vec<_>>(),
        None => {
            let rough = slab(outline_px, silhouette, camera, 0.0)?;
            let thickness = FLAT_THICKNESS * rough.size.truncate().min_element();
            slab(outline_px, silhouette, camera, thickness).into_iter().collect()
        }
    };
    let unexpected =
        |fit: &PosedPrimitive| expected.map_or(0.0, |e| e.disagreement(fit.center, fit.size.z, camera));
    let merit = |fit: &PosedPrimitive| fit.overlap - unexpected(fit);
    let fit = fits.into_iter().max_by(|a, b| merit(a).total_cmp(&merit(b)))?;
    let doubt = stretch_doubt(&fit, camera);
    Some((fit, doubt))
}

/// Penalty of a lying outline stretched away from the camera: it probably stands.
pub(super) fn stretch_doubt(fit: &PosedPrimitive, camera: &Camera) -> f64 {
    let eye = camera.world_from_camera.translation_m.truncate();
    let away = (fit.center - eye).normalize_or(DVec2::Y);
    let corners = fit.footprint();
    let spread = |axis: DVec2| {
        let along = corners.iter().map(|p| axis.dot(*p));
        let (low, high) = along.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(v), h.max(v)));
        high - low
    };
    let stretch = spread(away) / spread(away.perp()).max(1e-9);
    (0.12 * (stretch - 0.9)).clamp(0.0, 0.3)
}

/// The outline on the plane at half the thickness, as a slab of that thickness.
fn slab(
    outline_px: &[DVec2],
    silhouette: &Silhouette,
    camera: &Camera,
    thickness: f64,
) -> Option<PosedPrimitive> {
    // Most of the visible surface of a lying object is its upper face.
    let on_table: Option<Vec<DVec2>> =
        outline_px.iter().map(|p| camera.meet_plane(*p, 0.5 * thickness).map(|q| q.truncate())).collect();
    let on_table = Outline::new(on_table?).ok()?;
    let (yaw_rad, center, extent) = smallest_box(on_table.corners())?;
    let face = |height: f64| on_table.corners().iter().map(move |p| p.extend(height));
    let overlap = swept_overlap(silhouette, camera, face(0.0), face(thickness))?;
    let turned = |p: &DVec2| DVec2::from_angle(-yaw_rad).rotate(*p - center);
    let outline = on_table.corners().iter().map(turned).collect();
    let size = extent.extend(thickness);
    Some(PosedPrimitive { kind: PrimitiveKind::Flat { outline }, center, yaw_rad, size, overlap })
}

/// Overlap of a prism between two faces of equal corners with the silhouette; `None` if a corner lies behind the
/// camera.
fn swept_overlap(
    silhouette: &Silhouette,
    camera: &Camera,
    one: impl Iterator<Item = DVec3>,
    other: impl Iterator<Item = DVec3>,
) -> Option<f64> {
    let projected = |p: DVec3| camera.project(p).map(|(pixel, _)| pixel);
    let one: Vec<DVec2> = one.map(projected).collect::<Option<_>>()?;
    let other: Vec<DVec2> = other.map(projected).collect::<Option<_>>()?;
    let sides = (0..one.len()).map(|k| (k, (k + 1) % one.len()));
    let mut parts: Vec<Vec<DVec2>> = sides.map(|(k, l)| vec![one[k], one[l], other[l], other[k]]).collect();
    parts.extend([one, other]);
    Some(silhouette.overlap_of_polygons(&parts))
}

/// The pixels with a level foot: the lowest rows get their common width and extend below the centroid. Standing
/// objects have a foot; pixel outlines end in a tip.
pub(super) fn with_level_foot(indices: &[usize], width: usize) -> Vec<usize> {
    let rows = indices.iter().map(|index| index / width);
    let (Some(top), Some(bottom)) = (rows.clone().min(), rows.max()) else { return Vec::new() };
    let height = bottom + 1 - top;
    let first = bottom + 1 - ((FOOT * height as f64).ceil() as usize).max(2).min(height);
    let columns =
        |from: usize| indices.iter().filter(move |&&index| index / width >= from).map(|index| index % width);
    let span = |from: usize| columns(from).min().zip(columns(from).max());
    let (Some((all_left, all_right)), Some((left, right))) = (span(top), span(first)) else {
        return Vec::new();
    };
    let midpoint = columns(top).sum::<usize>() / indices.len();
    let reach = ((all_right - all_left) / 10).max(height / 10) + 1;
    let (left, right) =
        (left.min(midpoint.saturating_sub(reach)), right.max((midpoint + reach).min(width - 1)));
    let foot = (first..=bottom).flat_map(|y| (left..=right).map(move |x| y * width + x));
    let mut all: Vec<usize> = indices.iter().copied().chain(foot).collect();
    all.sort_unstable();
    all.dedup();
    all
}

/// The silhouette as an extrusion of the upright plane that faces the camera at the contact.
pub(super) fn standing(
    outline_px: &[DVec2],
    seen: &SilhouetteMeasures,
    silhouette: &Silhouette,
    camera: &Camera,
    expected: Option<&ShapePrior>,
) -> Option<PosedPrimitive> {
    let eye = camera.world_from_camera.translation_m;
    let normal = seen.away.extend(0.0);
    let right = DVec2::new(seen.away.y, -seen.away.x);
    let on_plane: Option<Vec<DVec2>> = outline_px
        .iter()
        .map(|p| {
            let direction = camera.ray_direction_in_world(*p);
            let t = (seen.contact.extend(0.0) - eye).dot(normal) / direction.dot(normal);
            let met = eye + t * direction;
            (t > 0.0).then(|| DVec2::new((met.truncate() - seen.contact).dot(right), met.z.max(0.0)))
        })
        .collect();
    let outline = Outline::new(on_plane?).ok()?;
    let (low, high) = outline.bounds();
    let (width, height) = (high.x - low.x, high.y - low.y);
    if width <= 0.0 || height <= 0.0 {
        return None;
    }
    let reach = expected.and_then(|e| e.base(camera)).map(|base| 2.0 * seen.beside_contact(base).y);
    let deepest =
        reach.map_or(UPRIGHT_DEPTH * width.min(height), |reach| reach.clamp(0.1 * width, 2.0 * width));
    let midpoint = 0.5 * (low.x + high.x);
    let moved: Vec<DVec2> =
        outline.corners().iter().map(|p| DVec2::new(p.x - midpoint, p.y - low.y)).collect();
    let of_depth = |share: &f64| {
        let depth = (share * deepest).max(MIN_DEPTH * height);
        let face = |beyond: f64| {
            let place = move |p: &DVec2| (seen.contact + p.x * right + beyond * seen.away).extend(p.y);
            outline.corners().iter().map(place)
        };
        let overlap = swept_overlap(silhouette, camera, face(0.0), face(depth))?;
        Some(PosedPrimitive {
            kind: PrimitiveKind::Upright { outline: moved.clone() },
            center: seen.contact + midpoint * right + 0.5 * depth * seen.away,
            yaw_rad: right.y.atan2(right.x),
            size: DVec3::new(width, depth, height),
            overlap,
        })
    };
    let merit = |fit: &PosedPrimitive| {
        fit.overlap - expected.map_or(0.0, |e| e.disagreement(fit.center, fit.size.z, camera))
    };
    DEPTHS.iter().filter_map(of_depth).max_by(|a, b| merit(a).total_cmp(&merit(b)))
}

/// Yaw, center and extents of the minimum-area rectangle of points (one side lies on a side of their hull).
pub(super) fn smallest_box(points: &[DVec2]) -> Option<(f64, DVec2, DVec2)> {
    let hull = convex_hull(points);
    (0..hull.len())
        .map(|k| {
            let along = hull[(k + 1) % hull.len()] - hull[k];
            let mut yaw = along.y.atan2(along.x);
            // The equivalent yaw nearest to the world's axes.
            yaw -= (yaw / std::f64::consts::FRAC_PI_2).round() * std::f64::consts::FRAC_PI_2;
            let turned = hull.iter().map(|p| DVec2::from_angle(-yaw).rotate(*p));
            let (low, high) =
                turned.fold((DVec2::INFINITY, DVec2::NEG_INFINITY), |(l, h), p| (l.min(p), h.max(p)));
            (yaw, DVec2::from_angle(yaw).rotate(0.5 * (low + high)), high - low)
        })
        .min_by(|a, b| a.2.element_product().total_cmp(&b.2.element_product()))
        .filter(|found| found.2.min_element() > 0.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::polygon::encloses;

    #[test]
    fn lying_extrusion_recovers_small_thickness() {
        let target = DVec3::new(0.0, 0.0, 0.0);
        let camera = Camera::orbit(640, 480, 0.6, target, 0.0, 0.6, 2.0);
        // A rod of 300 x 16 x 10 mm, with a prior height four times too large.
        let half = DVec3::new(0.15, 0.008, 0.01);
        let corners = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)];
        let all =
            corners.iter().flat_map(|(x, y)| [0.0, half.z].map(|z| DVec3::new(x * half.x, y * half.y, z)));
        let seen: Vec<DVec2> = all.filter_map(|p| camera.project(p)).map(|(pixel, _)| pixel).collect();
        let hull = convex_hull(&seen);
        let indices: Vec<usize> = (0..640 * 480)
            .filter(|k| encloses(&hull, DVec2::new((k % 640) as f64 + 0.5, (k / 640) as f64 + 0.5)))
            .collect();
        let silhouette = Silhouette::new(&indices, 640, FINE_SIDE);
        let outline = crate::contour::trace(&indices, 640, 1.2);
        let expected =
            ShapePrior { base: None, height: 0.04, log_height_sigma: ShapePrior::LOG_HEIGHT_SIGMA };
        let (fit, _) = lying(&outline, &silhouette, &camera, Some(&expected)).expect("lies on the table");
        assert!(fit.size.z < 0.015 && (fit.size.x - 0.3).abs() < 0.01, "{:?}", fit.size);
    }

    #[test]
    fn level_foot_extends_below_centroid() {
        // A post of 2 x 40 pixels that carries a bar of 30 x 10 to its right.
        let mut indices: Vec<usize> = (10..50).flat_map(|y| (20..22).map(move |x| y * 100 + x)).collect();
        indices.extend((10..20).flat_map(|y| (22..50).map(move |x| y * 100 + x)));
        indices.sort_unstable();
        let footed = with_level_foot(&indices, 100);
        let midpoint = indices.iter().map(|index| index % 100).sum::<usize>() / indices.len();
        let lowest: Vec<usize> = footed.iter().filter(|&&k| k / 100 == 49).map(|k| k % 100).collect();
        assert!(lowest.first() <= Some(&20) && lowest.last() > Some(&midpoint), "{midpoint} {lowest:?}");
        assert!(footed.iter().all(|k| indices.binary_search(k).is_ok() || k / 100 >= 48));
    }
}
