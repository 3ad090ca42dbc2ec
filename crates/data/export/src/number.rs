//! Numbers as text: the shortest decimals that parse to the same value, without exponent and without "-0".

use std::fmt::Write;

/// Appends a double-precision number; it must be finite.
pub fn push_f64(text: &mut String, value: f64) {
    write!(text, "{}", value + 0.0).expect("writing to a string cannot fail");
}

/// Appends a single-precision number; it must be finite.
pub fn push_f32(text: &mut String, value: f32) {
    write!(text, "{}", value + 0.0).expect("writing to a string cannot fail");
}

/// Appends `value` rounded to five decimals: enough for directions and a third of the bytes.
pub fn push_direction(text: &mut String, value: f32) {
    push_f64(text, (f64::from(value) * 1e5).round() / 1e5);
}

/// `value` rounded as in [`push_direction`].
pub fn direction(value: f32) -> f32 {
    ((f64::from(value) * 1e5).round() / 1e5) as f32
}

/// The numbers with spaces between them.
pub fn spaced(values: &[f64]) -> String {
    let mut text = String::new();
    for (k, value) in values.iter().enumerate() {
        if k > 0 {
            text.push(' ');
        }
        push_f64(&mut text, *value);
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn number_text_has_no_exponent_and_round_trips() {
        assert_eq!(spaced(&[0.1, -0.0, 1e-9, 2.0]), "0.1 0 0.000000001 2");
        for value in [1.0 / 3.0, 6.02e23, -1.5e-12] {
            assert_eq!(spaced(&[value]).parse::<f64>().expect("a number"), value);
        }
        let mut text = String::new();
        push_direction(&mut text, -1e-7);
        assert_eq!(text, "0");
    }
}
