//! Rounding and comparing in inner loops of pictures. Without SSE 4.1 the library's `floor` and `ceil` are calls.

/// Largest whole number at most `x`.
#[inline]
pub fn floor(x: f32) -> i32 {
    let truncated = x as i32;
    truncated - i32::from(truncated as f32 > x)
}

/// Smallest whole number at least `x`, within `0..=limit`; 0 where there is no number. `limit` is below 2^22.
#[inline]
pub fn ceil_within(x: f32, limit: usize) -> usize {
    // The sum's last place is 1: what is left of it is the nearest whole number, without a conversion and its checks.
    const SHIFT: f32 = 8_388_608.0;
    let x = if x > 0.0 { x } else { 0.0 };
    let x = if x < limit as f32 { x } else { limit as f32 };
    let shifted = x + SHIFT;
    let nearest = (shifted.to_bits() - SHIFT.to_bits()) as usize;
    nearest + usize::from(shifted - SHIFT < x)
}

/// Largest whole number at most `x`, within `low..=high`, which are within 2^22 of 0; `low` where there is no number.
#[inline]
pub fn floor_within(x: f32, low: f32, high: f32) -> i32 {
    // As above, with half as large a number more so that what is below 0 keeps its place.
    const SHIFT: f32 = 12_582_912.0;
    let x = if x > low { x } else { low };
    let x = if x < high { x } else { high };
    let shifted = x + SHIFT;
    let nearest = shifted.to_bits().wrapping_sub(SHIFT.to_bits()) as i32;
    nearest - i32::from(shifted - SHIFT > x)
}

/// The lesser of two numbers as a single instruction; the second where either is none.
#[inline]
pub fn lesser(a: f32, b: f32) -> f32 {
    if a < b { a } else { b }
}

/// The greater, likewise.
#[inline]
pub fn greater(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Whole numbers, halves and their neighbors, on both sides of 0 and beyond all bounds.
    fn numbers() -> impl Iterator<Item = f32> {
        let near = |x: f32| [x.next_down(), x, x.next_up()];
        let halves = (-4096..=4096).map(|k| 0.5 * k as f32);
        let far = [-1e30, -4e6, 4e6, 1e30, f32::INFINITY, f32::NEG_INFINITY];
        halves.chain(far).flat_map(near)
    }

    #[test]
    fn rounds_as_the_library_within_bounds() {
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
    fn what_is_no_number_is_the_lowest() {
        assert_eq!((ceil_within(f32::NAN, 9), floor_within(f32::NAN, -3.0, 9.0)), (0, -3));
    }
}
