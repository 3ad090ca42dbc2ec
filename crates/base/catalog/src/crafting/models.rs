//! Scale models: car and airplane. Model millimeters.

use glam::DVec3;

use crate::Order;
use crate::assembly::{
    Assembly, across_x, along_x, along_y, bar, black, main_finish, mirrored_x, path, points, resting, rolled,
};
use geometry::shapes::{cylinder, ellipsoid, lathe, rounded_block, slab, tube};
use geometry::{Material, Rgb, Solid, TexturedMesh};

/// Model car on its wheels, nose toward -y: sedan, estate or pickup.
pub(super) fn model_car(order: &mut Order) -> TexturedMesh {
    let mut object = Assembly::new();
    let paint = match order.material {
        Some(_) => main_finish(order, "plastic"),
        None => Material::plain("paint", order.color, 0.18),
    };
    let glass = Material::plain("windows", Rgb::hex(0x1a242e), 0.08);
    let chrome = Material::metal("chrome", Rgb::hex(0xd2d4d8), 0.2);
    let body = points(&[
        (-72.0, 8.0),
        (72.0, 8.0),
        (76.0, 14.0),
        (75.0, 27.0),
        (66.0, 31.0),
        (40.0, 32.0),
        (-28.0, 32.0),
        (-60.0, 28.0),
        (-74.0, 22.0),
        (-77.0, 14.0),
    ]);
    object.put(across_x(&body, 62.0, 4.5), [0.0; 3], &paint);
    let style = order.pick(3);
    let (cabin, roof_from, roof_to) = match style {
        0 => (points(&[(-34.0, 28.0), (52.0, 28.0), (33.0, 47.0), (-12.0, 47.0)]), -14.0, 34.0),
        1 => (points(&[(-36.0, 28.0), (70.0, 28.0), (64.0, 48.0), (-14.0, 48.0)]), -16.0, 64.0),
        _ => (points(&[(-34.0, 28.0), (20.0, 28.0), (16.0, 49.0), (-13.0, 49.0)]), -15.0, 18.0),
    };
    let top = cabin.iter().map(|p| p.y).fold(0.0, f64::max);
    object.put(across_x(&cabin, 52.0, 3.0), [0.0; 3], &glass);
    let center = 0.5 * (roof_from + roof_to);
    let length = roof_to - roof_from;
    object.put(rounded_block(DVec3::new(50.0, length, 5.0), 6.0, 2.0), [0.0, center, top - 2.0], &paint);
    // Pillars: the cabin's outline again, thin, at its ends and in the center.
    let pillar = |y0: f64, y1: f64| {
        path(&[(0.0, y0, 29.0), (0.0, 0.5 * (y0 + y1), 0.5 * (29.0 + top)), (0.0, y1, top)])
    };
    let corners = [(cabin[0].x, cabin[3].x), (cabin[1].x, cabin[2].x), (center + 2.0, center + 2.0)];
    for (low, high) in corners {
        object.put_pair(&tube(&pillar(low, high), 2.0, 8), [24.6, 0.0, 0.0], &paint);
    }
    if style == 2 {
        let bed = rounded_block(DVec3::new(50.0, 44.0, 3.0), 3.0, 0.8);
        object.put(bed, [0.0, 47.0, 30.0], &black());
        for x in [-27.0, 27.0] {
            object.put(rounded_block(DVec3::new(5.0, 52.0, 9.0), 1.5, 1.0), [x, 46.0, 28.0], &paint);
        }
        object.put(rounded_block(DVec3::new(59.0, 5.0, 9.0), 1.5, 1.0), [0.0, 71.0, 28.0], &paint);
    }
    if style != 2 && order.pick(2) == 0 {
        let stripe = Material::plain("stripe", Rgb::hex(0xf4f2ec), 0.3);
        for x in [-7.0, 7.0] {
            object.put(
                rounded_block(DVec3::new(7.0, length - 8.0, 3.0), 0.6, 0.3),
                [x, center, top + 0.6],
                &stripe,
            );
            let hood = bar(&[(-66.0, x, 25.6, 7.0, 3.0), (-30.0, x, 30.9, 7.0, 3.0)], 6.0, 12);
            object.put(hood, [0.0; 3], &stripe);
        }
    }
    let tire = Material::plain("tire", Rgb::hex(0x1c1c1e), 0.85);
    let rim = lathe(&points(&[(0.0, 0.0), (8.0, 0.0), (8.0, 1.4), (3.0, 1.0), (0.0, 2.2)]), 18);
    for y in [-46.0, 47.0] {
        let wheel = resting(along_x(tire_shape(13.0, 12.0)), -12.6);
        object.put_pair(&wheel, [22.0, y, 12.6], &tire);
        object.put_pair(&along_x(rim.clone()), [33.4, y, 12.6], &chrome);
        object.put_pair(&along_x(cylinder(15.0, 3.0, 0.0, 24)), [28.6, y, 14.0], &black());
    }
    let lamp = Material::plain("headlight", Rgb::hex(0xfff2c0), 0.1);
    let tail = Material::plain("tail_light", Rgb::hex(0xc81e1e), 0.2);
    object.put_pair(&ellipsoid(DVec3::new(13.0, 8.0, 8.0), 14), [20.0, -73.0, 16.5], &lamp);
    object.put_pair(&rounded_block(DVec3::new(12.0, 4.0, 5.0), 1.2, 0.6), [21.0, 74.5, 19.0], &tail);
    object.put(rounded_block(DVec3::new(22.0, 4.0, 6.0), 1.5, 0.8), [0.0, -75.5, 15.0], &black());
    for (y, width) in [(-76.0, 60.0), (75.0, 60.0)] {
        object.put(rounded_block(DVec3::new(width, 5.0, 5.0), 2.0, 1.2), [0.0, y, 9.0], &chrome);
    }
    object.fitted(order.size_m)
}

/// Model airplane on three wheels, propeller toward -y: low-wing monoplane or biplane.
pub(super) fn model_airplane(order: &mut Order) -> TexturedMesh {
    let mut object = Assembly::new();
    let paint = match order.material {
        Some(_) => main_finish(order, "plastic"),
        None => Material::plain("paint", order.color, 0.28),
    };
    let trim = Material::plain("trim", Rgb::hex([0xf2eee4, 0xf0c030, 0x2a2e36][order.pick(3)]), 0.3);
    let metal = Material::metal("metal", Rgb::hex(0xc0c2c6), 0.3);
    let biplane = order.pick(2) == 0;
    let fuselage = [
        (-76.0, 0.0, 38.0, 22.0, 22.0),
        (-72.0, 0.0, 38.0, 28.0, 29.0),
        (-50.0, 0.0, 38.0, 31.0, 35.0),
        (-10.0, 0.0, 38.5, 30.0, 36.0),
        (30.0, 0.0, 40.0, 22.0, 27.0),
        (70.0, 0.0, 42.0, 12.0, 16.0),
        (98.0, 0.0, 44.0, 5.0, 9.0),
    ];
    object.put(bar(&fuselage, 2.4, 28), [0.0; 3], &paint);
    object.put(along_y(cylinder(14.6, 9.0, 1.5, 28)), [0.0, -78.0, 38.0], &trim);
    let wing = |span: f64, chord: f64| -> Solid {
        let (s, c) = (0.5 * span, 0.5 * chord);
        slab(
            &points(&[
                (-0.92 * s, -0.80 * c),
                (-0.3 * s, -c),
                (0.3 * s, -c),
                (0.92 * s, -0.80 * c),
                (s, -0.4 * c),
                (s, 0.5 * c),
                (0.92 * s, 0.8 * c),
                (0.3 * s, c),
                (-0.3 * s, c),
                (-0.92 * s, 0.8 * c),
                (-s, 0.5 * c),
                (-s, -0.4 * c),
            ]),
            4.4,
            1.4,
        )
    };
    let wing_y = -26.0;
    object.put(wing(236.0, 46.0), [0.0, wing_y, 27.0], &paint);
    let mut upper = 27.0;
    if biplane {
        upper = 68.0;
        object.put(wing(240.0, 46.0), [0.0, wing_y - 6.0, upper], &paint);
        for (x, y) in [(74.0, -14.0), (74.0, 10.0), (13.0, -8.0), (13.0, 8.0)] {
            let low = if x > 20.0 { 29.0 } else { 50.0 };
            let strut = path(&[(x, wing_y + y, low), (x, wing_y + y - 4.0, upper + 2.0)]);
            object.put_pair(&tube(&strut, 1.6, 8), [0.0; 3], &trim);
        }
    }
    // Roundels and wing tips.
    for (radius, rise, color) in [(14.0, 3.9, 0xf4f2ec), (9.5, 4.5, 0x244f9a), (4.5, 5.1, 0xc8282c)] {
        let disc = cylinder(radius, 1.2, 0.0, 28);
        object.put_pair(
            &disc,
            [82.0, wing_y - if biplane { 6.0 } else { 0.0 }, upper + rise],
            &Material::plain("roundel", Rgb::hex(color), 0.4),
        );
    }
    object.put(wing(78.0, 28.0), [0.0, 84.0, 42.0], &trim);
    let fin = points(&[(66.0, 44.0), (98.0, 42.0), (102.0, 60.0), (99.0, 76.0), (88.0, 78.0), (80.0, 66.0)]);
    object.put(across_x(&fin, 4.0, 1.2), [0.0; 3], &trim);
    let canopy = Material::plain("canopy", Rgb::hex(0x243240), 0.06);
    object.put(ellipsoid(DVec3::new(20.0, 42.0, 26.0), 20), [0.0, 6.0, 43.0], &canopy);
    // Propeller.
    let spinner = lathe(&points(&[(0.0, -16.0), (3.0, -14.0), (6.0, -8.0), (7.0, 2.0), (0.0, 2.0)]), 20);
    object.put(along_y(spinner), [0.0, -79.0, 38.0], &metal);
    let turn = order.uniform(-60.0, 60.0);
    let blade = rounded_block(DVec3::new(7.0, 2.4, 40.0), 1.1, 0.7);
    for half in [0.0, 180.0] {
        object.put(rolled(blade.clone(), 90.0 + turn + half), [0.0, -85.0, 38.0], &black());
    }
    // Gear: two main wheels and a nose wheel.
    let tire = Material::plain("tire", Rgb::hex(0x1c1c1e), 0.85);
    let wheel = resting(along_x(tire_shape(10.0, 7.0)), -9.6);
    let hub = along_x(cylinder(4.5, 9.0, 0.0, 16));
    let leg = tube(&path(&[(12.0, 4.0, 30.0), (27.0, 4.0, 9.6)]), 1.8, 10);
    object.put(mirrored_x(leg.clone()), [0.0; 3], &metal);
    object.put(leg, [0.0; 3], &metal);
    for x in [-29.0, 29.0] {
        object.put(wheel.clone(), [x - 3.5, 4.0, 9.6], &tire);
        object.put(hub.clone(), [x - 4.5, 4.0, 9.6], &trim);
    }
    object.put(tube(&path(&[(0.0, -60.0, 28.0), (0.0, -62.0, 9.6)]), 1.8, 10), [0.0; 3], &metal);
    object.put(wheel, [-3.5, -62.0, 9.6], &tire);
    object.put(hub, [-4.5, -62.0, 9.6], &trim);
    object.fitted(order.size_m)
}

/// A tire along +z from 0 to `width`, its shoulders rounded.
fn tire_shape(radius: f64, width: f64) -> Solid {
    let shoulder = 0.16 * radius;
    let profile = points(&[
        (0.0, 0.0),
        (radius - shoulder, 0.0),
        (radius, shoulder),
        (radius, width - shoulder),
        (radius - shoulder, width),
        (0.0, width),
    ]);
    lathe(&profile, 28)
}
