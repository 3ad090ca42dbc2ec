//! Things that no simple body fits: lying flat, or standing as they are seen.

use glam::{DVec2, DVec3};

use super::{Expected, Seen, SolidFit, SolidKind};
use crate::geometry::{Camera, Outline};
use crate::vision::polygon::convex_hull;

/// Thickness of a flat thing as a share of its narrower side.
const FLAT_THICKNESS: f64 = 0.15;
/// Depth of an upright silhouette as a share of its width.
const UPRIGHT_DEPTH: f64 = 0.45;

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
