//! Cutting tools: hand saw, utility knife, chisel, hand plane. Model millimeters.

use glam::DVec3;

use crate::Order;
use crate::assembly::{
    Assembly, across_x, along_y, bar, black, grain_along_y, main_finish, pierced, pitched, plastic, points,
    resting, steel, wood,
};
use geometry::shapes::{cylinder, lathe, prism, rectangle, rounded_block, slab, smooth};
use geometry::{Material, Rgb, TexturedMesh};

/// Hand saw lying flat: toothed blade, closed wooden grip at -y.
pub(super) fn hand_saw(order: &mut Order) -> TexturedMesh {
    let mut object = Assembly::new();
    let blade_finish = Material::metal("blade", Rgb::hex(0xb8bcc0), 0.25);
    let mut blade = vec![(-46.0, -70.0), (40.0, -70.0)];
    let (from, to, count) = (-30.0, 286.0, 46);
    for k in 0..count {
        let y = from + (to - from) * f64::from(k) / f64::from(count);
        let x = 46.0 - 8.0 * (y - from) / (to - from);
        blade.extend([(x - 4.5, y), (x + 0.5, y + 1.2)]);
    }
    blade.extend([(34.0, 290.0), (-6.0, 290.0), (-14.0, 284.0)]);
    object.put(prism(&points(&blade), 1.8), [0.0; 3], &blade_finish);
    let handle_finish = match (order.material, order.pick(2)) {
        (Some(_), _) => main_finish(order, "beech"),
        (None, 0) => wood(order, 0xb07a44),
        _ => plastic(order.color),
    };
    let outline = smooth(
        &points(&[
            (-54.0, -30.0),
            (-57.0, -62.0),
            (-50.0, -96.0),
            (-52.0, -132.0),
            (-34.0, -142.0),
            (0.0, -139.0),
            (34.0, -146.0),
            (50.0, -134.0),
            (46.0, -100.0),
            (54.0, -62.0),
            (50.0, -34.0),
            (22.0, -20.0),
            (0.0, -34.0),
            (-24.0, -22.0),
        ]),
        3,
    );
    let hole = |angle: f64| {
        let (sin, cos) = angle.sin_cos();
        1.0 / ((cos / 33.0).powi(4) + (sin / 19.0).powi(4)).powf(0.25)
    };
    let handle = pierced(&outline, (0.0, -98.0), hole, 22.0, 4.0, 48);
    object.put(grain_along_y(handle.with_box_uvs(160.0)), [0.0; 3], &handle_finish);
    let brass = Material::metal("brass", Rgb::hex(0xc9a24c), 0.3);
    for (x, y) in [(-34.0, -50.0), (0.0, -56.0), (34.0, -50.0)] {
        object.put(cylinder(6.5, 3.0, 0.6, 24), [x, y, 20.0], &brass);
    }
    object.fitted(order.size_m)
}

/// Utility knife lying flat, blade out at +y.
pub(super) fn utility_knife(order: &mut Order) -> TexturedMesh {
    let mut object = Assembly::new();
    let shell = main_finish(order, "plastic");
    let metal = steel(order);
    let gray = Material::metal("nose", Rgb::hex(0x8a8d92), 0.4);
    let outline = smooth(
        &points(&[
            (-13.0, -74.0),
            (2.0, -80.0),
            (16.0, -72.0),
            (18.0, -40.0),
            (14.0, 0.0),
            (15.0, 34.0),
            (11.0, 66.0),
            (-9.0, 70.0),
            (-15.0, 40.0),
            (-13.0, 0.0),
            (-17.0, -40.0),
        ]),
        4,
    );
    object.put(slab(&outline, 17.0, 3.5), [0.0; 3], &shell);
    let pad = smooth(
        &points(&[(-8.0, -66.0), (10.0, -66.0), (12.0, -40.0), (9.0, -8.0), (-9.0, -8.0), (-12.0, -40.0)]),
        4,
    );
    object.put(slab(&pad, 3.0, 0.9), [0.0, 0.0, 15.2], &black());
    for k in 0..5 {
        object.put(
            rounded_block(DVec3::new(15.0, 3.0, 2.0), 0.8, 0.4),
            [0.0, -56.0 + 9.0 * f64::from(k), 17.4],
            &black(),
        );
    }
    object.put(rounded_block(DVec3::new(8.0, 46.0, 2.4), 2.0, 0.4), [0.0, 24.0, 15.4], &black());
    object.put(rounded_block(DVec3::new(9.0, 17.0, 6.0), 3.0, 1.4), [0.0, 18.0, 16.5], &gray);
    object.put(cylinder(4.4, 2.4, 0.5, 20), [0.0, 56.0, 15.8], &gray);
    let nose = points(&[(-11.0, 60.0), (11.5, 60.0), (9.5, 79.0), (-7.5, 82.0)]);
    object.put(slab(&nose, 9.0, 1.2), [0.0, 0.0, 4.0], &gray);
    let blade = points(&[(-7.0, 74.0), (9.0, 74.0), (9.0, 86.0), (-7.0, 108.0)]);
    object.put(prism(&blade, 1.6), [0.0, 0.0, 7.6], &metal);
    object.fitted(order.size_m)
}

/// Wood chisel lying on its flattened handle, edge at +y.
pub(super) fn chisel(order: &mut Order) -> TexturedMesh {
    let mut object = Assembly::new();
    let handle_finish = match (order.material, order.pick(2)) {
        (Some(_), _) => main_finish(order, "beech"),
        (None, 0) => wood(order, 0xc89652),
        _ => plastic(order.color),
    };
    let floor = -12.6;
    let handle = points(&[
        (0.0, 0.0),
        (11.0, 0.0),
        (13.0, 3.0),
        (14.8, 16.0),
        (14.6, 36.0),
        (13.4, 62.0),
        (14.4, 92.0),
        (12.0, 108.0),
        (9.6, 116.0),
        (0.0, 116.0),
    ]);
    object.put(resting(along_y(lathe(&handle, 36)), floor), [0.0, -118.0, 0.0], &handle_finish);
    let hoop = Material::metal("hoop", Rgb::hex(0xb8babe), 0.3);
    object.put(resting(along_y(cylinder(14.0, 8.0, 1.0, 32)), floor), [0.0, -117.0, 0.0], &hoop);
    let brass = Material::metal("ferrule", Rgb::hex(0xc9a24c), 0.28);
    object.put(
        along_y(lathe(&points(&[(0.0, 0.0), (11.2, 0.0), (10.0, 14.0), (0.0, 14.0)]), 32)),
        [0.0, -8.0, 0.0],
        &brass,
    );
    let blade = Material::metal("blade", Rgb::hex(0xc4c6ca), 0.22);
    let width = [13.0, 20.0, 25.0][order.pick(3)];
    let shape = [
        (4.0, 0.0, 0.0, 9.0, 9.0),
        (18.0, 0.0, 0.0, 8.0, 8.0),
        (30.0, 0.0, 0.0, width, 6.0),
        (112.0, 0.0, -0.4, width, 4.6),
        (128.0, 0.0, -2.1, width, 1.2),
    ];
    object.put(bar(&shape, 9.0, 28), [0.0; 3], &blade);
    object.fitted(order.size_m)
}

/// Bench plane on its sole: cheeks, bedded iron, lever cap, wooden knob in front (+y) and tote.
pub(super) fn hand_plane(order: &mut Order) -> TexturedMesh {
    let mut object = Assembly::new();
    let body = Material::plain("japanning", order.color, 0.45);
    let bright = steel(order);
    let timber = match order.material {
        Some(_) => main_finish(order, "walnut"),
        None => wood(order, 0x7a3f24),
    };
    let sole = smooth(
        &points(&[
            (-26.0, -118.0),
            (0.0, -122.0),
            (26.0, -118.0),
            (31.0, 0.0),
            (26.0, 118.0),
            (0.0, 122.0),
            (-26.0, 118.0),
            (-31.0, 0.0),
        ]),
        4,
    );
    object.put(slab(&sole, 6.0, 0.8), [0.0; 3], &bright);
    let floor = smooth(
        &points(&[
            (-24.0, -113.0),
            (0.0, -117.0),
            (24.0, -113.0),
            (27.0, 0.0),
            (24.0, 113.0),
            (0.0, 117.0),
            (-24.0, 113.0),
            (-27.0, 0.0),
        ]),
        4,
    );
    object.put(slab(&floor, 5.0, 0.6), [0.0, 0.0, 3.0], &body);
    let cheek = points(&[
        (-84.0, 1.0),
        (92.0, 1.0),
        (90.0, 10.0),
        (64.0, 14.0),
        (38.0, 36.0),
        (16.0, 46.0),
        (-10.0, 46.0),
        (-34.0, 36.0),
        (-58.0, 14.0),
        (-84.0, 9.0),
    ]);
    for x in [-27.5, 27.5] {
        object.put(across_x(&cheek, 5.0, 1.0), [x, 0.0, 0.0], &bright);
    }
    let frog = points(&[(-40.0, 4.0), (22.0, 4.0), (20.0, 8.0), (-22.0, 50.0), (-30.0, 48.0)]);
    object.put(across_x(&frog, 40.0, 1.0), [0.0; 3], &body);
    let iron = rounded_block(DVec3::new(48.0, 4.0, 128.0), 1.5, 0.8);
    object.put(pitched(iron, 45.0), [0.0, 26.0, 4.0], &bright);
    let cap = prism(
        &points(&[(-22.0, 0.0), (22.0, 0.0), (22.0, 40.0), (15.0, 86.0), (-15.0, 86.0), (-22.0, 40.0)]),
        8.0,
    );
    let chrome = Material::metal("lever_cap", Rgb::hex(0xd6d8dc), 0.2);
    object.put(pitched(cap, 135.0), [0.0, 28.0, 12.0], &chrome);
    let brass = Material::metal("brass", Rgb::hex(0xc9a24c), 0.28);
    object.put(along_y(cylinder(11.0, 7.0, 1.2, 28)), [0.0, -46.0, 40.0], &brass);
    let knob = points(&[
        (0.0, 0.0),
        (15.0, 0.0),
        (14.0, 6.0),
        (9.0, 16.0),
        (11.0, 28.0),
        (17.0, 38.0),
        (17.5, 46.0),
        (12.0, 53.0),
        (0.0, 55.0),
    ]);
    object.put(lathe(&knob, 32), [0.0, 84.0, 6.0], &timber);
    object.put(cylinder(4.0, 2.4, 0.5, 20), [0.0, 84.0, 59.6], &brass);
    let tote = smooth(
        &points(&[
            (-112.0, 6.0),
            (-52.0, 6.0),
            (-68.0, 24.0),
            (-66.0, 48.0),
            (-52.0, 72.0),
            (-48.0, 88.0),
            (-64.0, 94.0),
            (-84.0, 84.0),
            (-94.0, 56.0),
            (-96.0, 30.0),
        ]),
        3,
    );
    object.put(across_x(&tote, 22.0, 5.0).with_box_uvs(150.0), [0.0; 3], &timber);
    object.put(prism(&rectangle(30.0, 3.0), 1.5), [0.0, 30.0, 7.0], &black());
    object.fitted(order.size_m)
}
