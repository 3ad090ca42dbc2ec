//! Results of the yaw search.

use super::comparison::Place;

/// Result of a search over all yaws.
#[derive(Clone, Debug, PartialEq)]
pub struct YawSearchResult {
    /// (yaw in radians, loss) of the coarse search, in the order of yaw from 0.
    pub curve: Vec<(f64, f64)>,
    /// Refined poses, lowest loss first.
    pub top: Vec<PoseCandidate>,
}

/// A refined pose.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PoseCandidate {
    /// Yaw, radians, not wrapped.
    pub yaw_rad: f64,
    pub loss: f64,
    /// Placement in the image; `None` where the projected box is fitted to the mask's box.
    pub place: Option<Place>,
}
