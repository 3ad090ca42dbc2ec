//! Sobel gradients of a gray-scale image.

/// Horizontal and vertical Sobel derivative divided by 8, so that a ramp of 1 per pixel gives 1. Border
/// pixels are repeated.
pub fn sobel(gray: &[f32], width_px: usize, height_px: usize) -> (Vec<f32>, Vec<f32>) {
    let (mut dx, mut dy) = (vec![0.0; gray.len()], vec![0.0; gray.len()]);
    for y in 0..height_px {
        let rows = [y.saturating_sub(1), y, (y + 1).min(height_px - 1)]
            .map(|v| &gray[v * width_px..(v + 1) * width_px]);
        for x in 0..width_px {
            let (l, r) = (x.saturating_sub(1), (x + 1).min(width_px - 1));
            let column = |u: usize| rows[0][u] + 2.0 * rows[1][u] + rows[2][u];
            let row = |v: usize| rows[v][l] + 2.0 * rows[v][x] + rows[v][r];
            dx[y * width_px + x] = 0.125 * (column(r) - column(l));
            dy[y * width_px + x] = 0.125 * (row(2) - row(0));
        }
    }
    (dx, dy)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sobel_of_a_ramp_is_its_slope() {
        let gray: Vec<f32> = (0..8 * 6).map(|k| 2.0 * (k % 8) as f32 - 3.0 * (k / 8) as f32).collect();
        let (dx, dy) = sobel(&gray, 8, 6);
        assert!((dx[3 * 8 + 4] - 2.0).abs() < 1e-6 && (dy[3 * 8 + 4] + 3.0).abs() < 1e-6);
    }
}
