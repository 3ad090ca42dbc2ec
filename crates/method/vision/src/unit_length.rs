//! Features scaled to length 1, so that the dot product of two is their cosine.

/// Smallest length that still has a direction; that of features of networks is about 1 to 100.
const MIN_LENGTH: f64 = 1e-12;

/// The vector divided by its length, sums in double precision; `None` for one that has no length or is not finite.
pub(crate) fn to_unit_length(mut features: Vec<f32>) -> Option<Vec<f32>> {
    let length = features.iter().map(|v| f64::from(*v).powi(2)).sum::<f64>().sqrt();
    if !length.is_finite() || length < MIN_LENGTH {
        return None;
    }
    features.iter_mut().for_each(|v| *v = (f64::from(*v) / length) as f32);
    Some(features)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn vectors_without_direction_are_refused() {
        assert_eq!(to_unit_length(vec![3.0, -4.0]), Some(vec![0.6, -0.8]));
        for useless in [vec![0.0, 0.0], vec![f32::NAN, 1.0], vec![f32::INFINITY, 1.0], vec![]] {
            assert_eq!(to_unit_length(useless), None);
        }
    }
}
