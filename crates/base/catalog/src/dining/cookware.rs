//! Cookware and kitchen tools, handles toward -y: pans, cutting board, spatula, ladle, whisk, rolling pin.

use std::f64::consts::{PI, TAU};

use glam::{DQuat, DVec2, DVec3};

use super::assembly::{add_by, finish, fitted, flattened, points, ribbon, spline, vessel};
use crate::Order;
use crate::texture::{brushed_metal, wood_grain, wood_planks};
use geometry::shapes::{
    circle, cylinder, lathe, loft, prism, ring, rounded_rectangle, slab, sweep_closed, tube,
};
use geometry::{Material, Rgb, Solid, TexturedMesh};

fn black() -> Material {
    Material::plain("grip", Rgb([0.1, 0.1, 0.11]), 0.55)
}

fn steel(order: &mut Order) -> Material {
    let texture = brushed_metal(Rgb::hex(0xc6_c8_ca), &mut order.rng);
    Material { metalness: 1.0, ..Material::textured("steel", texture, 0.28) }
}

/// A pan's handle toward -y from the wall at radius `r` and height `z`: steel neck, grip with a hole.
fn pan_handle(mesh: &mut TexturedMesh, grip: &Material, r: f64, z: f64, length: f64, end_z: f64) {
    let metal = Material::metal("bracket", Rgb::hex(0xb4_b6_b9), 0.3);
    let from = -r + 0.006;
    let neck = ribbon(
        &[[from - 0.3 * length, z + 0.12 * (end_z - z), 0.016, 0.006], [from, z - 0.004, 0.026, 0.008]],
        5,
    );
    mesh.add(neck, &metal);
    let back = -r - length;
    let span = 0.82 * length;
    let bar = ribbon(
        &[
            [back, end_z, 0.016, 0.009],
            [back + 0.02 * length, end_z, 0.024, 0.012],
            [back + 0.35 * span, z + 0.75 * (end_z - z), 0.026, 0.016],
            [back + span, z - 0.002, 0.019, 0.012],
        ],
        6,
    );
    mesh.add(bar, grip);
    let hole = prism(&circle(0.0048, 18), 0.0132);
    mesh.add(hole.translated(DVec3::new(0.0, back + 0.02, end_z - 0.0004)), &metal);
}

pub(super) fn frying_pan(order: &mut Order) -> TexturedMesh {
    let DVec3 { x: d, y: long, z: h } = order.size_m;
    let r = 0.5 * d;
    let deep = 0.8 * h;
    let usual = Material::plain("enamel", order.color, 0.35);
    let outer = finish(order, usual);
    let coating = Material::plain("nonstick", Rgb([0.13, 0.13, 0.14]), 0.4);
    let outside =
        spline(&[(0.76 * r, 0.0), (0.8 * r, 0.06 * deep), (0.9 * r, 0.45 * deep), (r, 0.97 * deep)], 4);
    let mut mesh = TexturedMesh::default();
    add_by(&mut mesh, vessel(&outside, 0.0032, 0.0045, 48), &[&outer, &coating], |c, n| {
        usize::from(n.dot(DVec3::new(c.x, c.y, 0.0)) < 0.0 || n.z > 0.3)
    });
    mesh.add(ring(r - 0.0018, 0.0022, 48, 8).translated(DVec3::Z * (0.97 * deep - 0.0022)), &outer);
    let grip = if order.pick(2) == 0 {
        Material::textured("wooden_grip", wood_grain(Rgb::hex(0x8a_5a_34), &mut order.rng), 0.5)
    } else {
        black()
    };
    pan_handle(&mut mesh, &grip, 0.95 * r, 0.68 * deep, long - 1.95 * r, h - 0.012);
    fitted(mesh, order.size_m)
}

pub(super) fn saucepan(order: &mut Order) -> TexturedMesh {
    let DVec3 { x: d, y: long, z: h } = order.size_m;
    let r = 0.5 * d;
    let metal = order.pick(2) == 0;
    let usual = if metal { steel(order) } else { Material::plain("enamel", order.color, 0.25) };
    let outer = finish(order, usual);
    let inside = Material { metalness: 0.9, ..Material::plain("inside", Rgb::hex(0xb8_ba_bd), 0.35) };
    let bare = Material::metal("base", Rgb::hex(0x9a_9c_9f), 0.35);
    let outside = points(&[
        (0.86 * r, 0.0),
        (0.93 * r, 0.005),
        (0.95 * r, 0.012),
        (0.955 * r, 0.3 * h),
        (0.96 * r, 0.6 * h),
        (0.96 * r, 0.93 * h),
        (r, 0.985 * h),
    ]);
    let mut mesh = TexturedMesh::default();
    add_by(&mut mesh, vessel(&outside, 0.0028, 0.0055, 48), &[&outer, &inside, &bare], |c, n| {
        if n.dot(DVec3::new(c.x, c.y, 0.0)) < 0.0 || n.z > 0.3 {
            1
        } else if c.z < 0.012 {
            2
        } else {
            0
        }
    });
    pan_handle(&mut mesh, &black(), 0.95 * r, 0.78 * h, long - 1.95 * r, 0.86 * h);
    for x in [-0.007, 0.007] {
        let rivet = cylinder(0.0032, 0.006, 0.0008, 12).rotated(DQuat::from_rotation_x(0.5 * PI));
        mesh.add(rivet.translated(DVec3::new(x, -0.94 * r, 0.83 * h)), &bare);
    }
    fitted(mesh, order.size_m)
}

pub(super) fn cutting_board(order: &mut Order) -> TexturedMesh {
    let DVec3 { x: w, y: l, z: h } = order.size_m;
    let boards = 4 + order.pick(4);
    let mut texture = Material::textured("wood", wood_planks(order.color, boards, &mut order.rng), 0.6);
    texture = finish(order, texture);
    let mut mesh = TexturedMesh::default();
    let planked = |solid: Solid, from: f64, to: f64| {
        let mut solid = solid;
        for (uv, p) in solid.uvs.iter_mut().zip(&solid.positions) {
            *uv = geometry::Vec2::new((p.x / w) as f32, ((p.y - from) / (to - from)) as f32);
        }
        solid
    };
    if order.pick(2) == 0 {
        // Paddle: board, neck, ring to hang it by.
        let grip = 0.2 * l;
        let body = l - grip;
        let board = slab(&rounded_rectangle(w, body, 0.025, 6), h, 0.003);
        let board = board.translated(DVec3::Y * 0.5 * grip);
        mesh.add(planked(board, -0.5 * l + grip, 0.5 * l), &texture);
        let section = rounded_rectangle(0.024, h - 0.001, 0.003, 3);
        let center = DVec3::new(0.0, -0.5 * l + 0.036, 0.5 * (h - 0.001));
        let path: Vec<DVec3> = (0..32)
            .map(|k| center + (0.024 * DVec2::from_angle(TAU * f64::from(k) / 32.0)).extend(0.0))
            .collect();
        let loop_ = sweep_closed(&path, &section, DVec3::Z);
        mesh.add(planked(loop_, -0.5 * l, 0.5 * l), &texture);
        let neck_from = -0.5 * l + 0.055;
        let neck_to = -0.5 * l + grip + 0.01;
        let neck = slab(&rounded_rectangle(0.05, neck_to - neck_from, 0.004, 3), h - 0.0006, 0.003);
        mesh.add(
            planked(neck.translated(DVec3::Y * 0.5 * (neck_from + neck_to)), -0.5 * l, 0.5 * l),
            &texture,
        );
    } else {
        // Block with a juice groove, darker than the wood, and metal-free round feet left out.
        let rings: Vec<Vec<DVec3>> = [
            (0.003, 0.0),
            (0.0, 0.003),
            (0.0, h - 0.003),
            (0.003, h),
            (0.016, h),
            (0.019, h - 0.003),
            (0.025, h - 0.003),
            (0.028, h),
        ]
        .iter()
        .map(|&(by, z)| {
            rounded_rectangle(w - 2.0 * by, l - 2.0 * by, 0.03 - 0.7 * by, 8)
                .iter()
                .map(|p| p.extend(z))
                .collect()
        })
        .collect();
        let groove = Material { base_color: Rgb([0.62, 0.58, 0.55]), ..texture.clone() };
        let groove = Material { name: "groove".to_owned(), ..groove };
        add_by(&mut mesh, planked(loft(&rings), -0.5 * l, 0.5 * l), &[&texture, &groove], |c, n| {
            usize::from(n.z > 0.3 && c.z < h - 0.0005 && c.z > h - 0.0036 && c.x.abs() < 0.5 * w - 0.008)
        });
    }
    fitted(mesh, order.size_m)
}

pub(super) fn spatula(order: &mut Order) -> TexturedMesh {
    let DVec3 { x: w, y: l, z: h } = order.size_m;
    let metal = steel(order);
    let blade_finish = if order.pick(2) == 0 { metal.clone() } else { black() };
    let grip = Material::plain("grip", order.color, 0.5);
    let grip = finish(order, grip);
    let mut mesh = TexturedMesh::default();
    let (front, blade) = (0.5 * l, 0.3 * l);
    let t = 0.0018;
    let root = front - blade;
    for (y, depth, wide) in [(front - 0.011, 0.022, w), (root + 0.01, 0.024, 0.86 * w)] {
        let bar = slab(&rounded_rectangle(wide, depth, 0.008, 4), t, 0.0005);
        mesh.add(bar.translated(DVec3::Y * y), &blade_finish);
    }
    for k in 0..5 {
        let x = (f64::from(k) - 2.0) * 0.205;
        let path = [DVec3::new(0.86 * w * x, root + 0.006, 0.0), DVec3::new(w * x, front - 0.006, 0.0)];
        let half = if k == 0 || k == 4 { 0.055 * w } else { 0.06 * w };
        let outline = [
            path[0] - DVec3::X * half,
            path[0] + DVec3::X * half,
            path[1] + DVec3::X * half,
            path[1] - DVec3::X * half,
        ];
        let strip: Vec<DVec2> = outline.iter().map(|p| p.truncate()).collect();
        mesh.add(prism(&strip, t - 0.0003), &blade_finish);
    }
    let shaft = ribbon(
        &[
            [-0.12 * l, 0.8 * h, 0.009, 0.005],
            [0.0, 0.78 * h, 0.009, 0.005],
            [root - 0.035, 0.5 * h, 0.011, 0.004],
            [root - 0.006, 0.06 * h, 0.022, 0.0026],
            [root + 0.012, 0.0004, 0.3 * w, 0.0022],
        ],
        5,
    );
    mesh.add(shaft, &metal);
    let handle = ribbon(
        &[
            [-0.5 * l, 0.0, 0.016, 0.011],
            [-0.485 * l, 0.0, 0.024, 0.014],
            [-0.45 * l, 0.04 * h, 0.026, 0.016],
            [-0.3 * l, 0.35 * h, 0.02, 0.016],
            [-0.08 * l, 0.68 * h, 0.017, 0.013],
        ],
        6,
    );
    mesh.add(flattened(handle, 0.0004).translated(DVec3::Z * -0.0004), &grip);
    fitted(mesh, order.size_m)
}

pub(super) fn ladle(order: &mut Order) -> TexturedMesh {
    let DVec3 { x: w, y: l, z: h } = order.size_m;
    let texture = brushed_metal(order.color, &mut order.rng);
    let usual = Material { metalness: 0.9, ..Material::textured("steel", texture, 0.25) };
    let metal = finish(order, usual);
    let r = 0.5 * w;
    let center = 0.5 * l - r;
    let deep = h;
    let outside = spline(
        &[
            (0.36 * r, 0.0),
            (0.66 * r, 0.14 * deep),
            (0.9 * r, 0.5 * deep),
            (0.985 * r, 0.82 * deep),
            (r, 0.98 * deep),
        ],
        4,
    );
    let mut mesh = TexturedMesh::default();
    mesh.add(vessel(&outside, 0.0018, 0.002, 40).translated(DVec3::Y * center), &metal);
    let back = -0.5 * l;
    let rim = center - r;
    let at = |t: f64| back + (rim - back) * t;
    let bar = ribbon(
        &[
            [back, 0.0, 0.012, 0.0035],
            [at(0.03), 0.0, 0.022, 0.004],
            [at(0.12), 0.04 * h, 0.025, 0.004],
            [at(0.4), 0.34 * h, 0.018, 0.004],
            [at(0.85), 0.74 * h, 0.012, 0.0042],
            [at(1.0) + 0.002, 0.82 * h, 0.024, 0.0035],
        ],
        5,
    );
    mesh.add(flattened(bar, 0.0003).translated(DVec3::Z * -0.0003), &metal);
    let hole = prism(&circle(0.0045, 16), 0.0046);
    let dark = Material::plain("hole", Rgb([0.12; 3]), 0.9);
    mesh.add(hole.translated(DVec3::new(0.0, at(0.07), 0.0002)), &dark);
    fitted(mesh, order.size_m)
}

pub(super) fn whisk(order: &mut Order) -> TexturedMesh {
    let DVec3 { x: w, y: l, .. } = order.size_m;
    let wire = Material::metal("wire", Rgb::hex(0xc8_ca_cc), 0.2);
    let usual = if order.pick(2) == 0 {
        Material::metal("handle", Rgb::hex(0xb9_bb_be), 0.3)
    } else {
        Material::plain("handle", order.color, 0.5)
    };
    let grip = finish(order, usual);
    let thick = 0.0013;
    let r = 0.5 * w / (PI / 8.0).cos() - thick;
    let neck = -0.5 * l + 0.47 * l;
    let balloon = spline(
        &[
            (neck - 0.01, 0.004),
            (neck + 0.12 * l, 0.42 * r),
            (neck + 0.24 * l, 0.83 * r),
            (neck + 0.34 * l, r),
            (neck + 0.43 * l, 0.92 * r),
            (neck + 0.495 * l, 0.62 * r),
            (0.5 * l - thick - 0.0012, 0.22 * r),
            (0.5 * l - thick, 0.0),
        ],
        4,
    );
    let mut parts = Vec::new();
    for k in 0..4 {
        // Wires at 22.5 degrees from straight down, so that two of them touch the table.
        let angle = PI / 8.0 + PI * f64::from(k) / 4.0;
        let out = DVec3::new(angle.cos(), 0.0, angle.sin());
        let there = balloon.iter().map(|p| out * p.y + DVec3::Y * p.x);
        let back = balloon.iter().rev().skip(1).map(|p| -out * p.y + DVec3::Y * p.x);
        let path: Vec<DVec3> = there.chain(back).collect();
        parts.push((tube(&path, thick, 8), &wire));
    }
    let rh = 0.0115;
    let handle = spline(
        &[
            (0.0, 0.0),
            (0.8 * rh, 0.001),
            (rh, 0.05 * l),
            (0.95 * rh, 0.15 * l),
            (0.72 * rh, 0.3 * l),
            (0.85 * rh, 0.42 * l),
            (0.8 * rh, 0.475 * l),
            (0.0, 0.48 * l),
        ],
        3,
    );
    let handle =
        lathe(&handle, 24).rotated(DQuat::from_rotation_x(-0.5 * PI)).translated(DVec3::Y * -0.5 * l);
    parts.push((handle, &grip));
    let eye = ring(0.006, 0.0014, 20, 8).rotated(DQuat::from_rotation_y(0.5 * PI));
    parts.push((eye.translated(DVec3::new(-0.0014, -0.5 * l - 0.004, 0.0)), &wire));
    let tilt = ((r * (PI / 8.0).cos() + thick - rh) / (0.75 * l)).atan();
    let turn = DQuat::from_rotation_x(tilt);
    let parts: Vec<_> = parts.into_iter().map(|(solid, finish)| (solid.rotated(turn), finish)).collect();
    let low = |solid: &Solid| solid.positions.iter().map(|p| p.z).fold(f64::INFINITY, f64::min);
    let floor = low(&parts[1].0).max(low(&parts[4].0)) + 0.0004;
    let mut mesh = TexturedMesh::default();
    for (solid, finish) in parts {
        mesh.add(flattened(solid, floor), finish);
    }
    fitted(mesh, order.size_m)
}

pub(super) fn rolling_pin(order: &mut Order) -> TexturedMesh {
    let DVec3 { x: l, y: d, .. } = order.size_m;
    let r = 0.5 * d;
    let usual = Material::textured("wood", wood_grain(order.color, &mut order.rng), 0.55);
    let wood = finish(order, usual);
    let tinted = order.pick(2) == 0;
    let accent = if tinted {
        Material::plain(
            "painted_handle",
            [0xb0_34_2c, 0x2f_5a_7a, 0x3c_6e_4a].map(Rgb::hex)[order.pick(3)],
            0.4,
        )
    } else {
        wood.clone()
    };
    let laid = |solid: Solid| {
        let mut solid = solid.rotated(DQuat::from_rotation_y(0.5 * PI));
        solid.uvs.iter_mut().for_each(|uv| *uv = geometry::Vec2::new(2.0 * uv.y, uv.x));
        solid
    };
    let roll = laid(cylinder(r, 0.58 * l, 0.006, 40)).translated(DVec3::X * -0.29 * l);
    let mut mesh = TexturedMesh::default();
    mesh.add(flattened(roll, -0.975 * r), &wood);
    let grip = spline(
        &[
            (0.0, 0.0),
            (0.34 * r, 0.0),
            (0.36 * r, 0.03 * l),
            (0.56 * r, 0.1 * l),
            (0.54 * r, 0.17 * l),
            (0.3 * r, 0.212 * l),
            (0.0, 0.215 * l),
        ],
        4,
    );
    let grip = laid(lathe(&grip, 28)).translated(DVec3::X * 0.285 * l);
    mesh.add(grip.clone(), &accent);
    mesh.add(grip.rotated(DQuat::from_rotation_z(PI)), &accent);
    fitted(mesh, order.size_m)
}
