//! Low-discrepancy numbers for the samples of a pixel: shuffled and scrambled Sobol pairs.
//!
//! Burley, "Practical hash-based Owen scrambling" (JCGT 9(4), 2020): every pair of numbers is the two-dimensional Sobol
//! sequence in an order and with a nested scrambling of its own, both from hashes. Pixels and pairs are independent of
//! each other, the samples of one pair are stratified at every power of two, and each number is uniform over the seeds,
//! so that means stay unbiased.

use glam::Vec2;

/// Numbers of one sample of one pixel, handed out in pairs.
pub struct Samples {
    index: u32,
    pixel: u32,
    pair: u32,
}

impl Samples {
    /// Sample `index` of a pixel. The numbers depend on nothing else.
    pub fn new(seed: u64, pixel: u32, index: u32) -> Self {
        let seed = hash(seed as u32 ^ hash((seed >> 32) as u32));
        Self { index, pixel: hash(pixel ^ seed), pair: 0 }
    }

    /// The next pair, each number in 0..1.
    #[inline]
    pub fn pair(&mut self) -> Vec2 {
        let seed = hash(self.pixel ^ self.pair.wrapping_mul(0x9e37_79b9));
        self.pair += 1;
        let index = scrambled(self.index, seed);
        let x = scrambled(index.reverse_bits(), hash(seed ^ 0x68bc_21eb));
        let y = scrambled(second_sobol(index), hash(seed ^ 0x02e5_be93));
        Vec2::new(fraction(x), fraction(y))
    }
}

fn fraction(bits: u32) -> f32 {
    (bits >> 8) as f32 * (1.0 / 16_777_216.0)
}

/// Second dimension of Sobol's sequence. Its generator matrix is Pascal's triangle modulo 2, whose product with a
/// vector of bits is a sum over supersets, five steps in all.
#[inline]
fn second_sobol(index: u32) -> u32 {
    let mut x = index;
    x ^= (x & 0xaaaa_aaaa) >> 1;
    x ^= (x & 0xcccc_cccc) >> 2;
    x ^= (x & 0xf0f0_f0f0) >> 4;
    x ^= (x & 0xff00_ff00) >> 8;
    x ^= (x & 0xffff_0000) >> 16;
    x.reverse_bits()
}

/// Owen's nested uniform scrambling by the permutation of Laine and Karras, with Burley's constants.
#[inline]
fn scrambled(x: u32, seed: u32) -> u32 {
    let mut x = x.reverse_bits().wrapping_add(seed);
    x ^= x.wrapping_mul(0x6c50_b47c);
    x ^= x.wrapping_mul(0xb82f_1e52);
    x ^= x.wrapping_mul(0xc7af_e638);
    x ^= x.wrapping_mul(0x8d22_f6e6);
    x.reverse_bits()
}

/// Wellons' "lowbias32".
#[inline]
fn hash(x: u32) -> u32 {
    let mut h = x.wrapping_add(0x7f4a_7c15);
    h ^= h >> 16;
    h = h.wrapping_mul(0x7feb_352d);
    h ^= h >> 15;
    h = h.wrapping_mul(0x846c_a68b);
    h ^ (h >> 16)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn second_sobol_equals_its_direction_numbers() {
        for index in [0_u32, 1, 2, 3, 5, 77, 1 << 20, 0xdead_beef, u32::MAX] {
            let (mut direct, mut direction) = (0, 1_u32 << 31);
            for bit in 0..32 {
                if index >> bit & 1 == 1 {
                    direct ^= direction;
                }
                direction ^= direction >> 1;
            }
            assert_eq!(second_sobol(index), direct, "{index:#x}");
        }
    }

    #[test]
    fn every_elementary_interval_holds_one_sample() {
        for pair in 0..3 {
            for columns in [1, 2, 4, 8, 16_usize] {
                let mut filled = [0; 16];
                for index in 0..16 {
                    let mut samples = Samples::new(3, 1234, index);
                    (0..pair).for_each(|_| _ = samples.pair());
                    let p = samples.pair();
                    let rows = 16 / columns;
                    let cell = (p.x * columns as f32) as usize * rows + (p.y * rows as f32) as usize;
                    filled[cell] += 1;
                }
                assert_eq!(filled, [1; 16], "{columns} columns");
            }
        }
    }

    #[test]
    fn pixels_and_seeds_have_numbers_of_their_own() {
        let first = |seed: u64, pixel: u32| Samples::new(seed, pixel, 0).pair();
        let mean = (0..4096).map(|pixel| first(1, pixel)).sum::<Vec2>() / 4096.0;
        assert!(mean.abs_diff_eq(Vec2::splat(0.5), 0.02), "{mean}");
        assert_ne!(first(1, 7), first(2, 7));
        assert_ne!(first(1, 7), first(1 << 32, 7));
    }
}
