//! An oriented plane.

use glam::{DMat3, DVec3};

/// Points p with `normal . p = offset_m`; the normal points *above*.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Plane {
    /// Unit.
    pub normal: DVec3,
    pub offset_m: f64,
}

impl Plane {
    pub(super) fn through(point: DVec3, normal: DVec3) -> Self {
        Self { normal, offset_m: normal.dot(point) }
    }

    /// Signed distance of the point above the plane.
    pub(super) fn height_m(&self, point: DVec3) -> f64 {
        self.normal.dot(point) - self.offset_m
    }

    /// The same plane with the opposite normal.
    pub(super) fn flipped(&self) -> Self {
        Self { normal: -self.normal, offset_m: -self.offset_m }
    }

    /// The common point of three planes; `None` if two of them are nearly parallel.
    pub(super) fn meet(&self, b: &Plane, c: &Plane) -> Option<DVec3> {
        let rows = DMat3::from_cols(self.normal, b.normal, c.normal).transpose();
        (rows.determinant().abs() > 1e-3)
            .then(|| rows.inverse() * DVec3::new(self.offset_m, b.offset_m, c.offset_m))
    }
}
