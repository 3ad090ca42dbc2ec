//! The descriptor agrees with a slow one in double precision, its derivative with that one's central differences.

use super::*;

const SIDE_PX: usize = 64;

/// Waves of color that fade toward a disk's rim, and slopes of equal form.
fn image() -> SoftImage<1> {
    let waves = |phase: f64| -> [Vec<f32>; CHANNELS] {
        let value = |at: usize, c: usize| {
            let (x, y) = ((at % SIDE_PX) as f64 - 31.0, (at / SIDE_PX) as f64 - 33.0);
            let weight = ((26.0 - x.hypot(y)) / 5.0).clamp(0.0, 1.0);
            let wave = 0.5 + 0.3 * (0.31 * x + phase * (1.0 + c as f64) * 0.2 * y + c as f64).sin();
            (weight * if c == CHANNELS - 1 { 1.0 } else { wave }) as f32
        };
        from_fn(|c| (0..SIDE_PX * SIDE_PX).map(|at| value(at, c)).collect())
    };
    SoftImage::of_planes(Grid::square(SIDE_PX), waves(0.7), [waves(-1.9)])
}

fn known(hidden: impl Fn(usize, usize) -> bool) -> KnownPixels {
    let plane = (0..SIDE_PX * SIDE_PX).map(|at| if hidden(at % SIDE_PX, at / SIDE_PX) { 0.0 } else { 1.0 });
    KnownPixels::new(Grid::square(SIDE_PX), plane.collect())
}

/// As the file's head says, pixel by pixel.
fn slowly(planes: &[Vec<f64>; CHANNELS], pixels: &KnownPixels) -> Vec<f64> {
    let known = |at: usize| f64::from(pixels.known[at]);
    let total = |c: usize| (0..SIDE_PX * SIDE_PX).map(|at| known(at) * planes[c][at]).sum::<f64>();
    let mean: [f64; 3] = from_fn(|c| total(c) / total(3));
    let off = |c: usize, at: usize| planes[c][at] - planes[3][at] * mean[c];
    let gray = |at: usize| (0..3).map(|c| f64::from(LUMA[c]) * off(c, at)).sum::<f64>();
    let (mut lines, mut colors) = (Vec::new(), Vec::new());
    let across = SIDE_PX / BLOCK_PX;
    for patch in 0..across * across {
        let (left, top) = (patch % across * BLOCK_PX, patch / across * BLOCK_PX);
        let all: Vec<usize> = (0..64).map(|k| (top + k / BLOCK_PX) * SIDE_PX + left + k % BLOCK_PX).collect();
        let mut harmonics = [0.0; LINES];
        for &at in &all {
            let (x, y) = (at % SIDE_PX, at / SIDE_PX);
            let border = x == 0 || y == 0 || x + 1 == SIDE_PX || y + 1 == SIDE_PX;
            let around = |at: usize| [at - 1, at + 1, at - SIDE_PX, at + SIDE_PX];
            if border || known(at) == 0.0 || around(at).iter().any(|&k| known(k) == 0.0) {
                continue;
            }
            let [gx, gy] = [1, SIDE_PX].map(|step| 0.5 * (gray(at + step) - gray(at - step)));
            let quiet = f64::from(QUIET);
            let square = gx * gx + gy * gy + quiet * quiet;
            let (c, s) = ((gx * gx - gy * gy) / square, 2.0 * gx * gy / square);
            for (sum, h) in harmonics.iter_mut().zip([1.0, c, s, c * c - s * s, 2.0 * c * s]) {
                *sum += (square.sqrt() - quiet) * h;
            }
        }
        lines.extend(harmonics.map(|h| h / (harmonics[0] + FEW_LINES).sqrt()));
        let sum = |of: &dyn Fn(usize) -> f64| all.iter().map(|&at| known(at) * of(at)).sum::<f64>();
        colors.extend((0..3).map(|c| sum(&|at| off(c, at)) / 64.0));
        let count = sum(&|_| 1.0);
        let center = sum(&gray) / count.max(1.0);
        let variance = sum(&|at| gray(at).powi(2)) / count.max(1.0) - center * center;
        colors.push(count / 64.0 * ((variance.max(0.0) + EVEN * EVEN).sqrt() - EVEN));
    }
    let unit = |half: Vec<f64>, faint: f64, share: f64| {
        let length = (half.iter().map(|v| v * v).sum::<f64>() + faint * faint).sqrt();
        half.into_iter().map(move |v| v * share.sqrt() / length).collect::<Vec<f64>>()
    };
    let mut all = unit(lines, FAINT_LINES, 1.0 - COLOR_SHARE);
    all.extend(unit(colors, FAINT_COLORS, COLOR_SHARE));
    all
}

#[test]
fn descriptor_agrees_with_reference_and_central_differences() {
    const STEP: f64 = 1e-5;
    let image = image();
    for pixels in [known(|_, _| false), known(|x, y| x > 20 && y > 40 || x == 13)] {
        let found = describe(&image, &pixels, &mut DescriptorRoom::default());
        let moved = |step: f64| -> [Vec<f64>; CHANNELS] {
            from_fn(|c| {
                let both = image.planes()[c].iter().zip(&image.slopes()[0][c]);
                both.map(|(value, slope)| f64::from(*value) + step * f64::from(*slope)).collect()
            })
        };
        let [behind, here, ahead] = [-STEP, 0.0, STEP].map(|step| slowly(&moved(step), &pixels));
        assert_eq!(found.values.len(), here.len());
        let length: f64 = here.iter().map(|v| v * v).sum();
        assert!(length > 0.5 && length < 1.0, "{length}");
        let largest =
            ahead.iter().zip(&behind).map(|(a, b)| (a - b).abs() / (2.0 * STEP)).fold(0.0, f64::max);
        for k in 0..here.len() {
            assert!((found.values[k] - here[k]).abs() < 1e-5, "{k}: {} {}", found.values[k], here[k]);
            let slope = (ahead[k] - behind[k]) / (2.0 * STEP);
            let off = (found.slopes[0][k] - slope).abs();
            assert!(off < 1e-3 * largest, "{k}: {} {slope} of {largest}", found.slopes[0][k]);
        }
    }
}

#[test]
fn squared_distance_derivative_is_correct() {
    const STEP: f64 = 1e-5;
    let (image, pixels) = (image(), known(|_, _| false));
    let found = describe(&image, &pixels, &mut DescriptorRoom::default());
    let turned = image.planes().clone().map(|plane| plane.into_iter().rev().collect());
    let other = SoftImage::of_planes(Grid::square(SIDE_PX), turned, []);
    let other = describe(&other, &pixels, &mut DescriptorRoom::default());
    let hints = found.squared_distance(&other);
    let at = |step: f64| {
        let moved = found.values.iter().zip(&found.slopes[0]).map(|(v, s)| v + step * s);
        moved.zip(&other.values).map(|(a, b)| (a - b) * (a - b)).sum::<f64>()
    };
    assert!((hints.value - at(0.0)).abs() < 1e-12 && hints.value > 0.1, "{hints:?}");
    let difference = (at(STEP) - at(-STEP)) / (2.0 * STEP);
    assert!((hints.slopes[0] - difference).abs() < 1e-6 * difference.abs(), "{hints:?} {difference}");
}

#[test]
fn descriptor_ignores_exposure_and_hidden_pixels() {
    let image = image();
    let hidden = |x: usize, y: usize| x > 36 && y < 30;
    let pixels = known(hidden);
    let described = |planes: [Vec<f32>; CHANNELS]| {
        let image = SoftImage::of_planes(Grid::square(SIDE_PX), planes, []);
        describe(&image, &pixels, &mut DescriptorRoom::default())
    };
    let plain = described(image.planes().clone());
    let mut other = image.planes().clone();
    for at in (0..SIDE_PX * SIDE_PX).filter(|at| hidden(at % SIDE_PX, at / SIDE_PX)) {
        (0..CHANNELS).for_each(|c| other[c][at] = (at * (c + 3) % 17) as f32 / 17.0);
    }
    assert_eq!(described(other), plain);
    let mut dim = image.planes().clone();
    dim[..3].iter_mut().flatten().for_each(|v| *v *= 0.7);
    let as_dim = described(dim);
    let distance = |a: &Descriptor<0>| a.squared_distance(&plain).value;
    let mirrored = image.planes().clone().map(|plane| {
        plane.chunks(SIDE_PX).flat_map(|row| row.iter().rev().copied().collect::<Vec<f32>>()).collect()
    });
    assert!(distance(&as_dim) < 0.05 * distance(&described(mirrored)), "{}", distance(&as_dim));
}
