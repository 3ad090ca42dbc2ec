//! Openings of shapes whose cavities are known.

use super::*;
use crate::test_scenes::{hull_of_box, open_box};

#[test]
fn opening_of_box_has_its_inner_sides() {
    // 10 cm x 8 cm x 6 cm with walls of 4 mm and a floor of 5 mm.
    let opening = Opening::of_hulls(&open_box(DVec3::new(0.10, 0.08, 0.06), 0.004, 0.005)).expect("open");
    assert!((opening.rim_m - 0.06).abs() < 1e-9 && (opening.floor_m - 0.005).abs() < 1e-9);
    // Cells that the walls touch are not free: up to a cell of 1.4 mm on each side.
    let half_m = opening.hull_m.iter().fold(DVec2::ZERO, |half, corner| half.max(corner.abs()));
    assert!((half_m - DVec2::new(0.046, 0.036)).abs().max_element() < 0.003, "{half_m}");
    assert!((opening.volume_m3 / (0.092 * 0.072 * 0.055) - 1.0).abs() < 0.1, "{}", opening.volume_m3);
    assert!(opening.depth_inside_m(DVec3::new(0.0, 0.0, 0.03)) > 0.03);
    assert!(opening.depth_inside_m(DVec3::new(0.06, 0.0, 0.03)) < 0.0);
}

#[test]
fn walls_thinner_than_a_cell_hold_water() {
    let tray = Opening::of_hulls(&open_box(DVec3::new(0.40, 0.30, 0.03), 0.001, 0.002));
    assert!((tray.expect("a tray").rim_m - 0.03).abs() < 1e-9);
}

#[test]
fn solids_and_shallow_trays_have_no_opening() {
    assert_eq!(Opening::of_hulls(&[hull_of_box(DVec3::splat(0.05), DVec3::ZERO)]), None);
    assert_eq!(Opening::of_hulls(&open_box(DVec3::new(0.20, 0.20, 0.012), 0.004, 0.005)), None);
    assert_eq!(Opening::of_hulls(&[]), None);
}

#[test]
fn handle_above_the_opening_does_not_divide_it() {
    let mut hulls = open_box(DVec3::new(0.20, 0.16, 0.08), 0.004, 0.005);
    hulls.push(hull_of_box(DVec3::new(0.02, 0.16, 0.01), DVec3::new(0.0, 0.0, 0.15)));
    let opening = Opening::of_hulls(&hulls).expect("a basket");
    let (low, high) =
        opening.hull_m.iter().fold((DVec2::INFINITY, DVec2::NEG_INFINITY), |(low, high), &corner| {
            (low.min(corner), high.max(corner))
        });
    assert!(low.x < -0.09 && high.x > 0.09, "{low} {high}");
}
