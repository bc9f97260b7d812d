//! How unlike words of 64 bits are: by how many bits they differ, and by how much their bytes do.
//!
//! ```text
//! bits_l  = number of ones in (a_l ^ b_l) & mask
//! bytes_l = sum of min(|a_li - b_li|, most) over the bytes i of the mask
//! ```
//!
//! for 16 words. Loops narrow numbers of 64 bits one by one, or write their halves to memory and wait for both. Here
//! they stay in registers.
//!
//! A kernel asks for it in brackets, see [`at_every_level!`](super::level::at_every_level).

use super::aligned::Line;
use super::products::{LANES, Sums};

/// Words that are compared with others.
pub(crate) type Words = Line<[u64; LANES]>;

/// What compares words at one level.
pub(crate) trait Unlike: Copy {
    /// The bits by which words differ from others, of those in a mask.
    #[inline(always)]
    fn bits(self, words: &Words, others: &Words, mask: u64) -> Sums {
        let mut bits = Line([0; LANES]);
        for l in 0..LANES {
            bits[l] = ((words[l] ^ others[l]) & mask).count_ones() as i32;
        }
        bits
    }

    /// By how much the bytes of words differ from those of others, each by no more than so much, of those in a mask.
    #[inline(always)]
    fn bytes(self, words: &Words, others: &Words, most: u8, mask: u64) -> Sums {
        let mut sums = Line([0; LANES]);
        for l in 0..LANES {
            let [ours, theirs, mask] = [words[l], others[l], mask].map(u64::to_le_bytes);
            for i in 0..8 {
                sums[l] += i32::from(ours[i].abs_diff(theirs[i]).min(most) & mask[i]);
            }
        }
        sums
    }
}

#[cfg(not(target_arch = "x86_64"))]
impl Unlike for super::products::Baseline {}

#[cfg(all(test, target_arch = "x86_64"))]
impl Unlike for super::products::Plain {}

#[cfg(target_arch = "x86_64")]
#[allow(unsafe_code)]
mod x86 {
    use std::arch::x86_64::*;

    use super::{LANES, Line, Sums, Unlike, Words};
    use crate::kernels::products::{Avx2, Avx512, Baseline};

    /// Sums of bytes are one instruction everywhere, and what they come to fits the lower half of a word.
    macro_rules! bytes {
        (
            $part:ident, $same:ident, $same_byte:ident, $largest:ident, $least:ident, $subtract:ident, $and:ident,
            $sum:ident, $zero:ident, |$this:ident, $sums:ident| $narrow:expr
        ) => {
            #[inline(always)]
            fn bytes(self, words: &Words, others: &Words, most: u8, mask: u64) -> Sums {
                const PARTS: usize = size_of::<Words>() / size_of::<$part>();
                let mut sums = Line([0u64; LANES]);
                // SAFETY: whoever made `self` vouched for the instructions; all parts lie within the words, and lines
                // begin where any vector may.
                unsafe {
                    let (most, mask) = ($same_byte(most as i8), $same(mask as i64));
                    let ours = words.as_ptr().cast::<$part>();
                    let theirs = others.as_ptr().cast::<$part>();
                    for part in 0..PARTS {
                        let (one, other) = (ours.add(part).read(), theirs.add(part).read());
                        let off = $subtract($largest(one, other), $least(one, other));
                        let off = $and($least(off, most), mask);
                        sums.as_mut_ptr().cast::<$part>().add(part).write($sum(off, $zero()));
                    }
                }
                let ($this, $sums) = (self, &sums);
                $narrow
            }
        };
    }

    impl Unlike for Baseline {
        bytes!(
            __m128i,
            _mm_set1_epi64x,
            _mm_set1_epi8,
            _mm_max_epu8,
            _mm_min_epu8,
            _mm_sub_epi8,
            _mm_and_si128,
            _mm_sad_epu8,
            _mm_setzero_si128,
            |_this, sums| lower_halves(sums)
        );
    }

    impl Unlike for Avx2 {
        #[inline(always)]
        fn bits(self, words: &Words, others: &Words, mask: u64) -> Sums {
            let mut bits = Line([0u64; LANES]);
            // SAFETY: whoever made `self` vouched for the instructions; words are four such vectors, and lines begin
            // where any vector may.
            unsafe {
                let of_half = _mm_setr_epi8(0, 1, 1, 2, 1, 2, 2, 3, 1, 2, 2, 3, 2, 3, 3, 4);
                let of_half = _mm256_broadcastsi128_si256(of_half);
                let half = _mm256_set1_epi8(0xF);
                let mask = _mm256_set1_epi64x(mask as i64);
                let ours = words.as_ptr().cast::<__m256i>();
                let theirs = others.as_ptr().cast::<__m256i>();
                for part in 0..4 {
                    let differ = _mm256_xor_si256(ours.add(part).read(), theirs.add(part).read());
                    let differ = _mm256_and_si256(differ, mask);
                    let low = _mm256_and_si256(differ, half);
                    let high = _mm256_and_si256(_mm256_srli_epi16::<4>(differ), half);
                    let [low, high] =
                        [_mm256_shuffle_epi8(of_half, low), _mm256_shuffle_epi8(of_half, high)];
                    let of_word =
                        _mm256_sad_epu8(_mm256_add_epi8(low, high), _mm256_setzero_si256());
                    bits.as_mut_ptr().cast::<__m256i>().add(part).write(of_word);
                }
            }
            self.narrow(&bits)
        }

        bytes!(
            __m256i,
            _mm256_set1_epi64x,
            _mm256_set1_epi8,
            _mm256_max_epu8,
            _mm256_min_epu8,
            _mm256_sub_epi8,
            _mm256_and_si256,
            _mm256_sad_epu8,
            _mm256_setzero_si256,
            |this, sums| this.narrow(sums)
        );
    }

    impl Unlike for Avx512 {
        #[inline(always)]
        fn bits(self, words: &Words, others: &Words, mask: u64) -> Sums {
            let mut bits = Line([0u64; LANES]);
            // SAFETY: whoever made `self` vouched for the instructions; words are two such vectors, and lines begin
            // where any vector may.
            unsafe {
                let mask = _mm512_set1_epi64(mask as i64);
                let ours = words.as_ptr().cast::<__m512i>();
                let theirs = others.as_ptr().cast::<__m512i>();
                for part in 0..2 {
                    let differ = _mm512_xor_si512(ours.add(part).read(), theirs.add(part).read());
                    let bits_of = _mm512_popcnt_epi64(_mm512_and_si512(differ, mask));
                    bits.as_mut_ptr().cast::<__m512i>().add(part).write(bits_of);
                }
            }
            self.narrow(&bits)
        }

        bytes!(
            __m512i,
            _mm512_set1_epi64,
            _mm512_set1_epi8,
            _mm512_max_epu8,
            _mm512_min_epu8,
            _mm512_sub_epi8,
            _mm512_and_si512,
            _mm512_sad_epu8,
            _mm512_setzero_si512,
            |this, sums| this.narrow(sums)
        );
    }

    impl Avx2 {
        /// The lower halves of words.
        #[inline(always)]
        fn narrow(self, words: &Words) -> Sums {
            let mut narrow = Line([0; LANES]);
            for part in 0..2 {
                // SAFETY: whoever made `self` vouched for the instructions; words are four such vectors, and lines
                // begin where any vector may.
                let even = unsafe {
                    let words = words.as_ptr().cast::<__m256>().add(2 * part);
                    let even =
                        _mm256_shuffle_ps::<0b10_00_10_00>(words.read(), words.add(1).read());
                    _mm256_permute4x64_epi64::<0b11_01_10_00>(_mm256_castps_si256(even))
                };
                self.write(&mut narrow, part, even);
            }
            narrow
        }
    }

    impl Avx512 {
        /// The lower halves of words.
        #[inline(always)]
        fn narrow(self, words: &Words) -> Sums {
            let mut narrow = Line([0; LANES]);
            // SAFETY: whoever made `self` vouched for the instructions; words are two such vectors, and lines begin
            // where any vector may.
            let even = unsafe {
                let words = words.as_ptr().cast::<__m512i>();
                let even =
                    _mm512_setr_epi32(0, 2, 4, 6, 8, 10, 12, 14, 16, 18, 20, 22, 24, 26, 28, 30);
                _mm512_permutex2var_epi32(words.read(), even, words.add(1).read())
            };
            self.write(&mut narrow, 0, even);
            narrow
        }
    }

    /// The lower halves of words.
    #[inline(always)]
    fn lower_halves(words: &Words) -> Sums {
        let mut narrow = Line([0; LANES]);
        for l in 0..LANES {
            narrow[l] = words[l] as i32;
        }
        narrow
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::chance::Chance;
    use crate::kernels::level::{Level, at_every_level};
    use crate::kernels::products::Plain;

    at_every_level! {
        fn unlike[products](words: [&Words; 2], most: u8, mask: u64) -> [Sums; 2] {
            let [words, others] = words;
            [products.bits(words, others, mask), products.bytes(words, others, most, mask)]
        }
    }

    #[test]
    fn a_case_worked_by_hand() {
        let all = |word| Line([word; LANES]);
        let (words, others) = (all(0x1_10ff), all(0x1_30fe));
        assert_eq!(*Plain.bits(&words, &others, u64::MAX), [2; LANES]);
        assert_eq!(*Plain.bytes(&words, &others, 255, u64::MAX), [33; LANES]);
        assert_eq!(*Plain.bytes(&words, &others, 20, u64::MAX), [21; LANES]);
        assert_eq!(*Plain.bytes(&words, &others, 20, 0xff), [1; LANES]);
    }

    #[test]
    fn words_are_as_unlike_at_every_level() {
        let mut chance = Chance(7);
        let mut words = || -> Words {
            Line(
                [0; LANES]
                    .map(|_: u64| u64::from(chance.bits(32)) << 32 | u64::from(chance.bits(32))),
            )
        };
        let (mut words, others) = (words(), words());
        words[4] = others[4];
        words[5] = !others[5];
        for (most, mask) in [(255, u64::MAX), (20, 0xffff_ffff_ff00), (0, 0xff), (7, 0)] {
            let expected =
                [Plain.bits(&words, &others, mask), Plain.bytes(&words, &others, most, mask)];
            for level in Level::available() {
                eprintln!("level {}", level.name());
                assert_eq!(unlike(level, [&words, &others], most, mask), expected);
            }
        }
    }
}
