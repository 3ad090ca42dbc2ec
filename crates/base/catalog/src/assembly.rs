//! Assembly of objects from parts: placed solids, stacked sections, plates with holes, prints.
//!
//! Generators model in millimeters at a typical size and [`Assembly::fitted`] scales the result to the
//! ordered extents. The shape functions are independent of the unit, so every length here and in the
//! generators that use this module is in model millimeters unless its name says otherwise. Parts
//! overlap by half a millimeter or more and never share a face plane.

use std::f64::consts::{FRAC_PI_2, TAU};

use glam::{DQuat, DVec2, DVec3, Vec2, Vec3};

use super::Order;
use super::texture::{material_finish, wood_grain};
use geometry::shapes::{loft, loft_closed, prism, rectangle, slab};
use geometry::{Material, Rgb, Solid, TexturedMesh};

/// An object under construction.
pub(super) struct Assembly {
    mesh: TexturedMesh,
}

impl Assembly {
    pub(super) fn new() -> Self {
        Self { mesh: TexturedMesh::default() }
    }

    /// Adds a part, moved by `at` = (x, y, z).
    pub(super) fn put(&mut self, part: Solid, at: [f64; 3], material: &Material) {
        self.mesh.add(part.translated(DVec3::from_array(at)), material);
    }

    /// Adds a part twice: at `at` and mirrored to -x.
    pub(super) fn put_pair(&mut self, part: &Solid, at: [f64; 3], material: &Material) {
        let right = part.clone().translated(DVec3::from_array(at));
        self.mesh.add(mirrored_x(right.clone()), material);
        self.mesh.add(right, material);
    }

    /// The finished mesh, seated, scaled per axis to the extents `size_m`.
    pub(super) fn fitted(self, size_m: DVec3) -> TexturedMesh {
        let scale = size_m / self.mesh.size_m().max(DVec3::splat(1e-9));
        self.mesh.seated().scaled(scale)
    }

    /// As [`Assembly::fitted`] with one scale for x and y, so that round parts stay round.
    pub(super) fn fitted_round(self, size_m: DVec3) -> TexturedMesh {
        let scale = size_m / self.mesh.size_m().max(DVec3::splat(1e-9));
        let flat = 0.5 * (scale.x + scale.y);
        self.mesh.seated().scaled(DVec3::new(flat, flat, scale.z))
    }
}

/// The main material: the requested one, else `usual`.
pub(super) fn main_finish(order: &mut Order, usual: &str) -> Material {
    material_finish(order.material.unwrap_or(usual), order.color, &mut order.rng)
}

/// Brushed steel.
pub(super) fn steel(order: &mut Order) -> Material {
    material_finish("steel", order.color, &mut order.rng)
}

/// Wood of the given color, grain along u.
pub(super) fn wood(order: &mut Order, color: u32) -> Material {
    Material::textured("wood", wood_grain(Rgb::hex(color), &mut order.rng), 0.55)
}

/// Untextured plastic.
pub(super) fn plastic(color: Rgb) -> Material {
    Material::plain("plastic", color, 0.38)
}

/// Black rubber or matt plastic.
pub(super) fn black() -> Material {
    Material::plain("black", Rgb::hex(0x222325), 0.6)
}

/// Plane points from pairs.
pub(super) fn points(pairs: &[(f64, f64)]) -> Vec<DVec2> {
    pairs.iter().map(|&(x, y)| DVec2::new(x, y)).collect()
}

/// Space points from triples.
pub(super) fn path(triples: &[(f64, f64, f64)]) -> Vec<DVec3> {
    triples.iter().map(|&(x, y, z)| DVec3::new(x, y, z)).collect()
}

/// An open Catmull-Rom curve through `knots` (at least two), `steps` segments between neighbors.
pub(super) fn curve(knots: &[(f64, f64, f64)], steps: usize) -> Vec<DVec3> {
    let knots = path(knots);
    let last = knots.len() - 1;
    let mut smooth = Vec::with_capacity(last * steps + 1);
    for k in 0..last {
        let (p1, p2) = (knots[k], knots[k + 1]);
        let p0 = if k == 0 { 2.0 * p1 - p2 } else { knots[k - 1] };
        let p3 = if k + 2 > last { 2.0 * p2 - p1 } else { knots[k + 2] };
        for s in 0..steps {
            let t = s as f64 / steps as f64;
            smooth.push(
                0.5 * (2.0 * p1
                    + (p2 - p0) * t
                    + (2.0 * p0 - 5.0 * p1 + 4.0 * p2 - p3) * t * t
                    + (3.0 * p1 - p0 - 3.0 * p2 + p3) * t * t * t),
            );
        }
    }
    smooth.push(knots[last]);
    smooth
}

/// Rotates a solid from +z to lie along +y.
pub(super) fn along_y(solid: Solid) -> Solid {
    solid.rotated(DQuat::from_rotation_x(-FRAC_PI_2))
}

/// Rotates a solid from +z to lie along +x.
pub(super) fn along_x(solid: Solid) -> Solid {
    solid.rotated(DQuat::from_rotation_y(FRAC_PI_2))
}

/// Rotates a solid about +z by `degrees`, counter-clockwise seen from above.
pub(super) fn yawed(solid: Solid, degrees: f64) -> Solid {
    solid.rotated(DQuat::from_rotation_z(degrees.to_radians()))
}

/// Tilts a solid about +x by `degrees`: its +z side moves toward -y.
pub(super) fn pitched(solid: Solid, degrees: f64) -> Solid {
    solid.rotated(DQuat::from_rotation_x(degrees.to_radians()))
}

/// Tilts a solid about +y by `degrees`: its +z side moves toward +x.
pub(super) fn rolled(solid: Solid, degrees: f64) -> Solid {
    solid.rotated(DQuat::from_rotation_y(degrees.to_radians()))
}

/// Extrudes a side view (y, z), counter-clockwise seen from +x, to a `width` centered on x = 0.
pub(super) fn across_x(side_view: &[DVec2], width: f64, edge: f64) -> Solid {
    let quarter_turns = DQuat::from_mat3(&glam::DMat3::from_cols(DVec3::Y, DVec3::Z, DVec3::X));
    slab(side_view, width, edge).rotated(quarter_turns).translated(DVec3::new(-0.5 * width, 0.0, 0.0))
}

/// Extrudes a front view (x, z), counter-clockwise seen from the front (-y), to a `depth` centered on y = 0.
pub(super) fn across_y(front_view: &[DVec2], depth: f64, edge: f64) -> Solid {
    slab(front_view, depth, edge).rotated(DQuat::from_rotation_x(FRAC_PI_2)).translated(DVec3::new(
        0.0,
        0.5 * depth,
        0.0,
    ))
}

/// The mirror image in the plane x = 0.
pub(super) fn mirrored_x(mut solid: Solid) -> Solid {
    solid.positions.iter_mut().for_each(|p| p.x = -p.x);
    solid.normals.iter_mut().for_each(|n| n.x = -n.x);
    solid.triangles.iter_mut().for_each(|t| t.swap(1, 2));
    solid
}

/// Makes a flat underside: points below `floor` are moved up to it.
pub(super) fn resting(mut solid: Solid, floor: f64) -> Solid {
    solid.positions.iter_mut().for_each(|p| p.z = p.z.max(floor));
    let mut cut = Solid::from_corners(&solid.positions, &solid.uvs, &solid.triangles);
    // Slivers pressed into the plane have no normal of their own.
    cut.normals.iter_mut().filter(|n| n.length() < 0.5).for_each(|n| *n = Vec3::NEG_Z);
    cut
}

/// A superellipse section: (position along the axis, center a, center b, full width a, full width b).
pub(super) type Section = (f64, f64, f64, f64, f64);

/// Skins superellipse sections (y, x, z, width, height) along +y; `exponent` 2 is round, 6 boxy.
pub(super) fn bar(sections: &[Section], exponent: f64, segments: usize) -> Solid {
    let rings: Vec<Vec<DVec3>> = sections
        .iter()
        .map(|&(y, x, z, width, height)| {
            unit_superellipse(exponent, segments)
                .iter()
                .map(|p| DVec3::new(x + width * p.y, y, z + height * p.x))
                .collect()
        })
        .collect();
    loft(&rings)
}

/// Skins superellipse sections (z, x, y, width, depth) upward.
pub(super) fn column(sections: &[Section], exponent: f64, segments: usize) -> Solid {
    let rings: Vec<Vec<DVec3>> = sections
        .iter()
        .map(|&(z, x, y, width, depth)| {
            unit_superellipse(exponent, segments)
                .iter()
                .map(|p| DVec3::new(x + width * p.x, y + depth * p.y, z))
                .collect()
        })
        .collect();
    loft(&rings)
}

fn unit_superellipse(exponent: f64, segments: usize) -> Vec<DVec2> {
    let power = |c: f64| 0.5 * c.signum() * c.abs().powf(2.0 / exponent);
    (0..segments)
        .map(|k| {
            // Offset by half a step, so that a boxy section has a flat underside instead of a corner.
            let (sin, cos) = (TAU * (k as f64 + 0.5) / segments as f64).sin_cos();
            DVec2::new(power(cos), power(sin))
        })
        .collect()
}

/// A body of revolution with a modulated radius: `radius * (1 + depth * cos(lobes * angle))`.
pub(super) fn lobed(profile: &[(f64, f64)], lobes: usize, depth: f64, segments: usize) -> Solid {
    let rings: Vec<Vec<DVec3>> = profile
        .iter()
        .map(|&(radius, z)| {
            (0..segments)
                .map(|k| {
                    let angle = TAU * k as f64 / segments as f64;
                    let wavy = radius * (1.0 + depth * (lobes as f64 * angle).cos());
                    (DVec2::from_angle(angle) * wavy).extend(z)
                })
                .collect()
        })
        .collect();
    loft(&rings)
}

/// A ring of revolution with an open center: `profile`, a closed loop (radius, z), counter-clockwise in the
/// r-z plane, no point on the axis.
pub(super) fn turned_ring(profile: &[(f64, f64)], segments: usize) -> Solid {
    let rings: Vec<Vec<DVec3>> = profile
        .iter()
        .map(|&(radius, z)| {
            (0..segments)
                .map(|k| (DVec2::from_angle(TAU * k as f64 / segments as f64) * radius).extend(z))
                .collect()
        })
        .collect();
    loft_closed(&rings)
}

/// A plate with one hole, standing on z = 0: `outline` must be star shaped as seen from the center of the
/// hole; the hole is `hole(angle)` wide from `center`. Upper and lower edges are rounded by `edge`.
pub(super) fn pierced(
    outline: &[DVec2],
    center: (f64, f64),
    hole: impl Fn(f64) -> f64,
    height: f64,
    edge: f64,
    segments: usize,
) -> Solid {
    let center = DVec2::new(center.0, center.1);
    let reach = |direction: DVec2| {
        (0..outline.len())
            .filter_map(|k| {
                let (a, b) = (outline[k] - center, outline[(k + 1) % outline.len()] - center);
                let along = b - a;
                let turn = direction.perp_dot(along);
                let distance = a.perp_dot(along) / turn;
                let fraction = a.perp_dot(direction) / turn;
                (turn.abs() > 1e-12 && (-1e-9..=1.0 + 1e-9).contains(&fraction) && distance > 0.0)
                    .then_some(distance)
            })
            .fold(0.0, f64::max)
    };
    // The outline's own corners are sampled exactly; even steps fill the rest.
    let mut angles: Vec<f64> = (0..segments).map(|k| TAU * k as f64 / segments as f64).collect();
    angles.extend(outline.iter().map(|p| (*p - center).to_angle().rem_euclid(TAU)));
    angles.sort_by(f64::total_cmp);
    angles.dedup_by(|a, b| (*a - *b).abs() < 0.02);
    let ring = |outer: bool, shrink: f64, z: f64| -> Vec<DVec3> {
        angles
            .iter()
            .map(|&angle| {
                let direction = DVec2::from_angle(angle);
                let radius = if outer { reach(direction) - shrink } else { hole(angle) + shrink };
                (center + radius * direction).extend(z)
            })
            .collect()
    };
    let rings = if edge > 0.0 {
        vec![
            ring(true, edge, 0.0),
            ring(true, 0.0, edge),
            ring(true, 0.0, height - edge),
            ring(true, edge, height),
            ring(false, edge, height),
            ring(false, 0.0, height - edge),
            ring(false, 0.0, edge),
            ring(false, edge, 0.0),
        ]
    } else {
        vec![ring(true, 0.0, 0.0), ring(true, 0.0, height), ring(false, 0.0, height), ring(false, 0.0, 0.0)]
    };
    loft_closed(&rings)
}

/// A thin plate with an image on its top, u along +x, v along +y; standing on z = 0.
pub(super) fn print_plate(width: f64, depth: f64, thickness: f64) -> Solid {
    prism(&rectangle(width, depth), thickness)
}

/// As [`print_plate`], upright: the image faces the front (-y), u along +x, v along +z; centered on
/// the origin, its face at y = -`thickness` / 2.
pub(super) fn front_plate(width: f64, height: f64, thickness: f64) -> Solid {
    print_plate(width, height, thickness).rotated(DQuat::from_rotation_x(FRAC_PI_2)).translated(DVec3::new(
        0.0,
        0.5 * thickness,
        0.0,
    ))
}

/// As [`front_plate`], the image facing the right (+x), u along +y.
pub(super) fn side_plate(depth: f64, height: f64, thickness: f64) -> Solid {
    yawed(front_plate(depth, height, thickness), 90.0)
}

/// Rotates texture coordinates by a quarter turn: u becomes v (wood grain along y).
pub(super) fn grain_along_y(mut solid: Solid) -> Solid {
    solid.uvs.iter_mut().for_each(|uv| *uv = Vec2::new(uv.y, uv.x));
    solid
}
