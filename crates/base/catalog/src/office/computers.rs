//! Laptop, monitor, keyboard, mouse.

use glam::DQuat;

use super::images::desktop;
use super::parts::*;
use crate::Order;
use crate::texture::mapped_from_front;
use geometry::shapes::{loft, rounded_rectangle, superellipse, sweep};
use geometry::{DVec3, Material, Rgb, Solid, TexturedMesh};

/// Open, screen leaning back about fifteen degrees, keys and touchpad on the deck.
pub fn laptop(order: &mut Order) -> TexturedMesh {
    let size = order.size_m;
    let body = body_finish(order, 0.4);
    let screen = Material::textured("screen", desktop(&mut order.rng), 0.2);
    let (bezel, key) = (plain("bezel", 0x16_17_19, 0.4), plain("keys", 0x22_23_26, 0.5));
    let lean = order.uniform(0.2, 0.32);
    let (thick, lid) = (0.016, 0.007);
    let length = (size.z - thick) / lean.cos();
    let depth = size.y - (length * lean.sin() - 0.004).max(0.0);
    let (w, front) = (size.x, -0.5 * size.y);
    let back = front + depth;
    let mut mesh = TexturedMesh::default();
    mesh.add(rounded(at(-0.5 * w, front, 0.0), at(0.5 * w, back, thick), 0.012, 0.003), &body);
    let deck = rounded(
        at(-0.44 * w, back - 0.6 * depth, thick - 0.001),
        at(0.44 * w, back - 0.08 * depth, thick + 0.0006),
        0.004,
        0.0003,
    );
    mesh.add(deck, &bezel);
    let (rows, pitch) = (5, 0.5 * depth / 5.0);
    for row in 0..rows {
        let y = back - 0.11 * depth - (f64::from(row) + 0.5) * pitch;
        for (x, width) in key_row(row, 0.86 * w) {
            mesh.add(key_cap(at(x, y, thick), at(width - 0.003, pitch - 0.003, 0.0022), 0.0008), &key);
        }
    }
    let pad = rounded(
        at(-0.16 * w, front + 0.06 * depth, thick - 0.001),
        at(0.16 * w, front + 0.36 * depth, thick + 0.0007),
        0.004,
        0.0003,
    );
    let pad_finish = Material::plain("touchpad", body.base_color.scaled(0.8), 0.3);
    mesh.add(pad, &pad_finish);
    let turn = DQuat::from_rotation_x(-lean);
    let hinge = at(0.0, back - 0.012, thick - 0.004);
    let outline: Vec<_> =
        rounded_rectangle(w, length, 0.012, 5).iter().map(|p| p2(p.x, p.y + 0.5 * length)).collect();
    let stand = |solid: Solid| solid.rotated(turn).translated(hinge);
    mesh.add(stand(upright(&outline, 0.0, lid, 0.002)), &body);
    let inner: Vec<_> = rounded_rectangle(0.97 * w, 0.93 * length, 0.006, 4)
        .iter()
        .map(|p| p2(p.x, p.y + 0.5 * length))
        .collect();
    mesh.add(stand(upright(&inner, -0.0006, 0.001, 0.0003)), &bezel);
    let image: Vec<_> = rounded_rectangle(0.92 * w, 0.83 * length, 0.001, 1)
        .iter()
        .map(|p| p2(p.x, p.y + 0.52 * length))
        .collect();
    mesh.add(stand(mapped_from_front(upright(&image, -0.0012, 0.0, 0.0))), &screen);
    for side in [-0.32, 0.32] {
        let barrel = turned_along_x(&[(0.005, -0.02), (0.005, 0.02)], 16);
        mesh.add(barrel.translated(at(side * w, back - 0.01, thick - 0.001)), &bezel);
    }
    fitted(mesh, size)
}

/// Centers and widths of the keys in one row of a keyboard `width` across; row 4 holds the space bar.
fn key_row(row: i32, width: f64) -> Vec<(f64, f64)> {
    let shares: &[f64] = match row {
        0 => &[1.0; 14],
        1 => &[1.5, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.5],
        2 => &[1.75, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 2.25],
        3 => &[2.25, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 2.75],
        _ => &[1.25, 1.25, 1.25, 5.5, 1.25, 1.25, 1.25, 1.0],
    };
    let unit = width / shares.iter().sum::<f64>();
    let mut left = -0.5 * width;
    shares
        .iter()
        .map(|share| {
            let center = left + 0.5 * share * unit;
            left += share * unit;
            (center, share * unit)
        })
        .collect()
}

/// A wide screen on a neck and foot.
pub fn monitor(order: &mut Order) -> TexturedMesh {
    let size = order.size_m;
    let body = body_finish(order, 0.45);
    let bezel = plain("bezel", 0x14_15_17, 0.35);
    let screen = Material::textured("screen", desktop(&mut order.rng), 0.15);
    let (w, h) = (size.x, size.z);
    let panel_low = 0.24 * h;
    let height = h - panel_low;
    let front = -0.12 * size.y;
    let mut mesh = TexturedMesh::default();
    let centered = |width: f64, tall: f64, corner: f64| -> Vec<_> {
        rounded_rectangle(width, tall, corner, 4)
            .iter()
            .map(|p| p2(p.x, p.y + panel_low + 0.5 * height))
            .collect()
    };
    mesh.add(upright(&centered(w, height, 0.008), front, front + 0.022, 0.003), &bezel);
    mesh.add(upright(&centered(0.8 * w, 0.7 * height, 0.02), front + 0.02, front + 0.05, 0.008), &body);
    let lift = 0.012 * height;
    let image: Vec<_> =
        centered(w - 0.018, height - 0.032, 0.001).iter().map(|p| p2(p.x, p.y + lift)).collect();
    mesh.add(mapped_from_front(upright(&image, front - 0.0007, front + 0.001, 0.0)), &screen);
    let lamp = turned_along_y(&[(0.002, -0.0008), (0.002, 0.001)], 10);
    mesh.add(lamp.translated(at(0.44 * w, front, panel_low + 0.008)), &plain("power_light", 0x4f_d0_6a, 0.4));
    let neck_y = front + 0.06;
    mesh.add(
        rounded(
            at(-0.03, neck_y - 0.014, 0.006),
            at(0.03, neck_y + 0.014, panel_low + 0.4 * height),
            0.01,
            0.002,
        ),
        &body,
    );
    if order.pick(2) == 0 {
        mesh.add(
            rounded(at(-0.22 * w, -0.5 * size.y, 0.0), at(0.22 * w, 0.5 * size.y, 0.012), 0.03, 0.003),
            &body,
        );
    } else {
        let foot = superellipse(0.5 * w, size.y, 2.3, 48);
        mesh.add(plate(&foot, 0.0, 0.012, 0.004), &body);
    }
    fitted(mesh, size)
}

/// Sloped case, five rows of keys and a function row, cursor keys and a number pad.
pub fn keyboard(order: &mut Order) -> TexturedMesh {
    let size = order.size_m;
    let body = body_finish(order, 0.5);
    let dark = body.base_color.0.iter().sum::<f32>() < 1.2;
    let key = if dark { plain("keys", 0x3c_3e_43, 0.55) } else { plain("keys", 0xf4_f3_ef, 0.5) };
    let special =
        if dark { plain("side_keys", 0x55_58_5f, 0.55) } else { plain("side_keys", 0xb8_ba_bd, 0.5) };
    let accent = Material::plain("accent_key", Rgb::hex(0xe0_6a_3a), 0.5);
    let (w, d, h) = (size.x, size.y, size.z);
    let cap = 0.35 * h;
    let (low, high) = (0.45 * h, h - cap);
    let mut mesh = TexturedMesh::default();
    let profile = [
        p2(-0.5 * d, 0.0),
        p2(0.5 * d, 0.0),
        p2(0.5 * d, high - 0.001),
        p2(0.5 * d - 0.003, high),
        p2(-0.5 * d + 0.004, low),
        p2(-0.5 * d, low - 0.003),
    ];
    mesh.add(side_on(&profile, -0.5 * w, 0.5 * w, 0.0015), &body);
    let slope = ((high - low) / d).atan();
    let tilt = DQuat::from_rotation_x(slope);
    let pitch = 0.88 * d / 6.0;
    let full = order.pick(2) == 0;
    let main_width = if full { 0.64 * w } else { 0.95 * w };
    let main_center = if full { -0.155 * w } else { 0.0 };
    let mut add = |x: f64, row: f64, width: f64, tall: f64, finish: &Material| {
        let y = 0.44 * d - (row + 0.5 * tall) * pitch;
        let z = low + (y + 0.5 * d) * (high - low) / d - 0.001;
        let solid = key_cap(DVec3::ZERO, at(width - 0.0024, tall * pitch - 0.0024, cap), 0.0016);
        mesh.add(solid.rotated(tilt).translated(at(x, y, z)), finish);
    };
    for k in 0..14 {
        let unit = main_width / 14.0;
        let x = main_center - 0.5 * main_width + (f64::from(k) + 0.5) * unit;
        add(x, 0.0, unit, 0.9, if k == 0 { &accent } else { &special });
    }
    for row in 0..5 {
        let keys = key_row(row, main_width);
        let last = keys.len() - 1;
        for (k, (x, width)) in keys.into_iter().enumerate() {
            let finish = if row == 2 && k == last {
                &accent
            } else if (k == 0 || k == last || row == 4) && width < 0.3 * main_width && (k != 3 || row != 4) {
                &special
            } else {
                &key
            };
            add(main_center + x, 1.0 + f64::from(row), width, 1.0, finish);
        }
    }
    if full {
        let unit = main_width / 14.5;
        let cursor = main_center + 0.5 * main_width + 0.35 * unit;
        for column in 0..3 {
            let x = cursor + (f64::from(column) + 0.5) * unit;
            [1.0, 2.0, 5.0].into_iter().for_each(|row| add(x, row, unit, 1.0, &special));
        }
        add(cursor + 1.5 * unit, 4.0, unit, 1.0, &special);
        let pad = cursor + 3.35 * unit;
        let pad_unit = (0.485 * w - pad) / 4.0;
        for row in 0..5 {
            for column in 0..4 {
                let x = pad + (f64::from(column) + 0.5) * pad_unit;
                let finish = if row == 0 || column == 3 { &special } else { &key };
                add(x, 1.0 + f64::from(row), pad_unit, 1.0, finish);
            }
        }
    }
    fitted(mesh, size)
}

/// Rounded hump with two buttons and a wheel.
pub fn mouse(order: &mut Order) -> TexturedMesh {
    let size = order.size_m;
    let body = body_finish(order, 0.35);
    let seam = Material::plain("seam", body.base_color.scaled(0.35), 0.6);
    let (w, d, h) = (size.x, size.y, size.z);
    let crest = order.uniform(0.05, 0.2);
    let exponent = order.uniform(2.3, 2.9);
    // Height of the back over the table at depth y: highest a little behind the center.
    let hump = |y: f64| {
        let t = (y / (0.5 * d) - crest) / (1.0 + crest);
        h * (1.0 - 0.42 * t * t)
    };
    let levels = 10;
    let rings: Vec<Vec<DVec3>> = (0..=levels)
        .map(|k| {
            let t = f64::from(k) / f64::from(levels);
            let reach =
                (1.0 - t.powf(2.6)).max(0.0).powf(1.0 / 2.6).max(if k == levels { 0.0 } else { 0.02 });
            superellipse(w * reach, d * reach, exponent, 40)
                .iter()
                .map(|p| {
                    let waist = 1.0 - 0.1 * (1.0 - (2.0 * p.y / d).powi(2)) * (1.0 - t);
                    at(p.x * waist, p.y, t * hump(p.y))
                })
                .collect()
        })
        .collect();
    let mut mesh = TexturedMesh::default();
    mesh.add(loft(&rings), &body);
    // Where the hump's ridge runs at depth y, including the rounding toward the front.
    let ridge = |y: f64| {
        let s = (y.abs() / (0.5 * d)).min(0.999);
        (1.0 - s.powf(2.6)).powf(1.0 / 2.6) * hump(y)
    };
    let along: Vec<DVec3> = (0..=12)
        .map(|k| {
            let y = -0.485 * d + 0.5 * d * f64::from(k) / 12.0;
            at(0.0, y, ridge(y) - 0.0006)
        })
        .collect();
    let section = rounded_rectangle(0.0018, 0.0024, 0.0003, 1);
    mesh.add(sweep(&along, &section, DVec3::Z, |_| 1.0), &seam);
    let cross_y = 0.015 * d;
    let across: Vec<DVec3> = (-8..=8)
        .map(|k| {
            let x = 0.42 * w * f64::from(k) / 8.0;
            let s = (2.0 * x / w).abs();
            at(x, cross_y, (1.0 - s.powf(2.6)).powf(1.0 / 2.6) * ridge(cross_y) - 0.0007)
        })
        .collect();
    mesh.add(sweep(&across, &section, DVec3::Z, |_| 1.0), &seam);
    let wheel_y = -0.27 * d;
    let wheel = turned_along_x(&[(0.006, -0.0035), (0.0085, -0.0025), (0.0085, 0.0025), (0.006, 0.0035)], 24);
    mesh.add(wheel.translated(at(0.0, wheel_y, ridge(wheel_y) - 0.0045)), &plain("wheel", 0x2b_2c_2f, 0.7));
    // In use the buttons point away from the person.
    fitted(mesh.rotated(DQuat::from_rotation_z(std::f64::consts::PI)), size)
}
