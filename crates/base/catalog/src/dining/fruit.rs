//! Fruit and eggs, each with a small facet to rest on: apple, orange, pear, lemon, banana, tomato, egg.

use std::f64::consts::{PI, TAU};

use glam::{DQuat, DVec2, DVec3};

use super::assembly::{add_by, counter_clockwise, deformed, fitted, fitted_round, flattened, spline};
use crate::Order;
use crate::texture::{banana_skin, ceramic_speckle, citrus_peel, fruit_skin};
use geometry::shapes::{circle, lathe, loft, prism, smooth, sweep, tube};
use geometry::{Material, Rgb, Solid, TexturedMesh};

const STEM: Rgb = Rgb([0.36, 0.25, 0.13]);
const LEAF: Rgb = Rgb([0.27, 0.46, 0.18]);

/// A bent stem from `foot` upward, tapering.
fn stem(foot: DVec3, height: f64, radius: f64, lean: f64) -> Solid {
    let path: Vec<DVec3> = (0..=5)
        .map(|k| {
            let t = f64::from(k) / 5.0;
            foot + DVec3::new(lean * t * t, 0.3 * lean * t, height * t)
        })
        .collect();
    sweep(&path, &circle(radius, 8), DVec3::Y, |t| 0.8 + 0.5 * t * t)
}

/// A curved leaf of `length` from `foot`, pointing along `yaw_rad`.
fn leaf(foot: DVec3, length: f64, yaw_rad: f64) -> Solid {
    let half = smooth(
        &[(0.0, 0.0), (0.3, 0.2), (0.65, 0.22), (1.0, 0.0), (0.65, -0.22), (0.3, -0.2)]
            .map(|(x, y): (f64, f64)| DVec2::new(x, -y) * length),
        4,
    );
    let outline = counter_clockwise(half);
    let blade = deformed(prism(&outline, 0.0014), |p| {
        let t = p.x / length;
        DVec3::new(p.x, p.y, p.z + length * (0.5 * t - 0.55 * t * t) + 1.2 * p.y.abs() * 0.35)
    });
    blade.rotated(DQuat::from_rotation_z(yaw_rad)).translated(foot)
}

/// A pointed star of sepals lying on the top of a fruit, drooping toward its tips; the same from as many sides.
fn calyx(sepals: usize, radius: f64, droop: f64, top_z: f64) -> Solid {
    let thickness = 0.0016;
    let star = |share: f64, lift: f64| -> Vec<DVec3> {
        (0..sepals * 4)
            .map(|k| {
                let angle = TAU * k as f64 / (sepals * 4) as f64;
                let r = [1.0, 0.42, 0.26, 0.42][k % 4] * share;
                (r * radius * DVec2::from_angle(angle)).extend(top_z + lift - droop * r * r)
            })
            .collect()
    };
    loft(&[star(0.0, 0.0), star(1.0, 0.0), star(1.0, thickness), star(0.5, thickness), star(0.0, thickness)])
}

pub(super) fn apple(order: &mut Order) -> TexturedMesh {
    let r = 0.5 * order.size_m.x;
    let h = order.size_m.z * 0.88;
    let profile = spline(
        &[
            (0.0, 0.07 * h),
            (0.14 * r, 0.035 * h),
            (0.25 * r, 0.0),
            (0.38 * r, 0.0),
            (0.62 * r, 0.09 * h),
            (0.88 * r, 0.35 * h),
            (r, 0.63 * h),
            (0.9 * r, 0.86 * h),
            (0.62 * r, 0.985 * h),
            (0.36 * r, 0.98 * h),
            (0.12 * r, 0.88 * h),
            (0.0, 0.82 * h),
        ],
        3,
    );
    let lobes = order.uniform(0.0, TAU);
    let body = deformed(lathe(&profile, 40), |p| {
        let angle = p.y.atan2(p.x);
        let low = 1.0 - p.z / h;
        let lobe = 1.0 + 0.025 * low * (5.0 * angle + lobes).cos();
        DVec3::new(p.x * lobe, p.y * lobe, p.z)
    });
    let body = flattened(body, 0.008 * h);
    let color = order.color;
    let green = color.0[1] > color.0[0] * 0.95;
    let blush = if green { Rgb::hex(0xb9_c4_52) } else { Rgb::hex(0xd8_a8_3e) };
    let skin = Material::textured("skin", fruit_skin(color, blush, &mut order.rng), 0.3);
    let brown = Material::plain("stem", STEM, 0.8);
    let mut mesh = TexturedMesh::default();
    mesh.add(body, &skin);
    let lean = order.uniform(-0.15, 0.15) * r;
    mesh.add(stem(DVec3::new(0.0, 0.0, 0.8 * h), 0.36 * h, 0.0016, lean), &brown);
    if order.pick(2) == 0 {
        let yaw = order.uniform(0.0, TAU);
        let green = Material::plain("leaf", LEAF, 0.5);
        mesh.add(leaf(DVec3::new(0.2 * lean, 0.0, 0.99 * h), 0.75 * r, yaw), &green);
    }
    fitted(mesh, order.size_m)
}

pub(super) fn orange(order: &mut Order) -> TexturedMesh {
    let r = 0.5 * order.size_m.x;
    let h = order.size_m.z;
    let profile: Vec<DVec2> = (0..=20)
        .map(|k| {
            let angle = PI * f64::from(k) / 20.0;
            let dent = 0.035 * h * (-(angle / 0.22).powi(2)).exp()
                + 0.03 * h * (-((PI - angle) / 0.25).powi(2)).exp();
            let z = 0.5 * h * (1.0 - angle.cos());
            DVec2::new(r * angle.sin(), if angle < 1.0 { z + dent } else { z - dent })
        })
        .collect();
    let peel = Material::textured("peel", citrus_peel(order.color, &mut order.rng), 0.5);
    let green = Material::plain("button", Rgb::hex(0x6e_8a_3c), 0.7);
    let mut mesh = TexturedMesh::default();
    mesh.add(flattened(lathe(&profile, 40), 0.03 * h), &peel);
    mesh.add(calyx(5, 0.17 * r, 0.0, 0.962 * h), &green);
    mesh.add(stem(DVec3::Z * 0.95 * h, 0.04 * h, 0.0025, 0.0), &Material::plain("stem", STEM, 0.8));
    if order.pick(2) == 0 {
        let yaw = order.uniform(0.0, TAU);
        mesh.add(leaf(DVec3::Z * 0.968 * h, 0.8 * r, yaw), &Material::plain("leaf", LEAF, 0.45));
    }
    fitted(mesh, order.size_m)
}

pub(super) fn pear(order: &mut Order) -> TexturedMesh {
    let r = 0.5 * order.size_m.x;
    let h = order.size_m.z * 0.86;
    let profile = spline(
        &[
            (0.0, 0.05 * h),
            (0.12 * r, 0.02 * h),
            (0.26 * r, 0.0),
            (0.42 * r, 0.005 * h),
            (0.8 * r, 0.12 * h),
            (r, 0.32 * h),
            (0.86 * r, 0.53 * h),
            (0.56 * r, 0.72 * h),
            (0.47 * r, 0.86 * h),
            (0.36 * r, 0.97 * h),
            (0.12 * r, h),
            (0.0, 0.975 * h),
        ],
        3,
    );
    let lean = order.uniform(-0.12, 0.12) * r;
    let body = deformed(lathe(&profile, 36), |p| p + DVec3::X * lean * (p.z / h).powi(2));
    let skin = fruit_skin(order.color, Rgb::hex(0xb8_6a_34), &mut order.rng);
    let mut mesh = TexturedMesh::default();
    mesh.add(flattened(body, 0.008 * h), &Material::textured("skin", skin, 0.45));
    mesh.add(
        stem(DVec3::new(lean, 0.0, 0.955 * h), 0.2 * h, 0.0018, 0.16 * r),
        &Material::plain("stem", STEM, 0.8),
    );
    fitted(mesh, order.size_m)
}

pub(super) fn lemon(order: &mut Order) -> TexturedMesh {
    let DVec3 { x: l, y: d, .. } = order.size_m;
    let r = 0.5 * d;
    // Turned about z, then laid down along x: a nipple at one end, a stem scar at the other.
    let profile = spline(
        &[
            (0.0, 0.0),
            (0.2 * r, 0.012 * l),
            (0.3 * r, 0.06 * l),
            (0.66 * r, 0.16 * l),
            (0.97 * r, 0.38 * l),
            (0.99 * r, 0.56 * l),
            (0.74 * r, 0.79 * l),
            (0.36 * r, 0.91 * l),
            (0.2 * r, 0.97 * l),
            (0.0, l),
        ],
        3,
    );
    let body = lathe(&profile, 36).rotated(DQuat::from_rotation_y(0.5 * PI)).translated(DVec3::X * -0.5 * l);
    let peel = Material::textured("peel", citrus_peel(order.color, &mut order.rng), 0.45);
    let scar = Material::plain("scar", Rgb::hex(0x8a_8a_3a), 0.8);
    let mut mesh = TexturedMesh::default();
    add_by(&mut mesh, flattened(body, -0.95 * r), &[&peel, &scar], |center, _| {
        usize::from(center.x < -0.488 * l)
    });
    fitted(mesh, order.size_m)
}

pub(super) fn banana(order: &mut Order) -> TexturedMesh {
    let DVec3 { x: l, y: bow, z: thick } = order.size_m;
    let r = 0.5 * thick;
    // Lying on its side: a bow in the table's plane, ends toward -y.
    let half = 0.5 * l - 0.2 * r;
    let sag = bow - 1.6 * r;
    let n = 30;
    let path: Vec<DVec3> = (0..=n)
        .map(|k| {
            let t = 2.0 * f64::from(k) / f64::from(n) - 1.0;
            DVec3::new(half * (1.1 * t).sin() / 1.1_f64.sin(), -sag * t * t, 0.0)
        })
        .collect();
    let girth = |t: f64| {
        let neck = 0.24 + 0.76 * ((t - 0.06) / 0.16).clamp(0.0, 1.0).powf(0.8);
        let tip = 0.3 + 0.7 * ((1.0 - t) / 0.14).clamp(0.0, 1.0).powf(0.6);
        let end = if t > 0.985 { 0.65 } else { 1.0 };
        neck.min(tip) * end * (0.9 + 0.1 * (PI * t).sin())
    };
    let section: Vec<DVec2> = (0..20)
        .map(|k| {
            let angle = TAU * f64::from(k) / 20.0;
            r * (1.0 + 0.05 * (5.0 * angle).cos()) * DVec2::from_angle(angle)
        })
        .collect();
    let body = sweep(&path, &section, DVec3::Z, girth);
    let skin = Material::textured("peel", banana_skin(order.color, &mut order.rng), 0.5);
    let brown = Material::plain("stem", Rgb::hex(0x5f_4a_22), 0.8);
    let mut mesh = TexturedMesh::default();
    let first = path[2].x;
    let last = path[n as usize].x - 0.005 * l;
    add_by(&mut mesh, flattened(body, -0.88 * r), &[&skin, &brown], |center, _| {
        usize::from(center.x < first || center.x > last)
    });
    fitted(mesh, order.size_m)
}

pub(super) fn tomato(order: &mut Order) -> TexturedMesh {
    let r = 0.5 * order.size_m.x;
    let h = order.size_m.z * 0.9;
    let profile = spline(
        &[
            (0.0, 0.02 * h),
            (0.24 * r, 0.0),
            (0.4 * r, 0.01 * h),
            (0.75 * r, 0.12 * h),
            (r, 0.48 * h),
            (0.86 * r, 0.83 * h),
            (0.52 * r, 0.99 * h),
            (0.24 * r, 0.975 * h),
            (0.0, 0.92 * h),
        ],
        3,
    );
    let body = deformed(lathe(&profile, 42), |p| {
        let high = (p.z / h).powi(2);
        let lobe = 1.0 + 0.035 * high * (6.0 * p.y.atan2(p.x)).cos();
        DVec3::new(p.x * lobe, p.y * lobe, p.z)
    });
    let skin = fruit_skin(order.color, order.color.mix(Rgb::hex(0xd8_6a_2a), 0.5), &mut order.rng);
    let green = Material::plain("calyx", LEAF.scaled(1.1), 0.6);
    let mut mesh = TexturedMesh::default();
    mesh.add(flattened(body, 0.01 * h), &Material::textured("skin", skin, 0.18));
    mesh.add(calyx(6, 0.7 * r, 0.02 * h, 0.99 * h), &green);
    mesh.add(stem(DVec3::Z * 0.92 * h, 0.21 * h, 0.002, 0.0), &green);
    fitted_round(mesh, order.size_m)
}

pub(super) fn egg(order: &mut Order) -> TexturedMesh {
    let DVec3 { x: d, y: l, .. } = order.size_m;
    let r = 0.5 * d;
    let rings: Vec<Vec<DVec3>> = (0..=24)
        .map(|k| {
            let angle = PI * f64::from(k) / 24.0;
            let y = -0.5 * l * angle.cos();
            // Blunter toward -y.
            let radius = r * angle.sin() * (1.0 + 0.16 * angle.cos()) / 1.01;
            circle(radius.max(0.0), 36).iter().map(|p| DVec3::new(-p.x, y, p.y)).collect()
        })
        .map(|ring: Vec<DVec3>| if ring[0].x.abs() < 1e-9 { vec![DVec3::Y * ring[0].y; 36] } else { ring })
        .collect();
    let shell = Material::textured("shell", ceramic_speckle(order.color, &mut order.rng), 0.55);
    let plain = Material::plain("shell", order.color, 0.55);
    let mut mesh = TexturedMesh::default();
    let body = flattened(loft(&rings), -0.955 * r);
    mesh.add(body, if order.pick(3) == 0 { &shell } else { &plain });
    fitted(mesh, order.size_m)
}

pub(super) fn carrot(order: &mut Order) -> TexturedMesh {
    let DVec3 { x: w, y: l, .. } = order.size_m;
    let r = 0.5 * w.min(order.size_m.z);
    // Tip toward -y, leaves toward +y.
    let root = 0.82 * l;
    let wobble = order.uniform(0.0, TAU);
    let girth: Vec<f64> = spline(
        &[(0.0, 0.0), (0.03, 0.1), (0.3, 0.45), (0.7, 0.8), (0.93, 1.0), (0.985, 0.86), (1.0, 0.45)],
        5,
    )
    .iter()
    .map(|p| p.y.max(0.0))
    .collect();
    let n = girth.len() - 1;
    let rings: Vec<Vec<DVec3>> = girth
        .iter()
        .enumerate()
        .map(|(k, g)| {
            let t = k as f64 / n as f64;
            let ridge = 1.0 + 0.03 * (38.0 * t + wobble).sin();
            let radius = r * g * ridge;
            let bend = 0.15 * r * (3.0 * t + wobble).sin();
            (0..24)
                .map(|j| {
                    let p = radius * DVec2::from_angle(TAU * f64::from(j) / 24.0);
                    DVec3::new(bend - p.x, -0.5 * l + root * t, p.y - r + 0.5 * (r + r * g))
                })
                .collect()
        })
        .collect();
    let body = loft(&rings);
    let low = body.positions.iter().map(|p| p.z).fold(f64::INFINITY, f64::min);
    let skin = carrot_skin(order.color, &mut order.rng);
    let mut mesh = TexturedMesh::default();
    mesh.add(flattened(body, low + 0.2 * r), &Material::textured("skin", skin, 0.55));
    let green = Material::plain("leaves", LEAF.scaled(1.15), 0.7);
    let crown = DVec3::new(0.15 * r * (3.0 + wobble).sin(), -0.5 * l + root - 0.004, -0.05 * r);
    for k in 0..7 {
        let side = f64::from(k - 3) / 3.0;
        let high = order.uniform(-0.2, 0.6);
        let reach = order.uniform(0.75, 1.0) * (l - root);
        let path: Vec<DVec3> = (0..=6)
            .map(|j| {
                let t = f64::from(j) / 6.0;
                crown + DVec3::new(0.9 * r * side * t, 0.004 + reach * t, r * high * (t - 0.6 * t * t))
            })
            .collect();
        mesh.add(sweep(&path, &circle(0.0028, 8), DVec3::Z, |t| 0.7 + 0.9 * (PI * t).sin() * t), &green);
    }
    fitted(mesh, order.size_m)
}

/// Orange with short darker rings across (v runs along the root).
fn carrot_skin(color: Rgb, rng: &mut runtime::seed::Rng) -> imaging::Texture {
    let marks = crate::texture::Noise::new(9, 48, rng);
    crate::texture::draw_texture(64, 256, |u, v| {
        let mark = (marks.at(u, v) - 0.72).max(0.0) * 1.6;
        color.scaled(1.0 - mark).mix(Rgb::hex(0x7d_8a_2e), ((v - 0.95) * 14.0).clamp(0.0, 0.7))
    })
}

pub(super) fn cucumber(order: &mut Order) -> TexturedMesh {
    let DVec3 { x: l, y: w, z: thick } = order.size_m;
    let r = 0.5 * thick;
    let sag = w - 2.0 * r;
    let n = 26;
    let path: Vec<DVec3> = (0..=n)
        .map(|k| {
            let t = 2.0 * f64::from(k) / f64::from(n) - 1.0;
            DVec3::new(0.5 * l * (0.5 * PI * t).sin(), -sag * t * t * t * t * 0.3 - sag * 0.7 * t * t, 0.0)
        })
        .collect();
    let girth = |t: f64| {
        let x = (PI * (t - 0.5)).sin().abs();
        (1.0 - x.powi(9)).max(0.0).powf(0.5).max(0.12)
    };
    let section: Vec<DVec2> = (0..24)
        .map(|k| {
            let angle = TAU * f64::from(k) / 24.0;
            r * (1.0 + 0.025 * (8.0 * angle).cos()) * DVec2::from_angle(angle)
        })
        .collect();
    let color = order.color;
    let (stripe, bumps) = {
        let rng = &mut order.rng;
        (crate::texture::Noise::new(18, 3, rng), crate::texture::Noise::new(24, 60, rng))
    };
    let skin = crate::texture::draw_texture(128, 256, |u, v| {
        let pale = (stripe.at(u, v) - 0.5).max(0.0) * 1.1 + ((v - 0.5).abs() * 2.0 - 0.85).max(0.0);
        let bump = if bumps.at(u, v) > 0.9 { 0.35 } else { 0.0 };
        color.mix(Rgb::hex(0xa9_b8_5e), (pale + bump).min(0.8))
    });
    let mut mesh = TexturedMesh::default();
    let body = sweep(&path, &section, DVec3::Z, girth);
    mesh.add(flattened(body, -0.93 * r), &Material::textured("skin", skin, 0.4));
    let end = path[0];
    let nub = tube(&[end + DVec3::X * 0.004, end - DVec3::X * 0.006], 0.0035, 10);
    mesh.add(nub, &Material::plain("stem", Rgb::hex(0x8a_92_4a), 0.8));
    fitted(mesh, order.size_m)
}
