//! A picture twice: with what was painted and with what was read drawn on it.

use glam::DVec2;

use super::reading::TableRead;
use crate::synthetic::Painting;
use imaging::{Image, Mask};
use render::overlay::{draw_mask_outline, draw_polyline, side_by_side, tint_mask};

/// Left the truth, right the reading, or the bare picture where it was refused.
pub fn sheet(painting: &Painting, read: Option<&TableRead>) -> Image {
    let truth = &painting.truth;
    let masks: Vec<Mask> = (0..truth.objects.len()).map(|k| painting.labels.object(k)).collect();
    let left = drawn(&painting.picture, &truth.table.outline_px, &masks.iter().collect::<Vec<_>>());
    let right = read.map(|read| {
        drawn(
            &painting.picture,
            &read.outline_px,
            &read.things.iter().map(|thing| &thing.mask).collect::<Vec<_>>(),
        )
    });
    side_by_side(&[&left, right.as_ref().unwrap_or(&painting.picture)])
}

const COLORS: [[u8; 4]; 6] = [
    [230, 60, 60, 255],
    [50, 140, 230, 255],
    [40, 170, 80, 255],
    [240, 160, 30, 255],
    [160, 70, 200, 255],
    [20, 180, 180, 255],
];

fn drawn(picture: &Image, outline_px: &[DVec2], masks: &[&Mask]) -> Image {
    let mut image = picture.clone();
    for (mask, color) in masks.iter().zip(COLORS.iter().cycle()) {
        tint_mask(&mut image, mask, *color, 0.4);
        draw_mask_outline(&mut image, mask, *color, 2);
    }
    draw_polyline(&mut image, outline_px, true, [255, 0, 255, 255], 3.0);
    image
}
