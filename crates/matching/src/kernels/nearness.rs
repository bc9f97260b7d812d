//! How near numbers of 16 bits lie to others, weighed: what the candidates of a pixel make of each other.
//!
//! ```text
//! near_l  = sum of w_li over all i with |a_l - b_li| < within
//! apart_l = sum of w_li min(|a_l - b_li|, most) over all i
//! ```
//!
//! for 16 lanes; [`Numbers`] hold two `b` and `w` for each. Of plain loops some builds write what is compared to
//! memory and read it back at once, and wait for that: votes took three times as long. So all of it is written out
//! per level, as [products](super::products) are.
//!
//! A kernel asks for it in brackets, see [`at_every_level!`](super::level::at_every_level).

use super::aligned::Line;
use super::products::{LANES, Numbers, Sums};

/// What compares numbers at one level. No two numbers differ by more than 16 bits with a sign hold.
pub(crate) trait Nearness: Copy {
    /// Of numbers in turns those of either kind, each in the places of both.
    #[inline(always)]
    fn of_each(self, pair: &Numbers) -> [Numbers; 2] {
        [0, 1].map(|kind| Line(std::array::from_fn(|i| pair[i & !1 | kind])))
    }

    /// Of each of several numbers: the weights of those that are nearer than `within`, by several kinds of weights.
    #[inline(always)]
    fn near<const N: usize, const KINDS: usize>(
        self,
        numbers: [&Numbers; N],
        within: i16,
        others: &[Numbers],
        weights: &[[Numbers; KINDS]],
    ) -> [[Sums; KINDS]; N] {
        numbers.map(|number| {
            let mut sums = [Line([0; LANES]); KINDS];
            for (other, weights) in others.iter().zip(weights) {
                let near = |i: usize| number[i].wrapping_sub(other[i]).wrapping_abs() < within;
                for (sums, weights) in sums.iter_mut().zip(weights) {
                    for i in 0..2 * LANES {
                        sums[i / 2] += if near(i) { i32::from(weights[i]) } else { 0 };
                    }
                }
            }
            sums
        })
    }

    /// Of each of several numbers: how far others lie from it, but at most so far, times their weights.
    #[inline(always)]
    fn apart<const N: usize>(
        self,
        numbers: [&Numbers; N],
        most: i16,
        others: &[Numbers],
        weights: &[Numbers],
    ) -> [Sums; N] {
        numbers.map(|number| {
            let mut sums = Line([0; LANES]);
            for (other, weights) in others.iter().zip(weights) {
                for i in 0..2 * LANES {
                    let off = number[i].wrapping_sub(other[i]).wrapping_abs().min(most);
                    sums[i / 2] += i32::from(weights[i]) * i32::from(off);
                }
            }
            sums
        })
    }
}

#[cfg(not(target_arch = "x86_64"))]
impl Nearness for super::products::Baseline {}

#[cfg(all(test, target_arch = "x86_64"))]
impl Nearness for super::products::Plain {}

#[cfg(target_arch = "x86_64")]
#[allow(unsafe_code)]
mod x86 {
    use std::arch::x86_64::*;

    use super::{LANES, Line, Nearness, Numbers, Sums};
    use crate::kernels::products::{Avx2, Avx512, Baseline};

    macro_rules! nearness {
        (
            $level:ident, $part:ident, $same:ident, $subtract:ident, $largest:ident, $least:ident,
            $shuffle_low:ident, $shuffle_high:ident,
            |$off:ident, $within:ident| $near:expr, |$sums:ident| $negated:expr
        ) => {
            impl $level {
                /// How far numbers lie from others.
                #[inline(always)]
                fn off(self, one: $part, other: $part) -> $part {
                    // SAFETY: whoever made `self` vouched for the instructions.
                    unsafe { $largest($subtract(one, other), $subtract(other, one)) }
                }
            }

            impl Nearness for $level {
                #[inline(always)]
                fn of_each(self, pair: &Numbers) -> [Numbers; 2] {
                    let mut each = [Line([0; 2 * LANES]); 2];
                    for part in 0..Self::PARTS {
                        let pair = self.read(pair, part);
                        // SAFETY: as in `off`.
                        let (one, other) = unsafe {
                            (
                                $shuffle_high::<0b10_10_00_00>($shuffle_low::<0b10_10_00_00>(pair)),
                                $shuffle_high::<0b11_11_01_01>($shuffle_low::<0b11_11_01_01>(pair)),
                            )
                        };
                        self.write(&mut each[0], part, one);
                        self.write(&mut each[1], part, other);
                    }
                    each
                }

                #[inline(always)]
                fn near<const N: usize, const KINDS: usize>(
                    self,
                    numbers: [&Numbers; N],
                    within: i16,
                    others: &[Numbers],
                    weights: &[[Numbers; KINDS]],
                ) -> [[Sums; KINDS]; N] {
                    let mut all = [[Line([0; LANES]); KINDS]; N];
                    // SAFETY: as in `off`.
                    let ($within, none) = unsafe { ($same(within), $same(0)) };
                    for part in 0..Self::PARTS {
                        let numbers = numbers.map(|numbers| self.read(numbers, part));
                        let mut sums = [[none; KINDS]; N];
                        for (other, weights) in others.iter().zip(weights) {
                            let other = self.read(other, part);
                            for (sums, &number) in sums.iter_mut().zip(&numbers) {
                                let $off = self.off(number, other);
                                // -1 where it is near, so what is added is negative.
                                // SAFETY: as in `off`.
                                let near = unsafe { $near };
                                for (sums, weights) in sums.iter_mut().zip(weights) {
                                    *sums = self.plus(*sums, near, self.read(weights, part));
                                }
                            }
                        }
                        for (all, sums) in all.iter_mut().zip(sums) {
                            for (all, $sums) in all.iter_mut().zip(sums) {
                                // SAFETY: as in `off`.
                                self.write(all, part, unsafe { $negated });
                            }
                        }
                    }
                    all
                }

                #[inline(always)]
                fn apart<const N: usize>(
                    self,
                    numbers: [&Numbers; N],
                    most: i16,
                    others: &[Numbers],
                    weights: &[Numbers],
                ) -> [Sums; N] {
                    let mut all = [Line([0; LANES]); N];
                    // SAFETY: as in `off`.
                    let (most, none) = unsafe { ($same(most), $same(0)) };
                    for part in 0..Self::PARTS {
                        let numbers = numbers.map(|numbers| self.read(numbers, part));
                        let mut sums = [none; N];
                        for (other, weights) in others.iter().zip(weights) {
                            let (other, weights) =
                                (self.read(other, part), self.read(weights, part));
                            for (sums, &number) in sums.iter_mut().zip(&numbers) {
                                // SAFETY: as in `off`.
                                let off = unsafe { $least(self.off(number, other), most) };
                                *sums = self.plus(*sums, off, weights);
                            }
                        }
                        for (all, sums) in all.iter_mut().zip(sums) {
                            self.write(all, part, sums);
                        }
                    }
                    all
                }
            }
        };
    }

    nearness!(
        Baseline,
        __m128i,
        _mm_set1_epi16,
        _mm_sub_epi16,
        _mm_max_epi16,
        _mm_min_epi16,
        _mm_shufflelo_epi16,
        _mm_shufflehi_epi16,
        |off, within| _mm_cmplt_epi16(off, within),
        |sums| _mm_sub_epi32(_mm_setzero_si128(), sums)
    );
    nearness!(
        Avx2,
        __m256i,
        _mm256_set1_epi16,
        _mm256_sub_epi16,
        _mm256_max_epi16,
        _mm256_min_epi16,
        _mm256_shufflelo_epi16,
        _mm256_shufflehi_epi16,
        |off, within| _mm256_cmpgt_epi16(within, off),
        |sums| _mm256_sub_epi32(_mm256_setzero_si256(), sums)
    );
    nearness!(
        Avx512,
        __m512i,
        _mm512_set1_epi16,
        _mm512_sub_epi16,
        _mm512_max_epi16,
        _mm512_min_epi16,
        _mm512_shufflelo_epi16,
        _mm512_shufflehi_epi16,
        |off, within| _mm512_movm_epi16(_mm512_cmplt_epi16_mask(off, within)),
        |sums| _mm512_sub_epi32(_mm512_setzero_si512(), sums)
    );
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::chance::Chance;
    use crate::kernels::level::{Level, at_every_level};
    use crate::kernels::products::Plain;

    at_every_level! {
        fn near_at[nearness](
            numbers: [&Numbers; 2],
            others: &[Numbers],
            weights: &[[Numbers; 3]],
        ) -> [[Sums; 3]; 2] {
            nearness.near(numbers, 64, others, weights)
        }

        fn of_each_at[nearness](pair: &Numbers) -> [Numbers; 2] {
            nearness.of_each(pair)
        }

        fn apart_at[nearness](
            numbers: [&Numbers; 2],
            others: &[Numbers],
            weights: &[Numbers],
        ) -> [Sums; 2] {
            nearness.apart(numbers, 192, others, weights)
        }
    }

    #[test]
    fn those_nearer_than_the_limit_count() {
        let all = |number| Line([number; 2 * LANES]);
        let others = [all(0), Line(std::array::from_fn(|i| if i % 2 == 0 { 63 } else { 64 }))];
        let weights = [[all(1)], [all(10)]];
        assert_eq!(Plain.near([&all(0)], 64, &others, &weights), [[Line([12; LANES])]]);
        assert_eq!(Plain.near([&all(100)], 64, &others, &weights), [[Line([20; LANES])]]);
        let weights = [all(1), all(10)];
        assert_eq!(Plain.apart([&all(64)], 50, &others, &weights), [Line([2 * 50 + 10; LANES])]);
    }

    #[test]
    fn numbers_in_turns_are_told_apart() {
        let pair = Line(std::array::from_fn(|i| i as i16));
        let each = [0, 1].map(|kind| Line(std::array::from_fn(|i| (i - i % 2 + kind) as i16)));
        assert_eq!(Plain.of_each(&pair), each);
        for level in Level::available() {
            assert_eq!(of_each_at(level, &pair), each, "level {}", level.name());
        }
    }

    #[test]
    fn every_level_says_what_the_definition_says() {
        let mut chance = Chance(8);
        for reach in [100, 16_383] {
            let mut numbers = |_| -> Numbers {
                Line(std::array::from_fn(|_| (2.0 * reach as f32 * (chance.share() - 0.5)) as i16))
            };
            let [one, two] = [0, 1].map(&mut numbers);
            let others: Vec<Numbers> = (0..7).map(&mut numbers).collect();
            let weights: Vec<[Numbers; 3]> = (0..7).map(|i| [i; 3].map(&mut numbers)).collect();
            let of_one: Vec<Numbers> = weights.iter().map(|weights| weights[0]).collect();
            let near = Plain.near([&one, &two], 64, &others, &weights);
            let apart = Plain.apart([&one, &two], 192, &others, &of_one);
            for level in Level::available() {
                eprintln!("level {}", level.name());
                assert_eq!(near_at(level, [&one, &two], &others, &weights), near);
                assert_eq!(apart_at(level, [&one, &two], &others, &of_one), apart);
            }
        }
    }
}
