//! Pots that pour: teapot, kettle, pitcher. Spout toward +x or -x, handle opposite or above.

use std::f64::consts::PI;

use glam::{DQuat, DVec2, DVec3};

use super::assembly::{add_by, deformed, finish, fitted, loop_handle, points, spline, vessel};
use crate::Order;
use crate::texture::{brushed_metal, ceramic_speckle, striped_band, wrapped_around};
use geometry::shapes::{circle, cylinder, ellipse, ellipsoid, lathe, sweep};
use geometry::{Material, Rgb, Solid, TexturedMesh};

/// A smooth path through `pairs` (x, z) in the x-z plane.
fn path(pairs: &[(f64, f64)], steps: usize) -> Vec<DVec3> {
    spline(pairs, steps).iter().map(|p| DVec3::new(p.x, 0.0, p.y)).collect()
}

/// A dark disc that closes the end of a spout which heads along `along` at `tip`.
fn mouth(tip: DVec3, along: DVec3, radius: f64) -> Solid {
    let disc = cylinder(radius, 0.0022, 0.0, 20).translated(DVec3::Z * -0.0014);
    disc.rotated(DQuat::from_rotation_arc(DVec3::Z, along.normalize())).translated(tip)
}

pub(super) fn teapot(order: &mut Order) -> TexturedMesh {
    let DVec3 { x: long, y: d, z: h } = order.size_m;
    let r = 0.5 * d;
    let spare = long - d;
    let color = order.color;
    let style = order.pick(3);
    let texture = match style {
        0 => ceramic_speckle(color, &mut order.rng),
        1 => striped_band(color, color.mix(Rgb([0.97, 0.95, 0.9]), 0.7), 0.5, 0.72, 2, &mut order.rng),
        _ => striped_band(color, color.scaled(0.7), 0.0, 0.3, 1, &mut order.rng),
    };
    let usual = Material::textured("glaze", texture, 0.25);
    let glaze = finish(order, usual);
    let plain = if order.material.is_some() {
        glaze.clone()
    } else {
        Material::plain("glaze_plain", color.scaled(0.97), 0.25)
    };
    let dark = Material::plain("spout_mouth", Rgb([0.08, 0.07, 0.06]), 0.9);
    let mut mesh = TexturedMesh::default();
    let mut profile = vec![DVec2::ZERO];
    profile.extend(spline(
        &[
            (0.56 * r, 0.0),
            (0.58 * r, 0.03 * h),
            (0.86 * r, 0.14 * h),
            (r, 0.36 * h),
            (0.9 * r, 0.58 * h),
            (0.62 * r, 0.74 * h),
            (0.5 * r, 0.77 * h),
        ],
        3,
    ));
    profile.push(DVec2::new(0.0, 0.77 * h));
    mesh.add(wrapped_around(lathe(&profile, 40)), &glaze);
    let mut lid = vec![DVec2::new(0.0, 0.75 * h)];
    lid.extend(points(&[(0.46 * r, 0.75 * h), (0.56 * r, 0.765 * h), (0.56 * r, 0.785 * h)]));
    lid.extend(spline(
        &[
            (0.52 * r, 0.79 * h),
            (0.34 * r, 0.85 * h),
            (0.09 * r, 0.885 * h),
            (0.09 * r, 0.905 * h),
            (0.17 * r, 0.945 * h),
            (0.12 * r, 0.99 * h),
            (0.0, h),
        ],
        3,
    ));
    mesh.add(lathe(&lid, 32), &plain);
    let tip = r + 0.5 * spare;
    let spout =
        path(&[(0.72 * r, 0.26 * h), (1.02 * r, 0.34 * h), (r + 0.28 * spare, 0.56 * h), (tip, 0.76 * h)], 6);
    let wide = 0.27 * r;
    mesh.add(
        sweep(&spout, &ellipse(2.0 * wide, 1.7 * wide, 18), DVec3::Y, |t| 1.0 - 0.6 * t.powf(0.7)),
        &plain,
    );
    let last = spout.len() - 1;
    mesh.add(mouth(spout[last], spout[last] - spout[last - 1], 0.29 * wide), &dark);
    let grip = loop_handle([0.85 * r; 2], 0.5 * spare + 0.15 * r - 0.0045, 0.44 * h, 0.48 * h, 0.009, 0.013);
    mesh.add(grip.rotated(DQuat::from_rotation_z(PI)), &plain);
    fitted(mesh, order.size_m)
}

pub(super) fn kettle(order: &mut Order) -> TexturedMesh {
    let DVec3 { x: long, y: d, z: h } = order.size_m;
    let r = 0.5 * d;
    let color = order.color;
    let metallic = order.pick(2) == 0 && order.color.0[0] > 0.6;
    let usual = if metallic {
        let texture = brushed_metal(color, &mut order.rng);
        Material { metalness: 1.0, ..Material::textured("steel", texture, 0.25) }
    } else {
        Material::plain("enamel", color, 0.2)
    };
    let body_finish = finish(order, usual);
    let black = Material::plain("grip", Rgb([0.09, 0.09, 0.1]), 0.55);
    let chrome = Material::metal("chrome", Rgb::hex(0xc8_ca_cc), 0.2);
    let mut mesh = TexturedMesh::default();
    let body_h = 0.62 * h;
    let mut profile = vec![DVec2::ZERO, DVec2::new(0.93 * r, 0.0)];
    profile.extend(spline(
        &[
            (0.985 * r, 0.03 * body_h),
            (r, 0.14 * body_h),
            (0.97 * r, 0.4 * body_h),
            (0.84 * r, 0.68 * body_h),
            (0.56 * r, 0.9 * body_h),
            (0.4 * r, 0.96 * body_h),
        ],
        3,
    ));
    profile.push(DVec2::new(0.0, 0.96 * body_h));
    let lathe_body = lathe(&profile, 40);
    add_by(&mut mesh, lathe_body, &[&body_finish, &chrome], |c, _| usize::from(c.z < 0.02 * body_h));
    let lid = points(&[
        (0.0, 0.94 * body_h),
        (0.44 * r, 0.94 * body_h),
        (0.45 * r, 0.965 * body_h),
        (0.42 * r, 0.985 * body_h),
        (0.2 * r, 1.03 * body_h),
        (0.0, 1.04 * body_h),
    ]);
    mesh.add(lathe(&lid, 32), &chrome);
    mesh.add(
        ellipsoid(DVec3::new(0.22 * r, 0.22 * r, 0.14 * r), 16).translated(DVec3::Z * 1.025 * body_h),
        &black,
    );
    let tip = r + (long - d);
    let spout = path(&[(0.62 * r, 0.5 * body_h), (0.95 * r, 0.66 * body_h), (tip - 0.01, 1.02 * body_h)], 5);
    let wide = 0.2 * r;
    mesh.add(sweep(&spout, &circle(wide, 18), DVec3::Y, |t| 1.2 - 0.65 * t), &body_finish);
    let last = spout.len() - 1;
    mesh.add(mouth(spout[last], spout[last] - spout[last - 1], 0.42 * wide), &black);
    let arch = path(
        &[
            (-0.7 * r, 0.8 * body_h),
            (-0.74 * r, 0.74 * h),
            (-0.5 * r, 0.93 * h),
            (0.0, 0.965 * h),
            (0.5 * r, 0.93 * h),
            (0.74 * r, 0.74 * h),
            (0.7 * r, 0.8 * body_h),
        ],
        5,
    );
    mesh.add(sweep(&arch, &ellipse(0.007, 0.014, 12), DVec3::Y, |_| 1.0), &chrome);
    let grip: Vec<DVec3> = arch[9..=21].to_vec();
    mesh.add(sweep(&grip, &ellipse(0.017, 0.024, 16), DVec3::Y, |t| 0.82 + 0.18 * (PI * t).sin()), &black);
    fitted(mesh, order.size_m)
}

pub(super) fn pitcher(order: &mut Order) -> TexturedMesh {
    let DVec3 { x: long, y: d, z: h } = order.size_m;
    let r = 0.5 * d;
    let lip = 0.22 * r;
    let style = order.pick(2);
    let outside = match style {
        0 => spline(
            &[
                (0.68 * r, 0.0),
                (0.72 * r, 0.02 * h),
                (r, 0.32 * h),
                (0.86 * r, 0.66 * h),
                (0.7 * r, 0.84 * h),
                (0.8 * r, 0.985 * h),
            ],
            4,
        ),
        _ => spline(
            &[(0.9 * r, 0.0), (0.94 * r, 0.02 * h), (r, 0.3 * h), (0.9 * r, 0.7 * h), (0.84 * r, 0.985 * h)],
            5,
        ),
    };
    let body = deformed(vessel(&outside, 0.0042, 0.007, 48), |p| {
        let off = (p.y.atan2(-p.x) / 0.42).powi(2);
        let high = ((p.z / h - 0.7) / 0.3).max(0.0).powi(2);
        let pull = (-off).exp() * high;
        DVec3::new(p.x - lip * pull, p.y, p.z + 0.03 * h * pull)
    });
    let color = order.color;
    let glassy = order.pick(3) == 0;
    let usual = if glassy {
        Material { opacity: 0.42, ..Material::plain("glass", Rgb::hex(0xd6_ea_ee), 0.05) }
    } else {
        let texture =
            striped_band(color, color.mix(Rgb::hex(0x2f_4f_7a), 0.75), 0.3, 0.42, 2, &mut order.rng);
        Material::textured("glaze", texture, 0.25)
    };
    let outer = finish(order, usual);
    let inner = if glassy || order.material.is_some() {
        outer.clone()
    } else {
        Material::plain("inner_glaze", color.mix(Rgb([0.96, 0.94, 0.9]), 0.6), 0.25)
    };
    let mut mesh = TexturedMesh::default();
    add_by(&mut mesh, wrapped_around(body), &[&outer, &inner], |c, n| {
        usize::from(n.dot(DVec3::new(c.x, c.y, 0.0)) < 0.0 || (n.z > 0.5 && c.z < 0.5 * h))
    });
    let grip_finish = if glassy || order.material.is_some() {
        outer.clone()
    } else {
        Material::plain("handle", color, 0.25)
    };
    let reach = (long - d - 0.4 * lip).max(0.02);
    let grip = loop_handle([0.8 * r; 2], reach + 0.2 * r - 0.004, 0.58 * h, 0.56 * h, 0.009, 0.015);
    mesh.add(grip, &grip_finish);
    fitted(mesh, order.size_m)
}
