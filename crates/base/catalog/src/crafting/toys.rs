//! Games and toys: dice, chess pawn, playing cards, building brick, teddy bear. Model millimeters.

use glam::{DQuat, DVec3, Vec2};

use crate::Order;
use crate::assembly::{Assembly, bar, main_finish, mirrored_x, pitched, points, resting, rolled, yawed};
use crate::texture::{draw_text, fill_disc, fill_rectangle, granite, stripes};
use geometry::shapes::{cylinder, ellipsoid, lathe, prism, rounded_block, rounded_rectangle, slab, sphere};
use geometry::{Material, Rgb, Solid, TexturedMesh};
use imaging::{Image, Texture};

/// Six-sided die; opposite faces add up to seven.
pub(super) fn dice(order: &mut Order) -> TexturedMesh {
    let mut object = Assembly::new();
    let [r, g, b] = order.color.0;
    let pip = if 0.3 * r + 0.6 * g + 0.1 * b > 0.55 { Rgb::hex(0x1a1a1e) } else { Rgb::hex(0xf8f6f0) };
    let ground = match order.material {
        Some(_) => main_finish(order, "plastic"),
        None => Material::plain("die", order.color, 0.25),
    };
    let tone = if ground.base_color_texture.is_some() { Rgb::hex(0xc49a62) } else { ground.base_color };
    let top = order.pick(6);
    // Faces +x, -x, +y, -y, +z, -z.
    let values = [
        [1, 6, 2, 5, 3, 4],
        [2, 5, 6, 1, 4, 3],
        [3, 4, 1, 6, 5, 2],
        [5, 2, 3, 4, 6, 1],
        [4, 3, 5, 2, 1, 6],
        [6, 1, 4, 3, 2, 5],
    ][top];
    let faces =
        Material { base_color_texture: Some(pips(values, tone, pip)), base_color: Rgb([1.0; 3]), ..ground };
    let cube = slab(&rounded_rectangle(18.0, 18.0, 3.4, 5), 18.0, 2.6);
    object.put(six_faces(cube), [0.0; 3], &faces);
    object.fitted(order.size_m)
}

/// The six faces side by side, each a cell of a 4 x 2 image; corners are split per face.
fn six_faces(solid: Solid) -> Solid {
    let (low, high) = solid
        .positions
        .iter()
        .fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), p| (low.min(*p), high.max(*p)));
    let mut split = Solid::default();
    for triangle in &solid.triangles {
        let [a, b, c] = triangle.map(|v| solid.positions[v as usize]);
        let normal = (b - a).cross(c - a);
        let size = normal.abs();
        let (cell, axes) = if size.z >= size.x && size.z >= size.y {
            (if normal.z > 0.0 { 4 } else { 5 }, (0, 1))
        } else if size.x >= size.y {
            (if normal.x > 0.0 { 0 } else { 1 }, (1, 2))
        } else {
            (if normal.y > 0.0 { 2 } else { 3 }, (0, 2))
        };
        let corner = Vec2::new((cell % 4) as f32, (cell / 4) as f32);
        let base = split.positions.len() as u32;
        for &v in triangle {
            let p = (solid.positions[v as usize] - low) / (high - low);
            let local =
                Vec2::new(p[axes.0] as f32, p[axes.1] as f32).clamp(Vec2::splat(0.02), Vec2::splat(0.98));
            split.positions.push(solid.positions[v as usize]);
            split.normals.push(solid.normals[v as usize]);
            split.uvs.push((corner + local) / Vec2::new(4.0, 2.0));
        }
        split.triangles.push([base, base + 1, base + 2]);
    }
    split
}

/// 512 x 256 px in cells of 128; cell k from the left, the second row of cells above the first.
fn pips(values: [i32; 6], ground: Rgb, ink: Rgb) -> Texture {
    let mut image = Image::filled(512, 256, ground.to_rgba8());
    for (k, value) in values.iter().enumerate() {
        let (x0, y0) = (128 * (k as i32 % 4), if k < 4 { 128 } else { 0 });
        let mut dot = |x: i32, y: i32| fill_disc(&mut image, x0 + 64 + 32 * x, y0 + 64 + 32 * y, 12, ink);
        if value % 2 == 1 {
            dot(0, 0);
        }
        if *value >= 2 {
            dot(-1, -1);
            dot(1, 1);
        }
        if *value >= 4 {
            dot(-1, 1);
            dot(1, -1);
        }
        if *value == 6 {
            dot(-1, 0);
            dot(1, 0);
        }
    }
    Texture::new(image)
}

/// Staunton pawn on a felt foot.
pub(super) fn chess_pawn(order: &mut Order) -> TexturedMesh {
    let mut object = Assembly::new();
    let finish = match order.material {
        Some(_) => main_finish(order, "wood"),
        None => Material::plain("lacquer", order.color, 0.25),
    };
    object.put(cylinder(14.2, 1.6, 0.2, 40), [0.0; 3], &Material::plain("felt", Rgb::hex(0x2f5a3c), 0.95));
    let mut body = vec![
        (0.0, 0.9),
        (15.0, 0.9),
        (16.0, 2.4),
        (16.0, 6.0),
        (14.8, 7.6),
        (12.6, 8.6),
        (13.8, 10.2),
        (13.6, 12.0),
        (11.4, 13.6),
        (8.8, 18.0),
        (6.8, 24.0),
        (5.8, 31.0),
        (5.6, 36.0),
        (9.8, 37.6),
        (10.2, 39.0),
        (9.4, 40.4),
        (6.4, 41.4),
    ];
    for k in 2..=9 {
        let angle = std::f64::consts::PI * (f64::from(k) / 9.0);
        if angle.sin() * 9.2 > 6.0 || k > 4 {
            body.push((9.2 * angle.sin(), 50.0 - 9.2 * angle.cos()));
        }
    }
    if let Some(top) = body.last_mut() {
        top.0 = 0.0;
    }
    object.put(lathe(&points(&body), 44), [0.0; 3], &finish);
    object.fitted_round(order.size_m)
}

/// Deck of playing cards, one face card on top.
pub(super) fn playing_cards(order: &mut Order) -> TexturedMesh {
    let mut object = Assembly::new();
    let edges = Material::textured("edges", stripes(Rgb::hex(0xfaf8f4), Rgb::hex(0xd8d4cc), 12), 0.8);
    let card = |thickness: f64| prism(&rounded_rectangle(63.0, 88.0, 4.0, 5), thickness);
    let mut z = 0.0;
    for k in 0..5 {
        let slip = if k == 0 { 0.0 } else { order.uniform(-2.2, 2.2) };
        let (x, y) = (order.uniform(-0.8, 0.8), order.uniform(-0.8, 0.8));
        object.put(yawed(card(3.6), slip), [x, y, z], &edges);
        z += 3.2;
    }
    let back = Material::textured("back", card_back(order.color), 0.5);
    object.put(yawed(card(1.4), 1.0), [0.0, 0.0, z - 0.4], &back);
    let suit = order.pick(4);
    let rank = ["A", "7", "K", "Q", "10"][order.pick(5)];
    let face = Material::textured("face", card_face(suit, rank), 0.5);
    let aside = order.uniform(16.0, 28.0);
    object.put(yawed(card(1.3), -aside), [4.0, -2.0, z + 0.6], &face);
    object.fitted(order.size_m)
}

fn card_back(color: Rgb) -> Texture {
    let mut image = Image::filled(128, 128, Rgb::hex(0xfaf8f4).to_rgba8());
    fill_rectangle(&mut image, 9, 7, 110, 114, color);
    let light = color.mix(Rgb([1.0; 3]), 0.7);
    for k in 0..22 {
        for step in 0..104 {
            let x = 13 + step;
            let y = 11 + (step + 10 * k) % 106;
            fill_rectangle(&mut image, x, y, 1, 1, light);
            fill_rectangle(&mut image, 115 - step, y, 1, 1, light);
        }
    }
    fill_disc(&mut image, 64, 64, 18, light);
    fill_disc(&mut image, 64, 64, 13, color);
    Texture::new(image)
}

/// Hearts, diamonds, clubs, spades.
fn card_face(suit: usize, rank: &str) -> Texture {
    let mut image = Image::filled(256, 256, Rgb::hex(0xfdfcf8).to_rgba8());
    let ink = if suit < 2 { Rgb::hex(0xc8202c) } else { Rgb::hex(0x18181c) };
    symbol(&mut image, suit, 128, 128, 46, ink);
    for (x, y) in [(30, 52), (226, 204)] {
        symbol(&mut image, suit, x, y + 24, 13, ink);
        let left = x - 6 * rank.len() as i32 * 2 + 3;
        draw_text(&mut image, rank, left, y - 32, 4, ink);
    }
    Texture::new(image)
}

fn symbol(image: &mut Image, suit: usize, x: i32, y: i32, size: i32, ink: Rgb) {
    let mut row = |dy: i32, half: i32| fill_rectangle(image, x - half, y + dy, 2 * half + 1, 1, ink);
    match suit {
        0 => {
            for k in 0..size * 5 / 4 {
                row(k - size / 4, size * (size * 5 / 4 - k) / (size * 5 / 4));
            }
        }
        1 => {
            for k in -size..=size {
                row(k, (size - k.abs()) * 3 / 4);
            }
        }
        _ => {
            for k in 0..size {
                row(k - size, if suit == 3 { k * 9 / 10 } else { 0 });
                row(k, size / 8 + k / 4);
            }
        }
    }
    match suit {
        0 => {
            for side in [-1, 1] {
                fill_disc(image, x + side * size / 2, y - size / 3, size / 2, ink);
            }
        }
        2 => {
            for (dx, dy) in [(-1, 1), (1, 1), (0, -2)] {
                fill_disc(image, x + dx * size / 2, y + dy * size / 4, size * 5 / 11, ink);
            }
        }
        3 => {
            for side in [-1, 1] {
                fill_disc(image, x + side * size / 2, y + size / 6, size * 5 / 11, ink);
            }
        }
        _ => {}
    }
}

/// Toy building brick with two by four studs.
pub(super) fn building_brick(order: &mut Order) -> TexturedMesh {
    let mut object = Assembly::new();
    let finish = match order.material {
        Some(_) => main_finish(order, "plastic"),
        None => Material::plain("brick", order.color, 0.22),
    };
    object.put(rounded_block(DVec3::new(31.8, 15.8, 9.6), 0.7, 0.35), [0.0; 3], &finish);
    let stud = lathe(&points(&[(0.0, 0.0), (2.45, 0.0), (2.45, 1.95), (2.2, 2.2), (0.0, 2.2)]), 28);
    for k in 0..8 {
        let (x, y) = (-12.0 + 8.0 * f64::from(k % 4), -4.0 + 8.0 * f64::from(k / 4));
        object.put(stud.clone(), [x, y, 9.1], &finish);
        object.put(
            cylinder(1.5, 1.0, 0.15, 16),
            [x, y, 10.5],
            &Material::plain("mark", order.color.scaled(0.86), 0.3),
        );
    }
    object.fitted(order.size_m)
}

/// Teddy bear sitting, legs toward -y.
pub(super) fn teddy_bear(order: &mut Order) -> TexturedMesh {
    let mut object = Assembly::new();
    let plush =
        |color: Rgb, order: &mut Order| Material::textured("plush", granite(color, &mut order.rng), 1.0);
    let fur = plush(order.color, order);
    let pale = plush(order.color.mix(Rgb::hex(0xf8ead0), 0.6), order);
    let dark = Material::plain("nose", Rgb::hex(0x241a16), 0.35);
    let floor = 5.0;
    let ball = |width: f64, depth: f64, height: f64, segments: usize| {
        ellipsoid(DVec3::new(width, depth, height), segments).translated(DVec3::NEG_Z * 0.5 * height)
    };
    object.put(resting(ball(88.0, 78.0, 104.0, 26).translated(DVec3::Z * 54.0), floor), [0.0; 3], &fur);
    object.put(ball(60.0, 20.0, 70.0, 20), [0.0, -32.0, 54.0], &pale);
    let head = DVec3::new(0.0, -4.0, 132.0);
    let at = |x: f64, y: f64, z: f64| (head + DVec3::new(x, y, z)).to_array();
    object.put(ball(84.0, 74.0, 74.0, 26), at(0.0, 0.0, 0.0), &fur);
    object.put(ball(40.0, 34.0, 30.0, 18), at(0.0, -32.0, -10.0), &pale);
    object.put(ball(15.0, 9.0, 11.0, 12), at(0.0, -48.0, -3.0), &dark);
    object.put(rounded_block(DVec3::new(2.4, 4.0, 9.0), 1.0, 0.6), at(0.0, -47.4, -16.0), &dark);
    object.put_pair(
        &ball(9.0, 6.0, 10.0, 12),
        at(15.0, -32.5, 9.0),
        &Material::plain("eye", Rgb::hex(0x120c0a), 0.1),
    );
    object.put_pair(&ball(32.0, 16.0, 32.0, 18), at(32.0, 2.0, 30.0), &fur);
    object.put_pair(&ball(20.0, 8.0, 20.0, 12), at(32.0, -5.0, 29.0), &pale);
    // Arms hang forward, legs lie toward the viewer, soles up.
    let arm = rolled(pitched(ball(30.0, 30.0, 66.0, 18), 24.0), -28.0);
    object.put_pair(&arm, [47.0, -16.0, 68.0], &fur);
    let leg = bar(
        &[
            (-36.0, 0.0, 0.0, 2.0, 2.0),
            (-34.0, 0.0, 0.0, 24.0, 26.0),
            (-28.0, 0.0, 0.0, 36.0, 40.0),
            (-18.0, 0.0, 0.0, 38.0, 40.0),
            (0.0, 0.0, 0.0, 33.0, 34.0),
            (18.0, 0.0, 0.0, 33.0, 34.0),
            (32.0, 0.0, 0.0, 20.0, 22.0),
            (36.0, 0.0, 0.0, 4.0, 4.0),
        ],
        2.0,
        20,
    );
    let right = resting(yawed(leg, 20.0).translated(DVec3::new(34.0, -40.0, 23.0)), floor);
    object.put(mirrored_x(right.clone()), [0.0; 3], &fur);
    object.put(right, [0.0; 3], &fur);
    let sole = yawed(ball(27.0, 7.0, 30.0, 14), 20.0).translated(DVec3::new(46.0, -73.0, 23.5));
    object.put_pair(&sole, [0.0; 3], &pale);
    // Bow tie.
    let ribbon = Material::plain("ribbon", Rgb::hex([0xc8283c, 0x2c5cb0, 0x2f8a58][order.pick(3)]), 0.7);
    let wing = slab(&points(&[(0.0, -4.0), (24.0, -12.0), (26.0, 0.0), (24.0, 12.0), (0.0, 4.0)]), 7.0, 2.0)
        .rotated(DQuat::from_rotation_x(std::f64::consts::FRAC_PI_2));
    object.put_pair(&wing, [0.0, -32.0, 99.0], &ribbon);
    object.put(sphere(6.5, 14), [0.0, -36.0, 92.5], &ribbon);
    object.fitted(order.size_m)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn die_faces_have_their_number_of_pips() {
        let image = pips([1, 6, 2, 5, 3, 4], Rgb([1.0; 3]), Rgb([0.0; 3]));
        let dark = |cell: i32| {
            let (x0, y0) = (128 * (cell % 4), if cell < 4 { 128 } else { 0 });
            (0..128 * 128)
                .filter(|k| image.pixel((x0 + k % 128) as u32, (y0 + k / 128) as u32)[0] == 0)
                .count()
        };
        let one = dark(0);
        for (cell, value) in [1, 6, 2, 5, 3, 4].into_iter().enumerate() {
            assert_eq!(dark(cell as i32), value * one, "face {cell}");
        }
    }
}
