//! Formatting of measured values for people: millimeters, degrees, percent.

use certificate::Displacement;

/// A body that moved farther has left the scene, meters.
const LOST_M: f64 = 100.0;

/// Millimeters with two decimals; smaller values print as `< 0.01 mm`.
pub fn mm(meters: f64) -> String {
    match 1e3 * meters {
        lost if lost.abs() > 1e3 * LOST_M => "lost".to_owned(),
        0.0 => "0 mm".to_owned(),
        tiny if tiny.abs() < 0.01 => "< 0.01 mm".to_owned(),
        far if far.abs() >= 100.0 => format!("{far:.0} mm"),
        near => format!("{near:.2} mm"),
    }
}

/// Degrees with one decimal.
pub fn degrees(radians: f64) -> String {
    match radians.to_degrees() {
        0.0 => "0°".to_owned(),
        tiny if tiny.abs() < 0.05 => "< 0.05°".to_owned(),
        turn => format!("{turn:.1}°"),
    }
}

/// Distance and angle.
pub fn movement(moved: &Displacement) -> String {
    match mm(moved.distance_m) {
        lost if lost == "lost" => lost,
        way => format!("{way}, {}", degrees(moved.angle_rad)),
    }
}

/// Percent with at most one decimal.
pub fn percent(share: f64) -> String {
    let percent = 100.0 * share;
    if percent.fract() == 0.0 { format!("{percent:.0} %") } else { format!("{percent:.1} %") }
}

/// Three significant digits, without an exponent where it would be short.
pub fn significant(value: f64) -> String {
    if value == 0.0 || !value.is_finite() {
        return format!("{value}");
    }
    let digits = 2 - value.abs().log10().floor() as i32;
    match digits {
        ..=0 => format!("{value:.0}"),
        1..=6 => format!("{value:.*}", digits as usize),
        _ => format!("{value:.2e}"),
    }
}

/// An upper bound, rounded up to a power of ten.
pub fn at_most(difference: f64) -> String {
    if difference == 0.0 { "0".to_owned() } else { format!("≤ {difference:e}") }
}

/// The name of an enumeration's value in `report.json`.
pub fn word(value: impl serde::Serialize) -> String {
    let value = serde_json::to_value(value).unwrap_or_default();
    value.as_str().unwrap_or_default().to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_are_rounded_to_readable_text() {
        assert_eq!(
            [0.0, 4e-8, 0.00123, 0.25, 1e308].map(mm),
            ["0 mm", "< 0.01 mm", "1.23 mm", "250 mm", "lost"]
        );
        assert_eq!([0.0, 1e-4, 0.4].map(degrees), ["0°", "< 0.05°", "22.9°"]);
        assert_eq!([1.0, 5.0 / 6.0].map(percent), ["100 %", "83.3 %"]);
        assert_eq!(
            [0.0, 12345.0, 2.5, 0.0123, 3.1e-9].map(significant),
            ["0", "12345", "2.50", "0.0123", "3.10e-9"]
        );
        assert_eq!([0.0, 1e-7].map(at_most), ["0", "≤ 1e-7"]);
    }
}
