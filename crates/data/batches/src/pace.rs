//! Throughput of a batch, and the time until its end.

use std::time::Duration;

/// Progress so far.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Pace {
    /// Requests that ended in `elapsed`.
    pub finished: u64,
    pub elapsed: Duration,
}

impl Pace {
    /// Requests per hour; `None` before the first one ended.
    pub fn per_hour(&self) -> Option<f64> {
        let hours = self.elapsed.as_secs_f64() / 3600.0;
        (self.finished > 0 && hours > 0.0).then(|| self.finished as f64 / hours)
    }

    /// Time for so many more at the same pace; `None` before the first one ended.
    pub fn time_left(&self, remaining: u64) -> Option<Duration> {
        let hours = remaining as f64 / self.per_hour()?;
        // A century is as good as forever.
        Some(Duration::from_secs_f64((hours * 3600.0).min(3.2e9)))
    }
}

/// A duration as people say it, in the two largest units.
pub fn in_words(duration: Duration) -> String {
    let secs = duration.as_secs();
    match secs {
        0..60 => format!("{secs} s"),
        60..3600 => format!("{} min {} s", secs / 60, secs % 60),
        3600..86_400 => format!("{} h {} min", secs / 3600, secs % 3600 / 60),
        _ => format!("{} d {} h", secs / 86_400, secs % 86_400 / 3600),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_time_left_is_the_rest_over_the_throughput() {
        let pace = Pace { finished: 20, elapsed: Duration::from_secs(60) };
        assert_eq!(pace.per_hour(), Some(1200.0));
        assert_eq!(pace.time_left(100), Some(Duration::from_secs(300)));
        assert_eq!(pace.time_left(0), Some(Duration::ZERO));
    }

    #[test]
    fn nothing_is_estimated_before_something_is_measured() {
        assert_eq!(Pace::default().time_left(5), None);
        assert_eq!(Pace { finished: 0, elapsed: Duration::from_secs(9) }.time_left(5), None);
        let slow = Pace { finished: 1, elapsed: Duration::from_secs(1 << 40) };
        assert!(slow.time_left(u64::MAX).is_some_and(|left| left < Duration::from_secs(4_000_000_000)));
    }

    #[test]
    fn durations_have_at_most_two_units() {
        for (secs, words) in [
            (0, "0 s"),
            (59, "59 s"),
            (60, "1 min 0 s"),
            (3599, "59 min 59 s"),
            (3660, "1 h 1 min"),
            (90_000, "1 d 1 h"),
        ] {
            assert_eq!(in_words(Duration::from_secs(secs)), words);
        }
    }
}
