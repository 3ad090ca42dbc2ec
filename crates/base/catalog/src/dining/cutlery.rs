//! Cutlery lying on the table, handle toward -y: fork, knife, spoon, chopsticks on their rest.

use glam::{DVec2, DVec3};

use super::assembly::{
    counter_clockwise, deformed, finish, fitted, flattened, points, ribbon, spline, vessel,
};
use crate::Order;
use crate::texture::{brushed_metal, wood_grain};
use geometry::shapes::{inset, loft, prism, rounded_rectangle, slab, smooth, sphere};
use geometry::{Material, Rgb, Solid, TexturedMesh};

/// Polished steel in the order's color.
fn silver(order: &mut Order) -> Material {
    let texture = brushed_metal(order.color, &mut order.rng);
    let usual = Material { metalness: 1.0, ..Material::textured("polished_steel", texture, 0.22) };
    finish(order, usual)
}

/// The handle both fork and spoon have: wide end on the table, arched neck; from `back` to `neck` (y),
/// there at height `neck_z`.
fn handle(back: f64, neck: f64, neck_z: f64, end_width: f64) -> Solid {
    let at = |t: f64| back + (neck - back) * t;
    ribbon(
        &[
            [back, 0.0, 0.55 * end_width, 0.0022],
            [at(0.04), 0.0, 0.92 * end_width, 0.0026],
            [at(0.14), 0.0008, end_width, 0.0028],
            [at(0.4), 0.35 * neck_z, 0.7 * end_width, 0.0028],
            [at(0.72), 0.95 * neck_z, 0.36 * end_width, 0.0034],
            [at(0.9), 1.1 * neck_z, 0.36 * end_width, 0.0034],
            [at(1.0), neck_z, 0.5 * end_width, 0.003],
        ],
        5,
    )
}

pub(super) fn fork(order: &mut Order) -> TexturedMesh {
    let DVec3 { x: w, y: l, z: h } = order.size_m;
    let metal = silver(order);
    let mut mesh = TexturedMesh::default();
    let (back, front) = (-0.5 * l, 0.5 * l);
    let root = front - 0.27 * l;
    let lift = 0.55 * h;
    mesh.add(flattened(handle(back, root + 0.004, lift, 0.62 * w), 0.0003), &metal);
    let palm = ribbon(
        &[
            [root, lift, 0.32 * w, 0.003],
            [root + 0.025 * l, 0.72 * lift, 0.62 * w, 0.0026],
            [root + 0.06 * l, 0.35 * lift, 0.97 * w, 0.0024],
            [root + 0.1 * l, 0.08 * lift, w, 0.0024],
            [root + 0.13 * l, 0.0, w, 0.0024],
        ],
        5,
    );
    mesh.add(flattened(palm, 0.0003), &metal);
    let tines = if order.pick(4) == 0 { 3 } else { 4 };
    let gap = w / (f64::from(tines) * 1.65 - 0.65);
    for k in 0..tines {
        let x = -0.5 * w + 0.5 * gap + 1.65 * gap * f64::from(k);
        let from = root + 0.115 * l;
        let tine = ribbon(
            &[
                [from, 0.0002, gap, 0.0022],
                [from + 0.05 * l, 0.0, gap, 0.0022],
                [from + 0.1 * l, 0.25 * h, 0.85 * gap, 0.002],
                [front - 0.008, 0.5 * h, 0.7 * gap, 0.0018],
                [front, 0.56 * h, 0.35 * gap, 0.0013],
            ],
            4,
        );
        mesh.add(flattened(tine, 0.0003).translated(DVec3::X * x), &metal);
    }
    fitted(mesh, order.size_m)
}

pub(super) fn spoon(order: &mut Order) -> TexturedMesh {
    let DVec3 { x: w, y: l, z: h } = order.size_m;
    let metal = silver(order);
    let mut mesh = TexturedMesh::default();
    let (long, deep) = (1.5 * w, 0.5 * h);
    let r = 0.5 * w;
    let outside = spline(
        &[(0.3 * r, 0.0), (0.55 * r, 0.1 * deep), (0.8 * r, 0.4 * deep), (0.93 * r, 0.7 * deep), (r, deep)],
        3,
    );
    let dish = vessel(&outside, 0.0014, 0.0014, 40);
    let stretch = long / w;
    let center = 0.5 * l - 0.5 * long;
    let dish = deformed(dish, |p| {
        let y = p.y * stretch;
        let egg = 1.0 - 0.16 * y / (0.5 * long);
        DVec3::new(p.x * egg, center + y, p.z)
    });
    mesh.add(dish, &metal);
    let rim = center - 0.5 * long;
    mesh.add(
        flattened(handle(-0.5 * l, rim + 0.004, deep - 0.0013, 0.46 * w), 0.0003)
            .translated(DVec3::Z * -0.0003),
        &metal,
    );
    let joint = ribbon(
        &[
            [rim - 0.006, deep - 0.0014, 0.2 * w, 0.0028],
            [rim + 0.004, 0.75 * deep, 0.22 * w, 0.0028],
            [rim + 0.014, 0.42 * deep, 0.12 * w, 0.0024],
        ],
        4,
    );
    mesh.add(joint, &metal);
    fitted(mesh, order.size_m)
}

pub(super) fn knife(order: &mut Order) -> TexturedMesh {
    let DVec3 { x: w, y: l, z: h } = order.size_m;
    let steel = silver(order);
    let mut mesh = TexturedMesh::default();
    let split = -0.5 * l + 0.44 * l;
    // Straight back on the left, belly and tip on the right.
    let tip = if order.pick(2) == 0 { 0.0 } else { -0.42 * w };
    let blade = smooth(
        &points(&[
            (-0.4 * w, split - 0.012),
            (0.05 * w, split - 0.012),
            (0.15 * w, split + 0.004),
            (0.48 * w, split + 0.03),
            (0.5 * w, 0.24 * l),
            (0.44 * w, 0.4 * l),
            (0.2 * w + 0.4 * tip, 0.475 * l),
            (-0.1 * w + 0.6 * tip, 0.5 * l),
            (-0.4 * w, 0.45 * l),
            (-0.48 * w, 0.3 * l),
            (-0.48 * w, 0.0),
        ]),
        5,
    );
    // The edge is ground thinner along the belly.
    let rings: Vec<Vec<DVec3>> = [(0.0, 0.0), (0.0, 0.0012), (0.003, 0.0022)]
        .iter()
        .map(|&(by, z)| {
            let ring = inset(&blade, by);
            ring.iter()
                .zip(&blade)
                .map(|(p, edge)| if edge.x > 0.1 * w { *p } else { *edge })
                .map(|p: DVec2| p.extend(z))
                .collect()
        })
        .collect();
    mesh.add(loft(&rings), &steel);
    let wooden = order.pick(2) == 0;
    let grip_material = if wooden {
        let grain = wood_grain(Rgb::hex(0x5a_3a_26), &mut order.rng);
        Material::textured("grip", grain, 0.5)
    } else {
        steel.clone()
    };
    let half = 0.36 * w;
    let grip = smooth(
        &points(&[
            (-half - 0.1 * w, split),
            (0.12 * w, split),
            (0.1 * w, split - 0.1 * l),
            (0.2 * w, split - 0.3 * l),
            (0.18 * w, -0.49 * l),
            (-0.1 * w, -0.5 * l),
            (-half - 0.06 * w, -0.48 * l),
            (-half - 0.05 * w, split - 0.25 * l),
        ]),
        4,
    );
    let grip = counter_clockwise(grip);
    let grip = if wooden { slab(&grip, h, 0.0025).with_box_uvs(0.08) } else { slab(&grip, h, 0.0028) };
    mesh.add(grip, &grip_material);
    if wooden {
        let brass = Material::metal("rivets", Rgb::hex(0xc8_a8_60), 0.3);
        for t in [0.14, 0.24, 0.34] {
            let rivet = prism(&rounded_rectangle(0.0056, 0.0056, 0.0027, 4), h + 0.0012);
            mesh.add(rivet.translated(DVec3::new(-0.14 * w, -0.5 * l + t * l, 0.0)), &brass);
        }
    } else {
        let bolster = slab(&rounded_rectangle(0.62 * w, 0.006, 0.002, 3), 0.8 * h, 0.001);
        mesh.add(bolster.translated(DVec3::new(-0.15 * w, split - 0.002, 0.0)), &steel);
    }
    fitted(mesh, order.size_m)
}

pub(super) fn chopsticks(order: &mut Order) -> TexturedMesh {
    let DVec3 { x: w, y: l, z: h } = order.size_m;
    let usual = Material::textured("lacquer", wood_grain(order.color, &mut order.rng), 0.35);
    let wood = finish(order, usual);
    let band = Material::plain("band", Rgb::hex(0xc9_a2_4c), 0.3);
    let mut mesh = TexturedMesh::default();
    let rest_y = 0.3 * l;
    let rest_h = 0.62 * h;
    let (thick, thin) = (0.0082, 0.0046);
    for side in [-1.0, 1.0] {
        let along = |t: f64, size: f64, grow: f64| -> Vec<DVec3> {
            let y = -0.5 * l + l * t;
            // Thick end on the table, passing over the rest.
            let z = (rest_h - 0.0006) * t / 0.8;
            let x = side * (0.2 * w - 0.08 * w * t);
            rounded_rectangle(size + grow, size + grow, 0.3 * size, 3)
                .into_iter()
                .map(|p| DVec3::new(x - p.x, y, (z + 0.5 * size + p.y).max(0.0)))
                .collect()
        };
        let size = |t: f64| thick + (thin - thick) * t;
        let rings: Vec<Vec<DVec3>> =
            [0.0, 0.004, 0.05, 0.1, 0.3, 0.6, 0.9, 1.0].iter().map(|&t| along(t, size(t), 0.0)).collect();
        mesh.add(loft(&rings), &wood);
        for t in [0.045, 0.075] {
            mesh.add(loft(&[along(t, size(t), 0.0009), along(t + 0.016, size(t), 0.0009)]), &band);
        }
    }
    let ceramic = Material::plain("rest", Rgb::hex(0x3f_5f_86).mix(order.color, 0.15), 0.2);
    let saddle = slab(&rounded_rectangle(w, 0.016, 0.006, 4), rest_h, 0.003);
    let saddle = deformed(saddle, |p| {
        let up = 1.0 + 0.45 * (2.0 * p.x / w).powi(2);
        DVec3::new(p.x, p.y, p.z * up)
    });
    mesh.add(saddle.translated(DVec3::Y * rest_y), &ceramic);
    for side in [-1.0, 1.0] {
        let dot = sphere(0.004, 12);
        mesh.add(
            dot.translated(DVec3::new(side * 0.4 * w, rest_y, rest_h * 1.2 - 0.004)),
            &Material::plain("rest_dot", Rgb([0.95, 0.94, 0.9]), 0.2),
        );
    }
    fitted(mesh, order.size_m)
}
