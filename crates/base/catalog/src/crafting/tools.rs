//! Hobby tools: scissors, magnifying glass, hot glue gun, sorting case. Model millimeters.

use std::f64::consts::TAU;

use glam::{DVec2, DVec3};

use super::drawing::beads_image;
use crate::Order;
use crate::assembly::{
    Assembly, along_x, along_y, black, curve, lobed, main_finish, mirrored_x, points, print_plate, resting,
    turned_ring, yawed,
};
use crate::texture::label;
use geometry::shapes::{
    cylinder, lathe, rectangle, rounded_block, slab, smooth, superellipse, sweep, sweep_closed,
};
use geometry::{Material, Rgb, Solid, TexturedMesh};

/// Scissors lying a little open, points at +y.
pub(super) fn scissors(order: &mut Order) -> TexturedMesh {
    let mut object = Assembly::new();
    let grip = main_finish(order, "plastic");
    let metal = Material::metal("blade", Rgb::hex(0xc4c8cc), 0.22);
    let open = order.uniform(5.0, 9.0);
    let blade = points(&[
        (-4.5, -14.0),
        (7.0, -16.0),
        (8.0, 0.0),
        (6.5, 24.0),
        (3.0, 70.0),
        (-1.0, 98.0),
        (-2.6, 99.0),
        (-2.8, 40.0),
        (-6.0, 8.0),
    ]);
    let loop_section = superellipse(8.0, 9.0, 3.4, 14);
    let half = |level: f64| -> [(Solid, bool); 3] {
        let cutter = slab(&blade, 2.4, 0.5).translated(DVec3::Z * level);
        let (center, wide, long) = (DVec2::new(22.0, -66.0), 15.0, 25.0);
        let bow: Vec<DVec3> = (0..30)
            .map(|k| {
                let (sin, cos) = (TAU * f64::from(k) / 30.0).sin_cos();
                let tilt = DVec2::from_angle(0.16);
                let p = tilt.rotate(DVec2::new(wide * cos, long * sin)) + center;
                p.extend(4.5)
            })
            .collect();
        let arm = curve(
            &[(1.0, 2.0, level + 1.2), (4.0, -14.0, level + 1.2), (10.0, -30.0, 4.5), (16.0, -42.0, 4.5)],
            5,
        );
        let shank = sweep(&arm, &superellipse(10.0, 5.4, 3.0, 14), DVec3::Z, |t| 1.0 - 0.1 * t);
        [
            (yawed(cutter, open), true),
            (yawed(sweep_closed(&bow, &loop_section, DVec3::Z), open), false),
            (yawed(shank, open), false),
        ]
    };
    for (solid, is_metal) in half(2.6) {
        object.put(solid, [0.0; 3], if is_metal { &metal } else { &grip });
    }
    for (solid, is_metal) in half(4.6) {
        object.put(mirrored_x(solid), [0.0; 3], if is_metal { &metal } else { &grip });
    }
    object.put(
        cylinder(5.0, 8.0, 0.8, 24),
        [0.0, 4.0, 1.0],
        &Material::metal("pivot", Rgb::hex(0x85888e), 0.35),
    );
    object.put(rounded_block(DVec3::new(7.0, 1.4, 1.2), 0.3, 0.2), [0.0, 4.0, 8.6], &black());
    object.fitted(order.size_m)
}

/// Magnifying glass lying flat, handle toward -y.
pub(super) fn magnifying_glass(order: &mut Order) -> TexturedMesh {
    let mut object = Assembly::new();
    let handle_finish = match (order.material, order.pick(2)) {
        (Some(_), _) => main_finish(order, "walnut"),
        (None, 0) => Material::plain("handle", order.color, 0.35),
        _ => crate::assembly::wood(order, 0x6a452c),
    };
    let rim_finish = if order.pick(2) == 0 {
        Material::metal("brass", Rgb::hex(0xc9a24c), 0.25)
    } else {
        Material::metal("steel", Rgb::hex(0xc4c6ca), 0.25)
    };
    let rim = [
        (39.5, 0.6),
        (43.5, 0.0),
        (45.0, 1.4),
        (45.6, 7.0),
        (45.0, 12.6),
        (43.5, 14.0),
        (39.5, 13.4),
        (39.0, 7.0),
    ];
    object.put(turned_ring(&rim, 56), [0.0, 50.0, 0.0], &rim_finish);
    let lens = points(&[
        (0.0, 2.4),
        (14.0, 2.9),
        (28.0, 4.2),
        (40.0, 6.0),
        (40.0, 8.0),
        (28.0, 9.8),
        (14.0, 11.1),
        (0.0, 11.6),
    ]);
    let glass = Material { opacity: 0.32, ..Material::plain("lens", Rgb::hex(0xd8ecf4), 0.04) };
    object.put(lathe(&lens, 48), [0.0, 50.0, 0.0], &glass);
    let floor = -7.0;
    object.put(along_y(cylinder(4.0, 22.0, 0.6, 20)), [0.0, -14.0, 7.0], &rim_finish);
    let ferrule = points(&[(0.0, 0.0), (7.2, 0.0), (7.6, 2.0), (5.8, 13.0), (4.6, 15.0), (0.0, 15.0)]);
    object.put(resting(along_y(lathe(&ferrule, 28)), floor), [0.0, -23.0, 7.0], &rim_finish);
    let handle = points(&[
        (0.0, 0.0),
        (5.0, 0.0),
        (8.0, 3.0),
        (9.2, 12.0),
        (8.8, 34.0),
        (7.6, 62.0),
        (7.4, 84.0),
        (6.8, 88.0),
        (0.0, 88.0),
    ]);
    object.put(resting(along_y(lathe(&handle, 32)), floor), [0.0, -110.0, 7.0], &handle_finish);
    object.fitted(order.size_m)
}

/// Hot glue gun on its side, nozzle at +y, a glue stick in its back.
pub(super) fn hot_glue_gun(order: &mut Order) -> TexturedMesh {
    let mut object = Assembly::new();
    let shell = main_finish(order, "plastic");
    let outline = smooth(
        &points(&[
            (-17.0, -58.0),
            (-6.0, -68.0),
            (20.0, -72.0),
            (54.0, -84.0),
            (88.0, -94.0),
            (98.0, -84.0),
            (96.0, -64.0),
            (84.0, -56.0),
            (54.0, -46.0),
            (34.0, -34.0),
            (24.0, -14.0),
            (18.0, 20.0),
            (13.0, 52.0),
            (-11.0, 54.0),
            (-17.0, 30.0),
            (-18.0, -20.0),
        ]),
        3,
    );
    object.put(slab(&outline, 33.0, 6.0), [0.0; 3], &shell);
    let pad = smooth(
        &points(&[(30.0, -60.0), (58.0, -72.0), (84.0, -80.0), (88.0, -68.0), (58.0, -56.0), (38.0, -46.0)]),
        3,
    );
    object.put(slab(&pad, 3.0, 0.9), [0.0, 0.0, 31.4], &black());
    let badge = label(Rgb::hex(0x2a2c30), order.color, "HOT", &mut order.rng);
    object.put(
        yawed(print_plate(44.0, 21.0, 2.0), 90.0),
        [-1.0, 4.0, 31.8],
        &Material::textured("badge", badge, 0.5),
    );
    let trigger = points(&[(20.0, -30.0), (40.0, -38.0), (46.0, -28.0), (40.0, -8.0), (20.0, -6.0)]);
    let accent = Material::plain(
        "trigger",
        Rgb::hex(0xe8641c).mix(Rgb::hex(0x222428), if order.color.0[0] > 0.6 { 0.9 } else { 0.0 }),
        0.45,
    );
    object.put(slab(&trigger, 14.0, 2.5), [0.0, 0.0, 9.5], &accent);
    let sleeve = [(0.0, 0.0), (11.5, 0.0), (11.0, 3.0), (8.6, 18.0), (8.0, 20.0), (0.0, 20.0)];
    object.put(
        along_y(lobed(&sleeve, 10, 0.03, 40)),
        [0.0, 50.0, 16.5],
        &Material::plain("sleeve", Rgb::hex(0xd8521c), 0.7),
    );
    let nozzle = points(&[(0.0, 0.0), (7.0, 0.0), (7.0, 5.0), (5.0, 7.0), (2.0, 19.0), (0.0, 19.4)]);
    object.put(
        along_y(lathe(&nozzle, 24)),
        [0.0, 69.0, 16.5],
        &Material::metal("nozzle", Rgb::hex(0xc9a24c), 0.3),
    );
    let stick = Material { opacity: 0.85, ..Material::plain("glue", Rgb::hex(0xf2ecd8), 0.3) };
    object.put(along_y(cylinder(5.6, 58.0, 0.6, 24)), [2.0, -116.0, 16.5], &stick);
    for (x, y) in [(-8.0, -46.0), (74.0, -76.0), (2.0, 44.0)] {
        object.put(cylinder(2.8, 2.0, 0.3, 16), [x, y, 31.6 + if x > 50.0 { 2.0 } else { 0.0 }], &black());
    }
    object.fitted(order.size_m)
}

/// Flat sorting case: clear lid, compartments of beads, latches and a handle in front.
pub(super) fn storage_case(order: &mut Order) -> TexturedMesh {
    let mut object = Assembly::new();
    let tray = main_finish(order, "plastic");
    let (width, depth, height, wall) = (250.0, 170.0, 38.0, 3.0);
    object.put(rounded_block(DVec3::new(width, depth, 3.6), 8.0, 1.0), [0.0; 3], &tray);
    for y in [-1.0, 1.0] {
        let side = slab(&rectangle(width - 6.0, wall), height - 1.0, 0.5);
        object.put(side, [0.0, y * 0.5 * (depth - wall), 0.6], &tray);
        object.put(
            slab(&rectangle(wall, depth - 6.0), height - 1.0, 0.5),
            [y * 0.5 * (width - wall), 0.0, 0.6],
            &tray,
        );
    }
    let divider = Material::plain("divider", order.color.mix(Rgb([1.0; 3]), 0.6), 0.4);
    for x in [-62.0, 0.0, 62.0] {
        object.put(slab(&rectangle(2.2, depth - 4.0), 33.0, 0.4), [x, 0.0, 2.0], &divider);
    }
    object.put(slab(&rectangle(width - 4.0, 2.2), 33.0, 0.4), [0.0, 0.0, 2.4], &divider);
    let hues = [0xd82c2c, 0xf4c428, 0x2f9a58, 0x2c6cc8, 0xc03a8a, 0xf07c1e, 0x7a4ab0, 0x26a0b0].map(Rgb::hex);
    let first = order.pick(8);
    for k in 0..8 {
        let (column, row) = (k % 4, k / 4);
        let hue = hues[(first + 3 * k) % 8];
        let mixed = [hue, hue.mix(Rgb([1.0; 3]), 0.35), hue.scaled(0.75), hues[(first + k) % 8]];
        let image = beads_image(if k % 3 == 2 { &mixed } else { &mixed[..3] }, order);
        let level = order.uniform(14.0, 25.0);
        let fill = rounded_block(DVec3::new(59.0, 79.0, level), 5.0, 3.0).with_box_uvs(40.0);
        let at = [-93.0 + 62.0 * column as f64, -41.0 + 82.0 * row as f64, 2.6];
        object.put(fill, at, &Material::textured("beads", image, 0.35));
    }
    let clear = Material { opacity: 0.22, ..Material::plain("lid", Rgb::hex(0xe4eef4), 0.08) };
    object.put(
        rounded_block(DVec3::new(width - 2.0, depth - 2.0, 3.4), 7.0, 1.0),
        [0.0, 0.0, height - 1.6],
        &clear,
    );
    for x in [-72.0, 72.0] {
        object.put(
            rounded_block(DVec3::new(28.0, 7.0, 22.0), 2.0, 1.2),
            [x, -0.5 * depth - 1.0, 17.0],
            &black(),
        );
    }
    let handle = curve(
        &[
            (-34.0, -0.5 * depth + 1.0, 18.0),
            (-30.0, -0.5 * depth - 15.0, 18.0),
            (0.0, -0.5 * depth - 20.0, 18.0),
            (30.0, -0.5 * depth - 15.0, 18.0),
            (34.0, -0.5 * depth + 1.0, 18.0),
        ],
        5,
    );
    object.put(sweep(&handle, &superellipse(8.0, 12.0, 3.0, 14), DVec3::Z, |_| 1.0), [0.0; 3], &black());
    for x in [-80.0, 80.0] {
        object.put(along_x(cylinder(3.4, 34.0, 0.5, 16)), [x - 17.0, 0.5 * depth + 1.0, height - 3.0], &tray);
    }
    object.fitted(order.size_m)
}
