//! Pen, pencil, pen holder, stapler, tape dispenser, letter tray.

use glam::DQuat;
use rand::RngExt;

use super::images::{lattice, page_edges};
use super::parts::*;
use crate::Order;
use crate::texture::{mapped_from_above, printed_page};
use geometry::shapes::{circle, rounded_rectangle, smooth};
use geometry::{DVec3, Material, Rgb, TexturedMesh};

/// Ballpoint lying on a flat of its barrel, tip away from the viewer, clip on top.
pub fn pen(order: &mut Order) -> TexturedMesh {
    let size = order.size_m;
    let body = body_finish(order, 0.3);
    let (grip, metal) = (plain("grip", 0x24_26_2a, 0.75), steel());
    let d = size.y;
    let r = 0.5 * size.x;
    let floor = -0.86 * r;
    let mut mesh = TexturedMesh::default();
    let capped = order.pick(2) == 0;
    let barrel = [(0.86 * r, -0.44 * d), (0.94 * r, -0.42 * d), (r, -0.1 * d), (r, 0.22 * d)];
    mesh.add(rested(turned_along_y(&barrel, 32), floor), &body);
    let rings: Vec<(f64, f64)> = (0..=12)
        .map(|k| {
            let y = 0.215 + 0.14 * f64::from(k) / 12.0;
            (r * if k % 2 == 0 { 1.0 } else { 0.93 }, y * d)
        })
        .collect();
    mesh.add(rested(turned_along_y(&rings, 32), floor), &grip);
    let tip = [
        (0.92 * r, 0.352 * d),
        (0.7 * r, 0.4 * d),
        (0.3 * r, 0.465 * d),
        (0.18 * r, 0.47 * d),
        (0.12 * r, 0.5 * d),
    ];
    mesh.add(rested(turned_along_y(&tip, 24), floor), &metal);
    let band = [(1.04 * r, -0.105 * d), (1.04 * r, -0.085 * d)];
    mesh.add(rested(turned_along_y(&band, 32), floor), &metal);
    if capped {
        mesh.add(
            rested(
                turned_along_y(&[(0.5 * r, -0.5 * d), (0.8 * r, -0.485 * d), (0.9 * r, -0.435 * d)], 24),
                floor,
            ),
            &metal,
        );
    } else {
        mesh.add(
            rested(
                turned_along_y(&[(0.4 * r, -0.5 * d), (0.52 * r, -0.493 * d), (0.52 * r, -0.43 * d)], 24),
                floor,
            ),
            &metal,
        );
    }
    let clip = [
        p2(-0.43 * d, 0.6 * r),
        p2(-0.12 * d, 1.12 * r),
        p2(-0.1 * d, 0.95 * r),
        p2(-0.085 * d, 1.3 * r),
        p2(-0.12 * d, 1.45 * r),
        p2(-0.43 * d, 1.4 * r),
        p2(-0.445 * d, 1.1 * r),
    ];
    mesh.add(side_on(&clip, -0.28 * r, 0.28 * r, 0.0), &metal);
    fitted(mesh, size)
}

/// Hexagonal, lying on a flat; sharpened end away from the viewer, ferrule and eraser toward them.
pub fn pencil(order: &mut Order) -> TexturedMesh {
    let size = order.size_m;
    let finish = body_finish(order, 0.4);
    let (wood, lead) = (plain("cut_wood", 0xdd_b8_84, 0.7), plain("lead", 0x2b_2b_2e, 0.5));
    let (ferrule, eraser) =
        (Material::metal("ferrule", Rgb::hex(0xc9_b8_6a), 0.35), plain("eraser", 0xe0_8a_8a, 0.85));
    let (r, d) = (0.5 * size.x, size.y);
    let mut mesh = TexturedMesh::default();
    mesh.add(turned_along_y(&[(r, -0.43 * d), (r, 0.37 * d), (0.93 * r, 0.375 * d)], 6), &finish);
    mesh.add(turned_along_y(&[(0.9 * r, 0.37 * d), (0.28 * r, 0.468 * d)], 32), &wood);
    mesh.add(turned_along_y(&[(0.29 * r, 0.466 * d), (0.05 * r, 0.5 * d)], 16), &lead);
    let crimped: Vec<(f64, f64)> = (0..=8)
        .map(|k| ((if k % 2 == 0 { 0.84 } else { 0.78 }) * r, (-0.474 + 0.046 * f64::from(k) / 8.0) * d))
        .collect();
    mesh.add(turned_along_y(&crimped, 24), &ferrule);
    mesh.add(
        turned_along_y(&[(0.5 * r, -0.5 * d), (0.74 * r, -0.494 * d), (0.76 * r, -0.47 * d)], 24),
        &eraser,
    );
    let stamp = board(at(-0.16 * r, -0.36 * d, 0.84 * r), at(0.16 * r, -0.2 * d, 0.9 * r));
    mesh.add(stamp, &ferrule);
    fitted(mesh, size)
}

/// A cup for pens: round or square, wire mesh or solid, with rims and a second compartment.
pub fn pen_holder(order: &mut Order) -> TexturedMesh {
    let size = order.size_m;
    let body = body_finish(order, 0.5);
    let rim = Material::plain("rim", body.base_color.scaled(0.7), 0.4);
    let walls = if order.material.is_none() && order.rng.random_range(0..3) < 2 {
        Material::textured("mesh_wall", lattice(body.base_color.scaled(1.1)), 0.5)
    } else {
        body.clone()
    };
    let (w, d, h) = (size.x, size.y, size.z);
    let round = order.pick(2) == 0;
    let edge = if round { circle(0.5, 48) } else { rounded_rectangle(1.0, 1.0, 0.12, 5) };
    let outline: Vec<_> = edge.iter().map(|p| *p * p2(w - 0.003, d - 0.003)).collect();
    let mut mesh = TexturedMesh::default();
    let wall = 0.0028;
    let mut shell = cup(&outline, h - 0.001, wall, 0.004);
    shell.uvs.iter_mut().for_each(|uv| *uv *= geometry::Vec2::new(8.0, 5.0));
    mesh.add(shell, &walls);
    for (low, high) in [(0.0, 0.007), (h - 0.006, h)] {
        let band: Vec<_> = edge.iter().map(|p| *p * p2(w, d)).collect();
        let inner = geometry::shapes::inset(&band, 0.0055);
        let ring =
            |line: &[geometry::DVec2], z: f64| line.iter().map(|p| p.extend(z)).collect::<Vec<DVec3>>();
        mesh.add(
            geometry::shapes::loft_closed(&[
                ring(&inner, low),
                ring(&band, low),
                ring(&band, high),
                ring(&inner, high),
            ]),
            &rim,
        );
    }
    fitted(mesh, size)
}

/// Mouth away from the viewer: base with anvil, steel magazine, cushioned arm, hinge.
pub fn stapler(order: &mut Order) -> TexturedMesh {
    let size = order.size_m;
    let body = body_finish(order, 0.35);
    let (dark, metal) = (plain("cushion", 0x26_28_2b, 0.7), steel());
    let (w, d, h) = (size.x, size.y, size.z);
    let p = |y: f64, z: f64| p2(y * d, z * h);
    let mut mesh = TexturedMesh::default();
    let base =
        [p(-0.48, 0.0), p(0.5, 0.0), p(0.5, 0.1), p(0.42, 0.15), p(-0.25, 0.13), p(-0.4, 0.3), p(-0.48, 0.3)];
    mesh.add(side_on(&base, -0.5 * w, 0.5 * w, 0.0025), &dark);
    let anvil =
        rounded(at(-0.2 * w, 0.34 * d, 0.1 * h), at(0.2 * w, 0.45 * d, 0.15 * h + 0.001), 0.002, 0.0005);
    mesh.add(anvil, &metal);
    let magazine = [p(-0.45, 0.22), p(0.47, 0.43), p(0.47, 0.58), p(-0.45, 0.42)];
    mesh.add(side_on(&magazine, -0.3 * w, 0.3 * w, 0.001), &metal);
    let arm = smooth(
        &[
            p(-0.5, 0.34),
            p(-0.3, 0.36),
            p(0.1, 0.47),
            p(0.46, 0.56),
            p(0.5, 0.66),
            p(0.48, 0.8),
            p(0.3, 0.92),
            p(0.0, 0.98),
            p(-0.3, 0.86),
            p(-0.48, 0.62),
        ],
        4,
    );
    mesh.add(side_on(&arm, -0.42 * w, 0.42 * w, 0.003), &body);
    let pad = [p(0.02, 0.95), p(0.3, 0.89), p(0.42, 0.82), p(0.42, 0.87), p(0.3, 0.96), p(0.02, 1.01)];
    mesh.add(side_on(&pad, -0.3 * w, 0.3 * w, 0.001), &dark);
    let pin = turned_along_x(&[(0.07 * h, -0.46 * w), (0.07 * h, 0.46 * w)], 20);
    mesh.add(pin.translated(at(0.0, -0.41 * d, 0.33 * h)), &metal);
    fitted(mesh, size)
}

/// A weighted holder with a roll of clear tape and a toothed cutter toward the viewer.
pub fn tape_dispenser(order: &mut Order) -> TexturedMesh {
    let size = order.size_m;
    let body = body_finish(order, 0.4);
    let tape = Material { opacity: 1.0, ..plain("tape", 0xd9_cf_a0, 0.25) };
    let (core, metal) = (plain("core", 0xf0_ee_e8, 0.6), steel());
    let (w, d, h) = (size.x, size.y, size.z);
    let p = |y: f64, z: f64| p2(y * d, z * h);
    let mut mesh = TexturedMesh::default();
    let cheek = smooth(
        &[
            p(-0.49, 0.02),
            p(0.0, 0.0),
            p(0.48, 0.02),
            p(0.5, 0.25),
            p(0.4, 0.52),
            p(0.2, 0.66),
            p(0.0, 0.5),
            p(-0.2, 0.27),
            p(-0.4, 0.42),
            p(-0.5, 0.46),
        ],
        5,
    );
    let cheek: Vec<_> = cheek.iter().map(|q| p2(q.x, q.y.max(0.0))).collect();
    for (left, right) in [(-0.5, -0.36), (0.36, 0.5)] {
        mesh.add(side_on(&cheek, left * w, right * w, 0.002), &body);
    }
    let floor = [
        p(-0.48, 0.0),
        p(0.48, 0.0),
        p(0.48, 0.2),
        p(0.3, 0.16),
        p(-0.2, 0.16),
        p(-0.4, 0.34),
        p(-0.48, 0.4),
    ];
    mesh.add(side_on(&floor, -0.37 * w, 0.37 * w, 0.0), &body);
    let center = at(0.0, 0.15 * d, 0.57 * h);
    let radius = 0.43 * h;
    let roll = |inner: f64, outer: f64, half: f64| {
        hoop(&[(inner, -half), (outer, -half), (outer, half), (inner, half)], 40)
            .rotated(DQuat::from_rotation_y(0.5 * std::f64::consts::PI))
            .translated(center)
    };
    mesh.add(roll(0.55 * radius, radius, 0.27 * w), &tape);
    mesh.add(roll(0.38 * radius, 0.57 * radius, 0.29 * w), &core);
    mesh.add(
        turned_along_x(&[(0.4 * radius, -0.33 * w), (0.4 * radius, 0.33 * w)], 28).translated(center),
        &body,
    );
    let axle = [(0.14 * radius, -0.44 * w), (0.14 * radius, 0.44 * w)];
    mesh.add(turned_along_x(&axle, 16).translated(center), &metal);
    let strip = [
        at(0.0, 0.15 * d - 0.6 * radius, 0.57 * h + 0.79 * radius),
        at(0.0, -0.2 * d, 0.6 * h),
        at(0.0, -0.455 * d, 0.475 * h),
    ];
    mesh.add(strap(&strip, 0.54 * w, 0.0013, DVec3::Z), &tape);
    let teeth = 10;
    let mut blade = vec![p2(-0.3 * w, 0.36 * h), p2(0.3 * w, 0.36 * h)];
    for k in 0..=2 * teeth {
        let x = 0.3 * w - 0.6 * w * f64::from(k) / f64::from(2 * teeth);
        blade.push(p2(x, if k % 2 == 0 { 0.5 * h } else { 0.45 * h }));
    }
    mesh.add(upright(&blade, -0.49 * d, -0.49 * d + 0.0015, 0.0), &metal);
    fitted(mesh, size)
}

/// Two trays on posts, open toward the viewer; printed sheets in the lower one.
pub fn file_tray(order: &mut Order) -> TexturedMesh {
    let size = order.size_m;
    let body = body_finish(order, 0.45);
    let print = Material::textured("printed_sheet", printed_page(Rgb::hex(0xfa_f9_f5), &mut order.rng), 0.9);
    let sheets = Material::textured("sheets", page_edges(Rgb::hex(0xf4_f2_ec), &mut order.rng), 0.9);
    let post = Material::metal("posts", Rgb::hex(0x8d_90_95), 0.35);
    let (w, d, h) = (size.x, size.y, size.z);
    let (wall, side) = (0.003, 0.42 * h);
    let lips = order.pick(2) == 0;
    let mut mesh = TexturedMesh::default();
    for z in [0.0, h - side] {
        mesh.add(rounded(at(-0.5 * w, -0.5 * d, z), at(0.5 * w, 0.5 * d, z + wall), 0.01, 0.0), &body);
        for x in [-0.5 * w, 0.5 * w - wall] {
            // Side walls slope down toward the open front.
            let profile = [
                p2(-0.47 * d, z + 0.001),
                p2(0.49 * d, z + 0.001),
                p2(0.49 * d, z + side),
                p2(-0.2 * d, z + side),
                p2(-0.44 * d, z + 0.35 * side),
            ];
            mesh.add(side_on(&profile, x, x + wall, 0.0), &body);
        }
        let back = rounded(
            at(-0.495 * w, 0.5 * d - wall, z + 0.001),
            at(0.495 * w, 0.5 * d, z + side - 0.0004),
            0.001,
            0.0,
        );
        mesh.add(back, &body);
        if lips {
            mesh.add(
                board(at(-0.49 * w, -0.5 * d + 0.001, z + 0.001), at(-0.18 * w, -0.5 * d + 0.004, z + 0.014)),
                &body,
            );
            mesh.add(
                board(at(0.18 * w, -0.5 * d + 0.001, z + 0.001), at(0.49 * w, -0.5 * d + 0.004, z + 0.014)),
                &body,
            );
        }
    }
    for (x, y) in [(-1.0, -0.3), (1.0, -0.3), (-1.0, 0.42), (1.0, 0.42)] {
        let column = turned(&[(0.003, 0.3 * side), (0.003, h - 0.3 * side)], 12);
        mesh.add(column.translated(at(x * (0.5 * w - 0.005), y * d, 0.0)), &post);
    }
    for k in 0..3 {
        let low = wall - 0.0005 + 0.0035 * f64::from(k);
        let turn = DQuat::from_rotation_z(0.012 * (f64::from(k) - 1.0));
        let sheet = rounded(at(-0.44 * w, -0.46 * d, low), at(0.44 * w, 0.46 * d, low + 0.004), 0.001, 0.0);
        mesh.add(mapped_from_above(sheet).rotated(turn), if k == 2 { &print } else { &sheets });
    }
    fitted(mesh, size)
}
