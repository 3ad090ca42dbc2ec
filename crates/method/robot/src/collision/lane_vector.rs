//! Eight vectors at a time.
//!
//! Code on lanes has no closures: a closure is a function of its own, which is not compiled for the instructions.

use std::ops::{Add, Sub};

use super::lanes::Lanes;

/// A vector in each lane.
#[derive(Clone, Copy)]
pub struct LaneVector<L> {
    pub x: L,
    pub y: L,
    pub z: L,
}

impl<L: Lanes> LaneVector<L> {
    /// The same vector in each lane.
    #[inline(always)]
    pub fn splat(token: L::Token, [x, y, z]: [f32; 3]) -> Self {
        Self { x: L::splat(token, x), y: L::splat(token, y), z: L::splat(token, z) }
    }

    /// The vector of each lane times the number of the lane.
    #[inline(always)]
    pub fn times(self, factor: L) -> Self {
        Self { x: self.x * factor, y: self.y * factor, z: self.z * factor }
    }

    /// The vector of each lane times a number.
    #[inline(always)]
    pub fn scaled(self, factor: f32) -> Self {
        self.times(self.x.like(factor))
    }

    /// The vector of each lane minus a vector.
    #[inline(always)]
    pub fn minus(self, [x, y, z]: [f32; 3]) -> Self {
        Self { x: self.x - self.x.like(x), y: self.y - self.y.like(y), z: self.z - self.z.like(z) }
    }

    /// The dot product with a vector.
    #[inline(always)]
    pub fn dot(self, [x, y, z]: [f32; 3]) -> L {
        self.x * self.x.like(x) + self.y * self.y.like(y) + self.z * self.z.like(z)
    }

    /// The squared length.
    #[inline(always)]
    pub fn square(self) -> L {
        self.x * self.x + self.y * self.y + self.z * self.z
    }
}

impl<L: Lanes> Add for LaneVector<L> {
    type Output = Self;

    #[inline(always)]
    fn add(self, other: Self) -> Self {
        Self { x: self.x + other.x, y: self.y + other.y, z: self.z + other.z }
    }
}

impl<L: Lanes> Sub for LaneVector<L> {
    type Output = Self;

    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        Self { x: self.x - other.x, y: self.y - other.y, z: self.z - other.z }
    }
}
