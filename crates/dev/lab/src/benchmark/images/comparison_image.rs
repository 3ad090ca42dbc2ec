//! Side-by-side image of ground truth and estimate.

use glam::DVec2;

use super::estimate::TableEstimate;
use crate::synthetic_images::SyntheticImage;
use imaging::{Image, Mask};
use render::annotate::{draw_mask_outline, draw_polyline, side_by_side, tint_mask};

/// Left: the ground truth. Right: the estimate, or the plain image if it was refused.
pub fn comparison_image(sample: &SyntheticImage, read: Option<&TableEstimate>) -> Image {
    let truth = &sample.truth;
    let masks: Vec<Mask> = (0..truth.objects.len()).map(|k| sample.labels.object(k)).collect();
    let left = annotate(&sample.image, &truth.table.outline_px, &masks.iter().collect::<Vec<_>>());
    let right = read.map(|read| {
        annotate(
            &sample.image,
            &read.outline_px,
            &read.objects.iter().map(|object| &object.mask).collect::<Vec<_>>(),
        )
    });
    side_by_side(&[&left, right.as_ref().unwrap_or(&sample.image)])
}

const COLORS: [[u8; 4]; 6] = [
    [230, 60, 60, 255],
    [50, 140, 230, 255],
    [40, 170, 80, 255],
    [240, 160, 30, 255],
    [160, 70, 200, 255],
    [20, 180, 180, 255],
];

fn annotate(image: &Image, outline_px: &[DVec2], masks: &[&Mask]) -> Image {
    let mut canvas = image.clone();
    for (mask, color) in masks.iter().zip(COLORS.iter().cycle()) {
        tint_mask(&mut canvas, mask, *color, 0.4);
        draw_mask_outline(&mut canvas, mask, *color, 2);
    }
    draw_polyline(&mut canvas, outline_px, true, [255, 0, 255, 255], 3.0);
    canvas
}
