//! Needlework: thread, yarn, sewing machine, pin cushion, button, embroidery hoop. Model millimeters.

use glam::{DQuat, DVec2, DVec3};
use std::f64::consts::{FRAC_PI_2, PI, TAU};

use crate::Order;
use crate::assembly::{
    Assembly, across_y, along_x, black, curve, front_plate, lobed, main_finish, path, pierced, pitched,
    points, resting, rolled, turned_ring, wood, yawed,
};
use crate::texture::{Noise, draw_text, draw_texture, fabric_weave, fill_disc, fill_rectangle, stripes};
use geometry::shapes::{circle, cylinder, lathe, prism, rounded_block, sphere, tube};
use geometry::{Material, Rgb, TexturedMesh};
use imaging::{Image, Texture};

/// Spool of sewing thread, standing.
pub(super) fn thread_spool(order: &mut Order) -> TexturedMesh {
    let mut object = Assembly::new();
    let flange = match (order.material, order.pick(2)) {
        (Some(_), _) => main_finish(order, "wood"),
        (None, 0) => wood(order, 0xd4aa70),
        _ => Material::plain("spool", Rgb::hex(0xf2eee4), 0.4),
    };
    let thread = Material::textured("thread", stripes(order.color, order.color.scaled(0.72), 64), 0.7);
    let spool = points(&[
        (0.0, 0.0),
        (14.0, 0.0),
        (14.5, 0.8),
        (14.5, 2.8),
        (8.0, 6.5),
        (8.0, 37.5),
        (14.5, 41.2),
        (14.5, 43.2),
        (14.0, 44.0),
        (4.6, 44.0),
        (4.0, 42.5),
        (0.0, 42.5),
    ]);
    object.put(lathe(&spool, 36), [0.0; 3], &flange);
    let full = order.uniform(11.6, 13.4);
    let winding = points(&[
        (0.0, 4.2),
        (full - 2.4, 4.6),
        (full - 0.4, 8.0),
        (full, 14.0),
        (full + 0.2, 22.0),
        (full, 30.0),
        (full - 0.4, 36.0),
        (full - 2.4, 39.4),
        (0.0, 39.8),
    ]);
    object.put(lathe(&winding, 36), [0.0; 3], &thread);
    object.put(cylinder(3.8, 1.2, 0.0, 20), [0.0, 0.0, 42.0], &black());
    let loose = Material::plain("thread_end", order.color, 0.7);
    let tail = curve(
        &[
            (0.0, -full + 0.2, 26.0),
            (7.0, -full - 0.4, 24.0),
            (14.0, -14.0, 16.0),
            (19.0, -17.0, 5.0),
            (24.0, -14.0, 0.6),
            (30.0, -6.0, 0.6),
        ],
        6,
    );
    object.put(resting(tube(&tail, 0.7, 8), 0.0), [0.0; 3], &loose);
    object.fitted(order.size_m)
}

/// Ball of yarn, the end trailing on the table. The windings are ripples of one body, which one hull
/// covers: as rings of their own each would be decomposed into sectors.
pub(super) fn yarn_ball(order: &mut Order) -> TexturedMesh {
    let mut object = Assembly::new();
    let axes: Vec<DVec3> = (0..7)
        .map(|k| {
            let bundle = f64::from(k);
            DQuat::from_rotation_z(1.9 * bundle + 0.3)
                * DQuat::from_rotation_x(0.5 + 0.62 * bundle + order.uniform(0.0, 0.3))
                * DVec3::Z
        })
        .collect();
    let (crest, shade) = (order.color.scaled(1.1), order.color.scaled(0.62));
    let windings = draw_texture(256, 128, |u, v| {
        let (turn, polar) = (TAU * f64::from(u), PI * f64::from(v));
        let direction = (polar.sin() * DVec2::from_angle(turn)).extend(-polar.cos());
        shade.mix(crest, winding_height(&axes, direction).1 as f32)
    });
    let yarn = Material::textured("yarn", windings, 0.95);
    let strand = Material::plain("strand", order.color, 0.95);
    let floor = -35.0;
    let mut ball = sphere(36.5, 72).translated(DVec3::NEG_Z * 36.5);
    for p in &mut ball.positions {
        *p += winding_height(&axes, p.normalize()).0 * p.normalize();
    }
    object.put(resting(ball, floor), [0.0; 3], &yarn);
    let tail = curve(
        &[
            (6.0, -30.0, -22.0),
            (18.0, -38.0, -30.0),
            (34.0, -36.0, floor + 2.0),
            (48.0, -24.0, floor + 2.0),
            (54.0, -34.0, floor + 2.0),
            (64.0, -38.0, floor + 2.0),
        ],
        6,
    );
    object.put(resting(tube(&tail, 2.2, 8), floor), [0.0; 3], &strand);
    object.fitted(order.size_m)
}

/// Height above the core (millimeters) and brightness (0 in a groove, 1 on a crest) of the outermost
/// winding in a direction: three strands side by side around each axis, the later axes over the
/// earlier ones, and fine windings around the first axis where none of them lies.
fn winding_height(axes: &[DVec3], direction: DVec3) -> (f64, f64) {
    const STRAND: f64 = 6.2;
    const RADIUS: f64 = 36.5;
    let across = |axis: &DVec3| RADIUS * axis.dot(direction).clamp(-1.0, 1.0).asin();
    let covering = axes.iter().rev().map(across).find(|s| s.abs() < 1.5 * STRAND);
    let (s, width, height) = covering.map_or((across(&axes[0]), 0.5 * STRAND, 0.0), |s| (s, STRAND, 1.6));
    let from_crest = s / width - (s / width).round();
    let roundness = (PI * from_crest).cos();
    (height * roundness, (0.25 + 0.75 * roundness) * if covering.is_some() { 1.0 } else { 0.8 })
}

/// Sewing machine: bed, pillar, arm, needle, hand wheel, stitch chart, thread on its pin.
pub(super) fn sewing_machine(order: &mut Order) -> TexturedMesh {
    let mut object = Assembly::new();
    let shell = main_finish(order, "plastic");
    let trim = Material::plain("trim", Rgb::hex(0xf4f1ea), 0.35);
    let metal = Material::metal("metal", Rgb::hex(0xc8cace), 0.25);
    object.put(rounded_block(DVec3::new(360.0, 164.0, 56.0), 18.0, 6.0), [0.0; 3], &trim);
    object.put(rounded_block(DVec3::new(352.0, 156.0, 10.0), 16.0, 3.0), [0.0, 0.0, 49.0], &shell);
    let arm = points(&[
        (86.0, 52.0),
        (174.0, 52.0),
        (176.0, 262.0),
        (162.0, 276.0),
        (-150.0, 270.0),
        (-166.0, 256.0),
        (-166.0, 148.0),
        (-102.0, 148.0),
        (-96.0, 180.0),
        (-80.0, 194.0),
        (66.0, 194.0),
        (84.0, 176.0),
    ]);
    object.put(across_y(&arm, 104.0, 9.0), [0.0; 3], &shell);
    // Needle plate, presser foot, needle.
    object.put(rounded_block(DVec3::new(70.0, 84.0, 3.0), 4.0, 0.8), [-134.0, -8.0, 57.6], &metal);
    object.put(cylinder(4.0, 62.0, 0.6, 16), [-140.0, 4.0, 92.0], &metal);
    object.put(cylinder(1.4, 46.0, 0.0, 10), [-140.0, -6.0, 60.0], &metal);
    object.put(cylinder(4.6, 52.0, 0.8, 16), [-140.0, -6.0, 102.0], &metal);
    object.put(rounded_block(DVec3::new(20.0, 34.0, 3.0), 3.0, 0.8), [-140.0, -8.0, 62.0], &metal);
    object.put(cylinder(2.6, 34.0, 0.4, 12), [-140.0, 4.0, 62.0], &metal);
    // Hand wheel.
    let wheel = [
        (0.0, 0.0),
        (36.0, 0.0),
        (38.0, 3.0),
        (38.0, 19.0),
        (35.0, 22.0),
        (14.0, 20.0),
        (12.0, 25.0),
        (0.0, 25.0),
    ];
    object.put(along_x(lobed(&wheel, 20, 0.02, 40)), [174.0, 0.0, 214.0], &trim);
    // Front: stitch chart, dials, lever, name.
    let chart = Material::textured("chart", stitch_chart(), 0.5);
    object.put(front_plate(62.0, 62.0, 3.0), [130.0, -51.6, 116.0], &chart);
    let dial = Material::plain("dial", order.color.scaled(0.62), 0.4);
    for (x, z, radius) in [(130.0, 188.0, 24.0), (130.0, 238.0, 17.0), (66.0, 232.0, 15.0)] {
        let knob = [(0.0, 0.0), (radius, 0.0), (0.94 * radius, 9.0), (0.8 * radius, 11.0), (0.0, 11.0)];
        object.put(pitched(lobed(&knob, 12, 0.03, 36), 90.0), [x, -50.0, z], &trim);
        object.put(front_plate(3.4, 1.3 * radius, 3.0), [x, -60.6, z], &dial);
    }
    let mut name = Image::filled(256, 64, Rgb::hex(0xf4f1ea).to_rgba8());
    draw_text(&mut name, "STELLA", 24, 10, 6, order.color.scaled(0.55));
    object.put(
        front_plate(108.0, 27.0, 3.0),
        [-50.0, -51.6, 232.0],
        &Material::textured("name", Texture::new(name), 0.5),
    );
    object.put(rounded_block(DVec3::new(10.0, 14.0, 40.0), 3.0, 1.5), [-134.0, -54.0, 180.0], &metal);
    // Spool on its pin and the thread to the needle.
    let thread = Material::plain("thread", Rgb::hex([0xd82c4c, 0x2c6cc0, 0xf0b028][order.pick(3)]), 0.7);
    object.put(cylinder(2.4, 66.0, 0.6, 12), [84.0, 14.0, 266.0], &metal);
    object.put(cylinder(15.0, 34.0, 1.0, 24), [84.0, 14.0, 278.0], &thread);
    for z in [272.0, 311.0] {
        object.put(cylinder(18.0, 4.0, 1.0, 24), [84.0, 14.0, z], &trim);
    }
    let way = path(&[
        (84.0, 0.0, 296.0),
        (-130.0, -20.0, 276.0),
        (-138.0, -53.0, 250.0),
        (-140.0, -53.0, 150.0),
        (-140.0, -8.0, 90.0),
    ]);
    object.put(tube(&way, 0.9, 6), [0.0; 3], &thread);
    object.put(cylinder(3.0, 12.0, 0.6, 12), [-126.0, -20.0, 266.0], &metal);
    object.fitted(order.size_m)
}

fn stitch_chart() -> Texture {
    let mut image = Image::filled(128, 128, Rgb::hex(0xfaf8f2).to_rgba8());
    let ink = Rgb::hex(0x303440);
    for row in 0..5_i32 {
        let y = 14 + 24 * row;
        for k in 0..12_i32 {
            let rise = match row {
                0 => 0,
                1 => (k % 2) * 8,
                2 => (k % 4) * 4,
                3 => (k % 3) * 5,
                _ => i32::from(k % 4 < 2) * 9,
            };
            fill_rectangle(&mut image, 28 + 8 * k, y + rise, 6, 3, ink);
        }
        draw_text(&mut image, &format!("{}", row + 1), 8, y, 2, Rgb::hex(0xc03040));
    }
    Texture::new(image)
}

/// Tomato pin cushion with colored pins.
pub(super) fn pin_cushion(order: &mut Order) -> TexturedMesh {
    let mut object = Assembly::new();
    let cloth = Material::textured("cloth", fabric_weave(order.color, &mut order.rng), 0.95);
    let cushion = [
        (0.0, 0.0),
        (22.0, 0.0),
        (31.0, 4.0),
        (36.0, 11.0),
        (37.5, 19.0),
        (36.0, 28.0),
        (31.0, 35.0),
        (22.0, 40.0),
        (12.0, 41.0),
        (4.0, 39.0),
        (0.0, 38.0),
    ];
    object.put(lobed(&cushion, 8, 0.035, 48), [0.0; 3], &cloth);
    let leaf = Material::plain("leaf", Rgb::hex(0x3f8a42), 0.9);
    let star = [(0.0, 36.0), (11.5, 36.5), (12.0, 41.0), (10.0, 43.0), (3.0, 43.2), (0.0, 43.4)];
    object.put(lobed(&star, 6, 0.62, 60), [0.0; 3], &leaf);
    object.put(cylinder(2.0, 5.0, 0.8, 12), [0.0, 0.0, 41.5], &leaf);
    let steel = Material::metal("pin", Rgb::hex(0xc8cace), 0.2);
    let heads = [0xf4f2ec, 0xf2c428, 0x2c6cc8, 0xe03a7a, 0x2f9a5a, 0x222428];
    for k in 0..9 {
        let angle = (40.0 * k as f64 + order.uniform(-14.0, 14.0)) % 360.0;
        let out = order.uniform(13.0, 24.0);
        let tilt = order.uniform(4.0, 26.0);
        let length = order.uniform(17.0, 23.0);
        let top = 42.0 - 0.012 * out * out;
        let stand = |solid, z: f64| {
            yawed(
                rolled(geometry::Solid::translated(solid, DVec3::Z * z), tilt).translated(DVec3::new(
                    out,
                    0.0,
                    top - 6.0,
                )),
                angle,
            )
        };
        object.put(stand(cylinder(0.7, length, 0.0, 8), 0.0), [0.0; 3], &steel);
        let color = Material::plain("head", Rgb::hex(heads[k % heads.len()]), 0.25);
        object.put(stand(sphere(2.9, 12), length - 1.5), [0.0; 3], &color);
    }
    object.fitted(order.size_m)
}

/// Sewing button with two or four real holes and a raised rim.
pub(super) fn button(order: &mut Order) -> TexturedMesh {
    let mut object = Assembly::new();
    let finish = match (order.material, order.pick(3)) {
        (Some(_), _) => main_finish(order, "plastic"),
        (None, 0) => wood(order, 0xb07a48),
        _ => Material::plain("plastic", order.color, 0.25),
    };
    let holes = [2_usize, 4][order.pick(2)];
    // Sectors with one hole each, overlapping by a hair, held together by the rim.
    let half = PI / holes as f64;
    let mut sector: Vec<DVec2> =
        (0..=16).map(|k| 11.2 * DVec2::from_angle(-half + 2.0 * half * f64::from(k) / 16.0)).collect();
    if holes > 2 {
        sector.insert(0, DVec2::ZERO);
    }
    sector.iter_mut().for_each(|p| p.x -= 0.08);
    let hole_at = if holes == 2 { 3.6 } else { 4.2 };
    let part = pierced(&sector, (hole_at, 0.0), |_| 1.5, 3.0, 0.0, 28);
    let start = order.uniform(0.0, 90.0);
    for k in 0..holes {
        object.put(yawed(part.clone(), start + 360.0 * k as f64 / holes as f64), [0.0; 3], &finish);
    }
    let rim = [
        (10.4, 0.2),
        (13.6, 0.0),
        (15.0, 1.4),
        (15.0, 3.4),
        (14.2, 4.6),
        (12.8, 5.0),
        (11.4, 4.4),
        (10.2, 3.1),
    ];
    object.put(turned_ring(&rim, 44), [0.0; 3], &finish);
    object.fitted_round(order.size_m)
}

/// Embroidery hoop with cloth, a stitched flower and the brass screw behind (+y).
pub(super) fn embroidery_hoop(order: &mut Order) -> TexturedMesh {
    let mut object = Assembly::new();
    let frame = match order.material {
        Some(_) => main_finish(order, "beech"),
        None => wood(order, 0xd8b078),
    };
    let hoop = |inner: f64, outer: f64, low: f64, high: f64| {
        turned_ring(
            &[
                (inner + 0.6, low),
                (outer - 0.6, low),
                (outer, low + 0.6),
                (outer, high - 0.8),
                (outer - 0.8, high),
                (inner + 0.8, high),
                (inner, high - 0.8),
                (inner, low + 0.6),
            ],
            64,
        )
    };
    object.put(hoop(70.0, 75.5, 0.0, 10.0), [0.0; 3], &frame);
    object.put(hoop(64.0, 69.2, 0.0, 8.4), [0.0; 3], &frame);
    let image = embroidery(order);
    object.put(prism(&circle(70.4, 64), 2.0), [0.0, 0.0, 4.0], &Material::textured("cloth", image, 0.95));
    let brass = Material::metal("brass", Rgb::hex(0xc9a24c), 0.28);
    for x in [-5.5, 5.5] {
        object.put(rounded_block(DVec3::new(6.0, 14.0, 9.4), 1.5, 0.8), [x, 79.0, 0.3], &frame);
    }
    object.put(along_x(cylinder(1.8, 30.0, 0.3, 14)), [-13.0, 82.0, 5.0], &brass);
    object.put(
        along_x(lobed(&[(0.0, 0.0), (4.4, 0.0), (4.4, 6.0), (0.0, 6.0)], 10, 0.06, 40)),
        [11.5, 82.0, 5.0],
        &brass,
    );
    object.put(along_x(cylinder(3.4, 2.4, 0.5, 16)), [-14.0, 82.0, 5.0], &brass);
    object.fitted(order.size_m)
}

/// Cloth of 256 px with a satin-stitched flower, leaves and a stem.
fn embroidery(order: &mut Order) -> Texture {
    let ground = Rgb::hex(0xf4eee0);
    let weave = Noise::new(64, 64, &mut order.rng);
    let petal_color = order.color;
    let petals = [5, 6, 8][order.pick(3)];
    let cloth = draw_texture(256, 256, |u, v| {
        let (x, y) = (u - 0.5, v - 0.58);
        let (radius, angle) = ((x * x + y * y).sqrt(), y.atan2(x));
        let wave = (angle * petals as f32 * 0.5).cos().abs();
        let thread = 0.88 + 0.16 * ((angle * 60.0).sin() * 0.5 + 0.5);
        let stem_x = (u - 0.5 + 0.05 * (v * 9.0).sin()).abs();
        let leaf = |cx: f32, cy: f32, lean: f32| {
            let (dx, dy) = (u - cx, v - cy);
            let (a, b) = (dx * lean.cos() + dy * lean.sin(), dy * lean.cos() - dx * lean.sin());
            (a / 0.09).powi(2) + (b / 0.032).powi(2) < 1.0
        };
        if radius < 0.055 {
            Rgb::hex(0xf2c030).scaled(thread)
        } else if radius < 0.09 + 0.14 * wave {
            petal_color.scaled(thread)
        } else if (v < 0.46 && v > 0.14 && stem_x < 0.012) || leaf(0.38, 0.30, -0.6) || leaf(0.62, 0.26, 0.6)
        {
            Rgb::hex(0x3f8a48).scaled(thread)
        } else {
            ground.scaled(0.94 + 0.08 * weave.at(u, v))
        }
    });
    let mut image = (*cloth).clone();
    for k in 0..10 {
        let angle = f64::from(k) * TAU / 10.0 + FRAC_PI_2;
        let (x, y) = (128.0 + 98.0 * angle.cos(), 128.0 + 98.0 * angle.sin());
        fill_disc(&mut image, x as i32, y as i32, 4, petal_color.scaled(0.8));
    }
    Texture::new(image)
}
