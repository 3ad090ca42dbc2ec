//! Mesh and silhouette of a fitted primitive.

use glam::{DQuat, DVec2, DVec3};

use geometry::shapes::{Inflation, block, lathe, prism};
use geometry::{Camera, Pose, Solid};
use imaging::Mask;
use scene::ReconstructionMethod;
use vision::{PosedPrimitive, PrimitiveKind};

/// Segments of a solid of revolution.
const AROUND: usize = 48;
/// Cells of the inflation grid: about four triangles each.
const SQUARES: u32 = 700;

/// The closed mesh in its own frame, base on z = 0, and its method. A box replaces a self-intersecting outline
/// without an interior.
pub(super) fn primitive_mesh(fit: &PosedPrimitive) -> (Solid, ReconstructionMethod) {
    let made = match &fit.kind {
        PrimitiveKind::Turned { profile } => {
            let mut closed = vec![DVec2::ZERO];
            closed.extend(profile);
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
