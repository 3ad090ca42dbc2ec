//! Potted plants: broad leaves, upright blades, arching grass; cacti.

use std::f64::consts::{PI, TAU};

use super::images::leaf;
use super::parts::*;
use crate::Order;
use crate::texture::{granite, wrapped_around};
use geometry::shapes::{shell_of_revolution, tube};
use geometry::{DVec2, DVec3, Material, Rgb, Solid, TexturedMesh};

/// A pot with a rim, filled with soil; returns the soil's level.
fn add_pot(order: &mut Order, mesh: &mut TexturedMesh, radius: f64, height: f64) -> f64 {
    let finish = finish_or(order, |order| Material::plain("pot", order.color, 0.55));
    let soil = Material::textured("soil", granite(Rgb::hex(0x3f_2e_22), &mut order.rng), 1.0);
    let rim = 0.2 * height;
    let outside = if order.pick(2) == 0 {
        vec![
            p2(0.66 * radius, 0.0),
            p2(0.68 * radius, 0.003),
            p2(0.88 * radius, height - rim),
            p2(radius - 0.001, height - rim + 0.0005),
            p2(radius, height - rim + 0.003),
            p2(radius, height - 0.002),
            p2(radius - 0.001, height),
        ]
    } else {
        curve(&[(0.7, 0.0), (0.84, 0.1), (0.98, 0.5), (1.0, 0.8), (0.95, 1.0)], 2)
            .iter()
            .map(|&(r, z)| p2(r * radius, z * height))
            .collect()
    };
    mesh.add(wrapped_around(shell_of_revolution(&outside, 0.0045, 0.006, 36)), &finish);
    let level = 0.86 * height;
    let earth = turned(
        &[
            (0.66 * radius - 0.003, 0.005),
            (0.9 * radius - 0.003, level - 0.004),
            (0.5 * radius, level + 0.002),
        ],
        32,
    );
    mesh.add(earth.with_box_uvs(0.08), &soil);
    level
}

/// A leaf: midrib from `base` through `path`, half width at each fraction of the length, a shallow fold.
fn blade(path: &[DVec3], half_width: impl Fn(f64) -> f64, fold: f64) -> Solid {
    let last = path.len() - 1;
    let thick = 0.0013;
    let rings: Vec<Vec<DVec3>> = (0..=last)
        .map(|k| {
            let forward = (path[(k + 1).min(last)] - path[k.saturating_sub(1)]).normalize_or(DVec3::Z);
            let side = forward.cross(DVec3::Z).normalize_or(DVec3::X);
            let up = side.cross(forward);
            let half = half_width(k as f64 / last as f64).max(0.0006);
            let edge = |s: f64| path[k] + side * (s * half) + up * (fold * half);
            let (left, right) = (edge(-1.0), edge(1.0));
            vec![
                left,
                path[k] + up * thick * 0.5,
                right,
                right - up * thick,
                path[k] - up * thick * 0.5,
                left - up * thick,
            ]
        })
        .collect();
    let mut solid = skin(&rings);
    for uv in &mut solid.uvs {
        uv.x = if uv.x < 0.5 { 2.0 * uv.x } else { 2.0 - 2.0 * uv.x };
    }
    solid
}

/// Leaves of one of three habits in a pot.
pub fn potted_plant(order: &mut Order) -> TexturedMesh {
    let size = order.size_m;
    let (w, h) = (size.x.min(size.y), size.z);
    let greens = [0x3f_8a_3c, 0x2f_6f_3a, 0x5f_a0_4a, 0x4a_7f_52];
    let green = Rgb::hex(greens[order.pick(4)]);
    let leaves = Material::textured("leaf", leaf(green, &mut order.rng), 0.5);
    let young =
        Material::textured("young_leaf", leaf(green.mix(Rgb::hex(0xb8_d8_5a), 0.35), &mut order.rng), 0.5);
    let stem = Material::plain("stem", green.mix(Rgb::hex(0x7a_5a_3a), 0.5), 0.7);
    let mut mesh = TexturedMesh::default();
    let pot_height = 0.36 * h;
    let level = add_pot(order, &mut mesh, 0.29 * w, pot_height);
    let foot = DVec3::Z * (level - 0.004);
    match order.pick(3) {
        0 => {
            // Stems that carry ovate leaves in whorls.
            let crown = h - 0.05 * h;
            for k in 0..5 {
                let angle = TAU * f64::from(k) / 5.0 + order.uniform(-0.3, 0.3);
                let out = DVec2::from_angle(angle);
                let reach = if k == 0 { 0.02 } else { order.uniform(0.16, 0.24) } * w;
                let top = foot.z + (crown - foot.z) * if k == 0 { 1.0 } else { order.uniform(0.6, 0.85) };
                let bend =
                    |t: f64| (out * (reach * t * t + 0.02 * w * t)).extend(foot.z + (top - foot.z) * t);
                let path: Vec<DVec3> = (0..=5).map(|s| bend(f64::from(s) / 5.0)).collect();
                mesh.add(tube(&path, 0.0022, 8), &stem);
                for j in 0..6 {
                    let t = 0.4 + 0.6 * f64::from(j) / 5.0;
                    let heading = DVec2::from_angle(2.4 * f64::from(j) + 1.3 * f64::from(k));
                    let heading = (heading + 0.5 * out).normalize_or(out);
                    let long = w * order.uniform(0.19, 0.27) * (1.15 - 0.35 * t);
                    let from = bend(t);
                    let rise = order.uniform(0.35, 0.75);
                    let path: Vec<DVec3> = (0..=7)
                        .map(|s| {
                            let q = f64::from(s) / 7.0;
                            from + (heading * (long * q)).extend(long * (rise * q - 0.75 * q * q))
                        })
                        .collect();
                    let half = move |q: f64| 0.3 * long * (PI * q.powf(0.8)).sin().max(0.0).powf(0.8);
                    mesh.add(blade(&path, half, 0.25), if j == 5 { &young } else { &leaves });
                }
            }
        }
        1 => {
            // Stiff upright blades (snake plant).
            for k in 0..13 {
                // The outer ones stand evenly around, so that the plant is centered on its pot.
                let angle = if k > 7 { TAU * f64::from(k) / 5.0 + 0.25 } else { 2.4 * f64::from(k) };
                let out = DVec2::from_angle(angle);
                let spread = 0.02 * w + 0.17 * w * f64::from(k) / 12.0;
                let tall = (h - foot.z) * (1.0 - 0.5 * f64::from(k) / 12.0 * order.uniform(0.7, 1.0));
                let lean = if k > 7 { 0.48 * w - 0.7 * spread } else { order.uniform(0.3, 1.4) * spread };
                let path: Vec<DVec3> = (0..=8)
                    .map(|s| {
                        let q = f64::from(s) / 8.0;
                        foot + (out * (0.7 * spread + lean * q * q)).extend(tall * q)
                    })
                    .collect();
                let wide = 0.055 * w;
                let half = move |q: f64| wide * (0.6 + 0.5 * (PI * q).sin()) * (1.0 - q.powi(4));
                mesh.add(blade(&path, half, 0.35), if k % 4 == 3 { &young } else { &leaves });
            }
        }
        _ => {
            // Arching narrow leaves (spider plant).
            for k in 0..34 {
                let angle = 2.4 * f64::from(k) + order.uniform(-0.2, 0.2);
                let out = DVec2::from_angle(angle);
                let t = f64::from(k) / 33.0;
                let reach = (0.1 + 0.38 * t) * w;
                let peak = (h - foot.z) * (1.0 - 0.45 * t);
                let path: Vec<DVec3> = (0..=9)
                    .map(|s| {
                        let q = f64::from(s) / 9.0;
                        let z = peak
                            * (1.0 - (1.0 - 1.45 * q).powi(2))
                            * if q > 0.69 { 1.0 - 0.5 * (q - 0.69) } else { 1.0 };
                        foot + (out * (0.05 * w * (1.0 - q) + reach * q)).extend(z)
                    })
                    .collect();
                let wide = 0.022 * w;
                let half = move |q: f64| wide * (0.5 + 0.6 * (PI * q).sin()) * (1.0 - q.powi(3));
                mesh.add(blade(&path, half, 0.4), if k % 3 == 0 { &young } else { &leaves });
            }
        }
    }
    fitted(mesh, size)
}

/// A ribbed body: (radius, z) profile with `ribs` bulges.
fn ribbed(profile: &[(f64, f64)], ribs: usize, depth: f64) -> Solid {
    let around = 4 * ribs;
    let rings: Vec<Vec<DVec3>> = profile
        .iter()
        .map(|&(radius, z)| {
            (0..around)
                .map(|k| {
                    let angle = TAU * k as f64 / around as f64;
                    let radius = radius * (1.0 + depth * (ribs as f64 * angle).cos());
                    (radius * DVec2::from_angle(angle)).extend(z)
                })
                .collect()
        })
        .collect();
    geometry::shapes::loft(&rings)
}

/// A barrel with a blossom, or a column with two arms; spines along the ribs.
pub fn cactus(order: &mut Order) -> TexturedMesh {
    let size = order.size_m;
    let (w, h) = (size.x.min(size.y), size.z);
    let green = Rgb::hex([0x4a_86_4a, 0x5f_8f_5a, 0x3a_70_48][order.pick(3)]);
    let flesh = Material::plain("flesh", green, 0.6);
    let spine = plain("spines", 0xf0_e8_c8, 0.6);
    let petal = plain("blossom", [0xe0_4f_8a, 0xf0_c0_3a, 0xe8_6a_4a][order.pick(3)], 0.6);
    let mut mesh = TexturedMesh::default();
    let barrel = order.pick(2) == 0;
    let pot_radius = 0.42 * w;
    let level = add_pot(order, &mut mesh, pot_radius, 0.42 * h) - 0.004;
    let tall = h - level;
    let shape: &[(f64, f64)] = if barrel {
        &[(0.5, 0.0), (0.86, 0.16), (1.0, 0.42), (0.9, 0.7), (0.6, 0.88), (0.2, 0.94), (0.06, 0.93)]
    } else {
        &[(0.4, 0.0), (0.46, 0.1), (0.48, 0.5), (0.47, 0.8), (0.38, 0.93), (0.2, 0.99), (0.04, 1.0)]
    };
    let (radius, height) = (0.8 * pot_radius, if barrel { 0.94 * tall } else { tall });
    let ribs = if barrel { 14 } else { 9 };
    let profile: Vec<(f64, f64)> =
        curve(shape, 3).iter().map(|&(r, z)| (r.max(0.02) * radius, level + z * height)).collect();
    mesh.add(ribbed(&profile, ribs, 0.09), &flesh);
    let thorn = |from: DVec3, out: DVec3, mesh: &mut TexturedMesh| {
        let needle = turned(&[(0.0008, -0.001), (0.0006, 0.002), (0.0001, 0.006)], 4);
        mesh.add(pointed(needle, from, out), &spine);
    };
    for rib in 0..ribs {
        let out = DVec2::from_angle(TAU * rib as f64 / ribs as f64);
        for &(r, z) in profile.iter().skip(3).step_by(2).take(7) {
            thorn((out * (1.08 * r)).extend(z), (out * 0.9).extend(0.45), &mut mesh);
        }
    }
    if barrel {
        let top = DVec3::Z * (level + 0.9 * height);
        for k in 0..8 {
            let out = DVec2::from_angle(TAU * f64::from(k) / 8.0);
            let path: Vec<DVec3> = (0..=5)
                .map(|s| {
                    let q = f64::from(s) / 5.0;
                    top + (out * (0.3 * radius * q)).extend((h - top.z) * (1.0 - (1.0 - q).powi(2)))
                })
                .collect();
            mesh.add(blade(&path, |q| 0.13 * radius * (PI * (0.1 + 0.8 * q)).sin(), 0.3), &petal);
        }
        mesh.add(
            turned(&[(0.1 * radius, 0.0), (0.12 * radius, 0.05 * tall), (0.04 * radius, 0.09 * tall)], 16)
                .translated(top),
            &spine,
        );
    } else {
        for (side, from, rise) in [(-1.0, 0.34, 0.4), (1.0, 0.48, 0.34)] {
            let start = at(side * 0.38 * radius, 0.0, level + from * tall);
            let elbow = side * 0.96 * radius;
            let thick = 0.22 * radius;
            let path: Vec<DVec3> = (0..=6)
                .map(|k| {
                    let angle = 0.5 * PI * f64::from(k) / 6.0;
                    let reach = elbow - start.x;
                    start + at(reach * angle.sin(), 0.0, 0.12 * tall * (1.0 - angle.cos()))
                })
                .chain(
                    (1..=4).map(|k| at(elbow, 0.0, start.z + 0.12 * tall + rise * tall * f64::from(k) / 4.0)),
                )
                .collect();
            let last = path.len() as f64 - 1.0;
            let arm = geometry::shapes::sweep(&path, &geometry::shapes::circle(thick, 18), DVec3::Y, |t| {
                if t * last > last - 0.5 {
                    0.35
                } else if t * last > last - 1.5 {
                    0.92
                } else {
                    1.0
                }
            });
            mesh.add(arm, &flesh);
            for k in 0..12 {
                let out = DVec2::from_angle(2.4 * f64::from(k));
                let z = start.z + (0.16 + rise * 0.75 * f64::from(k) / 11.0) * tall;
                thorn(at(elbow, 0.0, z) + (out * thick * 0.97).extend(0.0), out.extend(0.3), &mut mesh);
            }
        }
    }
    fitted(mesh, size)
}
