//! Bread, pastry, cake and cheese.

use std::f64::consts::{PI, TAU};

use glam::{DQuat, DVec2, DVec3};

use super::assembly::{add_by, counter_clockwise, deformed, fitted, flattened, repeated, spline};
use crate::Order;
use crate::texture::{Noise, crust, draw_texture, mapped_from_above, mapped_on_box, sprinkles};
use geometry::shapes::{
    circle, cylinder, ellipse, ellipsoid, lathe, loft, prism, ring, smooth, sphere, superellipse, sweep,
};
use geometry::{Material, Rgb, Solid, TexturedMesh};
use imaging::Texture;
use runtime::seed::Rng;

/// Soft inside of bread: pale with pores.
fn crumb(rng: &mut Rng) -> Texture {
    let (pores, cloud) = (Noise::new(34, 34, rng), Noise::new(6, 6, rng));
    let pale = Rgb::hex(0xf0_dd_b4);
    draw_texture(128, 128, |u, v| {
        let pore = (pores.at(u, v) - 0.72).max(0.0);
        pale.scaled(0.96 + 0.06 * cloud.at(u, v) - 0.9 * pore)
    })
}

/// A bar along +x whose cross-sections are `outline` (x = +y, y = +z) scaled about (0, `pivot_m`) by
/// `scale` at each x of `stations`, lowered by `press_m` into the table plane, which flattens the underside.
fn bar(outline: &[DVec2], pivot_m: f64, press_m: f64, stations: &[(f64, f64)]) -> Solid {
    let rings: Vec<Vec<DVec3>> = stations
        .iter()
        .map(|&(x, scale)| {
            outline
                .iter()
                .map(|p| DVec3::new(x, scale * p.x, (pivot_m + scale * (p.y - pivot_m) - press_m).max(0.0)))
                .collect()
        })
        .collect();
    loft(&rings)
}

pub(super) fn bread_loaf(order: &mut Order) -> TexturedMesh {
    let DVec3 { x: l, y: w, z: h } = order.size_m;
    let outline: Vec<DVec2> = smooth(
        &[
            (0.0, 0.0),
            (0.4, 0.0),
            (0.45, 0.06),
            (0.445, 0.45),
            (0.5, 0.66),
            (0.44, 0.88),
            (0.24, 0.98),
            (0.0, 1.0),
            (-0.24, 0.98),
            (-0.44, 0.88),
            (-0.5, 0.66),
            (-0.445, 0.45),
            (-0.45, 0.06),
            (-0.4, 0.0),
        ]
        .map(|(y, z): (f64, f64)| DVec2::new(y * w, z * h)),
        3,
    )
    .into_iter()
    .map(|p| DVec2::new(p.x, p.y.max(0.0)))
    .collect();
    let brown = order.color;
    let crust =
        Material::textured("crust", crust(brown, brown.mix(Rgb::hex(0xe2_b0_70), 0.7), &mut order.rng), 0.75);
    let inside = Material::textured("crumb", crumb(&mut order.rng), 0.9);
    let mut mesh = TexturedMesh::default();
    let thick = 0.013;
    let slices = 2 + order.pick(2);
    let start = -0.5 * l + 0.021 * slices as f64;
    let body = bar(
        &outline,
        0.42 * h,
        0.0006,
        &[
            (start, 1.0),
            (start + 0.25 * (0.5 * l - start), 1.0),
            (start + 0.6 * (0.5 * l - start), 1.0),
            (0.5 * l - 0.028, 0.993),
            (0.5 * l - 0.013, 0.955),
            (0.5 * l - 0.004, 0.87),
            (0.5 * l, 0.72),
        ],
    );
    add_by(&mut mesh, repeated(body, 3.0, 2.0), &[&crust, &inside], |c, n| {
        usize::from(n.x < -0.95 && c.x < start + 0.001)
    });
    for k in 0..slices {
        // Each slice leans back on what stands behind it.
        let slice = bar(
            &outline,
            0.42 * h,
            0.0,
            &[(0.0, 0.985), (0.0012, 1.0), (thick - 0.0012, 1.0), (thick, 0.985)],
        );
        let lean = 0.1 + 0.05 * k as f64;
        let foot = start - 0.02 * (k + 1) as f64;
        let slice = slice.rotated(DQuat::from_rotation_y(lean)).translated(DVec3::X * foot);
        let slice = flattened(slice, 0.0);
        add_by(&mut mesh, slice, &[&crust, &inside], |_, n| usize::from(n.x.abs() > 0.9));
    }
    // The cut end toward +x.
    fitted(mesh.rotated(DQuat::from_rotation_z(PI)), order.size_m)
}

pub(super) fn baguette(order: &mut Order) -> TexturedMesh {
    let DVec3 { x: l, y: w, z: h } = order.size_m;
    let outline: Vec<DVec2> = superellipse(w, h, 2.1, 28)
        .into_iter()
        .map(|p| DVec2::new(p.x, (p.y + 0.5 * h).max(0.09 * h) - 0.09 * h))
        .collect();
    let n = 28;
    let stations: Vec<(f64, f64)> = (0..=n)
        .map(|k| {
            let t = 2.0 * f64::from(k) / f64::from(n) - 1.0;
            let x = (0.5 * PI * t).sin();
            (0.5 * l * x, (1.0 - x.abs().powf(3.2)).max(0.0).powf(0.55).max(0.12))
        })
        .collect();
    let brown = order.color;
    let skin = crust(brown, brown.mix(Rgb::hex(0xe8_bd_7c), 0.6), &mut order.rng);
    let mut mesh = TexturedMesh::default();
    let body = bar(&outline, 0.2 * h, 0.025 * h, &stations);
    mesh.add(repeated(body, 1.0, 4.0), &Material::textured("crust", skin, 0.75));
    let pale = Material::textured("score", crumb(&mut order.rng), 0.85);
    let scores = 5 + order.pick(2);
    for k in 0..scores {
        let x = l * 0.74 * ((k as f64 + 0.5) / scores as f64 - 0.5);
        let score = ellipsoid(DVec3::new(0.13 * l, 0.24 * w, 0.24 * h), 20);
        let score = score.rotated(DQuat::from_rotation_z(0.32)).translated(DVec3::new(x, 0.0, 0.735 * h));
        mesh.add(score, &pale);
    }
    fitted(mesh, order.size_m)
}

pub(super) fn croissant(order: &mut Order) -> TexturedMesh {
    let r = 0.5 * order.size_m.z;
    let arc = 1.25;
    let radius = order.size_m.x * 0.44;
    let n = 84;
    let path: Vec<DVec3> = (0..=n)
        .map(|k| {
            let angle = arc * (2.0 * f64::from(k) / f64::from(n) - 1.0);
            DVec3::new(radius * angle.sin(), radius * angle.cos(), 0.0)
        })
        .collect();
    // Seven overlapping rolls: each starts high and tapers toward the horn.
    let girth = |t: f64| {
        let s = 2.0 * t - 1.0;
        let envelope = (1.0 - s.abs().powf(1.6)).max(0.0).powf(0.62).max(0.14);
        let steps = 7.0 * t;
        let within = if s < 0.0 { steps.fract() } else { 1.0 - steps.fract() };
        let midpoint = (steps.floor() - 3.0).abs() < 0.5;
        let roll = if midpoint { 1.0 } else { 0.84 + 0.16 * within };
        envelope * roll
    };
    let section = ellipse(2.3 * r, 2.0 * r, 20);
    let brown = order.color;
    let (streak, fine) = (Noise::new(5, 42, &mut order.rng), Noise::new(20, 60, &mut order.rng));
    let skin = draw_texture(128, 256, |u, v| {
        let layer = 0.5 + 0.5 * (v * 7.0 * std::f32::consts::TAU).cos();
        let pale = (0.45 * layer + 0.7 * streak.at(u, v) - 0.35).clamp(0.0, 0.8);
        brown.mix(Rgb::hex(0xe9_b8_66), pale).scaled(0.9 + 0.2 * fine.at(u, v))
    });
    let mut mesh = TexturedMesh::default();
    let body = flattened(sweep(&path, &section, DVec3::Z, girth), -0.62 * r);
    mesh.add(body, &Material::textured("crust", skin, 0.5));
    fitted(mesh, order.size_m)
}

pub(super) fn donut(order: &mut Order) -> TexturedMesh {
    let d = order.size_m.x;
    let bar_r = 0.27 * 0.5 * d * 1.05;
    let around = 0.5 * d - bar_r;
    let squash = DVec3::new(1.0, 1.0, order.size_m.z / (2.0 * bar_r));
    let dough = crust(Rgb::hex(0xc9_8a_48), Rgb::hex(0xe4_b8_74), &mut order.rng);
    let dough = Material::textured("dough", dough, 0.8);
    let icing_color = order.color;
    let sprinkled = order.pick(3) > 0;
    let count = if sprinkled { 110 } else { 0 };
    let icing = Material::textured("icing", sprinkles(icing_color, count, &mut order.rng), 0.25);
    let body = flattened(ring(around, bar_r, 48, 20), 0.14 * bar_r);
    let waves = Noise::new(11, 1, &mut order.rng);
    let coat = deformed(ring(around, bar_r + 0.0016, 48, 22), |p| {
        let angle = p.y.atan2(p.x) / TAU;
        let edge = bar_r * (0.82 + 0.5 * f64::from(waves.at(angle as f32, 0.0)));
        DVec3::new(p.x, p.y, p.z.max(edge))
    });
    let coat = mapped_from_above(coat);
    let mut mesh = TexturedMesh::default();
    mesh.add(repeated(body, 3.0, 1.0).scaled(squash), &dough);
    mesh.add(coat.scaled(squash), &icing);
    fitted(mesh, order.size_m)
}

pub(super) fn cake(order: &mut Order) -> TexturedMesh {
    let DVec3 { x: d, z: h, .. } = order.size_m;
    let r = 0.5 * d;
    let color = order.color;
    let china = Material::plain("plate", Rgb([0.93, 0.93, 0.92]), 0.2);
    let icing = Material::plain("icing", color, 0.45);
    let cream = Material::plain("cream", Rgb::hex(0xf6_ee_de), 0.5);
    let dark = color.0.iter().sum::<f32>() < 1.5 || order.pick(2) == 0;
    let (crumb_color, pale) = if dark { (0x5a_34_20, 0x6e_44_2a) } else { (0xd9_a8_5a, 0xe8_c4_80) };
    let sponge = crust(Rgb::hex(crumb_color), Rgb::hex(pale), &mut order.rng);
    let sponge = Material::textured("sponge", sponge, 0.9);
    // A slice is missing toward the front right.
    let gap = (-0.62 * PI, -0.32 * PI);
    let midpoint = 0.5 * (gap.0 + gap.1);
    let sector = |radius: f64, back: f64| -> Vec<DVec2> {
        let center = -back * DVec2::from_angle(midpoint);
        let mut outline = vec![center];
        let steps = 40;
        outline.extend((0..=steps).map(|k| {
            let angle = gap.1 + (TAU - (gap.1 - gap.0)) * f64::from(k) / f64::from(steps);
            let turn = back / radius * (2.0 * f64::from(k) / f64::from(steps) - 1.0) * -0.6;
            radius * DVec2::from_angle(angle + turn)
        }));
        counter_clockwise(outline)
    };
    let layer =
        |low: f64, high: f64, outline: &[DVec2]| prism(outline, high - low).translated(DVec3::Z * low);
    let base = 0.05 * h;
    let top = 0.82 * h;
    let mut mesh = TexturedMesh::default();
    mesh.add(cylinder(r, base + 0.0005, 0.0025, 48), &china);
    let (inner, outer) = (0.84 * r, 0.87 * r);
    let (a, b) = (base + 0.3 * (top - base), base + 0.42 * (top - base));
    let e = base + 0.93 * (top - base);
    mesh.add(layer(base, a, &sector(inner, 0.0)), &sponge);
    mesh.add(layer(a - 0.0004, b, &sector(inner - 0.0005, 0.0012)), &cream);
    mesh.add(layer(b - 0.0004, e, &sector(inner, 0.0)), &sponge);
    mesh.add(layer(base + 0.0004, top, &sector(outer, 0.0035)), &icing);
    let drip = Noise::new(13, 1, &mut order.rng);
    let glaze = if dark { Rgb::hex(0x4a_28_18) } else { color.mix(Rgb::hex(0xd0_5a_6a), 0.6) };
    let cap = deformed(prism(&sector(outer + 0.0015, 0.0032), 0.02 * h), |p| {
        let rim = ((p.truncate().length() / outer - 0.97) / 0.03).clamp(0.0, 1.0);
        let angle = (p.y.atan2(p.x) / TAU) as f32;
        let fall = if p.z < 0.001 { rim * 0.34 * h * f64::from(drip.at(angle, 0.0)).powi(2) } else { 0.0 };
        DVec3::new(p.x, p.y, p.z - fall)
    });
    mesh.add(cap.translated(DVec3::Z * (top - 0.0008)), &Material::plain("glaze", glaze, 0.2));
    let cherry = Material::plain("cherry", Rgb::hex(0xb0_18_24), 0.15);
    let dollop = spline(
        &[(0.0, 0.0), (0.1 * r, 0.0), (0.115 * r, 0.02 * h), (0.07 * r, 0.065 * h), (0.0, 0.085 * h)],
        3,
    );
    let dollop = lathe(&dollop, 14);
    let deck = top + 0.02 * h - 0.0012;
    for k in 0..8 {
        let angle = gap.1 + (TAU - (gap.1 - gap.0)) * (f64::from(k) + 0.5) / 8.0;
        let at = (0.67 * r * DVec2::from_angle(angle)).extend(deck);
        mesh.add(dollop.clone().translated(at), &cream);
        mesh.add(sphere(0.055 * r, 12).translated(at + DVec3::Z * 0.055 * h), &cherry);
    }
    fitted(mesh, order.size_m)
}

pub(super) fn cheese_wedge(order: &mut Order) -> TexturedMesh {
    let DVec3 { x: l, y: w, z: h } = order.size_m;
    let color = order.color;
    let rind = Material::plain("rind", color.mix(Rgb::hex(0xb8_7a_20), 0.55), 0.55);
    let holes = {
        let spots: Vec<(f32, f32, f32)> = (0..13)
            .map(|_| {
                (
                    order.uniform(0.08, 0.92) as f32,
                    order.uniform(0.1, 0.9) as f32,
                    order.uniform(0.02, 0.075) as f32,
                )
            })
            .collect();
        let cloud = Noise::new(5, 5, &mut order.rng);
        draw_texture(256, 256, move |u, v| {
            let mut shade = 0.97 + 0.06 * cloud.at(u, v);
            for &(x, y, radius) in &spots {
                let (dx, dy) = ((u - x) / radius, (v - y) / (0.85 * radius));
                let r2 = dx * dx + dy * dy;
                if r2 < 1.0 {
                    // Lit from above: the hole's upper wall is in shadow.
                    shade = 0.72 + 0.14 * (1.0 - dy) * 0.5 - 0.1 * dy.max(0.0);
                } else if r2 < 1.25 {
                    shade = shade.max(1.05);
                }
            }
            color.scaled(shade)
        })
    };
    let paste = Material::textured("paste", holes, 0.5);
    // Tip toward -x, rind along +x; round notches where holes were cut through the front side.
    let tip = DVec2::new(-0.5 * l, 0.0);
    let front = DVec2::new(0.44 * l, -0.5 * w);
    let notches = [(0.3, 0.05), (0.58, 0.075), (0.82, 0.045)];
    let mut outline = vec![tip];
    let along = (front - tip).normalize();
    let inside = along.perp();
    for (t, size) in notches {
        let center = tip + (front - tip) * t;
        let radius = size * l * order.uniform(0.8, 1.1);
        outline.extend((0..=7).map(|k| {
            let angle = PI * f64::from(k) / 7.0;
            center + radius * (-angle.cos() * along + 0.75 * angle.sin() * inside)
        }));
    }
    outline.extend((0..=10).map(|k| {
        let t = 2.0 * f64::from(k) / 10.0 - 1.0;
        DVec2::new(0.44 * l + 0.06 * l * (1.0 - t * t), 0.5 * w * t)
    }));
    let outline = counter_clockwise(outline);
    let midpoint: Vec<DVec3> = outline.iter().map(|p| p.extend(0.5 * h)).collect();
    let wedge = loft(&[
        outline.iter().map(|p| p.extend(0.0)).collect(),
        midpoint,
        outline.iter().map(|p| p.extend(h)).collect(),
    ]);
    let wedge = mapped_on_box(wedge);
    let mut mesh = TexturedMesh::default();
    add_by(&mut mesh, wedge, &[&paste, &rind], |c, n| {
        usize::from(n.z.abs() < 0.5 && n.x > 0.5 && c.x > 0.4 * l)
    });
    let top = prism(&circle(0.06 * w, 18), 0.0016).scaled(DVec3::new(1.2, 1.0, 1.0));
    let pit = Material::plain("hole", color.scaled(0.62), 0.7);
    for (x, y, s) in [(0.25, 0.12, 1.0), (0.05, -0.08, 0.7), (0.32, -0.2, 0.6), (-0.15, 0.03, 0.55)] {
        let at = DVec3::new(x * l, y * w, h - 0.001);
        mesh.add(top.clone().scaled(DVec3::new(s, s, 1.0)).translated(at), &pit);
    }
    mesh.add(prism(&crust_edge(l, w), h + 0.0006), &rind);
    fitted(mesh, order.size_m)
}

/// The rind as a curved strip, 4 mm thick, seen from above.
fn crust_edge(l: f64, w: f64) -> Vec<DVec2> {
    let arc = |offset: f64| {
        (0..=10).map(move |k| {
            let t = 2.0 * f64::from(k) / 10.0 - 1.0;
            DVec2::new(0.44 * l + 0.06 * l * (1.0 - t * t) + offset, 0.5 * w * t)
        })
    };
    let outer: Vec<DVec2> = arc(0.0008).collect();
    let inner: Vec<DVec2> = arc(-0.0035).collect();
    counter_clockwise(outer.into_iter().chain(inner.into_iter().rev()).collect())
}
