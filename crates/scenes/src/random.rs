//! Pseudo-random numbers that are the same on every machine.
//!
//! Both halves are the finaliser of SplitMix64 (Steele, Lea & Flood, *Fast splittable
//! pseudorandom number generators*, OOPSLA 2014), on 64-bit whole numbers only:
//!
//! * [`Random`] is a stream: the state grows by the golden ratio, each output is the mixed state.
//!   Builders of scenes draw from it, in one fixed order.
//! * [`hash`] maps coordinates to a number without any state. Textures and sensor noise use it, so
//!   that a pixel's value does not depend on the order in which threads reach it.

use crate::vector::{Frame, Vector, vector};

const GOLDEN: u64 = 0x9e37_79b9_7f4a_7c15;

/// SplitMix64's finaliser: a bijection in which each input bit changes half of the output bits.
#[inline]
fn mix(mut z: u64) -> u64 {
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

/// A cell's coordinates in one number, linear in each. Odd multipliers keep neighbours apart.
#[inline]
pub(crate) fn key(x: i64, y: i64, z: i64) -> u64 {
    (x as u64)
        .wrapping_mul(GOLDEN)
        .wrapping_add((y as u64).wrapping_mul(0xc2b2_ae3d_27d4_eb4f))
        .wrapping_add((z as u64).wrapping_mul(0x1656_67b1_9e37_79f9))
}

/// A number that looks random and depends on nothing but its arguments.
#[inline]
pub(crate) fn hash(seed: u64, x: i64, y: i64, z: i64) -> u64 {
    mix(seed.wrapping_add(key(x, y, z)))
}

/// A word as a number, to keep the numbers that one seed gives for different purposes apart: FNV-1a
/// (Fowler, Noll & Vo) of its bytes.
pub(crate) const fn salt(word: &str) -> u64 {
    let bytes = word.as_bytes();
    let mut hash = 0xcbf2_9ce4_8422_2325u64;
    let mut i = 0;
    while i < bytes.len() {
        hash = (hash ^ bytes[i] as u64).wrapping_mul(0x0000_0100_0000_01b3);
        i += 1;
    }
    hash
}

/// A hash as a number in [0, 1), from its upper 53 bits.
#[inline]
pub(crate) fn unit(hash: u64) -> f64 {
    (hash >> 11) as f64 * (1.0 / (1u64 << 53) as f64)
}

/// A hash as a number of mean 0 and deviation 1, nearly normal: the sum of eight uniform 16-bit
/// numbers (Irwin-Hall), which never leaves +-4.9 and needs no logarithm.
#[inline]
pub(crate) fn normal(hash: u64) -> f64 {
    let halves = |h: u64| (h & 0xffff) + (h >> 16 & 0xffff) + (h >> 32 & 0xffff) + (h >> 48);
    let sum = halves(hash) + halves(mix(hash ^ GOLDEN));
    // Each term has mean 32767.5 and variance (65536^2 - 1) / 12.
    const DEVIATION: f64 = 53_509.919_921_45; // sqrt(8 / 12 * (65536^2 - 1))
    (sum as f64 - 8.0 * 32_767.5) / DEVIATION
}

/// A stream of numbers from a seed: the same on every machine.
#[derive(Debug, Clone)]
pub struct Random {
    state: u64,
}

impl Random {
    /// The stream of a seed. The purpose keeps streams of one seed apart.
    pub fn new(seed: u64, purpose: &str) -> Self {
        Self { state: mix(seed ^ salt(purpose)) }
    }

    /// 64 random bits.
    pub fn bits(&mut self) -> u64 {
        self.state = self.state.wrapping_add(GOLDEN);
        mix(self.state)
    }

    /// Uniform in [0, 1).
    pub fn unit(&mut self) -> f64 {
        unit(self.bits())
    }

    /// Uniform in [low, high).
    pub fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }

    /// Of mean 0 and deviation 1, nearly normal, never beyond +-4.9.
    pub fn normal(&mut self) -> f64 {
        normal(self.bits())
    }

    /// True this often.
    pub fn chance(&mut self, probability: f64) -> bool {
        self.unit() < probability
    }

    /// Uniform in 0..n, which must not be empty.
    pub fn below(&mut self, n: usize) -> usize {
        ((self.unit() * n as f64) as usize).min(n - 1)
    }

    /// One of the items, which must not be empty.
    pub fn pick<T: Copy>(&mut self, items: &[T]) -> T {
        items[self.below(items.len())]
    }

    /// A uniformly distributed direction: a point of the cube, kept when it lies in the ball.
    pub(crate) fn direction(&mut self) -> Vector {
        loop {
            let v =
                vector(self.between(-1.0, 1.0), self.between(-1.0, 1.0), self.between(-1.0, 1.0));
            let square = v.dot(v);
            if square > 1e-4 && square <= 1.0 {
                return v.normalized();
            }
        }
    }

    /// A uniformly distributed turn (a quaternion drawn like [`Random::direction`]).
    pub(crate) fn frame(&mut self) -> Frame {
        loop {
            let w = self.between(-1.0, 1.0);
            let v =
                vector(self.between(-1.0, 1.0), self.between(-1.0, 1.0), self.between(-1.0, 1.0));
            let square = w * w + v.dot(v);
            if square > 1e-4 && square <= 1.0 {
                return Frame::turned(w, v);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_stream_is_splitmix64() {
        // The published test vector of SplitMix64 for the state 1234567.
        let mut random = Random { state: 1234567 };
        assert_eq!(random.bits(), 6457827717110365317);
        assert_eq!(random.bits(), 3203168211198807973);
        assert_eq!(random.bits(), 9817491932198370423);
    }

    #[test]
    fn salt_is_fnv_1a() {
        // The published test vectors of the 64-bit hash.
        assert_eq!(salt(""), 0xcbf2_9ce4_8422_2325);
        assert_eq!(salt("a"), 0xaf63_dc4c_8601_ec8c);
        assert_eq!(salt("foobar"), 0x8594_4171_f739_67e8);
    }

    #[test]
    fn normal_has_its_moments() {
        let n = 40_000;
        let (mut sum, mut squares) = (0.0, 0.0);
        for i in 0..n {
            let v = normal(hash(5, i, 0, 0));
            sum += v;
            squares += v * v;
        }
        assert!((sum / n as f64).abs() < 0.02);
        assert!((squares / n as f64 - 1.0).abs() < 0.03);
    }

    #[test]
    fn neighbouring_hashes_are_uncorrelated() {
        let n = 20_000;
        let mean: f64 = (0..n)
            .map(|i| (unit(hash(1, i, 7, 0)) - 0.5) * (unit(hash(1, i + 1, 7, 0)) - 0.5))
            .sum::<f64>()
            / n as f64;
        assert!(mean.abs() < 0.002, "{mean}");
    }

    #[test]
    fn below_stays_below() {
        let mut random = Random::new(0, "test");
        assert!((0..1000).all(|_| random.below(3) < 3));
    }
}
