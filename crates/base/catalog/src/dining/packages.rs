//! Packages and carriers: milk carton, cereal box, napkin holder, toaster, tray, basket.

use std::f64::consts::PI;

use glam::{DQuat, DVec2, DVec3};

use super::assembly::{add_by, finish, fitted, repeated, spline};
use crate::Order;
use crate::texture::{
    brushed_metal, crust, draw_text, fill_disc, fill_rectangle, label, mapped_on_box, printed_page, stripes,
    text_width_px, wicker, wood_grain,
};
use geometry::shapes::{
    block, circle, cylinder, ellipse, loft, prism, rounded_block, rounded_rectangle, slab, smooth,
    superellipse, sweep, sweep_closed,
};
use geometry::{Material, Rgb, Solid, TexturedMesh};
use imaging::{Image, Texture};

/// A label with an image in its lower half.
fn pictured(base: &Texture, draw: impl Fn(&mut Image)) -> Texture {
    let mut image: Image = (**base).clone();
    draw(&mut image);
    Texture::new(image)
}

fn front_or_side(n: DVec3) -> usize {
    if n.y.abs() > 0.6 {
        0
    } else if n.x.abs() > 0.6 {
        1
    } else {
        2
    }
}

pub(super) fn milk_carton(order: &mut Order) -> TexturedMesh {
    let DVec3 { x: w, y: d, z: h } = order.size_m;
    let white = Rgb([0.96, 0.96, 0.95]);
    let accent = order.color;
    let front = pictured(&label(white, accent, "MILK", &mut order.rng), |image| {
        fill_rectangle(image, 0, 200, 256, 56, accent);
        for (x, y, r) in [(40, 196, 26), (96, 204, 30), (160, 198, 28), (220, 204, 26)] {
            fill_disc(image, x, y, r, accent);
        }
    });
    let front = Material::textured("front", front, 0.5);
    let side = pictured(&printed_page(white, &mut order.rng), |image| {
        fill_rectangle(image, 0, 200, 256, 56, accent);
    });
    let side = Material::textured("side", side, 0.5);
    let gable = Material::plain("gable", accent, 0.5);
    let body_h = 0.74 * h;
    let corner = 0.0025;
    let box_ring = |inset: f64, z: f64| -> Vec<DVec3> {
        rounded_rectangle(w - 2.0 * inset, d - 2.0 * inset, corner, 3).iter().map(|p| p.extend(z)).collect()
    };
    let body = loft(&[
        box_ring(0.0012, 0.0),
        box_ring(0.0, 0.0012),
        box_ring(0.0, 0.5 * body_h),
        box_ring(0.0, body_h),
    ]);
    let mut mesh = TexturedMesh::default();
    add_by(&mut mesh, mapped_on_box(body), &[&front, &side, &gable], |_, n| front_or_side(n));
    // The roof folds together along x; its ends are tucked in.
    let roof_ring = |wide: f64, deep: f64, z: f64| -> Vec<DVec3> {
        rounded_rectangle(wide, deep, corner.min(0.3 * deep), 3).iter().map(|p| p.extend(z)).collect()
    };
    let fin = 0.9 * h;
    let roof = loft(&[
        roof_ring(w - 0.0004, d - 0.0004, body_h - 0.0006),
        roof_ring(w - 0.0004, 0.52 * d, 0.5 * (body_h + fin)),
        roof_ring(w - 0.0004, 0.005, fin),
        roof_ring(w - 0.0004, 0.0042, h),
    ]);
    let paper = Material::plain("paper", white, 0.5);
    add_by(&mut mesh, roof, &[&gable, &paper], |c, _| usize::from(c.z > fin));
    for side in [-1.0, 1.0] {
        // Tucked gable ends, darker.
        let tri: Vec<DVec2> = [(-0.42 * d, 0.0), (0.42 * d, 0.0), (0.0, 0.82 * (fin - body_h))]
            .map(|(x, y)| DVec2::new(x, y))
            .to_vec();
        let flap = prism(&tri, 0.0022)
            .rotated(DQuat::from_rotation_x(0.5 * PI))
            .rotated(DQuat::from_rotation_z(0.5 * PI));
        let at = DVec3::new(side * 0.5 * w + if side > 0.0 { -0.0018 } else { -0.0006 }, 0.0, body_h + 0.002);
        mesh.add(flap.translated(at), &Material::plain("flap", accent.scaled(0.72), 0.6));
    }
    let slope = (0.5 * d).atan2(fin - body_h);
    let cap = cylinder(0.013, 0.014, 0.002, 28);
    let cap = cap.rotated(DQuat::from_rotation_x(0.5 * PI - slope));
    let at = DVec3::new(0.0, -0.25 * d - 0.0005, 0.5 * (body_h + fin) - 0.004);
    mesh.add(cap.translated(at), &Material::plain("cap", Rgb([0.97, 0.97, 0.97]).mix(accent, 0.1), 0.35));
    fitted(mesh, order.size_m)
}

pub(super) fn cereal_box(order: &mut Order) -> TexturedMesh {
    let DVec3 { x: w, y: d, z: h } = order.size_m;
    let color = order.color;
    let accent = if color.0[2] > color.0[0] { Rgb::hex(0xf2_c2_3a) } else { Rgb::hex(0xf8_f2_e2) };
    let words = ["FLAKES", "OATS", "CRUNCH", "LOOPS", "MUESLI"];
    let word = words[order.pick(words.len())];
    let blank: Texture = Texture::new(Image::filled(256, 256, color.to_rgba8()));
    let scale = (228 / text_width_px(word, 1)).min(8);
    let sunny = order.pick(2) == 0;
    let front = pictured(&blank, |image| {
        if sunny {
            fill_disc(image, 128, 66, 88, accent.mix(color, 0.55));
        } else {
            fill_rectangle(image, 0, 20, 256, 92, accent.mix(color, 0.55));
        }
        // A white bowl full of cereal.
        fill_disc(image, 128, 176, 74, Rgb([0.96, 0.96, 0.97]));
        fill_rectangle(image, 40, 100, 176, 72, color);
        fill_rectangle(image, 40, 100, 176, 12, if sunny { color } else { accent.mix(color, 0.55) });
        for k in 0..46 {
            let (x, y) = (62 + (k * 37) % 134, 150 + (k * 53) % 24 - ((k * 29) % 13));
            let tone = if k % 3 == 0 { 0xb8_70_22 } else { 0xd9_96_3a };
            fill_disc(image, x, y, 8, Rgb::hex(tone));
        }
        fill_rectangle(image, 50, 172, 156, 5, Rgb([0.84, 0.85, 0.88]));
        fill_rectangle(image, 0, 244, 256, 12, accent);
        let ink = Rgb([0.98, 0.97, 0.94]);
        draw_text(image, word, 131 - text_width_px(word, scale) / 2, 41, scale, color.scaled(0.4));
        draw_text(image, word, 128 - text_width_px(word, scale) / 2, 38, scale, ink);
    });
    let front = Material::textured("front", front, 0.45);
    let facts = pictured(&printed_page(color.mix(Rgb([1.0; 3]), 0.82), &mut order.rng), |image| {
        fill_rectangle(image, 0, 0, 256, 34, color);
        fill_rectangle(image, 0, 222, 256, 34, color);
    });
    let facts = Material::textured("facts", facts, 0.5);
    let board = Material::plain("cardboard", color.scaled(0.9), 0.7);
    let mut mesh = TexturedMesh::default();
    let body = rounded_block(DVec3::new(w, d, h - 0.0012), 0.0022, 0.0012);
    add_by(&mut mesh, mapped_on_box(body), &[&front, &facts, &board], |_, n| front_or_side(n));
    // Top flaps and the tab that closes them.
    let flap =
        block(DVec3::new(w - 0.006, 0.55 * d, 0.0016)).translated(DVec3::new(0.0, 0.2 * d, h - 0.0018));
    mesh.add(flap, &board);
    let tab = slab(&rounded_rectangle(0.3 * w, 0.3 * d, 0.006, 4), 0.0016, 0.0003);
    mesh.add(tab.translated(DVec3::new(0.0, -0.14 * d, h - 0.0016)), &Material::plain("tab", accent, 0.6));
    fitted(mesh, order.size_m)
}

pub(super) fn napkin_holder(order: &mut Order) -> TexturedMesh {
    let DVec3 { x: w, y: d, z: h } = order.size_m;
    let metal = order.pick(2) == 0;
    let usual = if metal {
        let texture = brushed_metal(Rgb::hex(0xc0_c2_c4), &mut order.rng);
        Material { metalness: 1.0, ..Material::textured("steel", texture, 0.3) }
    } else {
        Material::textured("wood", wood_grain(order.color, &mut order.rng), 0.5)
    };
    let frame = finish(order, usual);
    let mut mesh = TexturedMesh::default();
    let foot = slab(&rounded_rectangle(w, d, 0.008, 5), 0.006, 0.0015);
    mesh.add(foot.with_box_uvs(0.12), &frame);
    // Arched side panels, standing.
    let panel_h = 0.82 * h;
    let mut arch: Vec<DVec2> = vec![DVec2::new(-0.47 * w, 0.0), DVec2::new(0.47 * w, 0.0)];
    arch.extend((0..=16).map(|k| {
        let angle = PI * f64::from(k) / 16.0;
        DVec2::new(0.47 * w * angle.cos(), panel_h * (0.5 + 0.5 * angle.sin()))
    }));
    let panel = slab(&arch, 0.005, 0.001).rotated(DQuat::from_rotation_x(0.5 * PI)).with_box_uvs(0.12);
    for y in [-0.5 * d + 0.0075, 0.5 * d - 0.0025] {
        mesh.add(panel.clone().translated(DVec3::new(0.0, y, 0.0055)), &frame);
    }
    let paper = order.pick(3);
    let napkin_color = [Rgb([0.97, 0.97, 0.96]), Rgb::hex(0xc8_4a_3e), Rgb::hex(0x8f_b0_c4)][paper];
    let sheets = stripes(napkin_color, napkin_color.scaled(0.8), 24);
    let sheets = Material::textured("napkins", sheets, 0.95);
    // A stack of folded napkins: sheets show on the upper and side edges, folds in waves at the top.
    let n = 24;
    let deep = d - 0.0155;
    let stack: Vec<DVec2> = {
        let mut top: Vec<DVec2> = (0..=n)
            .map(|k| {
                let t = f64::from(k) / f64::from(n);
                let tooth = if k % 2 == 0 { 0.0 } else { 0.0022 };
                DVec2::new(deep * (0.5 - t), h - 0.0066 - tooth - 0.006 * (2.0 * t - 1.0).powi(2))
            })
            .collect();
        let mut outline = vec![DVec2::new(-0.5 * deep, 0.0), DVec2::new(0.5 * deep, 0.0)];
        outline.append(&mut top);
        outline
    };
    let wide = 0.88 * w;
    let napkins = prism(&stack, wide)
        .rotated(DQuat::from_rotation_x(0.5 * PI))
        .rotated(DQuat::from_rotation_z(0.5 * PI))
        .translated(DVec3::new(-0.5 * wide, 0.0, 0.0055));
    let mut napkins = napkins;
    for (uv, p) in napkins.uvs.iter_mut().zip(&napkins.positions) {
        *uv = geometry::Vec2::new((p.x / w) as f32, (p.y / deep + 0.5) as f32);
    }
    mesh.add(napkins, &sheets);
    fitted(mesh, order.size_m)
}

/// A slice of toast standing in the x-z plane, its center at y.
fn toast(w: f64, h: f64, thick: f64) -> Solid {
    let outline: Vec<DVec2> = smooth(
        &[
            (-0.42, 0.0),
            (0.0, 0.0),
            (0.42, 0.0),
            (0.44, 0.4),
            (0.5, 0.68),
            (0.42, 0.94),
            (0.18, 0.985),
            (0.0, 0.95),
            (-0.18, 0.985),
            (-0.42, 0.94),
            (-0.5, 0.68),
            (-0.44, 0.4),
        ]
        .map(|(x, z): (f64, f64)| DVec2::new(x * w, z * h)),
        3,
    );
    slab(&outline, thick, 0.0015).rotated(DQuat::from_rotation_x(0.5 * PI)).translated(DVec3::Y * 0.5 * thick)
}

pub(super) fn toaster(order: &mut Order) -> TexturedMesh {
    let DVec3 { x: w, y: d, z: h } = order.size_m;
    let with_toast = order.pick(2) == 0;
    let body_h = if with_toast { 0.86 * h } else { h - 0.001 };
    let color = order.color;
    let shiny = color.0[0] > 0.72 && (color.0[0] - color.0[2]).abs() < 0.06;
    let usual = if shiny {
        Material { metalness: 1.0, ..Material::textured("steel", brushed_metal(color, &mut order.rng), 0.25) }
    } else {
        Material::plain("enamel", color, 0.25)
    };
    let shell = finish(order, usual);
    let black = Material::plain("plastic", Rgb([0.09, 0.09, 0.1]), 0.5);
    let chrome = Material::metal("chrome", Rgb::hex(0xd0_d2_d4), 0.2);
    let glow = Material::plain("slot", Rgb::hex(0x2a_18_12), 0.9);
    let mut mesh = TexturedMesh::default();
    let long = w - 0.018;
    let foot_h = 0.012;
    let base = slab(&rounded_rectangle(long - 0.012, d - 0.012, 0.028, 5), 0.024, 0.003);
    mesh.add(base.translated(DVec3::new(-0.009, 0.0, foot_h - 0.002)), &black);
    for (x, y) in [(-1.0, -1.0), (1.0, -1.0), (-1.0, 1.0), (1.0, 1.0)] {
        let foot = cylinder(0.011, foot_h, 0.001, 16);
        mesh.add(foot.translated(DVec3::new(-0.009 + x * 0.38 * long, y * 0.36 * d, 0.0)), &black);
    }
    let body = slab(&rounded_rectangle(long, d, 0.035, 7), body_h - 0.03, 0.018)
        .translated(DVec3::new(-0.009, 0.0, 0.03));
    mesh.add(body.with_box_uvs(0.2), &shell);
    let plate = slab(&rounded_rectangle(0.8 * long, 0.62 * d, 0.012, 4), 0.004, 0.001);
    mesh.add(plate.translated(DVec3::new(-0.009, 0.0, body_h - 0.0032)), &chrome);
    let brown = crust(Rgb::hex(0xb0_72_34), Rgb::hex(0xe0_b4_70), &mut order.rng);
    let brown = Material::textured("toast", brown, 0.8);
    for y in [-0.17 * d, 0.17 * d] {
        let slot = slab(&rounded_rectangle(0.7 * long, 0.024, 0.008, 3), 0.003, 0.0005);
        mesh.add(slot.translated(DVec3::new(-0.009, y, body_h - 0.0016)), &glow);
        if with_toast {
            let slice = toast(0.56 * long, h - body_h + 0.05, 0.015);
            mesh.add(slice.translated(DVec3::new(-0.009, y, body_h - 0.05)), &brown);
        }
    }
    // Lever in its dark slit, dial below, at the right end.
    let end = -0.009 + 0.5 * long;
    let slit =
        block(DVec3::new(0.003, 0.012, 0.5 * body_h)).translated(DVec3::new(end - 0.001, 0.0, 0.3 * body_h));
    mesh.add(slit, &black);
    let lever = rounded_block(DVec3::new(0.018, 0.036, 0.012), 0.005, 0.003);
    let lever_z = if with_toast { 0.68 } else { 0.62 } * body_h;
    mesh.add(lever.translated(DVec3::new(end + 0.009, 0.0, lever_z)), &black);
    let dial = cylinder(0.013, 0.01, 0.002, 24).rotated(DQuat::from_rotation_y(0.5 * PI));
    mesh.add(dial.translated(DVec3::new(end - 0.001, -0.22 * d, 0.36 * body_h)), &chrome);
    // Brand plate in front.
    let badge = block(DVec3::new(0.22 * long, 0.003, 0.018)).translated(DVec3::new(
        -0.009,
        -0.5 * d - 0.0002,
        0.3 * body_h,
    ));
    mesh.add(badge, &chrome);
    fitted(mesh, order.size_m)
}

/// Nested outlines at given heights become an open trough: outside up, over the rim, inside down.
fn trough(ring: impl Fn(f64, f64) -> Vec<DVec3>, steps: &[(f64, f64)]) -> Solid {
    loft(&steps.iter().map(|&(inset, z)| ring(inset, z)).collect::<Vec<_>>())
}

pub(super) fn tray(order: &mut Order) -> TexturedMesh {
    let DVec3 { x: w, y: d, z: h } = order.size_m;
    let oval = order.pick(3) == 0;
    let usual = if oval {
        let texture = brushed_metal(Rgb::hex(0xc4_c6_c8), &mut order.rng);
        Material { metalness: 1.0, ..Material::textured("steel", texture, 0.25) }
    } else {
        Material::textured("wood", wood_grain(order.color, &mut order.rng), 0.5)
    };
    let body = finish(order, usual);
    let rim_h = 0.62 * h;
    let long = w - if oval { 0.03 } else { 0.0 };
    let ring = |inset: f64, z: f64| -> Vec<DVec3> {
        let (a, b) = (long - 2.0 * inset, d - 2.0 * inset);
        let outline =
            if oval { superellipse(a, b, 2.6, 56) } else { rounded_rectangle(a, b, 0.03 - 0.5 * inset, 10) };
        outline.iter().map(|p| p.extend(z)).collect()
    };
    let shell = trough(
        ring,
        &[
            (0.016, 0.0),
            (0.013, 0.001),
            (0.001, rim_h - 0.003),
            (0.0, rim_h - 0.001),
            (0.0015, rim_h),
            (0.005, rim_h),
            (0.0065, rim_h - 0.001),
            (0.019, 0.0055),
            (0.021, 0.005),
        ],
    );
    let mut mesh = TexturedMesh::default();
    let lining = if oval {
        body.clone()
    } else {
        let rng = &mut order.rng;
        Material::textured("lining", wood_grain(order.color.scaled(0.86), rng), 0.45)
    };
    add_by(&mut mesh, shell.with_box_uvs(0.25), &[&body, &lining], |c, n| {
        usize::from(n.z > 0.9 && c.z < 0.01)
    });
    let grip = Material::metal("grip", Rgb::hex(0x4a_44_3c).mix(Rgb::hex(0xc0_a0_60), 0.7), 0.35);
    for side in [-1.0, 1.0] {
        let x = side * (0.5 * long - 0.004);
        let out = if oval { 0.018 } else { 0.0 };
        let path: Vec<DVec3> = spline(
            &[(-0.16, 0.8), (-0.15, 1.25), (-0.1, 1.52), (0.0, 1.56), (0.1, 1.52), (0.15, 1.25), (0.16, 0.8)],
            4,
        )
        .iter()
        .map(|p| {
            let lean = ((p.y - 0.8) / 0.76).max(0.0);
            DVec3::new(x + side * out * lean, p.x * d * 1.2, p.y * rim_h)
        })
        .collect();
        mesh.add(sweep(&path, &circle(0.0042, 10), DVec3::X, |_| 1.0), if oval { &body } else { &grip });
    }
    fitted(mesh, order.size_m)
}

pub(super) fn basket(order: &mut Order) -> TexturedMesh {
    let DVec3 { x: w, y: d, z: h } = order.size_m;
    let arched = h > 0.72 * d;
    let rim_h = if arched { 0.5 * h } else { 0.94 * h };
    let color = order.color;
    let weave = Material::textured("wicker", wicker(color, 8, &mut order.rng), 0.85);
    let weave = finish(order, weave);
    let braid_finish = Material::textured("braid", stripes(color.scaled(0.95), color.scaled(0.68), 8), 0.85);
    let strakes = 48_usize;
    let levels = 9;
    let (long, deep) = (w - 0.014, d - 0.014);
    // Withies pass in front of and behind the stakes, row by row.
    let ring = |grow: f64, z: f64, row: i32, amplitude: f64| -> Vec<DVec3> {
        let flare = 0.8 + 0.2 * (z / rim_h).powf(0.8);
        superellipse(flare * long + 2.0 * grow, flare * deep + 2.0 * grow, 2.5, strakes)
            .iter()
            .enumerate()
            .map(|(k, p)| {
                let front = if (k as i32 / 2 + row) % 2 == 0 { amplitude } else { -amplitude };
                (*p + p.normalize() * front).extend(z)
            })
            .collect()
    };
    let mut rings = vec![ring(-0.004, 0.0, 0, 0.0)];
    let row_z = |row: i32| 0.002 + (rim_h - 0.006) * f64::from(row) / f64::from(levels);
    rings.extend((0..=levels).map(|row| ring(0.0, row_z(row), row, 0.0012)));
    rings.push(ring(-0.0025, rim_h - 0.002, 0, 0.0));
    rings.extend(
        (0..=levels)
            .rev()
            .filter(|&row| row_z(row) > 0.009)
            .map(|row| ring(-0.0055, row_z(row), row, 0.0006)),
    );
    rings.push(ring(-0.007, 0.006, 0, 0.0));
    let mut mesh = TexturedMesh::default();
    mesh.add(repeated(loft(&rings), 7.0, 3.0), &weave);
    let braid_path: Vec<DVec3> = superellipse(long - 0.004, deep - 0.004, 2.5, 56)
        .iter()
        .enumerate()
        .map(|(k, p)| p.extend(rim_h - 0.002 + 0.0008 * if k % 2 == 0 { 1.0 } else { -1.0 }))
        .collect();
    mesh.add(repeated(sweep_closed(&braid_path, &circle(0.0055, 10), DVec3::Z), 1.0, 7.0), &braid_finish);
    if arched {
        let path: Vec<DVec3> = (0..=28)
            .map(|k| {
                let angle = PI * f64::from(k) / 28.0;
                let x = 0.47 * long * angle.cos();
                DVec3::new(x, 0.0, 0.3 * rim_h + (h - 0.006 - 0.3 * rim_h) * angle.sin().powf(0.7))
            })
            .collect();
        mesh.add(
            repeated(sweep(&path, &ellipse(0.01, 0.016, 12), DVec3::Y, |_| 1.0), 1.0, 6.0),
            &braid_finish,
        );
    } else {
        for side in [-1.0, 1.0] {
            let path: Vec<DVec3> = (0..=14)
                .map(|k| {
                    let angle = PI * f64::from(k) / 14.0;
                    let z = rim_h - 0.004 + (h - rim_h) * angle.sin();
                    DVec3::new(side * (0.5 * long - 0.003), 0.2 * deep * angle.cos(), z)
                })
                .collect();
            mesh.add(sweep(&path, &circle(0.0042, 10), DVec3::X, |_| 1.0), &braid_finish);
        }
    }
    fitted(mesh, order.size_m)
}
