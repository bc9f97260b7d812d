//! Layers of small networks: sums of products, and the numbers or the score that become of them.
//!
//! ```text
//! s_tl      = b_tl + sum of (w_it0 f_il0 + w_it1 f_il1) over all pairs i
//! number_tl = (s_tl + o_t) >> fraction, from 0 to the largest sample
//! score_l  += sum of v_t max(0, s_tl + o_t) over t
//! ```
//!
//! for 16 lanes and [`TOGETHER`] neurons, of one kind of inputs or of several that share weights. Sums stay in registers
//! from the first product to the number that they become: written to memory in between, with AVX2 judges took
//! as long again.
//!
//! How many sums grow at once depends on the registers of a level. Where they are few, a weight that is read once serves
//! all parts of the lanes.
//!
//! A kernel asks for it in brackets, see [`at_every_level!`](super::level::at_every_level).

use super::aligned::Line;
use super::products::{LANES, Lanes, Pair, Sums, Weighing, packed};

/// Neurons of a layer that are worked on together.
pub(crate) const TOGETHER: usize = 8;

/// The numbers of as many neurons, [`packed`] two by two.
pub(crate) type OfNeurons = [Sums; TOGETHER / 2];

/// What works layers out at one level.
pub(crate) trait Neurons: Copy {
    /// The numbers of some neurons, of several kinds of inputs: sums of all kinds begin alike, offsets differ.
    #[inline(always)]
    fn layer<const KINDS: usize>(
        self,
        begin: &[Sums; TOGETHER],
        weights: &[[Pair; TOGETHER]],
        from: [&[Sums]; KINDS],
        offsets: [&[i32; TOGETHER]; KINDS],
        weighing: Weighing,
        numbers: [&mut OfNeurons; KINDS],
    ) {
        for ((from, offsets), numbers) in from.into_iter().zip(offsets).zip(numbers) {
            let sums = grown(*begin, weights, from);
            for (i, numbers) in numbers.iter_mut().enumerate() {
                for l in 0..LANES {
                    let one = weighing.sample(sums[2 * i][l] + offsets[2 * i], 0);
                    let other = weighing.sample(sums[2 * i + 1][l] + offsets[2 * i + 1], 0);
                    numbers[l] = packed(one, other);
                }
            }
        }
    }

    /// Adds to scores of several kinds of inputs what some neurons say.
    #[inline(always)]
    fn score<const KINDS: usize>(
        self,
        scores: &mut [Lanes; KINDS],
        weights: &[[Pair; TOGETHER]],
        from: [&[Sums]; KINDS],
        offsets: &[i32; TOGETHER],
        shares: &[f32; TOGETHER],
    ) {
        for (scores, from) in scores.iter_mut().zip(from) {
            let sums = grown([Line([0; LANES]); TOGETHER], weights, from);
            for t in 0..TOGETHER {
                for l in 0..LANES {
                    let sum = sums[t][l] + offsets[t];
                    let positive = if sum > 0 { sum } else { 0 };
                    scores[l] += shares[t] * positive as f32;
                }
            }
        }
    }
}

/// Sums to which all products are added.
#[inline(always)]
fn grown(
    mut sums: [Sums; TOGETHER],
    weights: &[[Pair; TOGETHER]],
    from: &[Sums],
) -> [Sums; TOGETHER] {
    for (weights, from) in weights.iter().zip(from) {
        for (sums, &[one, other]) in sums.iter_mut().zip(weights) {
            for l in 0..LANES {
                sums[l] +=
                    i32::from(one) * i32::from(from[l] as i16) + i32::from(other) * (from[l] >> 16);
            }
        }
    }
    sums
}

#[cfg(not(target_arch = "x86_64"))]
impl Neurons for super::products::Baseline {}

#[cfg(all(test, target_arch = "x86_64"))]
impl Neurons for super::products::Plain {}

#[cfg(target_arch = "x86_64")]
#[allow(unsafe_code)]
mod x86 {
    use std::arch::x86_64::*;
    use std::mem::transmute;

    use super::{Lanes, Neurons, OfNeurons, Pair, Sums, TOGETHER, Weighing};
    use crate::kernels::products::{Avx2, Avx512, Baseline};

    macro_rules! neurons {
        (
            $level:ident, $part:ident, $floats:ident,
            $zero:ident, $same:ident, $same_float:ident, $add:ident, $shift:ident, $narrow:ident, $largest_16:ident,
            $high_64:ident, $low_16:ident, $to_floats:ident, $multiply:ident, $add_floats:ident,
            |$sum:ident| $positive:expr
        ) => {
            impl $level {
                /// So many neurons grow at once.
                const AT_ONCE: usize = if TOGETHER * Self::PARTS <= Self::REGISTERS {
                    TOGETHER
                } else {
                    Self::REGISTERS / Self::PARTS
                };

                /// Whether there are registers for two kinds of them.
                const TWO_KINDS: bool = 2 * Self::AT_ONCE * Self::PARTS <= Self::REGISTERS;

                /// Adds all products to the sums of neurons from `first` on.
                #[inline(always)]
                fn grow<const KINDS: usize>(
                    self,
                    sums: &mut [[[$part; Self::PARTS]; Self::AT_ONCE]; KINDS],
                    first: usize,
                    weights: &[[Pair; TOGETHER]],
                    from: [&[Sums]; KINDS],
                ) {
                    let pairs = weights.len();
                    let from = from.map(|from| &from[..pairs]);
                    // By indices, of which the compiler sees that all are there.
                    for i in 0..pairs {
                        // SAFETY: whoever made `self` vouched for the instructions.
                        let mut own = [[unsafe { $zero() }; Self::PARTS]; KINDS];
                        for kind in 0..KINDS {
                            for part in 0..Self::PARTS {
                                own[kind][part] = self.read(&from[kind][i], part);
                            }
                        }
                        for n in 0..Self::AT_ONCE {
                            let weight = weights[i][first + n];
                            // SAFETY: as above, and both sides of a transmutation are plain numbers of the same size.
                            let weight = unsafe { $same(transmute::<Pair, i32>(weight)) };
                            for kind in 0..KINDS {
                                for part in 0..Self::PARTS {
                                    let sum = &mut sums[kind][n][part];
                                    *sum = self.plus(*sum, weight, own[kind][part]);
                                }
                            }
                        }
                    }
                }

                #[inline(always)]
                fn layer_of<const KINDS: usize>(
                    self,
                    begin: &[Sums; TOGETHER],
                    weights: &[[Pair; TOGETHER]],
                    from: [&[Sums]; KINDS],
                    offsets: [&[i32; TOGETHER]; KINDS],
                    weighing: Weighing,
                    numbers: [&mut OfNeurons; KINDS],
                ) {
                    // SAFETY: as in `grow`.
                    let none = unsafe { $zero() };
                    let fraction = unsafe { _mm_cvtsi32_si128(weighing.fraction() as i32) };
                    for first in (0..TOGETHER).step_by(Self::AT_ONCE) {
                        let mut sums = [[[none; Self::PARTS]; Self::AT_ONCE]; KINDS];
                        for kind in 0..KINDS {
                            for n in 0..Self::AT_ONCE {
                                for part in 0..Self::PARTS {
                                    sums[kind][n][part] = self.read(&begin[first + n], part);
                                }
                            }
                        }
                        self.grow(&mut sums, first, weights, from);
                        for kind in 0..KINDS {
                            for pair in 0..Self::AT_ONCE / 2 {
                                let at = first + 2 * pair;
                                for part in 0..Self::PARTS {
                                    let one = sums[kind][2 * pair][part];
                                    let other = sums[kind][2 * pair + 1][part];
                                    // Narrowing bounds to what samples can be.
                                    // SAFETY: as in `grow`.
                                    let both = unsafe {
                                        let of_one = $same(offsets[kind][at]);
                                        let of_other = $same(offsets[kind][at + 1]);
                                        let one = $shift($add(one, of_one), fraction);
                                        let other = $shift($add(other, of_other), fraction);
                                        let both = $largest_16($narrow(one, other), none);
                                        $low_16(both, $high_64(both, both))
                                    };
                                    self.write(&mut numbers[kind][at / 2], part, both);
                                }
                            }
                        }
                    }
                }

                #[inline(always)]
                fn score_of<const KINDS: usize>(
                    self,
                    scores: [&mut Lanes; KINDS],
                    weights: &[[Pair; TOGETHER]],
                    from: [&[Sums]; KINDS],
                    offsets: &[i32; TOGETHER],
                    shares: &[f32; TOGETHER],
                ) {
                    // SAFETY: as in `grow`.
                    let none = unsafe { $zero() };
                    for first in (0..TOGETHER).step_by(Self::AT_ONCE) {
                        let mut sums = [[[none; Self::PARTS]; Self::AT_ONCE]; KINDS];
                        self.grow(&mut sums, first, weights, from);
                        for kind in 0..KINDS {
                            for part in 0..Self::PARTS {
                                // SAFETY: as in `grow`.
                                unsafe {
                                    let score = self.read(scores[kind], part);
                                    let mut score = transmute::<$part, $floats>(score);
                                    for n in 0..Self::AT_ONCE {
                                        let $sum =
                                            $add(sums[kind][n][part], $same(offsets[first + n]));
                                        let share = $same_float(shares[first + n]);
                                        score = $add_floats(
                                            score,
                                            $multiply(share, $to_floats($positive)),
                                        );
                                    }
                                    self.write(
                                        scores[kind],
                                        part,
                                        transmute::<$floats, $part>(score),
                                    );
                                }
                            }
                        }
                    }
                }
            }

            impl Neurons for $level {
                #[inline(always)]
                fn layer<const KINDS: usize>(
                    self,
                    begin: &[Sums; TOGETHER],
                    weights: &[[Pair; TOGETHER]],
                    from: [&[Sums]; KINDS],
                    offsets: [&[i32; TOGETHER]; KINDS],
                    weighing: Weighing,
                    numbers: [&mut OfNeurons; KINDS],
                ) {
                    if Self::TWO_KINDS {
                        self.layer_of(begin, weights, from, offsets, weighing, numbers);
                    } else {
                        for kind in 0..KINDS {
                            let (from, offsets) = ([from[kind]], [offsets[kind]]);
                            let numbers = [&mut *numbers[kind]];
                            self.layer_of(begin, weights, from, offsets, weighing, numbers);
                        }
                    }
                }

                #[inline(always)]
                fn score<const KINDS: usize>(
                    self,
                    scores: &mut [Lanes; KINDS],
                    weights: &[[Pair; TOGETHER]],
                    from: [&[Sums]; KINDS],
                    offsets: &[i32; TOGETHER],
                    shares: &[f32; TOGETHER],
                ) {
                    if Self::TWO_KINDS {
                        self.score_of(scores.each_mut(), weights, from, offsets, shares);
                    } else {
                        for kind in 0..KINDS {
                            let scores = [&mut scores[kind]];
                            self.score_of(scores, weights, [from[kind]], offsets, shares);
                        }
                    }
                }
            }
        };
    }

    neurons!(
        Baseline,
        __m128i,
        __m128,
        _mm_setzero_si128,
        _mm_set1_epi32,
        _mm_set1_ps,
        _mm_add_epi32,
        _mm_sra_epi32,
        _mm_packs_epi32,
        _mm_max_epi16,
        _mm_unpackhi_epi64,
        _mm_unpacklo_epi16,
        _mm_cvtepi32_ps,
        _mm_mul_ps,
        _mm_add_ps,
        |sum| _mm_and_si128(sum, _mm_cmpgt_epi32(sum, _mm_setzero_si128()))
    );
    neurons!(
        Avx2,
        __m256i,
        __m256,
        _mm256_setzero_si256,
        _mm256_set1_epi32,
        _mm256_set1_ps,
        _mm256_add_epi32,
        _mm256_sra_epi32,
        _mm256_packs_epi32,
        _mm256_max_epi16,
        _mm256_unpackhi_epi64,
        _mm256_unpacklo_epi16,
        _mm256_cvtepi32_ps,
        _mm256_mul_ps,
        _mm256_add_ps,
        |sum| _mm256_max_epi32(sum, _mm256_setzero_si256())
    );
    neurons!(
        Avx512,
        __m512i,
        __m512,
        _mm512_setzero_si512,
        _mm512_set1_epi32,
        _mm512_set1_ps,
        _mm512_add_epi32,
        _mm512_sra_epi32,
        _mm512_packs_epi32,
        _mm512_max_epi16,
        _mm512_unpackhi_epi64,
        _mm512_unpacklo_epi16,
        _mm512_cvtepi32_ps,
        _mm512_mul_ps,
        _mm512_add_ps,
        |sum| _mm512_max_epi32(sum, _mm512_setzero_si512())
    );
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::chance::Chance;
    use crate::kernels::level::{Level, at_every_level};
    use crate::kernels::products::{LEAST, Plain};

    /// What two kinds of inputs, and what one alone come to: numbers, and the bits of scores.
    type Worked = ([OfNeurons; 2], [[u32; LANES]; 2], OfNeurons, [u32; LANES]);

    at_every_level! {
        fn worked[neurons](
            begin: &[Sums; TOGETHER],
            weights: &[[Pair; TOGETHER]],
            from: [&[Sums]; 2],
            offsets: [&[i32; TOGETHER]; 2],
            ends: (Weighing, &[f32; TOGETHER]),
        ) -> Worked {
            by(neurons, begin, weights, from, offsets, ends)
        }
    }

    #[inline(always)]
    fn by(
        neurons: impl Neurons,
        begin: &[Sums; TOGETHER],
        weights: &[[Pair; TOGETHER]],
        from: [&[Sums]; 2],
        offsets: [&[i32; TOGETHER]; 2],
        (weighing, shares): (Weighing, &[f32; TOGETHER]),
    ) -> Worked {
        let nothing = [Line([0; LANES]); TOGETHER / 2];
        let (mut both, mut one) = ([nothing; 2], nothing);
        neurons.layer(begin, weights, from, offsets, weighing, both.each_mut());
        neurons.layer(begin, weights, [from[1]], [offsets[1]], weighing, [&mut one]);
        // Others were there before.
        let mut scores = [0, 1].map(|kind| Line(std::array::from_fn(|l| (l + kind) as f32)));
        let mut score = [scores[1]];
        neurons.score(&mut scores, weights, from, offsets[0], shares);
        neurons.score(&mut score, weights, [from[1]], offsets[0], shares);
        let bits = |scores: &Lanes| scores.map(f32::to_bits);
        (both, scores.each_ref().map(bits), one, bits(&score[0]))
    }

    #[test]
    fn a_case_worked_by_hand() {
        // Weights of a half and a quarter, that begin at 1: 2 / 2 + 8 / 4 + 1, and 5 less in the second kind: less than 0.
        let weighing = Weighing::of([([0.5, 0.25], 1.0)].into_iter());
        let weights = [[[0.5, 0.25].map(|weight| weighing.weight(weight) as i16); TOGETHER]];
        let from = [Line([packed(2 << 9, 8 << 9); LANES])];
        let begin = [Line([weighing.part(1.0); LANES]); TOGETHER];
        let offsets = [0.0, -5.0].map(|offset| [weighing.offset(offset); TOGETHER]);
        let mut numbers = [[Line([7; LANES]); TOGETHER / 2]; 2];
        let both = [&offsets[0], &offsets[1]];
        Plain.layer(&begin, &weights, [&from; 2], both, weighing, numbers.each_mut());
        assert_eq!(numbers[0], [Line([packed(4 << 9, 4 << 9); LANES]); TOGETHER / 2]);
        assert_eq!(numbers[1], [Line([0; LANES]); TOGETHER / 2]);
        let mut scores = [Line([10.0; LANES])];
        let shares = std::array::from_fn(|t| t as f32 * weighing.unit());
        Plain.score(&mut scores, &weights, [&from], &[0; TOGETHER], &shares);
        assert_eq!(scores, [Line([10.0 + 3.0 * 28.0; LANES])]);
    }

    #[test]
    fn every_level_says_what_the_definition_says() {
        let mut chance = Chance(6);
        let mut number = |most: i32| (2.0 * most as f32 * (chance.share() - 0.5)) as i32;
        // No pair, as many as judges have, and more than there are registers.
        for pairs in [0, 1, 8, 10, 50] {
            let weights: Vec<[Pair; TOGETHER]> = (0..pairs)
                .map(|_| std::array::from_fn(|_| [0; 2].map(|_: i32| number(300) as i16)))
                .collect();
            let [one, other] = [0; 2].map(|_: i32| -> Vec<Sums> {
                let mut lane = |_| packed(number(-LEAST), number(-LEAST));
                (0..pairs).map(|_| Line(std::array::from_fn(&mut lane))).collect()
            });
            let begin = std::array::from_fn(|_| Line(std::array::from_fn(|_| number(1 << 26))));
            let offsets = [0; 2].map(|_: i32| std::array::from_fn(|_| number(1 << 24)));
            let shares = std::array::from_fn(|_| number(1000) as f32 / 7e4);
            let weighing = Weighing::of([([20.0], 1.0)].into_iter());
            let end = (weighing, &shares);
            let (from, offsets) = ([&one[..], &other], [&offsets[0], &offsets[1]]);
            let expected = by(Plain, &begin, &weights, from, offsets, end);
            let largest = packed(i32::from(i16::MAX), i32::from(i16::MAX)) as u32;
            let numbers = || expected.0.iter().flatten().flat_map(|numbers| numbers.iter());
            let is_half = |half: u32| numbers().any(|&both| both as u32 & 0xFFFF == half);
            assert!(is_half(0) && is_half(largest & 0xFFFF), "both bounds are reached");
            for level in Level::available() {
                let found = worked(level, &begin, &weights, from, offsets, end);
                assert_eq!(found, expected, "{pairs} pairs, level {}", level.name());
            }
        }
    }
}
