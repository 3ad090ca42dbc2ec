//! Measuring tools: tape measure, spirit level, multimeter. Model millimeters.

use glam::DVec3;

use crate::Order;
use crate::assembly::{
    Assembly, across_y, along_x, along_y, black, main_finish, pitched, plastic, points, print_plate,
    side_plate, steel, turned_ring, yawed,
};
use crate::texture::{draw_text, fill_disc, fill_rectangle, label};
use geometry::shapes::{circle, cylinder, ellipsoid, lathe, prism, rounded_block};
use geometry::{Material, Rgb, TexturedMesh};
use imaging::{Image, Texture};

/// Tape measure standing on its base, blade out toward +x.
pub(super) fn tape_measure(order: &mut Order) -> TexturedMesh {
    let mut object = Assembly::new();
    let shell = main_finish(order, "plastic");
    let metal = steel(order);
    let view = points(&[
        (-35.0, 0.0),
        (35.0, 0.0),
        (38.0, 4.0),
        (38.5, 20.0),
        (36.0, 38.0),
        (29.0, 52.0),
        (18.0, 62.0),
        (4.0, 67.0),
        (-12.0, 67.0),
        (-25.0, 60.0),
        (-34.0, 48.0),
        (-38.0, 32.0),
        (-38.5, 5.0),
    ]);
    object.put(across_y(&view, 38.0, 5.0), [0.0; 3], &shell);
    let bumper = view.iter().map(|p| glam::DVec2::new(p.x * 1.035, p.y * 1.03)).collect::<Vec<_>>();
    object.put(across_y(&bumper, 19.0, 3.0), [0.0; 3], &black());
    let length = ["3M", "5M", "8M"][order.pick(3)];
    let badge = Material::textured(
        "badge",
        label(Rgb::hex(0xf4f1e8), order.color.scaled(0.85), length, &mut order.rng),
        0.5,
    );
    let disc = pitched(prism(&circle(23.0, 40), 3.0), 90.0);
    object.put(disc.clone(), [-3.0, -17.2, 33.0], &badge);
    object.put(yawed(disc, 180.0), [-3.0, 17.2, 33.0], &badge);
    let tape = Material::textured("tape", ticks(Rgb::hex(0xf2cf3a), Rgb::hex(0x222224), 6), 0.4);
    object.put(print_plate(34.0, 25.0, 1.4), [47.0, 0.0, 4.6], &tape);
    object.put(rounded_block(DVec3::new(1.8, 24.0, 9.0), 0.7, 0.5), [63.0, 0.0, 0.3], &metal);
    object.put(rounded_block(DVec3::new(7.0, 12.0, 1.4), 0.6, 0.4), [60.0, 0.0, 5.6], &metal);
    let button = pitched(rounded_block(DVec3::new(13.0, 15.0, 7.0), 3.0, 1.5), 0.0);
    object.put(
        crate::assembly::rolled(button, 52.0),
        [33.0, 0.0, 46.0],
        &Material::plain("lock", Rgb::hex(0xc83228), 0.45),
    );
    object.put(rounded_block(DVec3::new(18.0, 2.0, 44.0), 0.9, 0.6), [-2.0, 22.0, 12.0], &metal);
    object.put(rounded_block(DVec3::new(18.0, 6.0, 5.0), 1.0, 0.6), [-2.0, 20.0, 51.0], &metal);
    object.fitted(order.size_m)
}

/// A scale with `groups` numbered tenths along u, ticks from the lower edge.
fn ticks(ground: Rgb, ink: Rgb, groups: i32) -> Texture {
    let mut image = Image::filled(256, 128, ground.to_rgba8());
    for k in 0..groups * 5 {
        let x = k * 256 / (groups * 5);
        let long = if k % 5 == 0 { 70 } else { 38 };
        fill_rectangle(&mut image, x, 128 - long, 3, long, ink);
    }
    for k in 0..groups {
        draw_text(&mut image, &format!("{}", k + 1), k * 256 / groups + 12, 14, 5, ink);
    }
    Texture::new(image)
}

/// Spirit level on its edge along y: I-beam, top vial and two plumb vials.
pub(super) fn spirit_level(order: &mut Order) -> TexturedMesh {
    let mut object = Assembly::new();
    let beam_finish = main_finish(order, "plastic");
    let beam = points(&[
        (-12.0, 0.0),
        (12.0, 0.0),
        (12.0, 8.0),
        (6.5, 11.0),
        (6.5, 41.0),
        (12.0, 44.0),
        (12.0, 52.0),
        (-12.0, 52.0),
        (-12.0, 44.0),
        (-6.5, 41.0),
        (-6.5, 11.0),
        (-12.0, 8.0),
    ]);
    object.put(across_y(&beam, 396.0, 0.0), [0.0; 3], &beam_finish);
    for y in [-197.0, 197.0] {
        object.put(rounded_block(DVec3::new(27.0, 12.0, 54.0), 3.0, 1.5), [0.0, y, 0.0], &black());
    }
    let fluid = Material { opacity: 0.85, ..Material::plain("fluid", Rgb::hex(0xc8e03a), 0.1) };
    let line = Material::plain("line", Rgb::hex(0x1c1d1f), 0.5);
    let bubble = Material::plain("bubble", Rgb::hex(0xf4fad8), 0.1);
    object.put(rounded_block(DVec3::new(25.0, 74.0, 18.0), 3.0, 1.2), [0.0, 0.0, 36.5], &black());
    object.put(
        along_y(lathe(&points(&[(0.0, -27.0), (6.0, -27.0), (8.0, 0.0), (6.0, 27.0), (0.0, 27.0)]), 28)),
        [0.0, 0.0, 52.0],
        &fluid,
    );
    for y in [-8.0, 8.0] {
        object.put(along_y(cylinder(8.0, 1.4, 0.2, 24)), [0.0, y - 0.7, 52.0], &line);
    }
    let off_level = order.uniform(-2.5, 2.5);
    object.put(ellipsoid(DVec3::new(9.0, 13.0, 6.0), 20), [0.0, off_level, 55.2], &bubble);
    let ring = [(13.5, -12.8), (19.0, -12.8), (19.6, -12.0), (19.6, 12.0), (19.0, 12.8), (13.5, 12.8)];
    for y in [-140.0, 140.0] {
        object.put(along_x(turned_ring(&ring, 32)), [0.0, y, 26.0], &black());
        object.put(
            lathe(&points(&[(0.0, 12.0), (7.6, 12.0), (9.0, 26.0), (7.6, 40.0), (0.0, 40.0)]), 20),
            [0.0, y, 0.0],
            &fluid,
        );
        for z in [22.0, 29.0] {
            object.put(cylinder(9.4, 1.2, 0.2, 20), [0.0, y, z], &line);
        }
    }
    let badge =
        Material::textured("badge", label(order.color, Rgb::hex(0xf4f4f0), "LEVEL", &mut order.rng), 0.5);
    for (x, turn) in [(6.2, 0.0), (-6.2, 180.0)] {
        object.put(yawed(side_plate(56.0, 26.0, 2.0), turn), [x, -70.0, 26.0], &badge);
    }
    // Inch marks along both flanges of the top.
    let scale = Material::textured("scale", ticks(Rgb::hex(0xe8e6dc), Rgb::hex(0x222224), 12), 0.5);
    for y in [-112.0, 112.0] {
        object.put(yawed(print_plate(146.0, 9.0, 1.6), 90.0), [-5.0, y, 51.0], &scale);
    }
    object.fitted(order.size_m)
}

/// Multimeter on its back: display, range dial, keys, jacks.
pub(super) fn multimeter(order: &mut Order) -> TexturedMesh {
    let mut object = Assembly::new();
    let (holster, dark) = (plastic(order.color), Material::plain("case", Rgb::hex(0x2c2e32), 0.5));
    object.put(rounded_block(DVec3::new(86.0, 166.0, 30.0), 14.0, 5.0), [0.0; 3], &holster);
    object.put(rounded_block(DVec3::new(94.0, 34.0, 31.0), 10.0, 5.0), [0.0, 60.0, 0.0], &holster);
    object.put(rounded_block(DVec3::new(94.0, 34.0, 31.0), 10.0, 5.0), [0.0, -60.0, 0.0], &holster);
    object.put(rounded_block(DVec3::new(72.0, 148.0, 10.0), 8.0, 1.5), [0.0, 0.0, 25.0], &dark);
    let bezel = Material::plain("bezel", Rgb::hex(0x141517), 0.3);
    object.put(rounded_block(DVec3::new(64.0, 42.0, 4.0), 4.0, 1.0), [0.0, 47.0, 33.0], &bezel);
    let reading = ["12.47", "230.1", "1.503", "0.998"][order.pick(4)];
    let display = Material::textured("display", display_image(reading), 0.25);
    object.put(print_plate(56.0, 33.0, 2.0), [0.0, 47.0, 35.6], &display);
    let keys = [0xd8d9da, 0xd8d9da, 0xe8b02c, 0xd8d9da];
    for (k, color) in (0..4).zip(keys) {
        let key = Material::plain("key", Rgb::hex(color), 0.5);
        object.put(
            rounded_block(DVec3::new(10.0, 6.5, 4.0), 2.5, 1.0),
            [-22.5 + 15.0 * f64::from(k), 18.0, 33.6],
            &key,
        );
    }
    let dial = Material::textured("dial", dial_image(order.color), 0.5);
    object.put(prism(&circle(26.0, 48), 3.0), [0.0, -16.0, 32.8], &dial);
    let knob = Material::plain("knob", Rgb::hex(0x4a4d52), 0.45);
    object.put(cylinder(14.0, 7.0, 1.5, 36), [0.0, -16.0, 35.0], &knob);
    let turn = [0.0, 35.0, -50.0, 80.0][order.pick(4)];
    object.put(yawed(rounded_block(DVec3::new(7.0, 27.0, 6.0), 3.0, 1.5), turn), [0.0, -16.0, 40.0], &knob);
    object.put(
        yawed(rounded_block(DVec3::new(2.0, 9.0, 1.4), 0.6, 0.3).translated(DVec3::Y * 8.0), turn),
        [0.0, -16.0, 45.2],
        &Material::plain("pointer", Rgb::hex(0xf6f6f2), 0.5),
    );
    let jack = [(2.8, 0.0), (6.4, 0.0), (6.4, 3.0), (5.4, 4.4), (2.8, 4.4)];
    for (x, color) in [(-24.0, 0xc83228), (-8.0, 0xc83228), (8.0, 0x18191b), (24.0, 0xc83228)] {
        let rim = Material::plain("jack", Rgb::hex(color), 0.4);
        object.put(turned_ring(&jack, 24), [x, -59.0, 33.0], &rim);
    }
    object.fitted(order.size_m)
}

fn display_image(reading: &str) -> Texture {
    let (ground, ink) = (Rgb::hex(0xb4c2a4), Rgb::hex(0x1c221c));
    let mut image = Image::filled(256, 128, ground.to_rgba8());
    draw_text(&mut image, reading, 18, 34, 7, ink);
    draw_text(&mut image, "V", 228, 44, 4, ink);
    draw_text(&mut image, "AUTO", 18, 8, 2, ink);
    draw_text(&mut image, "DC", 214, 8, 2, ink);
    for k in 0..24 {
        fill_rectangle(&mut image, 18 + 9 * k, 108, 5, if k < 15 { 12 } else { 4 }, ink);
    }
    Texture::new(image)
}

/// Ranges around a selector, colored sectors.
fn dial_image(accent: Rgb) -> Texture {
    let mut image = Image::filled(256, 256, Rgb::hex(0x2c2e32).to_rgba8());
    let white = Rgb::hex(0xf0f0ec);
    for k in 0..12_i32 {
        let angle = f64::from(k) * std::f64::consts::TAU / 12.0;
        let at = |r: f64| (128.0 + r * angle.cos(), 128.0 + r * angle.sin());
        let (x, y) = at(112.0);
        let color = if k % 3 == 0 { accent } else { white };
        fill_disc(&mut image, x as i32, y as i32, 7, color);
        let (x, y) = at(88.0);
        let text = ["V", "A", "MA", "R"][(k % 4) as usize];
        draw_text(&mut image, text, x as i32 - 8, y as i32 - 8, 2, white);
    }
    Texture::new(image)
}
