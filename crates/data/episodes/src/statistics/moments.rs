//! Mean and variance of a stream, by Welford's method; those of parts combine after Chan, Golub and LeVeque (1979).

/// Count, mean, sum of squared deviations from the mean, smallest and largest.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Moments {
    pub count: u64,
    pub mean: f64,
    pub sum_of_squares: f64,
    pub min: f64,
    pub max: f64,
}

impl Moments {
    pub const EMPTY: Self =
        Self { count: 0, mean: 0.0, sum_of_squares: 0.0, min: f64::INFINITY, max: f64::NEG_INFINITY };

    pub fn of(values: impl IntoIterator<Item = f64>) -> Self {
        let mut moments = Self::EMPTY;
        values.into_iter().for_each(|value| moments.add(value));
        moments
    }

    pub fn add(&mut self, value: f64) {
        self.count += 1;
        let deviation = value - self.mean;
        self.mean += deviation / self.count as f64;
        self.sum_of_squares += deviation * (value - self.mean);
        self.min = self.min.min(value);
        self.max = self.max.max(value);
    }

    /// Adds what another part of the stream has.
    pub fn merge(&mut self, other: &Self) {
        if other.count == 0 {
            return;
        }
        let (n, m) = (self.count as f64, other.count as f64);
        let difference = other.mean - self.mean;
        self.mean += difference * m / (n + m);
        self.sum_of_squares += other.sum_of_squares + difference * difference * n * m / (n + m);
        self.count += other.count;
        self.min = self.min.min(other.min);
        self.max = self.max.max(other.max);
    }

    /// The standard deviation of the population.
    pub fn standard_deviation(&self) -> f64 {
        (self.sum_of_squares / self.count.max(1) as f64).max(0.0).sqrt()
    }
}
