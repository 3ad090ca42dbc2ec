//! Building blocks of desk objects: boards and profiles set upright, bars along y, facets to rest on,
//! and the last step that brings a mesh to its ordered extents.

use glam::{DMat3, DQuat, DVec2, DVec3};

use crate::Order;
use crate::texture::{is_finish, material_finish};
use geometry::shapes::{circle, inset, lathe, loft, loft_closed, prism, rounded_rectangle, slab, sweep};
use geometry::{Material, Rgb, Solid, TexturedMesh, Vec3};

pub use crate::tables::shapes::board;

/// Shorthand for a point, meters.
pub fn at(x: f64, y: f64, z: f64) -> DVec3 {
    DVec3::new(x, y, z)
}

/// Shorthand for a point in a plane, meters.
pub fn p2(x: f64, y: f64) -> DVec2 {
    DVec2::new(x, y)
}

/// Dielectric of one color, `0xRRGGBB`.
pub fn plain(name: &str, rgb: u32, roughness: f32) -> Material {
    Material::plain(name, Rgb::hex(rgb), roughness)
}

/// Steel-like metal.
pub fn steel() -> Material {
    Material::metal("steel", Rgb::hex(0xb9_bc_c0), 0.32)
}

/// The main material: the requested one, else the order's color with `roughness`.
pub fn body_finish(order: &mut Order, roughness: f32) -> Material {
    finish_or(order, |order| Material::plain("body", order.color, roughness))
}

/// The requested material, or `usual` if none is requested.
pub fn finish_or(order: &mut Order, usual: impl FnOnce(&mut Order) -> Material) -> Material {
    match order.material {
        Some(name) if is_finish(name) => material_finish(name, order.color, &mut order.rng),
        _ => usual(order),
    }
}

/// A board between two corners with vertical corners rounded by `corner_m`, other edges by `edge_m`.
pub fn rounded(low: DVec3, high: DVec3, corner_m: f64, edge_m: f64) -> Solid {
    let size = high - low;
    let outline = rounded_rectangle(size.x, size.y, corner_m.max(1.05 * edge_m), 5);
    let center = 0.5 * (low + high);
    slab(&outline, size.z, edge_m).with_flat_ends().translated(at(center.x, center.y, low.z))
}

/// `outline` raised between two heights, edges rounded.
pub fn plate(outline: &[DVec2], low_m: f64, high_m: f64, edge_m: f64) -> Solid {
    slab(outline, high_m - low_m, edge_m).with_flat_ends().translated(at(0.0, 0.0, low_m))
}

/// An outline in the x-z plane (counter-clockwise seen from the front, -y) given a depth.
pub fn upright(outline_xz: &[DVec2], front_y_m: f64, back_y_m: f64, edge_m: f64) -> Solid {
    slab(outline_xz, back_y_m - front_y_m, edge_m)
        .with_flat_ends()
        .rotated(DQuat::from_rotation_x(0.5 * std::f64::consts::PI))
        .translated(at(0.0, back_y_m, 0.0))
}

/// An outline in the y-z plane (counter-clockwise seen from the right, +x) given a width.
pub fn side_on(outline_yz: &[DVec2], left_x_m: f64, right_x_m: f64, edge_m: f64) -> Solid {
    let turn = DQuat::from_mat3(&DMat3::from_cols(DVec3::Y, DVec3::Z, DVec3::X));
    let solid = if edge_m > 0.0 {
        slab(outline_yz, right_x_m - left_x_m, edge_m).with_flat_ends()
    } else {
        prism(outline_yz, right_x_m - left_x_m)
    };
    solid.rotated(turn).translated(at(left_x_m, 0.0, 0.0))
}

/// A body of revolution lying along +y: `profile` is (radius, y); six `sides` lie on a flat.
pub fn turned_along_y(profile: &[(f64, f64)], sides: usize) -> Solid {
    turned(profile, sides).rotated(DQuat::from_rotation_x(-0.5 * std::f64::consts::PI))
}

/// A body of revolution along +x: `profile` is (radius, x).
pub fn turned_along_x(profile: &[(f64, f64)], sides: usize) -> Solid {
    turned(profile, sides).rotated(DQuat::from_rotation_y(0.5 * std::f64::consts::PI))
}

/// A body of revolution about +z: `profile` is (radius, z) from the bottom up; ends are closed.
pub fn turned(profile: &[(f64, f64)], sides: usize) -> Solid {
    let points: Vec<DVec2> = profile.iter().map(|&(r, z)| p2(r, z)).collect();
    lathe(&points, sides)
}

/// Pushes everything below `floor_m` up to it: a facet to rest on, for bodies without overhangs there.
pub fn rested(solid: Solid, floor_m: f64) -> Solid {
    let positions: Vec<DVec3> = solid.positions.iter().map(|p| at(p.x, p.y, p.z.max(floor_m))).collect();
    let mut flat = Solid::from_corners(&positions, &solid.uvs, &solid.triangles);
    flat.normals.iter_mut().filter(|n| n.length_squared() < 0.5).for_each(|n| *n = Vec3::NEG_Z);
    flat
}

/// A strap of rectangular section (`width_m` across, `thickness_m` along the path's up) along `path`.
pub fn strap(path: &[DVec3], width_m: f64, thickness_m: f64, up: DVec3) -> Solid {
    sweep(path, &rounded_rectangle(width_m, thickness_m, 0.35 * thickness_m, 2), up, |_| 1.0)
}

/// A key cap: `size_m` at its foot, its top narrower by `taper_m` on every side.
pub fn key_cap(center: DVec3, size_m: DVec3, taper_m: f64) -> Solid {
    let ring = |inset: f64, z: f64| -> Vec<DVec3> {
        let (w, d) = (size_m.x - 2.0 * inset, size_m.y - 2.0 * inset);
        rounded_rectangle(w, d, 0.12 * w.min(d), 1).iter().map(|p| center + p.extend(z)).collect()
    };
    loft(&[ring(0.0, 0.0), ring(taper_m, size_m.z)])
}

/// A button or lid: `outline` from `low_m` up to `high_m`, only its upper edge chamfered by `edge_m`.
pub fn button(outline: &[DVec2], low_m: f64, high_m: f64, edge_m: f64) -> Solid {
    let ring = |by: f64, z: f64| -> Vec<DVec3> { inset(outline, by).iter().map(|p| p.extend(z)).collect() };
    loft(&[ring(0.0, low_m), ring(0.0, high_m - edge_m), ring(edge_m, high_m)]).with_flat_ends()
}

/// A straight-walled vessel on z = 0: `outline` up to `height_m`, walls and floor of the given thickness.
pub fn cup(outline: &[DVec2], height_m: f64, wall_m: f64, floor_m: f64) -> Solid {
    let inner = inset(outline, wall_m);
    let ring = |line: &[DVec2], z: f64| -> Vec<DVec3> { line.iter().map(|p| p.extend(z)).collect() };
    loft(&[ring(outline, 0.0), ring(outline, height_m), ring(&inner, height_m), ring(&inner, floor_m)])
}

/// A ring about +z whose section is the closed (radius, z) polygon `section`, counter-clockwise.
pub fn hoop(section: &[(f64, f64)], sides: usize) -> Solid {
    let rings: Vec<Vec<DVec3>> =
        section.iter().map(|&(r, z)| circle(r, sides).iter().map(|p| p.extend(z)).collect()).collect();
    loft_closed(&rings)
}

/// [`loft`] with clockwise rings reversed, so that faces point outward.
pub fn skin(rings: &[Vec<DVec3>]) -> Solid {
    let solid = loft(rings);
    if solid.volume_m3() > 0.0 {
        return solid;
    }
    let turned: Vec<Vec<DVec3>> = rings.iter().map(|r| r.iter().rev().copied().collect()).collect();
    loft(&turned)
}

/// A smooth open curve through (radius, z) points, `steps` segments between neighbors (Catmull-Rom).
pub fn curve(points: &[(f64, f64)], steps: usize) -> Vec<(f64, f64)> {
    let n = points.len();
    let point = |k: usize| p2(points[k].0, points[k].1);
    let mut line: Vec<(f64, f64)> = (0..n - 1)
        .flat_map(|k| {
            let [a, b, c, d] =
                [point(k.saturating_sub(1)), point(k), point(k + 1), point((k + 2).min(n - 1))];
            (0..steps).map(move |s| {
                let t = s as f64 / steps as f64;
                let q = 0.5
                    * (2.0 * b
                        + (c - a) * t
                        + (2.0 * a - 5.0 * b + 4.0 * c - d) * t * t
                        + (3.0 * b - a - 3.0 * c + d) * t * t * t);
                (q.x, q.y)
            })
        })
        .collect();
    line.push(points[n - 1]);
    line
}

/// Rotates a solid modeled along +z so that +z becomes `direction`, then moves its origin to `from`.
pub fn pointed(solid: Solid, from: DVec3, direction: DVec3) -> Solid {
    solid.rotated(DQuat::from_rotation_arc(DVec3::Z, direction.normalize_or(DVec3::Z))).translated(from)
}

/// The outline moved by `offset_m`.
pub fn moved(outline: &[DVec2], offset_m: DVec2) -> Vec<DVec2> {
    outline.iter().map(|p| *p + offset_m).collect()
}

/// The solid with every point moved by `change`, normals recomputed.
pub fn bent(solid: Solid, change: impl Fn(DVec3) -> DVec3) -> Solid {
    let positions: Vec<DVec3> = solid.positions.iter().map(|p| change(*p)).collect();
    Solid::from_corners(&positions, &solid.uvs, &solid.triangles)
}

/// Scales the mesh to exactly `size_m` and seats it. Generators model in the requested extents already, so
/// the factors are close to one.
pub fn fitted(mesh: TexturedMesh, size_m: DVec3) -> TexturedMesh {
    let scale = size_m / mesh.size_m().max(DVec3::splat(1e-6));
    mesh.seated().scaled(scale)
}
