//! Drinking vessels and tableware: mug, teacup, saucer, glasses, plate, bowl.

use glam::{DVec2, DVec3};

use super::assembly::{
    add_by, finish, fitted, fitted_round, loop_handle, points, spline, vessel, wall_radius_m,
};
use crate::Order;
use crate::texture::{ceramic_speckle, draw_texture, striped_band, stripes, wrap_label, wrapped_around};
use geometry::shapes::{lathe, ring};
use geometry::{Material, Rgb, TexturedMesh};

const CREAM: Rgb = Rgb([0.94, 0.92, 0.88]);

/// A glazed outside: plain, banded or striped, the same all around, or else (`printed`) speckled or
/// with an emblem in front.
fn glaze(order: &mut Order, printed: bool) -> Material {
    let color = order.color;
    let light = color.0.iter().sum::<f32>() > 1.8;
    let accent = if light { Rgb::hex(0x35_50_6b) } else { CREAM };
    let style = if printed { 2 + order.pick(4) } else { order.pick(3) };
    let rng = &mut order.rng;
    let texture = match style {
        0 => stripes(color, color, 2),
        1 => striped_band(color, accent, 0.0, 0.66, 1, rng),
        2 => striped_band(color, accent, 0.55, 0.85, 3, rng),
        3 => ceramic_speckle(color, rng),
        4 => wrap_label(color, accent, "", rng),
        _ => heart(color, if light { Rgb::hex(0xc0_39_2f) } else { CREAM }),
    };
    let usual = Material::textured("glaze", texture, 0.25);
    finish(order, usual)
}

/// A heart in the center of the front.
fn heart(ground: Rgb, ink: Rgb) -> imaging::Texture {
    draw_texture(256, 128, |u, v| {
        let (x, y) = ((u - 0.5) * 9.0, (v - 0.48) * 3.6);
        let r = x * x + y * y - 1.0;
        if r * r * r - x * x * y * y * y < 0.0 { ink } else { ground }
    })
}

pub(super) fn mug(order: &mut Order) -> TexturedMesh {
    let size = order.size_m;
    let (r, h) = (0.5 * size.y, size.z);
    let profile = match order.pick(3) {
        0 => points(&[(0.9 * r, 0.0), (0.97 * r, 0.02 * h), (r, 0.05 * h), (r, 0.5 * h), (r, 0.98 * h)]),
        1 => points(&[
            (0.74 * r, 0.0),
            (0.79 * r, 0.03 * h),
            (0.84 * r, 0.3 * h),
            (0.92 * r, 0.65 * h),
            (r, 0.98 * h),
        ]),
        _ => spline(
            &[
                (0.62 * r, 0.0),
                (0.84 * r, 0.07 * h),
                (r, 0.35 * h),
                (0.97 * r, 0.7 * h),
                (0.94 * r, 0.98 * h),
            ],
            4,
        ),
    };
    let outside = glaze(order, true);
    let inside = match order.material {
        Some(_) => outside.clone(),
        None => Material::plain("inner_glaze", order.color.mix(CREAM, 0.85), 0.2),
    };
    let mut mesh = TexturedMesh::default();
    let wall_m = 0.0042;
    let body = wrapped_around(vessel(&profile, wall_m, 0.006, 48));
    add_by(&mut mesh, body, &[&outside, &inside], |center, normal| {
        usize::from(
            normal.dot(DVec3::new(center.x, center.y, 0.0)) < -1e-6 || (normal.z > 0.5 && center.z < 0.5 * h),
        )
    });
    let [upper, lower] = [0.81 * h, 0.19 * h].map(|z_m| wall_radius_m(&profile, wall_m, z_m));
    let plain = Material::plain("handle", order.color, 0.25);
    let grip = if order.material.is_some() { &outside } else { &plain };
    let reach = size.x - 0.5 * size.y - 0.5 * (upper + lower) - 0.0035;
    mesh.add(loop_handle([upper, lower], reach, 0.5 * h, 0.62 * h, 0.0075, 0.0115), grip);
    fitted(mesh, size)
}

pub(super) fn teacup(order: &mut Order) -> TexturedMesh {
    let size = order.size_m;
    let (r, h) = (0.5 * size.y, size.z);
    let profile = spline(
        &[
            (0.5 * r, 0.0),
            (0.5 * r, 0.07 * h),
            (0.62 * r, 0.16 * h),
            (0.85 * r, 0.45 * h),
            (0.93 * r, 0.8 * h),
            (r, 0.98 * h),
        ],
        4,
    );
    let color = order.color;
    let gold = Material { metalness: 0.6, ..Material::plain("gilding", Rgb::hex(0xc9_a2_4c), 0.3) };
    let usual = Material::plain("porcelain", color, 0.18);
    let body = finish(order, usual);
    let rendered = Material::textured("flowers", flowers(color, &mut order.rng), 0.18);
    let mut mesh = TexturedMesh::default();
    let wall_m = 0.003;
    let cup = wrapped_around(vessel(&profile, wall_m, 0.0055, 48));
    add_by(&mut mesh, cup, &[&body, &rendered, &gold], |center, normal| {
        let outward = normal.dot(DVec3::new(center.x, center.y, 0.0)) > 0.0;
        if center.z > 0.965 * h { 2 } else { usize::from(outward && center.z > 0.2 * h) }
    });
    let [upper, lower] = [0.83 * h, 0.33 * h].map(|z_m| wall_radius_m(&profile, wall_m, z_m));
    let reach = size.x - 0.5 * size.y - 0.5 * (upper + lower) - 0.0025;
    mesh.add(loop_handle([upper, lower], reach, 0.58 * h, 0.5 * h, 0.005, 0.0075), &body);
    fitted(mesh, size)
}

/// Scattered blossoms with leaves.
fn flowers(ground: Rgb, rng: &mut runtime::seed::Rng) -> imaging::Texture {
    use rand::RngExt;
    let petals = [0xc7_5b_7a, 0x4f_6f_b0, 0xd0_8a_3c].map(Rgb::hex)[rng.random_range(0..3)];
    let spots: Vec<(f32, f32)> = (0..9)
        .map(|k| ((k as f32 + rng.random_range(0.2..0.8)) / 9.0, rng.random_range(0.45..0.8)))
        .collect();
    draw_texture(256, 128, |u, v| {
        for &(su, sv) in &spots {
            let (x, y) = ((u - su) * 6.0, (v - sv) * 2.0);
            let (radius, angle) = ((x * x + y * y).sqrt(), y.atan2(x));
            if radius < 0.07 {
                return Rgb::hex(0xe8_c0_4a);
            }
            if radius < 0.19 * (0.7 + 0.3 * (5.0 * angle).cos()) {
                return petals;
            }
            if (x - 0.2).abs() < 0.12 && (y + 0.16).abs() < 0.04 {
                return Rgb::hex(0x5a_8a_4a);
            }
        }
        ground
    })
}

pub(super) fn saucer(order: &mut Order) -> TexturedMesh {
    let usual = Material::plain("porcelain", order.color, 0.18);
    let body = finish(order, usual);
    let gold = Material { metalness: 0.6, ..Material::plain("gilding", Rgb::hex(0xc9_a2_4c), 0.3) };
    let r = 0.25 * (order.size_m.x + order.size_m.y);
    let h = order.size_m.z;
    let t = 0.0035;
    let profile = points(&[
        (0.0, 0.0),
        (0.52 * r, 0.0),
        (0.55 * r, 0.08 * h),
        (0.8 * r, 0.38 * h),
        (0.97 * r, h - t * 0.7),
        (r, h - 0.3 * t),
        (0.985 * r, h),
        (0.955 * r, h - 0.1 * t),
        (0.9 * r, 0.38 * h + t + 0.12 * r / (0.175 * r) * (0.62 * h - 1.1 * t)),
        (0.87 * r, 0.38 * h + t + 0.09 * r / (0.175 * r) * (0.62 * h - 1.1 * t)),
        (0.78 * r, 0.38 * h + t),
        (0.55 * r, 0.08 * h + t),
        (0.36 * r, t + 0.0006),
        (0.34 * r, t + 0.0022),
        (0.31 * r, t + 0.0022),
        (0.29 * r, t),
        (0.0, t),
    ]);
    let mut mesh = TexturedMesh::default();
    add_by(&mut mesh, lathe(&profile, 48), &[&body, &gold], |center, normal| {
        let radius = center.truncate().length();
        usize::from(radius > 0.96 * r || (normal.z > 0.0 && (0.871 * r..0.8985 * r).contains(&radius)))
    });
    fitted_round(mesh, order.size_m)
}

fn glass(tint: Rgb) -> Material {
    Material { opacity: 0.38, ..Material::plain("glass", tint, 0.05) }
}

pub(super) fn drinking_glass(order: &mut Order) -> TexturedMesh {
    let r = 0.25 * (order.size_m.x + order.size_m.y);
    let h = order.size_m.z;
    let narrow = order.uniform(0.78, 0.92);
    let ringed = order.pick(2) == 0;
    let radius_at = |t: f64| narrow * r + (1.0 - narrow) * r * t;
    let mut outside = points(&[(narrow * r - 0.002, 0.0), (narrow * r, 0.002)]);
    outside.extend((1..=18).map(|k| {
        let t = f64::from(k) / 18.0;
        let bulge = if ringed && t < 0.56 && k % 3 == 1 { 0.0016 } else { 0.0 };
        DVec2::new(radius_at(t) - 0.0016 + bulge, 0.99 * h * t)
    }));
    let body = vessel(&outside, 0.0028, 0.011, 48);
    let usual = glass(order.color);
    let glass = finish(order, usual);
    let rim = Material { opacity: 0.75, ..Material::plain("rim", order.color.mix(Rgb([1.0; 3]), 0.5), 0.05) };
    let mut mesh = TexturedMesh::default();
    add_by(&mut mesh, body, &[&glass, &rim], |center, _| {
        usize::from(center.z > 0.985 * h || (center.z < 0.0112 && center.truncate().length() < narrow * r))
    });
    fitted_round(mesh, order.size_m)
}

pub(super) fn wine_glass(order: &mut Order) -> TexturedMesh {
    let r = 0.25 * (order.size_m.x + order.size_m.y);
    let h = order.size_m.z;
    let foot = 0.92 * r;
    let wide = order.uniform(0.0, 0.1);
    let stem = 0.0045;
    let outside = [
        spline(
            &[
                (foot, 0.0),
                (foot, 0.0035),
                (0.6 * foot, 0.007),
                (0.25 * foot, 0.012),
                (stem, 0.03),
                (stem, 0.36 * h),
            ],
            3,
        ),
        spline(
            &[
                (stem, 0.4 * h),
                (0.35 * r, 0.45 * h),
                (0.85 * r, 0.56 * h),
                (r, 0.68 * h),
                ((0.93 - wide) * r, 0.85 * h),
                ((0.8 - wide) * r, 0.99 * h),
            ],
            4,
        ),
    ]
    .concat();
    let mut profile = vec![DVec2::ZERO];
    profile.extend(&outside);
    let wall = 0.0022;
    let rim = outside[outside.len() - 1];
    profile.push(rim + DVec2::new(-0.5 * wall, 0.3 * wall));
    profile.extend(
        outside
            .iter()
            .rev()
            .filter(|p| p.y > 0.46 * h)
            .map(|p| DVec2::new(p.x - wall * if p.y < 0.6 * h { 1.5 } else { 1.0 }, p.y)),
    );
    profile.push(DVec2::new(0.0, 0.45 * h));
    let usual = glass(order.color);
    let glass = finish(order, usual);
    let bright =
        Material { opacity: 0.7, ..Material::plain("rim", order.color.mix(Rgb([1.0; 3]), 0.5), 0.05) };
    let mut mesh = TexturedMesh::default();
    add_by(&mut mesh, lathe(&profile, 40), &[&glass, &bright], |center, _| {
        usize::from(center.z > 0.985 * h || (center.z < 0.42 * h && center.z > 0.02))
    });
    fitted_round(mesh, order.size_m)
}

pub(super) fn plate(order: &mut Order) -> TexturedMesh {
    let r = 0.25 * (order.size_m.x + order.size_m.y);
    let h = order.size_m.z;
    let well = order.uniform(0.64, 0.72);
    let t = 0.0042;
    let profile = points(&[
        (0.0, 0.0),
        // The foot grows with the well: its wall stays as thick wherever the rim begins.
        ((well - 0.04) * r, 0.0),
        ((well - 0.02) * r, 0.1 * h),
        ((well + 0.06) * r, 0.5 * h),
        (0.985 * r, h - t * 0.6),
        (r, h - 0.25 * t),
        (0.985 * r, h),
        (0.96 * r, h - 0.05 * t),
        ((well + 0.04) * r, 0.5 * h + 0.8 * t),
        ((well - 0.01) * r, 0.3 * h + t * 0.5),
        ((well - 0.06) * r, t + 0.0004),
        ((well - 0.1) * r, t),
        (0.0, t),
    ]);
    let color = order.color;
    let light = color.0.iter().sum::<f32>() > 1.8;
    let usual = Material::plain("glaze", color, 0.18);
    let body = finish(order, usual);
    let palette = [0x2f_4f_8a, 0x3f_7a_55, 0xb0_45_36, 0xc0_9a_45];
    let accent = if light { Rgb::hex(palette[order.pick(4)]) } else { CREAM };
    let band = Material::plain("rim_band", accent, 0.2);
    let (low, high) = if order.pick(2) == 0 { (0.9, 0.96) } else { (0.96, 1.1) };
    let mut mesh = TexturedMesh::default();
    // One more ring of vertices at the band's inner edge keeps it crisp.
    let mut rings = profile.clone();
    let slope = |x: f64| {
        let (a, b) = (DVec2::new((well + 0.04) * r, 0.5 * h + 0.8 * t), DVec2::new(0.96 * r, h - 0.05 * t));
        a + (b - a) * ((x - a.x) / (b.x - a.x))
    };
    rings.insert(8, slope(0.9 * r));
    add_by(&mut mesh, lathe(&rings, 48), &[&body, &band], |center, normal| {
        let radius = center.truncate().length() / r;
        usize::from(normal.z > 0.1 && (low..high).contains(&radius))
    });
    fitted_round(mesh, order.size_m)
}

pub(super) fn bowl(order: &mut Order) -> TexturedMesh {
    let r = 0.25 * (order.size_m.x + order.size_m.y);
    let h = order.size_m.z;
    let outside = match order.pick(2) {
        0 => spline(
            &[(0.45 * r, 0.0), (0.45 * r, 0.06 * h), (0.68 * r, 0.2 * h), (0.9 * r, 0.55 * h), (r, 0.98 * h)],
            5,
        ),
        _ => spline(
            &[
                (0.5 * r, 0.0),
                (0.5 * r, 0.06 * h),
                (0.8 * r, 0.2 * h),
                (0.95 * r, 0.5 * h),
                (0.985 * r, 0.75 * h),
                (r, 0.98 * h),
            ],
            4,
        ),
    };
    let outer = glaze(order, false);
    let inner = match order.material {
        Some(_) => outer.clone(),
        None => Material::plain("inner_glaze", order.color.mix(CREAM, 0.75), 0.2),
    };
    let line = Material::plain("rim_line", order.color.scaled(0.55), 0.25);
    let mut mesh = TexturedMesh::default();
    let body = wrapped_around(vessel(&outside, 0.0042, 0.0065, 48));
    add_by(&mut mesh, body, &[&outer, &inner], |center, normal| {
        let inward = normal.dot(DVec3::new(center.x, center.y, 0.0)) < -1e-9;
        usize::from(inward || (normal.z > 0.5 && center.z < 0.5 * h))
    });
    let lip = ring(r - 0.002, 0.0027, 48, 8).translated(DVec3::new(0.0, 0.0, 0.98 * h - 0.0022));
    mesh.add(lip, if order.material.is_some() { &inner } else { &line });
    fitted_round(mesh, order.size_m)
}
