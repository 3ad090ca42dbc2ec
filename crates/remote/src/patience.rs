//! How long to wait before the next try: exponential backoff with full jitter, and what `Retry-After` asks for.

use std::time::{Duration, SystemTime};

use uuid::Uuid;

/// Uniform between 0 and `base * 2^(tries - 1)`, capped (M. Brooker, "Exponential Backoff And Jitter"); `unit` is drawn
/// uniformly from 0..1.
pub fn full_jitter(tries: u32, base: Duration, cap: Duration, unit: f64) -> Duration {
    let doubled = base.saturating_mul(1_u32.checked_shl(tries.saturating_sub(1)).unwrap_or(u32::MAX));
    doubled.min(cap).mul_f64(unit.clamp(0.0, 1.0))
}

/// Uniform in 0..1; not a seed of anything.
pub(super) fn unit() -> f64 {
    (Uuid::new_v4().as_u128() >> 75) as f64 / (1_u64 << 53) as f64
}

/// The pause that a `Retry-After` asks for: seconds, or a date (RFC 9110, 10.2.3); a date that has passed asks for none.
pub fn asked_pause(value: &str, now: SystemTime) -> Option<Duration> {
    let value = value.trim();
    match value.parse::<u64>() {
        Ok(seconds) => Some(Duration::from_secs(seconds.min(86_400))),
        Err(_) => {
            let until = httpdate::parse_http_date(value).ok()?;
            Some(until.duration_since(now).unwrap_or_default().min(Duration::from_secs(86_400)))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pauses_double_up_to_the_cap_and_are_spread_over_all_of_it() {
        let (base, cap) = (Duration::from_millis(100), Duration::from_secs(1));
        let longest: Vec<u128> =
            (1..=6).map(|tries| full_jitter(tries, base, cap, 1.0).as_millis()).collect();
        assert_eq!(longest, [100, 200, 400, 800, 1000, 1000]);
        assert_eq!(full_jitter(3, base, cap, 0.0), Duration::ZERO);
        assert_eq!(full_jitter(3, base, cap, 0.5), Duration::from_millis(200));
        assert_eq!(full_jitter(200, base, cap, 1.0), cap);
        assert!((0..100).map(|_| unit()).all(|unit| (0.0..1.0).contains(&unit)));
    }

    #[test]
    fn servers_ask_in_seconds_or_by_a_date() {
        let now = SystemTime::UNIX_EPOCH + Duration::from_secs(784_111_700);
        assert_eq!(asked_pause("120", now), Some(Duration::from_secs(120)));
        assert_eq!(asked_pause("Sun, 06 Nov 1994 08:49:37 GMT", now), Some(Duration::from_secs(77)));
        assert_eq!(asked_pause("Sun, 06 Nov 1994 08:00:00 GMT", now), Some(Duration::ZERO));
        assert_eq!(asked_pause("99999999999", now), Some(Duration::from_secs(86_400)));
        assert_eq!(asked_pause("soon", now), None);
    }
}
