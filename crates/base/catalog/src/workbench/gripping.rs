//! Gripping tools: wrenches, pliers, C-clamp, all lying flat. Model millimeters.

use glam::{DVec2, DVec3};

use crate::Order;
use crate::assembly::{
    Assembly, along_x, along_y, black, curve, lobed, main_finish, pierced, plastic, points, print_plate,
    resting, yawed,
};
use crate::texture::{draw_text, text_width_px};
use geometry::shapes::{
    circle, cylinder, lathe, prism, rectangle, rounded_block, slab, smooth, sphere, superellipse, sweep,
};
use geometry::{Material, Rgb, TexturedMesh};
use imaging::{Image, Texture};

/// Combination wrench: open end at +y, twelve-point ring at -y.
pub(super) fn wrench(order: &mut Order) -> TexturedMesh {
    let mut object = Assembly::new();
    let metal = metal_finish(order);
    let shaft = points(&[
        (-7.5, -70.0),
        (7.5, -70.0),
        (6.5, -30.0),
        (7.5, 20.0),
        (10.0, 66.0),
        (-10.0, 66.0),
        (-7.5, 20.0),
        (-6.5, -30.0),
    ]);
    object.put(slab(&shaft, 8.0, 2.0), [0.0, 0.0, 0.7], &metal);
    let size = ["10", "13", "17", "19"][order.pick(4)];
    let stamp = Material { metalness: 0.6, ..Material::textured("stamp", stamped(size), 0.5) };
    object.put(yawed(print_plate(70.0, 8.0, 2.0), 90.0), [0.0, -8.0, 7.2], &stamp);
    let ring = |angle: f64| 9.4 * (1.0 + 0.05 * (12.0 * angle).cos());
    object.put(pierced(&circle(16.0, 48), (0.0, 0.0), ring, 11.0, 1.4, 72), [0.0, -80.0, 0.0], &metal);
    let jaw = points(&[
        (0.0, -20.0),
        (12.0, -17.0),
        (19.5, -6.0),
        (20.0, 5.0),
        (15.5, 16.0),
        (8.5, 21.0),
        (8.5, -1.0),
        (4.0, -6.0),
        (-4.0, -6.0),
        (-8.5, -1.0),
        (-8.5, 21.0),
        (-15.5, 16.0),
        (-20.0, 5.0),
        (-19.5, -6.0),
        (-12.0, -17.0),
    ]);
    object.put(yawed(slab(&jaw, 10.0, 1.2), 15.0), [0.0, 80.0, 0.0], &metal);
    object.fitted(order.size_m)
}

/// Adjustable wrench, jaws at +y, with the knurled worm in its window.
pub(super) fn adjustable_wrench(order: &mut Order) -> TexturedMesh {
    let mut object = Assembly::new();
    let metal = metal_finish(order);
    let shaft = smooth(
        &points(&[
            (-10.0, -105.0),
            (0.0, -112.0),
            (10.0, -105.0),
            (11.5, -60.0),
            (9.5, 0.0),
            (11.0, 36.0),
            (-11.0, 36.0),
            (-9.5, 0.0),
            (-11.5, -60.0),
        ]),
        3,
    );
    object.put(pierced(&shaft, (0.0, -98.0), |_| 5.0, 11.5, 1.8, 40), [0.0; 3], &metal);
    let grip = Material { name: "grip".to_owned(), ..plastic(order.color) };
    if order.pick(2) == 0 {
        let sleeve = smooth(
            &points(&[
                (-13.0, -84.0),
                (0.0, -88.0),
                (13.0, -84.0),
                (12.6, -40.0),
                (11.0, -6.0),
                (-11.0, -6.0),
                (-12.6, -40.0),
            ]),
            3,
        );
        object.put(slab(&sleeve, 14.5, 3.0), [0.0; 3], &grip);
    } else {
        let panel = smooth(&points(&[(-5.5, -80.0), (5.5, -80.0), (5.0, -10.0), (-5.0, -10.0)]), 3);
        object.put(
            slab(&panel, 2.0, 0.4),
            [0.0, 0.0, 10.3],
            &Material::metal("panel", Rgb::hex(0x606368), 0.55),
        );
    }
    let head = points(&[
        (-10.0, 26.0),
        (10.0, 26.0),
        (21.0, 42.0),
        (25.0, 60.0),
        (4.0, 61.0),
        (-6.0, 64.0),
        (-6.0, 95.0),
        (-13.0, 100.0),
        (-23.0, 88.0),
        (-24.0, 52.0),
        (-18.0, 38.0),
    ]);
    object.put(slab(&head, 15.0, 1.6), [0.0; 3], &metal);
    let jaw = points(&[
        (4.0, 57.0),
        (25.5, 56.0),
        (28.0, 72.0),
        (21.0, 92.0),
        (13.0, 97.0),
        (7.5, 95.0),
        (7.5, 66.0),
    ]);
    object.put(slab(&jaw, 12.0, 1.4), [0.0, 0.0, 1.0], &metal);
    let window = rounded_block(DVec3::new(20.0, 11.0, 2.0), 2.0, 0.3);
    object.put(window, [6.0, 48.0, 13.5], &black());
    let worm = [(0.0, -8.0), (4.6, -8.0), (5.2, -6.0), (5.2, 6.0), (4.6, 8.0), (0.0, 8.0)];
    let worm_metal = Material::metal("worm", Rgb::hex(0x9a9ca0), 0.35);
    object.put(along_x(lobed(&worm, 12, 0.09, 48)), [6.0, 48.0, 12.5], &worm_metal);
    object.fitted(order.size_m)
}

/// Combination or long-nose pliers with dipped grips, jaws at +y.
pub(super) fn pliers(order: &mut Order) -> TexturedMesh {
    let mut object = Assembly::new();
    let metal = Material::metal("steel", Rgb::hex(0xa8aaae), 0.3);
    let grip = main_finish(order, "plastic");
    let long_nose = order.pick(2) == 0;
    let open = 0.7;
    let section = superellipse(12.0, 13.0, 3.2, 16);
    let handle = curve(
        &[(7.0, 6.0, 6.5), (13.0, -14.0, 6.5), (20.0, -48.0, 6.5), (21.0, -78.0, 6.5), (15.0, -112.0, 6.5)],
        5,
    );
    let rounded = |t: f64| if !(0.04..=0.99).contains(&t) { 0.8 } else { 1.0 - 0.12 * (t - 0.5).abs() };
    object.put_pair(&sweep(&handle, &section, DVec3::Z, rounded), [0.0; 3], &grip);
    let neck = curve(&[(-2.0, 30.0, 6.5), (4.0, 18.0, 6.5), (8.5, 2.0, 6.5), (14.0, -20.0, 6.5)], 4);
    object.put_pair(&sweep(&neck, &superellipse(9.0, 9.0, 4.0, 16), DVec3::Z, |_| 1.0), [0.0; 3], &metal);
    let jaw = if long_nose {
        points(&[(open, 20.0), (12.0, 22.0), (12.5, 34.0), (7.5, 52.0), (4.5, 96.0), (open, 97.0)])
    } else {
        points(&[(open, 20.0), (13.0, 22.0), (14.0, 36.0), (12.0, 50.0), (9.0, 74.0), (open, 75.0)])
    };
    object.put_pair(&slab(&jaw, 12.0, 1.6), [0.0; 3], &metal);
    let tooth = prism(&rectangle(4.2, 1.4), 2.2);
    let dark = Material::metal("teeth", Rgb::hex(0x404246), 0.5);
    let count = if long_nose { 9 } else { 6 };
    for k in 0..count {
        object.put(tooth.clone(), [0.0, 48.0 + 4.2 * f64::from(k), 10.4], &dark);
    }
    object.put(cylinder(15.0, 11.6, 1.4, 36), [0.0, 22.0, 0.0], &metal);
    object.put(cylinder(6.4, 3.0, 0.8, 24), [0.0, 22.0, 10.8], &dark);
    object.put(rounded_block(DVec3::new(9.0, 1.8, 1.2), 0.3, 0.2), [0.0, 22.0, 13.2], &metal);
    object.fitted(order.size_m)
}

/// C-clamp on its side: frame, threaded spindle with sliding T-bar toward -y, swivel pad.
pub(super) fn c_clamp(order: &mut Order) -> TexturedMesh {
    let mut object = Assembly::new();
    let frame_finish = match order.material {
        Some(_) => main_finish(order, "cast_iron"),
        None => Material::plain("enamel", order.color, 0.4),
    };
    let bright = Material::metal("spindle", Rgb::hex(0xb4b6ba), 0.3);
    let frame = points(&[
        (-42.0, -62.0),
        (-20.0, -70.0),
        (22.0, -70.0),
        (22.0, -50.0),
        (-14.0, -48.0),
        (-24.0, -38.0),
        (-27.0, 0.0),
        (-24.0, 44.0),
        (-14.0, 55.0),
        (20.0, 57.0),
        (20.0, 76.0),
        (-22.0, 76.0),
        (-42.0, 66.0),
        (-50.0, 30.0),
        (-50.0, -30.0),
    ]);
    object.put(slab(&frame, 17.0, 2.0), [0.0, 0.0, 0.0], &frame_finish);
    let web: Vec<DVec2> = points(&[
        (-37.0, -52.0),
        (-32.0, -30.0),
        (-33.5, 0.0),
        (-31.0, 40.0),
        (-34.0, 56.0),
        (-44.0, 28.0),
        (-44.0, -28.0),
    ]);
    object.put(
        slab(&web, 2.0, 0.3),
        [0.0, 0.0, 15.6],
        &Material::plain("web", order.color.scaled(0.72), 0.6),
    );
    let floor = -10.0;
    object.put(resting(along_y(cylinder(11.5, 32.0, 1.5, 28)), floor), [8.0, -76.0, 10.0], &frame_finish);
    object.put(resting(along_y(cylinder(11.5, 22.0, 1.0, 28)), floor), [8.0, 46.0, 10.0], &frame_finish);
    let mut spindle = vec![(0.0, -132.0), (7.4, -132.0), (8.4, -129.0), (8.4, -112.0), (6.2, -110.0)];
    let mut y = -108.0;
    while y < 14.0 {
        spindle.extend([(5.0, y), (6.4, y + 1.7)]);
        y += 3.4;
    }
    spindle.extend([(4.0, 16.0), (4.0, 20.0), (0.0, 20.0)]);
    object.put(along_y(lathe(&points(&spindle), 20)), [8.0, 0.0, 10.0], &bright);
    let pad = points(&[(0.0, 0.0), (6.0, 0.0), (7.0, 5.0), (11.5, 8.0), (11.5, 12.0), (0.0, 12.0)]);
    object.put(resting(along_y(lathe(&pad, 28)), floor), [8.0, 17.0, 10.0], &bright);
    let slide = [0.0, 12.0][order.pick(2)];
    object.put(along_x(cylinder(3.0, 66.0, 0.0, 14)), [8.0 - 33.0 + slide, -121.0, 10.0], &bright);
    for x in [-33.0, 33.0] {
        object.put(sphere(4.6, 14), [8.0 + x + slide, -121.0, 5.4], &bright);
    }
    object.fitted(order.size_m)
}

fn metal_finish(order: &mut Order) -> Material {
    match order.material {
        Some(_) => main_finish(order, "steel"),
        None => Material::metal("chrome", Rgb::hex(0xc6c8cc).mix(order.color, 0.05), 0.26),
    }
}

/// A gray plate with the size and a maker's word pressed into it.
fn stamped(size: &str) -> Texture {
    let mut image = Image::filled(256, 64, Rgb::hex(0xa6a8ac).to_rgba8());
    let text = format!("{size} CRV");
    let x = (256 - text_width_px(&text, 5)) / 2;
    draw_text(&mut image, &text, x, 15, 5, Rgb::hex(0x3a3c40));
    Texture::new(image)
}
