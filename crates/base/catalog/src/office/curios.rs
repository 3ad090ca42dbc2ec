//! Hourglass, puzzle cube, globe, eyeglasses.

use std::f64::consts::{PI, TAU};

use glam::DQuat;
use rand::RngExt;

use super::images::earth;
use super::parts::*;
use crate::Order;
use crate::texture::{is_finish, mapped_from_front, material_finish};
use geometry::shapes::{circle, cylinder, ellipsoid, rounded_rectangle, superellipse, sweep_closed, tube};
use geometry::{DVec2, DVec3, Material, TexturedMesh};

/// Two glass bulbs with sand between wooden plates on three turned posts.
pub fn hourglass(order: &mut Order) -> TexturedMesh {
    let size = order.size_m;
    let across = 0.5 * (size.x + size.y);
    let (r, h) = (0.5 * across, size.z);
    let wood = match order.material {
        Some(name) if is_finish(name) && name != "glass" => {
            material_finish(name, order.color, &mut order.rng)
        }
        _ => Material::plain("frame", order.color, 0.45),
    };
    let glass = Material { opacity: 0.3, ..plain("glass", 0xd8_ea_ec, 0.05) };
    let sand = plain("sand", [0xe0_b8_6a, 0xd0_8a_5a, 0x6a_a8_c8, 0xe8_d8_b0][order.pick(4)], 0.95);
    let slab = 0.07 * h;
    let mut mesh = TexturedMesh::default();
    let disc =
        [(0.94 * r, 0.0), (r, 0.15 * slab), (r, 0.55 * slab), (0.88 * r, slab), (0.6 * r, slab + 0.001)];
    let lower = turned(&disc, 40);
    let upper = turned(&disc, 40).rotated(DQuat::from_rotation_x(PI)).translated(DVec3::Z * h);
    mesh.add(lower, &wood);
    mesh.add(upper, &wood);
    let (low, high, center) = (slab, h - slab, 0.5 * h);
    let bulb = 0.62 * r;
    let half = curve(
        &[
            (0.5 * bulb, low),
            (0.96 * bulb, low + 0.04 * h),
            (bulb, low + 0.15 * h),
            (0.7 * bulb, center - 0.12 * h),
            (0.16 * bulb, center - 0.015 * h),
            (0.13 * bulb, center),
        ],
        2,
    );
    let mut outside = half.clone();
    outside.extend(half.iter().rev().skip(1).map(|&(radius, z)| (radius, h - z)));
    let wall = 0.0016;
    let radius_at = |z: f64| {
        outside
            .windows(2)
            .find(|pair| pair[0].1 <= z && z <= pair[1].1 && pair[1].1 > pair[0].1)
            .map_or(outside[0].0, |pair| {
                pair[0].0 + (pair[1].0 - pair[0].0) * (z - pair[0].1) / (pair[1].1 - pair[0].1)
            })
    };
    let mut section = outside.clone();
    section.extend(outside.iter().rev().map(|&(radius, z)| (radius - wall, z)));
    mesh.add(hoop(&section, 32), &glass);
    let fill = |from: f64, to: f64, tip: f64| {
        let mut profile: Vec<(f64, f64)> = (0..=8)
            .map(|k| {
                let z = from + (to - from) * f64::from(k) / 8.0;
                (radius_at(z) - 0.8 * wall, z)
            })
            .collect();
        profile.push((0.001, to + tip));
        turned(&profile, 32)
    };
    mesh.add(fill(low - 0.001, low + 0.12 * h, 0.07 * h), &sand);
    mesh.add(fill(center - 0.002, center + 0.14 * h, -0.03 * h), &sand);
    mesh.add(cylinder(0.0012, center - low, 0.0, 10).translated(DVec3::Z * low), &sand);
    for k in 0..3 {
        let spot = DVec2::from_angle(TAU * f64::from(k) / 3.0 + 0.5 * PI) * (0.82 * r);
        let span = high - low;
        let post = curve(
            &[
                (0.055 * r, low - 0.001),
                (0.1 * r, low + 0.06 * span),
                (0.05 * r, low + 0.14 * span),
                (0.08 * r, center),
                (0.05 * r, high - 0.14 * span),
                (0.1 * r, high - 0.06 * span),
                (0.055 * r, high + 0.001),
            ],
            2,
        );
        mesh.add(turned(&post, 12).translated(spot.extend(0.0)), &wood);
    }
    fitted(mesh, at(across, across, h))
}

/// Three by three colored stickers on each face of a black cube, scrambled.
pub fn rubiks_cube(order: &mut Order) -> TexturedMesh {
    let side = order.size_m.min_element();
    let body = plain("body", 0x14_14_17, 0.4);
    let colors = [0xf4_f4_f2, 0xf2_d0_2c, 0xc4_2a_2c, 0xe8_7a_24, 0x24_9a_50, 0x24_5a_b8];
    let finishes: Vec<Material> =
        colors.iter().map(|&rgb| plain(&format!("sticker_{rgb:06x}"), rgb, 0.3)).collect();
    // Nine of each color, shuffled (Fisher-Yates) unless it comes solved.
    let mut stickers: Vec<usize> = (0..54).map(|k| k / 9).collect();
    if order.pick(4) > 0 {
        for k in (1..54).rev() {
            stickers.swap(k, order.rng.random_range(0..=k));
        }
    }
    let raised = 0.0007;
    let half = 0.5 * side - raised;
    let cell = 2.0 * half / 3.0;
    let mut mesh = TexturedMesh::default();
    let cube = rounded(at(-half, -half, -half), at(half, half, half), 0.08 * cell, 0.05 * cell);
    mesh.add(cube, &body);
    let outline = rounded_rectangle(0.86 * cell, 0.86 * cell, 0.14 * cell, 2);
    let turns = [
        DQuat::IDENTITY,
        DQuat::from_rotation_x(PI),
        DQuat::from_rotation_x(0.5 * PI),
        DQuat::from_rotation_x(-0.5 * PI),
        DQuat::from_rotation_y(0.5 * PI),
        DQuat::from_rotation_y(-0.5 * PI),
    ];
    for (face, turn) in turns.into_iter().enumerate() {
        for k in 0..9 {
            let (column, row) = ((k % 3) as f64 - 1.0, (k / 3) as f64 - 1.0);
            let sticker = plate(&outline, half - 0.001, half + raised, 0.0).translated(at(
                column * cell,
                row * cell,
                0.0,
            ));
            mesh.add(sticker.rotated(turn), &finishes[stickers[9 * face + k]]);
        }
    }
    fitted(mesh, order.size_m)
}

/// A globe on a tilted axis in a half meridian.
pub fn globe(order: &mut Order) -> TexturedMesh {
    let size = order.size_m;
    let stand = finish_or(order, |order| {
        let name = ["walnut", "brass"][order.pick(2)];
        material_finish(name, order.color, &mut order.rng)
    });
    let brass = Material::metal("meridian", geometry::Rgb::hex(0xc4_9f_52), 0.3);
    let map = Material::textured("map", earth(order.color, &mut order.rng), 0.4);
    let (d, h) = (size.y, size.z);
    let radius = 0.5 * d;
    let tilt: f64 = 0.41;
    let axis = at(tilt.sin(), 0.0, tilt.cos());
    let aside = at(tilt.cos(), 0.0, -tilt.sin());
    let hold = 1.1 * radius;
    let center = at(0.0, 0.0, h - hold * (tilt.cos() + 0.04));
    let mut mesh = TexturedMesh::default();
    let mut ball = ellipsoid(DVec3::splat(2.0 * radius), 44).translated(DVec3::NEG_Z * radius);
    // The lathe's v runs by arc length, which is latitude.
    ball = ball.rotated(DQuat::from_rotation_z(order.uniform(0.0, TAU)));
    mesh.add(pointed(ball, center, axis), &map);
    let arc: Vec<DVec3> = (0..=36)
        .map(|k| {
            let angle = PI * f64::from(k) / 36.0;
            center + hold * (axis * angle.cos() + aside * angle.sin())
        })
        .collect();
    mesh.add(strap(&arc, 0.009, 0.005, axis), &brass);
    for end in [-1.0, 1.0] {
        let pin =
            tube(&[center + axis * (end * 0.96 * radius), center + axis * (end * 1.13 * radius)], 0.004, 12);
        mesh.add(pin, &brass);
    }
    let neck = center.z - hold + 0.003;
    let foot = 0.62 * radius;
    let profile = curve(
        &[
            (foot, 0.0),
            (foot, 0.008),
            (0.86 * foot, 0.016),
            (0.4 * foot, 0.024),
            (0.16 * foot, 0.6 * neck),
            (0.2 * foot, 0.9 * neck),
            (0.12 * foot, neck + 0.002),
        ],
        4,
    );
    mesh.add(turned(&profile, 44), &stand);
    fitted(mesh, size)
}

/// Spectacles standing on their rims and the tips of the opened temples.
pub fn eyeglasses(order: &mut Order) -> TexturedMesh {
    let size = order.size_m;
    let frame = body_finish(order, 0.35);
    let sun = order.pick(3) == 0;
    let lens = if sun {
        Material { opacity: 0.85, ..plain("lens", 0x22_26_2a, 0.08) }
    } else {
        Material { opacity: 0.28, ..plain("lens", 0xcf_e0_e8, 0.05) }
    };
    let metal = steel();
    let (w, d, h) = (size.x, size.y, size.z);
    let bar = 0.0021;
    let exponent = [2.1, 3.2, 2.6][order.pick(3)];
    let front = -0.5 * d + bar;
    let (half_width, half_height) = (0.215 * w, 0.5 * h);
    let floor = 0.0006;
    let mut mesh = TexturedMesh::default();
    for side in [-1.0, 1.0] {
        let center = at(side * 0.255 * w, front, half_height);
        let edge = superellipse(2.0 * (half_width - bar), 2.0 * (half_height - bar), exponent, 40);
        let path: Vec<DVec3> = edge.iter().map(|p| center + at(p.x, 0.0, p.y)).collect();
        let rim = sweep_closed(&path, &circle(bar, 8), DVec3::Y);
        let rim = if rim.volume_m3() > 0.0 {
            rim
        } else {
            let back: Vec<DVec3> = path.iter().rev().copied().collect();
            sweep_closed(&back, &circle(bar, 8), DVec3::Y)
        };
        mesh.add(rested(rim, floor), &frame);
        let pane = upright(&moved(&edge, p2(center.x, center.z)), front - 0.0008, front + 0.0008, 0.0);
        mesh.add(mapped_from_front(pane), &lens);
        let (outer, high) = (side * 0.472 * w, 0.74 * h);
        let temple = [
            at(outer - side * 0.012, front, high),
            at(outer, front + 0.001, high),
            at(outer + side * 0.002, front + 0.008, high),
            at(outer, -0.1 * d, 0.72 * h),
            at(0.985 * outer, 0.24 * d, 0.68 * h),
            at(0.975 * outer, 0.36 * d, 0.52 * h),
            at(0.965 * outer, 0.45 * d, 0.2 * h),
            at(0.96 * outer, 0.485 * d, bar + 0.0002),
            at(0.96 * outer, 0.5 * d - 0.0002, bar),
        ];
        mesh.add(rested(tube(&temple, bar, 10), floor), &frame);
        let hinge = board(
            at(outer - 0.002, front + 0.002, high - 0.0045),
            at(outer + 0.002, front + 0.007, high + 0.0045),
        );
        mesh.add(hinge, &metal);
        let pad =
            ellipsoid(at(0.004, 0.003, 0.011), 12).translated(at(side * 0.05 * w, front + 0.006, 0.38 * h));
        mesh.add(pad, &lens);
        let arm =
            [at(side * 0.05 * w, front + 0.006, 0.38 * h + 0.007), at(side * 0.058 * w, front, 0.55 * h)];
        mesh.add(tube(&arm, 0.0007, 6), &metal);
    }
    let bridge: Vec<DVec3> = (0..=10)
        .map(|k| {
            let angle = PI * f64::from(k) / 10.0;
            at(0.056 * w * angle.cos(), front, 0.6 * h + 0.09 * h * angle.sin())
        })
        .collect();
    mesh.add(tube(&bridge, bar, 10), &frame);
    fitted(mesh, size)
}
