//! Plane geometry of moving lines: intersections with their derivatives, and clipping to a box.

use super::MovingPoint;

/// A point with its derivatives, as [`MovingPoint`], in double precision.
#[derive(Clone, Copy, Debug)]
pub struct Moving<const N: usize> {
    pub at_px: [f64; 2],
    pub slopes: [[f64; 2]; N],
}

impl<const N: usize> Moving<N> {
    pub fn at_px_f32(&self) -> [f32; 2] {
        self.at_px.map(|c| c as f32)
    }

    pub fn rounded(&self) -> MovingPoint<N> {
        MovingPoint { at_px: self.at_px_f32(), slopes: self.slopes.map(|s| s.map(|c| c as f32)) }
    }
}

impl<const N: usize> From<&MovingPoint<N>> for Moving<N> {
    fn from(point: &MovingPoint<N>) -> Self {
        Self { at_px: point.at_px.map(f64::from), slopes: point.slopes.map(|s| s.map(f64::from)) }
    }
}

pub fn minus(a: [f64; 2], b: [f64; 2]) -> [f64; 2] {
    [a[0] - b[0], a[1] - b[1]]
}

pub fn cross(a: [f64; 2], b: [f64; 2]) -> f64 {
    a[0] * b[1] - a[1] * b[0]
}

fn between(a: [f64; 2], b: [f64; 2], t: f64) -> [f64; 2] {
    [a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1])]
}

/// Sine of the angle under which lines count as parallel: their crossing has no useful derivative.
const PARALLEL: f64 = 1e-6;

/// A line between two moving points.
#[derive(Clone, Copy, Debug)]
pub struct MovingLine<const N: usize> {
    ends: [Moving<N>; 2],
}

impl<const N: usize> MovingLine<N> {
    pub fn between(ends: [&MovingPoint<N>; 2]) -> Self {
        Self { ends: ends.map(Moving::from) }
    }

    /// The point at share `t` of the way, moving with the ends.
    pub fn at(&self, t: f64) -> Moving<N> {
        let [a, b] = &self.ends;
        Moving {
            at_px: between(a.at_px, b.at_px, t),
            slopes: std::array::from_fn(|k| between(a.slopes[k], b.slopes[k], t)),
        }
    }

    pub fn direction(&self) -> [f64; 2] {
        minus(self.ends[1].at_px, self.ends[0].at_px)
    }

    /// Shares of the way at which this line and another cross.
    #[inline]
    pub fn crossing(&self, other: &Self) -> Option<(f64, f64)> {
        // A little beyond the ends counts: a line that passes through a vertex must not slip between the
        // vertex's two edges.
        const SLACK: f64 = 1e-9;
        let (r, q) = (self.direction(), other.direction());
        let across = cross(r, q);
        let apart = minus(other.ends[0].at_px, self.ends[0].at_px);
        let (along, along_other) = (cross(apart, q), cross(apart, r));
        // Most do not cross: for them no division is needed.
        let surely_beyond = |along: f64| {
            let along = along * across.signum();
            (along < -2.0 * SLACK * across.abs()) | (along > (1.0 + 2.0 * SLACK) * across.abs())
        };
        if surely_beyond(along) | surely_beyond(along_other) {
            return None;
        }
        let (s, u) = (along / across, along_other / across);
        let within = |t: f64| (-SLACK..=1.0 + SLACK).contains(&t);
        (within(s) && within(u)).then_some((s, u))
    }

    /// The crossing at shares `s` of this line and `u` of the other. It stays on both: it moves with this
    /// line's own point there, and along this line by as much as brings it back onto the other.
    pub fn crossing_point(&self, s: f64, other: &Self, u: f64) -> Moving<N> {
        let (mut point, theirs) = (self.at(s), other.at(u));
        let (r, q) = (self.direction(), other.direction());
        let across = cross(r, q);
        if across * across <= PARALLEL * PARALLEL * (r[0] * r[0] + r[1] * r[1]) * (q[0] * q[0] + q[1] * q[1])
        {
            return point;
        }
        for k in 0..N {
            let along = cross(minus(theirs.slopes[k], point.slopes[k]), q) / across;
            point.slopes[k] = [point.slopes[k][0] + along * r[0], point.slopes[k][1] + along * r[1]];
        }
        point
    }

    /// Shares of the way between which the line lies in a box (Liang and Barsky 1984).
    pub fn clip(&self, low: [f64; 2], high: [f64; 2]) -> Option<(f64, f64)> {
        // Most lines lie inside: for them no division is needed.
        let within = |p: [f64; 2]| (0..2).all(|axis| (low[axis]..=high[axis]).contains(&p[axis]));
        if self.ends.iter().all(|end| within(end.at_px)) {
            return Some((0.0, 1.0));
        }
        let (start, direction) = (self.ends[0].at_px, self.direction());
        let (mut from, mut to) = (0.0_f64, 1.0_f64);
        for axis in 0..2 {
            let (p, d) = (start[axis], direction[axis]);
            if d.abs() < 1e-30 {
                if p < low[axis] || p > high[axis] {
                    return None;
                }
                continue;
            }
            let (u, v) = ((low[axis] - p) / d, (high[axis] - p) / d);
            (from, to) = (from.max(u.min(v)), to.min(u.max(v)));
        }
        (from < to).then_some((from, to))
    }
}
