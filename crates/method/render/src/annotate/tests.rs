//! Lines, boxes, text and sheets change exactly the expected pixels.

use glam::DVec2;

use super::*;
use imaging::Mask;

const WHITE: [u8; 4] = [255; 4];
const RED: [u8; 4] = [255, 0, 0, 255];

#[test]
fn draw_line_covers_pixels_on_it_only() {
    let mut image = Image::filled(40, 20, WHITE);
    draw_line(&mut image, DVec2::new(5.0, 10.0), DVec2::new(35.0, 10.0), RED, 2.0);
    assert_eq!(image.pixel(20, 10), RED);
    assert_eq!(image.pixel(20, 13), WHITE);
    draw_line(&mut image, DVec2::new(-1e9, 0.0), DVec2::new(f64::NAN, 3.0), RED, 2.0);
}

#[test]
fn draw_mask_outline_and_draw_box_leave_interior_unchanged() {
    let mask = Mask::from_fn(20, 20, |x, y| (5..15).contains(&x) && (5..15).contains(&y));
    let mut image = Image::filled(20, 20, WHITE);
    draw_mask_outline(&mut image, &mask, RED, 1);
    assert_eq!((image.pixel(5, 9), image.pixel(9, 9), image.pixel(4, 9)), (RED, WHITE, WHITE));
    draw_box(&mut image, [0, 0, 20, 20], RED, 1);
    assert_eq!((image.pixel(0, 7), image.pixel(1, 7)), (RED, WHITE));
}

#[test]
fn draw_text_marks_only_its_width() {
    let mut image = Image::filled(60, 12, WHITE);
    draw_text(&mut image, 2, 2, "A-7\u{e9}", 1, RED);
    let right = (0..60).filter(|&x| (0..12).any(|y| image.pixel(x, y) == RED)).max().expect("ink");
    assert!(right >= 2 + 18 && right < 2 + text_width_px("A-7?", 1));
}

#[test]
fn sheet_contains_every_image_and_fitted_keeps_mean() {
    let red = Image::filled(30, 20, RED);
    let page = sheet(&[(&red, "one"), (&red, "two"), (&red, "three")], 2, 50);
    let count = page.as_rgba().chunks_exact(4).filter(|p| *p == RED).count();
    assert_eq!(count, 3 * 50 * 33);
    let row = side_by_side(&[&red, &Image::filled(60, 40, WHITE)]);
    assert_eq!((row.width_px(), row.height_px()), (66, 20));
    let checks: Vec<u8> =
        (0..64 * 64).flat_map(|k| [if (k + k / 64) % 2 == 0 { 255 } else { 0 }; 4]).collect();
    let checks = Image::from_rgba(64, 64, checks).expect("64 x 64");
    let small = fitted(&checks, 10, 10);
    assert!(small.as_rgba().iter().all(|&c| (90..=165).contains(&c)));
}

#[test]
fn plot_curves_draws_its_curve() {
    let points: Vec<(f64, f64)> = (0..50).map(|k| (f64::from(k), (f64::from(k) * 0.2).sin())).collect();
    let curve = Curve { points: &points, marks: &[(10.0, 0.9)], color: RED };
    let image = plot_curves(300, 160, "loss", &[curve]);
    assert!(image.as_rgba().chunks_exact(4).filter(|p| *p == RED).count() > 100);
    let empty = plot_curves(80, 60, "", &[Curve { points: &[], marks: &[], color: RED }]);
    assert_eq!(empty.width_px(), 80);
}
