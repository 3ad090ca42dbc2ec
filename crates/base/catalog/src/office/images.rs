//! Images on desk objects: screens, dials, covers, photographs, the map on a globe.

use rand::RngExt;
use std::f32::consts::TAU;

use crate::texture::{
    Noise, draw_text, draw_texture, fill_disc, fill_rectangle, frame_rectangle, text_width_px,
};
use geometry::Rgb;
use imaging::{Image, Texture};
use runtime::seed::Rng;

const APP_COLORS: [u32; 8] =
    [0x2f_7d_e0, 0xe0_4f_3a, 0x35_b0_5c, 0xf2_b5_33, 0x8a_55_d6, 0x1f_b5_c2, 0xe8_5a_9b, 0xf0_f0_f0];

/// Sky, sun, layers of mountains and water.
fn view(u: f32, v: f32, far: &Noise, near: &Noise, sky: Rgb, land: Rgb) -> Rgb {
    let (ridge, hill) = (0.42 + 0.3 * far.at(u, 0.1), 0.22 + 0.22 * near.at(u, 0.6));
    if v < 0.16 {
        sky.scaled(0.75 + 0.08 * (v * 160.0).sin())
    } else if v < hill {
        land.scaled(0.8)
    } else if v < ridge {
        land.mix(sky, 0.55)
    } else {
        let sun = ((u - 0.72).powi(2) + (v - 0.78).powi(2)).sqrt();
        let glow = Rgb([1.0, 0.95, 0.75]);
        if sun < 0.075 { glow } else { sky.mix(glow, 0.75 * (1.0 - (v - 0.4) / 0.7).clamp(0.0, 1.0)) }
    }
}

fn view_colors(rng: &mut Rng) -> (Rgb, Rgb) {
    let pairs = [
        (0x4f_9f_dc, 0x3c_7a_48),
        (0xe0_8a_5a, 0x5a_3f_66),
        (0x6f_b8_c8, 0x2f_5f_70),
        (0x5a_78_d0, 0x2f_6a_58),
    ];
    let (sky, land) = pairs[rng.random_range(0..pairs.len())];
    (Rgb::hex(sky), Rgb::hex(land))
}

/// A landscape photograph, 256 px.
pub fn landscape(rng: &mut Rng) -> Texture {
    let (far, near) = (Noise::new(5, 2, rng), Noise::new(4, 2, rng));
    let (sky, land) = view_colors(rng);
    draw_texture(256, 256, |u, v| view(u, v, &far, &near, sky, land))
}

/// A computer's desktop: wallpaper, icons, an open window, a task bar; 512 x 256 px.
pub fn desktop(rng: &mut Rng) -> Texture {
    let (far, near) = (Noise::new(5, 2, rng), Noise::new(4, 2, rng));
    let (sky, land) = view_colors(rng);
    let wallpaper = draw_texture(512, 256, |u, v| view(u, v, &far, &near, sky, land));
    let mut image = (*wallpaper).clone();
    for k in 0..4 {
        let color = Rgb::hex(APP_COLORS[rng.random_range(0..7)]);
        fill_rectangle(&mut image, 16, 18 + 50 * k, 26, 26, color);
        fill_rectangle(&mut image, 14, 48 + 50 * k, 30, 4, Rgb::hex(0xf4_f4_f4));
    }
    let (x, y, w, h) = (rng.random_range(90..150), rng.random_range(22..40), 270, 170);
    fill_rectangle(&mut image, x, y, w, h, Rgb::hex(0xf7_f7_f8));
    fill_rectangle(&mut image, x, y, w, 18, Rgb::hex(0x3a_44_55));
    for (k, color) in [0xe8_5a_4f, 0xf2_b5_33, 0x4f_b8_5a].into_iter().enumerate() {
        fill_disc(&mut image, x + 12 + 14 * k as i32, y + 9, 4, Rgb::hex(color));
    }
    fill_rectangle(&mut image, x, y + 18, 64, h - 18, Rgb::hex(0xdd_e2_ea));
    for k in 0..9 {
        fill_rectangle(&mut image, x + 8, y + 30 + 15 * k, rng.random_range(24..46), 5, Rgb::hex(0x7a_88_9c));
        let accent = if k % 4 == 0 { Rgb::hex(0x2f_6f_c8) } else { Rgb::hex(0x9a_a0_a8) };
        fill_rectangle(&mut image, x + 76, y + 30 + 15 * k, rng.random_range(70..180), 6, accent);
    }
    fill_rectangle(&mut image, 0, 238, 512, 18, Rgb::hex(0x1d_22_2c));
    for k in 0..7 {
        fill_rectangle(&mut image, 180 + 24 * k, 241, 13, 12, Rgb::hex(APP_COLORS[k as usize]));
    }
    Texture::new(image)
}

/// A telephone's or tablet's home screen: clock, rows of app icons, a dock; 256 x 512 px.
pub fn home_screen(columns: i32, rows: i32, rng: &mut Rng) -> Texture {
    let (low, high) = view_colors(rng);
    let blob = Noise::new(3, 4, rng);
    let wallpaper = draw_texture(256, 512, |u, v| low.mix(high, (0.9 * blob.at(u, v)).clamp(0.0, 1.0)));
    let mut image = (*wallpaper).clone();
    fill_rectangle(&mut image, 10, 6, 30, 6, Rgb::hex(0xff_ff_ff));
    fill_rectangle(&mut image, 216, 6, 28, 7, Rgb::hex(0xff_ff_ff));
    let time = format!("{}:{:02}", rng.random_range(1..13), rng.random_range(0..60));
    let scale = 7;
    draw_text(&mut image, &time, (256 - text_width_px(&time, scale)) / 2, 36, scale, Rgb::hex(0xff_ff_ff));
    let (pitch_x, pitch_y) = (228 / columns, 300 / rows);
    let (icon_x, icon_y) = (pitch_x * 2 / 3, pitch_y * 2 / 3);
    for row in 0..rows {
        for column in 0..columns {
            let color = Rgb::hex(APP_COLORS[rng.random_range(0..APP_COLORS.len())]);
            let (x, y) = (14 + pitch_x * column + (pitch_x - icon_x) / 2, 120 + pitch_y * row);
            fill_rectangle(&mut image, x, y, icon_x, icon_y, color);
            fill_disc(&mut image, x + icon_x / 2, y + icon_y / 2, icon_y / 5, color.scaled(0.6));
        }
    }
    fill_rectangle(&mut image, 10, 436, 236, 64, low.mix(Rgb([1.0; 3]), 0.55));
    for column in 0..4 {
        let color = Rgb::hex(APP_COLORS[column as usize]);
        fill_rectangle(&mut image, 24 + 56 * column, 448, 40, 40, color);
    }
    Texture::new(image)
}

/// A clock's dial with numerals, ticks and hands; 256 px, twelve at the top.
pub fn clock_dial(face: Rgb, ink: Rgb, rng: &mut Rng) -> Texture {
    let mut image = Image::filled(256, 256, face.to_rgba8());
    let spot = |angle: f32, radius: f32| {
        ((128.0 + radius * angle.sin()) as i32, (128.0 - radius * angle.cos()) as i32)
    };
    for minute in 0..60 {
        let (x, y) = spot(TAU * minute as f32 / 60.0, 114.0);
        fill_disc(&mut image, x, y, if minute % 5 == 0 { 4 } else { 1 }, ink);
    }
    for hour in 1..=12 {
        let (x, y) = spot(TAU * hour as f32 / 12.0, 90.0);
        let text = hour.to_string();
        draw_text(&mut image, &text, x - text_width_px(&text, 3) / 2, y - 10, 3, ink);
    }
    let hour = rng.random_range(0.0..12.0_f32);
    let hands = [
        (TAU * hour / 12.0, 56.0, 6, ink),
        (TAU * hour.fract(), 84.0, 4, ink),
        (TAU * 0.37, 88.0, 2, Rgb::hex(0xd0_3a_2a)),
    ];
    for (angle, reach, radius, color) in hands {
        for step in 0..90 {
            let (x, y) = spot(angle, reach * step as f32 / 90.0);
            fill_disc(&mut image, x, y, radius, color);
        }
    }
    fill_disc(&mut image, 128, 128, 9, ink);
    Texture::new(image)
}

/// A liquid-crystal display showing `text`; 256 x 64 px.
pub fn lcd(text: &str) -> Texture {
    let mut image = Image::filled(256, 64, Rgb::hex(0xb5_c4_a8).to_rgba8());
    let scale = 5;
    draw_text(&mut image, text, 246 - text_width_px(text, scale), 15, scale, Rgb::hex(0x20_28_20));
    Texture::new(image)
}

/// A book's front: title block, rules, emblem; 256 px.
pub fn book_cover(color: Rgb, rng: &mut Rng) -> Texture {
    let light = color.0.iter().sum::<f32>() > 1.6;
    let ink = if light { Rgb::hex(0x2a_24_22) } else { Rgb::hex(0xec_d8_9a) };
    let mut image = Image::filled(256, 256, color.to_rgba8());
    let titles =
        ["ATLAS", "PHYSICS", "THE SEA", "GARDEN", "POEMS", "HISTORY", "VOYAGE", "ALGEBRA", "COOKING"];
    let title = titles[rng.random_range(0..titles.len())];
    let style = rng.random_range(0..3);
    let scale = (200 / text_width_px(title, 1)).clamp(3, 6);
    let x = (256 - text_width_px(title, scale)) / 2;
    match style {
        0 => {
            frame_rectangle(&mut image, 14, 14, 228, 228, 4, ink);
            draw_text(&mut image, title, x, 50, scale, ink);
            fill_disc(&mut image, 128, 150, 38, ink);
            fill_disc(&mut image, 128, 150, 30, color);
            fill_disc(&mut image, 128, 150, 14, ink);
            fill_rectangle(&mut image, 78, 212, 100, 6, ink);
        }
        1 => {
            let accent = Rgb::hex(APP_COLORS[rng.random_range(0..6)]);
            fill_rectangle(&mut image, 0, 130, 256, 90, accent);
            let (far, near) = (Noise::new(5, 2, rng), Noise::new(4, 2, rng));
            let (sky, land) = view_colors(rng);
            for py in 0..90_u32 {
                for px in 0..256_u32 {
                    let shade = view(px as f32 / 256.0, 1.0 - py as f32 / 90.0, &far, &near, sky, land);
                    image.set_pixel(px, 130 + py, shade.to_rgba8());
                }
            }
            draw_text(&mut image, title, x, 40, scale, ink);
            fill_rectangle(&mut image, 60, 96, 136, 6, ink);
        }
        _ => {
            fill_rectangle(&mut image, 0, 24, 256, 86, ink);
            draw_text(&mut image, title, x, 50, scale, color);
            for k in 0..4 {
                fill_rectangle(&mut image, 40 + 44 * k, 140, 26, 84, ink.mix(color, 0.25 * k as f32));
            }
        }
    }
    Texture::new(image)
}

/// Edges of a block of pages: fine lines along u; 64 x 128 px.
pub fn page_edges(paper: Rgb, rng: &mut Rng) -> Texture {
    let tone = Noise::new(2, 60, rng);
    draw_texture(64, 128, |u, v| paper.scaled(0.82 + 0.2 * tone.at(u, v)))
}

/// A handwritten note on colored paper; 128 px.
pub fn note(paper: Rgb, rng: &mut Rng) -> Texture {
    let mut image = Image::filled(128, 128, paper.to_rgba8());
    let ink = Rgb::hex(0x2a_3a_6a);
    for line in 0..4 {
        let mut x = 14;
        let end = rng.random_range(70..114);
        while x < end {
            let y = 30 + 22 * line + rng.random_range(-3..4);
            fill_rectangle(&mut image, x, y, 5, 3, ink);
            fill_rectangle(&mut image, x + 3, y - 3, 2, 6, ink);
            x += rng.random_range(6..12);
        }
    }
    Texture::new(image)
}

/// Blossoms scattered over a ground color; 256 px, repeats.
pub fn blossoms(ground: Rgb, petal: Rgb, rng: &mut Rng) -> Texture {
    let mut image = Image::filled(256, 256, ground.to_rgba8());
    for k in 0..16 {
        let (x, y) =
            (32 + 64 * (k % 4) + rng.random_range(-10..10), 32 + 64 * (k / 4) + rng.random_range(-10..10));
        let (reach, turn) = (rng.random_range(10..15), rng.random_range(0.0..TAU));
        for leaf in 0..5 {
            let angle = turn + TAU * leaf as f32 / 5.0;
            let reach = reach as f32;
            fill_disc(
                &mut image,
                x + (reach * angle.cos()) as i32,
                y + (reach * angle.sin()) as i32,
                8,
                petal,
            );
        }
        fill_disc(&mut image, x, y, 6, Rgb::hex(0xf2_c8_3f));
    }
    Texture::new(image)
}

/// Expanded-metal lattice: dark openings between strands of `color`; 64 px, repeats.
pub fn lattice(color: Rgb) -> Texture {
    draw_texture(64, 64, |u, v| {
        let (a, b) = ((4.0 * (u + v)).fract(), (4.0 * (u - v) + 8.0).fract());
        let strand = a < 0.3 || b < 0.3;
        if strand { color } else { color.scaled(0.35) }
    })
}

/// Perforated loudspeaker cloth; 64 px, repeats.
pub fn grille(color: Rgb) -> Texture {
    draw_texture(64, 64, |u, v| {
        let (x, y) = ((8.0 * u).fract() - 0.5, (8.0 * v).fract() - 0.5);
        if x * x + y * y < 0.1 { color.scaled(0.4) } else { color }
    })
}

/// Leaf with a midrib and side veins along v; 64 x 128 px.
pub fn leaf(color: Rgb, rng: &mut Rng) -> Texture {
    let tone = Noise::new(3, 6, rng);
    draw_texture(64, 128, |u, v| {
        let across = (u - 0.5).abs();
        let vein = ((v - 0.9 * across) * 9.0).fract() < 0.12 || across < 0.03;
        color.scaled(0.86 + 0.25 * tone.at(u, v) + if vein { 0.22 } else { 0.0 })
    })
}

/// Coarse continents as (longitude, latitude) degrees.
const LANDS: &[&[(f32, f32)]] = &[
    &[
        (-168.0, 65.0),
        (-125.0, 70.0),
        (-95.0, 72.0),
        (-80.0, 63.0),
        (-60.0, 52.0),
        (-70.0, 43.0),
        (-81.0, 30.0),
        (-97.0, 27.0),
        (-95.0, 17.0),
        (-83.0, 9.0),
        (-105.0, 20.0),
        (-117.0, 33.0),
        (-124.0, 47.0),
        (-150.0, 59.0),
    ],
    &[
        (-80.0, 8.0),
        (-62.0, 10.0),
        (-50.0, 0.0),
        (-35.0, -7.0),
        (-40.0, -22.0),
        (-55.0, -34.0),
        (-66.0, -45.0),
        (-70.0, -55.0),
        (-75.0, -48.0),
        (-71.0, -20.0),
        (-81.0, -5.0),
    ],
    &[
        (-17.0, 15.0),
        (-10.0, 32.0),
        (10.0, 37.0),
        (32.0, 31.0),
        (43.0, 11.0),
        (51.0, 11.0),
        (40.0, -5.0),
        (38.0, -18.0),
        (30.0, -30.0),
        (20.0, -35.0),
        (13.0, -18.0),
        (9.0, 3.0),
        (-8.0, 5.0),
    ],
    &[
        (-9.0, 37.0),
        (-9.0, 43.0),
        (0.0, 47.0),
        (5.0, 53.0),
        (8.0, 58.0),
        (6.0, 62.0),
        (25.0, 71.0),
        (60.0, 69.0),
        (75.0, 73.0),
        (110.0, 75.0),
        (140.0, 72.0),
        (178.0, 68.0),
        (160.0, 60.0),
        (142.0, 54.0),
        (130.0, 42.0),
        (121.0, 38.0),
        (121.0, 28.0),
        (108.0, 20.0),
        (105.0, 9.0),
        (98.0, 10.0),
        (92.0, 22.0),
        (80.0, 8.0),
        (72.0, 20.0),
        (58.0, 25.0),
        (48.0, 30.0),
        (57.0, 18.0),
        (44.0, 13.0),
        (35.0, 30.0),
        (36.0, 37.0),
        (27.0, 38.0),
        (22.0, 37.0),
        (14.0, 45.0),
        (17.0, 40.0),
        (8.0, 44.0),
        (0.0, 39.0),
    ],
    &[
        (114.0, -22.0),
        (130.0, -12.0),
        (142.0, -11.0),
        (153.0, -27.0),
        (148.0, -38.0),
        (137.0, -35.0),
        (117.0, -35.0),
    ],
    &[(-55.0, 60.0), (-70.0, 77.0), (-35.0, 83.0), (-20.0, 73.0), (-42.0, 60.0)],
    &[(96.0, 5.0), (110.0, 2.0), (119.0, 5.0), (141.0, -3.0), (150.0, -10.0), (115.0, -8.0)],
];

/// A map of the earth, longitude along u and latitude along v; 512 x 256 px.
pub fn earth(sea: Rgb, rng: &mut Rng) -> Texture {
    let tone = Noise::new(12, 8, rng);
    draw_texture(512, 256, |u, v| {
        let (longitude, latitude) = (360.0 * u - 180.0, 180.0 * v - 90.0);
        let wobble = 4.0 * (tone.at(u, v) - 0.5);
        let inside = LANDS.iter().any(|land| contains(land, longitude + wobble, latitude - wobble));
        let grid = (longitude / 30.0 + 12.0).fract() < 0.02 || (latitude / 30.0 + 6.0).fract() < 0.03;
        if !(-70.0..=80.0).contains(&latitude) {
            Rgb::hex(0xee_ee_ea)
        } else if inside {
            let dry = (1.0 - (latitude.abs() - 23.0).abs() / 22.0).clamp(0.0, 1.0);
            Rgb::hex(0x62_9a_4a).mix(Rgb::hex(0xd2_b4_6c), dry * 0.85).scaled(0.9 + 0.2 * tone.at(v, u))
        } else if grid {
            sea.scaled(1.25)
        } else {
            sea
        }
    })
}

fn contains(polygon: &[(f32, f32)], x: f32, y: f32) -> bool {
    let mut inside = false;
    for (k, &(bx, by)) in polygon.iter().enumerate() {
        let (ax, ay) = polygon[(k + polygon.len() - 1) % polygon.len()];
        if (ay > y) != (by > y) && x < ax + (bx - ax) * (y - ay) / (by - ay) {
            inside = !inside;
        }
    }
    inside
}
