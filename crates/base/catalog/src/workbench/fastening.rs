//! Tools and hardware for driving and joining: hammer, screwdriver, bolt, nut, power drill. Model millimeters.

use glam::DVec3;

use crate::Order;
use crate::assembly::{
    Assembly, across_x, along_x, along_y, bar, black, column, grain_along_y, lobed, main_finish, pierced,
    plastic, points, resting, side_plate, steel, turned_ring, wood, yawed,
};
use crate::texture::label;
use geometry::shapes::{cylinder, lathe, prism, regular_polygon, rounded_block, slab};
use geometry::{Material, Rgb, TexturedMesh};

/// Claw hammer on its side, head at +y.
pub(super) fn hammer(order: &mut Order) -> TexturedMesh {
    let mut object = Assembly::new();
    let head = Material { roughness: 0.35, ..Material::metal("head", Rgb::hex(0x8c9094), 0.35) };
    if order.pick(2) == 0 || order.material.is_some() {
        let handle = match order.material {
            Some(_) => main_finish(order, "oak"),
            None => wood(order, 0xc49458),
        };
        let shaft = [
            (-165.0, 0.0, 15.0, 24.0, 20.0),
            (-162.0, 0.0, 15.0, 32.0, 28.0),
            (-130.0, 0.0, 15.0, 34.0, 30.0),
            (-70.0, 0.0, 15.0, 32.0, 29.0),
            (-20.0, 0.0, 15.0, 25.0, 22.0),
            (40.0, 0.0, 15.0, 22.0, 20.0),
            (143.0, 0.0, 15.0, 23.0, 18.0),
        ];
        object.put(grain_along_y(resting(bar(&shaft, 2.6, 28), 0.8)), [0.0; 3], &handle);
    } else {
        let grip = plastic(order.color);
        let mut ribs = vec![(-165.0, 0.0, 15.0, 28.0, 24.0), (-160.0, 0.0, 15.0, 36.0, 30.0)];
        for k in 0..8 {
            let y = -148.0 + 14.0 * f64::from(k);
            ribs.push((y, 0.0, 15.0, 32.0, 28.0));
            ribs.push((y + 7.0, 0.0, 15.0, 34.0, 30.0));
        }
        ribs.push((-34.0, 0.0, 15.0, 26.0, 24.0));
        object.put(resting(bar(&ribs, 3.0, 28), 0.8), [0.0; 3], &grip);
        let shaft = [(-40.0, 0.0, 15.0, 20.0, 18.0), (143.0, 0.0, 15.0, 20.0, 16.0)];
        object.put(bar(&shaft, 4.0, 24), [0.0; 3], &Material::metal("shaft", Rgb::hex(0xc4c6c8), 0.3));
    }
    object.put(rounded_block(DVec3::new(38.0, 34.0, 28.4), 5.0, 2.0), [0.0, 122.0, 0.8], &head);
    let poll = lathe(
        &points(&[
            (0.0, 0.0),
            (12.5, 0.0),
            (11.0, 12.0),
            (14.8, 19.0),
            (14.8, 32.0),
            (13.4, 34.0),
            (0.0, 34.0),
        ]),
        36,
    );
    object.put(resting(along_x(poll), -14.2), [16.0, 122.0, 15.0], &head);
    let claw = points(&[
        (-82.0, 99.0),
        (-62.0, 113.0),
        (-40.0, 117.0),
        (-12.0, 107.0),
        (-12.0, 138.0),
        (-38.0, 139.0),
        (-62.0, 128.0),
        (-84.0, 101.0),
    ]);
    let root = points(&[(-46.0, 118.0), (-12.0, 109.0), (-12.0, 136.5), (-46.0, 134.0)]);
    object.put(slab(&claw, 11.0, 1.2), [0.0, 0.0, 0.8], &head);
    object.put(slab(&claw, 11.0, 1.2), [0.0, 0.0, 18.2], &head);
    object.put(prism(&root, 24.0), [0.0, 0.0, 3.0], &head);
    object.fitted(order.size_m)
}

/// Screwdriver lying on its flattened handle, tip at +y: slotted or cross-head.
pub(super) fn screwdriver(order: &mut Order) -> TexturedMesh {
    let mut object = Assembly::new();
    let grip = main_finish(order, "plastic");
    let metal = Material::metal("shaft", Rgb::hex(0xc8cacc), 0.25);
    let handle = [
        (0.0, 0.0),
        (8.0, 0.0),
        (13.0, 3.0),
        (14.6, 12.0),
        (14.6, 34.0),
        (13.2, 52.0),
        (14.8, 74.0),
        (13.6, 88.0),
        (9.0, 95.0),
        (9.5, 103.0),
        (7.0, 106.0),
        (0.0, 106.0),
    ];
    let floor = -13.0;
    object.put(resting(along_y(lobed(&handle, 6, 0.07, 48)), floor), [0.0, -106.0, 0.0], &grip);
    let pads =
        [(0.0, 18.0), (14.6, 18.0), (15.4, 22.0), (14.0, 52.0), (15.5, 72.0), (14.6, 78.0), (0.0, 78.0)];
    object.put(resting(along_y(lobed(&pads, 6, 0.07, 48)), floor), [0.0, -106.0, 0.0], &black());
    object.put(along_y(cylinder(7.0, 6.0, 1.0, 24)), [0.0, -110.0, 0.0], &black());
    object.put(along_y(cylinder(3.4, 96.0, 0.0, 20)), [0.0, -2.0, 0.0], &metal);
    let dark = Material::metal("tip", Rgb::hex(0x4a4c50), 0.4);
    let tip = if order.pick(2) == 0 {
        bar(
            &[
                (90.0, 0.0, 0.0, 7.0, 7.0),
                (102.0, 0.0, 0.0, 8.6, 5.0),
                (110.0, 0.0, 0.0, 8.0, 1.6),
                (112.0, 0.0, 0.0, 7.4, 1.4),
            ],
            5.0,
            20,
        )
    } else {
        let cross = [(0.0, 0.0), (3.6, 0.0), (3.4, 14.0), (1.4, 21.0), (0.0, 22.0)];
        along_y(lobed(&cross, 4, 0.16, 24)).translated(DVec3::Y * 90.0)
    };
    object.put(tip, [0.0; 3], &dark);
    object.fitted(order.size_m)
}

/// Hexagon bolt standing on its head.
pub(super) fn bolt(order: &mut Order) -> TexturedMesh {
    let mut object = Assembly::new();
    let metal = hardware(order);
    object.put(slab(&regular_polygon(15.0, 6), 10.0, 1.4), [0.0; 3], &metal);
    object.put(cylinder(12.4, 1.6, 0.4, 36), [0.0, 0.0, 9.4], &metal);
    let threads_from = [18.0, 28.0, 34.0][order.pick(3)];
    let (end, pitch) = (66.0, 3.0);
    let mut shank = vec![(0.0, 8.0), (8.0, 8.0), (8.0, threads_from)];
    let mut z = threads_from + 0.8;
    while z + pitch < end - 2.0 {
        shank.extend([(6.6, z), (8.0, z + 0.5 * pitch), (8.0, z + 0.5 * pitch + 0.4)]);
        z += pitch;
    }
    shank.extend([(7.6, end - 1.6), (6.2, end), (0.0, end)]);
    object.put(lathe(&points(&shank), 36), [0.0; 3], &metal);
    object.fitted_round(order.size_m)
}

/// Hexagon nut lying flat, threaded through.
pub(super) fn nut(order: &mut Order) -> TexturedMesh {
    let mut object = Assembly::new();
    let metal = hardware(order);
    let bore = [9.2, 10.0][order.pick(2)];
    object.put(pierced(&regular_polygon(18.0, 6), (0.0, 0.0), |_| bore, 15.0, 1.3, 48), [0.0; 3], &metal);
    // The same from both sides, as a nut is.
    let mut thread = vec![(bore + 1.4, 1.6), (bore + 1.4, 13.4), (bore - 0.4, 13.0)];
    for k in 0..5 {
        let crest = 11.7 - 2.1 * f64::from(k);
        thread.extend([(bore - 0.3, crest + 1.05), (bore - 1.5, crest + 0.2), (bore - 1.5, crest - 0.2)]);
    }
    thread.extend([(bore - 0.3, 2.25), (bore - 0.4, 2.0)]);
    let inside = Material { roughness: 0.5, ..Material::metal("thread", Rgb::hex(0x808286), 0.5) };
    object.put(turned_ring(&thread, 36), [0.0; 3], &inside);
    // A raised washer face on both sides.
    let face =
        [(13.6, -0.4), (14.0, 0.4), (14.0, 14.6), (13.6, 15.4), (12.4, 15.4), (12.2, 7.5), (12.4, -0.4)];
    object.put(turned_ring(&face, 36), [0.0; 3], &metal);
    object.fitted_round(order.size_m)
}

fn hardware(order: &mut Order) -> Material {
    match order.material {
        Some(_) => main_finish(order, "steel"),
        None => Material::metal("zinc", order.color, 0.32),
    }
}

/// Cordless drill standing on its battery, chuck at +y.
pub(super) fn power_drill(order: &mut Order) -> TexturedMesh {
    let mut object = Assembly::new();
    let (shell, dark) = (main_finish(order, "plastic"), black());
    let gray = Material::plain("gray", Rgb::hex(0x55585c), 0.5);
    object.put(rounded_block(DVec3::new(74.0, 112.0, 40.0), 12.0, 4.0), [0.0, -12.0, 0.0], &dark);
    object.put(rounded_block(DVec3::new(66.0, 98.0, 12.0), 10.0, 3.0), [0.0, -12.0, 36.0], &shell);
    let grip = [
        (42.0, 0.0, -20.0, 40.0, 64.0),
        (58.0, 0.0, -18.0, 35.0, 48.0),
        (92.0, 0.0, -14.0, 34.0, 46.0),
        (128.0, 0.0, -9.0, 37.0, 52.0),
        (156.0, 0.0, -6.0, 42.0, 70.0),
    ];
    object.put(column(&grip, 3.0, 32), [0.0; 3], &shell);
    let pad = [
        (56.0, 0.0, -24.0, 30.0, 42.0),
        (60.0, 0.0, -24.0, 36.5, 42.0),
        (92.0, 0.0, -20.0, 36.0, 42.0),
        (126.0, 0.0, -16.0, 38.0, 44.0),
        (130.0, 0.0, -16.0, 32.0, 40.0),
    ];
    object.put(column(&pad, 3.0, 32), [0.0; 3], &dark);
    let barrel = [
        (-84.0, 0.0, 168.0, 40.0, 44.0),
        (-78.0, 0.0, 168.0, 54.0, 60.0),
        (-20.0, 0.0, 168.0, 60.0, 66.0),
        (40.0, 0.0, 168.0, 58.0, 62.0),
        (66.0, 0.0, 168.0, 50.0, 52.0),
    ];
    object.put(bar(&barrel, 3.2, 36), [0.0; 3], &shell);
    for k in 0..3 {
        let y = -66.0 + 13.0 * f64::from(k);
        object.put(
            bar(&[(y, 0.0, 168.0, 60.5, 60.0), (y + 6.0, 0.0, 168.0, 61.5, 60.5)], 3.2, 28),
            [0.0; 3],
            &dark,
        );
    }
    let clutch = [(0.0, 0.0), (23.0, 0.0), (23.5, 3.0), (23.0, 20.0), (0.0, 20.0)];
    object.put(along_y(lobed(&clutch, 14, 0.03, 42)), [0.0, 64.0, 168.0], &gray);
    let chuck = points(&[(0.0, 0.0), (20.0, 0.0), (20.0, 22.0), (16.0, 36.0), (8.0, 44.0), (0.0, 44.0)]);
    object.put(along_y(lathe(&chuck, 32)), [0.0, 82.0, 168.0], &dark);
    let metal = steel(order);
    object.put(along_y(cylinder(3.2, 52.0, 0.6, 16)), [0.0, 120.0, 168.0], &metal);
    let trigger = points(&[(10.0, 108.0), (24.0, 112.0), (22.0, 124.0), (27.0, 138.0), (10.0, 142.0)]);
    object.put(across_x(&trigger, 16.0, 2.0), [0.0; 3], &dark);
    let badge = Material::textured(
        "badge",
        label(Rgb::hex(0x2a2b2e), Rgb::hex(0xf2f0ea), "20V", &mut order.rng),
        0.5,
    );
    object.put(side_plate(44.0, 26.0, 3.0), [29.4, 14.0, 170.0], &badge);
    object.put(yawed(side_plate(44.0, 26.0, 3.0), 180.0), [-29.4, 14.0, 170.0], &badge);
    object.fitted(order.size_m)
}
