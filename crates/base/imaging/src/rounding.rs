//! Rounding and comparison for inner loops over pixels. Without SSE 4.1, `f32::floor` and `f32::ceil` are function
//! calls.

/// Largest integer not above `x`.
#[inline]
pub fn floor(x: f32) -> i32 {
    let truncated = x as i32;
    truncated - i32::from(truncated as f32 > x)
}

/// Smallest integer not below `x`, clamped to `0..=limit`; 0 for NaN. `limit` is below 2^22.
#[inline]
pub fn ceil_within(x: f32, limit: usize) -> usize {
    // The last bit of the sum is worth 1, so its mantissa holds the nearest integer without a checked conversion.
    const SHIFT: f32 = 8_388_608.0;
    let x = if x > 0.0 { x } else { 0.0 };
    let x = if x < limit as f32 { x } else { limit as f32 };
    let shifted = x + SHIFT;
    let nearest = (shifted.to_bits() - SHIFT.to_bits()) as usize;
    nearest + usize::from(shifted - SHIFT < x)
}

/// Largest integer not above `x`, clamped to `low..=high`, which are within 2^22 of 0; `low` for NaN.
#[inline]
pub fn floor_within(x: f32, low: f32, high: f32) -> i32 {
    // As above, with a shift 1.5 times as large, so that negative numbers keep the same exponent.
    const SHIFT: f32 = 12_582_912.0;
    let x = if x > low { x } else { low };
    let x = if x < high { x } else { high };
    let shifted = x + SHIFT;
    let nearest = shifted.to_bits().wrapping_sub(SHIFT.to_bits()) as i32;
    nearest - i32::from(shifted - SHIFT > x)
}

/// The smaller of two numbers as a single instruction; the second if either is NaN.
#[inline]
pub fn lesser(a: f32, b: f32) -> f32 {
    if a < b { a } else { b }
}

/// The larger of two numbers as a single instruction; the second if either is NaN.
#[inline]
pub fn greater(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Integers, halves and their neighbors, on both sides of 0 and beyond all bounds.
    fn numbers() -> impl Iterator<Item = f32> {
        let near = |x: f32| [x.next_down(), x, x.next_up()];
        let halves = (-4096..=4096).map(|k| 0.5 * k as f32);
        let far = [-1e30, -4e6, 4e6, 1e30, f32::INFINITY, f32::NEG_INFINITY];
        halves.chain(far).flat_map(near)
    }

    #[test]
    fn rounding_equals_the_standard_library_within_bounds() {
        for x in numbers() {
            assert_eq!(ceil_within(x, 777), x.ceil().clamp(0.0, 777.0) as usize, "{x}");
            for (low, high) in [(-1000.0, 1e6), (-4e6, 4e6), (3.0, 9.0)] {
                assert_eq!(floor_within(x, low, high), x.floor().clamp(low, high) as i32, "{x}");
            }
            if x.abs() < 1e9 {
                assert_eq!(floor(x), x.floor() as i32, "{x}");
            }
        }
    }

    #[test]
    fn rounding_maps_nan_to_the_lower_bound() {
        assert_eq!((ceil_within(f32::NAN, 9), floor_within(f32::NAN, -3.0, 9.0)), (0, -3));
    }
}
