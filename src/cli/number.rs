//! Numbers as arguments: a complaint names the value and the range.

use std::fmt::Display;
use std::ops::RangeInclusive;

use scene::request::MAX_SEED;

/// Reads a whole number of a range.
pub fn whole<T: TryFrom<u64>>(
    range: RangeInclusive<u64>,
) -> impl Fn(&str) -> Result<T, String> + Clone + Send + Sync + 'static {
    move |text: &str| {
        let number = text.trim().parse::<u64>().ok().filter(|number| range.contains(number));
        number.and_then(|number| T::try_from(number).ok()).ok_or_else(|| asked_for(&range))
    }
}

/// Reads a seed.
///
/// # Errors
///
/// The range of seeds.
pub fn seed(text: &str) -> Result<u64, String> {
    whole(0..=MAX_SEED)(text)
}

/// Reads an amount of money.
///
/// # Errors
///
/// A sentence with an example.
pub fn us_dollars(text: &str) -> Result<f64, String> {
    let amount = text.trim().parse::<f64>().ok().filter(|amount| amount.is_finite());
    amount.ok_or_else(|| "give a number of US dollars, such as 12.5".to_owned())
}

fn asked_for(range: &RangeInclusive<u64>) -> String {
    let (low, high): (&dyn Display, _) = (range.start(), *range.end());
    match high {
        u64::MAX => format!("give a whole number, {low} or more"),
        high => format!("give a whole number from {low} to {high}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_complaint_names_the_range() {
        assert_eq!(whole::<u32>(1..=64)("64"), Ok(64));
        for wrong in ["65", "0", "-1", "1.5", "many", "", "99999999999999999999"] {
            assert_eq!(whole::<u32>(1..=64)(wrong), Err("give a whole number from 1 to 64".to_owned()));
        }
        assert_eq!(whole::<u8>(1..=u64::MAX)("256"), Err("give a whole number, 1 or more".to_owned()));
        assert_eq!(
            seed("9007199254740992"),
            Err("give a whole number from 0 to 9007199254740991".to_owned())
        );
        assert_eq!(us_dollars("12.5"), Ok(12.5));
        assert!(us_dollars("NaN").is_err() && us_dollars("ten").is_err());
    }
}
