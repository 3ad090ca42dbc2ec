//! Durations as arguments: a whole number with a unit, such as `90d`.

use std::time::Duration;

/// Units with their seconds.
const UNITS: [(char, u64); 4] = [('s', 1), ('m', 60), ('h', 3600), ('d', 86_400)];

/// The text is no duration.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("give a whole number of seconds, minutes, hours or days, such as 90d, 12h, 30m or 45s")]
pub struct NoDuration;

/// Reads a duration.
///
/// # Errors
///
/// [`NoDuration`] for anything but a whole number from 1 on with a unit.
pub fn duration(text: &str) -> Result<Duration, NoDuration> {
    let text = text.trim();
    let unit = UNITS.iter().find(|(unit, _)| text.ends_with(*unit));
    let (unit, seconds) = unit.ok_or(NoDuration)?;
    let number = text.strip_suffix(*unit).and_then(|number| number.parse::<u64>().ok());
    let seconds = number.filter(|number| *number > 0).and_then(|number| number.checked_mul(*seconds));
    seconds.map(Duration::from_secs).ok_or(NoDuration)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn durations_have_a_unit() {
        for (text, seconds) in [("90d", 7_776_000), ("12h", 43_200), ("30m", 1800), (" 45s", 45)] {
            assert_eq!(duration(text), Ok(Duration::from_secs(seconds)), "{text}");
        }
        for text in ["", "90", "d", "0d", "-1d", "1.5h", "1w", "99999999999999999d"] {
            assert_eq!(duration(text), Err(NoDuration), "{text}");
        }
    }
}
