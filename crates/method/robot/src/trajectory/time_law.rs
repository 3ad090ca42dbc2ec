//! The fastest motion along a curve within limits of velocity and acceleration: TOPP-RA.
//!
//! After Pham and Pham, "A new approach to time-optimal path parameterization based on reachability analysis" (2018).
//! At each point of a grid along the curve, the squared rate of the parameter, `x`, is as large as allows to obey all
//! limits from there to the end (backward), and then as large as can be reached from the start (forward). Rates are
//! the parameter's per second. Each interval of the grid has one acceleration of the parameter, `u`, and its limits
//! hold at both ends of the interval.

use super::curve::{Curve, CurvePoint};
use crate::model::limits::JointLimits;

/// Grid points for each span of the curve.
const INTERVALS_PER_SPAN: usize = 6;

/// Position on the curve as a function of time, from rest to rest.
#[derive(Clone, Debug, PartialEq)]
pub struct TimeLaw {
    pieces: Vec<Piece>,
}

/// An interval of the grid, on which the parameter accelerates evenly.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Piece {
    begin_s: f64,
    parameter: f64,
    rate: f64,
    acceleration: f64,
}

/// A bound on the parameter's acceleration that is linear in the squared rate: `u <= offset + slope x`, or `>=`.
#[derive(Clone, Copy)]
struct Bound {
    offset: f64,
    slope: f64,
}

/// Limits of the motion on one interval.
#[derive(Default)]
struct Interval {
    lower: Vec<Bound>,
    upper: Vec<Bound>,
    /// The greatest squared rate that velocity and curvature allow at its begin.
    max_square: f64,
}

impl TimeLaw {
    /// The fastest law for a curve. All limits of velocity and acceleration must be greater than 0.
    pub fn fastest(curve: &Curve, limits: &[JointLimits]) -> Self {
        let count = INTERVALS_PER_SPAN * curve.span_count();
        let step = 1.0 / INTERVALS_PER_SPAN as f64;
        let points: Vec<CurvePoint> = (0..=count).map(|k| curve.at(k as f64 * step)).collect();
        let intervals: Vec<Interval> =
            points.windows(2).map(|ends| Interval::new(&ends[0], &ends[1], limits, step)).collect();
        // Backward: the greatest squared rate from which the end can still be obeyed.
        let mut controllable = vec![0.0; count + 1];
        for k in (0..count).rev() {
            controllable[k] = intervals[k].greatest_square(controllable[k + 1], step);
        }
        // Forward: as fast as that allows.
        let mut squares = vec![0.0; count + 1];
        for k in 0..count {
            let (lowest, greatest) = intervals[k].range(squares[k], controllable[k + 1], step);
            let u = greatest.max(lowest);
            squares[k + 1] = (squares[k] + 2.0 * step * u).clamp(0.0, controllable[k + 1]);
        }
        Self::through(&squares, step)
    }

    /// The law with these squared rates at the points of the grid.
    fn through(squares: &[f64], step: f64) -> Self {
        let mut begin_s = 0.0;
        let mut pieces = Vec::with_capacity(squares.len());
        for (k, ends) in squares.windows(2).enumerate() {
            let (from, to) = (ends[0].sqrt(), ends[1].sqrt());
            // A curve that stays where it is takes no time.
            let duration_s = if from + to > 0.0 { 2.0 * step / (from + to) } else { 0.0 };
            let acceleration = (ends[1] - ends[0]) / (2.0 * step);
            pieces.push(Piece { begin_s, parameter: k as f64 * step, rate: from, acceleration });
            begin_s += duration_s;
        }
        let end = (squares.len() - 1) as f64 * step;
        pieces.push(Piece { begin_s, parameter: end, rate: 0.0, acceleration: 0.0 });
        Self { pieces }
    }

    /// The law that takes `factor` times as long.
    pub fn slower(&self, factor: f64) -> Self {
        let slow = |piece: &Piece| Piece {
            begin_s: piece.begin_s * factor,
            parameter: piece.parameter,
            rate: piece.rate / factor,
            acceleration: piece.acceleration / (factor * factor),
        };
        Self { pieces: self.pieces.iter().map(slow).collect() }
    }

    pub fn duration_s(&self) -> f64 {
        self.pieces.last().map_or(0.0, |last| last.begin_s)
    }

    /// The times at which the parameter's acceleration changes, from 0 to the duration.
    pub fn times_s(&self) -> impl Iterator<Item = f64> {
        self.pieces.iter().map(|piece| piece.begin_s)
    }

    /// The parameter and its first two derivatives by time; before the begin and after the end it rests.
    pub fn at(&self, time_s: f64) -> (f64, f64, f64) {
        let after = self.pieces.partition_point(|piece| piece.begin_s <= time_s);
        let Some(piece) = after.checked_sub(1).map(|index| self.pieces[index]) else {
            return (0.0, 0.0, 0.0);
        };
        let since_s = if after == self.pieces.len() { 0.0 } else { time_s - piece.begin_s };
        let rate = piece.rate + piece.acceleration * since_s;
        let parameter = piece.parameter + (piece.rate + 0.5 * piece.acceleration * since_s) * since_s;
        (parameter, rate, piece.acceleration)
    }
}

impl Interval {
    fn new(begin: &CurvePoint, end: &CurvePoint, limits: &[JointLimits], step: f64) -> Self {
        let mut interval = Self { max_square: f64::MAX, ..Self::default() };
        for (joint, limit) in limits.iter().enumerate().take(begin.first.len()) {
            let speed = begin.first[joint].abs();
            if speed > 0.0 {
                interval.max_square = interval.max_square.min((limit.max_velocity / speed).powi(2));
            }
            // Acceleration of the joint at the begin, and at the end, where the squared rate is x + 2 step u.
            interval.limit(begin.first[joint], begin.second[joint], limit.max_acceleration);
            let at_end = end.first[joint] + 2.0 * step * end.second[joint];
            interval.limit(at_end, end.second[joint], limit.max_acceleration);
        }
        interval
    }

    /// Adds `-limit <= a u + b x <= limit`.
    fn limit(&mut self, a: f64, b: f64, limit: f64) {
        if a.abs() > 1e-12 {
            let bound = |side: f64| Bound { offset: side / a, slope: -b / a };
            let (low, high) = if a > 0.0 { (-limit, limit) } else { (limit, -limit) };
            self.lower.push(bound(low));
            self.upper.push(bound(high));
        } else if b != 0.0 {
            self.max_square = self.max_square.min(limit / b.abs());
        }
    }

    /// The greatest squared rate at the begin with which the one at the end can be within 0 to `next`.
    fn greatest_square(&self, next: f64, step: f64) -> f64 {
        let lower = self.lower.iter().copied().chain([Bound { offset: 0.0, slope: -0.5 / step }]);
        let mut greatest = self.max_square;
        for low in lower {
            let reach = Bound { offset: 0.5 * next / step, slope: -0.5 / step };
            for high in self.upper.iter().copied().chain([reach]) {
                // low <= high for this x; at x = 0 it holds.
                let slope = low.slope - high.slope;
                if slope > 0.0 {
                    greatest = greatest.min(((high.offset - low.offset) / slope).max(0.0));
                }
            }
        }
        greatest
    }

    /// The lowest and greatest acceleration of the parameter at squared rate `x`.
    fn range(&self, x: f64, next: f64, step: f64) -> (f64, f64) {
        let at = |bound: &Bound| bound.offset + bound.slope * x;
        let lowest = self.lower.iter().map(at).fold(-0.5 * x / step, f64::max);
        let greatest = self.upper.iter().map(at).fold(0.5 * (next - x) / step, f64::min);
        (lowest, greatest)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::trajectory::Corners;

    fn limits(max_velocity: f64, max_acceleration: f64) -> JointLimits {
        JointLimits {
            min_position: -10.0,
            max_position: 10.0,
            max_velocity,
            max_acceleration,
            max_jerk: 1e6,
            max_effort: 1.0,
        }
    }

    #[test]
    fn a_straight_motion_takes_as_long_as_a_trapezoid() {
        let curve = Curve::along(&[vec![0.0, 0.0], vec![2.0, 1.0]], 0.05, Corners::Rounded).expect("a curve");
        // The first joint needs 2 rad at 1 rad/s and 4 rad/s²: v/a + d/v. The second is slower than its limits.
        let law = TimeLaw::fastest(&curve, &[limits(1.0, 4.0), limits(1.0, 4.0)]);
        assert!((law.duration_s() - 2.25).abs() < 2e-3, "{}", law.duration_s());
        // Too short for full speed: 2 sqrt(d/a).
        let short = Curve::along(&[vec![0.0], vec![0.16]], 0.01, Corners::Rounded).expect("a curve");
        let law = TimeLaw::fastest(&short, &[limits(1.0, 4.0)]);
        assert!((law.duration_s() - 0.4).abs() < 2e-3, "{}", law.duration_s());
    }

    #[test]
    fn the_law_begins_and_ends_at_rest_and_never_goes_back() {
        let path = vec![vec![0.0, 0.0], vec![1.0, 0.2], vec![0.2, 1.0], vec![0.2, -1.0]];
        let curve = Curve::along(&path, 0.1, Corners::Rounded).expect("a curve");
        let law = TimeLaw::fastest(&curve, &[limits(1.0, 4.0), limits(2.0, 3.0)]);
        assert_eq!(law.at(0.0).1, 0.0);
        assert_eq!(law.at(law.duration_s() + 1.0), (curve.span_count() as f64, 0.0, 0.0));
        let mut before = 0.0;
        for k in 0..=1000 {
            let (parameter, rate, _) = law.at(law.duration_s() * f64::from(k) / 1000.0);
            assert!(parameter >= before && rate >= 0.0, "{parameter} {rate}");
            before = parameter;
        }
        assert!((before - curve.span_count() as f64).abs() < 1e-9);
    }
}
