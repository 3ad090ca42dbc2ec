//! Things that no simple body fits: lying flat, or standing as they are seen.

use glam::{DVec2, DVec3};

use super::{Expected, Seen, SolidFit, SolidKind};
use crate::geometry::{Camera, Outline};
use crate::vision::polygon::convex_hull;

/// Thickness of a flat thing as a share of its narrower side.
const FLAT_THICKNESS: f64 = 0.15;
/// Depth of an upright silhouette as a share of its width.
const UPRIGHT_DEPTH: f64 = 0.45;
/// Height of a foot as a share of the whole.
const FOOT: f64 = 0.05;
/// Least depth of an upright silhouette, a share of its height: less does not stand.
const LEAST_DEPTH: f64 = 0.14;

/// The silhouette as the outline of a thin thing on the table, and how doubtful that is: things seem to
/// stretch away from the camera where they really stand.
pub(super) fn lying(
    outline_px: &[DVec2],
    camera: &Camera,
    expected: Option<&Expected>,
) -> Option<(SolidFit, f64)> {
    // Most of what shows of a thing that lies is its upper face.
    let upper = expected.map_or(0.0, |expected| 0.5 * expected.height);
    let on_table: Option<Vec<DVec2>> =
        outline_px.iter().map(|p| camera.meet_plane(*p, upper).map(|q| q.truncate())).collect();
    let on_table = Outline::new(on_table?).ok()?;
    let (yaw_rad, center, extent) = smallest_box(on_table.corners())?;
    let eye = camera.world_from_camera.translation_m.truncate();
    let away = (center - eye).normalize_or(DVec2::Y);
    let spread = |axis: DVec2| {
        let along = on_table.corners().iter().map(|p| axis.dot(*p));
        let (low, high) = along.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(v), h.max(v)));
        high - low
    };
    let stretch = spread(away) / spread(away.perp()).max(1e-9);
    let doubt = (0.12 * (stretch - 0.9)).clamp(0.0, 0.3);
    let outline = on_table
        .corners()
        .iter()
        .map(|p| DVec2::from_angle(-yaw_rad).rotate(*p - center))
        .collect::<Vec<_>>();
    let height = expected.map_or(FLAT_THICKNESS * extent.min_element(), |expected| expected.height);
    let fit = SolidFit {
        kind: SolidKind::Flat { outline },
        center,
        yaw_rad,
        size: extent.extend(height),
        overlap: 1.0,
    };
    Some((fit, doubt))
}

/// The pixels with a level foot: the lowest rows become as wide as they are together, and reach under the middle of all.
/// A thing that is seen standing has one; outlines of pixels end in a tip on which nothing stands.
pub(super) fn with_a_foot(indices: &[usize], width: usize) -> Vec<usize> {
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
    let middle = columns(top).sum::<usize>() / indices.len();
    let reach = (all_right - all_left) / 10 + 1;
    let (left, right) = (left.min(middle.saturating_sub(reach)), right.max((middle + reach).min(width - 1)));
    let foot = (first..=bottom).flat_map(|y| (left..=right).map(move |x| y * width + x));
    let mut all: Vec<usize> = indices.iter().copied().chain(foot).collect();
    all.sort_unstable();
    all.dedup();
    all
}

/// The silhouette on an upright plane that faces the camera at the contact.
pub(super) fn standing(
    outline_px: &[DVec2],
    seen: &Seen,
    camera: &Camera,
    expected: Option<&Expected>,
) -> Option<SolidFit> {
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
    let depth =
        reach.map_or(UPRIGHT_DEPTH * width.min(height), |reach| reach.clamp(0.1 * width, 2.0 * width));
    let depth = depth.max(LEAST_DEPTH * height);
    let middle = 0.5 * (low.x + high.x);
    let moved = outline.corners().iter().map(|p| DVec2::new(p.x - middle, p.y - low.y)).collect();
    Some(SolidFit {
        kind: SolidKind::Upright { outline: moved },
        center: seen.contact + middle * right + 0.5 * depth * seen.away,
        yaw_rad: right.y.atan2(right.x),
        size: DVec3::new(width, depth, height),
        overlap: 1.0,
    })
}

/// Turn, center and extents of the smallest box around points (one side lies on a side of their hull).
fn smallest_box(points: &[DVec2]) -> Option<(f64, DVec2, DVec2)> {
    let hull = convex_hull(points);
    (0..hull.len())
        .map(|k| {
            let along = hull[(k + 1) % hull.len()] - hull[k];
            let mut yaw = along.y.atan2(along.x);
            // The nearest turn to the world's axes.
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

    #[test]
    fn what_leans_over_gets_a_foot_under_its_middle() {
        // A post of 2 x 40 pixels that carries a bar of 30 x 10 to its right.
        let mut indices: Vec<usize> = (10..50).flat_map(|y| (20..22).map(move |x| y * 100 + x)).collect();
        indices.extend((10..20).flat_map(|y| (22..50).map(move |x| y * 100 + x)));
        indices.sort_unstable();
        let footed = with_a_foot(&indices, 100);
        let middle = indices.iter().map(|index| index % 100).sum::<usize>() / indices.len();
        let lowest: Vec<usize> = footed.iter().filter(|&&k| k / 100 == 49).map(|k| k % 100).collect();
        assert!(lowest.first() == Some(&20) && lowest.last() >= Some(&middle), "{middle} {lowest:?}");
        assert!(footed.iter().all(|k| indices.binary_search(k).is_ok() || k / 100 >= 48));
    }
}
