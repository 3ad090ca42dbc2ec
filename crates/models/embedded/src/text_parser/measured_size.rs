//! Sizes from the lengths of a text.

use glam::DVec3;

use super::measures::{Axis, Measure};

/// Applies the lengths of the text to a size. A single length scales all extents and keeps proportions; several lengths
/// set their own extents.
pub(super) fn apply(measures: &[Measure], size_m: DVec3) -> DVec3 {
    let mut size = size_m;
    let horizontal = if size.x >= size.y { 0 } else { 1 };
    let index = |axis: Axis, size: DVec3| match axis {
        Axis::Width | Axis::Diameter => 0,
        Axis::Depth => 1,
        Axis::Height => 2,
        Axis::Length => horizontal,
        Axis::Unspecified => {
            let largest = size.max_element();
            (0..3).find(|&k| size[k] == largest).unwrap_or(0)
        }
    };
    if let [measure] = measures {
        let k = index(measure.axis, size);
        size *= measure.meters / size[k].max(1e-6);
    } else {
        for measure in measures {
            let k = index(measure.axis, size_m);
            size[k] = measure.meters;
            if measure.axis == Axis::Diameter {
                size.y = measure.meters;
            }
        }
    }
    size
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_length_keeps_proportions_and_several_set_their_extents() {
        let typical = DVec3::new(0.1, 0.05, 0.1);
        let measure = |axis, meters| Measure { axis, meters };
        for (measures, expected) in [
            (vec![measure(Axis::Height, 0.2)], DVec3::new(0.2, 0.1, 0.2)),
            (
                vec![measure(Axis::Width, 0.3), measure(Axis::Depth, 0.2), measure(Axis::Height, 0.1)],
                DVec3::new(0.3, 0.2, 0.1),
            ),
            (vec![measure(Axis::Diameter, 0.08), measure(Axis::Height, 0.12)], DVec3::new(0.08, 0.08, 0.12)),
        ] {
            assert!((apply(&measures, typical) - expected).length() < 1e-12, "{measures:?}");
        }
    }
}
