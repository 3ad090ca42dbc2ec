//! Smartphone, tablet, calculator, remote control, game controller.

use std::f64::consts::TAU;

use rand::RngExt;

use super::images::{home_screen, lcd};
use super::parts::*;
use crate::Order;
use crate::texture::mapped_from_above;
use geometry::shapes::{circle, inset, loft, rounded_rectangle, smooth};
use geometry::{DVec2, Material, Solid, TexturedMesh};

/// Lying on its back, home screen lit.
pub fn smartphone(order: &mut Order) -> TexturedMesh {
    let size = order.size_m;
    let body = body_finish(order, 0.3);
    let rows = 5;
    slate(order, &body, 0.011, 0.0032, 4, rows, size)
}

/// Lying on its back; wider margins, a stylus beside the screen on some.
pub fn tablet(order: &mut Order) -> TexturedMesh {
    let size = order.size_m;
    let body = body_finish(order, 0.3);
    slate(order, &body, 0.012, 0.011, 5, 5, size)
}

fn slate(
    order: &mut Order,
    body: &Material,
    corner: f64,
    margin: f64,
    columns: i32,
    rows: i32,
    size: geometry::DVec3,
) -> TexturedMesh {
    let (w, d, h) = (size.x, size.y, size.z);
    let glass = plain("glass_front", 0x0c_0d_0f, 0.12);
    let screen = Material::textured("screen", home_screen(columns, rows, &mut order.rng), 0.12);
    let trim = Material::metal("buttons", body.base_color.scaled(0.85), 0.35);
    let mut mesh = TexturedMesh::default();
    let bump = 0.0006;
    let side = 0.0008;
    let (bw, top) = (w - 2.0 * side, h - bump);
    mesh.add(rounded(at(-0.5 * bw, -0.5 * d, 0.0), at(0.5 * bw, 0.5 * d, top), corner, 0.0022), body);
    let face = rounded_rectangle(bw - 0.002, d - 0.002, corner - 0.001, 5);
    mesh.add(plate(&face, top - 0.0022, top + 0.5 * bump, 0.0004), &glass);
    let lit = rounded_rectangle(bw - 2.0 * margin, d - 2.0 * margin, (corner - margin).max(0.001), 4);
    mesh.add(mapped_from_above(plate(&lit, top - 0.001, h, 0.0)), &screen);
    for (x, y, long) in [(0.5, 0.18, 0.018), (-0.5, 0.24, 0.012), (-0.5, 0.15, 0.012), (0.5, -0.4, 0.006)] {
        let x = x * bw;
        mesh.add(
            rounded(
                at(x - side, y * d - 0.5 * long, 0.35 * h),
                at(x + side, y * d + 0.5 * long, 0.65 * h),
                0.0006,
                0.0004,
            ),
            &trim,
        );
    }
    fitted(mesh, size)
}

/// Sloped display above five rows of round-cornered keys.
pub fn calculator(order: &mut Order) -> TexturedMesh {
    let size = order.size_m;
    let body = body_finish(order, 0.5);
    let number = order.rng.random_range(100..99_999);
    let display = Material::textured("display", lcd(&format!("{number}.{}", number % 10)), 0.25);
    let dark = body.base_color.0.iter().sum::<f32>() < 1.3;
    let keys = if dark { plain("digit_keys", 0xe8_e6_e0, 0.5) } else { plain("digit_keys", 0x3a_3d_42, 0.5) };
    let (function, operator) =
        (plain("function_keys", 0x7d_86_92, 0.5), plain("operator_keys", 0xe0_7a_2c, 0.5));
    let (w, d, h) = (size.x, size.y, size.z);
    let cap = 0.003;
    let (low, high) = (0.55 * h, h - 0.001);
    let fold = 0.2 * d;
    let profile = [
        p2(-0.5 * d, 0.0),
        p2(0.5 * d, 0.0),
        p2(0.5 * d, high - 0.002),
        p2(0.5 * d - 0.003, high),
        p2(fold, low),
        p2(-0.5 * d + 0.003, low),
        p2(-0.5 * d, low - 0.003),
    ];
    let mut mesh = TexturedMesh::default();
    mesh.add(side_on(&profile, -0.5 * w, 0.5 * w, 0.002), &body);
    let lean = ((high - low) / (0.5 * d - fold - 0.003)).atan();
    let tilt = glam::DQuat::from_rotation_x(lean);
    let center = at(0.0, 0.5 * (fold + 0.5 * d), 0.5 * (low + high));
    let tall = (0.5 * d - fold) * 0.72;
    let place = |solid: Solid| solid.rotated(tilt).translated(center);
    mesh.add(
        place(plate(&rounded_rectangle(0.88 * w, tall * 1.2, 0.003, 3), -0.002, 0.0005, 0.0003)),
        &plain("bezel", 0x15_16_18, 0.4),
    );
    mesh.add(
        place(mapped_from_above(plate(
            &rounded_rectangle(0.78 * w, tall * 0.85, 0.001, 2),
            -0.001,
            0.0011,
            0.0,
        ))),
        &display,
    );
    let (columns, rows) = (4, 5);
    let (pitch_x, pitch_y) = (0.88 * w / f64::from(columns), (0.66 * d) / f64::from(rows));
    for row in 0..rows {
        for column in 0..columns {
            let x = (f64::from(column) + 0.5) * pitch_x - 0.44 * w;
            let y = fold - 0.02 * d - (f64::from(row) + 0.5) * pitch_y;
            let finish = match (row, column) {
                (0, 0) => &operator,
                (0, _) => &function,
                (_, 3) => &operator,
                _ => &keys,
            };
            let outline = moved(&rounded_rectangle(0.78 * pitch_x, 0.72 * pitch_y, 0.0025, 3), p2(x, y));
            mesh.add(button(&outline, low - 0.001, low + cap, 0.001), finish);
        }
    }
    fitted(mesh, size)
}

/// A long wand of keys: power, digits, a direction ring, volume and channel rockers.
pub fn remote_control(order: &mut Order) -> TexturedMesh {
    let size = order.size_m;
    let body = body_finish(order, 0.45);
    let light = body.base_color.0.iter().sum::<f32>() > 1.5;
    let keys = if light { plain("keys", 0x4a_4d_52, 0.6) } else { plain("keys", 0xc9_cb_ce, 0.6) };
    let (w, d, h) = (size.x, size.y, size.z);
    let top = h - 0.0022;
    let mut mesh = TexturedMesh::default();
    let case = rounded(at(-0.5 * w, -0.5 * d, 0.0), at(0.5 * w, 0.5 * d, top), 0.25 * w, 0.004);
    // Slightly waisted where the fingers hold it.
    let waisted = |p: geometry::DVec3| {
        let t = (p.y / d + 0.08) / 0.42;
        at(p.x * (1.0 - 0.1 * (1.0 - t * t).max(0.0)), p.y, p.z)
    };
    mesh.add(bent(case, waisted), &body);
    let mut key = |x: f64, y: f64, wide: f64, tall: f64, finish: &Material| {
        let outline = rounded_rectangle(wide * w, tall * w, 0.45 * tall.min(wide) * w, 3);
        mesh.add(button(&moved(&outline, p2(x * w, y * d)), top - 0.0012, h, 0.0007), finish);
    };
    let [red, green, yellow, blue] = [0xd0_3a_30, 0x3c_a0_50, 0xe8_c0_30, 0x35_6f_c8]
        .map(|rgb| plain(&format!("key_{rgb:06x}"), rgb, 0.5));
    key(-0.28, 0.43, 0.2, 0.2, &red);
    key(0.28, 0.43, 0.2, 0.2, &keys);
    for row in 0..4 {
        for column in 0..3 {
            key(0.28 * f64::from(column - 1), 0.345 - 0.062 * f64::from(row), 0.2, 0.17, &keys);
        }
    }
    key(-0.28, 0.06, 0.18, 0.42, &keys);
    key(0.28, 0.06, 0.18, 0.42, &keys);
    for (k, finish) in [&red, &green, &yellow, &blue].into_iter().enumerate() {
        key(0.21 * (k as f64 - 1.5), -0.29, 0.15, 0.1, finish);
    }
    for column in 0..3 {
        key(0.26 * f64::from(column - 1), -0.36, 0.18, 0.12, &keys);
    }
    let pad = moved(&circle(0.34 * w, 36), p2(0.0, -0.13 * d));
    mesh.add(button(&pad, top - 0.001, top + 0.0016, 0.0008), &keys);
    let center = moved(&circle(0.13 * w, 24), p2(0.0, -0.13 * d));
    mesh.add(button(&center, top, h + 0.0003, 0.0005), &body);
    fitted(mesh, size)
}

/// Two grips, two sticks, a direction cross and four colored buttons.
pub fn game_controller(order: &mut Order) -> TexturedMesh {
    let size = order.size_m;
    let body = body_finish(order, 0.4);
    let light = body.base_color.0.iter().sum::<f32>() > 1.5;
    let trim = if light { plain("trim", 0x2a_2b_2e, 0.6) } else { plain("trim", 0x9a_9d_a2, 0.55) };
    let stick = plain("sticks", 0x1b_1c_1e, 0.8);
    let (w, d, h) = (size.x, size.y, size.z);
    let half = [
        (0.0, 0.34),
        (0.2, 0.4),
        (0.34, 0.5),
        (0.44, 0.36),
        (0.49, 0.02),
        (0.5, -0.3),
        (0.43, -0.49),
        (0.33, -0.42),
        (0.23, -0.13),
        (0.1, -0.07),
    ];
    let mut corners: Vec<DVec2> = half.iter().rev().map(|&(x, y)| p2(x * w, y * d)).collect();
    corners.extend(half.iter().skip(1).map(|&(x, y)| p2(-x * w, y * d)));
    let top = 0.66 * h;
    let mut mesh = TexturedMesh::default();
    // The control polygon is shrunk, not the fine outline, so that narrow grips stay simple curves;
    // the grips are lower than the center.
    let levels = [(0.0065, 0.0), (0.002, 0.12), (0.0, 0.3), (0.001, 0.46), (0.0035, 0.59), (0.0075, 0.66)];
    let rings: Vec<Vec<geometry::DVec3>> = levels
        .iter()
        .map(|&(by, z)| {
            let droop = |y: f64| if y < -0.1 * d { 1.0 - 0.35 * (-y / d - 0.1) / 0.4 } else { 1.0 };
            smooth(&inset(&corners, by), 4).iter().map(|p| p.extend(z * h * droop(p.y))).collect()
        })
        .collect();
    mesh.add(loft(&rings), &body);
    let mut disc = |x: f64, y: f64, radius: f64, low: f64, high: f64, finish: &Material| {
        let outline = moved(&circle(radius, 24), p2(x * w, y * d));
        mesh.add(button(&outline, low, high, 0.001), finish);
    };
    let unit = 0.16 * w;
    for (x, y) in [(-0.145, 0.0), (0.145, 0.0)] {
        disc(x, y, 0.46 * unit, top - 0.002, top + 0.0018, &trim);
        disc(x, y, 0.2 * unit, top, top + 0.2 * h, &stick);
        disc(x, y, 0.34 * unit, top + 0.19 * h, h, &stick);
    }
    for (k, rgb) in [0x3c_a0_50, 0xd0_3a_30, 0x35_6f_c8, 0xe8_c0_30].into_iter().enumerate() {
        let spot = DVec2::from_angle(TAU * (k as f64 + 3.0) / 4.0) * 0.055;
        let finish = plain(&format!("button_{rgb:06x}"), rgb, 0.35);
        disc(0.32 + spot.x, 0.2 + spot.y * w / d, 0.028 * w, top - 0.003, top + 0.004, &finish);
    }
    disc(0.0, 0.2, 0.032 * w, top - 0.002, top + 0.0015, &trim);
    for x in [-0.09, 0.09] {
        disc(x, 0.24, 0.012 * w, top - 0.002, top + 0.0018, &trim);
    }
    let (arm, reach) = (0.024 * w, 0.068 * w);
    let cross = [
        p2(arm, arm),
        p2(arm, reach),
        p2(-arm, reach),
        p2(-arm, arm),
        p2(-reach, arm),
        p2(-reach, -arm),
        p2(-arm, -arm),
        p2(-arm, -reach),
        p2(arm, -reach),
        p2(arm, -arm),
        p2(reach, -arm),
        p2(reach, arm),
    ]
    .map(|p| 0.9 * p + p2(-0.32 * w, 0.2 * d));
    mesh.add(plate(&cross, top - 0.003, top + 0.004, 0.001), &stick);
    for side in [-1.0, 1.0] {
        let x = side * 0.33 * w;
        mesh.add(
            rounded(at(x - 0.07 * w, 0.43 * d, 0.3 * h), at(x + 0.07 * w, 0.52 * d, 0.62 * h), 0.008, 0.004),
            &trim,
        );
    }
    fitted(mesh, size)
}
