//! Pauses between attempts: exponential backoff with full jitter, and the `Retry-After` header.

use std::time::{Duration, SystemTime};

use uuid::Uuid;

/// The pause after `attempts` attempts: `uniform` times `base * 2^(attempts - 1)`, at most `cap` (M. Brooker,
/// "Exponential Backoff And Jitter"). `uniform` is drawn uniformly from 0..1.
pub fn full_jitter(attempts: u32, base: Duration, cap: Duration, uniform: f64) -> Duration {
    let doubled = base.saturating_mul(1_u32.checked_shl(attempts.saturating_sub(1)).unwrap_or(u32::MAX));
    doubled.min(cap).mul_f64(uniform.clamp(0.0, 1.0))
}

/// A random number, uniform in 0..1. It decides pauses only and never affects a result.
pub fn uniform() -> f64 {
    (Uuid::new_v4().as_u128() >> 75) as f64 / (1_u64 << 53) as f64
}

/// The pause that a `Retry-After` value requests, in seconds or as a date (RFC 9110, 10.2.3), at most one day.
/// A date in the past requests a pause of zero.
pub fn retry_after(value: &str, now: SystemTime) -> Option<Duration> {
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
    fn full_jitter_doubles_up_to_the_cap_and_scales_with_the_draw() {
        let (base, cap) = (Duration::from_millis(100), Duration::from_secs(1));
        let longest: Vec<u128> =
            (1..=6).map(|attempts| full_jitter(attempts, base, cap, 1.0).as_millis()).collect();
        assert_eq!(longest, [100, 200, 400, 800, 1000, 1000]);
        assert_eq!(full_jitter(3, base, cap, 0.0), Duration::ZERO);
        assert_eq!(full_jitter(3, base, cap, 0.5), Duration::from_millis(200));
        assert_eq!(full_jitter(200, base, cap, 1.0), cap);
        assert!((0..100).map(|_| uniform()).all(|drawn| (0.0..1.0).contains(&drawn)));
    }

    #[test]
    fn retry_after_reads_seconds_and_dates() {
        let now = SystemTime::UNIX_EPOCH + Duration::from_secs(784_111_700);
        assert_eq!(retry_after("120", now), Some(Duration::from_secs(120)));
        assert_eq!(retry_after("Sun, 06 Nov 1994 08:49:37 GMT", now), Some(Duration::from_secs(77)));
        assert_eq!(retry_after("Sun, 06 Nov 1994 08:00:00 GMT", now), Some(Duration::ZERO));
        assert_eq!(retry_after("99999999999", now), Some(Duration::from_secs(86_400)));
        assert_eq!(retry_after("soon", now), None);
    }
}
