//! Numbers as arguments: a complaint names the value and the range.

use std::ops::RangeInclusive;

use scene::request::MAX_SEED;

/// Reason why an argument is not the number that an option takes.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum NumberError {
    #[error("give a whole number{}", in_words(.0))]
    NotWhole(RangeInclusive<u64>),
    #[error("give a number of US dollars, such as 12.5")]
    NotDollars,
    #[error("give a number from 0 to 1, such as 0.6")]
    NotShare,
}

/// Reads a whole number of a range.
pub fn whole<T: TryFrom<u64>>(
    range: RangeInclusive<u64>,
) -> impl Fn(&str) -> Result<T, NumberError> + Clone + Send + Sync + 'static {
    move |text: &str| {
        let number = text.trim().parse::<u64>().ok().filter(|number| range.contains(number));
        number.and_then(|number| T::try_from(number).ok()).ok_or_else(|| NumberError::NotWhole(range.clone()))
    }
}

/// Reads a seed.
///
/// # Errors
///
/// [`NumberError::NotWhole`] with the range of seeds.
pub fn seed(text: &str) -> Result<u64, NumberError> {
    whole(0..=MAX_SEED)(text)
}

/// Reads an amount of money.
///
/// # Errors
///
/// [`NumberError::NotDollars`] for anything but a finite number.
pub fn us_dollars(text: &str) -> Result<f64, NumberError> {
    let amount = text.trim().parse::<f64>().ok().filter(|amount| amount.is_finite());
    amount.ok_or(NumberError::NotDollars)
}

/// Reads a share.
///
/// # Errors
///
/// [`NumberError::NotShare`] for anything but a number from 0 to 1.
pub fn share(text: &str) -> Result<f64, NumberError> {
    let share = text.trim().parse::<f64>().ok().filter(|share| (0.0..=1.0).contains(share));
    share.ok_or(NumberError::NotShare)
}

fn in_words(range: &RangeInclusive<u64>) -> String {
    match (range.start(), *range.end()) {
        (low, u64::MAX) => format!(", {low} or more"),
        (low, high) => format!(" from {low} to {high}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_complaint_names_the_range() {
        fn complaint<T: std::fmt::Debug>(read: Result<T, NumberError>) -> String {
            read.expect_err("is refused").to_string()
        }
        assert_eq!(whole::<u32>(1..=64)("64"), Ok(64));
        for wrong in ["65", "0", "-1", "1.5", "many", "", "99999999999999999999"] {
            assert_eq!(complaint(whole::<u32>(1..=64)(wrong)), "give a whole number from 1 to 64");
        }
        assert_eq!(complaint(whole::<u8>(1..=u64::MAX)("256")), "give a whole number, 1 or more");
        let beyond = complaint(seed("9007199254740992"));
        assert_eq!(beyond, "give a whole number from 0 to 9007199254740991");
        assert_eq!(us_dollars("12.5"), Ok(12.5));
        assert!(us_dollars("NaN").is_err() && us_dollars("ten").is_err());
    }
}
