//! Paints and what they are used on: bottle, brush, palette, watercolor set, canvas. Model millimeters.

use glam::DVec3;

use crate::Order;
use crate::assembly::{
    Assembly, bar, black, grain_along_y, lobed, main_finish, pierced, pitched, points, print_plate, resting,
    turned_ring, wood, yawed,
};
use crate::texture::{Noise, draw_texture, fill_disc, fill_rectangle, wrap_label, wrapped_around};
use geometry::shapes::{circle, lathe, prism, rounded_block, smooth};
use geometry::{Material, Rgb, TexturedMesh};
use imaging::{Image, Texture};

const PIGMENTS: [u32; 12] = [
    0xd82c2c, 0xf07c1e, 0xf4d028, 0x8ac038, 0x2f8a48, 0x269aa8, 0x2c5cc0, 0x5a3aa0, 0xc03a8a, 0x8a5a32,
    0x222226, 0xf4f2ec,
];

/// Acrylic craft paint: bottle of the paint's color, label, flip cap.
pub(super) fn paint_bottle(order: &mut Order) -> TexturedMesh {
    let mut object = Assembly::new();
    let color = Material::plain("paint", order.color, 0.3);
    let body = points(&[
        (0.0, 0.0),
        (16.0, 0.0),
        (17.6, 1.6),
        (17.6, 60.0),
        (16.4, 65.0),
        (11.0, 70.0),
        (9.0, 71.5),
        (9.0, 75.0),
        (0.0, 75.0),
    ]);
    object.put(lathe(&body, 40), [0.0; 3], &color);
    let ground = Rgb::hex([0xf6f4ee, 0x26282c][order.pick(2)]);
    let word = ["ACRYL", "PAINT", "COLOR"][order.pick(3)];
    let paper = Material::textured("label", wrap_label(ground, order.color, word, &mut order.rng), 0.5);
    object.put(wrapped_around(prism(&circle(18.1, 40), 38.0)), [0.0, 0.0, 12.0], &paper);
    let cap = if order.pick(2) == 0 { black() } else { Material::plain("cap", Rgb::hex(0xf0eee8), 0.4) };
    let ribbed = [(0.0, 0.0), (13.0, 0.0), (13.0, 9.0), (12.0, 10.0), (0.0, 10.0)];
    object.put(lobed(&ribbed, 20, 0.03, 60), [0.0, 0.0, 72.0], &cap);
    let spout = points(&[(0.0, 0.0), (9.5, 0.0), (7.0, 8.0), (5.5, 13.0), (4.5, 14.0), (0.0, 14.0)]);
    object.put(lathe(&spout, 28), [0.0, 0.0, 81.5], &cap);
    object.fitted_round(order.size_m)
}

/// Flat artist's brush, bristles at +y, wet with paint.
pub(super) fn paintbrush(order: &mut Order) -> TexturedMesh {
    let mut object = Assembly::new();
    let handle_finish = match (order.material, order.pick(2)) {
        (Some(_), _) => main_finish(order, "wood"),
        (None, 0) => wood(order, 0xd0a460),
        _ => Material::plain("lacquer", order.color, 0.2),
    };
    let floor = -3.4;
    let handle = [
        (-118.0, 0.0, 0.0, 2.0, 2.0),
        (-116.0, 0.0, 0.0, 4.6, 4.6),
        (-80.0, 0.0, 0.0, 7.0, 7.0),
        (-40.0, 0.0, 0.0, 9.4, 9.4),
        (-8.0, 0.0, 0.0, 11.0, 10.4),
        (24.0, 0.0, 0.0, 8.6, 8.2),
        (36.0, 0.0, 0.0, 8.4, 7.4),
    ];
    object.put(grain_along_y(resting(bar(&handle, 2.0, 24), floor)), [0.0; 3], &handle_finish);
    let ferrule = Material::metal("ferrule", Rgb::hex(0xc8cace), 0.2);
    let sleeve = [
        (30.0, 0.0, 0.0, 9.6, 8.4),
        (36.0, 0.0, 0.0, 9.8, 8.4),
        (37.0, 0.0, 0.0, 10.6, 9.2),
        (39.0, 0.0, 0.0, 10.6, 9.2),
        (40.0, 0.0, 0.0, 10.2, 8.6),
        (58.0, 0.0, 0.0, 16.0, 7.2),
        (68.0, 0.0, 0.0, 16.0, 7.2),
    ];
    object.put(resting(bar(&sleeve, 2.6, 24), floor), [0.0; 3], &ferrule);
    let hair = Material::plain("bristles", Rgb::hex([0x8a5a30, 0xe6d6b0, 0x3a2a22][order.pick(3)]), 0.9);
    let tuft = [(66.0, 0.0, 0.0, 15.4, 6.8), (78.0, 0.0, -0.2, 17.6, 7.4), (90.0, 0.0, -0.4, 17.8, 6.8)];
    object.put(resting(bar(&tuft, 3.0, 24), floor), [0.0; 3], &hair);
    let wet = Material::plain("paint", Rgb::hex(PIGMENTS[order.pick(9)]), 0.25);
    let tip = [
        (86.0, 0.0, -0.4, 18.2, 7.4),
        (95.0, 0.0, -0.6, 17.4, 6.4),
        (103.0, 0.0, -1.4, 14.6, 4.4),
        (106.0, 0.0, -2.2, 10.0, 2.4),
    ];
    object.put(resting(bar(&tip, 3.0, 24), floor), [0.0; 3], &wet);
    object.fitted(order.size_m)
}

/// Painter's palette with a thumb hole and dabs of color.
pub(super) fn paint_palette(order: &mut Order) -> TexturedMesh {
    let mut object = Assembly::new();
    let board = match (order.material, order.pick(3)) {
        (Some(_), _) => main_finish(order, "birch"),
        (None, 0) => Material::plain("enamel", Rgb::hex(0xf0eee8), 0.25),
        _ => wood(order, 0xc8965a),
    };
    let outline = smooth(
        &points(&[
            (-132.0, -4.0),
            (-112.0, -58.0),
            (-56.0, -90.0),
            (8.0, -96.0),
            (40.0, -80.0),
            (62.0, -58.0),
            (92.0, -62.0),
            (122.0, -44.0),
            (136.0, 8.0),
            (116.0, 60.0),
            (62.0, 92.0),
            (-12.0, 100.0),
            (-82.0, 80.0),
            (-120.0, 44.0),
        ]),
        4,
    );
    let hole = |angle: f64| {
        let (sin, cos) = angle.sin_cos();
        1.0 / ((cos / 18.0).powi(2) + (sin / 13.0).powi(2)).sqrt()
    };
    let plate = pierced(&outline, (82.0, -18.0), hole, 7.0, 1.8, 60);
    object.put(plate.with_box_uvs(260.0), [0.0; 3], &board);
    let first = order.pick(PIGMENTS.len());
    for k in 0..8 {
        let angle = (62.0 + 24.0 * k as f64).to_radians();
        let (x, y) = (-6.0 + 100.0 * angle.cos(), 2.0 + 70.0 * angle.sin());
        let color = Material::plain("dab", Rgb::hex(PIGMENTS[(first + k) % PIGMENTS.len()]), 0.18);
        let size = order.uniform(26.0, 34.0);
        let dab =
            [(0.0, 0.0), (0.5 * size, 0.0), (0.47 * size, 3.0), (0.3 * size, 6.5), (3.0, 8.0), (0.0, 8.6)];
        let turn = order.uniform(0.0, 90.0);
        object.put(yawed(lobed(&dab, 3 + k % 3, 0.09, 30), turn), [x, y, 6.2], &color);
    }
    // A mixed smear in the center.
    for (dx, mix) in [(-26.0, 0.2), (4.0, 0.5), (30.0, 0.8)] {
        let a = Rgb::hex(PIGMENTS[(first + 1) % PIGMENTS.len()]);
        let b = Rgb::hex(PIGMENTS[(first + 6) % PIGMENTS.len()]);
        let smear = lobed(&[(0.0, 0.0), (20.0, 0.0), (18.0, 1.6), (0.0, 2.2)], 2, 0.22, 30);
        object.put(yawed(smear, 24.0), [dx - 8.0, -22.0, 6.0], &Material::plain("smear", a.mix(b, mix), 0.3));
    }
    object.fitted(order.size_m)
}

/// Watercolor box, lid leaning open behind two rows of pans and a brush.
pub(super) fn watercolor_set(order: &mut Order) -> TexturedMesh {
    let mut object = Assembly::new();
    let case = main_finish(order, "plastic");
    let white = Material::plain("enamel", Rgb::hex(0xf4f2ee), 0.25);
    object.put(rounded_block(DVec3::new(206.0, 104.0, 16.0), 7.0, 2.0), [0.0; 3], &case);
    object.put(rounded_block(DVec3::new(196.0, 94.0, 4.0), 5.0, 0.8), [0.0, 0.0, 13.0], &white);
    let rim = |width: f64| {
        [
            (0.5 * width - 1.4, 0.0),
            (0.5 * width + 0.6, 0.0),
            (0.5 * width + 0.6, 3.4),
            (0.5 * width - 1.4, 3.4),
        ]
    };
    for row in 0..2 {
        for column in 0..6 {
            let (x, y) = (-78.0 + 31.2 * f64::from(column), -29.0 + 58.0 * f64::from(row));
            let pigment = Material::plain("pan", Rgb::hex(PIGMENTS[(row * 6 + column) as usize]), 0.55);
            object.put(
                lathe(&points(&[(0.0, 0.0), (12.6, 0.0), (12.6, 2.4), (8.0, 1.8), (0.0, 1.6)]), 24),
                [x, y, 16.4],
                &pigment,
            );
            object.put(turned_ring(&rim(27.0), 24), [x, y, 16.2], &white);
        }
    }
    // The brush in its groove.
    let stick = [(-70.0, 0.0, 0.0, 3.0, 3.0), (10.0, 0.0, 0.0, 6.0, 6.0), (34.0, 0.0, 0.0, 5.0, 5.0)];
    let brush_finish = Material::plain("brush", order.color.mix(Rgb::hex(0xc8282c), 0.6), 0.3);
    object.put(yawed(bar(&stick, 2.0, 14), -90.0), [-8.0, 0.0, 19.4], &brush_finish);
    let ferrule = Material::metal("ferrule", Rgb::hex(0xd0d2d6), 0.2);
    object.put(
        yawed(bar(&[(30.0, 0.0, 0.0, 5.6, 5.6), (48.0, 0.0, 0.0, 5.6, 5.6)], 2.0, 14), -90.0),
        [-8.0, 0.0, 19.4],
        &ferrule,
    );
    let hair = [(46.0, 0.0, 0.0, 5.0, 5.0), (54.0, 0.0, 0.0, 6.0, 6.0), (66.0, 0.0, 0.0, 1.2, 1.2)];
    object.put(yawed(bar(&hair, 2.0, 14), -90.0), [-8.0, 0.0, 19.4], &black());
    // Lid.
    let lean = |solid| pitched(solid, -14.0);
    let hinge = [0.0, 51.0, 11.0];
    object.put(lean(rounded_block(DVec3::new(206.0, 7.0, 96.0), 3.0, 1.6)), hinge, &case);
    object.put(
        lean(rounded_block(DVec3::new(194.0, 4.0, 84.0), 1.5, 0.8).translated(DVec3::new(0.0, -2.6, 6.0))),
        hinge,
        &white,
    );
    for (k, x) in (0..3).zip([-62.0, 0.0, 62.0]) {
        let tint = Rgb::hex(PIGMENTS[(k * 3 + 1) as usize]).mix(Rgb([1.0; 3]), 0.72);
        let well = pitched(prism(&circle(24.0, 32), 2.0), 90.0).translated(DVec3::new(x, -3.4, 48.0));
        object.put(lean(well), hinge, &Material::plain("well", tint, 0.3));
    }
    object.fitted(order.size_m)
}

/// Stretched canvas lying flat with a painting on it.
pub(super) fn canvas_board(order: &mut Order) -> TexturedMesh {
    let mut object = Assembly::new();
    let cloth = Material::plain("canvas", Rgb::hex(0xeeeae0), 0.9);
    object.put(rounded_block(DVec3::new(250.0, 200.0, 17.4), 2.5, 1.5), [0.0; 3], &cloth);
    let image = match order.pick(3) {
        0 => landscape(order),
        1 => abstract_image(order),
        _ => flowers(order),
    };
    object.put(print_plate(246.0, 196.0, 2.0), [0.0, 0.0, 16.0], &Material::textured("painting", image, 0.6));
    object.fitted(order.size_m)
}

fn landscape(order: &mut Order) -> Texture {
    let (ridge, far, brush) = (
        Noise::new(5, 1, &mut order.rng),
        Noise::new(9, 1, &mut order.rng),
        Noise::new(60, 24, &mut order.rng),
    );
    let dusk = order.pick(2) == 0;
    let (high, low) = if dusk { (0x3a5a9a, 0xf4b07a) } else { (0x4a96d8, 0xd8ecf4) };
    let sun = (order.uniform(0.2, 0.8) as f32, order.uniform(0.66, 0.84) as f32);
    draw_texture(256, 256, |u, v| {
        let stroke = 0.93 + 0.14 * brush.at(u, v);
        let sky = Rgb::hex(low).mix(Rgb::hex(high), ((v - 0.4) / 0.6).clamp(0.0, 1.0));
        let distance = ((u - sun.0).powi(2) * 1.5 + (v - sun.1).powi(2)).sqrt();
        let color = if v < 0.30 + 0.10 * ridge.at(u, 0.0) {
            Rgb::hex(0x3f7a3c).mix(Rgb::hex(0xc8b84a), (v * 3.0 * far.at(2.0 * u, v)).clamp(0.0, 1.0))
        } else if v < 0.38 + 0.28 * far.at(u, 0.3) {
            Rgb::hex(0x4c5c82).mix(Rgb([1.0; 3]), if v > 0.52 { 0.75 } else { 0.1 })
        } else if distance < 0.085 {
            Rgb::hex(0xffeca0)
        } else {
            sky
        };
        color.scaled(stroke)
    })
}

fn abstract_image(order: &mut Order) -> Texture {
    let mut image = Image::filled(256, 256, Rgb::hex(0xeee6d2).to_rgba8());
    for k in 0..9 {
        let color = if k == 0 { order.color } else { Rgb::hex(PIGMENTS[order.pick(PIGMENTS.len())]) };
        let (x, y) = (order.pick(220) as i32, order.pick(220) as i32);
        if order.pick(2) == 0 {
            fill_disc(&mut image, x + 16, y + 16, 14 + order.pick(34) as i32, color);
        } else {
            fill_rectangle(&mut image, x, y, 30 + order.pick(80) as i32, 12 + order.pick(60) as i32, color);
        }
    }
    for _ in 0..3 {
        let (x, y) = (order.pick(256) as i32, order.pick(256) as i32);
        fill_rectangle(&mut image, x, 0, 4, 256, Rgb::hex(0x1c1c20));
        fill_rectangle(&mut image, 0, y, 256, 4, Rgb::hex(0x1c1c20));
    }
    Texture::new(image)
}

fn flowers(order: &mut Order) -> Texture {
    let mut image = Image::filled(256, 256, Rgb::hex(0xd8e4e0).to_rgba8());
    fill_rectangle(&mut image, 0, 190, 256, 66, Rgb::hex(0xb08052));
    for k in 0..6 {
        let x = 62 + 26 * k;
        fill_rectangle(&mut image, 104 + 8 * k, 90, 5, 90, Rgb::hex(0x3c8044));
        let y = 60 + (order.pick(40) as i32);
        let color = if k == 2 { order.color } else { Rgb::hex(PIGMENTS[order.pick(9)]) };
        for petal in 0..6 {
            let angle = f64::from(petal) * std::f64::consts::TAU / 6.0;
            fill_disc(
                &mut image,
                x + (15.0 * angle.cos()) as i32,
                y + (15.0 * angle.sin()) as i32,
                10,
                color,
            );
        }
        fill_disc(&mut image, x, y, 8, Rgb::hex(0xf6d84a));
    }
    fill_rectangle(&mut image, 92, 150, 72, 76, Rgb::hex(0x3a5a92));
    fill_rectangle(&mut image, 84, 144, 88, 12, Rgb::hex(0x4a6ca8));
    Texture::new(image)
}
