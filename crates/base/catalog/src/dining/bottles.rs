//! Bottles, cans, jars and shakers, with their labels in front.

use std::f64::consts::TAU;

use glam::{DVec2, DVec3};

use super::assembly::{add_by, deformed, finish, fitted_round, label_band, points, spline, vessel};
use crate::Order;
use crate::texture::{wood_grain, wrap_label, wrapped_around};
use geometry::shapes::{cylinder, ellipse, lathe, loft, prism, ring, rounded_rectangle, slab, sweep};
use geometry::{Material, Rgb, TexturedMesh};

fn turned(pairs: &[(f64, f64)], steps: usize) -> Vec<DVec2> {
    let mut profile = vec![DVec2::new(0.0, pairs[0].1)];
    profile.extend(if steps > 1 { spline(pairs, steps) } else { points(pairs) });
    profile.push(DVec2::new(0.0, pairs[pairs.len() - 1].1));
    profile
}

pub(super) fn water_bottle(order: &mut Order) -> TexturedMesh {
    let r = 0.25 * (order.size_m.x + order.size_m.y);
    let h = order.size_m.z;
    let color = order.color;
    let mut mesh = TexturedMesh::default();
    if order.pick(2) == 0 {
        // Insulated steel flask: powder coat, logo, black cap with a carrying loop.
        let coat = wrap_label(color, color.mix(Rgb([0.95; 3]), 0.8), "AQUA", &mut order.rng);
        let usual = Material::textured("powder_coat", coat, 0.5);
        let coat = finish(order, usual);
        let steel = Material::metal("steel", Rgb::hex(0xc4_c6_c8), 0.25);
        let black = Material::plain("cap", Rgb([0.1, 0.1, 0.11]), 0.6);
        let body = turned(
            &[
                (0.93 * r, 0.0),
                (r, 0.012),
                (r, 0.2 * h),
                (r, 0.62 * h),
                (0.97 * r, 0.68 * h),
                (0.78 * r, 0.755 * h),
                (0.66 * r, 0.785 * h),
            ],
            3,
        );
        add_by(&mut mesh, wrapped_around(lathe(&body, 40)), &[&coat, &steel], |c, _| {
            usize::from(c.z < 0.012 || c.z > 0.755 * h)
        });
        let cap = cylinder(0.7 * r, 0.14 * h, 0.003, 40);
        let grooved = deformed(cap, |p| {
            let groove = 1.0 - 0.03 * (20.0 * p.y.atan2(p.x)).cos().max(0.0);
            DVec3::new(p.x * groove, p.y * groove, p.z)
        });
        mesh.add(grooved.translated(DVec3::Z * 0.775 * h), &black);
        let top = 0.9 * h;
        let bow: Vec<DVec3> = spline(
            &[
                (-0.5 * r, top),
                (-0.46 * r, 0.955 * h),
                (0.0, 0.975 * h),
                (0.46 * r, 0.955 * h),
                (0.5 * r, top),
            ],
            5,
        )
        .iter()
        .map(|p| DVec3::new(p.x, 0.0, p.y))
        .collect();
        mesh.add(sweep(&bow, &ellipse(0.006, 0.014, 12), DVec3::Y, |_| 1.0), &black);
    } else {
        // Clear bottle with ribs, paper label and a screw cap.
        let clear =
            Material { opacity: 0.45, ..Material::plain("clear_plastic", Rgb::hex(0xc4_e2_f0), 0.08) };
        let clear = finish(order, clear);
        let mut outline = points(&[(0.8 * r, 0.0), (0.97 * r, 0.01)]);
        outline.extend((1..=18).map(|k| {
            let t = f64::from(k) / 18.0;
            let rib = if (6..13).contains(&k) { -0.0015 } else { -0.0028 * f64::from(k % 2) };
            DVec2::new(r + rib, 0.01 + t * 0.62 * h)
        }));
        outline.extend(spline(
            &[
                (r, 0.66 * h),
                (0.9 * r, 0.75 * h),
                (0.55 * r, 0.86 * h),
                (0.4 * r, 0.9 * h),
                (0.38 * r, 0.94 * h),
            ],
            3,
        ));
        let mut profile = vec![DVec2::ZERO];
        profile.extend(outline);
        profile.push(DVec2::new(0.0, 0.94 * h));
        mesh.add(lathe(&profile, 36), &clear);
        let paper = wrap_label(Rgb([0.96, 0.97, 0.98]), color, "AQUA", &mut order.rng);
        let band = label_band(r - 0.0012, 0.01 + 0.215 * h, 0.01 + 0.42 * h, 36);
        mesh.add(band, &Material::textured("label", paper, 0.5));
        let cap = deformed(cylinder(0.43 * r, 0.075 * h, 0.0015, 40), |p| {
            let groove = 1.0 - 0.04 * (20.0 * p.y.atan2(p.x)).cos().max(0.0);
            DVec3::new(p.x * groove, p.y * groove, p.z)
        });
        mesh.add(cap.translated(DVec3::Z * 0.925 * h), &Material::plain("cap", color, 0.4));
    }
    fitted_round(mesh, order.size_m)
}

pub(super) fn wine_bottle(order: &mut Order) -> TexturedMesh {
    let r = 0.25 * (order.size_m.x + order.size_m.y);
    let h = order.size_m.z;
    let sloped = order.pick(2) == 0;
    let shoulder = if sloped {
        [(r, 0.52 * h), (0.9 * r, 0.62 * h), (0.6 * r, 0.74 * h), (0.39 * r, 0.83 * h)]
    } else {
        [(r, 0.6 * h), (0.95 * r, 0.65 * h), (0.6 * r, 0.71 * h), (0.39 * r, 0.76 * h)]
    };
    let mut pairs = vec![(0.9 * r, 0.0), (r, 0.012), (r, 0.25 * h)];
    pairs.extend(shoulder);
    pairs.extend([(0.36 * r, 0.9 * h), (0.36 * r, 0.93 * h)]);
    let glass = Material::plain("bottle_glass", order.color, 0.08);
    let glass = finish(order, glass);
    let foil_color = [0x6e_1f_2a, 0x20_24_2a, 0xb0_8a_3c, 0x26_3f_5a].map(Rgb::hex)[order.pick(4)];
    let foil = Material { metalness: 0.5, ..Material::plain("capsule", foil_color, 0.35) };
    let paper = Rgb::hex(0xee_e6_d2);
    let names = ["ROSSO", "BIANCO", "MERLOT", "RIOJA", "PINOT"];
    let name = names[order.pick(names.len())];
    let print = wrap_label(paper, foil_color, name, &mut order.rng);
    let mut mesh = TexturedMesh::default();
    mesh.add(lathe(&turned(&pairs, 4), 40), &glass);
    let low = 0.13 * h;
    mesh.add(label_band(r, low, low + 0.29 * h, 40), &Material::textured("label", print, 0.8));
    let capsule = points(&[
        (0.0, 0.82 * h),
        (0.41 * r, 0.82 * h),
        (0.4 * r, 0.94 * h),
        (0.45 * r, 0.945 * h),
        (0.45 * r, 0.97 * h),
        (0.41 * r, 0.975 * h),
        (0.4 * r, h - 0.001),
        (0.37 * r, h),
        (0.0, h),
    ]);
    mesh.add(lathe(&capsule, 32), &foil);
    fitted_round(mesh, order.size_m)
}

pub(super) fn soda_can(order: &mut Order) -> TexturedMesh {
    let r = 0.25 * (order.size_m.x + order.size_m.y);
    let h = order.size_m.z;
    let color = order.color;
    let names = ["COLA", "LEMON", "FIZZ", "TONIC", "SODA"];
    let word = names[order.pick(names.len())];
    let accent = if color.0[0] > 0.6 { Rgb([0.97, 0.96, 0.94]) } else { Rgb::hex(0xf0_b8_3a) };
    let print = wrap_label(color, accent, word, &mut order.rng);
    let print = Material { metalness: 0.3, ..Material::textured("print", print, 0.35) };
    let alu = Material::metal("aluminum", Rgb::hex(0xc6_c8_cb), 0.3);
    let profile = points(&[
        (0.0, 0.009),
        (0.5 * r, 0.006),
        (0.7 * r, 0.0),
        (0.78 * r, 0.0),
        (0.96 * r, 0.011),
        (r, 0.016),
        (r, 0.87 * h),
        (0.97 * r, 0.9 * h),
        (0.86 * r, 0.965 * h),
        (0.84 * r, 0.975 * h),
        (0.86 * r, 0.985 * h),
        (0.86 * r, h),
        (0.81 * r, h),
        (0.78 * r, h - 0.005),
        (0.0, h - 0.0045),
    ]);
    let mut mesh = TexturedMesh::default();
    add_by(&mut mesh, wrapped_around(lathe(&profile, 44)), &[&alu, &print], |c, _| {
        usize::from((0.011..0.9 * h).contains(&c.z))
    });
    // Tab toward -y's far side, drinking hole in front of it.
    let dark = Material::plain("score", Rgb([0.25, 0.25, 0.26]), 0.6);
    let hole = prism(&ellipse(0.021, 0.016, 24), 0.0014);
    mesh.add(hole.translated(DVec3::new(0.0, -0.42 * r, h - 0.0053)), &dark);
    let tab = slab(&rounded_rectangle(0.015, 0.024, 0.007, 4), 0.0024, 0.0005);
    mesh.add(tab.translated(DVec3::new(0.0, 0.12 * r, h - 0.0048)), &alu);
    let eye = prism(&ellipse(0.0085, 0.0095, 18), 0.0014);
    mesh.add(eye.translated(DVec3::new(0.0, 0.24 * r, h - 0.0031)), &dark);
    mesh.add(cylinder(0.0022, 0.0032, 0.0005, 12).translated(DVec3::new(0.0, -0.09 * r, h - 0.0048)), &alu);
    fitted_round(mesh, order.size_m)
}

pub(super) fn jar(order: &mut Order) -> TexturedMesh {
    let r = 0.25 * (order.size_m.x + order.size_m.y);
    let h = order.size_m.z;
    let clear = Material { opacity: 0.35, ..Material::plain("glass", Rgb::hex(0xdd_ee_ee), 0.05) };
    let clear = finish(order, clear);
    let mut outside = spline(
        &[
            (0.88 * r, 0.0),
            (0.97 * r, 0.006),
            (r, 0.03 * h + 0.006),
            (r, 0.4 * h),
            (r, 0.68 * h),
            (0.95 * r, 0.76 * h),
            (0.83 * r, 0.82 * h),
        ],
        3,
    );
    for z in [0.84, 0.88, 0.92] {
        outside.extend(points(&[
            (0.815 * r, z * h),
            (0.85 * r, (z + 0.012) * h),
            (0.815 * r, (z + 0.024) * h),
        ]));
    }
    outside.push(DVec2::new(0.83 * r, 0.985 * h));
    let fill = order.uniform(0.3, 0.5);
    let wall = 0.0034;
    let mut mesh = TexturedMesh::default();
    let rim = Material { opacity: 0.8, ..Material::plain("rim", Rgb::hex(0xe4_f0_f0), 0.05) };
    add_by(&mut mesh, vessel(&outside, wall, 0.005, 36), &[&clear, &rim], |c, _| usize::from(c.z > 0.97 * h));
    let jam = cylinder(r - wall + 0.0006, fill * h, 0.004, 36).translated(DVec3::Z * 0.0045);
    mesh.add(jam, &Material::plain("filling", order.color, 0.25));
    let names = ["JAM", "JELLY", "BERRY", "FRUIT"];
    let word = names[order.pick(names.len())];
    let print = wrap_label(Rgb::hex(0xf4_ee_dc), order.color.scaled(0.9), word, &mut order.rng);
    mesh.add(label_band(r, 0.2 * h, 0.6 * h, 36), &Material::textured("label", print, 0.8));
    fitted_round(mesh, order.size_m)
}

pub(super) fn salt_shaker(order: &mut Order) -> TexturedMesh {
    let r = 0.25 * (order.size_m.x + order.size_m.y);
    let h = order.size_m.z;
    let steel = Material::metal("cap", Rgb::hex(0xcc_ce_d0), 0.22);
    let dark = Material::plain("hole", Rgb([0.06; 3]), 0.9);
    let mut mesh = TexturedMesh::default();
    let body_h = 0.72 * h;
    let facets = |radius: f64, z: f64| -> Vec<DVec3> {
        (0..32)
            .map(|k| {
                let angle = TAU * f64::from(k) / 32.0;
                let flat = 1.0 - 0.07 * (0.5 * (1.0 - (8.0 * angle).cos()));
                (radius * flat * DVec2::from_angle(angle)).extend(z)
            })
            .collect()
    };
    if order.pick(2) == 0 {
        let glass = Material { opacity: 0.4, ..Material::plain("glass", Rgb::hex(0xe2_ee_f0), 0.05) };
        let rings: Vec<Vec<DVec3>> = [(0.9, 0.0), (1.0, 0.04), (0.94, 0.5), (0.8, 0.9), (0.78, 1.0)]
            .iter()
            .map(|&(s, t)| facets(s * r, t * body_h))
            .collect();
        mesh.add(loft(&rings), &glass);
        let salt: Vec<Vec<DVec3>> = [(0.86, 0.06), (0.84, 0.3), (0.78, 0.62)]
            .iter()
            .map(|&(s, t)| facets(s * r, t * body_h))
            .collect();
        mesh.add(loft(&salt), &Material::plain("salt", Rgb([0.97, 0.97, 0.96]), 0.9));
    } else {
        let usual = Material::plain("porcelain", order.color, 0.2);
        let body = finish(order, usual);
        let outline =
            turned(&[(0.9 * r, 0.0), (r, 0.1 * body_h), (0.93 * r, 0.55 * body_h), (0.78 * r, body_h)], 4);
        mesh.add(lathe(&outline, 32), &body);
        // The letter S in front, sunk into the wall.
        let stroke: Vec<DVec3> = spline(
            &[(0.2, 0.3), (0.0, 0.38), (-0.2, 0.24), (0.0, 0.0), (0.2, -0.24), (0.0, -0.38), (-0.2, -0.3)],
            4,
        )
        .iter()
        .map(|p| DVec3::new(p.x * r, -0.955 * r, 0.5 * body_h + p.y * r))
        .collect();
        mesh.add(sweep(&stroke, &ellipse(0.0022, 0.0022, 8), DVec3::Y, |_| 1.0), &dark);
    }
    let dome = turned(
        &[
            (0.84 * r, 0.97 * body_h),
            (0.84 * r, 0.8 * h),
            (0.78 * r, 0.9 * h),
            (0.5 * r, 0.98 * h),
            (0.15 * r, h),
        ],
        3,
    );
    mesh.add(lathe(&dome, 32), &steel);
    let dot = cylinder(0.0017, 0.0035, 0.0, 10);
    mesh.add(dot.clone().translated(DVec3::Z * (h - 0.0028)), &dark);
    for k in 0..6 {
        let at = 0.34 * r * DVec2::from_angle(TAU * f64::from(k) / 6.0);
        mesh.add(dot.clone().translated(at.extend(0.9935 * h - 0.0028)), &dark);
    }
    fitted_round(mesh, order.size_m)
}

pub(super) fn pepper_mill(order: &mut Order) -> TexturedMesh {
    let r = 0.25 * (order.size_m.x + order.size_m.y);
    let h = order.size_m.z;
    let usual = Material::textured("wood", wood_grain(order.color, &mut order.rng), 0.4);
    let wood = finish(order, usual);
    let steel = Material::metal("steel", Rgb::hex(0xcc_ce_d0), 0.22);
    let mut mesh = TexturedMesh::default();
    let lower = turned(
        &[
            (0.95 * r, 0.0),
            (r, 0.03 * h),
            (0.97 * r, 0.12 * h),
            (0.72 * r, 0.24 * h),
            (0.58 * r, 0.4 * h),
            (0.66 * r, 0.54 * h),
            (0.8 * r, 0.6 * h),
            (0.78 * r, 0.64 * h),
        ],
        3,
    );
    let along = |mut solid: geometry::Solid| {
        solid.uvs.iter_mut().for_each(|uv| *uv = geometry::Vec2::new(uv.y, 2.0 * uv.x));
        solid
    };
    mesh.add(along(lathe(&lower, 36)), &wood);
    mesh.add(cylinder(0.7 * r, 0.02 * h, 0.0, 36).translated(DVec3::Z * 0.635 * h), &steel);
    let head = turned(
        &[
            (0.74 * r, 0.65 * h),
            (0.8 * r, 0.67 * h),
            (0.6 * r, 0.71 * h),
            (0.72 * r, 0.78 * h),
            (0.76 * r, 0.84 * h),
            (0.58 * r, 0.91 * h),
            (0.2 * r, 0.935 * h),
        ],
        3,
    );
    mesh.add(along(lathe(&head, 36)), &wood);
    let knob = turned(&[(0.14 * r, 0.925 * h), (0.2 * r, 0.955 * h), (0.2 * r, 0.985 * h), (0.1 * r, h)], 3);
    mesh.add(lathe(&knob, 20), &steel);
    let foot = ring(0.93 * r, 0.0022, 36, 8).translated(DVec3::Z * 0.05 * h);
    mesh.add(foot, &steel);
    fitted_round(mesh, order.size_m)
}
