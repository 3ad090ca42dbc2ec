//! `track.json`: how the bodies moved while the certificate watched them, for replay by a viewer.

use std::collections::BTreeMap;

use serde::Serialize;

use crate::pipeline::error::StageError;
use geometry::Pose;
use physics::Stability;
use physics::settle::TRACK_HZ;

/// Parts of a meter, and of a component of a quaternion, that numbers are rounded to.
const PARTS: f64 = 1e5;

/// The simulations of the certificate.
#[derive(Serialize)]
pub(super) struct Tracks<'a> {
    /// Poses per second of each track.
    rate_hz: f64,
    /// Length of each simulation, seconds.
    duration_s: f64,
    /// From the poses that the scene ships: what its `dss_shipped` is measured on.
    from_shipped: Track<'a>,
    /// From the poses before anything was pushed apart or dropped: what its `dss_aligned` is measured on.
    #[serde(skip_serializing_if = "Option::is_none")]
    from_aligned: Option<Track<'a>>,
}

/// By body: `[x, y, z, qx, qy, qz, qw]` of `world_from_object`, meters and a unit quaternion, from the start until
/// it stays where it is.
type Track<'a> = BTreeMap<&'a str, Vec<[f64; 7]>>;

impl<'a> Tracks<'a> {
    /// Tracks of bodies with these names, in the order of the simulations.
    pub(super) fn new(
        names: &[&'a str],
        duration_s: f64,
        from_shipped: &Stability,
        from_aligned: Option<&Stability>,
    ) -> Self {
        let track = |found: &Stability| {
            let poses = found.track.iter().map(|poses| moving_part(poses));
            names.iter().copied().zip(poses).collect()
        };
        Self {
            rate_hz: TRACK_HZ,
            duration_s,
            from_shipped: track(from_shipped),
            from_aligned: from_aligned.map(track),
        }
    }

    /// Compact JSON, with a line break at its end.
    pub(super) fn to_json(&self) -> Result<Vec<u8>, StageError> {
        let mut bytes = serde_json::to_vec(self).map_err(|error| {
            StageError::permanent("artifact_not_storable", "the settle track cannot be written as JSON")
                .because(error)
        })?;
        bytes.push(b'\n');
        Ok(bytes)
    }
}

/// The poses up to the first of those that equal the last.
fn moving_part(poses: &[Pose]) -> Vec<[f64; 7]> {
    let mut rows: Vec<[f64; 7]> = poses.iter().map(row).collect();
    while let [.., before, last] = &rows[..] {
        if before != last {
            break;
        }
        rows.pop();
    }
    rows
}

fn row(pose: &Pose) -> [f64; 7] {
    let [x, y, z] = pose.translation_m.to_array();
    let [qx, qy, qz, qw] = pose.rotation.to_array();
    // Adding zero turns -0 into 0.
    [x, y, z, qx, qy, qz, qw].map(|value| (value * PARTS).round() / PARTS + 0.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;

    fn at(x_m: f64) -> Pose {
        Pose::upright(DVec3::new(x_m, 0.0, 0.0), 0.0)
    }

    #[test]
    fn a_track_ends_where_its_body_stays() {
        let falls = [at(0.0), at(0.01), at(0.02), at(0.020_000_1), at(0.02)];
        let rows = moving_part(&falls);
        assert_eq!(rows.len(), 3);
        assert_eq!(rows[2], [0.02, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0]);
        assert_eq!(moving_part(&[at(0.3), at(0.3)]).len(), 1);
    }
}
