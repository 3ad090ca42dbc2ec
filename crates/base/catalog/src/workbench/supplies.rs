//! Funnel, flashlight, wire spool. Model millimeters.

use glam::DVec3;

use crate::Order;
use crate::assembly::{
    Assembly, across_y, along_y, black, curve, lobed, main_finish, pierced, pitched, plastic, points,
    resting, turned_ring, wood, yawed,
};
use geometry::shapes::{circle, cylinder, ellipse, lathe, rounded_block, tube};
use geometry::{Material, Rgb, TexturedMesh};

/// Funnel on its wide rim, spout up, with a hanging tab.
pub(super) fn funnel(order: &mut Order) -> TexturedMesh {
    let mut object = Assembly::new();
    let finish = main_finish(order, "plastic");
    let wall = [
        (57.5, 0.0),
        (61.5, 0.0),
        (62.5, 1.5),
        (61.5, 3.5),
        (58.5, 4.5),
        (58.0, 14.0),
        (54.0, 20.0),
        (14.0, 62.0),
        (10.5, 68.0),
        (6.5, 112.0),
        (6.0, 113.0),
        (4.0, 113.0),
        (3.8, 112.0),
        (8.0, 67.0),
        (11.5, 60.0),
        (51.5, 18.0),
        (55.5, 13.0),
    ];
    object.put(turned_ring(&wall, 48), [0.0; 3], &finish);
    let fin = points(&[(7.0, 70.0), (16.0, 58.0), (32.0, 42.0), (14.0, 62.0), (8.4, 96.0)]);
    let fin_turn = order.uniform(0.0, 90.0);
    for k in 0..4 {
        object.put(yawed(across_y(&fin, 2.0, 0.0), fin_turn + 90.0 * f64::from(k)), [0.0; 3], &finish);
    }
    object.put(
        pierced(&ellipse(26.0, 24.0, 32), (2.0, 0.0), |_| 5.5, 3.6, 0.8, 32),
        [68.0, 0.0, 0.0],
        &finish,
    );
    object.fitted(order.size_m)
}

/// Flashlight lying on its head's and tail's flats, beam toward +y.
pub(super) fn flashlight(order: &mut Order) -> TexturedMesh {
    let mut object = Assembly::new();
    let body = match order.material {
        Some(_) => main_finish(order, "aluminum"),
        None => Material { metalness: 0.4, ..Material::plain("anodized", order.color, 0.38) },
    };
    // Tilted so that the wide head and the tail touch the table together.
    let floor = -14.4;
    let lay = |solid| resting(pitched(along_y(solid), 2.9), floor);
    let tube_profile = points(&[
        (0.0, 0.0),
        (13.5, 0.0),
        (15.5, 1.5),
        (15.5, 16.0),
        (13.5, 18.0),
        (13.5, 100.0),
        (14.5, 103.0),
        (20.5, 122.0),
        (22.6, 126.0),
        (22.6, 134.0),
        (21.4, 135.0),
        (21.4, 140.0),
        (22.6, 141.0),
        (22.6, 152.0),
        (20.0, 154.0),
        (20.0, 150.0),
        (0.0, 150.0),
    ]);
    object.put(lay(lathe(&tube_profile, 40)), [0.0; 3], &body);
    let knurl = [(0.0, 30.0), (13.6, 30.0), (14.2, 31.5), (14.2, 74.0), (13.6, 75.5), (0.0, 75.5)];
    object.put(lay(lobed(&knurl, 24, 0.025, 72)), [0.0; 3], &black());
    let reflector = Material::metal("reflector", Rgb::hex(0xe6e7e8), 0.12);
    object.put(
        lay(lathe(&points(&[(0.0, 148.0), (20.4, 148.0), (20.4, 151.0), (0.0, 151.0)]), 36)),
        [0.0; 3],
        &reflector,
    );
    let lens = Material::plain("lens", Rgb::hex(0xfff6cf), 0.08);
    object.put(
        lay(lathe(&points(&[(0.0, 149.0), (17.0, 149.0), (17.0, 152.0), (10.0, 153.4), (0.0, 154.0)]), 36)),
        [0.0; 3],
        &lens,
    );
    let button = pitched(rounded_block(DVec3::new(9.0, 17.0, 6.0), 4.0, 1.4), 2.9);
    object.put(button, [0.0, 87.0, 15.2], &Material::plain("button", Rgb::hex(0xc8422c), 0.6));
    object.put(
        pitched(rounded_block(DVec3::new(13.0, 24.0, 4.0), 5.0, 1.0), 2.9),
        [0.0, 87.0, 14.0],
        &black(),
    );
    object.put(lay(cylinder(10.0, 6.0, 1.5, 28).translated(DVec3::NEG_Z * 4.0)), [0.0; 3], &black());
    object.fitted(order.size_m)
}

/// Spool of wire standing on a flange.
pub(super) fn wire_spool(order: &mut Order) -> TexturedMesh {
    let mut object = Assembly::new();
    let flange = match (order.material, order.pick(3)) {
        (Some(_), _) => main_finish(order, "wood"),
        (None, 0) => wood(order, 0xc8a068),
        (None, 1) => black(),
        _ => plastic(Rgb::hex(0xe6e2d8)),
    };
    let bare = order.pick(3) == 0;
    let wire = if bare {
        Material::metal("copper", Rgb::hex(0xc87442), 0.3)
    } else {
        Material::plain("insulation", order.color, 0.35)
    };
    for z in [0.0, 56.0] {
        object.put(pierced(&circle(46.0, 40), (0.0, 0.0), |_| 11.0, 5.0, 1.2, 40), [0.0, 0.0, z], &flange);
    }
    let full = order.uniform(31.0, 40.0);
    let mut winding = vec![(0.0, 3.0), (full - 1.5, 3.0)];
    for k in 0..14 {
        let z = 5.0 + 3.75 * f64::from(k);
        winding.extend([(full - 1.6, z), (full, z + 1.8)]);
    }
    winding.extend([(full - 1.5, 58.0), (0.0, 58.0)]);
    object.put(lathe(&points(&winding), 36), [0.0; 3], &wire);
    let core = [(9.6, 0.6), (12.2, 0.6), (12.2, 60.4), (9.6, 60.4)];
    object.put(turned_ring(&core, 32), [0.0; 3], &flange);
    object.put(cylinder(10.4, 58.6, 0.0, 24), [0.0, 0.0, 0.8], &black());
    for k in 0..3 {
        let angle = f64::from(k) * 120.0;
        object.put(
            yawed(cylinder(4.5, 2.0, 0.3, 20).translated(DVec3::X * 28.0), angle),
            [0.0, 0.0, 59.5],
            &black(),
        );
    }
    // The free end leaves the winding and is bent up beside the flange.
    let end = curve(
        &[
            (0.0, 0.6 - full, 30.0),
            (14.0, -full - 0.6, 31.0),
            (30.0, -42.0, 36.0),
            (36.0, -37.0, 50.0),
            (34.0, -33.0, 66.0),
            (28.0, -27.0, 72.0),
        ],
        5,
    );
    object.put(tube(&end, 1.5, 10), [0.0; 3], &wire);
    object.fitted_round(order.size_m)
}
