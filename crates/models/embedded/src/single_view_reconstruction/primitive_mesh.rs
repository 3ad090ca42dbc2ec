//! Mesh and silhouette of a fitted primitive.

use glam::{DQuat, DVec2, DVec3};

use geometry::shapes::{Inflation, block, lathe, prism};
use geometry::{Camera, Pose, Solid};
use imaging::Mask;
use scene::ReconstructionMethod;
use vision::{PosedPrimitive, PrimitiveKind};

/// Segments of a solid of revolution.
const AROUND: usize = 48;
/// A turned body may be tipped by at least this angle before it falls, radians (8 degrees).
const STEADY_RAD: f64 = 0.14;
/// Height of a foot that is added, share of the body's.
const FOOT_SHARE: f64 = 0.03;
/// Cells of the inflation grid: about four triangles each.
const SQUARES: u32 = 700;

/// The closed mesh in its own frame, base on z = 0, and its method. A box replaces a self-intersecting outline
/// without an interior.
pub(super) fn primitive_mesh(fit: &PosedPrimitive) -> (Solid, ReconstructionMethod) {
    let made = match &fit.kind {
        PrimitiveKind::Turned { profile } => {
            let mut closed = vec![DVec2::ZERO];
            closed.extend(with_a_foot(profile));
            closed.push(DVec2::new(0.0, fit.size.z));
            Some((lathe(&closed, AROUND), ReconstructionMethod::Turned))
        }
        PrimitiveKind::Block => Some((block(fit.size), ReconstructionMethod::Box)),
        PrimitiveKind::Flat { outline } => Some((prism(outline, fit.size.z), ReconstructionMethod::Slab)),
        PrimitiveKind::Upright { outline } => {
            let raised =
                prism(outline, fit.size.y).rotated(DQuat::from_rotation_x(std::f64::consts::FRAC_PI_2));
            Some((raised.translated(DVec3::new(0.0, 0.5 * fit.size.y, 0.0)), ReconstructionMethod::Extrusion))
        }
        PrimitiveKind::Inflated { outline, posture } => Inflation::new(outline, *posture, SQUARES)
            .map(|inflation| (inflation.solid(fit.size), ReconstructionMethod::Inflation)),
    };
    made.filter(|(solid, _)| solid.is_watertight() && solid.volume_m3() > 0.0)
        .unwrap_or_else(|| (block(fit.size.max(DVec3::splat(1e-4))), ReconstructionMethod::Box))
}

/// The profile, (radius, height) upward from z = 0, with a base wide enough to stand on: what an image shows of the
/// foot of a stem may be narrower than any object stands on.
fn with_a_foot(profile: &[DVec2]) -> Vec<DVec2> {
    // Slices between neighboring points, as cylinders.
    let (mut volume, mut moment) = (0.0, 0.0);
    for pair in profile.windows(2) {
        let radius_m = 0.5 * (pair[0].x + pair[1].x);
        let slice = radius_m * radius_m * (pair[1].y - pair[0].y).abs();
        volume += slice;
        moment += slice * 0.5 * (pair[0].y + pair[1].y);
    }
    let height_m = profile.iter().map(|p| p.y).fold(0.0, f64::max);
    let center_of_mass_m = if volume > 0.0 { moment / volume } else { 0.5 * height_m };
    let base_m = profile.first().map_or(0.0, |p| p.x);
    let wanted_m = center_of_mass_m * STEADY_RAD.tan();
    if base_m >= wanted_m {
        return profile.to_vec();
    }
    let foot_m = FOOT_SHARE * height_m;
    let mut widened = vec![DVec2::new(wanted_m, 0.0), DVec2::new(wanted_m, foot_m)];
    widened.extend(profile.iter().filter(|p| p.y > foot_m));
    widened
}

/// Silhouette of the unoccluded primitive in the camera's image; `None` if part of it lies behind the camera.
pub(super) fn silhouette(fit: &PosedPrimitive, camera: &Camera) -> Option<Mask> {
    let (solid, _) = primitive_mesh(fit);
    let world_from_solid = Pose::upright(fit.center.extend(0.0), fit.yaw_rad);
    let corners: Option<Vec<DVec2>> = solid
        .positions
        .iter()
        .map(|p| camera.project(world_from_solid.transform_point(*p)).map(|(pixel, _)| pixel))
        .collect();
    let corners = corners?;
    let mut mask = Mask::empty(camera.width_px, camera.height_px);
    let within = |from: f64, to: f64, limit: u32| {
        let bound = |v: f64| (v - 0.5).ceil().clamp(0.0, f64::from(limit)) as u32;
        bound(from)..bound(to)
    };
    for t in &solid.triangles {
        let [a, b, c] = t.map(|v| corners[v as usize]);
        // Faces toward the camera are clockwise with y down, and cover all of a closed mesh.
        if (b - a).perp_dot(c - a) >= 0.0 {
            continue;
        }
        for y in within(a.y.min(b.y).min(c.y), a.y.max(b.y).max(c.y), camera.height_px) {
            let row = f64::from(y) + 0.5;
            let crossed = [(a, b), (b, c), (c, a)]
                .into_iter()
                .filter(|(p, q)| (p.y <= row) != (q.y <= row))
                .map(|(p, q)| p.x + (q.x - p.x) * (row - p.y) / (q.y - p.y));
            let (left, right) =
                crossed.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| (low.min(x), high.max(x)));
            if left < right {
                within(left, right, camera.width_px).for_each(|x| mask.set(x, y, true));
            }
        }
    }
    Some(mask)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_turned_body_has_a_foot_to_stand_on() {
        let stem = [(0.003, 0.0), (0.003, 0.1), (0.05, 0.12), (0.05, 0.2)];
        let stem = stem.map(|(radius, height)| DVec2::new(radius, height));
        let standing = with_a_foot(&stem);
        assert!(standing[0].x > 0.015 && standing[0].x < 0.03, "{standing:?}");
        assert_eq!(standing[standing.len() - 1], stem[3]);
        assert!(standing.windows(2).all(|pair| pair[0].y <= pair[1].y), "{standing:?}");
        let cup = [(0.03, 0.0), (0.04, 0.1)].map(|(radius, height)| DVec2::new(radius, height));
        assert_eq!(with_a_foot(&cup), cup);
    }
}
