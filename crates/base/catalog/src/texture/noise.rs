//! Periodic value noise: a lattice of random numbers, smoothly interpolated, wrapped at its edges.

use rand::RngExt;

use runtime::seed::Rng;

/// Smooth random numbers 0..1 over the unit square; opposite edges match.
#[derive(Clone, Debug)]
pub struct Noise {
    columns: usize,
    rows: usize,
    values: Vec<f32>,
}

impl Noise {
    /// `columns` x `rows` bumps over the square (both at least 1).
    pub fn new(columns: usize, rows: usize, rng: &mut Rng) -> Self {
        let values = (0..columns * rows).map(|_| rng.random_range(0.0..1.0)).collect();
        Self { columns, rows, values }
    }

    /// The value at (u, v); any real coordinates.
    pub fn at(&self, u: f32, v: f32) -> f32 {
        let x = wrapped(u) * self.columns as f32;
        let y = wrapped(v) * self.rows as f32;
        let (i, j) = (x as usize, y as usize);
        let ease = |t: f32| t * t * (3.0 - 2.0 * t);
        let (fx, fy) = (ease(x - i as f32), ease(y - j as f32));
        let node = |k: usize, count: usize| if k < count { k } else { k % count };
        let value =
            |i: usize, j: usize| self.values[node(j, self.rows) * self.columns + node(i, self.columns)];
        let low = value(i, j) + (value(i + 1, j) - value(i, j)) * fx;
        let high = value(i, j + 1) + (value(i + 1, j + 1) - value(i, j + 1)) * fx;
        low + (high - low) * fy
    }
}

/// The equivalent coordinate in 0..=1: `rem_euclid(1.0)` without a function call, because textures need it millions of
/// times.
#[inline]
fn wrapped(c: f32) -> f32 {
    /// Larger numbers are integers.
    const WHOLE: f32 = 8_388_608.0;
    if c.abs() >= WHOLE {
        return 0.0;
    }
    let rest = c - (c as i32) as f32;
    if rest < 0.0 { rest + 1.0 } else { rest }
}

#[cfg(test)]
mod tests {
    use super::*;
    use runtime::seed::child_rng;

    #[test]
    fn wrapping_equals_the_euclidean_remainder() {
        for c in [0.0, -0.0, 0.25, 1.0, 7.75, -0.25, -3.0, -1e-9, 8_388_607.5, -8_388_607.5, 1e12, -1e30_f32]
        {
            assert_eq!(wrapped(c), c.rem_euclid(1.0), "{c}");
        }
    }

    #[test]
    fn noise_is_periodic_and_stays_in_range() {
        let noise = Noise::new(5, 3, &mut child_rng(1, "noise"));
        for k in 0..20 {
            let t = k as f32 / 20.0;
            assert!((noise.at(0.0, t) - noise.at(1.0, t)).abs() < 1e-5);
            assert!((noise.at(t, 0.0) - noise.at(t, 1.0)).abs() < 1e-5);
            assert!((0.0..=1.0).contains(&noise.at(t, 0.3)));
        }
    }
}
