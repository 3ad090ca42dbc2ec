//! Contact sheets, image rows and resizing.

use super::{draw_text, text_width_px};
use imaging::Image;

/// Arranges images in a grid of `columns`, each fitted into a square cell of `cell_px` with its caption below.
pub fn sheet(images: &[(&Image, &str)], columns: usize, cell_px: u32) -> Image {
    let (columns, gap, caption) = (columns.max(1) as u32, 6, 14);
    let rows = (images.len() as u32).div_ceil(columns).max(1);
    let (step_x, step_y) = (cell_px + gap, cell_px + caption + gap);
    let mut page = Image::filled(columns * step_x + gap, rows * step_y + gap, [250, 250, 250, 255]);
    for (k, (image, label)) in images.iter().enumerate() {
        let (column, row) = (k as u32 % columns, k as u32 / columns);
        let (x, y) = (gap + column * step_x, gap + row * step_y);
        let small = fitted(image, cell_px, cell_px);
        let (dx, dy) = ((cell_px - small.width_px()) / 2, (cell_px - small.height_px()) / 2);
        paste(&mut page, &small, x + dx, y + dy);
        let room = (cell_px / 6) as usize;
        let text: String = label.chars().take(room).collect();
        let indent = cell_px.saturating_sub(text_width_px(&text, 1)) / 2;
        draw_text(&mut page, i64::from(x + indent), i64::from(y + cell_px + 4), &text, 1, [40, 40, 44, 255]);
    }
    page
}

/// Arranges images of any sizes in one row, all as high as the first.
pub fn side_by_side(images: &[&Image]) -> Image {
    let height = images.first().map_or(1, |p| p.height_px());
    let scaled: Vec<Image> = images.iter().map(|p| fitted(p, u32::MAX / 4, height)).collect();
    let gap = 6;
    let width = scaled.iter().map(|p| p.width_px() + gap).sum::<u32>().saturating_sub(gap).max(1);
    let mut page = Image::filled(width, height, [250, 250, 250, 255]);
    let mut x = 0;
    for image in &scaled {
        paste(&mut page, image, x, 0);
        x += image.width_px() + gap;
    }
    page
}

/// Resizes the image to fit the box with its proportions kept: averaged where it shrinks, bilinear where it grows.
pub fn fitted(image: &Image, max_width_px: u32, max_height_px: u32) -> Image {
    let (width, height) = (image.width_px().max(1), image.height_px().max(1));
    let scale =
        (f64::from(max_width_px) / f64::from(width)).min(f64::from(max_height_px) / f64::from(height));
    if (scale - 1.0).abs() < 1e-9 {
        return image.clone();
    }
    let new_width = ((f64::from(width) * scale).round() as u32).max(1);
    let new_height = ((f64::from(height) * scale).round() as u32).max(1);
    // Box filter at least one source pixel wide: sums over the source pixels, weighted by overlap.
    let spans = |new: u32, old: u32| -> Vec<Vec<(u32, f64)>> {
        let step = f64::from(old) / f64::from(new);
        let reach = 0.5 * step.max(1.0);
        (0..new)
            .map(|k| {
                let center = (f64::from(k) + 0.5) * step;
                let (low, high) = (center - reach, center + reach);
                let first = low.floor().max(0.0) as u32;
                let last = (high.ceil() as u32).min(old);
                let weight = |j: u32| (high.min(f64::from(j) + 1.0) - low.max(f64::from(j))).max(0.0);
                let total: f64 = (first..last).map(weight).sum();
                (first..last).map(|j| (j, weight(j) / total)).filter(|w| w.1 > 0.0).collect()
            })
            .collect()
    };
    let (columns, rows) = (spans(new_width, width), spans(new_height, height));
    let mut small = Image::filled(new_width, new_height, [0, 0, 0, 255]);
    for (y, row) in rows.iter().enumerate() {
        for (x, column) in columns.iter().enumerate() {
            let mut sum = [0.0; 4];
            for &(v, wy) in row {
                for &(u, wx) in column {
                    for (s, c) in sum.iter_mut().zip(image.pixel(u, v)) {
                        *s += wx * wy * f64::from(c);
                    }
                }
            }
            small.set_pixel(x as u32, y as u32, sum.map(|s| s.round() as u8));
        }
    }
    small
}

/// Copies `image` onto `page` with its top-left corner at (x, y), cut at the page's edge; where it is
/// transparent the page shows.
fn paste(page: &mut Image, image: &Image, x: u32, y: u32) {
    for v in 0..image.height_px().min(page.height_px().saturating_sub(y)) {
        for u in 0..image.width_px().min(page.width_px().saturating_sub(x)) {
            let color = image.pixel(u, v);
            if color[3] == 255 {
                page.set_pixel(x + u, y + v, color);
                continue;
            }
            super::blend(page, i64::from(x + u), i64::from(y + v), color, f64::from(color[3]) / 255.0);
        }
    }
}
