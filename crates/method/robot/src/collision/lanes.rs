//! Eight `f32` at a time, with the widest instructions of the processor that runs the program.
//!
//! The collision checks are written once, over [`Lanes`]. [`Backend`] is chosen at run time: AVX2 where the processor
//! has it, else the baseline that the program was compiled for. Both round alike, since neither fuses a product with a
//! sum: the same checks give the same answers on every machine.

use std::ops::{Add, Mul, Sub};

/// The number of configurations that are checked together.
pub const LANE_COUNT: usize = 8;

/// Eight numbers that are computed with at once.
pub trait Lanes: Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> {
    /// Proof that the processor can run the instructions.
    type Token: Copy;

    /// The same number in each lane.
    fn splat(token: Self::Token, value: f32) -> Self;
    fn from_array(token: Self::Token, values: [f32; LANE_COUNT]) -> Self;
    fn to_array(self) -> [f32; LANE_COUNT];
    /// The token that the value was made with.
    fn token(self) -> Self::Token;
    fn max(self, other: Self) -> Self;
    fn min(self, other: Self) -> Self;
    fn sqrt(self) -> Self;
    /// Bit `k` is set if lane `k` of `self` is less than lane `k` of `other`.
    fn below(self, other: Self) -> u8;

    /// The same number in each lane, with the token of `self`.
    #[inline(always)]
    fn like(self, value: f32) -> Self {
        Self::splat(self.token(), value)
    }

    #[inline(always)]
    fn abs(self) -> Self {
        self.max(self.like(0.0) - self)
    }

    /// The least lane.
    #[inline(always)]
    fn min_lane(self) -> f32 {
        let [a, b, c, d, e, f, g, h] = self.to_array();
        (a.min(e).min(c.min(g))).min(b.min(f).min(d.min(h)))
    }

    /// The greatest lane.
    #[inline(always)]
    fn max_lane(self) -> f32 {
        let [a, b, c, d, e, f, g, h] = self.to_array();
        (a.max(e).max(c.max(g))).max(b.max(f).max(d.max(h)))
    }
}

/// A computation that runs on either kind of lanes.
pub trait LaneTask {
    type Output;

    /// Must be `#[inline(always)]`, as must be all that it calls: only then is it compiled for the instructions.
    fn run<L: Lanes>(self, token: L::Token) -> Self::Output;
}

/// Instructions that the checks use.
#[derive(Clone, Copy, Debug)]
pub enum Backend {
    /// Instructions that the program was compiled for.
    Baseline,
    /// AVX2: one instruction for eight lanes.
    #[cfg(target_arch = "x86_64")]
    Avx2(pulp::x86::V3),
}

impl Backend {
    /// The fastest that this processor runs.
    pub fn fastest() -> Self {
        #[cfg(target_arch = "x86_64")]
        if let Some(token) = pulp::x86::V3::try_new() {
            return Self::Avx2(token);
        }
        Self::Baseline
    }

    /// Runs a computation with these instructions.
    #[inline]
    pub fn run<T: LaneTask>(self, task: T) -> T::Output {
        match self {
            Self::Baseline => task.run::<BaselineLanes>(()),
            #[cfg(target_arch = "x86_64")]
            Self::Avx2(token) => token.vectorize(avx2::Entry { token, task }),
        }
    }
}

/// Lanes in the instructions that the program was compiled for.
#[derive(Clone, Copy)]
pub struct BaselineLanes(wide::f32x8);

macro_rules! baseline_operator {
    ($trait:ident, $method:ident) => {
        impl $trait for BaselineLanes {
            type Output = Self;

            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                Self($trait::$method(self.0, other.0))
            }
        }
    };
}
baseline_operator!(Add, add);
baseline_operator!(Sub, sub);
baseline_operator!(Mul, mul);

impl Lanes for BaselineLanes {
    type Token = ();

    #[inline(always)]
    fn splat((): (), value: f32) -> Self {
        Self(wide::f32x8::splat(value))
    }

    #[inline(always)]
    fn from_array((): (), values: [f32; LANE_COUNT]) -> Self {
        Self(wide::f32x8::new(values))
    }

    #[inline(always)]
    fn to_array(self) -> [f32; LANE_COUNT] {
        self.0.to_array()
    }

    #[inline(always)]
    fn token(self) {}

    #[inline(always)]
    fn max(self, other: Self) -> Self {
        Self(self.0.fast_max(other.0))
    }

    #[inline(always)]
    fn min(self, other: Self) -> Self {
        Self(self.0.fast_min(other.0))
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        Self(self.0.sqrt())
    }

    #[inline(always)]
    fn below(self, other: Self) -> u8 {
        self.0.simd_lt(other.0).to_bitmask() as u8
    }
}

#[cfg(target_arch = "x86_64")]
mod avx2 {
    use std::ops::{Add, Mul, Sub};

    use pulp::x86::V3;
    use pulp::{NullaryFnOnce, Simd, f32x8};

    use super::{LANE_COUNT, LaneTask, Lanes};

    /// A task on its way into the function that is compiled for AVX2.
    pub struct Entry<T> {
        pub token: V3,
        pub task: T,
    }

    impl<T: LaneTask> NullaryFnOnce for Entry<T> {
        type Output = T::Output;

        #[inline(always)]
        fn call(self) -> T::Output {
            self.task.run::<Avx2Lanes>(self.token)
        }
    }

    /// Lanes in one AVX register.
    #[derive(Clone, Copy)]
    pub struct Avx2Lanes {
        token: V3,
        values: f32x8,
    }

    macro_rules! avx2_operator {
        ($trait:ident, $method:ident, $instruction:ident) => {
            impl $trait for Avx2Lanes {
                type Output = Self;

                #[inline(always)]
                fn $method(self, other: Self) -> Self {
                    Self { token: self.token, values: self.token.$instruction(self.values, other.values) }
                }
            }
        };
    }
    avx2_operator!(Add, add, add_f32s);
    avx2_operator!(Sub, sub, sub_f32s);
    avx2_operator!(Mul, mul, mul_f32s);

    impl Lanes for Avx2Lanes {
        type Token = V3;

        #[inline(always)]
        fn splat(token: V3, value: f32) -> Self {
            Self { token, values: token.splat_f32s(value) }
        }

        #[inline(always)]
        fn from_array(token: V3, [a, b, c, d, e, f, g, h]: [f32; LANE_COUNT]) -> Self {
            Self { token, values: f32x8(a, b, c, d, e, f, g, h) }
        }

        #[inline(always)]
        fn to_array(self) -> [f32; LANE_COUNT] {
            let f32x8(a, b, c, d, e, f, g, h) = self.values;
            [a, b, c, d, e, f, g, h]
        }

        #[inline(always)]
        fn token(self) -> V3 {
            self.token
        }

        #[inline(always)]
        fn max(self, other: Self) -> Self {
            Self { token: self.token, values: self.token.max_f32s(self.values, other.values) }
        }

        #[inline(always)]
        fn min(self, other: Self) -> Self {
            Self { token: self.token, values: self.token.min_f32s(self.values, other.values) }
        }

        #[inline(always)]
        fn sqrt(self) -> Self {
            Self { token: self.token, values: self.token.sqrt_f32s(self.values) }
        }

        #[inline(always)]
        fn abs(self) -> Self {
            Self { token: self.token, values: self.token.abs_f32x8(self.values) }
        }

        #[inline(always)]
        fn below(self, other: Self) -> u8 {
            let less = self.token.cmp_lt_f32x8(self.values, other.values);
            self.token.avx._mm256_movemask_ps(pulp::cast(less)) as u8
        }

        #[inline(always)]
        fn min_lane(self) -> f32 {
            self.token.reduce_min_f32s(self.values)
        }

        #[inline(always)]
        fn max_lane(self) -> f32 {
            self.token.reduce_max_f32s(self.values)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    struct Everything;

    impl LaneTask for Everything {
        type Output = (Vec<[f32; LANE_COUNT]>, u8, f32, f32);

        #[inline(always)]
        fn run<L: Lanes>(self, token: L::Token) -> Self::Output {
            let a = L::from_array(token, [0.1, -0.2, 3.0, 4.0, -5.5, 6.25, 7.125, 8.0]);
            let b = L::splat(token, 0.3);
            let values = [a + b, a - b, a * b, a.max(b), a.min(b), a.abs(), a.abs().sqrt(), a.like(2.0)];
            (values.map(L::to_array).to_vec(), a.below(b), a.min_lane(), a.max_lane())
        }
    }

    #[test]
    fn every_backend_gives_the_same_bits() {
        let baseline = Backend::Baseline.run(Everything);
        assert_eq!(baseline.0[0][1], -0.2 + 0.3);
        assert_eq!(baseline.0[5][4], 5.5);
        assert_eq!((baseline.1, baseline.2, baseline.3), (0b0001_0011, -5.5, 8.0));
        assert_eq!(Backend::fastest().run(Everything), baseline);
    }
}
