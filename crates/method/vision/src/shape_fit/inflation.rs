//! Inflation fit: reconstructs rounded shapes from one silhouette (Igarashi et al. 1999), lying or upright.
//!
//! The initial outlines are those of the lying and the upright extrusion. A rounded object shows less of its
//! outline than a flat one, and more of its back. So position, scale of the outline and thickness are refined by
//! pattern search on the overlap of the projected body with the mask. The inflated surface is computed once and
//! scaled.

use glam::{DVec2, DVec3};

use super::extrusion::{smallest_box, stretch_doubt};
use super::{PosedPrimitive, PrimitiveKind, ShapePrior, SilhouetteMeasures};
use crate::silhouette::Silhouette;
use geometry::Camera;
use geometry::optimize::pattern_search;
use geometry::posed_primitive::Posture;
use geometry::shapes::Inflation;

/// Cells of the inflation grid for the fit.
const SQUARES: u32 = 150;
/// Initial thicknesses, as shares of the natural one.
const THICKNESSES: [f64; 2] = [1.0, 0.6];
/// Halvings of the search steps.
const HALVINGS: u32 = 3;
/// Weight of the squared logarithm of thickness over the natural one: rounded objects are about as thick as wide.
const THICKNESS_WEIGHT: f64 = 0.03;

/// Inflation of a lying extrusion, and its stretch penalty.
pub(super) fn lying(
    flat: &PosedPrimitive,
    silhouette: &Silhouette,
    camera: &Camera,
    expected: Option<&ShapePrior>,
) -> Option<(PosedPrimitive, f64)> {
    let PrimitiveKind::Flat { outline } = &flat.kind else { return None };
    let eye = camera.world_from_camera.translation_m;
    let away = (flat.center - eye.truncate()).normalize_or(DVec2::Y);
    // x is across the view, y away from the camera, as `away.perp()` points left.
    let right = -away.perp();
    let to_view = |p: DVec2| DVec2::new(p.dot(right), p.dot(away));
    let turned = DVec2::from_angle(flat.yaw_rad);
    let in_view: Vec<DVec2> = outline.iter().map(|p| to_view(turned.rotate(*p))).collect();
    let body = Inflation::new(&in_view, Posture::Lying, SQUARES)?;
    let frame = Frame { center: flat.center, right, away };
    let natural = body.natural_thickness();
    let start = |thickness: f64| {
        // A rounded object appears longer along the view, as its thickness hides the table behind it.
        let (low, high) = span(in_view.iter().map(|p| p.y));
        let slant = (eye.z / (flat.center - eye.truncate()).length().max(1e-9)).atan().sin().max(0.1);
        let shorter = 1.0 - 0.7 * thickness * (1.0 / slant - 1.0) / (high - low).max(1e-9);
        [0.0, 0.0, 0.0, shorter.clamp(0.4, 1.0).ln(), (thickness / natural).ln()]
    };
    let (center_of, fit) =
        best(&body, natural, &frame, silhouette, camera, expected, start, |q, thickness| {
            DVec3::new(q[2].exp(), q[3].exp(), thickness)
        })?;
    let Fitted { scale, overlap } = fit;
    let on_table: Vec<DVec2> =
        in_view.iter().map(|p| center_of + scale.x * p.x * right + scale.y * p.y * away).collect();
    let (yaw_rad, center, extent) = smallest_box(&on_table)?;
    let outline = on_table.iter().map(|p| DVec2::from_angle(-yaw_rad).rotate(*p - center)).collect();
    let kind = PrimitiveKind::Inflated { outline, posture: Posture::Lying };
    let fit = PosedPrimitive { kind, center, yaw_rad, size: extent.extend(scale.z), overlap };
    let doubt = stretch_doubt(&fit, camera);
    Some((fit, doubt))
}

/// Inflation of an upright extrusion.
pub(super) fn standing(
    upright: &PosedPrimitive,
    seen: &SilhouetteMeasures,
    silhouette: &Silhouette,
    camera: &Camera,
    expected: Option<&ShapePrior>,
) -> Option<PosedPrimitive> {
    let PrimitiveKind::Upright { outline } = &upright.kind else { return None };
    let body = Inflation::new(outline, Posture::Standing, SQUARES)?;
    let right = DVec2::new(seen.away.y, -seen.away.x);
    let natural = body.natural_thickness();
    let beyond = expected.and_then(|e| e.base(camera)).map(|base| seen.beside_contact(base).y);
    let midpoint = seen.beside_contact(upright.center).x;
    let frame = Frame { center: seen.place(midpoint, 0.0), right, away: seen.away };
    let start = |thickness: f64| {
        let beyond = beyond.unwrap_or(0.3 * thickness);
        // An object farther back is larger, and begins lower than its outline at the contact plane.
        let lower = (beyond * seen.steepness).min(0.5 * upright.size.z);
        [
            0.0,
            beyond,
            0.0,
            ((upright.size.z - lower) / upright.size.z.max(1e-9)).ln(),
            (thickness / natural).ln(),
        ]
    };
    let (center, fit) = best(&body, natural, &frame, silhouette, camera, expected, start, |q, thickness| {
        DVec3::new(q[2].exp(), thickness, q[3].exp())
    })?;
    let Fitted { scale, overlap } = fit;
    let outline: Vec<DVec2> = outline.iter().map(|p| DVec2::new(scale.x, scale.z) * *p).collect();
    let (low, high) = span(outline.iter().map(|p| p.y));
    let (left, highest) = span(outline.iter().map(|p| p.x));
    Some(PosedPrimitive {
        kind: PrimitiveKind::Inflated { outline, posture: Posture::Standing },
        center,
        yaw_rad: right.y.atan2(right.x),
        size: DVec3::new(highest - left, scale.y, high - low),
        overlap,
    })
}

/// A point on the table, and the directions across the view and away from the camera there.
struct Frame {
    center: DVec2,
    right: DVec2,
    away: DVec2,
}

/// Refined factors of the outline's two axes, with the thickness as third component.
struct Fitted {
    scale: DVec3,
    overlap: f64,
}

/// Best position and scale of a body. Parameters: across and beyond the frame's center, logarithms of the factors
/// of the outline's axes, and of thickness over the natural one.
#[expect(clippy::too_many_arguments, reason = "two postures share one climb")]
fn best(
    body: &Inflation,
    natural: f64,
    frame: &Frame,
    silhouette: &Silhouette,
    camera: &Camera,
    expected: Option<&ShapePrior>,
    start: impl Fn(f64) -> [f64; 5],
    scaled: impl Fn(&[f64; 5], f64) -> DVec3,
) -> Option<(DVec2, Fitted)> {
    // The thickness is scaled along the axis in which it is 1.
    let (positions, triangles) = body.shell(1.0);
    let place = |q: &[f64; 5]| frame.center + q[0] * frame.right + q[1] * frame.away;
    let overlap = |q: &[f64; 5]| {
        let (center, scale) = (place(q), scaled(q, natural * q[4].exp()));
        let pixels: Option<Vec<DVec2>> = positions
            .iter()
            .map(|p| {
                let p = scale * *p;
                let at = center + p.x * frame.right + p.y * frame.away;
                camera.project(at.extend(p.z)).map(|(pixel, _)| pixel)
            })
            .collect();
        pixels.map_or(-1.0, |pixels| silhouette.overlap_of_triangles(&pixels, &triangles))
    };
    let height = positions.iter().map(|p| p.z).fold(0.0, f64::max);
    let score = |q: &[f64; 5]| {
        let height = height * scaled(q, natural * q[4].exp()).z;
        let unexpected = expected.map_or(0.0, |e| e.disagreement(place(q), height, camera));
        overlap(q) - unexpected - THICKNESS_WEIGHT * q[4].powi(2)
    };
    let step = 0.3 * natural;
    let refined = THICKNESSES
        .map(|share| pattern_search(start(share * natural), [step, step, 0.12, 0.12, 0.3], HALVINGS, score));
    let (q, score) = refined.into_iter().max_by(|a, b| a.1.total_cmp(&b.1))?;
    (score > 0.0)
        .then(|| (place(&q), Fitted { scale: scaled(&q, natural * q[4].exp()), overlap: overlap(&q) }))
}

fn span(values: impl Iterator<Item = f64>) -> (f64, f64) {
    values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| (low.min(v), high.max(v)))
}

/// Penalty of a thickness far from the natural one of the outline; 0 for other kinds.
pub(super) fn thickness_penalty(fit: &PosedPrimitive) -> f64 {
    let PrimitiveKind::Inflated { outline, posture } = &fit.kind else { return 0.0 };
    let thickness = match posture {
        Posture::Lying => fit.size.z,
        Posture::Standing => fit.size.y,
    };
    let natural =
        Inflation::new(outline, *posture, SQUARES).map_or(thickness, |body| body.natural_thickness());
    THICKNESS_WEIGHT * (thickness / natural).ln().powi(2)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contour;
    use crate::shape_fit::extrusion;
    use geometry::shapes::{ellipse, smooth};

    /// Pixels that show the triangles.
    fn shown(camera: &Camera, positions: &[DVec3], triangles: &[[u32; 3]]) -> Vec<usize> {
        let pixels: Vec<DVec2> =
            positions.iter().filter_map(|p| camera.project(*p)).map(|(pixel, _)| pixel).collect();
        let mut set = std::collections::BTreeSet::new();
        for t in triangles {
            let corners = t.map(|v| pixels[v as usize]);
            let hull = crate::polygon::convex_hull(&corners);
            let (low, high) =
                (corners[0].min(corners[1]).min(corners[2]), corners[0].max(corners[1]).max(corners[2]));
            for y in low.y as usize..=high.y as usize {
                for x in low.x as usize..=high.x as usize {
                    if crate::polygon::contains(&hull, DVec2::new(x as f64 + 0.5, y as f64 + 0.5)) {
                        set.insert(y * camera.width_px as usize + x);
                    }
                }
            }
        }
        set.into_iter().collect()
    }

    fn seen_as(camera: &Camera, indices: &[usize], height: f64) -> (PosedPrimitive, PosedPrimitive) {
        let seen = SilhouetteMeasures::new(indices, camera).expect("seen");
        let fine = Silhouette::new(indices, camera.width_px as usize, extrusion::FINE_SIDE);
        let expected = ShapePrior { base: None, height, log_height_sigma: ShapePrior::LOG_HEIGHT_SIGMA };
        let outline = contour::trace(indices, camera.width_px as usize, 1.2);
        let (flat, _) = extrusion::lying(&outline, &fine, camera, Some(&expected)).expect("flat");
        let (lies, _) = lying(&flat, &fine, camera, Some(&expected)).expect("lies");
        let upright = extrusion::standing(&outline, &seen, &fine, camera, Some(&expected)).expect("upright");
        let stands = standing(&upright, &seen, &fine, camera, Some(&expected)).expect("stands");
        (lies, stands)
    }

    #[test]
    fn lying_inflation_recovers_position_and_thickness() {
        let camera = Camera::orbit(640, 480, 0.5, DVec3::ZERO, 0.0, 0.6, 1.2);
        let size = DVec3::new(0.2, 0.04, 0.036);
        let turned = DVec2::from_angle(0.5);
        let body =
            Inflation::new(&ellipse(size.x, size.y, 48), Posture::Lying, 700).expect("encloses").solid(size);
        let placed: Vec<DVec3> =
            body.positions.iter().map(|p| turned.rotate(p.truncate()).extend(p.z)).collect();
        let indices = shown(&camera, &placed, &body.triangles);
        let (lies, _) = seen_as(&camera, &indices, 0.036);
        assert!(lies.overlap > 0.88, "{}", lies.overlap);
        assert!(lies.center.length() < 0.008 && (lies.size.z / size.z - 1.0).abs() < 0.25, "{lies:?}");
        assert!(
            (lies.size.x / size.x - 1.0).abs() < 0.1 && (lies.size.y / size.y - 1.0).abs() < 0.45,
            "{:?}",
            lies.size
        );
    }

    #[test]
    fn upright_inflation_recovers_height() {
        let camera = Camera::orbit(640, 480, 0.5, DVec3::new(0.0, 0.0, 0.05), 0.0, 0.45, 1.2);
        let half = [(0.03, 0.0), (0.055, 0.03), (0.03, 0.075), (0.04, 0.11), (0.0, 0.14)];
        let right = half.map(|(x, z)| DVec2::new(x, z));
        let corners: Vec<DVec2> =
            right.into_iter().chain(half.iter().rev().skip(1).map(|(x, z)| DVec2::new(-x, *z))).collect();
        let size = DVec3::new(0.11, 0.07, 0.14);
        let body =
            Inflation::new(&smooth(&corners, 4), Posture::Standing, 700).expect("encloses").solid(size);
        let indices = shown(&camera, &body.positions, &body.triangles);
        let (_, stands) = seen_as(&camera, &indices, 0.14);
        assert!(stands.overlap > 0.92, "{}", stands.overlap);
        assert!((stands.size.z / size.z - 1.0).abs() < 0.15 && stands.center.length() < 0.02, "{stands:?}");
    }
}
