//! Containers: toolbox, storage bin, paint can, oil can, glue bottle. Model
//! millimeters.

use glam::DVec3;

use crate::Order;
use crate::assembly::{
    Assembly, across_x, along_x, black, column, curve, front_plate, lobed, main_finish, plastic, points,
    steel, yawed,
};
use crate::texture::{label, wrap_label, wrapped_around};
use geometry::shapes::{circle, cylinder, ellipsoid, lathe, prism, rounded_block, superellipse, sweep, tube};
use geometry::{Material, Rgb, TexturedMesh};

/// Closed toolbox with a carrying handle and two latches in front.
pub(super) fn toolbox(order: &mut Order) -> TexturedMesh {
    let mut object = Assembly::new();
    let body = main_finish(order, "plastic");
    let trim = if order.material.is_some() { plastic(order.color) } else { black() };
    let metal = steel(order);
    object.put(rounded_block(DVec3::new(372.0, 180.0, 112.0), 12.0, 4.0), [0.0; 3], &body);
    for x in [-150.0, -75.0, 0.0, 75.0, 150.0] {
        object.put(rounded_block(DVec3::new(14.0, 184.0, 84.0), 3.0, 1.5), [x, 0.0, 10.0], &body);
    }
    let lid = points(&[
        (-95.0, 106.0),
        (95.0, 106.0),
        (95.0, 120.0),
        (88.0, 130.0),
        (58.0, 150.0),
        (-58.0, 150.0),
        (-88.0, 130.0),
        (-95.0, 120.0),
    ]);
    object.put(across_x(&lid, 384.0, 5.0), [0.0; 3], &trim);
    object.put(rounded_block(DVec3::new(300.0, 70.0, 6.0), 8.0, 2.0), [0.0, 0.0, 147.0], &body);
    let grip = curve(
        &[
            (-92.0, 0.0, 146.0),
            (-90.0, 0.0, 168.0),
            (-72.0, 0.0, 184.0),
            (0.0, 0.0, 188.0),
            (72.0, 0.0, 184.0),
            (90.0, 0.0, 168.0),
            (92.0, 0.0, 146.0),
        ],
        5,
    );
    object.put(sweep(&grip, &superellipse(24.0, 13.0, 3.0, 16), DVec3::Y, |_| 1.0), [0.0; 3], &trim);
    for x in [-115.0, 115.0] {
        object.put(rounded_block(DVec3::new(36.0, 8.0, 48.0), 3.0, 1.5), [x, -94.0, 78.0], &metal);
        object.put(rounded_block(DVec3::new(22.0, 8.0, 16.0), 3.0, 1.5), [x, -97.0, 82.0], &metal);
    }
    let badge =
        Material::textured("badge", label(Rgb::hex(0xf0eee6), order.color, "TOOLS", &mut order.rng), 0.5);
    object.put(front_plate(86.0, 44.0, 3.0), [0.0, -92.6, 56.0], &badge);
    object.put(rounded_block(DVec3::new(22.0, 8.0, 18.0), 3.0, 1.0), [0.0, -95.0, 96.0], &metal);
    object.fitted(order.size_m)
}

/// Open-fronted stacking bin, a card in its label holder.
pub(super) fn storage_bin(order: &mut Order) -> TexturedMesh {
    let mut object = Assembly::new();
    let finish = main_finish(order, "plastic");
    let wall = 3.4;
    let side = points(&[
        (-82.0, 0.0),
        (82.0, 0.0),
        (86.0, 78.0),
        (84.0, 80.0),
        (-10.0, 80.0),
        (-40.0, 52.0),
        (-86.0, 46.0),
    ]);
    for x in [-52.0, 52.0] {
        object.put(across_x(&side, wall, 0.8), [x, 0.0, 0.0], &finish);
    }
    object.put(rounded_block(DVec3::new(104.0, 164.0, 3.6), 3.0, 0.8), [0.0, 0.0, 0.0], &finish);
    let back = points(&[(79.0, 0.5), (82.4, 0.5), (86.3, 79.0), (82.9, 79.0)]);
    object.put(across_x(&back, 103.0, 0.0), [0.0; 3], &finish);
    let front = points(&[(-82.4, 0.5), (-79.0, 0.5), (-83.0, 45.5), (-86.4, 45.5)]);
    object.put(across_x(&front, 103.0, 0.0), [0.0; 3], &finish);
    // Rolled rims.
    object.put(along_x(cylinder(3.0, 110.0, 0.8, 16)), [-55.0, -87.0, 45.0], &finish);
    object.put(along_x(cylinder(3.0, 110.0, 0.8, 16)), [-55.0, 86.0, 79.0], &finish);
    let rim = [(0.0, 88.0, 79.5), (0.0, -10.0, 79.5), (0.0, -41.0, 51.5), (0.0, -88.0, 45.5)];
    object.put_pair(&tube(&crate::assembly::path(&rim), 3.2, 12), [53.0, 0.0, 0.0], &finish);
    let holder = Material::plain("holder", order.color.scaled(0.7), 0.5);
    let lean = |solid| crate::assembly::pitched(solid, 5.0);
    object.put(lean(front_plate(70.0, 26.0, 4.0)), [0.0, -83.8, 24.0], &holder);
    let word = ["M6", "NUTS", "BOLTS", "MISC"][order.pick(4)];
    let card =
        Material::textured("card", label(Rgb::hex(0xf6f4ec), Rgb::hex(0x305078), word, &mut order.rng), 0.8);
    object.put(lean(front_plate(60.0, 20.0, 2.0)), [0.0, -85.6, 24.2], &card);
    object.fitted(order.size_m)
}

/// Paint can: beaded tin, label around, wire bail, drips of its color over the rim.
pub(super) fn paint_can(order: &mut Order) -> TexturedMesh {
    let mut object = Assembly::new();
    let metal = steel(order);
    let tin = points(&[
        (0.0, 0.0),
        (53.0, 0.0),
        (55.0, 1.5),
        (55.0, 4.5),
        (52.5, 6.5),
        (52.5, 112.0),
        (55.0, 114.0),
        (55.5, 118.0),
        (53.5, 120.5),
        (50.0, 120.0),
        (48.5, 115.5),
        (45.5, 115.5),
        (44.0, 119.0),
        (40.0, 119.0),
        (38.0, 116.5),
        (0.0, 116.5),
    ]);
    object.put(lathe(&tin, 48), [0.0; 3], &metal);
    let accents = [0xf2f0ea, 0x2a2c30, 0xe8c03a];
    let ground = Rgb::hex(accents[order.pick(3)]);
    let paper = Material::textured("label", wrap_label(ground, order.color, "PAINT", &mut order.rng), 0.5);
    object.put(wrapped_around(prism(&circle(53.1, 48), 92.0)), [0.0, 0.0, 13.0], &paper);
    let paint = Material::plain("paint", order.color, 0.25);
    object.put(
        lobed(&[(0.0, 0.0), (27.0, 0.0), (24.0, 1.4), (0.0, 1.8)], 3, 0.09, 40),
        [3.0, -4.0, 115.8],
        &paint,
    );
    let runs = 3 + order.pick(3);
    for k in 0..runs {
        let angle = order.uniform(-25.0, 25.0) + 360.0 * k as f64 / runs as f64 - 70.0;
        let length = order.uniform(14.0, 44.0);
        let run = column(
            &[
                (-length, 54.6, 0.0, 1.0, 1.0),
                (2.0 - length, 54.6, 0.0, 5.0, 5.5),
                (8.0 - length, 54.4, 0.0, 4.6, 5.0),
                (-3.0, 55.0, 0.0, 5.0, 9.0),
                (1.0, 53.0, 0.0, 9.0, 12.0),
                (2.6, 51.5, 0.0, 5.0, 8.0),
            ],
            2.0,
            14,
        );
        object.put(yawed(run, angle), [0.0, 0.0, 119.0], &paint);
    }
    for x in [-1.0, 1.0] {
        object.put(along_x(cylinder(6.0, 7.0, 1.0, 20)), [55.0 * x - 3.5, 0.0, 98.0], &metal);
    }
    let bail = curve(
        &[
            (-60.0, 0.0, 98.0),
            (-58.0, 12.0, 92.0),
            (-48.0, 38.0, 74.0),
            (0.0, 64.0, 56.0),
            (48.0, 38.0, 74.0),
            (58.0, 12.0, 92.0),
            (60.0, 0.0, 98.0),
        ],
        5,
    );
    let wire = Material::metal("bail", Rgb::hex(0x9a9ca0), 0.35);
    object.put(tube(&bail, 1.5, 10), [0.0; 3], &wire);
    for x in [-59.0, 59.0] {
        object.put(ellipsoid(DVec3::splat(6.0), 12), [x, 0.0, 95.0], &wire);
    }
    object.fitted(order.size_m)
}

/// Pump oiler: domed tin, long bent spout toward +x, thumb lever behind.
pub(super) fn oil_can(order: &mut Order) -> TexturedMesh {
    let mut object = Assembly::new();
    let tin = main_finish(order, "plastic");
    let brass = Material::metal("brass", Rgb::hex(0xc9a24c), 0.28);
    let dome = points(&[
        (0.0, 0.0),
        (40.0, 0.0),
        (42.0, 2.0),
        (42.0, 5.0),
        (40.0, 7.0),
        (40.0, 32.0),
        (42.0, 34.0),
        (41.0, 38.0),
        (33.0, 48.0),
        (21.0, 57.0),
        (13.0, 62.0),
        (12.0, 66.0),
        (0.0, 66.0),
    ]);
    object.put(lathe(&dome, 44), [0.0; 3], &tin);
    let paper = Material::textured(
        "label",
        wrap_label(Rgb::hex(0xf0e6c8), order.color.scaled(0.8), "OIL", &mut order.rng),
        0.5,
    );
    object.put(wrapped_around(prism(&circle(40.7, 44), 23.0)), [0.0, 0.0, 8.0], &paper);
    object.put(
        lobed(&[(0.0, 0.0), (14.5, 0.0), (14.5, 9.0), (12.0, 11.0), (0.0, 11.0)], 16, 0.03, 48),
        [0.0, 0.0, 63.0],
        &brass,
    );
    let spout = curve(
        &[(0.0, 0.0, 70.0), (2.0, 0.0, 92.0), (14.0, 0.0, 118.0), (42.0, 0.0, 146.0), (82.0, 0.0, 166.0)],
        7,
    );
    object.put(sweep(&spout, &circle(5.4, 16), DVec3::Y, |t| 1.0 - 0.62 * t), [0.0; 3], &brass);
    let lever = curve(
        &[(-6.0, 0.0, 68.0), (-26.0, 0.0, 84.0), (-52.0, 0.0, 82.0), (-66.0, 0.0, 62.0), (-64.0, 0.0, 38.0)],
        5,
    );
    object.put(sweep(&lever, &superellipse(4.0, 16.0, 3.0, 14), DVec3::Z, |_| 1.0), [0.0; 3], &tin);
    let grip = curve(
        &[(-38.0, 0.0, 30.0), (-52.0, 0.0, 36.0), (-56.0, 0.0, 24.0), (-52.0, 0.0, 12.0), (-38.0, 0.0, 10.0)],
        5,
    );
    object.put(sweep(&grip, &superellipse(4.0, 13.0, 3.0, 14), DVec3::Y, |_| 1.0), [0.0; 3], &tin);
    object.fitted(order.size_m)
}

/// White-glue bottle: oval body, label, twist cap with a nozzle.
pub(super) fn glue_bottle(order: &mut Order) -> TexturedMesh {
    let mut object = Assembly::new();
    let body = main_finish(order, "plastic");
    let accent = Rgb::hex([0xe86a1c, 0x2a5ca8, 0xc82c32][order.pick(3)]);
    let shape = [
        (0.0, 0.0, 0.0, 54.0, 34.0),
        (3.0, 0.0, 0.0, 60.0, 39.0),
        (20.0, 0.0, 0.0, 62.0, 40.0),
        (98.0, 0.0, 0.0, 61.0, 39.0),
        (114.0, 0.0, 0.0, 56.0, 37.0),
        (126.0, 0.0, 0.0, 44.0, 33.0),
        (133.0, 0.0, 0.0, 30.0, 27.0),
        (138.0, 0.0, 0.0, 25.0, 25.0),
        (144.0, 0.0, 0.0, 25.0, 25.0),
    ];
    object.put(column(&shape, 2.4, 44), [0.0; 3], &body);
    let paper = Material::textured(
        "label",
        wrap_label(Rgb::hex(0x244f9a).mix(accent, 0.0), accent, "GLUE", &mut order.rng),
        0.45,
    );
    let sleeve = column(&[(0.0, 0.0, 0.0, 63.0, 41.0), (66.0, 0.0, 0.0, 62.6, 40.6)], 2.4, 44);
    object.put(wrapped_around(sleeve), [0.0, 0.0, 24.0], &paper);
    let cap = Material::plain("cap", accent, 0.4);
    object.put(
        lobed(&[(0.0, 0.0), (14.0, 0.0), (13.6, 16.0), (11.0, 19.0), (0.0, 19.0)], 18, 0.03, 54),
        [0.0, 0.0, 141.0],
        &cap,
    );
    let nozzle = points(&[
        (0.0, 0.0),
        (9.0, 0.0),
        (7.5, 10.0),
        (4.6, 26.0),
        (5.6, 28.0),
        (5.4, 33.0),
        (3.4, 36.0),
        (0.0, 36.0),
    ]);
    object.put(lathe(&nozzle, 24), [0.0, 0.0, 159.0], &cap);
    object.fitted(order.size_m)
}
