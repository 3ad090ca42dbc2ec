//! Headphones, speaker, desk lamp, desk fan, desk clock.

use std::f64::consts::{PI, TAU};

use glam::DQuat;

use super::images::{clock_dial, grille};
use super::parts::*;
use crate::Order;
use crate::tables::grain::along_repeating;
use crate::texture::mapped_from_front;
use geometry::shapes::{
    circle, cylinder, ellipsoid, loft, ring, rounded_rectangle, shell_of_revolution, sphere, superellipse,
    tube,
};
use geometry::{DVec3, Material, Rgb, TexturedMesh};

/// Lying with swiveled ear cups, cushions up, the band behind them.
pub fn headphones(order: &mut Order) -> TexturedMesh {
    let size = order.size_m;
    let body = body_finish(order, 0.4);
    let (pad, mesh_cloth) =
        (plain("cushion", 0x1d_1d_20, 0.85), Material::textured("cloth", grille(Rgb::hex(0x55_57_5c)), 0.9));
    let metal = steel();
    let (w, d, h) = (size.x, size.y, size.z);
    let mut mesh = TexturedMesh::default();
    let (cx, cy) = (0.285 * w, -0.5 * d + 0.235 * d);
    let (rx, ry) = (0.21 * w, 0.235 * d);
    for side in [-1.0, 1.0] {
        let center = at(side * cx, cy, 0.0);
        let shell = superellipse(2.0 * rx, 2.0 * ry, 2.3, 40);
        mesh.add(plate(&shell, 0.0, 0.55 * h, 0.18 * h).translated(center), &body);
        let section: Vec<_> = circle(0.24 * h, 14);
        let path: Vec<DVec3> = superellipse(2.0 * (rx - 0.26 * h), 2.0 * (ry - 0.26 * h), 2.3, 36)
            .iter()
            .map(|p| p.extend(0.76 * h))
            .collect();
        let cushion = geometry::shapes::sweep_closed(&path, &section, DVec3::Z);
        mesh.add(cushion.translated(center), &pad);
        let cloth = superellipse(2.0 * (rx - 0.3 * h), 2.0 * (ry - 0.3 * h), 2.3, 32);
        mesh.add(plate(&cloth, 0.5 * h, 0.66 * h, 0.0).with_box_uvs(0.03).translated(center), &mesh_cloth);
        // Fork that holds the cup, reaching back to the band.
        let fork = rounded(at(-0.006, 0.0, 0.22 * h), at(0.006, 0.3 * d, 0.5 * h), 0.003, 0.001);
        mesh.add(
            fork.rotated(DQuat::from_rotation_z(-side * 0.06))
                .translated(center + at(side * 0.6 * rx, 0.62 * ry, 0.0)),
            &metal,
        );
    }
    let (reach, back) = (0.46 * w, 0.5 * d - 0.0045);
    let start = 0.02 * d;
    let steps = 36;
    let arc: Vec<DVec3> = (0..=steps)
        .map(|k| {
            let angle = PI * f64::from(k) / f64::from(steps);
            at(reach * angle.cos(), start + (back - start) * angle.sin(), 0.42 * h)
        })
        .collect();
    mesh.add(strap(&arc, 0.007, 0.5 * h, DVec3::Z), &body);
    let padded: Vec<DVec3> = arc[8..=28].iter().map(|p| at(0.965 * p.x, p.y - 0.004, p.z)).collect();
    mesh.add(strap(&padded, 0.012, 0.62 * h, DVec3::Z), &pad);
    fitted(mesh, size)
}

/// A cabinet with woofer, tweeter, port and badge on its front.
pub fn speaker(order: &mut Order) -> TexturedMesh {
    let size = order.size_m;
    let body = body_finish(order, 0.5);
    let (baffle, rubber) = (plain("baffle", 0x1c_1d_1f, 0.6), plain("surround", 0x30_31_34, 0.8));
    let (cone, metal) = (plain("cone", 0x8d_8a_80, 0.6), steel());
    let (w, d, h) = (size.x, size.y, size.z);
    let mut mesh = TexturedMesh::default();
    let front = -0.5 * d + 0.006;
    let foot = 0.006;
    let cabinet = rounded(at(-0.5 * w, front + 0.004, foot), at(0.5 * w, 0.5 * d, h), 0.006, 0.004);
    mesh.add(along_repeating(cabinet, DVec3::Z, 0.25), &body);
    let panel: Vec<_> =
        moved(&rounded_rectangle(0.94 * w, 0.95 * (h - foot), 0.012, 4), p2(0.0, foot + 0.5 * (h - foot)));
    mesh.add(upright(&panel, front, front + 0.007, 0.002), &baffle);
    let drive = |radius: f64, z: f64, mesh: &mut TexturedMesh| {
        let toward = |solid: geometry::Solid| {
            solid.rotated(DQuat::from_rotation_x(0.5 * PI)).translated(at(0.0, front + 0.001, z))
        };
        let trim = hoop(&[(0.86 * radius, 0.0), (radius, 0.0), (radius, 0.003), (0.86 * radius, 0.004)], 40);
        mesh.add(toward(trim), &metal);
        mesh.add(
            toward(ring(0.77 * radius, 0.1 * radius, 40, 10).translated(DVec3::NEG_Z * 0.06 * radius)),
            &rubber,
        );
        let dish = turned(&[(0.7 * radius, -0.004), (0.7 * radius, 0.0035), (0.3 * radius, 0.0018)], 40);
        mesh.add(toward(dish), &cone);
        mesh.add(
            toward(
                ellipsoid(at(0.5 * radius, 0.5 * radius, 0.3 * radius), 24)
                    .translated(DVec3::NEG_Z * 0.12 * radius),
            ),
            &rubber,
        );
    };
    drive(0.39 * w, foot + 0.34 * (h - foot), &mut mesh);
    drive(0.2 * w, foot + 0.79 * (h - foot), &mut mesh);
    let badge = rounded_rectangle(0.16 * w, 0.02 * h, 0.001, 2);
    mesh.add(upright(&moved(&badge, p2(0.0, foot + 0.05 * h)), front - 0.001, front + 0.001, 0.0), &metal);
    for (x, y) in [(-0.36, -0.34), (0.36, -0.34), (-0.36, 0.4), (0.36, 0.4)] {
        mesh.add(cylinder(0.008, foot + 0.001, 0.001, 16).translated(at(x * w, y * d, 0.0)), &rubber);
    }
    fitted(mesh, size)
}

/// Weighted foot, two arms with joints, a conical shade over the light bulb.
pub fn desk_lamp(order: &mut Order) -> TexturedMesh {
    let size = order.size_m;
    let body = body_finish(order, 0.35);
    let (metal, bulb) = (steel(), plain("bulb", 0xff_f3_cf, 0.3));
    let (w, d, h) = (size.x, size.y, size.z);
    let radius = 0.5 * w;
    let base_y = 0.5 * d - radius;
    let mut mesh = TexturedMesh::default();
    let foot = [
        (0.97 * radius, 0.0),
        (radius, 0.004),
        (radius, 0.016),
        (0.9 * radius, 0.024),
        (0.25 * radius, 0.03),
        (0.2 * radius, 0.04),
    ];
    mesh.add(turned(&foot, 48).translated(at(0.0, base_y, 0.0)), &body);
    let (shoulder, elbow) = (at(0.0, base_y, 0.045), at(0.0, 0.5 * d - 0.014, 0.5 * h));
    let head = at(0.0, -0.2 * d, 0.9 * h);
    let twin = order.pick(2) == 0;
    let offsets: &[f64] = if twin { &[-0.011, 0.011] } else { &[0.0] };
    let bar = if twin { 0.0042 } else { 0.007 };
    for &x in offsets {
        for (from, to) in [(shoulder, elbow), (elbow, head)] {
            mesh.add(tube(&[from + DVec3::X * x, to + DVec3::X * x], bar, 14), &metal);
        }
    }
    for joint in [shoulder, elbow, head] {
        let hub = turned_along_x(&[(0.011, -0.016), (0.013, -0.014), (0.013, 0.014), (0.011, 0.016)], 24);
        mesh.add(hub.translated(joint), &body);
    }
    let outward = at(0.0, -0.45, -0.9).normalize();
    let length = 0.28 * h;
    let rim = 0.42 * w;
    let outside = [
        p2(0.3 * rim, 0.0),
        p2(0.34 * rim, 0.2 * length),
        p2(0.5 * rim, 0.4 * length),
        p2(0.85 * rim, 0.8 * length),
        p2(rim, length),
    ];
    let start = head - outward * 0.018;
    mesh.add(pointed(shell_of_revolution(&outside, 0.0025, 0.004, 40), start, outward), &body);
    mesh.add(pointed(turned(&[(0.012, -0.02), (0.014, -0.018), (0.014, 0.03)], 20), start, outward), &metal);
    let glow = ellipsoid(at(0.036, 0.036, 0.05), 24);
    mesh.add(pointed(glow, start + outward * (0.45 * length), outward), &bulb);
    mesh.add(pointed(turned(&[(0.01, 0.0), (0.01, 0.5 * length)], 16), start, outward), &metal);
    let switch = cylinder(0.007, 0.008, 0.001, 16).translated(at(0.0, base_y - 0.6 * radius, 0.022));
    mesh.add(switch, &plain("switch", 0xc0_35_2c, 0.4));
    fitted(mesh, size)
}

/// Four blades behind a wire cage on a weighted stand.
pub fn desk_fan(order: &mut Order) -> TexturedMesh {
    let size = order.size_m;
    let body = body_finish(order, 0.4);
    let wire = Material::metal("cage", Rgb::hex(0xc4_c7_cb), 0.3);
    let dark = plain("motor", 0x3a_3c_40, 0.5);
    let (w, d, h) = (size.x, size.y, size.z);
    let cage = 0.5 * w;
    let hub = at(0.0, 0.0, h - cage);
    let deep = 0.26 * d;
    let bar = 0.0014;
    let mut mesh = TexturedMesh::default();
    let toward = |solid: geometry::Solid, y: f64| {
        solid.rotated(DQuat::from_rotation_x(0.5 * PI)).translated(hub + DVec3::Y * y)
    };
    let hoop_at = |radius: f64, thick: f64, segments: usize| {
        ring(radius, thick, segments, 5).translated(DVec3::NEG_Z * thick)
    };
    mesh.add(toward(hoop_at(cage - 0.0025, 0.0025, 48), 0.0), &wire);
    for (front, reach) in [(-1.0, deep), (1.0, deep)] {
        mesh.add(toward(hoop_at(0.66 * cage, bar, 32), front * 0.72 * reach), &wire);
        mesh.add(toward(hoop_at(0.34 * cage, bar, 24), front * 0.95 * reach), &wire);
        for k in 0..18 {
            let spoke = glam::DVec2::from_angle(TAU * f64::from(k) / 18.0);
            let point = |radius: f64, y: f64| hub + at(spoke.x * radius, y, spoke.y * radius);
            let path = [
                point(cage - 0.0025, 0.0),
                point(0.66 * cage, front * 0.72 * reach),
                point(0.34 * cage, front * 0.95 * reach),
                point(0.16 * cage, front * reach),
            ];
            mesh.add(tube(&path, bar, 4), &wire);
        }
    }
    mesh.add(
        toward(turned(&[(0.2 * cage, 0.0), (0.2 * cage, 0.004), (0.17 * cage, 0.006)], 28), -deep + 0.004),
        &body,
    );
    mesh.add(toward(turned(&[(0.13 * cage, 0.0), (0.13 * cage, 2.0 * deep)], 24), deep), &dark);
    let motor = [(0.3 * cage, 0.0), (0.36 * cage, 0.05 * d), (0.34 * cage, 0.2 * d), (0.2 * cage, 0.25 * d)];
    mesh.add(turned_along_y(&motor, 32).translated(hub + DVec3::Y * (deep - 0.004)), &body);
    let blades = 4;
    for k in 0..blades {
        let turn = DQuat::from_rotation_y(TAU * f64::from(k) / f64::from(blades));
        let steps = 8;
        let rings: Vec<Vec<DVec3>> = (0..=steps)
            .map(|s| {
                let t = f64::from(s) / f64::from(steps);
                let radius = 0.1 * cage + 0.76 * cage * t;
                let half = cage * (0.1 + 0.24 * (PI * (0.12 + 0.8 * t)).sin());
                let pitch = 0.6 - 0.25 * t;
                superellipse(2.0 * half, 0.003, 2.5, 10)
                    .iter()
                    .map(|p| {
                        let (sin, cos) = f64::sin_cos(pitch);
                        at(p.x * cos - p.y * sin + 0.12 * cage * t, p.x * sin + p.y * cos, radius)
                    })
                    .collect()
            })
            .collect();
        mesh.add(loft(&rings).rotated(turn).translated(hub), &body);
    }
    let neck = at(0.0, deep + 0.06 * d, 0.02);
    mesh.add(tube(&[neck, at(0.0, neck.y, hub.z - 0.1 * cage)], 0.011, 20), &body);
    let foot = superellipse(0.72 * w, d, 2.4, 44);
    mesh.add(plate(&foot, 0.0, 0.022, 0.005), &body);
    for k in 0..3 {
        let knob = turned(&[(0.008, 0.0), (0.007, 0.008)], 14).translated(at(
            0.022 * (f64::from(k) - 1.0),
            -0.32 * d,
            0.021,
        ));
        mesh.add(knob, if k == 0 { &dark } else { &wire });
    }
    fitted(mesh, size)
}

/// Twin-bell alarm clock on two feet, dial toward the viewer.
pub fn desk_clock(order: &mut Order) -> TexturedMesh {
    let size = order.size_m;
    let body = body_finish(order, 0.3);
    let face = Rgb::hex([0xf6_f2_e6, 0xfd_fd_fb, 0x22_25_2a][order.pick(3)]);
    let ink = if face.0[0] > 0.5 { Rgb::hex(0x1c_1c_1e) } else { Rgb::hex(0xf0_ee_e6) };
    let dial = Material::textured("dial", clock_dial(face, ink, &mut order.rng), 0.4);
    let bells = [Rgb::hex(0xc9_cb_cd), Rgb::hex(0xc9_a2_4c)][order.pick(2)];
    let metal = finish_or(order, |_| Material::metal("bells", bells, 0.22));
    let (w, d, h) = (size.x, size.y, size.z);
    let radius = 0.46 * w;
    let center = at(0.0, 0.0, 0.06 * h + radius);
    let half = 0.36 * d;
    let mut mesh = TexturedMesh::default();
    let case = [(0.9 * radius, -half), (radius, -0.8 * half), (radius, 0.7 * half), (0.8 * radius, half)];
    mesh.add(turned_along_y(&case, 48).translated(center), &body);
    let bezel = hoop(
        &[(0.86 * radius, 0.0), (0.97 * radius, 0.0), (0.95 * radius, 0.006), (0.86 * radius, 0.004)],
        48,
    )
    .rotated(DQuat::from_rotation_x(0.5 * PI))
    .translated(center - DVec3::Y * (half - 0.001));
    mesh.add(bezel, &metal);
    let disc = moved(&circle(0.87 * radius, 48), p2(0.0, center.z));
    mesh.add(mapped_from_front(upright(&disc, -half - 0.0015, -half + 0.001, 0.0)), &dial);
    for side in [-1.0, 1.0] {
        let lean = at(side * 0.62, 0.0, 0.78);
        let bell = shell_of_revolution(
            &[
                p2(0.42 * radius, 0.0),
                p2(0.4 * radius, 0.09 * h),
                p2(0.3 * radius, 0.15 * h),
                p2(0.12 * radius, 0.185 * h),
            ],
            0.003,
            0.003,
            32,
        );
        mesh.add(pointed(bell, center + lean * (1.12 * radius), lean), &metal);
        mesh.add(tube(&[center + lean * (0.9 * radius), center + lean * (1.25 * radius)], 0.004, 12), &body);
        let foot_top = center + at(side * 0.55, 0.0, -0.75) * radius;
        let sole = at(side * 0.72 * radius, 0.0, 0.0);
        for y in [-0.4, 0.4] {
            let foot = sole + DVec3::Y * (y * d);
            mesh.add(tube(&[foot_top, foot + DVec3::Z * 0.005], 0.0055, 12), &metal);
            mesh.add(cylinder(0.1 * d, 0.007, 0.001, 20).translated(foot), &metal);
        }
    }
    let crown = center + DVec3::Z * radius;
    mesh.add(tube(&[crown - DVec3::Z * 0.005, crown + DVec3::Z * (0.2 * radius)], 0.0028, 10), &metal);
    mesh.add(
        turned_along_x(&[(0.0055, -0.009), (0.0055, 0.009)], 14)
            .translated(crown + DVec3::Z * (0.22 * radius)),
        &body,
    );
    let arch: Vec<DVec3> = (0..=14)
        .map(|k| {
            let angle = PI * f64::from(k) / 14.0;
            let foot = center.z + 1.42 * radius;
            at(0.62 * radius * angle.cos(), 0.0, foot + (h - 0.004 - foot) * angle.sin())
        })
        .collect();
    mesh.add(tube(&arch, 0.0035, 10), &metal);
    mesh.add(sphere(0.006, 12).translated(at(0.0, half - 0.003, center.z - 0.006)), &metal);
    fitted(mesh, size)
}
