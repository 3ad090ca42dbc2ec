//! Meshes in requested poses: lying on a side or upside down.
//!
//! An object that a text tips over has its tipped pose as the canonical one: its mesh is rotated onto a face of its
//! convex hull on which it can rest, and everything after it (footprint, height, image, recognition, simulation) sees
//! the rotated mesh. The face is the most stable one within 30 degrees of the request; the center of mass is that of
//! the enclosed volume. Input and output: a mesh in its canonical frame (+z up, front toward -y, origin at the bottom
//! center), meters. Deterministic; the same mesh and pose give the same result. Cost: a convex hull.

use std::f64::consts::PI;

use glam::{DQuat, DVec2, DVec3};

use catalog::{Recipe, build_cached};
use geometry::TexturedMesh;
use geometry::convex_hull::{convex_hull, planes};
use geometry::mass_properties::solid_mass_properties;
use geometry::polygon::{convex_hull_2d, depth_in_convex_m};
use scene::{RecognizedObject, RequestedPose};

/// Corners of the hull; faces of round objects stay narrow enough to lie flat.
const MAX_HULL_CORNERS: usize = 256;
/// Points within this distance belong to a face, meters.
const FACE_THICKNESS_M: f64 = 0.0004;
/// Largest angle between the requested and the resting direction, radians (30 degrees).
const MAX_TILT_RAD: f64 = PI / 6.0;
/// A resting object may be tipped by at least this angle before it falls, radians (1 degree).
const MIN_STABILITY_RAD: f64 = PI / 180.0;

/// A face of the hull on which the object can rest.
struct RestingFace {
    normal: DVec3,
    /// Tilt from the requested direction, radians.
    tilt_rad: f64,
    /// Angle by which the object may be tipped before it falls, radians.
    stability_rad: f64,
}

/// The mesh of a rendered object in its pose, as the image shows it: built by the catalog from the recognized
/// attributes. `None` for an unknown category, or if the object cannot rest in the pose.
pub fn rendered_mesh(object: &RecognizedObject) -> Option<TexturedMesh> {
    let tipped = object.tipped.as_ref();
    let mesh = build_cached(&Recipe {
        category: object.category.clone(),
        size_m: tipped.map_or(object.size_m, |tipped| tipped.upright_size_m),
        color: object.color,
        material: object.material.clone(),
        seed: object.seed,
    })?;
    posed(&mesh, tipped.map_or(RequestedPose::Upright, |tipped| tipped.pose))
}

/// The mesh rotated into the pose and seated on the origin; an upright mesh stays as it is. `None` if the object
/// cannot rest in the pose.
pub fn posed(mesh: &TexturedMesh, pose: RequestedPose) -> Option<TexturedMesh> {
    if pose.is_upright() {
        return Some(mesh.clone());
    }
    let rotation = resting_rotation(mesh, pose)?;
    Some(mesh.clone().rotated(rotation).seated().snap_to_f32())
}

/// The rotation from the upright mesh to one that rests in the pose. Lying objects have their top toward +x; objects
/// that are upside down keep their front. `None` if it cannot rest so.
pub fn resting_rotation(mesh: &TexturedMesh, pose: RequestedPose) -> Option<DQuat> {
    let tilt_rad = |normal: DVec3| match pose {
        RequestedPose::LyingOnSide => normal.z.clamp(-1.0, 1.0).asin(),
        _ => normal.z.clamp(-1.0, 1.0).acos(),
    };
    let faces = resting_faces(mesh, &tilt_rad)?;
    let value = |face: &RestingFace| face.stability_rad.min(0.5) - 0.5 * face.tilt_rad;
    let best = faces.into_iter().reduce(|best, face| {
        // The first of equal faces is kept.
        if value(&face) > value(&best) + 1e-6 { face } else { best }
    })?;
    let first = match pose {
        RequestedPose::UpsideDown => DQuat::from_rotation_y(PI),
        _ => DQuat::IDENTITY,
    };
    let down = DQuat::from_rotation_arc((first * best.normal).normalize(), -DVec3::Z) * first;
    let top = (down * DVec3::Z).truncate();
    let turn = if pose == RequestedPose::LyingOnSide { -top.to_angle() } else { 0.0 };
    Some((DQuat::from_rotation_z(turn) * down).normalize())
}

/// Faces of the hull within the permitted tilt that carry the center of mass.
fn resting_faces(mesh: &TexturedMesh, tilt_rad: &dyn Fn(DVec3) -> f64) -> Option<Vec<RestingFace>> {
    let hull = convex_hull(&mesh.positions, MAX_HULL_CORNERS, 0.0)?;
    let (low, high) = mesh.bounds();
    let center =
        solid_mass_properties(mesh, 1.0).map_or(0.5 * (low + high), |properties| properties.center_of_mass_m);
    let mut normals: Vec<DVec3> = Vec::new();
    let mut faces = Vec::new();
    for (normal, offset) in planes(&hull) {
        let tilt_rad = tilt_rad(normal).abs();
        if tilt_rad > MAX_TILT_RAD || normals.iter().any(|known| known.dot(normal) > 1.0 - 1e-7) {
            continue;
        }
        normals.push(normal);
        let to_plane = DQuat::from_rotation_arc(normal, DVec3::Z);
        let on_face = hull.points.iter().filter(|p| p.dot(normal) > offset - FACE_THICKNESS_M);
        let corners: Vec<DVec2> = on_face.map(|p| (to_plane * *p).truncate()).collect();
        let depth_m = depth_in_convex_m(&convex_hull_2d(&corners), (to_plane * center).truncate());
        let height_m = offset - center.dot(normal);
        let stability_rad = depth_m.atan2(height_m.max(1e-6));
        if stability_rad >= MIN_STABILITY_RAD {
            faces.push(RestingFace { normal, tilt_rad, stability_rad });
        }
    }
    Some(faces)
}

#[cfg(test)]
mod tests {
    use super::*;
    use catalog::build;

    fn typical(category: &str) -> TexturedMesh {
        build(&Recipe::typical(category, None, None).expect("a category")).expect("a mesh")
    }

    #[test]
    fn lying_bottle_is_as_long_as_it_was_high_and_rests_on_the_table() {
        for category in ["wine_bottle", "water_bottle", "mug", "soda_can"] {
            let upright = typical(category);
            let lying = posed(&upright, RequestedPose::LyingOnSide).expect(category);
            let (before, after) = (upright.size_m(), lying.size_m());
            assert!((after.x - before.z).abs() < 0.25 * before.z, "{category}: {before} becomes {after}");
            assert!(after.z < 1.1 * before.x.max(before.y), "{category}: {before} becomes {after}");
            let (low, high) = lying.bounds();
            assert!(low.z.abs() < 1e-6 && (low + high).truncate().length() < 1e-5, "{category}");
            let volume = |mesh: &TexturedMesh| solid_mass_properties(mesh, 1.0).expect("closed").mass_kg;
            assert!((volume(&lying) / volume(&upright) - 1.0).abs() < 1e-3, "{category}: a rotation");
        }
    }

    #[test]
    fn bowl_upside_down_keeps_its_size_and_has_its_wide_end_below() {
        let upright = typical("bowl");
        let inverted = posed(&upright, RequestedPose::UpsideDown).expect("a bowl rests on its rim");
        assert!((inverted.size_m() - upright.size_m()).abs().max_element() < 0.002);
        let width_below = |mesh: &TexturedMesh| {
            let low = mesh.positions.iter().filter(|p| p.z < 0.2 * mesh.size_m().z);
            low.map(|p| p.truncate().length()).fold(0.0, f64::max)
        };
        assert!(width_below(&inverted) > 1.2 * width_below(&upright));
    }

    #[test]
    fn cone_cannot_stand_on_its_tip() {
        let mut cone = TexturedMesh::default();
        cone.add(
            geometry::shapes::cone(0.05, 0.0, 0.1, 24),
            &geometry::Material::plain("plain", geometry::Rgb::hex(0x808080), 0.5),
        );
        assert!(posed(&cone, RequestedPose::UpsideDown).is_none());
        assert!(posed(&cone, RequestedPose::LyingOnSide).is_some());
        assert_eq!(posed(&cone, RequestedPose::Upright), Some(cone));
    }
}
