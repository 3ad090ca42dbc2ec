//! A smooth curve along a path: twice continuously differentiable, and never far from it.

/// A uniform cubic B-spline in joint space whose control points lie on a path.
///
/// The parameter runs from 0 to `span_count`. On straight stretches of the path the curve is on the path; at a corner
/// it is off by at most a third of the spacing of the control points. It begins and ends where the path does.
#[derive(Clone, Debug, PartialEq)]
pub struct Curve {
    /// Coefficients of each span: `q(k + w) = c[0] + c[1] w + c[2] w² + c[3] w³` for `w` in 0..1.
    spans: Vec<[Vec<f64>; 4]>,
}

/// Treatment of the corners of a path.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Corners {
    /// Rounded corners.
    Rounded,
    /// Rest at each corner; the curve never leaves the path.
    Stopped,
}

/// The derivatives of a curve by its parameter.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CurvePoint {
    pub position: Vec<f64>,
    pub first: Vec<f64>,
    pub second: Vec<f64>,
}

/// A path that no curve follows.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum CurveError {
    #[error("a path for a curve needs at least one configuration, all of one length and finite")]
    Malformed,
    #[error("the spacing of the control points is {0}; it must be greater than 0")]
    Spacing(f64),
}

impl Curve {
    /// A curve along `path` with control points at most `spacing` apart, in the Euclidean metric of joint space.
    ///
    /// # Errors
    /// If the path has no configurations, or some that are not finite or of another length.
    pub fn along(path: &[Vec<f64>], spacing: f64, corners: Corners) -> Result<Self, CurveError> {
        if spacing.is_nan() || spacing <= 0.0 {
            return Err(CurveError::Spacing(spacing));
        }
        let first = path.first().ok_or(CurveError::Malformed)?;
        let sound = |point: &Vec<f64>| point.len() == first.len() && point.iter().all(|p| p.is_finite());
        if first.is_empty() || !path.iter().all(sound) {
            return Err(CurveError::Malformed);
        }
        let mut controls = vec![first.clone()];
        for (index, ends) in path.windows(2).enumerate() {
            // Three equal control points: the curve passes through them, along the path, and has no derivatives there.
            if index > 0 && corners == Corners::Stopped {
                controls.extend([ends[0].clone(), ends[0].clone()]);
            }
            let length = ends[0].iter().zip(&ends[1]).map(|(a, b)| (b - a).powi(2)).sum::<f64>().sqrt();
            // A path may stay where it is; a curve with two equal control points would come to a rest there.
            let count = (length / spacing).ceil() as usize;
            let share = |k: usize| k as f64 / count as f64;
            controls.extend((1..=count).map(|k| mix(&[(1.0 - share(k), &ends[0]), (share(k), &ends[1])])));
        }
        Ok(Self::with_controls(&controls))
    }

    /// The curve of these control points, continued beyond both ends so that it begins and ends on them.
    fn with_controls(controls: &[Vec<f64>]) -> Self {
        let last = controls.len() - 1;
        let control = |index: isize| -> Vec<f64> {
            let beyond = |end: usize, inner: usize| mix(&[(2.0, &controls[end]), (-1.0, &controls[inner])]);
            match usize::try_from(index) {
                Err(_) => beyond(0, 1.min(last)),
                Ok(index) if index > last => beyond(last, last.saturating_sub(1)),
                Ok(index) => controls[index].clone(),
            }
        };
        let spans = (0..last as isize).map(|k| {
            let [a, b, c, d] = [k - 1, k, k + 1, k + 2].map(control);
            let of = |weights: [f64; 4]| {
                let [wa, wb, wc, wd] = weights.map(|weight| weight / 6.0);
                mix(&[(wa, &a), (wb, &b), (wc, &c), (wd, &d)])
            };
            [[1.0, 4.0, 1.0, 0.0], [-3.0, 0.0, 3.0, 0.0], [3.0, -6.0, 3.0, 0.0], [-1.0, 3.0, -3.0, 1.0]]
                .map(of)
        });
        let spans: Vec<_> = spans.collect();
        // A path of one configuration is a curve that stays there.
        let rest = || vec![0.0; controls[0].len()];
        Self {
            spans: if spans.is_empty() { vec![[controls[0].clone(), rest(), rest(), rest()]] } else { spans },
        }
    }

    /// The number of spans between knots, which is the end of the parameter's range.
    pub fn span_count(&self) -> usize {
        self.spans.len()
    }

    /// The number of joints.
    pub fn dof(&self) -> usize {
        self.spans[0][0].len()
    }

    /// The position and derivatives at a parameter, which is limited to the range of the curve.
    pub fn at(&self, parameter: f64) -> CurvePoint {
        let parameter = parameter.clamp(0.0, self.spans.len() as f64);
        let span = (parameter as usize).min(self.spans.len() - 1);
        let w = parameter - span as f64;
        let [a, b, c, d] = &self.spans[span];
        CurvePoint {
            position: mix(&[(1.0, a), (w, b), (w * w, c), (w * w * w, d)]),
            first: mix(&[(1.0, b), (2.0 * w, c), (3.0 * w * w, d)]),
            second: mix(&[(2.0, c), (6.0 * w, d)]),
        }
    }
}

/// The weighted sum of vectors.
fn mix(terms: &[(f64, &Vec<f64>)]) -> Vec<f64> {
    let length = terms.first().map_or(0, |(_, vector)| vector.len());
    (0..length).map(|joint| terms.iter().map(|(weight, vector)| weight * vector[joint]).sum()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn corner() -> Vec<Vec<f64>> {
        vec![vec![0.0, 0.0], vec![1.0, 0.0], vec![1.0, 2.0]]
    }

    #[test]
    fn the_curve_begins_and_ends_with_the_path_and_stays_near() {
        let curve = Curve::along(&corner(), 0.1, Corners::Rounded).expect("a curve");
        let end = curve.span_count() as f64;
        for (parameter, expected) in [(0.0, [0.0, 0.0]), (end, [1.0, 2.0]), (5.0, [0.5, 0.0])] {
            let position = curve.at(parameter).position;
            assert!((position[0] - expected[0]).hypot(position[1] - expected[1]) < 1e-12, "{position:?}");
        }
        let off = (0..3000).map(|k| curve.at(end * f64::from(k) / 3000.0).position);
        let off = off.map(|p| p[1].abs().min((p[0] - 1.0).abs())).fold(0.0, f64::max);
        assert!((0.005..0.1 / 3.0).contains(&off), "{off}");
    }

    #[test]
    fn derivatives_are_those_of_the_position_and_continuous() {
        let curve = Curve::along(&corner(), 0.3, Corners::Rounded).expect("a curve");
        let step = 1e-5;
        for k in 1..100 {
            let parameter = curve.span_count() as f64 * f64::from(k) / 100.0;
            let [before, here, after] = [-step, 0.0, step].map(|d| curve.at(parameter + d));
            for joint in 0..2 {
                let first = (after.position[joint] - before.position[joint]) / (2.0 * step);
                let second = (after.first[joint] - before.first[joint]) / (2.0 * step);
                assert!(
                    (first - here.first[joint]).abs() < 1e-8 && (second - here.second[joint]).abs() < 1e-4
                );
            }
        }
    }

    #[test]
    fn a_curve_that_stops_at_corners_is_on_the_path() {
        let curve = Curve::along(&corner(), 0.3, Corners::Stopped).expect("a curve");
        for k in 0..=1000 {
            let position = curve.at(curve.span_count() as f64 * f64::from(k) / 1000.0).position;
            assert!(position[1].abs().min((position[0] - 1.0).abs()) < 1e-12, "{position:?}");
        }
    }

    #[test]
    fn a_path_that_stays_is_a_curve_that_stays() {
        let curve = Curve::along(&[vec![0.5, 1.0], vec![0.5, 1.0]], 0.1, Corners::Rounded).expect("a curve");
        assert_eq!(
            curve.at(0.7),
            CurvePoint { position: vec![0.5, 1.0], first: vec![0.0; 2], second: vec![0.0; 2] }
        );
    }

    #[test]
    fn malformed_paths_are_refused() {
        assert_eq!(Curve::along(&[], 0.1, Corners::Rounded), Err(CurveError::Malformed));
        assert_eq!(
            Curve::along(&[vec![0.0], vec![0.0, 1.0]], 0.1, Corners::Rounded),
            Err(CurveError::Malformed)
        );
        assert_eq!(Curve::along(&[vec![f64::NAN]], 0.1, Corners::Rounded), Err(CurveError::Malformed));
        assert_eq!(Curve::along(&corner(), 0.0, Corners::Rounded), Err(CurveError::Spacing(0.0)));
    }
}
