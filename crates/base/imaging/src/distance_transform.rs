//! Exact Euclidean distance to the nearest marked pixel.
//!
//! Felzenszwalb and Huttenlocher, "Distance transforms of sampled functions" (2012): first the distance along each
//! column, then the lower envelope of parabolas along each row. O(pixels).

/// Distance in pixels from each pixel center to the nearest marked one (row-major); infinite
/// everywhere if none is marked.
pub fn distance_transform(marked: &[bool], width_px: usize, height_px: usize) -> Vec<f32> {
    let mut squared = squared_in_columns(marked, width_px, height_px);
    if width_px == 0 || height_px == 0 {
        return squared;
    }
    let mut envelope = Envelope::new(width_px);
    squared.chunks_exact_mut(width_px).for_each(|row| envelope.transform(row));
    squared.into_iter().map(|d| if d >= 0.5 * FAR { f32::INFINITY } else { d.sqrt() }).collect()
}

/// Represents the square of an infinite distance.
const FAR: f32 = 1e20;

/// Squared distance to the nearest marked pixel of the same column, [`FAR`] in columns without one. Processes whole
/// rows, first downward, then upward.
fn squared_in_columns(marked: &[bool], width_px: usize, height_px: usize) -> Vec<f32> {
    // Distance to the nearest mark above; columns without one count on from a number far above any height.
    const NONE: f32 = 1e10;
    let mut steps: Vec<f32> = marked.iter().map(|&m| if m { 0.0 } else { NONE }).collect();
    for y in 1..height_px {
        let (above, row) = steps[(y - 1) * width_px..(y + 1) * width_px].split_at_mut(width_px);
        row.iter_mut().zip(above).for_each(|(here, above)| *here = here.min(*above + 1.0));
    }
    for y in (1..height_px).rev() {
        let (row, below) = steps[(y - 1) * width_px..(y + 1) * width_px].split_at_mut(width_px);
        row.iter_mut().zip(below).for_each(|(here, below)| *here = here.min(*below + 1.0));
    }
    steps.iter_mut().for_each(|d| *d = if *d < NONE { *d * *d } else { FAR });
    steps
}

/// Scratch space of the one-dimensional transform.
struct Envelope {
    values: Vec<f32>,
    /// Positions of the parabolas in the envelope, and where each begins to be the lowest.
    positions: Vec<usize>,
    begins: Vec<f32>,
}

impl Envelope {
    fn new(longest: usize) -> Self {
        Self { values: vec![0.0; longest], positions: vec![0; longest], begins: vec![0.0; longest + 1] }
    }

    /// d(p) = min over q of (p - q)^2 + f(q), in place.
    fn transform(&mut self, f: &mut [f32]) {
        let n = f.len();
        let values = &mut self.values[..n];
        values.copy_from_slice(f);
        let square = |q: usize| (q * q) as f32;
        let mut last = 0;
        self.positions[0] = 0;
        self.begins[0] = f32::NEG_INFINITY;
        self.begins[1] = f32::INFINITY;
        for q in 1..n {
            loop {
                let p = self.positions[last];
                let meet = ((values[q] + square(q)) - (values[p] + square(p))) / (2 * (q - p)) as f32;
                if meet > self.begins[last] || last == 0 {
                    if meet > self.begins[last] {
                        last += 1;
                    }
                    self.positions[last] = q;
                    self.begins[last] = if last == 0 { f32::NEG_INFINITY } else { meet };
                    self.begins[last + 1] = f32::INFINITY;
                    break;
                }
                last -= 1;
            }
        }
        let mut k = 0;
        for (p, out) in f.iter_mut().enumerate() {
            while self.begins[k + 1] < p as f32 {
                k += 1;
            }
            let q = self.positions[k];
            let d = p.abs_diff(q);
            *out = square(d) + values[q];
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn distance_transform_equals_brute_force(marks in proptest::collection::vec(proptest::bool::weighted(0.06), 17 * 11)) {
            let distances = distance_transform(&marks, 17, 11);
            for (k, &distance) in distances.iter().enumerate() {
                let (x, y) = ((k % 17) as f32, (k / 17) as f32);
                let nearest = (0..marks.len())
                    .filter(|&j| marks[j])
                    .map(|j| ((j % 17) as f32 - x).hypot((j / 17) as f32 - y))
                    .fold(f32::INFINITY, f32::min);
                prop_assert!(nearest == distance || (nearest - distance).abs() < 1e-4);
            }
        }
    }
}
