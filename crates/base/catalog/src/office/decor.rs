//! Picture frame, vase, candle, coaster, tissue box.

use std::f64::consts::{PI, TAU};

use glam::DQuat;

use super::images::{blossoms, landscape};
use super::parts::*;
use crate::Order;
use crate::texture::{checker, mapped_from_above, material_finish, striped_band, stripes, wrapped_around};
use geometry::shapes::{
    circle, ellipse, ellipsoid, inset, loft_closed, rectangle, ring, rounded_rectangle, shell_of_revolution,
    tube,
};
use geometry::{DVec2, DVec3, Material, Rgb, Solid, TexturedMesh};

/// Leaning on its strut: profiled frame, mat, photograph.
pub fn picture_frame(order: &mut Order) -> TexturedMesh {
    let size = order.size_m;
    let (w, d, h) = (size.x, size.y, size.z);
    let frame = finish_or(order, |order| match order.pick(2) {
        0 => material_finish("oak", order.color, &mut order.rng),
        _ => Material::plain("frame", order.color, 0.4),
    });
    let photo = Material::textured("photograph", landscape(&mut order.rng), 0.25);
    let (mat, back) = (plain("mat", 0xf4_f1_e8, 0.8), plain("backing", 0x3a_34_2e, 0.8));
    let lean: f64 = 0.2;
    let thick = 0.015;
    let length = (h - thick * lean.sin()) / lean.cos();
    let wide = order.uniform(0.1, 0.14) * w;
    let outline = |by: f64| moved(&inset(&rectangle(w, length), by), p2(0.0, 0.5 * length));
    let ring_at = |by: f64, z: f64| -> Vec<DVec3> { outline(by).iter().map(|p| p.extend(z)).collect() };
    let stand = |solid: Solid, floor: f64| {
        let upright = solid.rotated(DQuat::from_rotation_x(0.5 * PI)).translated(DVec3::Y * thick);
        let leaning = upright.rotated(DQuat::from_rotation_x(-lean)).translated(at(0.0, -0.5 * d, 0.0));
        rested(leaning, floor)
    };
    let floor = 0.0;
    let mut mesh = TexturedMesh::default();
    let profile = loft_closed(&[
        ring_at(wide, 0.0),
        ring_at(0.0, 0.0),
        ring_at(0.0, 0.7 * thick),
        ring_at(0.25 * wide, thick),
        ring_at(0.6 * wide, 0.85 * thick),
        ring_at(wide, 0.55 * thick),
    ]);
    mesh.add(stand(profile.with_box_uvs(0.12), floor), &frame);
    mesh.add(stand(plate(&outline(0.6 * wide), 0.001, 0.25 * thick, 0.0), floor), &back);
    mesh.add(stand(plate(&outline(0.9 * wide), 0.2 * thick, 0.4 * thick, 0.0), floor), &mat);
    let margin = wide + 0.07 * w;
    let image = plate(
        &rounded_rectangle(w - 2.0 * margin, length - 2.0 * margin, 0.0008, 2),
        0.35 * thick,
        0.4 * thick + 0.001,
        0.0,
    );
    let image = mapped_from_above(image).translated(at(0.0, 0.5 * length, 0.0));
    mesh.add(stand(image, floor), &photo);
    let (foot, hinge) = (0.5 * d, 0.62 * h);
    let y = -0.5 * d + hinge * lean.tan() + thick - 0.003;
    let strut = [p2(foot - 0.012, 0.0), p2(foot, 0.0), p2(y + 0.005, hinge), p2(y - 0.003, hinge)];
    mesh.add(side_on(&strut, -0.16 * w, 0.16 * w, 0.0008), &back);
    for side in [-1.0, 1.0] {
        let pin = ellipsoid(at(0.007, 0.007, 0.007), 12).translated(at(side * 0.12 * w, y, hinge - 0.01));
        mesh.add(pin, &steel());
    }
    fitted(mesh, size)
}

/// A hollow vase: bottle, amphora or bulb, with glazed bands; a body of revolution.
pub fn vase(order: &mut Order) -> TexturedMesh {
    let size = order.size_m;
    let across = 0.5 * (size.x + size.y);
    let (r, h) = (0.5 * across, size.z);
    let line = order.color.mix(Rgb::hex(0xf6_f0_e2), 0.75);
    let count = 2 + order.pick(3);
    let (low, high) = [(0.3, 0.5), (0.45, 0.6), (0.12, 0.3)][order.pick(3)];
    let body = finish_or(order, |order| {
        Material::textured("glaze", striped_band(order.color, line, low, high, count, &mut order.rng), 0.25)
    });
    let shape: &[(f64, f64)] = match order.pick(3) {
        0 => &[(0.52, 0.0), (0.8, 0.12), (1.0, 0.36), (0.86, 0.56), (0.4, 0.76), (0.34, 0.88), (0.5, 1.0)],
        1 => &[(0.55, 0.0), (0.6, 0.05), (0.78, 0.3), (1.0, 0.62), (0.84, 0.8), (0.5, 0.9), (0.62, 1.0)],
        _ => &[(0.62, 0.0), (0.9, 0.1), (1.0, 0.25), (0.74, 0.5), (0.56, 0.72), (0.68, 0.9), (0.86, 1.0)],
    };
    let outside: Vec<DVec2> = curve(shape, 3).iter().map(|&(radius, z)| p2(radius * r, z * h)).collect();
    let mut mesh = TexturedMesh::default();
    mesh.add(wrapped_around(shell_of_revolution(&outside, 0.004, 0.007, 40)), &body);
    let lip = Material::plain("lip", line, 0.3);
    let rim = outside[outside.len() - 1];
    mesh.add(ring(rim.x - 0.002, 0.0026, 44, 8).translated(DVec3::Z * (h - 0.0046)), &lip);
    fitted(mesh, at(across, across, h))
}

/// A pillar candle with wick and drips in a chamberstick: dish, socket and finger ring.
pub fn candle(order: &mut Order) -> TexturedMesh {
    let size = order.size_m;
    let wax = Material::plain("wax", order.color, 0.5);
    let holder = finish_or(order, |_| Material::metal("brass", Rgb::hex(0xb9_93_4a), 0.32));
    let (w, d, h) = (size.x, size.y, size.z);
    let radius = 0.5 * d;
    let center = at(-0.5 * w + radius, 0.0, 0.0);
    let mut mesh = TexturedMesh::default();
    let dish = shell_of_revolution(
        &[p2(0.7 * radius, 0.0), p2(0.8 * radius, 0.004), p2(0.95 * radius, 0.012), p2(radius, 0.019)],
        0.003,
        0.0035,
        44,
    );
    mesh.add(dish.translated(center), &holder);
    let thick = 0.5 * radius;
    let socket = hoop(
        &[(0.96 * thick, 0.003), (thick + 0.004, 0.003), (thick + 0.003, 0.022), (0.96 * thick, 0.022)],
        36,
    );
    mesh.add(socket.translated(center), &holder);
    let top = h - 0.012;
    let pool = [
        (thick, 0.003),
        (thick, top - 0.004),
        (0.9 * thick, top),
        (0.75 * thick, top - 0.004),
        (0.3 * thick, top - 0.006),
    ];
    mesh.add(turned(&pool, 36).translated(center), &wax);
    for k in 0..7 {
        let angle = TAU * (f64::from(k) + order.uniform(-0.3, 0.3)) / 7.0;
        let run = order.uniform(0.12, 0.5) * (top - 0.03);
        let side = (DVec2::from_angle(angle) * (thick - 0.0005)).extend(0.0);
        let drip = ellipsoid(at(0.006, 0.006, run + 0.008), 12)
            .translated(center + side + DVec3::Z * (top - 0.003 - run));
        mesh.add(drip, &wax);
    }
    let tip = center + at(0.002, 0.0, h - 0.001);
    let wick = [center + DVec3::Z * (top - 0.012), center + DVec3::Z * (h - 0.007), tip];
    mesh.add(tube(&wick, 0.0012, 10), &plain("wick", 0x25_22_20, 0.9));
    let finger = 0.5 * (w - 2.0 * radius) + 0.004;
    let loop_center = at(0.5 * w - finger, 0.0, finger.max(0.016));
    let handle = ring(finger - 0.0022, 0.0022, 32, 8)
        .translated(DVec3::NEG_Z * 0.0022)
        .rotated(DQuat::from_rotation_x(0.5 * PI))
        .translated(loop_center);
    mesh.add(handle, &holder);
    fitted(mesh, size)
}

/// Round or square with a raised rim, patterned top, cork beneath.
pub fn coaster(order: &mut Order) -> TexturedMesh {
    let size = order.size_m;
    let (w, d, h) = (size.x, size.y, size.z);
    let body = body_finish(order, 0.5);
    let pale = order.color.mix(Rgb::hex(0xf4_ee_e0), 0.7);
    let pattern = match order.pick(4) {
        0 => stripes(order.color, pale, 10),
        1 => checker(order.color, pale, 8, 8),
        2 => blossoms(order.color.mix(pale, 0.2), pale, &mut order.rng),
        _ => landscape(&mut order.rng),
    };
    let image = Material::textured("pattern", pattern, 0.4);
    let cork = material_finish("cork", order.color, &mut order.rng);
    let edge = if order.pick(2) == 0 { circle(0.5, 48) } else { rounded_rectangle(1.0, 1.0, 0.12, 8) };
    let outline =
        |by: f64| -> Vec<DVec2> { edge.iter().map(|p| *p * p2(w - 2.0 * by, d - 2.0 * by)).collect() };
    let ring_at = |by: f64, z: f64| -> Vec<DVec3> { outline(by).iter().map(|p| p.extend(z)).collect() };
    let mut mesh = TexturedMesh::default();
    mesh.add(plate(&outline(0.002), 0.0, 0.4 * h, 0.0).with_box_uvs(0.05), &cork);
    let tray = loft_closed(&[
        ring_at(0.005, 0.35 * h),
        ring_at(0.0, 0.35 * h),
        ring_at(0.0, h - 0.0008),
        ring_at(0.0008, h),
        ring_at(0.0032, h),
        ring_at(0.005, 0.75 * h),
    ]);
    mesh.add(tray.with_box_uvs(0.1), &body);
    mesh.add(mapped_from_above(plate(&outline(0.0045), 0.36 * h, 0.8 * h, 0.0)), &image);
    fitted(mesh, size)
}

/// A patterned carton with an oval opening from which a tissue rises.
pub fn tissue_box(order: &mut Order) -> TexturedMesh {
    let size = order.size_m;
    let (w, d, h) = (size.x, size.y, size.z);
    let pale = order.color.mix(Rgb::hex(0xff_fa_f0), 0.75);
    let pattern = blossoms(order.color, pale, &mut order.rng);
    let (carton, tissue) = (Material::textured("carton", pattern, 0.7), plain("tissue", 0xfd_fc_f9, 0.95));
    let film = Material::plain("opening", pale.scaled(0.8), 0.5);
    let top = 0.6 * h;
    let mut mesh = TexturedMesh::default();
    let carton_body = rounded(at(-0.5 * w, -0.5 * d, 0.0), at(0.5 * w, 0.5 * d, top), 0.003, 0.0012);
    mesh.add(carton_body.with_box_uvs(0.11), &carton);
    mesh.add(plate(&ellipse(0.62 * w, 0.5 * d, 40), top - 0.001, top + 0.0007, 0.0), &film);
    let (phase, lean) = (order.uniform(0.0, TAU), order.uniform(-0.08, 0.08));
    let around = 40;
    let rings: Vec<Vec<DVec3>> = (0..=8)
        .map(|k| {
            let t = f64::from(k) / 8.0;
            let (half, thick) = ((0.17 + 0.16 * t - 0.1 * t * t) * w, 0.022 * (1.0 - t) + 0.004);
            (0..around)
                .map(|j| {
                    let angle = TAU * f64::from(j) / f64::from(around);
                    let x = half * angle.cos();
                    let fold = (0.05 + 0.16 * t) * d * (9.0 * x / w * 1.6 + phase + 1.4 * t).sin();
                    let peak = 1.0 - 0.3 * (x / half).powi(2) * t - 0.1 * t * (14.0 * x / w + phase).cos();
                    at(
                        x + lean * t * w,
                        fold + thick * angle.sin(),
                        top - 0.002 + (h - top + 0.002) * t * peak,
                    )
                })
                .collect()
        })
        .collect();
    mesh.add(skin(&rings), &tissue);
    fitted(mesh, size)
}
