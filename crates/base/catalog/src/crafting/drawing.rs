//! Drawing and writing supplies: ruler, glue stick, cutting mat, crayons, color pencil, marker. Model
//! millimeters.

use glam::DVec3;

use crate::Order;
use crate::assembly::{
    Assembly, across_x, along_y, black, front_plate, lobed, main_finish, pitched, plastic, points,
    print_plate, resting, yawed,
};
use crate::texture::{
    draw_text, fill_disc, fill_rectangle, label, text_width_px, wood_grain, wrap_label, wrapped_around,
};
use geometry::shapes::{circle, cylinder, lathe, prism, regular_polygon, rounded_block, rounded_rectangle};
use geometry::{Material, Rgb, TexturedMesh};
use imaging::{Image, Texture};

/// Ruler along y: wood, steel or plastic, graduated on both edges.
pub(super) fn ruler(order: &mut Order) -> TexturedMesh {
    let mut object = Assembly::new();
    let style = if order.material.is_some() { 3 } else { order.pick(3) };
    let (body, image) = match style {
        0 => {
            let tone = Rgb::hex(0xdcb478);
            let grain = wood_grain(tone, &mut order.rng);
            let printed = scale_print(Some(&grain), tone);
            (Material::textured("wood", grain, 0.55), printed)
        }
        1 => {
            let tone = Rgb::hex(0xb8bcc2);
            (Material::metal("steel", tone, 0.3), scale_print(None, Rgb::hex(0xc6cace)))
        }
        2 => (plastic(order.color), scale_print(None, order.color)),
        _ => {
            let finish = main_finish(order, "wood");
            let printed = scale_print(finish.base_color_texture.as_deref(), finish.base_color);
            (finish, printed)
        }
    };
    let steel_like = body.metalness;
    object.put(rounded_block(DVec3::new(32.0, 306.0, 2.8), 2.5, 0.6), [0.0; 3], &body);
    let print = Material { metalness: 0.5 * steel_like, ..Material::textured("scale", image, 0.5) };
    object.put(yawed(print_plate(302.0, 30.0, 1.6), 90.0), [0.0, 0.0, 1.8], &print);
    object.put(cylinder(3.2, 1.6, 0.2, 20), [0.0, 146.0, 2.3], &black());
    object.fitted(order.size_m)
}

/// Thirty centimeters of graduation on `ground`, 512 x 64 px.
fn scale_print(ground: Option<&Image>, tone: Rgb) -> Texture {
    let mut image = Image::filled(512, 64, tone.to_rgba8());
    if let Some(ground) = ground {
        let (width, height) = (ground.width_px(), ground.height_px());
        for y in 0..64 {
            for x in 0..512 {
                image.set_pixel(x, y, ground.pixel(x % width, y % height));
            }
        }
    }
    let [r, g, b] = tone.0;
    let ink = if 0.3 * r + 0.6 * g + 0.1 * b > 0.42 { Rgb::hex(0x1a1a1e) } else { Rgb::hex(0xf6f4ee) };
    for k in 0..=60 {
        let x = 6 + k * 500 / 60;
        let long = if k % 10 == 0 {
            24
        } else if k % 2 == 0 {
            17
        } else {
            9
        };
        let wide = if k % 10 == 0 { 3 } else { 2 };
        fill_rectangle(&mut image, x, 0, wide, long, ink);
        fill_rectangle(&mut image, x, 64 - long * 2 / 3, wide, long * 2 / 3, ink);
        if k % 10 == 0 && k > 0 && k < 60 {
            let text = format!("{}", k / 2);
            draw_text(&mut image, &text, x - text_width_px(&text, 2) / 2, 28, 2, ink);
        }
    }
    Texture::new(image)
}

/// Glue stick standing on its turning foot, cap on.
pub(super) fn glue_stick(order: &mut Order) -> TexturedMesh {
    let mut object = Assembly::new();
    let color = main_finish(order, "plastic");
    let white = Material::plain("tube", Rgb::hex(0xf4f2ec), 0.4);
    let foot = [(0.0, 0.0), (12.6, 0.0), (13.4, 0.8), (13.4, 9.0), (12.6, 10.0), (0.0, 10.0)];
    object.put(lobed(&foot, 24, 0.03, 72), [0.0; 3], &color);
    object.put(lathe(&points(&[(0.0, 9.0), (12.8, 9.0), (12.8, 66.0), (0.0, 66.0)]), 36), [0.0; 3], &white);
    let word = ["GLUE", "STICK"][order.pick(2)];
    let accent = Rgb::hex([0xd8282c, 0xf2b81e, 0x2c64c0][order.pick(3)]);
    let paper =
        Material::textured("label", wrap_label(Rgb::hex(0xf6f2e4), accent, word, &mut order.rng), 0.5);
    object.put(wrapped_around(prism(&circle(13.4, 36), 48.0)), [0.0, 0.0, 13.0], &paper);
    let cap = points(&[
        (0.0, 0.0),
        (14.0, 0.0),
        (14.2, 1.0),
        (13.9, 26.0),
        (13.0, 29.0),
        (11.0, 30.0),
        (10.4, 29.0),
        (0.0, 29.0),
    ]);
    object.put(lathe(&cap, 36), [0.0, 0.0, 63.0], &color);
    object.fitted_round(order.size_m)
}

/// Self-healing cutting mat with its grid.
pub(super) fn cutting_mat(order: &mut Order) -> TexturedMesh {
    let mut object = Assembly::new();
    let base = main_finish(order, "plastic");
    object.put(rounded_block(DVec3::new(300.0, 220.0, 3.0), 6.0, 0.8), [0.0; 3], &base);
    let ink = Rgb::hex(0xf0ecc8).mix(order.color, 0.18);
    let mut image = Image::filled(512, 512, order.color.to_rgba8());
    // 28 x 20 centimeters of squares inside a margin.
    let (left, top, width, height) = (24, 30, 464, 452);
    for k in 0..=28 {
        let x = left + k * width / 28;
        let (wide, shade) = if k % 5 == 0 { (3, 0.0) } else { (1, 0.35) };
        fill_rectangle(&mut image, x, top, wide, height, ink.mix(order.color, shade));
        if k % 5 == 0 && k > 0 {
            draw_text(&mut image, &format!("{k}"), x - 8, 488, 2, ink);
        }
        fill_rectangle(&mut image, x, 20, 1, 10, ink);
    }
    for k in 0..=20 {
        let y = top + k * height / 20;
        let (wide, shade) = if k % 5 == 0 { (3, 0.0) } else { (1, 0.35) };
        fill_rectangle(&mut image, left, y, width, wide, ink.mix(order.color, shade));
    }
    for k in 0..452 {
        fill_rectangle(&mut image, left + k, top + height - k, 2, 2, ink);
        fill_rectangle(&mut image, left + k, top + height - k * 58 / 100, 2, 2, ink);
    }
    draw_text(&mut image, "A4", 446, 40, 3, ink);
    let print = Material::textured("grid", Texture::new(image), 0.75);
    object.put(print_plate(292.0, 212.0, 1.4), [0.0, 0.0, 2.1], &print);
    object.fitted(order.size_m)
}

/// Open box of crayons, flap up behind two rows of tips.
pub(super) fn crayon_box(order: &mut Order) -> TexturedMesh {
    let mut object = Assembly::new();
    let card = main_finish(order, "cardboard_box");
    let inside = Material::plain("inside", Rgb::hex(0xe8e2d4), 0.9);
    let (width, depth, wall) = (76.0, 30.0, 1.6);
    object.put(rounded_block(DVec3::new(width, depth, 3.0), 0.6, 0.3), [0.0; 3], &card);
    let (front, back) = (74.0, 92.0);
    let side = points(&[
        (-0.5 * depth + 0.3, 0.4),
        (0.5 * depth - 0.3, 0.4),
        (0.5 * depth - 0.3, back),
        (-0.5 * depth + 0.3, front - 0.3),
    ]);
    for x in [-1.0, 1.0] {
        object.put(across_x(&side, wall, 0.0), [x * 0.5 * (width - wall), 0.0, 0.0], &card);
    }
    object.put(
        front_plate(width - 0.4, front - 0.2, wall),
        [0.0, -0.5 * (depth - wall), 0.5 * front + 0.2],
        &card,
    );
    object.put(
        front_plate(width - 0.4, back - 0.2, wall),
        [0.0, 0.5 * (depth - wall), 0.5 * back + 0.2],
        &card,
    );
    object.put(rounded_block(DVec3::new(width - 2.4, depth - 2.4, 40.0), 0.6, 0.3), [0.0, 0.0, 2.0], &inside);
    // Flap, folded up and back.
    let flap = pitched(rounded_block(DVec3::new(width - 2.0, 1.6, 32.0), 0.7, 0.4), -24.0);
    object.put(flap, [0.0, 0.5 * depth - 1.0, back - 1.5], &card);
    let accent = Rgb::hex([0x2f7a3c, 0x2c4fa0, 0xc8302c][order.pick(3)]);
    let paper =
        Material::textured("label", label(order.color.scaled(1.05), accent, "CRAYON", &mut order.rng), 0.6);
    object.put(front_plate(width - 4.0, front - 6.0, 1.4), [0.0, -0.5 * depth + 0.1, 0.5 * front], &paper);
    let colors = [
        0xd82c2c, 0xf07c1e, 0xf4d028, 0x8ac038, 0x2f8a48, 0x26a0b0, 0x2c5cc0, 0x5a3aa0, 0xc03a8a, 0x8a5a32,
        0x2a2a2e, 0xf08aa8,
    ];
    let first = order.pick(12);
    for k in 0..12 {
        let (column, row) = (k % 6, k / 6);
        let color = Rgb::hex(colors[(first + k * 5) % 12]);
        let wax = Material::plain("crayon", color, 0.6);
        let top = 88.0 + 9.0 * row as f64 + order.uniform(-1.5, 1.5);
        let stick = points(&[
            (0.0, 30.0),
            (4.9, 30.0),
            (4.9, top - 9.0),
            (4.2, top - 8.6),
            (3.8, top - 7.0),
            (1.7, top),
            (0.0, top),
        ]);
        let (x, y) = (-29.5 + 11.8 * column as f64, -6.4 + 12.4 * row as f64);
        object.put(lathe(&stick, 14), [x, y, 0.0], &wax);
        let sleeve = Material::plain("sleeve", color.mix(Rgb::hex(0xffffff), 0.25), 0.85);
        object.put(prism(&circle(5.3, 14), top - 50.0), [x, y, 38.0], &sleeve);
    }
    object.fitted(order.size_m)
}

/// Color pencil along y on a flat of its hexagon, sharpened at +y.
pub(super) fn color_pencil(order: &mut Order) -> TexturedMesh {
    let mut object = Assembly::new();
    let lacquer = match order.material {
        Some(_) => main_finish(order, "wood"),
        None => Material::plain("lacquer", order.color, 0.25),
    };
    let bare = Material::plain("cedar", Rgb::hex(0xdcb482), 0.7);
    let core = Material::plain("core", order.color.scaled(0.95), 0.6);
    let hexagon = regular_polygon(3.8, 6);
    object.put(along_y(prism(&hexagon, 148.0)), [0.0, -88.0, 0.0], &lacquer);
    // Dipped end with two rings, each a hair wider than the body.
    let gold = Material::metal("gold", Rgb::hex(0xd8b048), 0.3);
    let white = Material::plain("dip", Rgb::hex(0xf4f2ec), 0.3);
    let ring = |radius: f64, length: f64| along_y(prism(&regular_polygon(radius, 6), length));
    object.put(ring(3.95, 12.0), [0.0, -89.0, 0.0], if order.pick(2) == 0 { &white } else { &lacquer });
    object.put(ring(4.02, 2.0), [0.0, -77.6, 0.0], &gold);
    object.put(ring(4.02, 1.2), [0.0, -73.6, 0.0], &gold);
    // The lacquer ends in scallops: lobes reach further back on the flats.
    let cone = [(0.0, 0.0), (3.7, 0.0), (3.25, 2.5), (1.25, 17.0), (0.0, 17.0)];
    object.put(along_y(lobed(&cone, 6, 0.045, 36)), [0.0, 58.0, 0.0], &bare);
    let point = points(&[(0.0, 0.0), (1.55, 0.0), (0.5, 8.0), (0.0, 8.6)]);
    object.put(along_y(lathe(&point, 24)), [0.0, 72.6, 0.0], &core);
    let end = Material::plain("core_end", order.color.scaled(0.9), 0.6);
    object.put(along_y(cylinder(1.6, 1.5, 0.2, 20)), [0.0, -89.6, 0.0], &end);
    let mut print = Image::filled(256, 64, order.color.to_rgba8());
    draw_text(&mut print, "COLOR", 40, 11, 6, Rgb::hex(0xf0d890));
    let stamp = Material::textured("stamp", Texture::new(print), 0.3);
    object.put(yawed(print_plate(30.0, 3.0, 1.2), -90.0), [0.0, -40.0, 2.5], &stamp);
    object.fitted(order.size_m)
}

/// Felt marker along y, cap with clip at +y, color on cap and end plug.
pub(super) fn marker(order: &mut Order) -> TexturedMesh {
    let mut object = Assembly::new();
    let ink = main_finish(order, "plastic");
    let barrel = if order.pick(2) == 0 {
        Material::plain("barrel", Rgb::hex(0xeceae4), 0.35)
    } else {
        Material::plain("barrel", Rgb::hex(0x2e3034), 0.4)
    };
    let floor = -8.0;
    let lay = |solid| resting(along_y(solid), floor);
    let body = points(&[
        (0.0, -68.0),
        (6.0, -68.0),
        (7.6, -66.0),
        (8.6, -60.0),
        (8.6, 26.0),
        (8.0, 30.0),
        (0.0, 30.0),
    ]);
    object.put(lay(lathe(&body, 36)), [0.0; 3], &barrel);
    object.put(
        lay(lathe(&points(&[(0.0, -71.0), (4.5, -71.0), (6.6, -69.0), (6.6, -64.0), (0.0, -64.0)]), 28)),
        [0.0; 3],
        &ink,
    );
    let word = ["MARKER", "INK", "FELT"][order.pick(3)];
    let paper =
        Material::textured("label", wrap_label(Rgb::hex(0xf6f4ee), order.color, word, &mut order.rng), 0.45);
    // The word's center faces up once the barrel lies down.
    let sleeve = yawed(wrapped_around(prism(&circle(8.9, 36), 56.0)), 0.0);
    object.put(lay(sleeve.translated(DVec3::Z * -44.0)), [0.0; 3], &paper);
    let cap = points(&[
        (0.0, 20.0),
        (9.0, 20.0),
        (9.4, 21.0),
        (9.4, 30.0),
        (9.0, 60.0),
        (8.0, 67.0),
        (6.0, 70.0),
        (0.0, 70.0),
    ]);
    object.put(lay(lathe(&cap, 36)), [0.0; 3], &ink);
    let clip = rounded_block(DVec3::new(4.6, 38.0, 2.2), 1.6, 0.7);
    object.put(clip, [0.0, 44.0, 10.0], &ink);
    object.put(rounded_block(DVec3::new(4.6, 7.0, 4.6), 1.6, 0.7), [0.0, 60.0, 7.0], &ink);
    let plate = rounded_rectangle(3.0, 10.0, 1.2, 3);
    object.put(prism(&plate, 1.4), [0.0, 32.0, 11.4], &barrel);
    object.fitted(order.size_m)
}

/// A row of discs, for boxes of loose objects: 128 px, repeats.
pub(super) fn beads_image(colors: &[Rgb], order: &mut Order) -> Texture {
    let mut image = Image::filled(128, 128, colors[0].scaled(0.45).to_rgba8());
    for k in 0..64 {
        let (x, y) =
            (8 + 16 * (k % 8) + order.pick(5) as i32 - 2, 8 + 16 * (k / 8) + order.pick(5) as i32 - 2);
        let color = colors[order.pick(colors.len())];
        fill_disc(&mut image, x, y, 8, color);
        fill_disc(&mut image, x - 2, y - 3, 2, color.mix(Rgb([1.0; 3]), 0.55));
    }
    Texture::new(image)
}
