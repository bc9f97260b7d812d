//! Sums of products of 16-bit numbers, two at a time: what neural networks in whole numbers are made of.
//!
//! ```text
//! s_l += a0 w_l0 + a1 w_l1
//! ```
//!
//! for 16 sums of 32 bits and a pair of numbers that all of them share. x86 has one instruction for the
//! two products and their sum, and with VNNI for all of it, but the compiler makes neither of plain loops
//! in which one factor is shared. So they are written out per level. Whole numbers have one right
//! answer: all levels agree as long as nothing overflows.
//!
//! Samples have [`FRACTION`] bits behind the point, and weights as many as no sum can overflow with
//! ([`Weighing`]).
//!
//! A kernel asks for it in brackets, see [`at_every_level!`](super::level::at_every_level).

use super::aligned::Line;
use super::bits::Bits;
use super::look_up::LookUp;
use super::nearness::Nearness;
use super::neurons::Neurons;
use super::records::Records;
use super::rounding::nearest;
use super::unlike::Unlike;

/// Sums that are kept together.
pub(crate) const LANES: usize = 16;
/// Bits of a sample behind the point: samples reach from -64 to 64.
pub(crate) const FRACTION: u32 = 9;
/// The smallest and the largest sample.
pub(crate) const LEAST: i32 = i16::MIN as i32;
const LARGEST: i32 = i16::MAX as i32;
/// The sample that stands for 1.
pub(crate) const ONE: f32 = (1 << FRACTION) as f32;

/// The sample that stands for a number, of 16 bits; what is larger than samples can be is as good as the
/// largest.
#[inline(always)]
pub(crate) fn sample(number: f32) -> i32 {
    let scaled = number * ONE;
    let scaled = if scaled > -32768.0 { scaled } else { -32768.0 };
    nearest(if scaled < 32767.0 { scaled } else { 32767.0 })
}

/// Weighted sums in whole numbers: as many bits behind the point as no sum can overflow with, whatever
/// the samples.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Weighing(u32);

impl Weighing {
    /// For sums with these weights, each and an offset.
    pub fn of<W: IntoIterator<Item = f32>>(sums: impl Iterator<Item = (W, f32)>) -> Self {
        // Samples reach to 64, so of an offset as much remains. Weights are rounded.
        let (mut most, mut largest) = (0.0f32, 0.0f32);
        let mut terms = 0;
        for (weights, offset) in sums {
            let (mut all, mut count) = (offset.abs() / 64.0, 0);
            for weight in weights {
                (all, count) = (all + weight.abs(), count + 1);
                largest = largest.max(weight.abs());
            }
            (most, terms) = (most.max(all), terms.max(count));
        }
        let fits = |fraction: &u32| {
            let one = (1 << fraction) as f32;
            one * largest < 32766.0 && one * most + 0.5 * terms as f32 + 2.0 < 65535.0
        };
        Self((1..15).rev().find(fits).expect("weights are not so large"))
    }

    /// A weight, of 16 bits.
    pub fn weight(self, number: f32) -> i32 {
        ((1 << self.0) as f32 * number).round_ties_even() as i32
    }

    /// What is added to a sum that begins with it, and half a unit for rounding.
    pub fn offset(self, number: f32) -> i32 {
        self.part(number) + (1 << (self.0 - 1))
    }

    /// What is added to a sum.
    pub fn part(self, number: f32) -> i32 {
        ((1 << self.0) as f32 * ONE * number).round_ties_even() as i32
    }

    /// The sample that stands for a sum, but `least` if it is smaller.
    #[inline(always)]
    pub fn sample(self, sum: i32, least: i32) -> i32 {
        let sum = sum >> self.fraction();
        let sum = if sum > least { sum } else { least };
        if sum < LARGEST { sum } else { LARGEST }
    }

    /// So many bits of a sum are behind those of a sample.
    #[inline(always)]
    pub(in crate::kernels) fn fraction(self) -> u32 {
        self.0
    }

    /// The number that 1 in a sum stands for.
    pub fn unit(self) -> f32 {
        1.0 / ((1 << self.0) as f32 * ONE)
    }
}

/// Two numbers that all sums share: samples or weights.
pub(crate) type Pair = [i16; 2];

/// Two numbers of 16 bits in one of 32, the first in the lower half: those of one sum. Numbers of many
/// sums are put together faster so than as two of 16.
#[inline(always)]
pub(crate) fn packed(one: i32, other: i32) -> i32 {
    other << 16 | one & 0xFFFF
}

/// The pairs of all sums, number by number.
pub(crate) type Numbers = Line<[i16; 2 * LANES]>;

/// A whole number for each lane.
pub(crate) type Sums = Line<[i32; LANES]>;
/// A number for each lane.
pub(crate) type Lanes = Line<[f32; LANES]>;

/// What adds pairs of products at one level.
pub(crate) trait Products: Bits + LookUp + Nearness + Neurons + Records + Unlike {
    /// The samples that stand for two numbers of each lane, [`packed`]. No number is larger than samples can be; in
    /// lanes that nobody reads it may be NaN.
    fn pairs(self, numbers: &[Lanes; 2]) -> Sums;

    /// Adds to each sum both products of its own [`packed`] pair with the pair that all share.
    fn add(self, sums: &mut [i32; LANES], shared: Pair, own: &[i32; LANES]);

    /// The same, pair after pair, for sums that grow together: all of them see the same pairs of the lanes, and
    /// share pairs of their own. Those of a vector stay in registers from the first pair to the last.
    fn add_all<const N: usize>(self, sums: &mut [Sums; N], shared: &[[Pair; N]], own: &[Sums]);
}

/// The definition, which the compiler vectorises where nothing better is written out.
#[cfg(any(test, not(target_arch = "x86_64")))]
#[derive(Clone, Copy)]
pub(crate) struct Plain;

#[cfg(all(test, target_arch = "x86_64"))]
impl Bits for Plain {}

#[cfg(all(test, target_arch = "x86_64"))]
impl LookUp for Plain {}

#[cfg(any(test, not(target_arch = "x86_64")))]
impl Products for Plain {
    #[inline(always)]
    fn pairs(self, [one, other]: &[Lanes; 2]) -> Sums {
        let fits = |number: &f32| number.abs() < 64.0 || number.is_nan();
        debug_assert!(one.iter().chain(&**other).all(fits), "{one:?}, {other:?}");
        Line(std::array::from_fn(|l| packed(sample(one[l]), sample(other[l]))))
    }

    #[inline(always)]
    fn add(self, sums: &mut [i32; LANES], shared: Pair, own: &[i32; LANES]) {
        for (sum, &own) in sums.iter_mut().zip(own) {
            *sum +=
                i32::from(shared[0]) * i32::from(own as i16) + i32::from(shared[1]) * (own >> 16);
        }
    }

    #[inline(always)]
    fn add_all<const N: usize>(self, sums: &mut [Sums; N], shared: &[[Pair; N]], own: &[Sums]) {
        for (shared, own) in shared.iter().zip(own) {
            for (sums, shared) in sums.iter_mut().zip(shared) {
                self.add(sums, *shared, own);
            }
        }
    }
}

#[cfg(not(target_arch = "x86_64"))]
#[allow(unsafe_code)]
impl Plain {
    /// # Safety
    ///
    /// It needs no level; the others do.
    pub unsafe fn new() -> Self {
        Self
    }
}

#[cfg(not(target_arch = "x86_64"))]
pub(crate) use self::Plain as Baseline;
/// Every x86 of 64 bits has it.
#[cfg(target_arch = "x86_64")]
pub(crate) use self::x86::Sse2 as Baseline;
#[cfg(target_arch = "x86_64")]
pub(crate) use self::x86::{Avx2, Avx512};

#[cfg(target_arch = "x86_64")]
#[allow(unsafe_code)]
mod x86 {
    use std::arch::x86_64::*;
    use std::mem::transmute;

    use super::{LANES, Lanes, Line, Pair, Products, Sums};

    /// What vectors are read from and written to.
    ///
    /// # Safety
    ///
    /// As long as a number of 32 bits for each lane; all bits belong to it, and any bits are such a value.
    pub(in crate::kernels) unsafe trait AnyBits {}

    // SAFETY: numbers hold any bits, and all of them are as many bytes.
    unsafe impl AnyBits for [f32; LANES] {}
    unsafe impl AnyBits for [i32; LANES] {}
    unsafe impl AnyBits for [u32; LANES] {}
    unsafe impl AnyBits for [i16; 2 * LANES] {}

    /// Defines a level's type, of which there is a value only where the processor has that level.
    macro_rules! level {
        (
            $name:ident, $registers:literal, $sums:ident, $same:ident, |$sum:ident, $one:ident, $other:ident| $add:expr,
            $numbers:ident, |$a:ident, $b:ident| $pairs:expr
        ) => {
            #[derive(Clone, Copy)]
            pub(crate) struct $name(());

            impl $name {
                /// # Safety
                ///
                /// The processor must have this level.
                #[inline(always)]
                pub unsafe fn new() -> Self {
                    Self(())
                }

                /// Registers that sums which grow together may fill: half of all.
                pub(in crate::kernels) const REGISTERS: usize = $registers;

                /// How many vectors the sums of all lanes are.
                pub(in crate::kernels) const PARTS: usize =
                    size_of::<[i32; LANES]>() / size_of::<$sums>();

                /// A part of the numbers of all lanes.
                #[inline(always)]
                pub(in crate::kernels) fn read<A: AnyBits>(
                    self,
                    numbers: &Line<A>,
                    part: usize,
                ) -> $sums {
                    assert!(part < Self::PARTS);
                    // SAFETY: the part lies within the numbers, which are as long as all parts, and any vector holds
                    // their bits.
                    unsafe { std::ptr::from_ref(numbers).cast::<$sums>().add(part).read() }
                }

                /// Writes a part of them.
                #[inline(always)]
                pub(in crate::kernels) fn write<A: AnyBits>(
                    self,
                    numbers: &mut Line<A>,
                    part: usize,
                    of_part: $sums,
                ) {
                    assert!(part < Self::PARTS);
                    // SAFETY: as in `read`, and numbers hold any bits.
                    unsafe { std::ptr::from_mut(numbers).cast::<$sums>().add(part).write(of_part) }
                }

                /// Sums, and the products of two vectors.
                #[inline(always)]
                pub(in crate::kernels) fn plus(
                    self,
                    $sum: $sums,
                    $one: $sums,
                    $other: $sums,
                ) -> $sums {
                    // SAFETY: whoever made `self` vouched for the instructions.
                    unsafe { $add }
                }
            }

            impl Products for $name {
                #[inline(always)]
                fn pairs(self, [one, other]: &[Lanes; 2]) -> Sums {
                    let mut pairs = Line([0; LANES]);
                    for part in 0..Self::PARTS {
                        // SAFETY: as in `plus`, and both sides of a transmutation are sixteen plain numbers or fewer.
                        let of_part = unsafe {
                            let $a = transmute::<$sums, $numbers>(self.read(one, part));
                            let $b = transmute::<$sums, $numbers>(self.read(other, part));
                            $pairs
                        };
                        self.write(&mut pairs, part, of_part);
                    }
                    pairs
                }

                #[inline(always)]
                fn add(self, sums: &mut [i32; LANES], shared: Pair, own: &[i32; LANES]) {
                    // SAFETY: as in `plus`, and both sides of a transmutation are plain numbers of the same size.
                    unsafe {
                        let shared = $same(transmute::<Pair, i32>(shared));
                        let own = transmute::<[i32; LANES], [$sums; Self::PARTS]>(*own);
                        let mut parts: [$sums; Self::PARTS] = transmute(*sums);
                        for (part, own) in parts.iter_mut().zip(own) {
                            *part = self.plus(*part, shared, own);
                        }
                        *sums = transmute::<[$sums; Self::PARTS], [i32; LANES]>(parts);
                    }
                }

                #[inline(always)]
                fn add_all<const N: usize>(
                    self,
                    sums: &mut [Sums; N],
                    shared: &[[Pair; N]],
                    own: &[Sums],
                ) {
                    const AT_ONCE: usize = $name::REGISTERS / $name::PARTS;
                    for first in (0..N).step_by(AT_ONCE) {
                        let sums = &mut sums[first..N.min(first + AT_ONCE)];
                        // SAFETY: as in `plus`.
                        let mut grown = [[unsafe { $same(0) }; Self::PARTS]; AT_ONCE];
                        for (grown, sums) in grown.iter_mut().zip(&*sums) {
                            for (part, grown) in grown.iter_mut().enumerate() {
                                *grown = self.read(sums, part);
                            }
                        }
                        for (shared, own) in shared.iter().zip(own) {
                            let shared = &shared[first..][..sums.len()];
                            for (grown, shared) in grown.iter_mut().zip(shared) {
                                // SAFETY: as in `add`.
                                let shared = unsafe { $same(transmute::<Pair, i32>(*shared)) };
                                for (part, grown) in grown.iter_mut().enumerate() {
                                    *grown = self.plus(*grown, shared, self.read(own, part));
                                }
                            }
                        }
                        for (sums, grown) in sums.iter_mut().zip(grown) {
                            for (part, grown) in grown.into_iter().enumerate() {
                                self.write(sums, part, grown);
                            }
                        }
                    }
                }
            }
        };
    }

    level!(
        Sse2,
        8,
        __m128i,
        _mm_set1_epi32,
        |s, a, b| _mm_add_epi32(s, _mm_madd_epi16(a, b)),
        __m128,
        |a, b| {
            let one = _mm_set1_ps(super::ONE);
            let low = _mm_and_si128(_mm_cvtps_epi32(_mm_mul_ps(a, one)), _mm_set1_epi32(0xFFFF));
            _mm_or_si128(low, _mm_slli_epi32::<16>(_mm_cvtps_epi32(_mm_mul_ps(b, one))))
        }
    );
    level!(
        Avx2,
        8,
        __m256i,
        _mm256_set1_epi32,
        |s, a, b| _mm256_add_epi32(s, _mm256_madd_epi16(a, b)),
        __m256,
        |a, b| {
            let one = _mm256_set1_ps(super::ONE);
            let low = _mm256_cvtps_epi32(_mm256_mul_ps(a, one));
            _mm256_blend_epi16::<0b1010_1010>(
                low,
                _mm256_slli_epi32::<16>(_mm256_cvtps_epi32(_mm256_mul_ps(b, one))),
            )
        }
    );
    level!(
        Avx512,
        16,
        __m512i,
        _mm512_set1_epi32,
        |s, a, b| _mm512_dpwssd_epi32(s, a, b),
        __m512,
        |a, b| {
            let one = _mm512_set1_ps(super::ONE);
            let low = _mm512_cvtps_epi32(_mm512_mul_ps(a, one));
            _mm512_ternarylogic_epi32::<0xF8>(
                _mm512_slli_epi32::<16>(_mm512_cvtps_epi32(_mm512_mul_ps(b, one))),
                low,
                _mm512_set1_epi32(0xFFFF),
            )
        }
    );
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kernels::level::{Level, at_every_level};

    at_every_level! {
        fn added[products](sums: &mut [i32; LANES], shared: &[Pair], own: &[[i32; LANES]]) {
            for (shared, own) in shared.iter().zip(own) {
                products.add(sums, *shared, own);
            }
        }

        fn all_added[products](sums: &mut [Sums; 8], shared: &[[Pair; 8]], own: &[Sums]) {
            products.add_all(sums, shared, own);
        }
    }

    fn noise(seed: usize) -> i16 {
        let mixed = (seed as u32 ^ (seed as u32 >> 7)).wrapping_mul(0x9E37_79B1);
        (mixed >> 16) as i16
    }

    /// The largest numbers too.
    fn extreme(i: usize) -> i16 {
        [i16::MIN, i16::MAX, noise(i)][i % 3]
    }

    fn half(seed: usize) -> i32 {
        i32::from(noise(seed)) / 2
    }

    #[test]
    fn sums_are_their_definition_at_every_level() {
        let shared: Vec<_> = (0..9).map(|i| [extreme(i), extreme(i + 1)]).collect();
        let own: Vec<[i32; LANES]> = (0..9)
            .map(|i| std::array::from_fn(|l| packed(half(90 * i + l), half(70 * i + l))))
            .collect();
        let mut expected = std::array::from_fn(|l| l as i32 - 7);
        for (shared, own) in shared.iter().zip(&own) {
            Plain.add(&mut expected, *shared, own);
        }
        for level in Level::available() {
            eprintln!("level {}", level.name());
            let mut sums = std::array::from_fn(|l| l as i32 - 7);
            added(level, &mut sums, &shared, &own);
            assert_eq!(sums, expected);
        }
    }

    #[test]
    fn sums_that_grow_together_are_their_definition_at_every_level() {
        let begin: [Sums; 8] =
            std::array::from_fn(|n| Line(std::array::from_fn(|l| (100 * n + l) as i32 - 7)));
        // None, one, and more pairs than there are registers.
        for pairs in [0, 1, 9, 40] {
            let shared: Vec<[Pair; 8]> = (0..pairs)
                .map(|i| std::array::from_fn(|n| [extreme(5 * i + n), noise(11 * i + n) / 4]))
                .collect();
            let lane = |i, l| packed(half(90 * i + l) / 8, half(70 * i + l) / 8);
            let own: Vec<Sums> =
                (0..pairs).map(|i| Line(std::array::from_fn(|l| lane(i, l)))).collect();
            let mut expected = begin;
            Plain.add_all(&mut expected, &shared, &own);
            for level in Level::available() {
                let mut sums = begin;
                all_added(level, &mut sums, &shared, &own);
                assert_eq!(sums, expected, "{pairs} pairs, level {}", level.name());
            }
        }
    }

    #[test]
    fn pairs_are_their_definition_at_every_level() {
        at_every_level! {
            fn pairs_of[products](numbers: &[Lanes; 2]) -> Sums {
                products.pairs(numbers)
            }
        }

        // Both signs, halves between two samples, and the largest.
        let number = |i: usize| [0.5, 1.5, 32_766.6, -0.5, -9.7, -32_767.4][i % 6] / ONE;
        let numbers = [0, 1].map(|i| Line(std::array::from_fn(|l| number(5 * i + l))));
        let expected = Plain.pairs(&numbers);
        assert_eq!(expected[..2], [packed(0, -32_767), packed(2, 0)]);
        for level in Level::available() {
            assert_eq!(pairs_of(level, &numbers), expected, "level {}", level.name());
        }
    }

    #[test]
    fn samples_are_rounded_and_the_largest_stand_for_all_beyond() {
        assert_eq!([0.0, 1.0, -0.5, 0.0011].map(sample), [0, 512, -256, 1]);
        assert_eq!([64.0, 1e9, f32::INFINITY].map(sample), [LARGEST; 3]);
        assert_eq!([-64.0, -1e9, f32::NEG_INFINITY].map(sample), [LEAST; 3]);
    }

    #[test]
    fn no_sum_overflows_whatever_the_samples() {
        for weight in [0.001, 0.9, 7.0, 33.0] {
            let (weights, offset) = (vec![weight; 288], 60.0);
            let weighing = Weighing::of([(weights.iter().copied(), offset)].into_iter());
            for extreme in [LEAST, LARGEST] {
                let products = 288 * i64::from(weighing.weight(weight)) * i64::from(extreme);
                let sum = products + i64::from(weighing.offset(offset));
                assert!(i32::try_from(sum).is_ok(), "{weight}: {sum}");
            }
            // A weight is off by less than a half and no more than a bit is given away.
            let off = weighing.weight(weight) as f32 * weighing.unit() * ONE - weight;
            assert!(off.abs() <= 0.5 * weighing.unit() * ONE);
        }
    }

    #[test]
    fn a_sum_becomes_a_sample() {
        let weighing = Weighing::of([([0.5, -0.25], 1.0)].into_iter());
        let [a, b] = [0.5, -0.25].map(|weight| weighing.weight(weight));
        let sum = weighing.offset(1.0) + a * sample(3.0) + b * sample(8.0);
        assert_eq!(weighing.sample(sum, 0), sample(0.5));
        let negative = weighing.part(-1.0) + weighing.offset(0.0) - a * sample(-1.0);
        assert_eq!(weighing.sample(negative, LEAST), sample(-0.5));
        assert_eq!(weighing.sample(-sum, 0), 0);
        assert!((weighing.unit() * sum as f32 - 0.5).abs() < 1e-3);
    }
}
