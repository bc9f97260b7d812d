//! How many bits of words differ, weighed: what census words cost.
//!
//! ```text
//! c_i = floor(w H(a, b_i) / 64)
//! ```
//!
//! with the Hamming distance `H` of 32 bits. From AVX-512 on there is an instruction that counts bits, and a plain
//! loop becomes it. With AVX2 the compiler counts those of half bytes by a table, as everyone does, but then adds
//! the four bytes of a word up in a way that takes nearly as long as counting; here it is sums of products by ones.
//! What the plain loop makes of 32 words with AVX-512 takes longer to narrow numbers than to count bits: twice as many
//! are packed, and what so many bits cost is looked up.
//!
//! A kernel asks for it in brackets, see [`at_every_level!`](super::level::at_every_level).

/// Words that are compared together.
pub(crate) const LANES: usize = 32;

/// What a bit counts.
#[derive(Debug)]
pub(crate) struct Weight {
    /// In 64ths.
    pub each: u16,
    /// What so many bits count.
    #[cfg_attr(
        not(target_arch = "x86_64"),
        expect(dead_code, reason = "looked up from AVX-512 on")
    )]
    of_bits: [u8; 2 * LANES],
}

impl Weight {
    /// In 64ths, at most 510: what all bits count fits a byte.
    pub const fn new(each: u16) -> Self {
        let (mut of_bits, mut bits) = ([0; 2 * LANES], 0);
        while bits <= u32::BITS as usize {
            assert!(bits as u16 * each / 64 <= u8::MAX as u16, "too large a weight");
            of_bits[bits] = (bits as u16 * each / 64) as u8;
            bits += 1;
        }
        Self { each, of_bits }
    }
}

/// What compares words at one level.
pub(crate) trait Bits: Copy {
    /// What the bits count by which `word` differs from each of `words`.
    #[inline(always)]
    fn weighed(self, word: u32, words: &[u32; LANES], weight: &Weight) -> [u8; LANES] {
        // One loop per width of number, so that each fills its vectors.
        let (mut bits, mut weighed) = ([0u8; LANES], [0u8; LANES]);
        for i in 0..LANES {
            bits[i] = (word ^ words[i]).count_ones() as u8;
        }
        for i in 0..LANES {
            weighed[i] = (u16::from(bits[i]) * weight.each / 64) as u8;
        }
        weighed
    }

    /// The same of twice as many words.
    #[inline(always)]
    fn weighed_in_two(
        self,
        word: u32,
        words: &[[u32; LANES]; 2],
        weight: &Weight,
    ) -> [u8; 2 * LANES] {
        let [first, second] = words;
        let both = [self.weighed(word, first, weight), self.weighed(word, second, weight)];
        let mut weighed = [0; 2 * LANES];
        weighed.copy_from_slice(both.as_flattened());
        weighed
    }
}

#[cfg(target_arch = "x86_64")]
#[allow(unsafe_code)]
mod x86 {
    use std::arch::x86_64::*;
    use std::mem::transmute;

    use super::{Bits, LANES, Weight};
    use crate::kernels::products::{Avx2, Avx512, Baseline};

    impl Bits for Baseline {}

    impl Bits for Avx512 {
        #[inline(always)]
        fn weighed_in_two(
            self,
            word: u32,
            words: &[[u32; LANES]; 2],
            weight: &Weight,
        ) -> [u8; 2 * LANES] {
            // SAFETY: whoever made `self` vouched for the instructions, and both sides of a transmutation are
            // plain numbers of the same size.
            unsafe {
                let [a, b, c, d] = transmute::<[[u32; LANES]; 2], [__m512i; 4]>(*words);
                let word = _mm512_set1_epi32(word as i32);
                let ab = _mm512_packus_epi32(self.differing(word, a), self.differing(word, b));
                let cd = _mm512_packus_epi32(self.differing(word, c), self.differing(word, d));
                // Fours of a, b, c and d stand in each part of a lane.
                let bits = _mm512_packus_epi16(ab, cd);
                let order = _mm512_setr_epi32(0, 4, 8, 12, 1, 5, 9, 13, 2, 6, 10, 14, 3, 7, 11, 15);
                let bits = _mm512_permutexvar_epi32(order, bits);
                let of_bits = transmute::<[u8; 2 * LANES], __m512i>(weight.of_bits);
                transmute::<__m512i, [u8; 2 * LANES]>(_mm512_permutexvar_epi8(bits, of_bits))
            }
        }
    }

    impl Avx512 {
        /// How many bits differ in each of 16 words.
        #[inline(always)]
        fn differing(self, word: __m512i, words: __m512i) -> __m512i {
            // SAFETY: as above.
            unsafe { _mm512_popcnt_epi32(_mm512_xor_si512(word, words)) }
        }
    }

    impl Bits for Avx2 {
        #[inline(always)]
        fn weighed(self, word: u32, words: &[u32; LANES], weight: &Weight) -> [u8; LANES] {
            // SAFETY: whoever made `self` vouched for the instructions, and both sides of a transmutation are
            // plain numbers of the same size.
            unsafe {
                let [a, b, c, d] = transmute::<[u32; LANES], [__m256i; 4]>(*words);
                let word = _mm256_set1_epi32(word as i32);
                // Of each part of a lane: a and b, then c and d.
                let ab = _mm256_packus_epi16(self.of_halves(word, a), self.of_halves(word, b));
                let cd = _mm256_packus_epi16(self.of_halves(word, c), self.of_halves(word, d));
                let weight = _mm256_set1_epi16(weight.each as i16);
                let all = _mm256_packus_epi16(self.of_words(ab, weight), self.of_words(cd, weight));
                let order = _mm256_setr_epi32(0, 4, 1, 5, 2, 6, 3, 7);
                transmute::<__m256i, [u8; LANES]>(_mm256_permutevar8x32_epi32(all, order))
            }
        }
    }

    impl Avx2 {
        /// How many bits differ in each half of eight words.
        #[inline(always)]
        fn of_halves(self, word: __m256i, words: __m256i) -> __m256i {
            // SAFETY: as above.
            unsafe {
                let table = _mm256_broadcastsi128_si256(_mm_setr_epi8(
                    0, 1, 1, 2, 1, 2, 2, 3, 1, 2, 2, 3, 2, 3, 3, 4,
                ));
                let half_byte = _mm256_set1_epi8(15);
                let differing = _mm256_xor_si256(word, words);
                let low = _mm256_and_si256(differing, half_byte);
                let high = _mm256_and_si256(_mm256_srli_epi16::<4>(differing), half_byte);
                let low = _mm256_shuffle_epi8(table, low);
                let bits = _mm256_add_epi8(low, _mm256_shuffle_epi8(table, high));
                _mm256_maddubs_epi16(bits, _mm256_set1_epi8(1))
            }
        }

        /// What comes of the words whose halves these are.
        #[inline(always)]
        fn of_words(self, halves: __m256i, weight: __m256i) -> __m256i {
            // SAFETY: as above.
            unsafe {
                let bits = _mm256_maddubs_epi16(halves, _mm256_set1_epi8(1));
                _mm256_srli_epi16::<6>(_mm256_mullo_epi16(bits, weight))
            }
        }
    }
}

#[cfg(not(target_arch = "x86_64"))]
impl Bits for super::products::Baseline {}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::chance::Chance;
    use crate::kernels::level::{Level, at_every_level};

    at_every_level! {
        fn weigh[bits](word: u32, words: &[u32; LANES], weight: &Weight) -> [u8; LANES] {
            bits.weighed(word, words, weight)
        }

        fn weigh_in_two[bits](word: u32, words: &[[u32; LANES]; 2], weight: &Weight) -> [u8; 2 * LANES] {
            bits.weighed_in_two(word, words, weight)
        }
    }

    #[test]
    fn weighed_bits_are_their_definition_at_every_level() {
        let mut chance = Chance(7);
        let mut word = || chance.below(1 << 16) << 16 | chance.below(1 << 16);
        for each in [0, 1, 75, 200, 510] {
            let weight = Weight::new(each);
            for extreme in [[0; 2], [0, u32::MAX], [word(), word()]] {
                let mut words = [[(); LANES]; 2].map(|half| half.map(|()| word()));
                words[0][3] = extreme[0];
                let differing =
                    |other: u32| (0..32).filter(move |b| (extreme[1] ^ other) >> b & 1 == 1);
                let expected = words.map(|half| {
                    half.map(|w| (differing(w).count() * usize::from(each) / 64) as u8)
                });
                for level in Level::available() {
                    eprintln!("level {}", level.name());
                    let found = words.map(|half| weigh(level, extreme[1], &half, &weight));
                    assert_eq!(found, expected);
                    let found = weigh_in_two(level, extreme[1], &words, &weight);
                    assert_eq!(found, expected.as_flattened());
                }
            }
        }
    }
}
