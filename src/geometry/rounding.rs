//! Rounding in inner loops of pictures. Without SSE 4.1 the library's `floor` and `ceil` are calls.

/// Largest whole number at most `x`.
#[inline]
pub fn floor(x: f32) -> i32 {
    let truncated = x as i32;
    truncated - i32::from(truncated as f32 > x)
}

/// Smallest whole number at least `x`, within `0..=limit`.
#[inline]
pub fn ceil_within(x: f32, limit: usize) -> usize {
    let x = x.clamp(0.0, limit as f32);
    let truncated = x as usize;
    truncated + usize::from((truncated as f32) < x)
}
