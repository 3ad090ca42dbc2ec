//! Generators of stand-ins: one plain shape per family, at any size.
//!
//! Input: the ordered extents, meters. Each body is modeled at these extents and then scaled per axis by the few
//! percent that remain, so that the extents are exact. Bodies of revolution become elliptical if width and depth
//! differ. The finish follows the material and always has the ordered color.

use std::f64::consts::{FRAC_PI_2, TAU};

use glam::{DMat3, DQuat, DVec2, DVec3};

use crate::Order;
use crate::kit::{column, rested, turned_ring};
use crate::substance::substance;
use crate::texture::{brushed_metal, fabric_weave, granite, is_finish, material_finish, wood_grain};
use geometry::shapes::{
    circle, cylinder, ellipse, ellipsoid, lathe, rounded_rectangle, shell_of_revolution, slab,
};
use geometry::{Material, Rgb, Solid, TexturedMesh};

/// Segments of bodies of revolution.
const SEGMENTS: usize = 40;

/// Segments of rings, which show their corners more.
const RING_SEGMENTS: usize = 64;

/// Relative difference of width and depth up to which a flat body is round.
const ROUND: f64 = 0.05;

/// The finish of the ordered material in the ordered color. Substances with a color of their own (wood, metals) take
/// the ordered one, which is theirs unless a request states another; a named wood or metal ("walnut") keeps its own.
fn finish(order: &mut Order) -> Material {
    let (name, color) = (order.material.unwrap_or(&order.category.substance), order.color);
    let rng = &mut order.rng;
    match name {
        "wood" | "plywood" => Material::textured(name, wood_grain(color, rng), 0.55),
        "fabric" => Material::textured(name, fabric_weave(color, rng), 0.95),
        "leather" => Material::textured(name, granite(color, rng), 0.6),
        "stone" | "soil" => Material::textured(name, granite(color, rng), 0.8),
        "steel" | "aluminum" | "brass" | "cast_iron" => {
            Material { metalness: 1.0, ..Material::textured(name, brushed_metal(color, rng), 0.35) }
        }
        _ if is_finish(name) => material_finish(name, color, rng),
        _ if substance(name).is_some() => Material::plain(name, color, 0.6),
        _ => Material::plain("main", color, 0.5),
    }
}

/// One solid in the ordered finish, scaled to the ordered extents.
fn in_one_piece(order: &mut Order, solid: Solid) -> TexturedMesh {
    let main = finish(order);
    fitted(&[(solid, &main)], order.size_m)
}

/// The parts, seated, scaled per axis to the extents.
fn fitted(parts: &[(Solid, &Material)], size_m: DVec3) -> TexturedMesh {
    let mut mesh = TexturedMesh::default();
    parts.iter().for_each(|(solid, material)| mesh.add(solid.clone(), material));
    let scale = size_m / mesh.size_m().max(DVec3::splat(1e-9));
    mesh.seated().scaled(scale)
}

/// Points of a profile, shares of a radius or width and of a height.
fn profile(shares: &[(f64, f64)], across_m: f64, height_m: f64) -> Vec<DVec2> {
    shares.iter().map(|&(x, y)| DVec2::new(x * across_m, y * height_m)).collect()
}

fn raised(solid: Solid, z_m: f64) -> Solid {
    solid.translated(DVec3::new(0.0, 0.0, z_m))
}

pub(super) fn block(order: &mut Order) -> TexturedMesh {
    let size_m = order.size_m;
    let edge_m = (0.08 * size_m.min_element()).min(0.004);
    let outline = rounded_rectangle(size_m.x, size_m.y, 1.5 * edge_m, 6);
    in_one_piece(order, slab(&outline, size_m.z, edge_m))
}

pub(super) fn can(order: &mut Order) -> TexturedMesh {
    let DVec3 { x, y, z } = order.size_m;
    let edge_m = (0.06 * x.min(y).min(z)).min(0.003);
    in_one_piece(order, cylinder(0.5 * x, z, edge_m, SEGMENTS))
}

pub(super) fn bottle(order: &mut Order) -> TexturedMesh {
    let DVec3 { x, z, .. } = order.size_m;
    let radius_m = 0.5 * x;
    let shares = [
        (0.0, 0.0),
        (0.9, 0.0),
        (1.0, 0.03),
        (1.0, 0.58),
        (0.94, 0.65),
        (0.74, 0.72),
        (0.5, 0.77),
        (0.38, 0.82),
        (0.36, 0.93),
        (0.0, 0.93),
    ];
    let main = finish(order);
    let cap = Material::plain("cap", order.color.mix(Rgb([0.1; 3]), 0.7), 0.4);
    let body = lathe(&profile(&shares, radius_m, z), SEGMENTS);
    let cap_solid = cylinder(0.43 * radius_m, 0.12 * z, 0.01 * z, SEGMENTS);
    fitted(&[(body, &main), (raised(cap_solid, 0.88 * z), &cap)], order.size_m)
}

pub(super) fn bowl(order: &mut Order) -> TexturedMesh {
    let DVec3 { x, y, z } = order.size_m;
    let radius_m = 0.5 * x;
    let wall_m = (0.035 * x.min(y)).clamp(0.0025, 0.006).min(0.25 * radius_m).min(0.3 * z);
    let steps = 12;
    let outside: Vec<DVec2> = (0..=steps)
        .map(|k| {
            let (sin, cos) = (FRAC_PI_2 * f64::from(k) / f64::from(steps)).sin_cos();
            DVec2::new(radius_m * (0.62 + 0.38 * sin), z * (1.0 - cos))
        })
        .collect();
    in_one_piece(order, shell_of_revolution(&outside, wall_m, wall_m, SEGMENTS))
}

pub(super) fn produce(order: &mut Order) -> TexturedMesh {
    let size_m = order.size_m;
    let round = ellipsoid(size_m, 28);
    in_one_piece(order, rested(round, 0.03 * size_m.z))
}

pub(super) fn plate(order: &mut Order) -> TexturedMesh {
    let DVec3 { x, y, z } = order.size_m;
    let is_round = (x - y).abs() < ROUND * x.max(y);
    let outline = if is_round { circle(0.5 * x, 48) } else { rounded_rectangle(x, y, 0.06 * x.min(y), 8) };
    in_one_piece(order, slab(&outline, z, 0.25 * z))
}

pub(super) fn rod(order: &mut Order) -> TexturedMesh {
    let DVec3 { x, y, z } = order.size_m;
    let (length_m, width_m) = (x.max(y), x.min(y));
    let sections: Vec<_> = [(-0.5, 0.5), (-0.47, 0.78), (-0.42, 0.95), (-0.36, 1.0)]
        .iter()
        .chain(&[(0.0, 1.0)])
        .chain(&[(0.36, 1.0), (0.42, 0.95), (0.47, 0.78), (0.5, 0.5)])
        .map(|&(along, thick): &(f64, f64)| (along * length_m, 0.5 * z, 0.0, thick * z, thick * width_m))
        .collect();
    // The column's axis becomes y, its width the height.
    let along_y = DQuat::from_mat3(&DMat3::from_cols(DVec3::Z, DVec3::X, DVec3::Y));
    let turn = if x > y { DQuat::from_rotation_z(FRAC_PI_2) } else { DQuat::IDENTITY };
    let lying = column(&sections, 3.0, 24).rotated(turn * along_y);
    in_one_piece(order, lying)
}

pub(super) fn pillow(order: &mut Order) -> TexturedMesh {
    let DVec3 { x, y, z } = order.size_m;
    let steps = 10;
    let sections: Vec<_> = (0..=steps)
        .map(|k| {
            let height = f64::from(k) / f64::from(steps);
            let wide = 0.72 + 0.28 * (1.0 - (2.0 * height - 1.0).abs().powf(2.5)).powf(0.6);
            (height * z, 0.0, 0.0, wide * x, wide * y)
        })
        .collect();
    in_one_piece(order, column(&sections, 4.0, 36))
}

/// An animal or a person on an oval base. The proportions decide: a low figure has a long body with a raised head in
/// front, a tall one an upright body with the head on top.
pub(super) fn figure(order: &mut Order) -> TexturedMesh {
    let DVec3 { x, y, z } = order.size_m;
    let main = finish(order);
    let base = Material::plain("base", order.color.mix(Rgb([0.12; 3]), 0.65), 0.6);
    let foot_m = 0.06 * z;
    let foot = slab(&ellipse(x, y, 40), foot_m, 0.2 * foot_m);
    let ball = |size: [f64; 3], at: [f64; 3], segments| {
        let extents = DVec3::new(x, y, z);
        let at_m = DVec3::from_array(at) * extents;
        ellipsoid(DVec3::from_array(size) * extents, segments).translated(at_m)
    };
    let parts = if z > 1.25 * x.max(y) {
        let shares = [
            (0.0, 0.0),
            (0.38, 0.0),
            (0.34, 0.2),
            (0.3, 0.36),
            (0.36, 0.5),
            (0.3, 0.6),
            (0.13, 0.66),
            (0.0, 0.68),
        ];
        let body = raised(lathe(&profile(&shares, x, z), 28), 0.5 * foot_m);
        let head = ball([0.5, 0.5 * x / y, 0.36], [0.0, 0.0, 0.64], 24);
        vec![body, head]
    } else {
        let body = ball([0.72, 0.8, 0.62], [0.0, 0.06, 0.018], 24);
        let head = ball([0.52, 0.36, 0.52], [0.0, -0.28, 0.48], 24);
        let tail = ball([0.16, 0.12, 0.3], [0.0, 0.42, 0.3], 16);
        vec![body, head, tail]
    };
    let figure = parts.into_iter().map(|solid| (solid, &main));
    let parts: Vec<(Solid, &Material)> = [(foot, &base)].into_iter().chain(figure).collect();
    fitted(&parts, order.size_m)
}

pub(super) fn plant(order: &mut Order) -> TexturedMesh {
    let DVec3 { x, z, .. } = order.size_m;
    let clay = Material::plain("pot", Rgb::hex(0xb8_66_42), 0.8);
    let leaves = Material::textured("leaves", granite(order.color, &mut order.rng), 0.8);
    let pot = [(0.0, 0.0), (0.25, 0.0), (0.32, 0.25), (0.36, 0.26), (0.36, 0.33), (0.3, 0.33), (0.0, 0.31)];
    let foliage = [
        (0.0, 0.3),
        (0.1, 0.31),
        (0.3, 0.42),
        (0.46, 0.56),
        (0.5, 0.68),
        (0.44, 0.82),
        (0.3, 0.93),
        (0.12, 0.99),
        (0.0, 1.0),
    ];
    let [pot, foliage] = [&pot[..], &foliage].map(|shares| lathe(&profile(shares, x, z), SEGMENTS));
    fitted(&[(pot, &clay), (foliage, &leaves)], order.size_m)
}

pub(super) fn ring(order: &mut Order) -> TexturedMesh {
    let DVec3 { x, y, z } = order.size_m;
    let radius_m = 0.5 * x;
    let band_m = z.max(0.12 * x.min(y)).min(0.6 * radius_m);
    let corners = 12;
    let section: Vec<DVec2> = (0..corners)
        .map(|k| {
            // Half a step off, so that two corners touch the table.
            let (sin, cos) = (TAU * (f64::from(k) + 0.5) / f64::from(corners)).sin_cos();
            DVec2::new(radius_m - 0.5 * band_m + 0.5 * band_m * cos, 0.5 * z * (1.0 + sin))
        })
        .collect();
    in_one_piece(order, turned_ring(&section, RING_SEGMENTS))
}
